// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bake/field/needed_voxels.h"
#include "bake/methods/catalogue.h"
#include "bake/scene/scene.h"

namespace photic {

/// One of several parts that a volume is baked in. All that one bake would do is done for each: the same tubes through
/// the whole box, and the ledger of all power; light is kept in the tile alone.
struct Tile {
    int index = 1;  ///< from 1
    int count = 1;
    std::string name() const;  ///< "3/8"
};

/// Boxes that share out the needed leaves as evenly as they can be: halves of halves along the longest side, cut at
/// multiples of 128 voxels from the frame's first leaf where that is nearly even, otherwise of 64 or 8. They cover the
/// frame and do not overlap; which is which follows from the voxels and the count alone.
/// @throws Error{Usage} when there are more tiles than leaves in the box
std::vector<VoxelBox> tileBoxes(const NeededVoxels& needed, int count);

/// Why a bake cannot be done tile by tile and come out the same; empty when it can.
/// @param post  steps that would follow
std::string tileRefusal(const Scene& scene, const Method& method, const GridFrame& frame,
                        const std::vector<std::string>& post);

/// Leaves around a tile that what is in it depends on. Only where tileRefusal() has nothing to say.
int tileMargin(const Scene& scene, const Method& method, const GridFrame& frame);

/// The part of the needed voxels that one tile is baked on. @throws Error{Usage} as tileRefusal and tileBoxes say
std::shared_ptr<const NeededVoxels> cutTile(const Scene& scene, const Method& method,
                                            std::shared_ptr<const NeededVoxels> whole, const Tile& tile,
                                            const std::vector<std::string>& post);

/// A part's place as the `tile` metadata holds it, in JSON; and back: none where it is not one.
std::string tileText(const NeededVoxels& part, const Tile& tile);
struct PlacedTile {
    Tile tile;
    VoxelBox box;
};
std::optional<PlacedTile> readTile(const std::string& text);

}  // namespace photic
