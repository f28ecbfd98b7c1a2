// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "bake/field/light_field.h"

namespace photic {

/// Light on the needed voxels, that which travels against an axis kept apart from the rest (docs/light_volume.md): two
/// beams that oppose each other have no mean direction that a wall between them could use.
struct LobeFields {
    LightField first;
    std::optional<LightField> second;  ///< on the same voxels; nothing where all light is in one lobe
};

/// Dark lobes; the second only where an axis parts them and there is flux to part.
LobeFields emptyLobes(const std::shared_ptr<const NeededVoxels>& needed, FieldChannels channels, bool parted);

/// Adds the light of a field with the same voxels and channels.
void addField(LightField& to, const LightField& from);

/// Keeps the second lobe where it tells something: in leaves where directions oppose each other, and those beside them,
/// so that look-ups across a leaf's side find the same lobes on both. Elsewhere, and where one lobe holds all light,
/// its light joins the first lobe. What opposes itself: |F1| + |F2| - |F1 + F2| > 0.03 (E1 + E2), which opposed beams
/// reach where |direction| of all light would be below 0.97.
/// @param faint  [W/m2] below which nothing is looked at
void keepOpposedLight(LobeFields& lobes, double faint);

/// Irradiance of both lobes, mean of the channels [W/m2], of a leaf's 512 voxels. @return whether there is any light
bool totalIrradiance(const LightField& first, const LightField* second, int slot, double* out);
inline bool totalIrradiance(const LobeFields& lobes, int slot, double* out) {
    return totalIrradiance(lobes.first, lobes.second ? &*lobes.second : nullptr, slot, out);
}

/// Both lobes in one.
LightField joined(LobeFields lobes);

}  // namespace photic
