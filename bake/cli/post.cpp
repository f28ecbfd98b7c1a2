// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/post_steps.h"
#include "bake/cli/verbs.h"
#include "bake/file/output_set.h"

namespace photic::cli {

int run(const PostArguments& arguments, Terminal& terminal) {
    OutputSet outputs;
    outputs.reads("the volume", arguments.volume);
    outputs.writes("the output", arguments.output);
    terminal.progress("read", 0);
    LightVolume volume = readVdb(arguments.volume);
    terminal.checkCancelled();
    terminal.progress("post", 0);
    applyPostSteps(arguments.steps, volume);
    if (arguments.as_light) causticAsLight(volume);
    terminal.checkCancelled();
    terminal.progress("write", 0);
    writeVdb(outputs, arguments.output, volume, arguments.file);
    outputs.commit();
    terminal.progress("write", 1);
    terminal.say(arguments.output + ": written");
    return 0;
}

}  // namespace photic::cli
