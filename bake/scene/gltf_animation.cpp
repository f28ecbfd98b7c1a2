// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/gltf_animation.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <glm/ext/quaternion_double.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>
#include <numbers>

#include "bake/report/error.h"
#include "bake/scene/plain_text.h"

namespace photic {

using gltf::Json, gltf::memberOf, gltf::textOf, gltf::vectorOf;

namespace {

constexpr int kMostFrames = 100'000;  // of one body: as many keyframes, a minute of reading
constexpr double kRigid = 1e-4;       // of lengths and angles: files hold single precision
constexpr double kDegree = std::numbers::pi / 180;

glm::dquat quaternion(const glm::dvec4& v) { return {v.w, v.x, v.y, v.z}; }
glm::dvec4 numbersOf(const glm::dquat& q) { return {q.x, q.y, q.z, q.w}; }

/// Z up from Y up.
const glm::dmat4& zUpMatrix() {
    static const glm::dmat4 turn(glm::dvec4(1, 0, 0, 0), glm::dvec4(0, 0, 1, 0), glm::dvec4(0, -1, 0, 0),
                                 glm::dvec4(0, 0, 0, 1));
    return turn;
}

/// Degrees about x, then y, then z, as placement.h turns.
glm::dvec3 anglesOf(const glm::dmat3& m) {
    const double y = std::asin(std::clamp(-m[0][2], -1.0, 1.0));
    // Straight up or down x and z turn about one axis, and z does it alone.
    const bool upright = std::hypot(m[0][0], m[0][1]) < 1e-9;
    const double x = upright ? 0 : std::atan2(m[1][2], m[2][2]),
                 z = upright ? std::atan2(-m[1][0], m[1][1]) : std::atan2(m[0][1], m[0][0]);
    return glm::dvec3(x, y, z) / kDegree;
}

bool isRigid(const glm::dmat3& m) {
    const glm::dmat3 should_be_one = glm::transpose(m) * m;
    double worst = 0;
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) worst = std::max(worst, std::fabs(should_be_one[c][r] - (c == r)));
    return worst < kRigid;
}

/// Adding 0 makes 0 of -0.
std::string longNumbers(const glm::dvec3& v) {
    return fmt::format("[{:.13g}, {:.13g}, {:.13g}]", v.x + 0.0, v.y + 0.0, v.z + 0.0);
}

/// Vectors of one key at frames that follow one another.
struct Curve {
    const char* key;
    std::vector<glm::dvec3> values;
    bool stays() const {
        return std::all_of(values.begin(), values.end(), [&](const glm::dvec3& v) { return same(v, values.front()); });
    }
    /// Whether a frame says nothing that its neighbours don't.
    bool rests(std::size_t i) const {
        return i > 0 && i + 1 < values.size() && same(values[i], values[i - 1]) && same(values[i], values[i + 1]);
    }
    static bool same(const glm::dvec3& a, const glm::dvec3& b) {
        return glm::length(a - b) <= 1e-9 * std::max(1.0, glm::length(a));
    }
};

std::string keyframesText(int first, const std::vector<Curve>& curves) {
    if (curves.empty()) return {};
    std::string out = "keyframes = [\n";
    for (std::size_t i = 0; i < curves.front().values.size(); ++i) {
        if (std::all_of(curves.begin(), curves.end(), [i](const Curve& curve) { return curve.rests(i); })) continue;
        out += fmt::format("  {{ frame = {}", first + static_cast<int>(i));
        for (const Curve& curve : curves) out += fmt::format(", {} = {}", curve.key, longNumbers(curve.values[i]));
        out += " },\n";
    }
    return out + "]\n";
}

}  // namespace

glm::dvec4 GltfTrack::at(double seconds) const {
    const std::size_t step = between == Between::CubicSpline ? 3 : 1, value = between == Between::CubicSpline ? 1 : 0;
    const auto key = [&](std::size_t i) { return values[step * i + value]; };
    const auto unit = [&](const glm::dvec4& v) { return path == Path::Rotation ? glm::normalize(v) : v; };
    const auto next = std::upper_bound(times.begin(), times.end(), seconds);
    if (next == times.begin()) return unit(key(0));
    if (next == times.end()) return unit(key(times.size() - 1));
    const auto b = static_cast<std::size_t>(next - times.begin()), a = b - 1;
    const double span = times[b] - times[a], t = (seconds - times[a]) / span;
    switch (between) {
        case Between::Step:
            break;
        case Between::Linear:
            if (path != Path::Rotation) return glm::mix(key(a), key(b), t);
            return numbersOf(glm::slerp(quaternion(unit(key(a))), quaternion(unit(key(b))), t));  // the short way
        case Between::CubicSpline: {
            const double t2 = t * t, t3 = t2 * t;
            return unit((2 * t3 - 3 * t2 + 1) * key(a) + span * (t3 - 2 * t2 + t) * values[3 * a + 2] +
                        (3 * t2 - 2 * t3) * key(b) + span * (t3 - t2) * values[3 * b]);
        }
    }
    return unit(key(a));
}

