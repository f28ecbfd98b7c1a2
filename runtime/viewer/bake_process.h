// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "bake/report/error.h"

namespace photic::viewer {

/// `photic bake` as a process of its own, and what it says about itself (docs/schemas/progress.md). It ends with this
/// object, and with the program that started it, however that ends.
class BakeProcess {
public:
    /// @param program    path of `photic`
    /// @param arguments  of the verb; --progress=json is added
    /// @throws Error{Failed} when the system starts no process
    BakeProcess(const std::string& program, const std::vector<std::string>& arguments);
    ~BakeProcess();  ///< ends it at once: what it was writing is nobody's
    BakeProcess(const BakeProcess&) = delete;
    BakeProcess& operator=(const BakeProcess&) = delete;

    /// Listens, without waiting. @return whether it has ended
    bool poll();

    pid_t pid() const { return pid_; }
    const std::string& stage() const { return stage_; }   ///< "trace" ...
    double done() const { return done_; }                 ///< of all of it, 0 to 1
    double secondsLeft() const { return seconds_left_; }  ///< estimated; below 0: too early to tell
    const std::vector<std::string>& warnings() const { return warnings_; }

    /// Of a bake that has ended: whether there is a volume, and else why not, in the baker's words.
    bool succeeded() const { return exit_code_ == 0; }
    Error failure() const;

private:
    void listen();
    void hear(const std::string& line);

    pid_t pid_ = -1;
    int said_ = -1;  ///< the end of its stderr that is read
    bool ended_ = false;
    int exit_code_ = -1;
    std::string pending_, stage_, where_, words_;
    std::vector<std::string> warnings_;
    double done_ = 0, seconds_left_ = -1;
};

}  // namespace photic::viewer
