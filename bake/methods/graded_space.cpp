// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/graded_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "bake/graded/enclosed_bodies.h"
#include "bake/paths/launch_domain.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {

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

namespace {

double voxelsOf(const FrontBox& box) {
    const glm::dvec3 size = glm::max(box.max - box.min, glm::dvec3(1));
    return size.x * size.y * size.z;
}

/// Fronts go through all of the box around the domain and what bends light, and so do the samples of the index: 4 bytes
/// a voxel.
/// @throws Error{Input} where that is much, and next to empty
void requireFilled(const Scene& scene, const GradedMedia& media, const GridFrame& frame, const FrontSpace& space) {
    constexpr double kMost = 268435456;  // 2^28 voxels: 1 GB
    constexpr double kMostTimes = 8;     // as many as are filled
    const double all = voxelsOf({glm::dvec3(space.low) - 0.5, glm::dvec3(space.high) + 0.5});
    if (!(all > kMost)) return;
    const FrontBox grid{glm::dvec3(frame.min) - 0.5, glm::dvec3(frame.max) + 0.5};
    double filled = voxelsOf(grid), farthest = 0;
    std::string what = "the domain", where = scene.file;
    const auto add = [&](const FrontBox& box, const std::string& name, const std::string& place) {
        filled += voxelsOf(box);
        const glm::dvec3 gap = glm::max(glm::max(box.min - grid.max, grid.min - box.max), glm::dvec3(0));
        const double distance = glm::length(glm::dmat3(frame.worldFromIndex()) * gap);
        if (distance > farthest) farthest = distance, what = "'" + name + "'", where = place;
    };
    for (const GradedObject& object : media.objects)
        add(mediaBox(GradedMedia(std::vector<GradedObject>{object}), frame), object.name, object.where);
    for (const Surface& surface : scene.surfaces) {
        if (!surface.mesh) continue;
        FrontBox box;
        for (const glm::dvec3& v : surface.mesh->positions) box.add(frame.indexFromWorld(v));
        add(box, surface.name, surface.where);
    }
    if (!(all > kMostTimes * filled)) return;
    throw Error(
        ErrorCode::Input,
        fmt::format("{} lies {:.3g} m beside the domain, and light is followed through all of the {:.3g} voxels "
                    "around both, of which they fill {:.2g} %; the limit where they fill less than an eighth is "
                    "2^28: move it closer, leave it out, or use a voxel_size of {:.2g} m",
                    what, farthest, all, 100 * filled / all, std::cbrt(all / kMost) * frame.worldFromIndex()[0][0]),
        where);
}

}  // namespace

std::string gradedSpaceRefusal(const Scene& scene) {
    if (scene.lights.empty()) return "the scene has no [[light]]";
    if (scene.domain.shear_mode != ShearMode::None)
        return "a sheared grid is not built yet for media whose index varies; remove [domain] shear";
    return {};
}

GradedSpace::GradedSpace(const Scene& scene, const GridFrame& frame, const Sampling& sampling)
    : frame_(frame), fit_(sampling.fit), rim_(sampling.rim), all_light_(scene.bake.paths == Paths::All) {
    if (scene.index->objects().size() > 255)
        throw Error(ErrorCode::Input, fmt::format("{} media have an index that varies; up to 255 are baked",
                                                  scene.index->objects().size()));
    findParts(scene);
    target_ = mediaBox(media(), frame);
    if (!scene.surfaces.empty()) addSurfaces(scene);
    const bool fills = media().fillTheWorld() || partOf(start_) != 0;
    if (all_light_ || fills) target_.add(glm::dvec3(frame.min) - 0.5), target_.add(glm::dvec3(frame.max) + 0.5);
    addLampsNear(scene);
    box_ = frontSpace(target_, frame);
    requireFilled(scene, media(), frame, box_);
    if (fills) widen(scene, sampling.disc_samples);
    for (Part& part : parts_) {
        FrontSpace& space = part.space;
        space.low = box_.low, space.high = box_.high, space.steps = sampling.steps,
        space.integrator = sampling.integrator;
        if (optics_) space.beyond = this;
        space.limits.events = scene.bake.bounces.value_or(kDefaultBounces);
        space.limits.threshold = scene.bake.threshold.value_or(kDefaultThreshold);
    }
}

