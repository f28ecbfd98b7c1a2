// SPDX-License-Identifier: Apache-2.0
#pragma once

// Photic's runtime, GPU half: light volumes on the GPU, and the passes that shade with them. OpenGL 4.3 or ES 3.1.
//
//     auto gpu = photic::runtime::GpuContext::create(loader);
//     auto light = photic::runtime::GpuVolume::upload(*gpu, volume);
//     auto receivers = photic::runtime::ReceiverPass::create(*gpu);
//     ...each frame: receivers->draw(g_buffer, target, {{&*light}});
//
// All of it belongs to one GL context and is used where that is current. GL's state is as it was after every call, and
// errors that the game left pending are forgotten. Nothing throws. Objects delete their GL names when they are
// destroyed, which needs the context; after it is lost, call abandon() on each and create them anew.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "photic/gl_context.h"
#include "photic/movers.h"
#include "photic/result.h"
#include "photic/runtime.h"
#include "photic/sequence.h"
#include "photic/volume_bytes.h"

namespace photic::runtime {

struct GlFunctions;
class GpuUpload;
class LiveBake;

/// GL's functions and limits, shared by all that is made with it. Copies are the same context.
class GpuContext {
public:
    /// @return Error{Unsupported} for less than OpenGL 4.3 or ES 3.1
    static Result<GpuContext> create(const GlLoader& loader);
    const GlFunctions& gl() const { return *gl_; }
    std::string renderer() const;

private:
    explicit GpuContext(std::shared_ptr<const GlFunctions> gl) : gl_(std::move(gl)) {}
    std::shared_ptr<const GlFunctions> gl_;
};

/// A light volume on the GPU.
class GpuVolume {
public:
    /// Tries layouts until one fits the budget and GL's limits, then coarser voxels. The volume is not needed
    /// afterwards, except to upload it again after the context was lost.
    /// @return Error{Limit}, Error{Memory}
    static Result<GpuVolume> upload(const GpuContext& context, const Volume& volume, const UploadOptions& options = {});

    GpuVolume(GpuVolume&&) noexcept;
    GpuVolume& operator=(GpuVolume&&) noexcept;
    ~GpuVolume();

    const UploadInfo& info() const;

    /// The second lobe (Volume::secondLobe), or null. The passes draw both; a shader of the game's adds them up as it
    /// does two volumes (docs/runtime.md).
    GpuVolume* secondLobe();

    /// Binds textures to units `first_texture`, + 1 and + 2, the parameters to uniform buffer binding `first_buffer`
    /// and bricks in a buffer to storage buffer binding `first_buffer`, for a shader of the game's that includes
    /// volumeGlsl(). This state stays bound.
    /// @param weight  factor on the light, for blending frames or dimming
    void bind(unsigned first_texture = 0, unsigned first_buffer = 0, float weight = 1);

    /// The context is lost: forgets all GL names without deleting them.
    void abandon();

