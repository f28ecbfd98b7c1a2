// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/graded_photons.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

#include "bake/graded/ray_integrator.h"
#include "bake/methods/front_obstacles.h"
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

/// What one channel's light, or that of all channels, goes through.
struct GradedPhotons::Pass {
    std::shared_ptr<const SplineIndex> samples;
    SplineGradedIndex index;
    FrontSpace space;
    FlatBlocks flat;
    glm::dvec3 channels{1};  // that it is of
    int channel = 0;

    Pass(const GradedSpace& medium, int number)
        : samples(medium.index()),
          index(*samples),
          space(medium.space()),
          flat(*samples, space.media),
          channel(number) {
        if (medium.passes() > 1) channels = glm::dvec3(0), channels[number] = 1;
    }
    glm::dvec3 nodeOf(const glm::dvec3& world) const {
        return (world - samples->nodes().first_world) / samples->nodes().spacing;
    }
    /// What attenuates at a place, by its number in the space; 0: nothing.
    std::size_t mediumAt(const glm::dvec3& world) const {
        if (space.media.empty()) return 0;
        const glm::ivec3 count = samples->nodes().count,
                         node = glm::clamp(glm::ivec3(glm::round(nodeOf(world))), glm::ivec3(0), count - 1);
        return space.media[(static_cast<std::size_t>(node.z) * static_cast<std::size_t>(count.y) +
                            static_cast<std::size_t>(node.y)) *
                               static_cast<std::size_t>(count.x) +
                           static_cast<std::size_t>(node.x)];
    }
};

struct GradedPhotons::Photon {
    GradedRay ray;
    glm::dvec3 power{0};
    bool lit = false;      // it has been in a medium
    bool touched = false;  // a needed voxel
    double way = 0;        // [m]
};

