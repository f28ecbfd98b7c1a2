// SPDX-License-Identifier: Apache-2.0
#pragma once

// Photic's runtime: objects whose index of refraction varies, as eye rays see them. OpenGL 4.3 or ES 3.1.
//
//     auto glass = photic::runtime::loadIndexVolumes("glass.ivol");
//     auto objects = photic::runtime::GpuIndexVolumes::upload(*gpu, *glass);
//     auto bent = photic::runtime::BentRayPass::create(*gpu);
//     ...each frame, after what is opaque:
//     bent->draw(g_buffer, target, *objects, {{0}}, surroundings);
//
// After Ihrke et al., Eikonal Rendering (SIGGRAPH 2007), sections 4.1 and 5.3. Belongs to one GL context, as all of
// photic/runtime_gl.h does.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "photic/index_volume.h"
#include "photic/runtime_gl.h"

namespace photic::runtime {

/// Objects on the GPU, all in one atlas.
class GpuIndexVolumes {
public:
    struct Info {
        int objects = 0;
        std::array<int, 3> texels{0, 0, 0};  ///< of the atlas
        std::uint64_t bytes = 0;             ///< of GPU memory
        double even = 0;                     ///< share of the blocks of 2^3 nodes that are passed over
    };
    /// @return Error{Usage} without objects, Error{Limit} when no texture holds them, Error{Memory}
    static Result<GpuIndexVolumes> upload(const GpuContext& context, const std::vector<IndexVolume>& objects);
    GpuIndexVolumes(GpuIndexVolumes&&) noexcept;
    GpuIndexVolumes& operator=(GpuIndexVolumes&&) noexcept;
    ~GpuIndexVolumes();

    const Info& info() const;
    /// The context is lost: forgets all GL names without deleting them.
    void abandon();