GltfAnimation::GltfAnimation(const Json& root, const GltfModel& model, double frame_rate)
    : root_(root), model_(model), frame_rate_(frame_rate) {
    std::size_t number = 0;
    for (const Json& animation : memberOf(root, "animations")) {
        std::string name = excerpt(textOf(animation, "name"));
        if (name.empty()) name = fmt::format("animation {}", number);
        ++number;
        for (const Json& channel : memberOf(animation, "channels")) readChannel(channel, animation, name);
    }
}

void GltfAnimation::readChannel(const Json& channel, const Json& animation, const std::string& name) {
    const Json& target = memberOf(channel, "target");
    const std::string what = textOf(target, "path");
    const auto fail = [&](const std::string& why) {
        model_.fail(fmt::format("has a damaged animation '{}': {}", name, why));
    };
    if (what == "weights" || what == "pointer") {
        ++left_out_[what == "weights" ? "morph weights" : "what a pointer names"];
        return;
    }
    static const std::map<std::string, GltfTrack::Path> kPaths{{"translation", GltfTrack::Path::Translation},
                                                               {"rotation", GltfTrack::Path::Rotation},
                                                               {"scale", GltfTrack::Path::Scale}};
    const auto path = kPaths.find(what);
    if (path == kPaths.end())
        fail(fmt::format("a channel moves '{}'; translation, rotation, scale and weights can move", excerpt(what)));
    const Json& nodes = memberOf(root_, "nodes");
    const Json& node_index = memberOf(target, "node");
    if (node_index.is_null()) return;  // of an extension: to be ignored, says the standard
    const auto index = [&](const Json& value, const Json& list, const char* of) {
        if (!value.is_number_unsigned() || value.get<std::size_t>() >= list.size())
            fail(fmt::format("a channel refers to {} {}, and there are {}", of, excerpt(value.dump()), list.size()));
        return value.get<std::size_t>();
    };
    const std::size_t node = index(node_index, nodes, "node");
    const Json& samplers = memberOf(animation, "samplers");
    const Json& sampler = samplers.at(index(memberOf(channel, "sampler"), samplers, "sampler"));
    if (!memberOf(nodes[node], "matrix").is_null())
        fail(fmt::format("it moves node {}, which is placed by a matrix; give it translation, rotation and scale",
                         node));

    GltfTrack track;
    track.path = path->second, track.animation = name;
    const std::string between = textOf(sampler, "interpolation");
    if (between == "STEP")
        track.between = GltfTrack::Between::Step;
    else if (between == "CUBICSPLINE")
        track.between = GltfTrack::Between::CubicSpline;
    else if (!between.empty() && between != "LINEAR")
        fail(fmt::format("its keys are joined by '{}'; LINEAR, STEP and CUBICSPLINE are known", excerpt(between)));
    const auto accessor = [&](const char* key) {
        const Json& value = memberOf(sampler, key);
        if (!value.is_number_integer()) fail(fmt::format("a sampler has no '{}'", key));
        return value.get<int>();
    };
    track.times = model_.numbers(accessor("input"), 1, "times of an animation");
    const std::size_t width = track.path == GltfTrack::Path::Rotation ? 4 : 3;
    const std::vector<double> values = model_.numbers(accessor("output"), width, "values of an animation");
    const bool spline = track.between == GltfTrack::Between::CubicSpline;
    const std::size_t wanted = (spline ? 3 : 1) * track.times.size();
    if (values.size() / width != wanted)
        fail(fmt::format("{} times ask for {} values, and a sampler has {}", track.times.size(), wanted,
                         values.size() / width));
    for (std::size_t i = 0; i < track.times.size(); ++i) {
        const bool rises = i == 0 ? track.times[0] >= 0 : track.times[i] > track.times[i - 1];
        if (!rises || !std::isfinite(track.times[i]))
            fail(fmt::format("its times must rise from 0, and key {} is at {:g} s", i, track.times[i]));
    }
    for (std::size_t i = 0; i < wanted; ++i) {
        glm::dvec4 value(0);
        for (std::size_t c = 0; c < width; ++c) value[static_cast<int>(c)] = values[width * i + c];
        const bool is_value = !spline || i % 3 == 1;
        if (!(glm::length(value) < 1e15)) fail(fmt::format("value {} is not a finite number", i));
        if (is_value && width == 4 && !(glm::length(value) > 1e-6)) fail(fmt::format("rotation {} has no length", i));
        track.values.push_back(value);
    }
    const std::string node_name = excerpt(textOf(nodes[node], "name"));
    const auto [place, is_new] = tracks_.emplace(std::pair(node, track.path), std::move(track));
    if (!is_new)
        notes_.push_back(fmt::format("its animations '{}' and '{}' both move the {} of '{}': the first one is taken",
                                     place->second.animation, name, what, node_name));
}

