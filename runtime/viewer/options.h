// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "runtime/viewer/renderer.h"

namespace photic::viewer {

/// What the command line asks for.
struct Options {
    std::string scene;                 ///< .toml; may be empty
    std::vector<std::string> volumes;  ///< .vdb or .nvdb, at most two; #### is the frame
    std::vector<std::string> objects;  ///< .ivol
    std::string environment;           ///< .exr; empty: a studio
    std::string screenshot;            ///< .png; empty: a window
    int width = 1280, height = 800;
    int supersample = 2;  ///< screenshots: pixels a side of a pixel
    int first_frame = 1, last_frame = 1;
    std::optional<Source> left, right;
    std::optional<float> split;
    std::optional<glm::vec3> eye, target;
    std::optional<float> field_of_view_deg, scattering, anisotropy;
    std::optional<glm::vec4> ball;  ///< centre and radius [m]
    float exposure = 1, tile_size = 0;
    std::optional<float> ambient;
    float turn_deg = 0;  ///< of the environment
    bool surface = true;
    bool bake = false;           ///< the scene, at first and when its light is moved
    std::string bake_arguments;  ///< more of `photic bake`, with spaces between
    bool watch = false;          ///< bake again when the scene's files change
    std::string light;           ///< by name: the one that is moved; empty: the brightest that can be
    std::optional<glm::vec3> light_direction, light_position;
    int frames_to_draw = 0;  ///< after which the window closes; 0: never
};

/// @return nothing when the command line was answered (--help)
/// @throws Error{Usage}
std::optional<Options> parseOptions(int argc, const char* const* argv);

}  // namespace photic::viewer
