// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>

#include "photic/result.h"
#include "photic/runtime_gl.h"

/// Water that nobody baked: what a game falls back to, and what moves. From the heights of a water surface and one sun:
///   - a look at the surface's slopes (Guerin and Izumi; GPU Gems): a texture read per point, any receiver, no state;
///   its
///     bright lines are not where the light is (docs/runtime.md has the figures);
///   - a caustic map: the surface's mesh carried along its refracted rays to level layers, energy kept;
///   - warped volumes (Ernst et al. 2005): every triangle's beam drawn over the receivers, no map and no layers.
/// Metres, Z up, world axes throughout. One object belongs to one GL context and is used where that is current.
namespace photic::runtime {

/// What lies beyond the heights' rectangle.
enum class WaterOutside {
    Flat,     ///< still water at the level
    Periodic  ///< the same again
};

/// Heights over a level rectangle.
struct WaterHeights {
    const float* heights = nullptr;  ///< [m] over the level; rows of x, lowest y first; read during the call only
    int columns = 0, rows = 0;  ///< 4 or more; sample (i, j) is at corner + (i + 1/2, j + 1/2) * size / (columns, rows)
    float corner[2] = {0, 0};   ///< lower x and y [m]
    float size[2] = {1, 1};     ///< [m]
    float level = 0;            ///< z [m]
    WaterOutside outside = WaterOutside::Flat;
};

struct WaterLight {
    float direction[3] = {0, 0, -1};           ///< of travel, in air; downwards, any length
    float irradiance[3] = {1000, 1000, 1000};  ///< across the beam, in air [W/m2]
    float extinction[3] = {0, 0, 0};           ///< of the water [1/m]
    float ior = 1.333f;                        ///< of the water over the air's; above 1
};

/// Which slopes a look-up reads.
enum class LookupProjection {
    AlongLight,  ///< where the sun's light in still water comes from
    TriPlanar    ///< as in the paper: at the position's own x y, x z and y z, mixed by the receiver's normal
};
/// How much light a look-up's mean keeps.
enum class LookupGain {
    KeepMean,  ///< that of still water, for Gaussian slopes
    Fixed      ///< `gain`, as in the paper
};
/// How misalignment is measured, a in omega = exp(-tau a^2).
enum class LookupAxes {
    One = 1,  ///< as in the paper: one axis across the light, which sees one of the two slopes
    Both = 2
};

struct LookupOptions {
    LookupAxes axes = LookupAxes::Both;
    LookupProjection projection = LookupProjection::AlongLight;
    LookupGain gain_mode = LookupGain::KeepMean;
    float gain = 1;
    float tightening = 150;             ///< tau at the surface; higher is narrower
    float tightening_per_metre = 0.5f;  ///< tau grows by this part of itself with each metre of depth
    float reflected = 0;  ///< 0..1, weight of the ray that bounces below the surface (the paper's second term)
    /// God rays: samples where eye rays cross planes that stand in the world and lean with the light.
    float plane_distance = 0.25f;  ///< [m]
    float plane_fade = 0.3f;       ///< [m] below the surface over which samples fade in; above 0
    int plane_samples = 32;        ///< at most
    float ray_strength = 1;        ///< radiance per irradiance and gamma [m/sr]
};

struct CausticMapOptions {
    float bottom = -1, top = 0;   ///< z of the deepest and the highest layer [m]; the highest may be at the level
    int layers = 8;               ///< 1: only `bottom`, right for one level floor
    int resolution = 512;         ///< texels a side, over the water's rectangle
    bool full_precision = false;  ///< 32-bit instead of 16-bit floats
};

struct WarpedVolumesOptions {
    float bottom = -1;                ///< z [m] that the volumes reach down to: below every receiver
    int step = 1;                     ///< samples of the heights from one corner of a volume to the next
    float scattering[3] = {0, 0, 0};  ///< of the water [1/m]; 0: light on receivers only
    float anisotropy = 0;             ///< Henyey-Greenstein g, -1 to 1, both excluded
    MoverShadows shadows;  ///< each beam ends where a mover covers it (photic/movers.h: its surface, sun and ior too)
};

/// Water under a sun. ReceiverPass::drawLit (photic/runtime_gl.h) lights receivers with it.
class LiveWater {
public:
    /// @return Error{Unsupported}, Error{Shader}
    static Result<LiveWater> create(const GpuContext& context);
    LiveWater(LiveWater&&) noexcept;
    LiveWater& operator=(LiveWater&&) noexcept;
    ~LiveWater();  ///< deletes the GL objects: the context must be current, or abandon() called before

    /// Uploads heights and their slopes. Call again as the water moves; the same size takes no new memory.
    /// @return Error{Usage} for sizes or numbers that make no sense, Error{Limit}, Error{Memory}
    Status setHeights(const WaterHeights& heights);
    /// @return Error{Usage} for a light from below, an index not above 1, numbers that are not finite
    Status setLight(const WaterLight& light);
    Status setLookup(const LookupOptions& options);

    /// Traces the mesh (one vertex a sample of the heights) and draws the layers. After setHeights and setLight.
    /// GL state is put back.
    Status updateCausticMap(const CausticMapOptions& options);
    bool hasCausticMap() const;

    /// Adds the look-up's god rays: `ray_strength` x the sun's irradiance x gamma, the paper's equation 2. Needs depth
    /// only. Movers take of each sample what they take of light in still water there.
    /// @return Error{Usage}, Error{Shader}
    Status drawGodRays(const GBuffer& surfaces, const Target& target, const MoverShadows& shadows = {});

    /// Adds the radiance of receivers and of scattering water that the refracted light gives them [W/m2/sr]: each
    /// triangle of the water is drawn as the bounding prism of its beam, each pixel in it tested, one pass. One
    /// refraction, as in the paper, and no shadows but those of movers. Cost: the prisms' pixels, some hundreds deep
    /// where the water is finely meshed.
    /// @param clip_from_world  projection * view, column by column, of which `surfaces` has the inverse
    Status drawWarpedVolumes(const GBuffer& surfaces, const float* clip_from_world, const Target& target,
                             const WarpedVolumesOptions& options);

    /// The context is lost: forgets all GL names without deleting them. Create and fill anew.
    void abandon();

    /// Bytes of GPU memory held by textures and buffers.
    std::size_t gpuBytes() const;

    struct Impl;
    Impl& impl() { return *impl_; }
    const Impl& impl() const { return *impl_; }

private:
    explicit LiveWater(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace photic::runtime
