// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "bake/field/needed_voxels.h"
#include "bake/tubes/tube_set.h"

namespace photic {

/// All that decides a tile's light, as 128 bits: two of the same are taken for the same.
struct TileKey {
    std::uint64_t first = 0, second = 0;
    bool operator==(const TileKey&) const = default;
};

/// Makes a TileKey of bytes, eight at a time. Both halves change with every bit of a word and lose none of what came
/// before it, each in its own way.
class TileHash {
public:
    void add(const void* data, std::size_t bytes);
    /// Of numbers, and of structs without gaps.
    template <class T>
    void add(const T& value) {
        add(&value, sizeof(T));
    }
    TileKey key() const;

private:
    void addWord(std::uint64_t word);
    std::uint64_t first_ = 0x9e3779b97f4a7c15u, second_ = 0xc2b2ae3d27d4eb4fu;
};

/// Of each block of tubes: its corners, its tubes and how they hang together.
std::vector<TileKey> keysOf(const TubeSet& set);
/// Of a grid and of which of its voxels are needed.
TileKey keyOf(const NeededVoxels& needed);

/// What a deposit laid into one tile of one slab.
struct TileLight {
    double expected = 0;  ///< as DepositTotals
    std::int64_t degenerate = 0;
    std::vector<int> slots;     ///< of the leaves that are lit
    std::vector<float> values;  ///< of each, channel after channel
    std::int64_t bytes() const {
        return static_cast<std::int64_t>(sizeof(TileLight) + slots.capacity() * sizeof(int) +
                                         values.capacity() * sizeof(float));
    }
};

/// Light of a frame, tile by tile, for the next: where the very same tubes come into a tile, its light is the very
/// same, and is handed on instead of being summed. Which tubes those are the launch decides anew each time, so that
/// nothing needs to be known of what changed in the scene.
///
/// All tiles of the first frame are kept, and of later ones those that are as they were in the frame before: of what
/// changes all over, nothing is.
class KeptTiles {
public:
    /// Between the two, tiles of one bake are looked for.
    /// @param grid        of its voxels (keyOf): nothing is kept from one grid to another
    /// @param most_bytes  that may be kept
    void begin(const TileKey& grid, std::int64_t most_bytes);
    /// What did not come up in the bake goes.
    void end();
    void clear();

    struct Found {
        const TileLight* light = nullptr;  ///< stays until end()
        bool wanted = false;               ///< where there is none, keep() it
    };
    /// Thread-safe, as is keep().
    Found find(const TileKey& key);
    void keep(const TileKey& key, TileLight&& light);

    std::int64_t found() const { return found_; }           ///< in this bake, or the last one
    std::int64_t lookedFor() const { return looked_for_; }  ///< the same
    std::int64_t bytes() const { return bytes_; }

    /// Those that bakes of this thread use; null where they use none.
    static KeptTiles* used();
    static void use(KeptTiles* tiles);

private:
    struct Entry {
        std::unique_ptr<TileLight> light;
        std::int64_t bake = 0;  ///< that it came up in last
    };
    struct Hash {
        std::size_t operator()(const TileKey& key) const { return static_cast<std::size_t>(key.first); }
    };
    std::mutex mutex_;
    std::unordered_map<TileKey, Entry, Hash> entries_;
    TileKey grid_;
    std::int64_t bake_ = 0, most_bytes_ = 0, bytes_ = 0, found_ = 0, looked_for_ = 0;
    bool first_ = true;  ///< bake of this grid
};

}  // namespace photic
