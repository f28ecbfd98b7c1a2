// SPDX-License-Identifier: Apache-2.0
#pragma once

// Light under water that moves, baked anew each frame on the GPU: a GpuVolume like any other, without a file.
//
//     auto water = photic::runtime::LiveWater::create(*gpu);      // photic/runtime_water.h
//     auto bake = photic::runtime::LiveBake::create(*gpu, {.min = {-2, -2, -1.6f}, .max = {2, 2, 0.2f}});
//     ...each frame:
//     water->setHeights(heights);
//     bake->update(*water);
//     receivers->draw(surfaces, target, {{&bake->volume()}});     // look-ups, media, movers: as with a baked volume
//
// What it is: the baker's `beams` for one sun and one refraction, with the sun's disc and absorption: every triangle of
// the water's mesh lays its power into the voxels that it covers in each layer, by exact area. What it leaves out: what
// stands in the water (photic/movers.h), light that is reflected. Belongs to one GL context, as all of
// photic/runtime_gl.h does. Needs compute shaders (OpenGL 4.3, ES 3.1), and storage blocks of the size that gpuBytes()
// tells; where there are none, LiveWater's caustic map is the fallback.

#include <array>
#include <memory>

#include "photic/runtime_gl.h"
#include "photic/runtime_water.h"

namespace photic::runtime {

struct LiveBakeOptions {
    /// Corners of the box [m]. Under water that is periodic the box is as wide and deep as the water, and repeats.
    std::array<float, 3> min{-1, -1, -1}, max{1, 1, 0.1f};
    std::array<int, 3> voxels{128, 128, 128};
    float angular_diameter_deg = 0.53f;  ///< of the sun; 0: a point
};

class LiveBake {
public:
    /// @return Error{Usage} for a box or numbers that make no sense, Error{Limit} for more than the GPU takes,
    /// Error{Memory}, Error{Shader}
    static Result<LiveBake> create(const GpuContext& context, const LiveBakeOptions& options);
    LiveBake(LiveBake&&) noexcept;
    LiveBake& operator=(LiveBake&&) noexcept;
    ~LiveBake();

    /// Bakes the light of the water as it is now. Dispatches, and waits for nothing. After LiveWater::setHeights and
    /// setLight. The same water gives the same bits.
    /// @return Error{Usage} where the water has no heights, or is periodic and the box is not its rectangle
    Status update(LiveWater& water);

    /// Dark before the first update(). Coloured where the sun or the water is, which an update() may change.
    GpuVolume& volume();
    std::uint64_t gpuBytes() const;
    /// The context is lost: forgets all GL names without deleting them.
    void abandon();

    struct Impl;
    const Impl& impl() const { return *impl_; }

private:
    explicit LiveBake(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace photic::runtime
