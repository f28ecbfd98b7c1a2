// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "runtime/src/bytes.h"
#include "runtime/src/volume_data.h"

namespace photic::runtime {

/// A shape with sharp faces, in nodes of its object.
struct SharpShape {
    enum class Kind { Smooth, Flat, Ball };
    enum class Faces { Glass, Clear, Mirror, Thin };
    Kind kind = Kind::Smooth;
    Faces faces = Faces::Glass;
    std::array<float, 3> index{1, 1, 1};  ///< inside, where the object has no spline
    std::uint32_t rank = 0;
    std::array<float, 3> absorption{0, 0, 0};  ///< [1/m]
    std::array<float, 3> colour{1, 1, 1};      ///< of a mirror
    std::array<float, 4> ball{0, 0, 0, 1};     ///< centre and radius
    std::vector<std::array<float, 3>> positions;
    std::vector<std::array<float, 3>> normals;            ///< covectors of nodes; of smooth ones alone
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counterclockwise from outside

    std::uint64_t bytes() const {
        return (positions.size() + normals.size() + triangles.size()) * sizeof(std::array<float, 3>);
    }
};

/// The shape whose block lies at a place of the file.
/// @param what  the object, for messages
/// @param memory_left  is counted down [bytes]
/// @throws Failure{Format} for anything that makes no sense, Failure{Limit}
SharpShape readShape(const Bytes& file, std::uint64_t place, const std::string& what, std::uint64_t& memory_left);

/// The box around a shape, in nodes.
void boundsOf(const SharpShape& shape, Double3& low, Double3& high);

}  // namespace photic::runtime
