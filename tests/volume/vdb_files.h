// SPDX-License-Identifier: Apache-2.0
// .vdb files as OpenVDB itself writes them.
#pragma once

#include <cstdint>
#include <random>
#include <sstream>
#include <string>

#include "bake/libraries/openvdb.h"

namespace photic {

class OpenVdbArchive : public openvdb::io::Archive {
public:
    std::string bytesOf(const openvdb::GridPtrVec& grids, std::uint32_t compression, bool seekable = true) {
        std::ostringstream out;
        setCompression(compression);
        setGridStatsMetadataEnabled(true);
        Archive::write(out, grids, seekable, openvdb::MetaMap());
        return out.str();
    }
};

/// What a voxel of a leaf holds: some of all, of both signs, zeros and tiny ones (halves without an exponent) included.
inline float valueOf(std::mt19937& random) {
    const auto n = random();
    const float sign = n & 1 ? -1.0f : 1.0f;
    switch (n >> 1 & 7) {
        case 0:
            return 0;
        case 1:
            return sign * 3e-6f * static_cast<float>(n >> 8 & 255);
        case 2:
            return sign * 60000 / static_cast<float>(1 + (n >> 8 & 255));
        default:
            return sign * static_cast<float>(n >> 8) / 1e6f;
    }
}

template <class Value>
Value gridValue(std::mt19937& random) {
    if constexpr (std::is_same_v<Value, float>)
        return valueOf(random);
    else
        return {valueOf(random), valueOf(random), valueOf(random)};
}

/// Leaves on both sides of 0, full and in part, in several nodes.
template <class Grid>
typename Grid::Ptr gridOfLeaves(unsigned seed) {
    std::mt19937 random(seed);
    auto grid = Grid::create();
    grid->setName("irradiance");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(
        openvdb::math::Mat4d(0.5, 0.0, 0.0, 0.0, 0.0, 0.25, 0.0, 0.0, 0.1, 0.0, 0.5, 0.0, 3.0, -4.0, 5.0, 1.0)));
    using Value = typename Grid::ValueType;
    for (const openvdb::Coord origin : {openvdb::Coord(0, 0, 0), openvdb::Coord(-8, 0, 8), openvdb::Coord(0, 0, 128),
                                        openvdb::Coord(4096, -16, 8), openvdb::Coord(-4104, 4088, 72)}) {
        auto* leaf = grid->tree().touchLeaf(origin);
        const bool full = random() % 3 == 0;
        for (openvdb::Index i = 0; i < 512; ++i)
            if (full || random() % 4 != 0) leaf->setValueOn(i, gridValue<Value>(random));
    }
    return grid;
}

}  // namespace photic
