// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/bake_slabs.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bake/baker/bake_cost.h"
#include "bake/baker/merge_tiles.h"
#include "bake/field/scene_grid.h"
#include "bake/field/scene_needed_voxels.h"
#include "bake/methods/kept_shapes.h"
#include "bake/report/error.h"
#include "bake/report/stopwatch.h"

namespace photic {
namespace {

constexpr int kMostSlabs = 64;
// Of the memory that may be taken: an estimate is off by some per cent.
constexpr double kFilled = 0.8;
// What is known of each leaf while slabs are joined, for each grid of a file [bytes].
constexpr std::int64_t kBytesAJoinedLeaf = 200;

/// The stages of slab after slab as one.
class SlabMonitor final : public Monitor {
public:
    SlabMonitor(Monitor& to, int slabs) : to_(to), slabs_(slabs) {}
    void next() { ++slab_, done_ = 0; }
    void expect(const std::vector<Stage>& stages) { stages_ = stages; }

    void progress(std::string_view stage, double fraction) override {
        double before = 0, own = 0, all = 0;
        for (const Stage& known : stages_) {
            if (known.name == stage) own = known.seconds, before = all;
            all += known.seconds;
        }
        if (all > 0) done_ = std::max(done_, (before + own * fraction) / all);
        to_.progress("slabs", (slab_ + std::min(done_, 1.0)) / slabs_);
    }
    bool cancelled() const override { return to_.cancelled(); }
    void warn(const std::string& message) override { to_.warn(message); }
    void note(const std::string& message) override { to_.note(message); }

private:
    Monitor& to_;
    int slabs_, slab_ = -1;
    double done_ = 0;
    std::vector<Stage> stages_;
};

/// The most of tiles, with their margins.
NeededCount largestOf(const NeededVoxels& needed, int tiles, int margin_leaves) {
    NeededCount largest;
    for (const VoxelBox& tile : tileBoxes(needed, tiles)) {
        const VoxelBox grown{((tile.min >> 3) - margin_leaves) * 8, ((tile.max >> 3) + 1 + margin_leaves) * 8 - 1};
        double leaves = 0;
        if (needed.isEverything()) {
            const glm::ivec3 low = glm::max(grown.min, needed.frame().min),
                             high = glm::min(grown.max, needed.frame().max);
            const glm::dvec3 size((high >> 3) - (low >> 3) + 1);
            leaves = size.x * size.y * size.z;
        } else {
            for (int slot = 0; slot < needed.leafCount(); ++slot) leaves += grown.contains(needed.leafOrigin(slot));
        }
        largest.leaves = std::max(largest.leaves, leaves);
    }
    largest.voxels = LightField::kLeafVoxels * largest.leaves;
    return largest;
}

/// Adds what a slab did to the report of all.
void addReport(const BakeReport& slab, bool first, BakeReport& all) {
    if (first) {
        all = slab;
        return;
    }
    // All light is traced for each slab: what it counts is the same.
    all.path.deposited += slab.path.deposited, all.path.expected += slab.path.expected;
    all.needed_voxels += slab.needed_voxels, all.active_voxels += slab.active_voxels;
    all.field_bytes = std::max(all.field_bytes, slab.field_bytes);
    for (const auto& [stage, seconds] : slab.seconds) {
        const auto same = std::find_if(all.seconds.begin(), all.seconds.end(),
                                       [&](const auto& known) { return known.first == stage; });
        if (same == all.seconds.end())
            all.seconds.emplace_back(stage, seconds);
        else
            same->second += seconds;
    }
    for (const auto& [from, to] : {std::pair{&slab.warnings, &all.warnings}, {&slab.skipped, &all.skipped}})
        for (const std::string& word : *from)
            if (std::find(to->begin(), to->end(), word) == to->end()) to->push_back(word);
}

}  // namespace

SlabPlan slabsToFit(const Scene& scene, Monitor& monitor, const BakeChoices& choices) {
    if (choices.tile || errorGoal(scene.bake) > 0) return {};
    const Method& method = chooseMethod(scene.bake.method, scene);
    checkMethodTables(scene);
    const GridFrame frame = sceneFrame(scene);
    const std::int64_t limit = memoryLimit(choices);
    if (mostMemory(scene, method, frame) <= limit) return {};
    // The box is the most that can be needed.
    if (bakeCost(scene, method, frame, nullptr, choices).memory_bytes <= limit) return {};
    const NeededVoxels needed = sceneNeededVoxels(scene, frame, monitor);
    const BakeCost whole = bakeCost(scene, method, frame, &needed, choices);
    if (whole.memory_bytes <= limit) return {};

    std::string why = tileRefusal(scene, method, frame, choices.post);
    if (why.empty()) {
        const int margin = tileMargin(scene, method, frame);
        const double joined = kBytesAJoinedLeaf * static_cast<double>(whole.leaves) * (1 + scene.bake.grids.direction);
        const std::int64_t blocks = NeededVoxels::everything(frame).leafCount();
        for (int slabs = 2; slabs <= std::min<std::int64_t>(kMostSlabs, blocks); slabs += (slabs + 1) / 2) {
            const BakeCost each = bakeCost(scene, method, frame, largestOf(needed, slabs, margin), choices);
            const double held = static_cast<double>(each.memory_bytes + needed.bytes());
            if (std::max(held, joined) <= kFilled * static_cast<double>(limit)) return {slabs, each};
        }
        why = fmt::format("{} would not be enough", kMostSlabs);
    }
    try {
        checkMemory(whole, choices);
    } catch (const Error& error) {
        throw Error(error.code(),
                    fmt::format("{} (nor can it be baked in slabs one after another: {})", error.what(), why),
                    error.where());
    }
    return {};
}

BakedSlabs bakeInSlabs(const Scene& scene, int slabs, CheckedFile& output, Monitor& caller, const BakeChoices& given) {
    const KeptShapes shapes;
    SlabMonitor monitor(caller, slabs);
    BakeChoices choices = given;
    choices.measure = Measure::Nothing;
    choices.kept_light = nullptr;  // there is no memory for it, or no need of slabs
    choices.expect = [&](const std::vector<Stage>& stages) { monitor.expect(stages); };
    if (given.expect) given.expect({{"slabs", 1}});
    BakedSlabs all;
    std::vector<std::unique_ptr<CheckedFile>> files;
    std::vector<TileFile> tiles;
    double write_seconds = 0;
    for (int slab = 1; slab <= slabs; ++slab) {
        monitor.next();
        choices.tile = Tile{slab, slabs};
        BakedScene baked = bakeScene(scene, monitor, choices);
        const Stopwatch watch;
        // Under the output's own temporary names: what a killed run leaves goes with the next one.
        files.push_back(std::make_unique<CheckedFile>(output.path()));
        baked.report.active_voxels = writeVdb(*files.back(), baked.volume, given.file);
        tiles.push_back({files.back()->temporaryPath(), fmt::format("slab {}", choices.tile->name())});
        write_seconds += watch.seconds();
        if (slab == 1) all.frame = baked.volume.field.frame();
        addReport(baked.report, slab == 1, all.report);
    }
    const Stopwatch watch;
    const MergedTiles merged = mergeTiles(tiles, output);
    all.report.active_voxels = merged.active_voxels;
    all.report.seconds.emplace_back("slabs", write_seconds);
    all.report.seconds.emplace_back("join", watch.seconds());
    all.report.skipped.push_back("look-ups are not measured: the volume is baked in slabs");
    return all;
}

}  // namespace photic
