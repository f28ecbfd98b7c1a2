// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>
#include <new>

#include "bake/cli/arguments.h"
#include "bake/cli/stop.h"
#include "bake/cli/terminal.h"
#include "bake/field/heap.h"
#include "bake/report/error.h"
#include "bake/threads/stop_loops.h"

int main(int argc, char** argv) {
    using photic::Error;
    using photic::ErrorCode;
    photic::keepFreedMemory();
    // Never destroyed: the thread that watches signals may still speak through it.
    auto& terminal =
        *new photic::cli::Terminal(photic::cli::progressMode(argc, argv), photic::cli::loudness(argc, argv));
    photic::cli::watchSignals([&terminal](const Error& why) { terminal.lastWord(why); });
    // What takes more memory than it may goes on taking it until it looks: so loops look for it.
    photic::stopLoopsWhen([] { return photic::cli::stopWanted() == photic::cli::Stop::Memory; });
    const auto fail = [&terminal](const Error& error) {
        terminal.error(error);
        return static_cast<int>(error.code());
    };
    try {
        const int code = photic::cli::parseArguments(argc, argv)(terminal);
        terminal.finish();
        if (std::fflush(stdout) != 0 || std::ferror(stdout)) {
            return fail({ErrorCode::Failed, "could not write all of the output; is the disk full or the pipe closed?",
                         "stdout"});
        }
        return code;
    } catch (const Error& error) {
        return fail(photic::cli::explained(error));
    } catch (const std::bad_alloc&) {
        return fail({ErrorCode::Failed,
                     "out of memory; use a larger voxel_size, where = \"receivers\" or fewer grids (photic bake "
                     "--dry-run estimates)"});
    } catch (const std::exception& error) {
        return fail({ErrorCode::Failed, error.what()});
    }
}
