// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/keyframes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <map>

#include "bake/report/error.h"
#include "bake/scene/table_reader.h"
#include "bake/scene/unit_vector.h"

namespace photic {
namespace {

const char* const kMoving[] = {"light", "surface", "object"};

/// What a key is at one frame, and where that is said.
struct Key {
    double frame = 0;
    glm::dvec3 value{0};
    std::string where;
};

/// The keys of a table by name, each in the order of their frames.
using Tracks = std::map<std::string, std::vector<Key>>;

const ConfigValue& framesOf(const ConfigValue& keyframes) {
    if (keyframes.kind != ConfigValue::Kind::Array || keyframes.items.empty())
        throw Error(ErrorCode::Input,
                    fmt::format("'keyframes' is {}; give an array: keyframes = [{{ frame = 1, position = [0, 0, 1] }}, "
                                "{{ frame = 48, position = [1, 0, 1] }}]",
                                keyframes.kind == ConfigValue::Kind::Array ? "empty" : keyframes.kindName()),
                    keyframes.where);
    return keyframes;
}

/// Along the great circle from one unit vector to another.
glm::dvec3 turned(const Key& from, const Key& to, double part) {
    const glm::dvec3 a = unitVector(from.value), b = unitVector(to.value);
    const double angle = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
    constexpr double kOpposite = 3.14159;
    if (angle > kOpposite)
        throw Error(ErrorCode::Input,
                    fmt::format("the directions at frames {:g} and {:g} are opposite, and any way from one to the "
                                "other is as short; put a keyframe between them",
                                from.frame, to.frame),
                    to.where);
    if (angle < 1e-9) return part < 0.5 ? a : b;
    return (std::sin((1 - part) * angle) * a + std::sin(part * angle) * b) / std::sin(angle);
}

Tracks tracksOf(const ConfigValue& keyframes) {
    constexpr double kMostFrames = 1e9;
    Tracks tracks;
    for (const ConfigValue& item : framesOf(keyframes).items) {
        if (item.kind != ConfigValue::Kind::Table)
            throw Error(ErrorCode::Input,
                        fmt::format("a keyframe is {}; write {{ frame = 1, position = [0, 0, 1] }}", item.kindName()),
                        item.where);
        const TableReader table(item, "a keyframe", {"frame", "position", "center", "direction", "rotation"});
        const auto frame = table.number("frame", between(-kMostFrames, kMostFrames));
        if (!frame) table.missing("frame", "1");
        if (item.entries.size() < 2)
            table.fail(
                fmt::format("the keyframe at {:g} moves nothing; give it a position, center, direction or "
                            "rotation",
                            *frame));
        for (const char* name : {"position", "center", "direction", "rotation"}) {
            const auto value = table.vector3(name, withinReach(""));
            if (!value) continue;
            if (name == std::string("direction") && *value == glm::dvec3(0))
                table.fail(name, "'direction' has no length; give the direction that the light travels in");
            tracks[name].push_back({*frame, *value, table.where(name)});
        }
    }
    for (auto& [name, keys] : tracks) {
        std::stable_sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) { return a.frame < b.frame; });
        for (std::size_t i = 1; i < keys.size(); ++i) {
            if (keys[i].frame == keys[i - 1].frame)
                throw Error(ErrorCode::Input,
                            fmt::format("two keyframes say '{}' at frame {:g}; keep one", name, keys[i].frame),
                            keys[i].where);
            if (name == "direction") turned(keys[i - 1], keys[i], 0.5);  // refuses opposite ones
        }
    }
    return tracks;
}

glm::dvec3 valueAt(const std::string& name, const std::vector<Key>& keys, double frame) {
    const auto next = std::find_if(keys.begin(), keys.end(), [&](const Key& key) { return key.frame >= frame; });
    if (next == keys.end()) return keys.back().value;
    if (next == keys.begin() || next->frame == frame) return next->value;
    const Key& last = *std::prev(next);
    const double part = (frame - last.frame) / (next->frame - last.frame);
    return name == "direction" ? turned(last, *next, part) : last.value + part * (next->value - last.value);
}

ConfigValue vectorValue(const glm::dvec3& v, const std::string& where) {
    ConfigValue out;
    out.kind = ConfigValue::Kind::Array, out.where = where;
    for (int a = 0; a < 3; ++a) {
        ConfigValue number;
        number.kind = ConfigValue::Kind::Number, number.where = where, number.number = v[a];
        out.items.push_back(std::move(number));
    }
    return out;
}

void settle(ConfigValue& table, double frame) {
    const ConfigValue* keyframes = table.find("keyframes");
    if (!keyframes) return;
    const Tracks tracks = tracksOf(*keyframes);
    std::vector<ConfigEntry> settled;
    for (const auto& [name, keys] : tracks) {
        if (const ConfigValue* twice = table.find(name))
            throw Error(ErrorCode::Input,
                        fmt::format("'{}' is given here and by 'keyframes'; keep one of the two", name), twice->where);
        settled.push_back({name, vectorValue(valueAt(name, keys, frame), keys.front().where)});
    }
    std::erase_if(table.entries, [](const ConfigEntry& entry) { return entry.key == "keyframes"; });
    for (ConfigEntry& entry : settled) table.entries.push_back(std::move(entry));
}

}  // namespace

ConfigValue atFrame(const ConfigValue& root, double frame) {
    ConfigValue out = root;
    for (ConfigEntry& entry : out.entries)
        for (const char* name : kMoving)
            if (entry.key == name)
                for (ConfigValue& table : entry.value.items) settle(table, frame);
    return out;
}

ConfigValue atKeyframes(const ConfigValue& table, double frame) {
    ConfigValue out = table;
    settle(out, frame);
    return out;
}

double firstKeyframe(const ConfigValue& table, double otherwise) {
    const ConfigValue* keyframes = table.find("keyframes");
    if (!keyframes) return otherwise;
    double first = otherwise;
    bool any = false;
    for (const auto& [name, keys] : tracksOf(*keyframes))
        first = any ? std::min(first, keys.front().frame) : keys.front().frame, any = true;
    return first;
}

}  // namespace photic
