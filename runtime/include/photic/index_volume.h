// SPDX-License-Identifier: Apache-2.0
#pragma once

// Photic's runtime: objects whose index of refraction varies in space, for eye rays that bend (photic/bent_rays.h).
//
//     auto glass = photic::runtime::loadIndexVolumes("glass.ivol");     // photic export glass.toml -o glass.ivol
//     if (!glass) return fail(glass.error().message);
//     const auto here = glass->front().at({x, y, z});                   // n^2 / 2, and its gradient
//
// Needs no GL. Nothing here throws. An IndexVolume is a handle to data that never changes: copy it freely.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "photic/result.h"
#include "photic/runtime.h"

namespace photic::runtime {

/// A refractive index n at a place. A ray goes as a ball under gravity: dx/ds = p, dp/ds = grad(n^2 / 2), where p is as
/// long as n and s grows by length / n.
struct Refraction {
    double half_square = 0.5;  ///< n^2 / 2
    Vec3 gradient;             ///< of n^2 / 2 [1/m], world: exactly that of half_square
};

/// What an object does to light at a place besides bending it.
struct Attenuation {
    Vec3 absorption, scattering;  ///< per channel [1/m]
    Vec3 emission;                ///< [W/(m3 sr)]
    double anisotropy = 0;        ///< g of Henyey and Greenstein
    bool face = false;            ///< a face goes through here
};

/// How a face sends light back besides Fresnel's mirror.
struct FaceReflection {
    Vec3 albedo;           ///< per channel: share of the light that arrives which goes back evenly to all sides
    double roughness = 0;  ///< of highlights, GGX's alpha is its square; 0: there are none
};

/// What an object ends at.
enum class IndexShape {
    Samples,  ///< its own index, or the sharp sides of its box
    Mesh,     ///< the sharp faces of triangles, their normals smooth or not
    Ball      ///< that of a ball, exactly
};

struct IndexVolumeData;

/// One object, in air.
class IndexVolume {
public:
    /// Nothing: air everywhere.
    IndexVolume();
    explicit IndexVolume(std::shared_ptr<const IndexVolumeData> data) : data_(std::move(data)) {}

    const std::string& name() const;
    /// n at a place: a cubic B-spline between nodes, in double; 1 outside of the object's box, and where `world` is not
    /// finite. Of an object with a shape this is what lies in the shape, wherever that ends; of one without samples, 1.
    /// @param channel  0 to 2: red, green, blue, of an object that disperses light
    Refraction at(const Vec3& world, int channel = 0) const;
    /// Trilinear between nodes; nothing outside of the object's box.
    Attenuation attenuation(const Vec3& world) const;

    /// Of a face, or a sharp side, at a place: trilinear between nodes; nothing outside of the object's box.
    FaceReflection faceReflection(const Vec3& world) const;

    bool disperses() const;
    bool attenuates() const;
    bool shines() const;
    /// Its faces send light back besides Fresnel's mirror.
    bool reflects() const;
    /// The object ends at its box as at a polished face; otherwise its index goes to 1 before the box ends.
    bool sharpSides() const;
    IndexShape shape() const;
    std::size_t triangles() const;     ///< of its shape
    std::array<int, 3> nodes() const;  ///< 0 of a shape of one index
    /// World position of a node [m].
    Vec3 node(double i, double j, double k) const;
    /// Corners of what holds the object, in nodes.
    void box(Vec3& low, Vec3& high) const;
    std::uint64_t bytes() const;  ///< of memory

    const IndexVolumeData& data() const { return *data_; }

private:
    std::shared_ptr<const IndexVolumeData> data_;
};

/// Reads a file of index volumes (docs/index_volumes.md). Every length and offset in it is checked before it is used.
/// @return Error{File}, Error{Format}, Error{Limit} or Error{Memory}
Result<std::vector<IndexVolume>> loadIndexVolumes(const std::string& path, const LoadOptions& options = {});

/// The same from memory, which is not needed afterwards.
Result<std::vector<IndexVolume>> readIndexVolumes(const void* bytes, std::size_t size, const LoadOptions& options = {});

}  // namespace photic::runtime
