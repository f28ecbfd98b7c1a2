// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/graded_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <map>

#include "bake/graded/voxel_mean.h"
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

double GradedMedia::contrast(const GridFrame& frame) const {
    double least = 1e300, most = 0;
    const auto look = [&](const glm::dvec3& world) {
        const double square = 2 * halfSquare(world, 0);
        least = std::min(least, square), most = std::max(most, square);
    };
    for (int i = 0; i < 27; ++i) {
        const glm::dvec3 share = glm::dvec3(i % 3, i / 3 % 3, i / 9) * 0.5;
        look(frame.worldFromIndex(glm::mix(glm::dvec3(frame.min), glm::dvec3(frame.max), share)));
    }
    for (const GradedObject& object : objects)
        if (const auto bounds = object.index.front()->bounds()) look(0.5 * (bounds->min + bounds->max));
    return most - least;
}

double distanceInto(const WorldBox& box, const glm::dvec3& from, const glm::dvec3& direction) {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    double enter = 0, leave = kNever;
    for (int a = 0; a < 3; ++a) {
        if (direction[a] == 0) {
            if (from[a] < box.min[a] || from[a] > box.max[a]) return kNever;
            continue;
        }
        const double low = (box.min[a] - from[a]) / direction[a], high = (box.max[a] - from[a]) / direction[a];
        enter = std::max(enter, std::min(low, high)), leave = std::min(leave, std::max(low, high));
    }
    return enter < leave ? enter : kNever;
}

FrontBox mediaBox(const GradedMedia& media, const GridFrame& frame) {
    FrontBox box;
    for (const GradedObject& object : media.objects)
        for (const auto& index : object.index) {
            const auto bounds = index->bounds();
            if (bounds)
                box.add(frame.indexFromWorld(bounds->min) - 2.0), box.add(frame.indexFromWorld(bounds->max) + 2.0);
            else
                box.add(glm::dvec3(frame.min) - 0.5), box.add(glm::dvec3(frame.max) + 0.5);
        }
    return box;
}

FrontSpace frontSpace(const FrontBox& target, const GridFrame& frame) {
    FrontSpace space;
    // A voxel reaches half a step around its centre; what ends on its side does not need the next one.
    constexpr double kTouches = 1e-6;
    space.low = glm::min(frame.min, glm::ivec3(glm::floor(target.min + 0.5 + kTouches)));
    space.high = glm::max(frame.max, glm::ivec3(glm::ceil(target.max - 0.5 - kTouches)));
    return space;
}

std::string gradedSpaceRefusal(const Scene& scene) {
    if (scene.lights.empty()) return "the scene has no [[light]]";
    if (!scene.surfaces.empty())
        return fmt::format(
            "the surface '{}' lies beside media whose index varies, which is not built yet; remove it, or give the "
            "medium as an index",
            scene.surfaces.front().name);
    if (scene.domain.shear_mode != ShearMode::None)
        return "a sheared grid is not built yet for media whose index varies; remove [domain] shear";
    return {};
}

GradedSpace::GradedSpace(const Scene& scene, const GridFrame& frame, const Sampling& sampling)
    : frame_(frame),
      media_(scene),
      target_(mediaBox(media_, frame)),
      fit_(sampling.fit),
      all_light_(scene.bake.paths == Paths::All) {
    if (media_.objects.size() > 255)
        throw Error(ErrorCode::Input,
                    fmt::format("{} media have an index that varies; up to 255 are baked", media_.objects.size()));
    if (all_light_) target_.add(glm::dvec3(frame.min) - 0.5), target_.add(glm::dvec3(frame.max) + 0.5);
    space_ = frontSpace(target_, frame);
    space_.steps = sampling.steps;
    if (media_.fillTheWorld()) widen(scene, sampling.disc_samples);
}

/// Slanting light comes into a grid by its sides too, from a medium that goes on there: the space holds where it comes
/// from. Not where the light is so level that this would be more than eight times as much.
void GradedSpace::widen(const Scene& scene, int disc_samples) {
    known_ = space_;
    FrontBox entries;
    entries.add(glm::dvec3(space_.low)), entries.add(glm::dvec3(space_.high));
    for (const Light& light : scene.lights)
        for (const LightSample& sample : lightSamples(light, disc_samples)) {
            const FrontBox entry = entryOf({frame_, space_, target_}, sample);
            entries.add(entry.min), entries.add(entry.max);
        }
    const glm::dvec3 low = glm::floor(entries.min), high = glm::ceil(entries.max), size = high - low + 1.0,
                     before(space_.high - space_.low + 1);
    if (!(size.x * size.y * size.z <= 8 * before.x * before.y * before.z)) return;
    for (int a = 0; a < 3; ++a) {
        // Light enters on the side that it comes from, which stays where it is.
        if (entries.min[a] < space_.low[a] - 0.5) space_.low[a] = static_cast<int>(low[a]);
        if (entries.max[a] > space_.high[a] + 0.5) space_.high[a] = static_cast<int>(high[a]);
    }
}

