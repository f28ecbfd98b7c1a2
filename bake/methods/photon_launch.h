// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "bake/methods/photons.h"
#include "bake/paths/emission.h"
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
    glm::dvec3 direction{0};           ///< unit, of travel
    std::optional<glm::dvec3> source;  ///< of a lamp [m]
    glm::dvec3 normal{0}, face{0};     ///< unit; on the side of ior_above
    glm::dvec3 power{0};  ///< that the sample stands for, per channel [W]: the mean over samples is what enters through
                          ///< the surface. 0 when the surface turns away from the light
};

/// A light as photons leave it: each from its own direction of the sun's disc, or its own place of a rectangle.
class PhotonLight {
public:
    explicit PhotonLight(const Light& light);
    const Light& light() const { return *light_; }
    /// Of the sample points that a photon takes: 2 for a point, 4 with a disc or a rectangle.
    int dimensions() const { return cap_height_ > 0 || light_->type == LightType::Rectangle ? 4 : 2; }
    /// @param a, b  in [0, 1)
    LightSample sample(double a, double b) const;

private:
    const Light* light_;
    LightSample centre_;     // of the disc
    double cap_height_ = 0;  // 1 - cos of the disc's angular radius
};

/// One light on one surface: where photons start.
class PhotonLaunch {
public:
    /// @param surface  in Scene::surfaces
    PhotonLaunch(const Scene& scene, int surface, const Light& light, const GridFrame& frame);

    int surface() const { return surface_index_; }
    const Light& light() const { return light_.light(); }
    /// No light can reach the grid.
    bool empty() const { return !(estimated_power_ > 0); }
    /// About the power that is launched, mean of the channels [W]: for sharing out paths.
    double estimatedPower() const { return estimated_power_; }
    /// False when the launched rectangle had to be cut off (LaunchDomain::complete).
    bool complete() const { return domain_.complete; }
    /// Of the sample points.
    int dimensions() const { return light_.dimensions(); }

    PhotonStart start(const std::array<double, 4>& x) const;

private:
    /// Where a sample lands on the surface, and the oriented area that it stands for [m2]; false where there is none.
    bool place(double u, double v, PhotonStart& out, glm::dvec3& area) const;
    bool placeOnMesh(double u, double v, PhotonStart& out, glm::dvec3& area) const;
    /// Part of a triangle, or all of it, from which photons start as densely as anywhere in it.
    struct Piece {
        std::uint32_t triangle = 0;
        std::array<glm::dvec2, 3> corners{glm::dvec2(0, 0), {1, 0}, {0, 1}};  ///< shares of its second and third vertex
        double part = 1;                                                      ///< of the triangle's area
    };
    void divideMesh();
    void addPieces(const Piece& piece, int depth);
    void addPiece(double share);

    const Scene* scene_;
    int surface_index_;
    const Surface* surface_;
    PhotonLight light_;
    LaunchDomain domain_;
    bool from_below_ = false;  // the lamp stands under the height field
    double estimated_power_ = 0;
    std::vector<Piece> pieces_;       // of a mesh under a lamp; of a sun it is the triangles that are chosen among
    std::vector<double> cumulative_;  // meshes: of each piece's share, last is 1
    std::vector<double> share_;       // about what light it gets, before normalisation
    double total_share_ = 0;
};

}  // namespace photic