/// What may be on the sides of surfaces: the objects in air, each medium whose index varies and that a surface names,
/// and each other medium.
void GradedSpace::findParts(const Scene& scene) {
    parts_.emplace_back(Part{GradedMedia(scene), {}});
    disperses_ = media().disperses();
    if (media().objects.empty()) parts_.front().even = {1, 1, 1, 1};
    if (scene.surfaces.empty()) return;
    const glm::dvec3 nm = RefractiveIndex::kChannels_nm;
    optics_ =
        std::make_unique<OpticalScene>(scene, frame_, std::vector<double>{nm.x, nm.y, nm.z}, 0.0, LoneWater::IsMet);
    for (int m = 0; m < optics_->mediumCount(); ++m) {
        const OpticalMedium& medium = optics_->medium(m);
        const std::string& name = optics_->given(m).name;
        const auto& objects = scene.index->objects();
        const auto object = std::find_if(objects.begin(), objects.end(), [&](const GradedObject& o) {
            return o.enclosed && !name.empty() && o.name == name;
        });
        if (object == objects.end() && medium.iors.front() == 1 && !medium.disperses && medium.clear()) {
            part_of_medium_.push_back(0);  // air, with the objects in it
            continue;
        }
        part_of_medium_.push_back(parts_.size());
        Part part{GradedMedia(std::vector<GradedObject>{}), {}};
        if (object != objects.end()) {
            part.media = GradedMedia(std::vector<GradedObject>{*object}), part.enclosed = true;
            disperses_ = disperses_ || part.media.disperses();
        } else {
            part.even = medium.iors;
            disperses_ = disperses_ || medium.disperses;
            FrontSpace& space = part.space;
            if (!medium.clear()) {
                space.media = {1};
                space.absorption = {glm::dvec3(0), medium.absorption};
                for (int k = 0; k < 3; ++k) {
                    const double extinction = medium.extinction()[k];
                    space.table.extinction[1][k] = static_cast<float>(extinction);
                    space.absorbed_share[k] = extinction > 0 ? medium.absorption[k] / extinction : 1;
                }
            }
        }
        parts_.push_back(std::move(part));
    }
    // Water is lit from above, and bodies stand in what lies around the first of them.
    const auto water = std::find_if(scene.surfaces.begin(), scene.surfaces.end(),
                                    [](const Surface& surface) { return surface.height_field != nullptr; });
    over_water_ = water != scene.surfaces.end();
    const auto from = over_water_ ? water - scene.surfaces.begin() : std::ptrdiff_t{0};
    start_.base = static_cast<std::int16_t>(optics_->sides(static_cast<int>(from)).outside);
    for (std::size_t p = 0; p < parts_.size(); ++p) {
        if (!parts_[p].enclosed) continue;
        // Where bodies alone hold it, it need not be known elsewhere.
        WorldBox box{glm::dvec3(1e300), glm::dvec3(-1e300)};
        bool bodies = partOf(start_) != p;
        for (std::size_t s = 0; s < scene.surfaces.size(); ++s) {
            const MediumSides& sides = optics_->sides(static_cast<int>(s));
            const bool outside = part_of_medium_[static_cast<std::size_t>(sides.outside)] == p,
                       inside = part_of_medium_[static_cast<std::size_t>(sides.inside)] == p;
            if (!outside && !inside) continue;
            bodies = bodies && !outside && sides.nested;
            if (scene.surfaces[s].mesh)
                for (const glm::dvec3& v : scene.surfaces[s].mesh->positions)
                    box.min = glm::min(box.min, v), box.max = glm::max(box.max, v);
        }
        if (bodies) parts_[p].within = box;
    }
}