    struct Impl;
    const Impl& impl() const { return *impl_; }

private:
    explicit GpuIndexVolumes(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

/// One of the objects in the world; the same one may stand in several places.
struct PlacedObject {
    unsigned object = 0;  ///< by its number in what was uploaded
    /// Moves it from where its file puts it, column by column: affine, with an inverse.
    std::array<float, 16> world_from_object{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
};

/// Radiance from all directions as nine spherical harmonics, per channel: the integral over all directions of radiance
/// times Y_lm, real, in the order (0, 0), (1, -1), (1, 0), (1, 1), (2, -2) ... (2, 2), Z up. All that a matte face sees
/// of it (Ramamoorthi and Hanrahan, An Efficient Representation for Irradiance Environment Maps, SIGGRAPH 2001).
using Harmonics = std::array<std::array<float, 3>, 9>;

/// Those of an environment by longitude and latitude, as Surroundings::environment has it: four floats a texel, row 0
/// looks down.
Harmonics environmentHarmonics(const float* rgba, int width, int height);

/// What is behind and around the objects.
struct Surroundings {
    /// 2D texture of all directions by longitude and latitude, Z up, its middle along +x and its left half towards +y
    /// [W/(m2 sr)]; 0: `colour` everywhere. Filtered as it says itself.
    unsigned environment = 0;
    float colour[3] = {1, 1, 1};  ///< factor on the environment
    float turn = 0;               ///< of the environment about z [radians]
    /// Of `environment`: needed where a face of an object has an albedo. Without an environment `colour` is enough.
    std::optional<Harmonics> harmonics{};
    /// What has been drawn without the objects: where a bent ray meets a surface of the G-buffer, it sees this. Of the
    /// G-buffer's size, not the target's own texture. 0: the environment alone.
    unsigned radiance = 0;
};

enum class BentIntegrator {
    DriftKickDrift,  ///< one look a step, second order, steps by the gradient
    Euler            ///< the paper's equations 11 and 12: steps of one length, first order, without faces
};
enum class IndexLookup {
    Spline,    ///< the bake's cubic spline with its exact gradient: 17 reads
    Gradients  ///< value and gradient at nodes, in half floats, filtered: one read, as the paper's
};
enum class BentSkipping {
    Even,  ///< blocks that bend nothing and are alike are passed over: the same bits, sooner
    None
};
enum class BentRadiance {
    Conserved,  ///< every term times (n_eye / n_there)^2
    Paper       ///< without
};

struct BentRayOptions {
    BentIntegrator integrator = BentIntegrator::DriftKickDrift;
    IndexLookup lookup = IndexLookup::Spline;
    BentSkipping skipping = BentSkipping::Even;
    BentRadiance radiance = BentRadiance::Conserved;
    float step = 1;     ///< longest [nodes]
    float turn = 0.1f;  ///< of a step at most, about [radians]
    int steps = 2048;   ///< of a pixel's rays together; what is left then sees the environment
    int branches = 4;   ///< reflected rays kept to be followed, 0 to 4; the others see the environment at once
    float faintest =
        0.01f;  ///< share of a pixel's light below which a reflected ray is not followed, but sees the environment
    bool disperses = true;  ///< objects with three indices: one ray for each colour
};

/// Draws what is seen through and in index volumes: refracted and reflected surroundings, coloured attenuation,
/// emission, the light of light volumes that the objects scatter, and what matte or rough faces send back of it.
/// Objects are seen through objects; those with a shape (IndexVolume::shape) end at its sharp faces.
class BentRayPass {
public:
    static constexpr int kMostObjects = 16;

    /// @return Error{Shader}
    static Result<BentRayPass> create(const GpuContext& context);
    BentRayPass(BentRayPass&&) noexcept;
    BentRayPass& operator=(BentRayPass&&) noexcept;
    ~BentRayPass();

    /// Replaces the pixels that see an object, with alpha 1; all others stay as they are. Of the G-buffer depth (0:
    /// there is nothing opaque), world_from_clip and camera are needed. Objects that overlap add up; one with sharp
    /// sides must not overlap others. What is opaque inside of an object's box is seen only where the ray to it is
    /// straight.
    /// @param light  of the world; what scattering objects and faces show of it
    /// @return Error{Usage} for what makes no sense, Error{Shader}
    Status draw(const GBuffer& surfaces, const Target& target, const GpuIndexVolumes& objects,
                const std::vector<PlacedObject>& placed, const Surroundings& surroundings,
                const std::vector<LitVolume>& light = {}, const BentRayOptions& options = {});

    /// For a shader of the game's own that includes bentGlsl(): binds the objects' textures to units 5 to 10 and 12 and
    /// their parameters to uniform buffer binding 1, where they stay.
    /// @param origin  of the places that photicBentRadiance() takes [m], three numbers: the camera as a rule
    /// @param surroundings  of which only what matte faces see of it counts
    /// @return Error{Usage}
    Status bind(const float* origin, const GpuIndexVolumes& objects, const std::vector<PlacedObject>& placed,
                const BentRayOptions& options = {}, const Surroundings& surroundings = {});

    void abandon();

private:
    struct Impl;
    explicit BentRayPass(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

/// Where a shader finds the objects: numbers as BentRayPass::bind has them.
struct BentBindings {
    unsigned parameters = 1;  ///< uniform buffer
    unsigned faces = 5, gradients = 6, spline = 7, attenuation = 8, glow = 9, blocks = 10;
    unsigned shapes = 12;  ///< declared with BentGlslOptions::shapes alone
};

struct BentGlslOptions {
    BentBindings bindings;
    std::optional<unsigned> vulkan_set;  ///< for Vulkan: the descriptor set; no two bindings are alike then
    IndexLookup lookup = IndexLookup::Spline;
    bool scatters = false;  ///< the light of a volume, by the volumeGlsl() that stands in front
    bool shapes = false;    ///< objects with sharp faces (IndexVolume::shape); without, they are not seen
};

/// GLSL for a game's own shader, to be put behind its #version: photicBentRadiance(), photicBentAt() and what they need
/// (runtime/shaders/photic_bent.glsl, photic_bent_trace.glsl). The game defines, behind it,
///     vec3 photicEnvironment(vec3 direction)
///     bool photicNearby(vec3 from, vec3 direction, float limit, out vec3 radiance)   // false: nothing opaque is met
std::string bentGlsl(const BentGlslOptions& options = {});

}  // namespace photic::runtime
