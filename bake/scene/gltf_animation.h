// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bake/scene/gltf_json.h"
#include "bake/scene/gltf_model.h"

namespace photic {

/// Translation, rotation (a quaternion x, y, z, w) or scale of a node over time: glTF 2.0, appendix C.
struct GltfTrack {
    enum class Path { Translation, Rotation, Scale };
    enum class Between { Linear, Step, CubicSpline };

    Path path = Path::Translation;
    Between between = Between::Linear;
    std::vector<double> times;  ///< [s], rising
    /// Of each time a value; of a spline the tangent before it [1/s], the value, and the tangent behind it.
    std::vector<glm::dvec4> values;
    std::string animation;  ///< its name

    /// The value at a time; that of the first or last key outside of them. Rotations are unit.
    glm::dvec4 at(double seconds) const;
};

/// The nodes of a glTF as they stand and as its animations move them, all of which play at once. A scene's frame f
/// shows them at f / frame_rate seconds.
class GltfAnimation {
public:
    /// @param root  the file's JSON
    /// @throws Error{Input} for channels that are damaged: without a node or sampler, with times that do not rise, with
    ///         another count of values than their times ask for, of unknown paths and ways
    GltfAnimation(const gltf::Json& root, const GltfModel& model, double frame_rate);

    /// That a node of the scene hangs from another.
    void hang(std::size_t child, std::size_t parent) { parent_[child] = parent; }

    /// From a node's axes to the world's (Y up), at rest.
    glm::dmat4 worldFromNode(std::size_t node) const;
    /// Whether it, or something that it hangs from, moves.
    bool moves(std::size_t node) const { return !tracksOf(node).empty(); }

    /// `keyframes = [...]` of a shape that the file holds where it rests, a key a frame; empty where it stays there.
    /// @param name    for messages
    /// @param places  is given world_from_rest (Z up) of each keyframe
    /// @throws Error{Input} where it is scaled or sheared on the way
    std::string placementKeyframes(std::size_t node, const std::string& name,
                                   const std::function<void(const glm::dmat4& world_from_rest)>& places);
    /// The same of a lamp: `position` and `direction` (along its -z), each where it is wanted and changes.
    std::string lightKeyframes(std::size_t node, bool position, bool direction);

    /// What is left out, and which frames show the motion that was asked for: a sentence each.
    std::vector<std::string> notes() const;

private:
    using Tracks = std::vector<const GltfTrack*>;
    struct Frames {
        int first = 0, last = 0;
    };

    void readChannel(const gltf::Json& channel, const gltf::Json& animation, const std::string& name);
    Tracks tracksOf(std::size_t node) const;
    glm::dmat4 worldFromNode(std::size_t node, double seconds) const;
    glm::dmat4 parentFromNode(std::size_t node, std::optional<double> seconds) const;
    Frames framesOf(const Tracks& tracks, const std::string& name);
    [[noreturn]] void failDistorted(std::size_t node, const std::string& name) const;

    const gltf::Json& root_;
    const GltfModel& model_;
    double frame_rate_;
    std::map<std::size_t, std::size_t> parent_;
    std::map<std::pair<std::size_t, GltfTrack::Path>, GltfTrack> tracks_;
    std::vector<std::string> notes_;
    std::map<std::string, std::size_t> left_out_;  ///< channels by what they move
    std::optional<Frames> shown_;
};

}  // namespace photic
