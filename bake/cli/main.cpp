// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>
#include <new>
#include <string_view>
#include <variant>

#include "bake/cli/arguments.h"
#include "bake/cli/terminal.h"
#include "bake/cli/verbs.h"
#include "bake/field/heap.h"
#include "bake/report/error.h"

namespace {

int runVerb(const photic::cli::Verb& verb, photic::cli::Terminal& terminal) {
    return std::visit(
        [&](const auto& arguments) {
            using Arguments = std::decay_t<decltype(arguments)>;
            if constexpr (std::is_same_v<Arguments, photic::cli::NothingToDo>) {
                return 0;
            } else {
                return run(arguments, terminal);
            }
        },
        verb);
}

}  // namespace

int main(int argc, char** argv) {
    using photic::ErrorCode;
    photic::keepFreedMemory();
    photic::cli::installSignalHandlers();
    photic::cli::Terminal terminal(photic::cli::progressMode(argc, argv));
    const auto fail = [&](ErrorCode code, const std::string& where, const std::string& message) {
        terminal.error(static_cast<int>(code), where, message);
        return static_cast<int>(code);
    };
    try {
        const int code = runVerb(photic::cli::parseArguments(argc, argv), terminal);
        if (std::fflush(stdout) != 0 || std::ferror(stdout)) {
            return fail(ErrorCode::Failed, "stdout",
                        "could not write all of the output; is the disk full or the pipe closed?");
        }
        return code;
    } catch (const photic::Error& error) {
        return fail(error.code(), error.where(), error.what());
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::Failed, "",
                    "out of memory; use a larger voxel_size, where = \"receivers\" or fewer grids (photic bake "
                    "--dry-run estimates)");
    } catch (const std::exception& error) {
        return fail(ErrorCode::Failed, "", error.what());
    }
}
