// SPDX-License-Identifier: Apache-2.0
#pragma once

// Photic's runtime, CPU half: loads a baked light volume and looks light up in it. Needs no GL.
//
//     auto loaded = photic::runtime::loadVolume("pool.nvdb");
//     if (!loaded) return fail(loaded.error().message);
//     const photic::runtime::Vec3 e = loaded->irradiance({x, y, z}, {0, 0, 1});   // [W/m2] per channel
//
// Nothing here throws. A Volume is a handle to data that never changes: copy it freely, sample it from any thread.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>

#include "photic/result.h"

namespace photic::runtime {

struct Vec3 {
    double x = 0, y = 0, z = 0;
};

/// Light at a point.
struct Light {
    Vec3 irradiance;  ///< fluence rate per channel [W/m2]; the three are equal when the volume is white
    Vec3 flux;        ///< net flux of the mean of the channels [W/m2]; its direction is that of travel
};

/// What the bake said about itself.
struct Metadata {
    int version = 1;                  ///< of the light volume's format
    double reference_irradiance = 1;  ///< [W/m2]: a stored 1 means this
    double ior = 1;                   ///< of the medium
    Vec3 scattering, absorption;      ///< of the medium [1/m]
    double anisotropy = 0;            ///< g of the medium's Henyey-Greenstein phase function
    int frame = 0;
    /// The medium is where dot(xyz, world) <= w: below the water's level as the file says it, or else below the highest
    /// of the voxels that hold light; infinite w: everywhere, of a volume that is dark.
    double surface[4] = {0, 0, 1, std::numeric_limits<double>::infinity()};
    std::string scene_hash;         ///< of the scene that was baked, 16 hexadecimal digits; empty when it is not known
    Vec3 period;                    ///< [m] after which the light repeats along the world's axes; 0: it does not
    std::string up_axis = "Z";      ///< of the world
    std::string paths = "caustic";  ///< "caustic" or "all"
    /// Blocks of 16^3 voxels whose light is smooth, so that a GPU takes one brick for each, of voxels twice as wide
    /// (docs/schemas/runtime.md); empty: none.
    std::string coarse_blocks;
};

struct LoadOptions {
    std::uint64_t largest_file = std::uint64_t{4} << 30;    ///< [bytes], as it lies on the disk and unpacked
    std::uint64_t largest_memory = std::uint64_t{4} << 30;  ///< of the volume once loaded [bytes]
};

/// Voxels of a grid, both ends inside.
struct VoxelBox {
    int min[3] = {0, 0, 0}, max[3] = {-1, -1, -1};
};

struct VolumeData;

/// A light volume in memory: half floats in bricks of 8^3 voxels.
class Volume {
public:
    /// Empty and dark.
    Volume();
    explicit Volume(std::shared_ptr<const VolumeData> data) : data_(std::move(data)) {}

    /// Interpolated between the eight voxels around a point (trilinear, in double); voxels without light are dark.
    /// @param world  [m]; any value, also one that is not finite, which gives darkness
    Light sample(const Vec3& world) const;

    /// What a surface gets: E_c = irradiance_c * max(0, -normal . flux) / mean irradiance [W/m2] per channel; exact
    /// when no light comes from behind it, otherwise a lower bound. A volume without directions gives its fluence rate.
    /// @param normal  away from the surface, of any length; 0 gives darkness
    Vec3 irradiance(const Vec3& world, const Vec3& normal) const;

    /// Many look-ups in one call, several times as fast as one by one (docs/runtime.md): mixed in float, not in double,
    /// which differs by less than 1e-6 of the largest value around. Of spans of different lengths the shortest counts.
    void sample(std::span<const Vec3> world, std::span<Light> light) const;
    void irradiance(std::span<const Vec3> world, std::span<const Vec3> normals, std::span<Vec3> out) const;

    /// Where light opposes itself a volume keeps two lobes apart, each with a direction of its own. All look-ups here
    /// add both up; this is the second as a volume, for a GPU that is to do so too; dark where there is none.
    Volume secondLobe() const;
    bool hasSecondLobe() const;

    const Metadata& metadata() const;
    bool coloured() const;
    bool hasDirection() const;
    /// Around all voxels that hold light.
    VoxelBox litVoxels() const;
    /// World position of a voxel's centre [m].
    Vec3 voxelCentre(int i, int j, int k) const;
    std::uint64_t litVoxelCount() const;
    std::uint64_t bytes() const;  ///< of memory
    /// Values that were not finite, negative irradiance, or beyond half floats' 65504, and were cut to 0 or to that.
    std::uint64_t repairedValues() const;

    const VolumeData& data() const { return *data_; }
    std::shared_ptr<const VolumeData> share() const { return data_; }

private:
    std::shared_ptr<const VolumeData> data_;
};

/// Reads a `.nvdb` file: NanoVDB 32.x, plain or packed by Blosc (`photic export` writes both), with a Vec4f grid `flux`
/// (flux.xyz, irradiance), or scalar grids `irradiance`, `flux_x`, `flux_y`, `flux_z`, or `irradiance` and `direction`
/// as nanovdb_convert makes them of a
/// `.vdb`; in colour also `irradiance_rgb`, or `irradiance_r`, `irradiance_g`, `irradiance_b`. Every length and offset
/// in the file is checked before it is used. docs/runtime.md lists what else may be in it.
/// @return Error{File}, Error{Format}, Error{Limit} or Error{Memory}
Result<Volume> loadVolume(const std::string& path, const LoadOptions& options = {});

/// The same from memory, which is not needed afterwards.
Result<Volume> readVolume(const void* bytes, std::size_t size, const LoadOptions& options = {});

}  // namespace photic::runtime
