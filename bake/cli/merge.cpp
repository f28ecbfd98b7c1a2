// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "bake/baker/merge_tiles.h"
#include "bake/baker/report_json.h"
#include "bake/cli/json.h"
#include "bake/cli/verbs.h"
#include "bake/file/output_set.h"
#include "bake/report/error.h"

namespace photic::cli {

int run(const MergeArguments& arguments, Terminal& terminal) {
    OutputSet outputs;
    outputs.reads("a tile", arguments.tiles);
    outputs.writes("the output", arguments.output);
    std::vector<TileFile> tiles;
    for (const std::string& path : arguments.tiles) tiles.push_back({path, path});
    terminal.progress("merge", 0);
    const MergedTiles merged = mergeTiles(tiles, outputs.open(arguments.output));
    terminal.checkCancelled();
    const std::int64_t file_bytes = outputs.pendingBytes(arguments.output);
    outputs.commit();
    terminal.progress("merge", 1);
    terminal.say(fmt::format("{}: {} tiles, {:.4g} voxels lit, {:.1f} MB", arguments.output, tiles.size(),
                             static_cast<double>(merged.active_voxels), static_cast<double>(file_bytes) * 1e-6));
    if (arguments.json)
        print({{"schema", "photic-merge-1"},
               {"output", arguments.output},
               {"tiles", tiles.size()},
               {"frame", merged.frame},
               {"active_voxels", merged.active_voxels},
               {"file_bytes", file_bytes},
               {"power", toJson(merged.power)},
               {"path", toJson(merged.path)}});
    return 0;
}

}  // namespace photic::cli
