// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/lobe_axis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <vector>

#include "bake/methods/photon_launch.h"
#include "bake/methods/photon_tracer.h"

namespace photic {
namespace {

constexpr int kCellsASide = 24, kStepsASide = 48;
constexpr double kPhotons = 6000;       // in all
constexpr double kWorthParting = 4e-3;  // of the light: variance of directions along the axis, where they meet

/// Moments of the directions of light in one cell.
struct CellLight {
    double irradiance = 0;
    glm::dvec3 flux{0};
    glm::dmat3 spread{0.0};  // sum of power x length x w w^T
};

/// Sums the directions of tracks on coarse cells: what PhotonTracer tells it.
class DirectionCells final : public TrackSink {
public:
    explicit DirectionCells(const GridFrame& frame)
        : frame_(frame), cells_(static_cast<std::size_t>(kCellsASide) * kCellsASide * kCellsASide) {}

    DepositedTrack deposit(const Track& track) override {
        const double length = track.end - track.begin;
        if (!(length > 0) || !std::isfinite(length)) return {};
        const double power = (track.power.x + track.power.y + track.power.z) / 3;
        const glm::dvec3 size(frame_.size());
        const glm::dmat3 outer = glm::outerProduct(track.direction, track.direction);
        const int steps = kStepsASide;
        for (int s = 0; s < steps; ++s) {
            const glm::dvec3 p = track.origin + track.direction * (track.begin + length * (s + 0.5) / steps);
            const glm::dvec3 part = (frame_.indexFromWorld(p) - glm::dvec3(frame_.min) + 0.5) / size;
            const glm::ivec3 cell =
                glm::clamp(glm::ivec3(part * double(kCellsASide)), glm::ivec3(0), glm::ivec3(kCellsASide - 1));
            CellLight& to = cells_[static_cast<std::size_t>((cell.x * kCellsASide + cell.y) * kCellsASide + cell.z)];
            const double w = power * length / steps;
            to.irradiance += w, to.flux += w * track.direction, to.spread += w * outer;
        }
        return {true, power * length};
    }

    /// All light; its flux; and how far directions differ that meet in a cell.
    CellLight together() const {
        CellLight all;
        for (const CellLight& cell : cells_) {
            if (!(cell.irradiance > 0)) continue;
            all.irradiance += cell.irradiance, all.flux += cell.flux;
            all.spread += cell.spread - glm::outerProduct(cell.flux, cell.flux) / cell.irradiance;
        }
        return all;
    }

private:
    const GridFrame& frame_;
    std::vector<CellLight> cells_;
};

/// The axes through opposite sides, edges and corners of a cube, each once.
std::vector<glm::dvec3> candidateAxes() {
    std::vector<glm::dvec3> axes;
    for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z) {
                const int first = x != 0 ? x : y != 0 ? y : z;
                if (first > 0) axes.push_back(glm::normalize(glm::dvec3(x, y, z)));
            }
    // Sides before edges before corners where they part equally well.
    std::stable_sort(axes.begin(), axes.end(), [](const glm::dvec3& a, const glm::dvec3& b) {
        const auto most = [](const glm::dvec3& v) {
            return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
        };
        return most(a) > most(b) + 1e-9;
    });
    return axes;
}

}  // namespace

bool lightCanOppose(const Scene& scene) {
    if (scene.lights.size() > 1 || scene.surfaces.size() > 1) return true;
    return std::any_of(scene.surfaces.begin(), scene.surfaces.end(),
                       [](const Surface& s) { return s.closed || s.sphere || s.event != SurfaceEvent::Refract; });
}

std::optional<glm::dvec3> lobeAxis(const Scene& scene, const GridFrame& frame) {
    if (!lightCanOppose(scene)) return std::nullopt;
    constexpr int kWavelengths = 3;
    const std::vector<SpectralSample> spectrum = spectralSamples(kWavelengths);
    const PhotonTracer tracer(scene, frame, spectrum);
    std::vector<PhotonLaunch> launches;
    double power = 0;
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i)
        for (const Light& light : scene.lights) {
            launches.emplace_back(scene, static_cast<int>(i), light, frame);
            power += launches.back().estimatedPower();
        }
    DirectionCells cells(frame);
    PhotonTally tally;
    for (std::size_t j = 0; j < launches.size(); ++j) {
        const PhotonLaunch& launch = launches[j];
        if (launch.empty()) continue;
        const auto paths = static_cast<std::uint64_t>(std::ceil(kPhotons * launch.estimatedPower() / power));
        const PhotonPoints points(PhotonSampling::Quasi, launch.dimensions(), 0, j);
        for (std::uint64_t i = 0; i < paths; ++i) {
            const PhotonStart start = launch.start(points.at(i));
            if (channelMean(start.power) > 0)
                tracer.follow(launch.surface(), start, start.power / static_cast<double>(paths), cells, tally);
        }
    }
    const CellLight all = cells.together();
    if (!(all.irradiance > 0)) return std::nullopt;
    glm::dvec3 best(0);
    double most = 0;
    for (const glm::dvec3& axis : candidateAxes()) {
        const double spread = glm::dot(axis, all.spread * axis);
        if (spread > 1.001 * most) best = axis, most = spread;
    }
    if (most < kWorthParting * all.irradiance) return std::nullopt;
    return glm::dot(best, all.flux) < -0.02 * all.irradiance ? -best : best;
}

}  // namespace photic
