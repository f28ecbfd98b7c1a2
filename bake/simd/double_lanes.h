// SPDX-License-Identifier: Apache-2.0
// The widest register of doubles of the instruction set, for kernels that go along rows whatever its width is.
#pragma once

#include "bake/simd/lanes.h"

namespace photic::PHOTIC_ISA {

using Lanes = WidestDoubles;
using LaneMask = MaskOf<Lanes>;
inline constexpr int kLanes = laneCount<Lanes>;

inline Lanes splat(double x) { return splat<Lanes>(x); }
inline Lanes load(const double* from) { return load<Lanes>(from); }
inline Lanes gather(const double* from, const std::int32_t* index) { return gather<Lanes>(from, index); }
inline bool any(const LaneMask& m) { return bitsOf(m) != 0; }

}  // namespace photic::PHOTIC_ISA
