// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/mat4x4.hpp>
#include <memory>
#include <string>
#include <vector>

#include "photic/gl_context.h"
#include "photic/index_volume.h"
#include "photic/result.h"
#include "photic/runtime.h"
#include "runtime/viewer/environment.h"
#include "runtime/viewer/stage.h"

namespace photic::viewer {

/// What lights one half of the picture.
enum class Source { BakedA, BakedB, LiveBake, CausticMap, Lookup, WarpedVolumes, None };
inline constexpr const char* kSourceNames[] = {"baked",   "baked B",        "live bake", "caustic map",
                                               "look-up", "warped volumes", "none"};

struct Camera {
    glm::vec3 eye{3}, target{0};
    float field_of_view_deg = 34;
};

struct Picture {
    Camera camera;
    Source left = Source::BakedA, right = Source::BakedA;
    float split = 0;     ///< part of the width that shows `left`; 0 or 1: one picture
    float exposure = 1;  ///< times what suits unfocused light
    float ambient = 0.06f;
    float tile_size = 0;  ///< [m]
    glm::vec3 albedo{0.80f, 0.82f, 0.84f};
    glm::vec3 ball_centre{0};
    float ball_radius = 0;                   ///< [m]; 0: no ball
    glm::vec3 scattering{0}, extinction{0};  ///< [1/m]
    float anisotropy = 0;
    int steps = 64;          ///< of the march through a medium
    float tightening = 150;  ///< of the look-up
    int warped_step = 3;
    bool surface = true;  ///< show the water's surface
    float turn = 0;       ///< of the environment about z [radians]
    bool objects = true;  ///< show what is seen through
    bool exact = false;   ///< eight-fetch sampling of baked volumes
};

/// Draws a stage, lit by what a Picture says, into framebuffers of any size. Belongs to one GL context.
class Renderer {
public:
    static runtime::Result<std::unique_ptr<Renderer>> create(const runtime::GlLoader& loader);
    virtual ~Renderer() = default;

    /// Shows another stage. Also takes its water's heights and sun.
    virtual runtime::Status setStage(const Stage& stage) = 0;
    /// Volume A (0) or B (1).
    virtual runtime::Status setVolume(int index, const runtime::Volume& volume) = 0;
    /// Another one instead, a few megabytes at each bringVolume(), so that no frame waits for it. The old one is shown
    /// until then. One that is on its way is forgotten.
    virtual runtime::Status sendVolume(int index, const runtime::Volume& volume) = 0;
    /// @return true once it is shown, or where none is on its way
    virtual runtime::Result<bool> bringVolume() = 0;
    /// Another sun over the stage's water, for what is not baked.
    virtual runtime::Status setLight(const runtime::WaterLight& light) = 0;
    /// Objects that are seen through: at most 16.
    virtual runtime::Status setObjects(const std::vector<runtime::IndexVolume>& objects) = 0;
    /// What is around them.
    virtual void setEnvironment(const Environment& environment) = 0;
    virtual bool hasObjects() const = 0;
    /// Draws into the framebuffer's lower left corner.
    virtual runtime::Status draw(const Picture& picture, unsigned framebuffer, int width, int height) = 0;
    /// Whether a source has what it needs.
    virtual bool has(Source source) const = 0;
    virtual std::string device() const = 0;
};

}  // namespace photic::viewer
