// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/graded_photons.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <optional>

#include "bake/graded/ray_integrator.h"
#include "bake/methods/front_obstacles.h"
#include "bake/optics/tangent_frame.h"
#include "bake/paths/optical_scene.h"

namespace photic {
namespace {

/// Directions of the sun's disc for which the space is made wide enough.
constexpr int kDiscSamples = 16;
/// Light that goes round and round in a medium is given up after this many times the space's diagonal.
constexpr double kRounds = 16;

/// The same place a hair further: what starts on a side of a block is in the next one.
constexpr double kHairVoxels = 1e-6;

/// How long a step may be where the index is so [voxels]: it turns a ray by about a twentieth at most, and sees every
/// voxel twice.
double stepLength(const IndexSample& here, double voxel) {
    constexpr double kLongest = 0.5, kShortest = 1.0 / 16, kTurn = 0.05;
    const double turn = glm::length(here.gradient) * voxel / (2 * here.half_square);
    return std::clamp(turn > 0 ? kTurn / turn : kLongest, kShortest, kLongest);
}

}  // namespace

/// One of the spaces that a channel's light goes through.
struct GradedPhotons::Space {
    std::shared_ptr<const SplineIndex> samples;  // null: the index is the same everywhere
    std::optional<SplineGradedIndex> index;
    FrontSpace space;
    std::optional<FlatBlocks> flat;

    Space(const GradedSpace& medium, int number) : samples(medium.index(number)), space(medium.spaceNumbered(number)) {
        if (!samples) return;
        index.emplace(*samples), flat.emplace(*samples, space.media);
    }
    glm::dvec3 nodeOf(const glm::dvec3& world) const {
        return (world - samples->nodes().first_world) / samples->nodes().spacing;
    }
    double halfSquareAt(const glm::dvec3& world) const { return samples ? samples->at(world).half_square : space.even; }
    /// What attenuates at a place, by its number in the space; 0: nothing.
    std::size_t mediumAt(const glm::dvec3& world) const {
        if (space.media.empty()) return 0;
        if (!samples) return space.media.front();
        const glm::ivec3 count = samples->nodes().count,
                         node = glm::clamp(glm::ivec3(glm::round(nodeOf(world))), glm::ivec3(0), count - 1);
        return space.media[(static_cast<std::size_t>(node.z) * static_cast<std::size_t>(count.y) +
                            static_cast<std::size_t>(node.y)) *
                               static_cast<std::size_t>(count.x) +
                           static_cast<std::size_t>(node.x)];
    }
};

/// What one channel's light, or that of all channels, goes through.
struct GradedPhotons::Pass {
    std::vector<Space> spaces;
    glm::dvec3 channels{1};  // that it is of
    int channel = 0;

    Pass(const GradedSpace& medium, int number) : channel(number) {
        for (int i = 0; i < medium.spaces(); ++i) spaces.emplace_back(medium, i);
        if (medium.passes() > 1) channels = glm::dvec3(0), channels[number] = 1;
    }
};

struct GradedPhotons::Photon {
    GradedRay ray;
    glm::dvec3 power{0};
    bool lit = false;      // it has been in a medium
    bool touched = false;  // a needed voxel
    double way = 0;        // [m]
    MediumStack inside;
    glm::dvec3 start{0};  // of this leg [m]
    int surface = -1;     // that it starts on
    int events = 0;
    double least = 0;  // [W] below which no surface sends it on
};

/// The photons of one light.
class GradedPhotons::Paths final : public PhotonPaths {
public:
    Paths(const GradedPhotons& photons, const Light& light) : photons_(photons), light_(light) {
        const LightSample centre = light_.sample(0.5, 0.5);
        spaces_.reserve(photons.passes_.size());
        for (const auto& pass : photons.passes_) {
            FrontLaunch launch = photons.medium_.launch(centre.source, 1, pass->channel, nullptr);
            const std::size_t first = photons.medium_.partOf(launch.inside);
            spaces_.push_back(pass->spaces[first].space);  // the pass's own samples
            launches_.push_back({launch.frame, spaces_.back(), launch.target, launch.spacing, launch.lit,
                                 launch.in_medium, nullptr, launch.inside, launch.across, launch.straight});
        }
        constexpr int kTries = 256;
        const PhotonPoints points(PhotonSampling::Quasi, dimensions(), 1, 1);
        for (int i = 0; i < kTries; ++i) {
            const std::array<double, 4> x = points.at(static_cast<std::uint64_t>(i));
            const LightSample sample = light_.sample(x[2], x[3]);
            requireWay(launches_.front(), sample, light);
            for (std::size_t p = 0; p < launches_.size(); ++p)
                estimated_power_ += channelMean(start(p, sample, x).power) / kTries;
        }
    }