/// Light has to cover all that could send it into the grid.
void GradedSpace::addSurfaces(const Scene& scene) {
    for (const Surface& surface : scene.surfaces) {
        if (surface.mesh) {
            for (const glm::dvec3& v : surface.mesh->positions) target_.add(frame_.indexFromWorld(v));
            // A ball is a little wider than the mesh that stands for it.
            if (surface.sphere)
                for (int a = 0; a < 3; ++a) {
                    glm::dvec3 reach(0);
                    reach[a] = surface.sphere->radius;
                    target_.add(frame_.indexFromWorld(surface.sphere->center + reach));
                    target_.add(frame_.indexFromWorld(surface.sphere->center - reach));
                }
            continue;
        }
        for (const Light& light : scene.lights) {
            const LaunchDomain domain = launchDomain(scene, surface, light, frame_);
            if (domain.empty()) continue;
            target_.add(frame_.indexFromWorld({domain.min, surface.height_field->minZ()}));
            target_.add(frame_.indexFromWorld({domain.max, surface.height_field->maxZ()}));
        }
    }
    // A hair more: no surface lies on the plane that light starts from.
    constexpr double kHair = 1e-3;
    if (target_.min.x <= target_.max.x) target_.min -= kHair, target_.max += kHair;
    // Where no light comes into the grid at all.
    if (!(target_.min.x <= target_.max.x))
        target_.add(glm::dvec3(frame_.min) - 0.5), target_.add(glm::dvec3(frame_.max) + 0.5);
}

std::size_t GradedSpace::partOf(const MediumStack& inside) const {
    return optics_ ? part_of_medium_[static_cast<std::size_t>(optics_->mediumOf(inside))] : 0;
}

OpticalScene::Event GradedSpace::eventOn(int surface, const MediumStack& inside, const glm::dvec3& direction,
                                         const Meeting& at) const {
    return optics_->eventBetween(surface, inside, direction, at, [&](int medium) {
        const FrontSpace& space = parts_[part_of_medium_[static_cast<std::size_t>(medium)]].space;
        // Rings of a spline through samples may leave no index at all beside a jump.
        constexpr double kLeast = 1e-6;
        return std::sqrt(std::max(2 * space.halfSquareAt(at.position), kLeast));
    });
}

bool GradedSpace::startsGraded(const MediumStack& inside, const glm::dvec3& world, int channel) const {
    const std::size_t part = partOf(inside);
    return part == 0 ? media().at(world, channel) >= 0 : parts_[part].enclosed;
}

FrontLaunch GradedSpace::launch(const std::optional<glm::dvec3>& lamp, double spacing, int channel,
                                const RayCaster* caster) const {
    const auto launchInside = [&](const MediumStack& inside) {
        FrontLaunch launch{frame_,
                           spaceOf(inside),
                           target_,
                           spacing,
                           all_light_,
                           [this, inside, channel](const glm::dvec3& world) {
                               return startsGraded(inside, world, channel); },
                           caster};
        launch.inside = inside;
        if (over_water_) launch.across = 2;
        launch.straight = partOf(start_) == 0 && media().objects.empty();
        return launch;
    };
    const FrontLaunch launch = launchInside(start_);
    LightSample at_lamp;
    at_lamp.source = lamp;
    return optics_ && standsAmong(launch, at_lamp) ? launchInside(insideAt(*lamp)) : launch;
}

void GradedSpace::standIn(const FrontObstacles& obstacles) {
    for (Part& part : parts_) part.space.obstacles = &obstacles;
}

/// Slanting light comes into a grid by its sides too, from a medium that goes on there: the space holds where it comes
/// from. Not where the light is so level that this would be more than eight times as much.
void GradedSpace::widen(const Scene& scene, int disc_samples) {
    known_ = box_;
    FrontBox entries;
    entries.add(glm::dvec3(box_.low)), entries.add(glm::dvec3(box_.high));
    FrontLaunch launch{frame_, box_, target_};
    if (over_water_) launch.across = 2;
    for (const Light& light : scene.lights)
        for (const LightSample& sample : lightSamples(light, disc_samples)) {
            if (standsAmong(launch, sample)) continue;
            const FrontBox entry = entryOf(launch, sample);
            entries.add(entry.min), entries.add(entry.max);
        }
    const glm::dvec3 low = glm::floor(entries.min), high = glm::ceil(entries.max), size = high - low + 1.0,
                     before(box_.high - box_.low + 1);
    if (!(size.x * size.y * size.z <= 8 * before.x * before.y * before.z)) return;
    for (int a = 0; a < 3; ++a) {
        // Light enters on the side that it comes from, which stays where it is.
        if (entries.min[a] < box_.low[a] - 0.5) box_.low[a] = static_cast<int>(low[a]);
        if (entries.max[a] > box_.high[a] + 0.5) box_.high[a] = static_cast<int>(high[a]);
    }
}