    struct Impl;
    Impl& impl() { return *impl_; }
    const Impl& impl() const { return *impl_; }

private:
    friend class GpuUpload;
    friend class LiveBake;
    explicit GpuVolume(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

enum class NormalEncoding {
    Signed,   ///< the texture holds -1 to 1
    Unsigned  ///< it holds (n + 1) / 2
};
enum class ClipDepth { NegativeOneToOne, ZeroToOne };

/// What a game has drawn: the surfaces that are seen. Textures are 2D, of one size, read without filtering.
struct GBuffer {
    unsigned depth = 0;    ///< window depth, 0 to 1, in the red channel of a depth or a float texture
    unsigned normals = 0;  ///< world normals, towards the camera's side; need not be unit; not needed for media
    unsigned albedo = 0;   ///< linear; 0: white
    NormalEncoding normal_encoding = NormalEncoding::Signed;
    ClipDepth clip_depth = ClipDepth::NegativeOneToOne;  ///< as glClipControl was when depth was drawn
    float empty_depth = 1;                               ///< where nothing was drawn: 1, or 0 when depth is reversed
    float world_from_clip[16] = {};                      ///< inverse of projection * view, column by column
    float camera[3] = {};                                ///< [m], world
};

/// Where a pass draws: color attachment 0, a float texture as a rule.
struct Target {
    unsigned framebuffer = 0;
    int x = 0, y = 0, width = 0, height = 0;  ///< [pixels]; stands for the whole of the GBuffer's textures
};

/// One of the volumes that light a scene. Light adds up: over lights, and over two frames with weights that sum to 1.
struct LitVolume {
    GpuVolume* volume = nullptr;
    float weight = 1;
};

/// A sequence on the GPU: the two frames that are shown, uploaded as they come.
class GpuSequence {
public:
    /// @param bytes_a_call  that at() sends to the GPU at most, about: of the frames that are shown, then of the next
    /// one
    GpuSequence(const GpuContext& context, VolumeSequence sequence, const UploadOptions& options = {},
                std::uint64_t bytes_a_call = std::uint64_t{4} << 20);
    GpuSequence(GpuSequence&&) noexcept;
    GpuSequence& operator=(GpuSequence&&) noexcept;
    ~GpuSequence();

    /// The volumes to draw with at a time, with weights that add up to 1; none while no frame is on the GPU yet. They
    /// are the sequence's and last until the next call. Frames that do not load are stood in for as VolumeSequence::at
    /// says; while those of this time are on their way to the GPU, the ones shown before stay. WhenLate::Wait sends all
    /// that is missing at once. Ask each frame of the game: each call sends a part of what comes next.
    /// @return the error when no frame loads, or of one that does not fit the GPU
    Result<std::vector<LitVolume>> at(double seconds, WhenLate when_late = WhenLate::ShowNearest);
    void abandon();

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// What darkens the light of volumes while it is drawn.
struct MoverShadows {
    const Movers* movers = nullptr;  ///< null: nothing does
    unsigned map = 0;                ///< 2D texture RG32F of Movers::map, where there is one
};

enum class ReceiverOutput {
    Radiance,   ///< of diffuse surfaces: albedo / pi * E [W/(m2 sr)]
    Irradiance  ///< E [W/m2]
};

struct ReceiverOptions {
    ReceiverOutput output = ReceiverOutput::Radiance;
    /// Factor on the result: (n_camera / n_receiver)^2 for receivers in water seen from air (docs/light_volume.md).
    float scale = 1;
    MoverShadows shadows;  ///< on the light of volumes, and of water without a bake
};

class LiveWater;

/// Where light on receivers comes from: the switch by which a game falls back where nothing was baked.
enum class LightSource {
    Best,        ///< the first of the others that there is
    Baked,       ///< volumes
    CausticMap,  ///< of water that moves (photic/runtime_water.h)
    Lookup       ///< at the water's slopes
};

/// What lights a scene.
struct Lighting {
    LightSource source = LightSource::Best;
    std::vector<LitVolume> volumes;
    const LiveWater* water = nullptr;
};

/// Adds the light of the volumes to the surfaces of a G-buffer (blending with 1, 1).
class ReceiverPass {
public:
    /// @return Error{Shader}
    static Result<ReceiverPass> create(const GpuContext& context);
    ReceiverPass(ReceiverPass&&) noexcept;
    ReceiverPass& operator=(ReceiverPass&&) noexcept;
    ~ReceiverPass();

    /// @return Error{Usage} for a G-buffer without depth or normals or a target without pixels, Error{Shader}
    Status draw(const GBuffer& surfaces, const Target& target, const std::vector<LitVolume>& volumes,
                const ReceiverOptions& options = {});
    /// The same by whatever `lighting` chooses. What it gives is drawn alike: a receiver does not know its source.
    /// @return Error{Usage} also when the chosen source is not there
    Status drawLit(const GBuffer& surfaces, const Target& target, const Lighting& lighting,
                   const ReceiverOptions& options = {});
    void abandon();

    struct Impl;

private:
    explicit ReceiverPass(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

enum class StepJitter {
    Middle,   ///< no noise; banded when steps are few
    PerPixel  ///< noise that is even over neighbouring pixels, and over frames when `frame` counts up
};
enum class Skipping {
    Automatic,  ///< DarkPages, unless nearly all blocks have light and looking for dark ones costs more than it saves
    DarkPages,
    Nothing
};
enum class MediumResolution {
    Full,
    Halved  ///< a quarter of the rays; spread to the pixels by how near their surfaces are
};
enum class Extinction {
    Applied,  ///< what is behind the medium is dimmed by it
    Left      ///< to the game
};

/// A homogeneous medium that the light shines through.
struct MediumOptions {
    float scattering[3] = {0, 0, 0};  ///< [1/m]
    float absorption[3] = {0, 0, 0};  ///< [1/m]
    float anisotropy = 0;             ///< g of Henyey-Greenstein, -1 to 1, both excluded
    /// The medium is where dot(xyz, world) <= w: {0, 0, 1, level} is water below z = level. Everywhere by default.
    float surface[4] = {0, 0, 0, 1};
    int steps = 32;
    StepJitter jitter = StepJitter::Middle;
    int frame = 0;
    Skipping skipping = Skipping::Automatic;  ///< the same picture, bit by bit
    MediumResolution resolution = MediumResolution::Full;
    Extinction extinction = Extinction::Applied;
    float scale = 1;  ///< factor on the scattered light
    MoverShadows shadows;
};

/// The medium that volumes were baked with, as their metadata say: its coefficients, below its surface. Of a Volume's
/// own metadata the surface is always known; set `surface` where the medium fills something else than the water below a
/// level.
MediumOptions mediumOf(const Metadata& metadata);

/// Dims what a G-buffer shows by a medium in front of it and adds the light that the medium scatters once towards the
/// camera, which is a perspective one.
class MediumPass {
public:
    /// @return Error{Shader}
    static Result<MediumPass> create(const GpuContext& context);
    MediumPass(MediumPass&&) noexcept;
    MediumPass& operator=(MediumPass&&) noexcept;
    ~MediumPass();

    /// @return Error{Usage} for a G-buffer without depth, a target without pixels, or a medium that is none;
    /// Error{Shader}, Error{Memory}
    Status draw(const GBuffer& surfaces, const Target& target, const std::vector<LitVolume>& volumes,
                const MediumOptions& options);
    void abandon();

    struct Impl;

private:
    explicit MediumPass(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace photic::runtime