    int dimensions() const override { return light_.dimensions(); }
    double estimatedPower() const override { return estimated_power_; }
    void follow(const std::array<double, 4>& x, double share, TrackSink& field, PhotonTally& tally) const override {
        const LightSample sample = light_.sample(x[2], x[3]);
        for (std::size_t p = 0; p < launches_.size(); ++p) {
            Photon photon = start(p, sample, x);
            photon.power *= share, photon.least *= share;
            if (!(channelMean(photon.power) > 0)) continue;
            tally.power.emitted += channelMean(photon.power);
            if (standsBefore(photons_.caster_, sample, photon.ray.position)) {
                tally.power.absorbed_surface += channelMean(photon.power);
                continue;
            }
            photons_.follow(*photons_.passes_[p], photon, field, tally);
        }
    }

private:
    /// Even over the part of the plane that a front would start from.
    Photon start(std::size_t pass, const LightSample& sample, const std::array<double, 4>& x) const {
        const FrontLaunch& launch = launches_[pass];
        if (standsAmong(launch, sample)) return startInLamp(pass, sample, x);
        const LaunchPlane plane(launch, sample);
        const FrontBox entry = entryOf(launch, sample);
        const int u = (plane.axis() + 1) % 3, v = (plane.axis() + 2) % 3;
        const glm::dvec2 low(entry.min[u], entry.min[v]), size(entry.max[u] - low.x, entry.max[v] - low.y);
        const glm::dvec2 uv = low + glm::dvec2(x[0], x[1]) * size;
        const double area = size.x * photons_.voxel_[u] * size.y * photons_.voxel_[v];
        const Front::Ray ray = plane.rayAt(uv);
        Photon photon;
        photon.ray = {photons_.frame_.worldFromIndex(ray.voxel), ray.momentum, 0};
        photon.power = plane.irradianceAt(uv) * area * photons_.passes_[pass]->channels;
        photon.lit = ray.lit;
        photon.inside = launch.inside, photon.start = photon.ray.position;
        photon.least = launch.space.limits.threshold * channelMean(photon.power);
        return photon;
    }

    /// Even over the directions that a lamp shines in.
    Photon startInLamp(std::size_t pass, const LightSample& sample, const std::array<double, 4>& x) const {
        const FrontLaunch& launch = launches_[pass];
        const Light& light = *sample.light;
        const double widest = light.type == LightType::Spot        ? 0.5 * light.cone_angle_deg * std::numbers::pi / 180
                              : light.type == LightType::Rectangle ? 0.5 * std::numbers::pi
                                                                   : std::numbers::pi;
        const double solid_angle = 2 * std::numbers::pi * (1 - std::cos(widest)),
                     cosine = 1 - x[0] * (1 - std::cos(widest)), sine = std::sqrt(std::max(0.0, 1 - cosine * cosine)),
                     turn = 2 * std::numbers::pi * x[1];
        const TangentFrame frame(sample.direction);
        const glm::dvec3 direction =
            cosine * sample.direction + sine * (std::cos(turn) * frame.across + std::sin(turn) * frame.up);
        Photon photon;
        photon.ray = {*sample.source, std::sqrt(2 * launch.space.halfSquareAt(*sample.source)) * direction, 0};
        photon.power =
            LaunchPlane(launch, sample).strengthTowards(direction) * solid_angle * photons_.passes_[pass]->channels;
        photon.lit = launch.lit || launch.in_medium(*sample.source);
        photon.inside = launch.inside, photon.start = photon.ray.position;
        photon.least = launch.space.limits.threshold * channelMean(photon.power);
        return photon;
    }

