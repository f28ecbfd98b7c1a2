// SPDX-License-Identifier: Apache-2.0
#include "runtime/viewer/bake_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

#include <cerrno>
#include <csignal>
#include <cstring>
#include <nlohmann/json.hpp>

namespace photic::viewer {
namespace {

constexpr int kNotStarted = 127;  // as a shell has it

/// In the child: only calls that are safe between fork and exec.
[[noreturn]] void becomeBake(char* const* arguments, int said, pid_t parent) {
#ifdef __linux__
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(kNotStarted);  // it ended before it was asked for
#else
    static_cast<void>(parent);
#endif
    // Signals that the viewer waits for are not the baker's.
    for (const int signal : {SIGINT, SIGTERM, SIGPIPE}) std::signal(signal, SIG_DFL);
    const int nothing = open("/dev/null", O_RDWR);
    dup2(nothing, STDIN_FILENO);
    dup2(nothing, STDOUT_FILENO);
    dup2(said, STDERR_FILENO);
    execv(arguments[0], arguments);
    _exit(kNotStarted);
}

}  // namespace

BakeProcess::BakeProcess(const std::string& program, const std::vector<std::string>& arguments) {
    std::vector<std::string> words{program, "bake", "--progress=json"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
        throw Error(ErrorCode::Failed, fmt::format("cannot start a bake: {}", std::strerror(errno)));
    const pid_t self = getpid();
    pid_ = fork();
    if (pid_ == 0) becomeBake(argv.data(), ends[1], self);
    const int reason = errno;
    close(ends[1]);
    said_ = ends[0];
    fcntl(said_, F_SETFL, O_NONBLOCK);
    if (pid_ < 0) {
        close(said_);
        throw Error(ErrorCode::Failed, fmt::format("cannot start a bake: {}", std::strerror(reason)));
    }
}

BakeProcess::~BakeProcess() {
    if (!ended_) {
        kill(pid_, SIGKILL);
        while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
        }
    }
    close(said_);
}

void BakeProcess::hear(const std::string& line) {
    const auto event = nlohmann::json::parse(line, nullptr, false);
    if (!event.is_object()) {
        if (!line.empty()) words_ += (words_.empty() ? "" : "\n") + line;
        return;
    }
    const std::string kind = event.value("event", "");
    if (kind == "progress") {
        stage_ = event.value("stage", stage_);
        done_ = event.value("overall", done_);
        seconds_left_ = event.contains("eta_s") && event["eta_s"].is_number() ? event["eta_s"].get<double>() : -1;
    } else if (kind == "warning") {
        warnings_.push_back(event.value("message", ""));
    } else if (kind == "error") {
        where_ = event.value("where", ""), words_ = event.value("message", "");
    }
}

void BakeProcess::listen() {
    char part[4096];
    for (ssize_t count = 0; (count = read(said_, part, sizeof(part))) > 0;) {
        pending_.append(part, static_cast<std::size_t>(count));
        for (std::size_t end = 0; (end = pending_.find('\n')) != std::string::npos;) {
            hear(pending_.substr(0, end));
            pending_.erase(0, end + 1);
        }
    }
}

bool BakeProcess::poll() {
    if (ended_) return true;
    listen();
    int status = 0;
    if (waitpid(pid_, &status, WNOHANG) != pid_) return false;
    ended_ = true;
    listen();  // what it said last
    hear(pending_);
    exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    return true;
}

Error BakeProcess::failure() const {
    if (exit_code_ < 0) return {ErrorCode::Failed, fmt::format("the bake was ended by signal {}", -exit_code_)};
    if (exit_code_ == kNotStarted && words_.empty())
        return {ErrorCode::Failed, "cannot run photic, which should lie beside photic-view"};
    const std::string words = words_.empty() ? fmt::format("the bake ended with exit code {}", exit_code_) : words_;
    for (const ErrorCode known : {ErrorCode::Usage, ErrorCode::Input, ErrorCode::TryAgain, ErrorCode::Cancelled})
        if (exit_code_ == static_cast<int>(known)) return {known, words, where_};
    return {ErrorCode::Failed, words, where_};
}

}  // namespace photic::viewer
