// SPDX-License-Identifier: Apache-2.0
// `photic view` is the program photic-view beside this one, so that baking needs no GL.
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "bake/cli/verbs.h"
#include "bake/report/error.h"

namespace photic::cli {

int run(const ViewArguments& arguments, Terminal&) {
    namespace fs = std::filesystem;
    std::error_code failure;
    const fs::path self = fs::read_symlink("/proc/self/exe", failure);
    const fs::path viewer = self.parent_path() / "photic-view";
    if (failure || !fs::exists(viewer)) {
        throw Error(
            ErrorCode::Usage,
            fmt::format("the viewer is not built: there is no {}; install libglfw3-dev, libepoxy-dev, libimgui-dev and "
                        "libegl-dev (scripts/setup build), configure and build again",
                        viewer.string()));
    }
    std::string name = "photic view";
    std::vector<std::string> texts = arguments.arguments;
    std::vector<char*> argv{name.data()};
    for (std::string& text : texts) argv.push_back(text.data());
    argv.push_back(nullptr);
    execv(viewer.c_str(), argv.data());
    throw Error(ErrorCode::Failed, fmt::format("cannot run it: {}", std::strerror(errno)), viewer.string());
}

}  // namespace photic::cli
