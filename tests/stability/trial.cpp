// SPDX-License-Identifier: Apache-2.0
#include "tests/stability/trial.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <list>
#include <sstream>
#include <utility>

#include "bake/report/error.h"

namespace photic::stability {
namespace {

/// A folder that is removed at the end.
class Folder {
public:
    Folder() {
        std::string pattern = (std::filesystem::temp_directory_path() / "photic_stability_XXXXXX").string();
        if (!::mkdtemp(pattern.data())) throw Error(ErrorCode::Failed, "no temporary folder");
        path_ = pattern;
    }
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    const std::string& path() const { return path_; }

private:
    std::string path_;
};

// What the child tells, a line each: of a law that was judged its name and seconds, of one that was broken its name and
// figure, of a scene that is refused why, and at last that nothing more comes.
constexpr char kJudged = 'J', kBroken = 'B', kRefused = 'R', kEnd = 'E';

void writeLine(int pipe, char kind, const std::string& first, const std::string& second) {
    std::string line = fmt::format("{}{}\t{}", kind, first, second);
    std::replace(line.begin(), line.end(), '\n', ' ');
    line += '\n';
    if (::write(pipe, line.data(), line.size()) != static_cast<ssize_t>(line.size())) ::_exit(1);
}

void judgeInto(int pipe, const SceneModel& scene, const std::string& directory) {
    try {
        judgeLaws(scene, directory, [&](const Judgement& judgement) {
            if (judgement.broken) writeLine(pipe, kBroken, judgement.broken->law, judgement.broken->what);
            writeLine(pipe, kJudged, judgement.law, fmt::format("{:.4f}", judgement.seconds));
        });
    } catch (const Error& error) {
        const bool refused = error.code() == ErrorCode::Input || error.code() == ErrorCode::Usage;
        if (refused)
            writeLine(pipe, kRefused, error.where(), error.what());
        else
            writeLine(pipe, kBroken, "error", error.what());
    } catch (const std::exception& error) {
        writeLine(pipe, kBroken, "exception", error.what());
    }
    writeLine(pipe, kEnd, "", "");
}

/// A scene that is being tried.
class Trial {
public:
    Trial(SceneModel scene, unsigned limit_seconds) : scene_(std::move(scene)), limit_(limit_seconds) {
        int ends[2];
        if (::pipe(ends) != 0) throw Error(ErrorCode::Failed, "no pipe");
        child_ = ::fork();
        if (child_ < 0) throw Error(ErrorCode::Failed, "no process");
        if (child_ == 0) {
            ::close(ends[0]);
            const rlimit limit{limit_, limit_ + 1};
            ::setrlimit(RLIMIT_CPU, &limit);
            ::alarm(10 * limit_);
            judgeInto(ends[1], scene_, folder_.path());
            ::_exit(0);
        }
        ::close(ends[1]);
        pipe_ = ends[0];
    }
    Trial(const Trial&) = delete;
    Trial& operator=(const Trial&) = delete;

    const SceneModel& scene() const { return scene_; }
    /// Hangs up where the process has ended. What it tells fits into the pipe.
    int pipe() const { return pipe_; }

    /// Waits for the end; once only.
    Outcome outcome() {
        std::string text, part(4096, '\0');
        for (ssize_t got = 0; (got = ::read(pipe_, part.data(), part.size())) > 0;)
            text.append(part, 0, static_cast<std::size_t>(got));
        ::close(pipe_);
        int status = 0;
        ::waitpid(child_, &status, 0);
        return read(text, status);
    }

private:
    Outcome read(const std::string& text, int status) const {
        Outcome outcome;
        bool ended = false;
        std::string last = "the first";
        std::istringstream lines(text);
        for (std::string line; std::getline(lines, line);) {
            const std::size_t tab = std::min(line.find('\t'), line.size() - 1);
            const std::string first = line.substr(1, tab - 1), second = line.substr(tab + 1);
            switch (line[0]) {
                case kJudged:
                    outcome.seconds[first] = std::atof(second.c_str()), last = first;
                    break;
                case kBroken:
                    outcome.violations.push_back({first, second});
                    break;
                case kRefused:
                    outcome.kind = Outcome::Kind::Refused, outcome.refusal = first + ": " + second;
                    break;
                default:
                    ended = true;
            }
        }
        if (!ended) {
            const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
            if (signal == SIGXCPU || signal == SIGALRM)
                outcome.violations.push_back(
                    {"time", fmt::format("took more than {} s; the last law that was judged is {}", limit_, last)});
            else
                outcome.violations.push_back({"crash", fmt::format("ended with status {} (signal {}); the last law "
                                                                   "that was judged is {}",
                                                                   status, signal, last)});
        }
        if (!outcome.violations.empty()) outcome.kind = Outcome::Kind::Broken;
        return outcome;
    }

    SceneModel scene_;
    unsigned limit_;
    Folder folder_;
    pid_t child_ = 0;
    int pipe_ = -1;
};

}  // namespace

Outcome tryScene(const SceneModel& scene, unsigned limit_seconds) { return Trial(scene, limit_seconds).outcome(); }

void tryScenes(int jobs, unsigned limit_seconds, const std::function<std::optional<SceneModel>()>& next,
               const std::function<void(const SceneModel&, const Outcome&)>& ended) {
    std::list<Trial> running;
    for (bool more = true;;) {
        while (more && static_cast<int>(running.size()) < jobs) {
            if (std::optional<SceneModel> scene = next())
                running.emplace_back(std::move(*scene), limit_seconds);
            else
                more = false;
        }
        if (running.empty()) return;
        std::vector<pollfd> pipes;
        for (const Trial& trial : running) pipes.push_back({trial.pipe(), 0, 0});
        ::poll(pipes.data(), pipes.size(), -1);
        std::size_t at = 0;
        for (auto trial = running.begin(); trial != running.end();) {
            if (pipes[at++].revents == 0) {
                ++trial;
                continue;
            }
            ended(trial->scene(), trial->outcome());
            trial = running.erase(trial);
        }
    }
}

}  // namespace photic::stability