/// n^2 / 2 of a voxel: beyond the grid, where a formula may end, that of the nearest one in it.
double GradedSpace::halfSquareAt(const glm::dvec3& world, const glm::dvec3& voxel, int channel) const {
    const double value = media_.halfSquareOfVoxel(world, voxel, channel);
    if (value > 0 || !media_.fillTheWorld()) return value;
    const glm::dvec3 inside =
        glm::clamp(frame_.indexFromWorld(world), glm::dvec3(known_.low - kMargin), glm::dvec3(known_.high + kMargin));
    return media_.halfSquareOfVoxel(frame_.worldFromIndex(inside), voxel, channel);
}

void GradedSpace::sample(int channel, Monitor& monitor) {
    space_.first_node = space_.low - kMargin;
    SplineIndex::Nodes nodes;
    nodes.count = space_.high - space_.low + 1 + 2 * kMargin;
    nodes.first_world = frame_.worldFromIndex(glm::dvec3(space_.first_node));
    for (int a = 0; a < 3; ++a) nodes.spacing[a] = frame_.worldFromIndex()[a][a];
    space_.index = nullptr, index_.reset();
    index_ = std::make_shared<const SplineIndex>(
        nodes,
        [&](const glm::dvec3& p) {
            monitor.checkCancelled();
            return halfSquareAt(p, nodes.spacing, channel);
        },
        fit_);
    space_.index = index_.get();
    layMedia(channel);
    jump_ = std::max(jump_, index_->steepest() * (index_->largest() - index_->least()));
    bytes_ = std::max(bytes_, index_->bytes() + static_cast<std::int64_t>(space_.media.size()));
    const double contrast = std::max(index_->largest() - 0.5, 0.5 - index_->least());
    space_.least_lit =
        all_light_ ? -1.0f : static_cast<float>((index_->fit() == SplineFit::Plain ? 0.25 : 0.01) * contrast);
}

void GradedSpace::layMedia(int channel) {
    space_.media.clear();
    if (!media_.attenuate()) return;
    const glm::ivec3 count = index_->nodes().count;
    std::vector<Attenuation> of_node(static_cast<std::size_t>(count.x) * static_cast<std::size_t>(count.y) *
                                     static_cast<std::size_t>(count.z));
    parallelFor(count.z, [&](std::int64_t z) {
        std::size_t node =
            static_cast<std::size_t>(z) * static_cast<std::size_t>(count.y) * static_cast<std::size_t>(count.x);
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x, ++node) {
                const glm::ivec3 voxel = space_.first_node + glm::ivec3(x, y, static_cast<int>(z));
                const glm::dvec3 world = frame_.worldFromIndex(glm::dvec3(voxel));
                const int place = media_.at(world, channel);
                if (place < 0) continue;
                const GradedObject& object = media_.objects[static_cast<std::size_t>(place)];
                of_node[node].absorption =
                    glm::vec3(object.absorption_volume ? object.absorption_volume->at(world) : object.absorption);
                of_node[node].scattering = glm::vec3(object.scattering);
            }
    });
    space_.media = paletteOf(of_node, space_.table, space_.absorption);
    glm::dvec3 absorbed(0), attenuated(0);
    for (std::size_t i = 1; i < space_.absorption.size(); ++i) {
        const float* extinction = space_.table.extinction[i];
        absorbed += space_.absorption[i], attenuated += glm::dvec3(extinction[0], extinction[1], extinction[2]);
    }
    for (int k = 0; k < 3; ++k) space_.absorbed_share[k] = attenuated[k] > 0 ? absorbed[k] / attenuated[k] : 1;
}

std::string GradedSpace::faces() const {
    if (!index_ || index_->fit() != SplineFit::Plain) return {};
    return "reflection at faces: the index jumps from a voxel to the next, and is blurred by 0.58 voxels there";
}

LightField causticBesideMedia(const Scene& scene, const LightField& field) {
    std::vector<LightSample> samples;
    for (const Light& light : scene.lights)
        for (const LightSample& sample : lightSamples(light, 1)) samples.push_back(sample);
    const auto unfocused = [&](const glm::dvec3& world) {
        double sum = 0;
        for (const LightSample& sample : samples) {
            const double strength = (sample.strength.x + sample.strength.y + sample.strength.z) / 3;
            if (!sample.source) {
                sum += strength;
                continue;
            }
            const glm::dvec3 way = world - *sample.source;
            const double square = glm::dot(way, way);
            if (!(square > 0)) continue;
            const double cosine = glm::dot(way, sample.direction) / std::sqrt(square);
            const bool panel = sample.light->type == LightType::Rectangle;
            sum += strength * (panel ? std::max(0.0, cosine) : sample.light->spotFalloff(cosine)) / square;
        }
        return sum;
    };
    LightField caustic(field.neededPtr(), {1, false});
    const double dark = 1e-3 * scene.referenceIrradiance();
    parallelFor(field.leafCount(), [&](std::int64_t i) {
        const int slot = static_cast<int>(i);
        if (field.state(slot) == LeafState::Empty) return;
        const glm::ivec3 origin = field.needed().leafOrigin(slot);
        float* out = caustic.makeDense(slot);
        for (int v = 0; v < LightField::kLeafVoxels; ++v) {
            const glm::ivec3 voxel = origin + glm::ivec3(v >> 6, v >> 3 & 7, v & 7);
            const double without = unfocused(field.frame().worldFromIndex(glm::dvec3(voxel)));
            out[v] = without > dark ? static_cast<float>(field.irradiance(voxel) / without) : 0.0f;
        }
    });
    return caustic;
}

}  // namespace photic