/// n^2 / 2 of a voxel: beyond the grid, where a formula may end, that of the nearest one in it. What surfaces enclose
/// goes on beyond them, and beyond what is known of it as it is at its rim.
double GradedSpace::halfSquareAt(const Part& part, const glm::dvec3& world, const glm::dvec3& voxel,
                                 int channel) const {
    if (part.enclosed) {
        const double value = halfSquareEnclosed(part.media.indexOf(part.media.objects.front(), channel), world);
        if (value > 0) return value;
    } else {
        const double value = part.media.halfSquareOfVoxel(world, voxel, channel);
        if (value > 0 || !part.media.fillTheWorld()) return value;
    }
    const FrontSpace& known = known_.high != known_.low ? known_ : box_;  // known_: where it was widened
    const glm::dvec3 inside =
        glm::clamp(frame_.indexFromWorld(world), glm::dvec3(known.low - kMargin), glm::dvec3(known.high + kMargin));
    return part.media.halfSquareOfVoxel(frame_.worldFromIndex(inside), voxel, channel);
}

void GradedSpace::sample(int channel, Monitor& monitor) {
    std::int64_t bytes = 0;
    for (Part& part : parts_) part.space.index = nullptr, part.index.reset();
    for (Part& part : parts_) {
        if (part.media.objects.empty()) {
            const double n = part.even[disperses_ ? static_cast<std::size_t>(channel) + 1 : 0];
            part.space.even = 0.5 * n * n;
            // Light counts there from the surface on that it comes by.
            part.space.least_lit = all_light_ ? -1.0f : std::numeric_limits<float>::infinity();
            continue;
        }
        sample(part, channel, monitor);
        bytes += part.index->bytes() + static_cast<std::int64_t>(part.space.media.size());
    }
    bytes_ = std::max(bytes_, bytes);
}

void GradedSpace::sample(Part& part, int channel, Monitor& monitor) {
    FrontSpace& space = part.space;
    glm::ivec3 low = space.low - kMargin, high = space.high + kMargin;
    if (part.within) {
        const glm::dvec3 a = frame_.indexFromWorld(part.within->min), b = frame_.indexFromWorld(part.within->max);
        low = glm::max(low, glm::ivec3(glm::floor(a)) - kMargin),
        high = glm::min(high, glm::ivec3(glm::ceil(b)) + kMargin);
        high = glm::max(high, low + kMargin);
    }
    space.first_node = low;
    SplineIndex::Nodes nodes;
    nodes.count = high - low + 1;
    nodes.first_world = frame_.worldFromIndex(glm::dvec3(space.first_node));
    for (int a = 0; a < 3; ++a) nodes.spacing[a] = frame_.worldFromIndex()[a][a];
    part.index = std::make_shared<const SplineIndex>(
        nodes,
        [&](const glm::dvec3& p) {
            monitor.checkCancelled();
            return halfSquareAt(part, p, nodes.spacing, channel);
        },
        fit_);
    space.index = part.index.get();
    layMedia(part, channel);
    const SplineIndex& index = *part.index;
    jump_ = std::max(jump_, index.steepest() * (index.largest() - index.least()));
    const double contrast = std::max(index.largest() - 0.5, 0.5 - index.least());
    space.least_lit = all_light_      ? -1.0f
                      : part.enclosed ? std::numeric_limits<float>::infinity()
                                      : static_cast<float>((rim_ > 0                          ? rim_
                                                            : index.fit() == SplineFit::Plain ? 0.25
                                                                                              : 0.01) *
                                                           contrast);
}

bool GradedSpace::attenuate() const {
    return std::any_of(parts_.begin(), parts_.end(), [](const Part& part) { return part.media.attenuate(); });
}

bool GradedSpace::plain() const {
    return std::any_of(parts_.begin(), parts_.end(),
                       [](const Part& part) { return part.index && part.index->fit() == SplineFit::Plain; });
}

std::string GradedSpace::faces() const {
    if (!plain()) return {};
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
