// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "bake/field/needed_voxels.h"

namespace photic {

/// Light of a sequence's last frame, in tiles, for the next one: where the very same light comes into a tile, it is
/// handed on instead of being summed again, bit for bit. `beams` does it; other methods bake each frame whole.
class KeptLight {
public:
    KeptLight();
    ~KeptLight();

    /// While it lives, bakes of this thread take from what is kept, and leave what they make.
    class Lent {
    public:
        /// @param kept        null: nothing is kept
        /// @param most_bytes  that may be kept; no more than twice what all needed voxels take is
        Lent(KeptLight* kept, const NeededVoxels& needed, int channels, std::int64_t most_bytes);
        ~Lent();
        Lent(const Lent&) = delete;
        Lent& operator=(const Lent&) = delete;

    private:
        KeptLight* kept_;
    };

    /// Gives its memory back.
    void clear();
    std::int64_t bytes() const;

private:
    struct Tiles;
    std::unique_ptr<Tiles> tiles_;
};

}  // namespace photic
