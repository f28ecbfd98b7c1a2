// SPDX-License-Identifier: Apache-2.0
#include "tests/support/landed_light.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <variant>

#include "bake/field/scene_grid.h"
#include "bake/methods/photon_launch.h"
#include "bake/methods/photon_tracer.h"
#include "bake/picture/receiver_picture.h"
#include "bake/picture/volume_lookup.h"
#include "bake/threads/parallel_for.h"

namespace photic::support {
namespace {

/// Power per texel of each side of each plane: what PhotonTracer tells its tracks to.
class LandingCounter final : public TrackSink {
public:
    explicit LandingCounter(const std::vector<PlaneTexels>& planes) : planes_(planes) {
        for (const PlaneTexels& plane : planes)
            sums_.emplace_back(2 * static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(plane.rows));
    }

    DepositedTrack deposit(const Track& track) override {
        for (std::size_t k = 0; k < planes_.size(); ++k) {
            const PlaneTexels& plane = planes_[k];
            const double facing = glm::dot(track.direction, plane.normal);
            if (facing == 0) continue;
            const double t = glm::dot(plane.origin - track.origin, plane.normal) / facing;
            // A receiver ends its own tracks: by rounding they may fall a hair short of it.
            const double hair = 1e-9 * (1 + std::fabs(t));
            if (t < track.begin - hair || t > track.end + hair) continue;
            const glm::dvec3 at = track.origin + t * track.direction - plane.origin;
            const double side2 = plane.side() * plane.side();
            const double x = std::floor(glm::dot(at, plane.right) / side2),
                         y = std::floor(glm::dot(at, plane.up) / side2);
            if (x < 0 || y < 0 || x >= plane.columns || y >= plane.rows) continue;
            double power = 0;
            for (int c = 0; c < 3; ++c) power += track.power[c] * std::exp(-track.extinction[c] * t) / 3;
            const auto texel =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(plane.columns) + static_cast<std::size_t>(x);
            sums_[k][2 * texel + (facing > 0 ? 1 : 0)] += power / side2;
        }
        return {true, 0};
    }

    const std::vector<std::vector<double>>& sums() const { return sums_; }

private:
    const std::vector<PlaneTexels>& planes_;
    std::vector<std::vector<double>> sums_;  // of each plane: front and back of each texel [W/m2]
};

FaceLight faceOf(const std::vector<LandingCounter>& repetitions, std::size_t plane, std::size_t side) {
    FaceLight face;
    const std::size_t texels = repetitions.front().sums()[plane].size() / 2;
    const auto n = static_cast<double>(repetitions.size());
    for (std::size_t t = 0; t < texels; ++t) {
        double sum = 0, squares = 0;
        for (const LandingCounter& one : repetitions) sum += one.sums()[plane][2 * t + side];
        for (const LandingCounter& one : repetitions) squares += std::pow(one.sums()[plane][2 * t + side] - sum / n, 2);
        face.mean.push_back(sum / n), face.error.push_back(std::sqrt(squares / (n - 1) / n));
    }
    return face;
}

PlaneTexels squares(const glm::dvec3& origin, const glm::dvec3& across, const glm::dvec3& up, double side) {
    PlaneTexels texels;
    const glm::dvec3 right = glm::normalize(across), upright = glm::normalize(up);
    texels.origin = origin, texels.right = side * right, texels.up = side * upright;
    texels.normal = glm::cross(right, upright);
    texels.columns = static_cast<int>(glm::length(across) / side + 1e-6);
    texels.rows = static_cast<int>(glm::length(up) / side + 1e-6);
    return texels;
}

/// Whether a sphere around a point holds part of a glass or mirror surface.
class NearSurfaces {
public:
    NearSurfaces(const Scene& scene, double reach) : scene_(scene), reach_(reach) {}
    bool holds(const glm::dvec3& point) const {
        return std::any_of(scene_.surfaces.begin(), scene_.surfaces.end(), [&](const Surface& s) {
            if (s.sphere) return std::fabs(glm::length(point - s.sphere->center) - s.sphere->radius) < reach_;
            return s.mesh && meets(*s.mesh, point);
        });
    }

private:
    /// A triangle is near where the point is near its plane and, in its plane, near the triangle.
    bool meets(const TriangleMesh& mesh, const glm::dvec3& point) const {
        for (const auto& t : mesh.triangles) {
            const glm::dvec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
            const glm::dvec3 low = glm::min(glm::min(a, b), c) - reach_, high = glm::max(glm::max(a, b), c) + reach_;
            if (glm::any(glm::lessThan(point, low)) || glm::any(glm::greaterThan(point, high))) continue;
            const glm::dvec3 cross = glm::cross(b - a, c - a);
            const double area = glm::length(cross);
            if (!(area > 0) || std::fabs(glm::dot(point - a, cross)) < reach_ * area) return true;
        }
        return false;
    }
    const Scene& scene_;
    double reach_;
};

bool isHidden(const Scene& scene, const std::string& but, const glm::dvec3& point, double margin) {
    return std::any_of(scene.objects.begin(), scene.objects.end(), [&](const Object& object) {
        const Plane* plane = std::get_if<Plane>(&object.shape);
        return plane && object.blocks() && object.name != but && glm::dot(plane->normal, point - plane->point) < margin;
    });
}

}  // namespace

std::vector<PlaneLight> landedLight(const Scene& scene, const GridFrame& frame, const std::vector<PlaneTexels>& planes,
                                    const LandedOptions& options) {
    const std::vector<SpectralSample> spectrum = spectralSamples(options.wavelengths);
    const PhotonTracer tracer(scene, frame, spectrum);
    std::vector<PhotonLaunch> launches;
    double power = 0;
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i)
        for (const Light& light : scene.lights) {
            launches.emplace_back(scene, static_cast<int>(i), light, frame);
            power += launches.back().estimatedPower();
        }
    std::vector<LandingCounter> repetitions(static_cast<std::size_t>(options.shifts), LandingCounter(planes));
    parallelFor(options.shifts, [&](std::int64_t shift) {
        LandingCounter& counter = repetitions[static_cast<std::size_t>(shift)];
        PhotonTally tally;
        for (std::size_t j = 0; j < launches.size(); ++j) {
            const PhotonLaunch& launch = launches[j];
            if (launch.empty()) continue;
            const auto paths = static_cast<std::uint64_t>(
                std::ceil(static_cast<double>(options.count) / options.shifts * launch.estimatedPower() / power));
            const PhotonPoints points(options.sampling, launch.dimensions(), 7,
                                      static_cast<std::uint64_t>(shift) * launches.size() + j);
            for (std::uint64_t i = 0; i < paths; ++i) {
                const PhotonStart start = launch.start(points.at(i));
                if (channelMean(start.power) > 0)
                    tracer.follow(launch.surface(), start, start.power / static_cast<double>(paths), counter, tally);
            }
        }
    });
    std::vector<PlaneLight> out;
    for (std::size_t k = 0; k < planes.size(); ++k)
        out.push_back({faceOf(repetitions, k, 0), faceOf(repetitions, k, 1)});
    return out;
}