    const GradedPhotons& photons_;
    PhotonLight light_;
    std::vector<FrontSpace> spaces_;     // per pass
    std::vector<FrontLaunch> launches_;  // likewise
    double estimated_power_ = 0;
};

GradedPhotons::GradedPhotons(const Scene& scene, const GridFrame& frame, Monitor& monitor)
    : scene_(scene),
      frame_(frame),
      medium_(scene, frame, {kDiscSamples, SplineFit::Auto, 1}),
      caster_(scene),
      light_end_(scene, frame, caster_) {
    monitor.progress("index", 0);
    for (int channel = 0; channel < medium_.passes(); ++channel) {
        medium_.sample(channel, monitor);
        passes_.push_back(std::make_shared<const Pass>(medium_, channel));
        bytes_ += medium_.bytes();
    }
    monitor.progress("index", 1);
    const FrontSpace& space = medium_.space();
    low_world_ = frame.worldFromIndex(glm::dvec3(space.low) - 0.5);
    high_world_ = frame.worldFromIndex(glm::dvec3(space.high) + 0.5);
    for (int a = 0; a < 3; ++a) voxel_[a] = frame.worldFromIndex()[a][a];
    longest_ = kRounds * glm::distance(low_world_, high_world_);
}

std::unique_ptr<PhotonPaths> GradedPhotons::pathsOf(const Light& light) const {
    return std::make_unique<Paths>(*this, light);
}

bool GradedPhotons::inside(const glm::dvec3& world) const {
    const glm::dvec3 hair = 0.5 * kHairVoxels * voxel_;
    for (int a = 0; a < 3; ++a)
        if (!(world[a] >= low_world_[a] - hair[a] && world[a] <= high_world_[a] + hair[a])) return false;
    return true;
}

/// How far straight on a ray from beside the space comes into it, and a hair further [m]; infinity where it does not.
double GradedPhotons::distanceToSpace(const Photon& photon) const {
    return distanceInto({low_world_, high_world_}, photon.ray.position, glm::normalize(photon.ray.momentum)) +
           kHairVoxels * std::min({voxel_.x, voxel_.y, voxel_.z});
}

/// How far a ray goes in its block, or in all that has one index, and a hair further [m]; not beyond the space.
double GradedPhotons::straightThrough(const Space& space, const Photon& photon, const glm::ivec3& block) const {
    const glm::dvec3 direction = glm::normalize(photon.ray.momentum);
    double length = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a) {
        if (direction[a] == 0) continue;
        const double side = direction[a] > 0 ? high_world_[a] : low_world_[a];
        length = std::min(length, (side - photon.ray.position[a]) / direction[a]);
        if (!space.samples) continue;
        const int face = direction[a] > 0 ? block[a] + 1 : block[a];
        if (face == 0 || face == space.flat->count()[a]) continue;  // the rim's blocks have no end
        const SplineIndex::Nodes& nodes = space.samples->nodes();
        const double end = nodes.first_world[a] + face * FlatBlocks::kCells * nodes.spacing[a];
        length = std::min(length, (end - photon.ray.position[a]) / direction[a]);
    }
    return std::max(length, 0.0) + kHairVoxels * std::min({voxel_.x, voxel_.y, voxel_.z});
}