glm::dmat4 GltfAnimation::parentFromNode(std::size_t node, std::optional<double> seconds) const {
    const Json& json = memberOf(root_, "nodes").at(node);
    glm::dmat4 m(1);
    if (const Json& matrix = memberOf(json, "matrix"); matrix.is_array() && matrix.size() == 16) {
        for (int c = 0; c < 4; ++c)
            for (int r = 0; r < 4; ++r) m[c][r] = matrix[static_cast<std::size_t>(4 * c + r)].get<double>();
        return m;
    }
    const auto moved = [&](GltfTrack::Path path) -> std::optional<glm::dvec4> {
        const auto found = seconds ? tracks_.find({node, path}) : tracks_.end();
        if (found == tracks_.end()) return {};
        return found->second.at(*seconds);
    };
    glm::dvec4 turn(0, 0, 0, 1);
    if (const Json& q = memberOf(json, "rotation"); q.is_array() && q.size() == 4)
        for (int i = 0; i < 4; ++i) turn[i] = q[static_cast<std::size_t>(i)].get<double>();
    turn = moved(GltfTrack::Path::Rotation).value_or(turn);
    if (glm::length(turn) > 0) m = glm::mat4_cast(glm::normalize(quaternion(turn)));
    const glm::dvec4 scale = moved(GltfTrack::Path::Scale)
                                 .value_or(glm::dvec4(vectorOf(memberOf(json, "scale"), glm::dvec3(1)), 0)),
                     place = moved(GltfTrack::Path::Translation)
                                 .value_or(glm::dvec4(vectorOf(memberOf(json, "translation"), glm::dvec3(0)), 0));
    for (int a = 0; a < 3; ++a) m[a] *= scale[a];
    m[3] = glm::dvec4(glm::dvec3(place), 1);
    return m;
}

glm::dmat4 GltfAnimation::worldFromNode(std::size_t node) const {
    glm::dmat4 m = parentFromNode(node, {});
    for (auto up = parent_.find(node); up != parent_.end(); up = parent_.find(up->second))
        m = parentFromNode(up->second, {}) * m;
    return m;
}

glm::dmat4 GltfAnimation::worldFromNode(std::size_t node, double seconds) const {
    glm::dmat4 m = parentFromNode(node, seconds);
    for (auto up = parent_.find(node); up != parent_.end(); up = parent_.find(up->second))
        m = parentFromNode(up->second, seconds) * m;
    return m;
}

GltfAnimation::Tracks GltfAnimation::tracksOf(std::size_t node) const {
    Tracks out;
    for (std::optional<std::size_t> at = node; at;) {
        for (const auto path : {GltfTrack::Path::Translation, GltfTrack::Path::Rotation, GltfTrack::Path::Scale})
            if (const auto found = tracks_.find({*at, path}); found != tracks_.end()) out.push_back(&found->second);
        const auto up = parent_.find(*at);
        at = up == parent_.end() ? std::nullopt : std::optional(up->second);
    }
    return out;
}

