// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include "bake/cli/bake_plan.h"
#include "bake/cli/verbs.h"
#include "bake/file/slice_atlas.h"
#include "bake/report/error.h"

namespace photic::cli {

int run(const ExportArguments& arguments, Terminal& terminal) {
    if (std::filesystem::path(arguments.output).extension() != ".exr") {
        throw Error(ErrorCode::Usage,
                    "output '" + arguments.output + "' does not end in .exr, the one format that is built", "-o");
    }
    checkWritable(arguments.output);
    terminal.progress("read", 0);
    const LightVolume volume = readVdb(arguments.volume);
    terminal.checkCancelled();
    terminal.progress("write", 0);
    writeSliceAtlas(arguments.output, volume);
    terminal.progress("write", 1);
    terminal.say(arguments.output + ": atlas and its .json written");
    return 0;
}

}  // namespace photic::cli