/// What a photon meets on a chord; not the surface that it leaves.
RayHit GradedPhotons::hitOn(const Photon& photon, const glm::dvec3& direction, double length, Meeting& meeting) const {
    const glm::dvec3& from = photon.ray.position;
    const OpticalScene* optics = medium_.optics();
    if (!optics) return caster_.empty() ? RayHit{} : caster_.firstHit(from, direction, length);
    RayHit hit = optics->firstHit(from, direction, length, meeting);
    // Met again by rounding.
    constexpr double kHair = 2e-3;  // voxels
    const double hair = kHair * std::min({voxel_.x, voxel_.y, voxel_.z});
    if (hit.target != Target{Target::Kind::Surface, photon.surface} ||
        glm::distance(from + hit.distance * direction, photon.start) >= hair)
        return hit;
    const double passed = hit.distance + hair;
    if (passed >= length) return {};
    hit = optics->firstHit(from + passed * direction, direction, length - passed, meeting);
    hit.distance += passed;
    return hit;
}

/// Lays a photon's light on the chord from where it is to a place, and moves it there, or to what it meets.
/// @return what it meets
RayHit GradedPhotons::layPiece(const Space& space, const glm::dvec3& to, Photon& photon, Meeting& meeting,
                               TrackSink& field, PhotonTally& tally) const {
    const glm::dvec3 from = photon.ray.position, chord = to - from;
    double length = glm::length(chord);
    if (!(length > 0)) return {};
    Track track;
    track.origin = from, track.direction = chord / length, track.power = photon.power;
    track.continues = photon.touched;
    const RayHit hit = hitOn(photon, track.direction, length, meeting);
    track.end = length;
    if (hit) track.end = light_end_.distance(from, track.direction, hit), length = hit.distance;
    const std::size_t medium = space.mediumAt(from + 0.5 * length * track.direction);
    for (int c = 0; c < 3 && medium > 0; ++c) track.extinction[c] = double(space.space.table.extinction[medium][c]);
    if (photon.lit) {
        const DepositedTrack deposited = field.deposit(track);
        tally.path += deposited.path;
        if (deposited.touched && !photon.touched) photon.touched = true, ++tally.deposited;
    }
    if (medium > 0)
        for (int c = 0; c < 3; ++c) {
            const double lost = -photon.power[c] * std::expm1(-track.extinction[c] * length);
            if (!(track.extinction[c] > 0)) continue;
            const double absorbed = std::min(1.0, space.space.absorption[medium][c] / track.extinction[c]);
            tally.power.absorbed_medium += lost * absorbed / 3, tally.power.scattered += lost * (1 - absorbed) / 3;
            photon.power[c] -= lost;
        }
    photon.way += length, photon.ray.position = hit ? from + length * track.direction : to;
    if (hit && hit.target.kind != Target::Kind::Surface) tally.power.received += channelMean(photon.power);
    return hit;
}

void GradedPhotons::follow(const Pass& pass, const Photon& photon, TrackSink& field, PhotonTally& tally) const {
    std::vector<Photon> waiting{photon};
    while (!waiting.empty()) {
        const Photon next = waiting.back();
        waiting.pop_back();
        followLeg(pass, next, waiting, field, tally);
    }
}

