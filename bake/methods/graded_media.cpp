// SPDX-License-Identifier: Apache-2.0
// Media whose index varies, as one channel's light sees them, and what attenuates in them.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "bake/graded/voxel_mean.h"
#include "bake/methods/graded_space.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

/// What attenuates at a node [1/m], per channel.
struct Attenuation {
    glm::vec3 absorption{0}, scattering{0};
};

/// Numbers what attenuates, by node, so that 255 numbers do: equal ones have one, and where there are more, those that
/// are within a share of each other have their mean.
/// @param table, absorption  of each number; the first, 0, attenuates nothing
std::vector<std::uint8_t> paletteOf(const std::vector<Attenuation>& nodes, FrontMedia& table,
                                    std::vector<glm::dvec3>& absorption) {
    using Key = std::array<float, 6>;
    struct Entry {
        std::uint8_t number = 0;
        double nodes = 0;
        glm::dvec3 absorption{0}, scattering{0};
    };
    std::vector<std::uint8_t> numbers(nodes.size());
    // Steps a factor of two; 0: as they are.
    for (const float steps : {0.0f, 64.0f, 32.0f, 16.0f, 8.0f, 4.0f, 2.0f, 1.0f, 0.5f}) {
        std::map<Key, Entry> entries;
        const auto keyOf = [steps](float v) { return steps > 0 && v > 0 ? std::round(steps * std::log2(v)) : v; };
        const Key* last_key = nullptr;
        Entry* last = nullptr;
        for (std::size_t i = 0; i < nodes.size() && entries.size() < 256; ++i) {
            const glm::vec3 &a = nodes[i].absorption, &s = nodes[i].scattering;
            numbers[i] = 0;
            if (a == glm::vec3(0) && s == glm::vec3(0)) continue;
            const Key key{keyOf(a.x), keyOf(a.y), keyOf(a.z), keyOf(s.x), keyOf(s.y), keyOf(s.z)};
            if (!last || key != *last_key) {
                const auto [at, fresh] = entries.try_emplace(key);
                if (fresh) at->second.number = static_cast<std::uint8_t>(entries.size());
                last_key = &at->first, last = &at->second;
            }
            numbers[i] = last->number;
            ++last->nodes, last->absorption += glm::dvec3(a), last->scattering += glm::dvec3(s);
        }
        if (entries.size() > 255) continue;
        absorption.assign(entries.size() + 1, glm::dvec3(0));
        for (const auto& [key, entry] : entries) {
            absorption[entry.number] = entry.absorption / entry.nodes;
            for (int k = 0; k < 3; ++k)
                table.extinction[entry.number][k] =
                    static_cast<float>((entry.absorption[k] + entry.scattering[k]) / entry.nodes);
        }
        return numbers;
    }
    throw Error(ErrorCode::Input,
                "the media's absorption varies so much that 255 values do not stand for it; use fewer colours of it");
}

}  // namespace

GradedMedia::GradedMedia(const Scene& scene)
    : GradedMedia([&] {
          std::vector<GradedObject> in_air = scene.index->objects();
          std::erase_if(in_air, [](const GradedObject& object) { return object.enclosed; });
          return in_air;
      }()) {}

bool GradedMedia::disperses() const {
    return std::any_of(objects.begin(), objects.end(), [](const auto& o) { return o.index.size() > 1; });
}

bool GradedMedia::fillTheWorld() const {
    return std::any_of(objects.begin(), objects.end(), [](const auto& object) {
        return std::any_of(object.index.begin(), object.index.end(), [](const auto& i) { return !i->bounds(); });
    });
}

bool GradedMedia::attenuate() const {
    return std::any_of(objects.begin(), objects.end(), [](const auto& o) { return o.attenuates(); });
}

int GradedMedia::at(const glm::dvec3& world, int channel) const {
    for (std::size_t i = 0; i < objects.size(); ++i)
        if (indexOf(objects[i], channel).contains(world)) return static_cast<int>(i);
    return -1;
}

double GradedMedia::halfSquare(const glm::dvec3& world, int channel) const {
    const int object = at(world, channel);
    return object < 0 ? 0.5 : indexOf(objects[static_cast<std::size_t>(object)], channel).halfSquareAt(world);
}

double GradedMedia::halfSquareOfVoxel(const glm::dvec3& middle, const glm::dvec3& voxel, int channel) const {
    if (!rims) return indexOf(objects.front(), channel).halfSquareAt(middle);
    glm::dmat3 axes(1);
    for (int a = 0; a < 3; ++a) axes[a] *= voxel[a];
    return meanAcrossRims(
        middle, axes, [&](const glm::dvec3& world) { return at(world, channel); },
        [&](const glm::dvec3& world) { return halfSquare(world, channel); });
}

void GradedSpace::layMedia(Part& part, int channel) const {
    FrontSpace& space = part.space;
    const GradedMedia& media = part.media;
    space.media.clear();
    if (!media.attenuate()) return;
    const glm::ivec3 count = part.index->nodes().count;
    std::vector<Attenuation> of_node(static_cast<std::size_t>(count.x) * static_cast<std::size_t>(count.y) *
                                     static_cast<std::size_t>(count.z));
    parallelFor(count.z, [&](std::int64_t z) {
        std::size_t node =
            static_cast<std::size_t>(z) * static_cast<std::size_t>(count.y) * static_cast<std::size_t>(count.x);
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x, ++node) {
                const glm::ivec3 voxel = space.first_node + glm::ivec3(x, y, static_cast<int>(z));
                const glm::dvec3 world = frame_.worldFromIndex(glm::dvec3(voxel));
                const int place = part.enclosed ? 0 : media.at(world, channel);
                if (place < 0) continue;
                const GradedObject& object = media.objects[static_cast<std::size_t>(place)];
                of_node[node].absorption =
                    glm::vec3(object.absorption_volume ? object.absorption_volume->at(world) : object.absorption);
                of_node[node].scattering = glm::vec3(object.scattering);
            }
    });
    space.media = paletteOf(of_node, space.table, space.absorption);
    glm::dvec3 absorbed(0), attenuated(0);
    for (std::size_t i = 1; i < space.absorption.size(); ++i) {
        const float* extinction = space.table.extinction[i];
        absorbed += space.absorption[i], attenuated += glm::dvec3(extinction[0], extinction[1], extinction[2]);
    }
    for (int k = 0; k < 3; ++k) space.absorbed_share[k] = attenuated[k] > 0 ? absorbed[k] / attenuated[k] : 1;
}

}  // namespace photic
