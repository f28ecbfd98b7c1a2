// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/merge_tiles.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "bake/baker/bake_tile.h"
#include "bake/baker/report_json.h"
#include "bake/file/vdb_join.h"
#include "bake/report/error.h"

namespace photic {
namespace {

using Metadata = std::map<std::string, std::string>;
using Parts = std::vector<std::unique_ptr<VdbPart>>;

[[noreturn]] void refuse(const std::string& why, const std::string& name) { throw Error(ErrorCode::Input, why, name); }

std::string textOf(const VdbPart& part, const char* key) {
    const auto found = part.metadata().find(key);
    return found == part.metadata().end() ? std::string() : found->second;
}

template <class Number>
Number numberOf(const VdbPart& part, const char* key, Number missing) {
    const std::string text = textOf(part, key);
    Number value = missing;
    const auto end = text.data() + text.size();
    return std::from_chars(text.data(), end, value).ptr == end ? value : missing;
}

PlacedTile placeOf(const VdbPart& part) {
    const std::string text = textOf(part, "tile");
    if (text.empty())
        refuse(fmt::format("{} is a whole volume and no tile; tiles are made by photic bake --tile", part.name()),
               part.name());
    const auto placed = readTile(text);
    if (!placed) refuse(fmt::format("{} does not say which tile it is ('{}')", part.name(), text), part.name());
    return *placed;
}

/// Which tiles there are: each once, and all.
void checkNumbers(const Parts& parts) {
    const int count = placeOf(*parts.front()).tile.count;
    std::map<int, const VdbPart*> found;
    for (const auto& part : parts) {
        const Tile tile = placeOf(*part).tile;
        if (tile.count != count)
            refuse(fmt::format("{} is tile {}, and {} is one of {}; merge tiles of one count", part->name(),
                               tile.name(), parts.front()->name(), count),
                   part->name());
        const auto [at, is_new] = found.emplace(tile.index, part.get());
        if (!is_new)
            refuse(fmt::format("{} and {} are both tile {}; give each tile once", at->second->name(), part->name(),
                               tile.name()),
                   part->name());
    }
    std::vector<int> missing;
    for (int i = 1; i <= count; ++i)
        if (found.count(i) == 0) missing.push_back(i);
    constexpr std::size_t kNamed = 20;
    if (missing.empty()) return;
    const bool more = missing.size() > kNamed;
    const std::size_t all = missing.size();
    if (more) missing.resize(kNamed);
    refuse(fmt::format("{} of {} tiles {} missing: {}{}; bake {} with --tile", all, count, all == 1 ? "is" : "are",
                       fmt::join(missing, ", "), more ? " ..." : "", all == 1 ? "it" : "them"),
           {});
}

/// Refuses a tile that is not of the bake that the first is of.
void checkAlike(const VdbPart& first, const VdbPart& part) {
    const auto differ = [&](const std::string& what, const std::string& of_first, const std::string& of_part) {
        refuse(
            fmt::format("{} is of another {} than {}: {} and {}", part.name(), what, first.name(), of_part, of_first),
            part.name());
    };
    const VdbTransform &a = first.grids().front().layout.transform, &b = part.grids().front().layout.transform;
    if (a.world_from_index != b.world_from_index || a.origin_world != b.origin_world) {
        const auto voxel = [](const VdbTransform& t) {
            const auto& m = t.world_from_index;
            return fmt::format("voxels of {:.6g} x {:.6g} x {:.6g} m from ({:.6g}, {:.6g}, {:.6g})", m[0].x, m[1].y,
                               m[2].z, t.origin_world.x, t.origin_world.y, t.origin_world.z);
        };
        differ("grid", voxel(a), voxel(b));
    }
    for (const auto& [key, what] : {std::pair{"frame", "frame"},
                                    {"method", "method"},
                                    {"reference_irradiance", "reference irradiance [W/m2]"},
                                    {"program", "program"},
                                    {"options", "bake, with other settings"},
                                    {"scene_hash", "scene (scene_hash)"}})
        if (textOf(first, key) != textOf(part, key)) differ(what, textOf(first, key), textOf(part, key));
    // What only one of them says may be of the second lobe, which a tile may be without.
    for (const auto& [key, text] : part.metadata()) {
        if (key == "tile" || key == "ledger" || key == "clamped") continue;
        const auto found = first.metadata().find(key);
        if (found != first.metadata().end() && found->second != text) differ(key, found->second, text);
    }
    for (const VdbPart::Grid& grid : part.grids()) {
        const VdbPart::Grid* same = first.grid(grid.layout.name);
        const bool lobe = grid.layout.name.ends_with("_2");
        if (!same && lobe) continue;
        if (!same)
            refuse(fmt::format("{} has a grid '{}', and {} has none", part.name(), grid.layout.name, first.name()),
                   part.name());
        const VdbGridLayout &p = same->layout, &q = grid.layout;
        if (p.half != q.half || p.compression != q.compression || p.components != q.components)
            refuse(fmt::format("{} stores its grid '{}' otherwise than {}; bake tiles with the same --compression and "
                               "--f32",
                               part.name(), q.name, first.name()),
                   part.name());
    }
    for (const VdbPart::Grid& grid : first.grids())
        if (!part.grid(grid.layout.name) && !grid.layout.name.ends_with("_2"))
            refuse(fmt::format("{} has no grid '{}', and {} has", part.name(), grid.layout.name, first.name()),
                   part.name());
}

/// Both ledgers of all tiles. @return whether the tiles have any
bool addLedgers(const Parts& parts, MergedTiles& merged) {
    const VdbPart& first = *parts.front();
    if (textOf(first, "ledger").empty()) return false;
    for (const auto& part : parts) {
        PowerLedger power;
        PathLedger path;
        readLedger(textOf(*part, "ledger"), power, path);
        if (part.get() == &first) merged.power = power;
        // Each tile is baked with all light; machines whose registers differ round it a little otherwise.
        constexpr double kRounding = 1e-5;
        for (const auto term : PowerLedger::kTerms)
            if (std::fabs(power.*term - merged.power.*term) > kRounding * merged.power.emitted)
                refuse(fmt::format("{} was baked with other light than {}: their power ledgers differ ({:.6g} W and "
                                   "{:.6g} W); bake one of them again",
                                   part->name(), first.name(), power.*term, merged.power.*term),
                       part->name());
        merged.path.deposited += path.deposited, merged.path.expected += path.expected;
    }
    return true;
}

}  // namespace

MergedTiles mergeTiles(const std::vector<TileFile>& tiles, CheckedFile& file) {
    Parts parts;
    for (const TileFile& tile : tiles) parts.push_back(std::make_unique<VdbPart>(tile.path, tile.name));
    for (const auto& part : parts) placeOf(*part);
    for (const auto& part : parts) checkAlike(*parts.front(), *part);
    checkNumbers(parts);
    std::sort(parts.begin(), parts.end(),
              [](const auto& a, const auto& b) { return placeOf(*a).tile.index < placeOf(*b).tile.index; });

    MergedTiles merged;
    merged.frame = numberOf(*parts.front(), "frame", 0);
    Metadata metadata;
    std::int64_t clamped = 0;
    for (const auto& part : parts) {
        metadata.insert(part->metadata().begin(), part->metadata().end());
        clamped += numberOf<std::int64_t>(*part, "clamped", 0);
    }
    metadata.erase("tile");
    if (addLedgers(parts, merged)) {
        BakeReport ledgers;
        ledgers.power = merged.power, ledgers.path = merged.path;
        metadata["ledger"] = ledgerText(ledgers);
    }
    merged.active_voxels =
        joinVdb(file, parts, metadata, numberOf(*parts.front(), "reference_irradiance", 1.0), clamped);
    return merged;
}

}  // namespace photic