/// To the next surface, or to the photon's end.
void GradedPhotons::followLeg(const Pass& pass, Photon photon, std::vector<Photon>& waiting, TrackSink& field,
                              PhotonTally& tally) const {
    const Space& space = pass.spaces[medium_.partOf(photon.inside)];
    const double voxel = std::min({voxel_.x, voxel_.y, voxel_.z});
    Meeting meeting;
    // Slanting light crosses the launch plane beside the space.
    if (!inside(photon.ray.position)) {
        const double way = distanceToSpace(photon);
        if (std::isfinite(way)) {
            const glm::dvec3 direction = glm::normalize(photon.ray.momentum);
            const RayHit hit = layPiece(space, photon.ray.position + way * direction, photon, meeting, field, tally);
            if (hit) return meet(pass, photon, direction, hit, meeting, waiting, tally);
        }
    }
    std::optional<IndexSample> here;
    while (inside(photon.ray.position)) {
        GradedRay next = photon.ray;
        const glm::ivec3 block = space.samples ? space.flat->blockOf(space.nodeOf(photon.ray.position)) : glm::ivec3(0);
        if (!space.samples || space.flat->flat(block)) {
            next.position += straightThrough(space, photon, block) * glm::normalize(next.momentum);
            here.reset();
        } else {
            if (!here) here = space.index->at(photon.ray.position);
            // Rings of a spline through samples may leave no index at all beside a jump.
            if (photon.way > longest_ || !(here->half_square > 0)) {
                tally.power.dropped += channelMean(photon.power);
                return;
            }
            const double length = stepLength(*here, voxel) * voxel / std::sqrt(2 * here->half_square);
            here = stepYoshida(*space.index, length, next);
        }
        // A piece counts by its middle, as a layer of a front does.
        if (!photon.lit) {
            const double middle = space.halfSquareAt(0.5 * (photon.ray.position + next.position));
            photon.lit = std::fabs(middle - 0.5) > double(space.space.least_lit);
        }
        const glm::dvec3 before = photon.ray.momentum, from = photon.ray.position;
        const RayHit hit = layPiece(space, next.position, photon, meeting, field, tally);
        if (hit) {
            const double share = hit.distance / glm::distance(from, next.position);
            return meet(pass, photon, glm::normalize(glm::mix(before, next.momentum, share)), hit, meeting, waiting,
                        tally);
        }
        photon.ray.momentum = next.momentum;
    }
    (photon.touched ? tally.power.escaped : tally.power.culled) += channelMean(photon.power);
}

/// At a surface: each branch is a photon of its own.
void GradedPhotons::meet(const Pass& pass, const Photon& photon, const glm::dvec3& direction, const RayHit& hit,
                         const Meeting& meeting, std::vector<Photon>& waiting, PhotonTally& tally) const {
    if (hit.target.kind != Target::Kind::Surface) return;
    const FrontLimits& limits = pass.spaces.front().space.limits;
    const double power = channelMean(photon.power);
    if (photon.events >= limits.events || power < photon.least) {
        tally.power.dropped += power;
        return;
    }
    const auto halfSquare = [&](const MediumStack& stack) {
        return pass.spaces[medium_.partOf(stack)].halfSquareAt(meeting.position);
    };
    const OpticalScene::Event event =
        medium_.optics()->eventBetween(hit.target.index, photon.inside, direction, meeting, [&](int medium) {
            return std::sqrt(std::max(2 * pass.spaces[medium_.partOf(medium)].halfSquareAt(meeting.position), 1e-6));
        });
    Photon next = photon;
    next.ray.position = next.start = meeting.position, next.surface = hit.target.index, next.lit = true;
    const auto send = [&](const glm::dvec3& to, const glm::dvec3& fraction, const MediumStack& inside) {
        next.power = fraction * photon.power, next.inside = inside;
        next.ray.momentum = std::sqrt(2 * std::max(halfSquare(inside), 1e-12)) * to;
        if (channelMean(next.power) > 0) waiting.push_back(next);
    };
    if (event.void_surface) return send(direction, glm::dvec3(1), event.beyond);
    ++next.events;
    tally.power.reflected += event.light.untraced * power;
    tally.power.dropped += event.light.dropped * power;
    tally.power.absorbed_surface += channelMean(event.light.absorbed * photon.power);
    for (int b = 0; b < event.light.count; ++b) {
        const SpecularBranch& branch = event.light.branches[static_cast<std::size_t>(b)];
        send(branch.direction, branch.fraction, branch.crosses ? event.beyond : photon.inside);
    }
}

}  // namespace photic
