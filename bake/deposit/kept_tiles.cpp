// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/kept_tiles.h"

#include <cstring>
#include <utility>

#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

thread_local KeptTiles* used_tiles = nullptr;

// The hash reads these as they lie in memory.
static_assert(sizeof(CornerRay) == 6 * sizeof(double));
static_assert(sizeof(TubeConstants) == 7 * sizeof(float));
static_assert(sizeof(BlockTopology::Triangle) == 3 && sizeof(BlockTopology::Edge) == 4);

}  // namespace

void TileHash::addWord(std::uint64_t word) {
    // Each line can be undone where the word is known, so that two ways to here never meet.
    first_ = (first_ ^ word) * 0x9fb21c651e98df25u;
    first_ ^= first_ >> 32;
    second_ = (second_ + word) * 0xd6e8feb86659fd93u;
    second_ ^= second_ >> 29;
}

void TileHash::add(const void* data, std::size_t bytes) {
    const auto* from = static_cast<const unsigned char*>(data);
    for (; bytes >= 8; bytes -= 8, from += 8) {
        std::uint64_t word = 0;
        std::memcpy(&word, from, 8);
        addWord(word);
    }
    if (bytes == 0) return;
    std::uint64_t word = 0;
    std::memcpy(&word, from, bytes);
    addWord(word ^ bytes << 60);
}

TileKey TileHash::key() const {
    TileHash last = *this;
    for (int i = 0; i < 2; ++i) last.addWord(0);
    return {last.first_, last.second_};
}

std::vector<TileKey> keysOf(const TubeSet& set) {
    std::vector<TileKey> keys(set.blocks.size());
    parallelFor(static_cast<std::int64_t>(keys.size()), [&](std::int64_t i) {
        const TubeBlock& block = set.blocks[static_cast<std::size_t>(i)];
        const BlockTopology& topology = *block.topology;
        TileHash hash;
        hash.add(topology.vertex_count);
        hash.add(topology.triangles.size());
        hash.add(topology.triangles.data(), topology.triangles.size() * sizeof(BlockTopology::Triangle));
        hash.add(topology.edges.data(), topology.edges.size() * sizeof(BlockTopology::Edge));
        hash.add(set.corners.data() + block.first_corner,
                 static_cast<std::size_t>(topology.vertex_count) * sizeof(CornerRay));
        hash.add(set.tubes.data() + block.first_tube, topology.triangles.size() * sizeof(TubeConstants));
        for (int c = 0; c < 3; ++c) hash.add(block.extinction[c]);
        keys[static_cast<std::size_t>(i)] = hash.key();
    });
    return keys;
}

TileKey keyOf(const NeededVoxels& needed) {
    TileHash hash;
    const auto addVoxel = [&](const glm::ivec3& voxel) {
        for (int a = 0; a < 3; ++a) hash.add(voxel[a]);
    };
    const GridFrame& frame = needed.frame();
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) hash.add(frame.worldFromIndex()[c][r]);
    for (int a = 0; a < 3; ++a) hash.add(frame.origin_world[a]);
    addVoxel(frame.min), addVoxel(frame.max);
    addVoxel(needed.tile().min), addVoxel(needed.tile().max);
    hash.add(needed.leafCount());
    if (needed.isEverything()) return hash.key();
    for (int slot = 0; slot < needed.leafCount(); ++slot) {
        addVoxel(needed.leafOrigin(slot));
        const NeededVoxels::Mask& mask = needed.mask(slot);
        hash.add(mask.data(), sizeof(mask));
    }
    return hash.key();
}

void KeptTiles::begin(const TileKey& grid, std::int64_t most_bytes) {
    const std::lock_guard lock(mutex_);
    if (!(grid == grid_) || bytes_ > most_bytes) entries_.clear(), bytes_ = 0;
    grid_ = grid, most_bytes_ = most_bytes;
    first_ = entries_.empty();
    ++bake_, found_ = 0, looked_for_ = 0;
}

void KeptTiles::end() {
    const std::lock_guard lock(mutex_);
    std::erase_if(entries_, [&](const auto& entry) {
        if (entry.second.bake == bake_) return false;
        if (entry.second.light) bytes_ -= entry.second.light->bytes();
        return true;
    });
}

void KeptTiles::clear() {
    const std::lock_guard lock(mutex_);
    entries_.clear(), bytes_ = 0;
}

KeptTiles::Found KeptTiles::find(const TileKey& key) {
    const std::lock_guard lock(mutex_);
    ++looked_for_;
    const auto [entry, is_new] = entries_.try_emplace(key);
    entry->second.bake = bake_;
    if (entry->second.light) {
        ++found_;
        return {entry->second.light.get(), false};
    }
    return {nullptr, (first_ || !is_new) && bytes_ < most_bytes_};
}

void KeptTiles::keep(const TileKey& key, TileLight&& light) {
    auto kept = std::make_unique<TileLight>(std::move(light));
    const std::lock_guard lock(mutex_);
    Entry& entry = entries_[key];
    if (entry.light || bytes_ + kept->bytes() > most_bytes_) return;
    bytes_ += kept->bytes();
    entry.light = std::move(kept);
}

KeptTiles* KeptTiles::used() { return used_tiles; }
void KeptTiles::use(KeptTiles* tiles) { used_tiles = tiles; }

}  // namespace photic
