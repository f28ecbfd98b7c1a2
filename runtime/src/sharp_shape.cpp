// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/sharp_shape.h"

#include <algorithm>
#include <cmath>

#include "runtime/format/index_volume_format.h"
#include "runtime/src/guarded.h"

namespace photic::runtime {
namespace {

class ShapeReader {
public:
    ShapeReader(const Bytes& file, std::uint64_t place, const std::string& what, std::uint64_t& memory_left)
        : file_(file), place_(place), what_(what + "'s shape"), memory_left_(memory_left) {}

    SharpShape read() {
        file_.require(place_, 1, format::kShapeHeader, what_.c_str());
        SharpShape shape;
        const std::uint32_t kind = whole(format::kShapeKindAt), faces = whole(format::kShapeFacesAt);
        if (kind > format::kShapeBall) refuse("is of a kind of a later version: export it again");
        if (faces > format::kFacesThin) refuse("has faces of a later version: export it again");
        shape.kind = static_cast<SharpShape::Kind>(kind), shape.faces = static_cast<SharpShape::Faces>(faces);
        shape.rank = whole(format::kShapeRankAt);
        if (shape.rank > format::kShapeHighestRank) refuse("has rank " + std::to_string(shape.rank) + ", beyond 255");
        for (unsigned c = 0; c < 3; ++c) {
            constexpr float kLeast = 0.01F, kMost = 100;
            shape.index[c] = number(format::kShapeIndexAt + 4 * c, kLeast, kMost, "index");
            shape.absorption[c] = number(format::kShapeAbsorptionAt + 4 * c, 0, 1e9F, "absorption");
            shape.colour[c] = number(format::kShapeColourAt + 4 * c, 0, 1, "colour");
        }
        if (shape.kind == SharpShape::Kind::Ball)
            readBall(shape);
        else
            readMesh(shape);
        return shape;
    }

private:
    static constexpr float kFarthest = 1e6F;  // nodes
    std::uint32_t whole(unsigned at) const { return file_.get<std::uint32_t>(place_ + at); }
    [[noreturn]] void refuse(const std::string& why) const { fail(ErrorCode::Format, what_ + " " + why); }
    float number(unsigned at, float least, float most, const char* of) const {
        const auto value = file_.get<float>(place_ + at);
        if (!(value >= least && value <= most))
            refuse(std::string("has ") + of + " " + std::to_string(value) + "; it must be " + std::to_string(least) +
                   " to " + std::to_string(most));
        return value;
    }

    void readBall(SharpShape& shape) const {
        if (whole(format::kShapeVerticesAt) != 0 || whole(format::kShapeTrianglesAt) != 0)
            refuse("is a ball and has triangles");
        if (shape.faces == SharpShape::Faces::Thin) refuse("is a ball, and a pane without an inside");
        for (unsigned a = 0; a < 3; ++a)
            shape.ball[a] = number(format::kShapeBallAt + 4 * a, -kFarthest, kFarthest, "centre");
        shape.ball[3] = number(format::kShapeBallAt + 12, 1e-3F, kFarthest, "radius");
    }

    void readMesh(SharpShape& shape) const {
        const std::uint32_t vertices = whole(format::kShapeVerticesAt), triangles = whole(format::kShapeTrianglesAt);
        if (triangles < 1 || triangles > format::kShapeMostTriangles)
            refuse("has " + std::to_string(triangles) + " triangles; 1 to 2097152 are read");
        if (vertices < 3 || vertices > 3 * std::uint64_t{triangles})
            refuse("has " + std::to_string(vertices) + " vertices for " + std::to_string(triangles) + " triangles");
        const bool smooth = shape.kind == SharpShape::Kind::Smooth;
        constexpr std::uint64_t kVector = 12;
        const std::uint64_t vectors = std::uint64_t{vertices} * (smooth ? 2 : 1) + triangles;
        std::uint64_t at = place_ + format::kShapeHeader;
        file_.require(at, vectors, kVector, what_.c_str());
        if (vectors * kVector > memory_left_)
            fail(ErrorCode::Limit, what_ + " takes more memory than LoadOptions::largest_memory");
        memory_left_ -= vectors * kVector;
        copy(at, vertices, shape.positions);
        if (smooth) copy(at, vertices, shape.normals);
        copy(at, triangles, shape.triangles);
        for (const auto& p : shape.positions)
            for (const float c : p)
                if (!(std::fabs(c) <= kFarthest))
                    refuse("has a vertex that is no place, or more than a million nodes off");
        for (const auto& n : shape.normals) {
            const float square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
            if (!(square > 0.25F && square < 4)) refuse("has a normal that is not of length 1");
        }
        for (const auto& triangle : shape.triangles)
            for (const std::uint32_t v : triangle)
                if (v >= vertices)
                    refuse("has a triangle of vertex " + std::to_string(v) + ", of " + std::to_string(vertices));
    }

    template <class T>
    void copy(std::uint64_t& at, std::uint32_t count, std::vector<T>& out) const {
        out.resize(count);
        std::memcpy(out.data(), file_.view(at, count * sizeof(T)).data(), count * sizeof(T));
        at += count * sizeof(T);
    }

    const Bytes& file_;
    std::uint64_t place_;
    std::string what_;
    std::uint64_t& memory_left_;
};

}  // namespace

SharpShape readShape(const Bytes& file, std::uint64_t place, const std::string& what, std::uint64_t& memory_left) {
    return ShapeReader(file, place, what, memory_left).read();
}

void boundsOf(const SharpShape& shape, Double3& low, Double3& high) {
    for (std::size_t a = 0; a < 3; ++a) {
        const double centre = double(shape.ball[a]), radius = double(shape.ball[3]);
        low[a] = centre - radius, high[a] = centre + radius;
        if (shape.kind == SharpShape::Kind::Ball) continue;
        low[a] = 1e300, high[a] = -1e300;
        for (const auto& p : shape.positions)
            low[a] = std::min(low[a], double(p[a])), high[a] = std::max(high[a], double(p[a]));
    }
}

}  // namespace photic::runtime
