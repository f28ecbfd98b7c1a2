// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "bake/methods/photons.h"
#include "bake/paths/launch_domain.h"
#include "bake/scene/scene.h"

namespace photic {

/// Points of the unit cube of 2 or 4 dimensions, for one shift of one light and surface.
/// In 64-bit fixed point: the R sequence alpha_j = phi^-(j+1), phi^(d+1) = phi + 1, stays exact for any index.
class PhotonPoints {
public:
    /// @param stream  of random numbers: different for every light, surface and shift
    PhotonPoints(PhotonSampling sampling, int dimensions, std::uint64_t seed, std::uint64_t stream);
    /// Coordinates in [0, 1); those past the dimensions asked for are 0.5.
    std::array<double, 4> at(std::uint64_t index) const;

private:
    PhotonSampling sampling_;
    int dimensions_;
    std::uint64_t key_;
    std::array<std::uint64_t, 4> alpha_{}, shift_{};
};

/// A photon on its specular surface, before the event.
struct PhotonStart {
    glm::dvec3 position{0};
    glm::dvec3 direction{0};        ///< unit, of travel
    glm::dvec3 normal{0}, face{0};  ///< unit; on the side of ior_above
    double area = 0;  ///< of the beam that the sample stands for [m2], divided by nothing: the mean over samples is the
                      ///< lit cross-section. 0 when the surface turns away from the light
};

/// One light on one surface: where photons start.
class PhotonLaunch {
public:
    PhotonLaunch(const Scene& scene, const Surface& surface, const Light& light, const GridFrame& frame);

    const Surface& surface() const { return *surface_; }
    const Light& light() const { return *light_; }
    /// No light can reach the grid.
    bool empty() const { return cross_section_ <= 0; }
    /// About the beam's cross-section that is launched [m2]: for sharing out paths.
    double crossSection() const { return cross_section_; }
    /// False when the launched rectangle had to be cut off (LaunchDomain::complete).
    bool complete() const { return domain_.complete; }
    /// Of the sample points: 2 for a point sun, 4 with its disc.
    int dimensions() const { return cap_height_ > 0 ? 4 : 2; }

    PhotonStart start(const std::array<double, 4>& x) const;

private:
    glm::dvec3 sunDirection(double a, double b) const;
    void startOnMesh(double u, double v, PhotonStart& out) const;

    const Surface* surface_;
    const Light* light_;
    LaunchDomain domain_;
    double cross_section_ = 0;
    glm::dvec3 across_{0}, up_{0};    // with the light's direction, a frame
    double cap_height_ = 0;           // 1 - cos of the disc's angular radius
    std::vector<double> cumulative_;  // meshes: of each triangle's share, last is 1
    std::vector<double> share_;       // [m2], before normalisation
};

}  // namespace photic
