// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace photic::test {

/// A directory of its own, removed with the object.
class Workplace {
public:
    Workplace();
    ~Workplace();
    Workplace(const Workplace&) = delete;
    Workplace& operator=(const Workplace&) = delete;

    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
    const std::filesystem::path& path() const { return path_; }
    void write(const std::string& name, const std::string& bytes) const;
    std::string read(const std::string& name) const;
    bool has(const std::string& name) const { return std::filesystem::exists(path_ / name); }
    /// Names of everything in it, sorted.
    std::vector<std::string> names() const;

private:
    std::filesystem::path path_;
};

struct Outcome {
    int code = -1;  ///< exit code; 1000 + signal when it was killed
    std::string out, err;
    std::int64_t most_bytes = 0;  ///< of memory that it held
    nlohmann::json json() const { return nlohmann::json::parse(out); }
    /// Each line of stderr as JSON.
    std::vector<nlohmann::json> events() const;
};

/// A running photic, with the workplace as its current directory.
class Program {
public:
    /// @param file_size_limit  RLIMIT_FSIZE [bytes]; 0: none
    Program(const Workplace& place, const std::vector<std::string>& arguments, std::int64_t file_size_limit = 0);
    pid_t pid() const { return pid_; }
    /// What it has said on stderr so far.
    std::string errSoFar() const;
    Outcome wait();

private:
    const Workplace& place_;
    std::filesystem::path out_, err_;
    pid_t pid_ = -1;
};

Outcome photic(const Workplace& place, const std::vector<std::string>& arguments, std::int64_t file_size_limit = 0);

/// A scene of a small pool, its parts to be replaced.
struct PoolText {
    double voxel_size = 2.0 / 32;
    std::string sun_direction = "[0.433, 0.25, -0.866]";
    std::string surface = "waves = [{ amplitude = 0.03, wavelength = 1.0, direction = 20.0, phase = 0.4 }]";
    std::string bake, extra;
    std::string text() const;
};

}  // namespace photic::test