GltfAnimation::Frames GltfAnimation::framesOf(const Tracks& tracks, const std::string& name) {
    double first = tracks.front()->times.front(), last = first;
    for (const GltfTrack* track : tracks)
        first = std::min(first, track->times.front()), last = std::max(last, track->times.back());
    // Times are in single precision: a key on a frame is that frame's.
    constexpr double kPart = 1e-4;
    if (last * frame_rate_ > kMostFrames)
        model_.fail(fmt::format(
            "moves '{}' until {:g} s, which is frame {:.0f} at {:g} frames a second; up to frame {} is read: cut the "
            "animation, or give the scene's extras a lower photic.frame_rate",
            name, last, last * frame_rate_, frame_rate_, kMostFrames));
    const Frames frames{static_cast<int>(std::floor(first * frame_rate_ + kPart)),
                        static_cast<int>(std::ceil(last * frame_rate_ - kPart))};
    if (!shown_) shown_ = frames;
    shown_ = Frames{std::min(shown_->first, frames.first), std::max(shown_->last, frames.last)};
    return {frames.first, std::max(frames.last, frames.first)};
}

void GltfAnimation::failDistorted(std::size_t node, const std::string& name) const {
    for (const GltfTrack* track : tracksOf(node))
        if (track->path == GltfTrack::Path::Scale &&
            std::any_of(track->values.begin(), track->values.end(),
                        [&](const glm::dvec4& v) { return v != track->values.front(); }))
            model_.fail(
                fmt::format("scales '{}' in its animation '{}'; what moves must keep its size: remove the channel "
                            "'scale'",
                            name, track->animation));
    model_.fail(
        fmt::format("moves '{}' so that it changes its shape, by the scale of what it hangs from or by one that it "
                    "does not have at rest; apply scales before export",
                    name));
}

std::string GltfAnimation::placementKeyframes(std::size_t node, const std::string& name,
                                              const std::function<void(const glm::dmat4& world_from_rest)>& places) {
    const Tracks tracks = tracksOf(node);
    if (tracks.empty()) return {};
    const Frames frames = framesOf(tracks, name);
    const glm::dmat4 rest = worldFromNode(node);
    const double size = std::fabs(glm::determinant(glm::dmat3(rest)));
    if (!(size > 1e-30)) model_.fail(fmt::format("moves '{}', which has no size at rest; give it one there", name));
    const glm::dmat4 rest_from_world = glm::inverse(rest);
    std::vector<Curve> curves{{"position", {}}, {"rotation", {}}};
    for (int frame = frames.first; frame <= frames.last; ++frame) {
        const glm::dmat4 moved =
            zUpMatrix() * worldFromNode(node, frame / frame_rate_) * rest_from_world * glm::transpose(zUpMatrix());
        const glm::dmat3 turn(moved);
        if (!isRigid(turn)) failDistorted(node, name);
        places(moved);
        curves[0].values.emplace_back(moved[3]);
        curves[1].values.push_back(anglesOf(turn));
    }
    // What stays where it rests needs no keys, and what stays elsewhere one.
    const auto at_rest = [](const Curve& curve) { return curve.stays() && glm::length(curve.values[0]) < 1e-6; };
    std::erase_if(curves, at_rest);
    return keyframesText(frames.first, curves);
}

std::string GltfAnimation::lightKeyframes(std::size_t node, bool position, bool direction) {
    const Tracks tracks = tracksOf(node);
    if (tracks.empty()) return {};
    const Frames frames = framesOf(tracks, textOf(memberOf(root_, "nodes").at(node), "name"));
    std::vector<Curve> curves;
    if (position) curves.push_back({"position", {}});
    if (direction) curves.push_back({"direction", {}});
    for (int frame = frames.first; frame <= frames.last; ++frame) {
        const glm::dmat4 m = worldFromNode(node, frame / frame_rate_);
        for (Curve& curve : curves)
            curve.values.push_back(
                gltf::zUp(curve.key[0] == 'p' ? glm::dvec3(m[3]) : -glm::normalize(glm::dvec3(m[2]))));
    }
    return keyframesText(frames.first, curves);
}

std::vector<std::string> GltfAnimation::notes() const {
    std::vector<std::string> out = notes_;
    for (const auto& [what, channels] : left_out_)
        out.push_back(fmt::format("{} of its animated channels move {}, and are not read", channels, what));
    if (shown_)
        out.push_back(
            fmt::format("it moves from frame {} to {}, {:g} a second (photic.frame_rate in the scene's "
                        "extras): --frames {}-{} bakes them",
                        shown_->first, shown_->last, frame_rate_, shown_->first, shown_->last));
    return out;
}

}  // namespace photic
