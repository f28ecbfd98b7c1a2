// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "bake/paths/light_end.h"
#include "bake/paths/path.h"
#include "bake/paths/ray_casting.h"
#include "bake/paths/specular_event.h"
#include "bake/paths/triangle_tree.h"
#include "bake/report/bake_report.h"
#include "bake/scene/scene.h"

namespace photic {

/// What fills a part of space, as light sees it.
struct OpticalMedium {
    double ior = 1;
    glm::dvec3 absorption{0}, scattering{0};  ///< per channel [1/m]
    glm::dvec3 extinction() const { return absorption + scattering; }
    bool clear() const { return extinction() == glm::dvec3(0); }
};

/// The media on either side of a surface, in OpticalScene::media.
struct MediumSides {
    int outside = 0;  ///< on the side of the normal: ior_above
    int inside = 0;
};

/// Shares the power of a leg out between the medium that it runs through and what is at its end (Beer-Lambert).
/// @param power   at the leg's start, per channel [W]
/// @param length  [m]
/// @param end     the term of the ledger that what is left belongs to
/// @return what is left, per channel [W]
glm::dvec3 countLeg(const OpticalMedium& medium, const glm::dvec3& power, double length, double PowerLedger::*end,
                    PowerLedger& ledger);

/// Mean of the channels: what the ledgers count.
inline double channelMean(const glm::dvec3& power) { return (power.x + power.y + power.z) / 3; }

/// A scene as every tracer sees it: what stands in it, where deposits end in the grid, and what lies on either side of
/// each surface. Built once a bake and shared by all lights. Thread-safe.
class OpticalScene {
public:
    OpticalScene(const Scene& scene, const GridFrame& frame);

    const Scene& scene() const { return scene_; }
    const GridFrame& frame() const { return frame_; }
    const RayCaster& caster() const { return caster_; }
    const TriangleTree& tree() const { return tree_; }
    const OpticalMedium& medium(int index) const { return media_[static_cast<std::size_t>(index)]; }
    const MediumSides& sides(int surface) const { return sides_[static_cast<std::size_t>(surface)]; }
    /// The planes that block light.
    const std::vector<Plane>& planes() const { return planes_; }

    /// Whether light from far away along `direction` reaches a point of a surface, or what it meets before.
    PathOutcome arrival(const glm::dvec3& point, const glm::dvec3& direction) const;

    /// Casts a leg and finds where its deposit ends.
    struct LegEnd {
        RayHit hit;
        double deposit_end;  ///< [m]; infinity without a hit
    };
    LegEnd legEnd(const glm::dvec3& origin, const glm::dvec3& direction) const;

private:
    const Scene& scene_;
    GridFrame frame_;
    RayCaster caster_;
    TriangleTree tree_;
    LightEnd light_end_;
    std::vector<OpticalMedium> media_;
    std::vector<MediumSides> sides_;
    std::vector<Plane> planes_;
};

}  // namespace photic
