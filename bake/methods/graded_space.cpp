// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/graded_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {

bool GradedMedia::disperses() const {
    return std::any_of(objects.begin(), objects.end(), [](const auto& o) { return o.index.size() > 1; });
}

bool GradedMedia::fillTheWorld() const {
    return std::any_of(objects.begin(), objects.end(), [](const auto& object) {
        return std::any_of(object.index.begin(), object.index.end(), [](const auto& i) { return !i->bounds(); });
    });
}

bool GradedMedia::attenuate() const {
    return std::any_of(objects.begin(), objects.end(), [](const auto& o) { return o.extinction() != glm::dvec3(0); });
}

int GradedMedia::at(const glm::dvec3& world, int channel) const {
    for (std::size_t i = 0; i < objects.size(); ++i)
        if (indexOf(objects[i], channel).contains(world)) return static_cast<int>(i);
    return -1;
}

double GradedMedia::halfSquare(const glm::dvec3& world, int channel) const {
    const int object = at(world, channel);
    return object < 0 ? 0.5 : indexOf(objects[static_cast<std::size_t>(object)], channel).at(world).half_square;
}

double GradedMedia::halfSquareOfVoxel(const glm::dvec3& middle, const glm::dvec3& voxel, int channel) const {
    // Samples of a kink at a rim scatter, and made 3.5 % of noise in the light of a Luneburg lens at any resolution,
    // where means leave 0.1 %.
    const int object = at(middle, channel);
    bool alike = true;
    for (int corner = 0; corner < 8 && alike; ++corner) {
        const glm::dvec3 way(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
        alike = at(middle + way * voxel, channel) == object;
    }
    if (alike) return halfSquare(middle, channel);
    constexpr int kPoints = 4;
    double sum = 0;
    for (int i = 0; i < kPoints * kPoints * kPoints; ++i) {
        const glm::dvec3 part(i % kPoints, i / kPoints % kPoints, i / (kPoints * kPoints));
        sum += halfSquare(middle + ((part + 0.5) / double(kPoints) - 0.5) * voxel, channel);
    }
    return sum / (kPoints * kPoints * kPoints);
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
    space_.media.resize(static_cast<std::size_t>(count.x) * static_cast<std::size_t>(count.y) *
                        static_cast<std::size_t>(count.z));
    parallelFor(count.z, [&](std::int64_t z) {
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x) {
                const glm::ivec3 voxel = space_.first_node + glm::ivec3(x, y, static_cast<int>(z));
                const int object = media_.at(frame_.worldFromIndex(glm::dvec3(voxel)), channel);
                space_.media[(static_cast<std::size_t>(z) * static_cast<std::size_t>(count.y) +
                              static_cast<std::size_t>(y)) *
                                 static_cast<std::size_t>(count.x) +
                             static_cast<std::size_t>(x)] = static_cast<std::uint8_t>(object + 1);
            }
    });
    glm::dvec3 absorbed(0), attenuated(0);
    for (std::size_t i = 0; i < media_.objects.size(); ++i) {
        const glm::dvec3 extinction = media_.objects[i].extinction();
        for (int k = 0; k < 3; ++k) space_.table.extinction[i + 1][k] = static_cast<float>(extinction[k]);
        absorbed += media_.objects[i].absorption, attenuated += extinction;
    }
    for (int k = 0; k < 3; ++k) space_.absorbed_share[k] = attenuated[k] > 0 ? absorbed[k] / attenuated[k] : 1;
}

std::string GradedSpace::faces() const {
    if (!index_ || index_->fit() != SplineFit::Plain) return {};
    return "reflection at faces: the index jumps from a voxel to the next, and is blurred by 0.58 voxels there";
}

}  // namespace photic