std::vector<LookedAt> planesOf(const Scene& scene, double voxels) {
    const double side = voxels * scene.domain.voxel_size;
    std::vector<LookedAt> planes;
    for (const std::string& name : planarReceivers(scene)) {
        const PictureFrame frame = receiverFrame(scene, name, 64);
        planes.push_back({name, squares(frame.origin, frame.across, frame.up, side)});
        planes.back().texels.normal = frame.normal;
    }
    const glm::dvec3 low = scene.domain.min, size = scene.domain.max - low;
    // A little beside the middle, where symmetric scenes have edges.
    const glm::dvec3 at = low + glm::dvec3(0.47, 0.53, 0.48) * size;
    planes.push_back({"card across x", squares({at.x, low.y, low.z}, {0, size.y, 0}, {0, 0, size.z}, side)});
    planes.push_back({"card across y", squares({low.x, at.y, low.z}, {size.x, 0, 0}, {0, 0, size.z}, side)});
    planes.push_back({"card across z", squares({low.x, low.y, at.z}, {size.x, 0, 0}, {0, size.y, 0}, side)});
    return planes;
}

std::vector<double> lookedUpLight(const Scene& scene, const LightVolume& volume, const LookedAt& plane, bool front) {
    const PlaneTexels& texels = plane.texels;
    const VolumeLookup lookup(volume);
    const double voxel = scene.domain.voxel_size, side = texels.side();
    const int points = std::max(2, static_cast<int>(std::ceil(3 * side / voxel)));
    const NearSurfaces near(scene, 2 * voxel + 0.75 * side);
    const glm::dvec3 normal = front ? texels.normal : -texels.normal;
    std::vector<double> out(static_cast<std::size_t>(texels.columns) * static_cast<std::size_t>(texels.rows));
    parallelFor(texels.rows, [&](std::int64_t row) {
        const int j = static_cast<int>(row);
        for (int i = 0; i < texels.columns; ++i) {
            double& value = out[static_cast<std::size_t>(j * texels.columns + i)];
            const glm::dvec3 centre = texels.centre(i, j);
            value = std::nan("");
            if (isHidden(scene, plane.name, centre, 2 * voxel + 0.5 * side) || near.holds(centre)) continue;
            glm::dvec3 sum(0);

            for (int b = 0; b < points; ++b)
                for (int a = 0; a < points; ++a) {
                    const glm::dvec3 at =
                        texels.origin + (i + (a + 0.5) / points) * texels.right + (j + (b + 0.5) / points) * texels.up;
                    sum += lookup.receiverIrradiance(at, normal);
                }

            value = channelMean(sum) / (points * points);
        }
    });
    return out;
}

Agreement agreementOf(const std::vector<double>& found, const FaceLight& landed) {
    Agreement a;
    for (std::size_t t = 0; t < found.size(); ++t) {
        if (!std::isfinite(found[t])) continue;
        ++a.texels;
        a.light += landed.mean[t], a.found += found[t], a.apart += std::fabs(found[t] - landed.mean[t]);
        a.noise += std::sqrt(2 / std::numbers::pi) * landed.error[t];
    }
    if (a.light > 0) a.apart /= a.light, a.noise /= a.light;
    return a;
}

}  // namespace photic::support