/// The photons of one light.
class GradedPhotons::Paths final : public PhotonPaths {
public:
    Paths(const GradedPhotons& photons, const Light& light) : photons_(photons), light_(light) {
        const bool all = photons.scene_.bake.paths == Paths_::All;
        for (const auto& pass : photons.passes_)
            launches_.push_back({photons.frame_, pass->space, photons.medium_.target(), 1, all,
                                 [&photons, channel = pass->channel](const glm::dvec3& world) {
                                     return photons.medium_.media().at(world, channel) >= 0;
                                 }});
        constexpr int kTries = 256;
        const PhotonPoints points(PhotonSampling::Quasi, dimensions(), 1, 1);
        for (int i = 0; i < kTries; ++i) {
            const std::array<double, 4> x = points.at(static_cast<std::uint64_t>(i));
            const LightSample sample = light_.sample(x[2], x[3]);
            refuseLampWithin(LaunchPlane(launches_.front(), sample), light);
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
            photon.power *= share;
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
    using Paths_ = photic::Paths;

    /// Even over the part of the plane that a front would start from.
    Photon start(std::size_t pass, const LightSample& sample, const std::array<double, 4>& x) const {
        const FrontLaunch& launch = launches_[pass];
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
        return photon;
    }

    const GradedPhotons& photons_;
    PhotonLight light_;
    std::vector<FrontLaunch> launches_;  // per pass
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

/// How far a ray goes in its block, and a hair further [m]; not beyond the space.
double GradedPhotons::straightThrough(const Pass& pass, const Photon& photon, const glm::ivec3& block) const {
    const glm::dvec3 direction = glm::normalize(photon.ray.momentum), spacing = pass.samples->nodes().spacing,
                     first = pass.samples->nodes().first_world;
    double length = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a) {
        if (direction[a] == 0) continue;
        const int side = direction[a] > 0 ? block[a] + 1 : block[a];
        const bool rim = side == 0 || side == pass.flat.count()[a];
        const double space = direction[a] > 0 ? high_world_[a] : low_world_[a];
        const double end = rim ? space : first[a] + side * FlatBlocks::kCells * spacing[a];
        length = std::min(
            {length, (end - photon.ray.position[a]) / direction[a], (space - photon.ray.position[a]) / direction[a]});
    }
    return std::max(length, 0.0) + kHairVoxels * std::min({voxel_.x, voxel_.y, voxel_.z});
}

/// Lays a photon's light on the chord from where it is to a place, and moves it there.
/// @return false where an object ends it
bool GradedPhotons::layPiece(const Pass& pass, const glm::dvec3& to, Photon& photon, TrackSink& field,
                             PhotonTally& tally) const {
    const glm::dvec3 from = photon.ray.position, chord = to - from;
    double length = glm::length(chord);
    if (!(length > 0)) return true;
    const std::size_t medium = pass.mediumAt(0.5 * (from + to));
    Track track;
    track.origin = from, track.direction = chord / length, track.power = photon.power;
    track.end = length, track.continues = photon.touched;
    for (int c = 0; c < 3 && medium > 0; ++c) track.extinction[c] = double(pass.space.table.extinction[medium][c]);
    RayHit hit;
    if (!caster_.empty()) hit = caster_.firstHit(from, track.direction, length);
    if (hit) track.end = light_end_.distance(from, track.direction, hit), length = hit.distance;
    if (photon.lit) {
        const DepositedTrack deposited = field.deposit(track);
        tally.path += deposited.path;
        if (deposited.touched && !photon.touched) photon.touched = true, ++tally.deposited;
    }
    if (medium > 0)
        for (int c = 0; c < 3; ++c) {
            const double lost = -photon.power[c] * std::expm1(-track.extinction[c] * length);
            if (!(track.extinction[c] > 0)) continue;
            const double absorbed = std::min(1.0, pass.space.absorption[medium][c] / track.extinction[c]);
            tally.power.absorbed_medium += lost * absorbed / 3, tally.power.scattered += lost * (1 - absorbed) / 3;
            photon.power[c] -= lost;
        }
    photon.way += length, photon.ray.position = to;
    if (hit) tally.power.received += channelMean(photon.power);
    return !hit;
}

void GradedPhotons::follow(const Pass& pass, Photon photon, TrackSink& field, PhotonTally& tally) const {
    const double voxel = std::min({voxel_.x, voxel_.y, voxel_.z});
    // Slanting light crosses the launch plane beside the space.
    if (!inside(photon.ray.position)) {
        const double way = distanceToSpace(photon);
        if (std::isfinite(way) &&
            !layPiece(pass, photon.ray.position + way * glm::normalize(photon.ray.momentum), photon, field, tally))
            return;
    }
    std::optional<IndexSample> here;
    while (inside(photon.ray.position)) {
        GradedRay next = photon.ray;
        const glm::ivec3 block = pass.flat.blockOf(pass.nodeOf(photon.ray.position));
        if (pass.flat.flat(block)) {
            next.position += straightThrough(pass, photon, block) * glm::normalize(next.momentum);
            here.reset();
        } else {
            if (!here) here = pass.index.at(photon.ray.position);
            // Rings of a spline through samples may leave no index at all beside a jump.
            if (photon.way > longest_ || !(here->half_square > 0)) {
                tally.power.dropped += channelMean(photon.power);
                return;
            }
            const double length = stepLength(*here, voxel) * voxel / std::sqrt(2 * here->half_square);
            here = stepYoshida(pass.index, length, next);
        }
        // A piece counts by its middle, as a layer of a front does.
        if (!photon.lit) {
            const double middle = pass.index.at(0.5 * (photon.ray.position + next.position)).half_square;
            photon.lit = std::fabs(middle - 0.5) > double(pass.space.least_lit);
        }
        const glm::dvec3 momentum = next.momentum;
        if (!layPiece(pass, next.position, photon, field, tally)) return;
        photon.ray.momentum = momentum;
    }
    (photon.touched ? tally.power.escaped : tally.power.culled) += channelMean(photon.power);
}

}  // namespace photic
