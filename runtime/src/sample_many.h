// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "runtime/src/volume_data.h"

namespace photic::runtime {

/// Whether the processor's own conversion of halves is used; the numbers are the same bits.
enum class HalfConversion { WhereThereIs, Never };

/// Volume::sample of many positions; both spans are as long.
void sampleMany(const VolumeData& data, std::span<const Vec3> world, std::span<Light> light, HalfConversion conversion);

}  // namespace photic::runtime
