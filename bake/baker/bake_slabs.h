// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "bake/baker/bake_cost.h"
#include "bake/baker/bake_scene.h"
#include "bake/file/checked_file.h"

namespace photic {

/// How a bake stays within its memory.
struct SlabPlan {
    int slabs = 1;
    BakeCost each;  ///< of a slab, where there are several
};

/// How many slabs a bake must be cut to, to stay within memoryLimit(): 1 where it fits whole, where it chooses its own
/// voxels, and for a tile, which is asked for as it is; 64 at most.
/// @throws Error{Failed} where it fits in no way: with the figures, and why it cannot be cut
SlabPlan slabsToFit(const Scene& scene, Monitor& monitor, const BakeChoices& choices);

/// A volume that was baked in slabs.
struct BakedSlabs {
    BakeReport report;  ///< of all slabs together; active_voxels is that of the file
    GridFrame frame;
};

/// Bakes the tiles of a volume one after the other, each into a file under a temporary name beside `output`, and joins
/// them: the file is the one that bakeScene() and writeVdb() would make, but for the last digits of its path ledger.
/// Takes the memory of the largest slab, about a hundred bytes for each leaf of the volume, and the disk twice.
/// Look-ups on receivers are not measured. The caller commits `output`.
/// @throws as bakeScene() and writeVdb()
BakedSlabs bakeInSlabs(const Scene& scene, int slabs, CheckedFile& output, Monitor& monitor,
                       const BakeChoices& choices);

}  // namespace photic
