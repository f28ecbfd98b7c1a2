// SPDX-License-Identifier: Apache-2.0
// `photic view`. A program of its own: `photic` runs it when asked, and so needs no GL to bake.
#include <cstdio>
#include <exception>

#include "bake/report/error_text.h"
#include "runtime/viewer/show.h"

int main(int argc, char** argv) {
    try {
        const auto options = photic::viewer::parseOptions(argc, argv);
        if (!options) return 0;
        photic::viewer::watchSignals();
        options->screenshot.empty() ? photic::viewer::openWindow(*options) : photic::viewer::takeScreenshot(*options);
        return 0;
    } catch (const photic::Error& error) {
        std::fprintf(stderr, "photic view: %s\n", photic::errorText(error).c_str());
        return static_cast<int>(error.code());
    } catch (const std::exception& error) {
        std::fprintf(stderr, "photic view: %s\n", error.what());
        return static_cast<int>(photic::ErrorCode::Failed);
    }
}
