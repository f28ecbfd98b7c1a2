// SPDX-License-Identifier: Apache-2.0
#include "tests/cli/program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

namespace photic::test {

namespace fs = std::filesystem;

namespace {

std::string readAll(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace

Workplace::Workplace() {
    std::string pattern = (fs::temp_directory_path() / "photic_cli_XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary directory");
    path_ = pattern;
}

Workplace::~Workplace() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

void Workplace::write(const std::string& name, const std::string& bytes) const {
    std::ofstream file(path_ / name, std::ios::binary);
    file << bytes;
}

std::string Workplace::read(const std::string& name) const { return readAll(path_ / name); }

std::vector<std::string> Workplace::names() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(path_)) {
        const std::string name = entry.path().filename().string();
        if (name != ".out" && name != ".err") names.push_back(name);
    }
    std::sort(names.begin(), names.end());
    return names;
}

std::vector<nlohmann::json> Outcome::events() const {
    std::vector<nlohmann::json> events;
    std::istringstream lines(err);
    for (std::string line; std::getline(lines, line);) events.push_back(nlohmann::json::parse(line));
    return events;
}

Program::Program(const Workplace& place, const std::vector<std::string>& arguments, std::int64_t file_size_limit)
    : place_(place), out_(place / ".out"), err_(place / ".err") {
    pid_ = fork();
    if (pid_ < 0) throw std::runtime_error("fork failed");
    if (pid_ > 0) return;
    // The child: only calls that are safe between fork and exec, besides the vector of arguments.
    std::vector<char*> argv{const_cast<char*>(PHOTIC_PROGRAM)};
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    const int out = open(out_.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600),
              err = open(err_.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600);
    dup2(out, STDOUT_FILENO);
    dup2(err, STDERR_FILENO);
    if (chdir(place_.path().c_str()) != 0) _exit(99);
    if (file_size_limit > 0) {
        const rlimit limit{static_cast<rlim_t>(file_size_limit), static_cast<rlim_t>(file_size_limit)};
        if (setrlimit(RLIMIT_FSIZE, &limit) != 0) _exit(98);
    }
    execv(PHOTIC_PROGRAM, argv.data());
    _exit(97);
}

std::string Program::errSoFar() const { return readAll(err_); }

Outcome Program::wait() {
    int status = 0;
    rusage usage{};
    while (wait4(pid_, &status, 0, &usage) < 0 && errno == EINTR) {
    }
    Outcome outcome;
    outcome.most_bytes = usage.ru_maxrss * std::int64_t{1024};
    outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
    outcome.out = readAll(out_);
    outcome.err = readAll(err_);
    return outcome;
}

Outcome photic(const Workplace& place, const std::vector<std::string>& arguments, std::int64_t file_size_limit) {
    return Program(place, arguments, file_size_limit).wait();
}

std::string PoolText::text() const {
    return fmt::format(R"(photic = 1
[domain]
min = [-1.0, -1.0, -1.2]
max = [ 1.0,  1.0,  0.1]
voxel_size = {}
[[light]]
type = "sun"
direction = {}
irradiance = 1000.0
[[surface]]
name = "water"
kind = "height_field"
size = [4.0, 4.0]
{}
[[object]]
name = "floor"
plane = {{ point = [0, 0, -1.0], normal = [0, 0, 1] }}
{}
[bake]
{}
)",
                       voxel_size, sun_direction, surface, extra, bake);
}

}  // namespace photic::test
