// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/optical_scene.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "bake/optics/beer_lambert.h"

namespace photic {

glm::dvec3 countLeg(const OpticalMedium& medium, const glm::dvec3& power, double length, double PowerLedger::*end,
                    PowerLedger& ledger) {
    glm::dvec3 left = power;
    if (!medium.clear())
        for (int c = 0; c < 3; ++c) {
            const double extinction = medium.absorption[c] + medium.scattering[c];
            if (extinction <= 0) continue;
            const double depth = extinction * length;
            // 1 - exp(-depth), without cancellation; everything for a leg without end.
            const double lost = std::isfinite(depth) ? power[c] * depth * meanTransmittance(depth) : power[c];
            ledger.absorbed_medium += lost * medium.absorption[c] / extinction / 3;
            ledger.scattered += lost * medium.scattering[c] / extinction / 3;
            left[c] = power[c] - lost;
        }
    ledger.*end += channelMean(left);
    return left;
}

OpticalScene::OpticalScene(const Scene& scene, const GridFrame& frame)
    : scene_(scene), frame_(frame), caster_(scene), tree_(scene), light_end_(scene, frame, caster_) {
    for (const Surface& surface : scene.surfaces) {
        MediumSides sides{static_cast<int>(media_.size()), static_cast<int>(media_.size()) + 1};
        media_.push_back({surface.ior_above, glm::dvec3(0), glm::dvec3(0)});
        media_.push_back({surface.ior_below, scene.medium.absorption, scene.medium.scattering});
        sides_.push_back(sides);
    }
    for (const Object& object : scene.objects)
        if (const Plane* plane = std::get_if<Plane>(&object.shape); plane && object.blocks()) planes_.push_back(*plane);
}

PathOutcome OpticalScene::arrival(const glm::dvec3& point, const glm::dvec3& direction) const {
    if (caster_.empty()) return PathOutcome::Lit;
    const RayHit back = caster_.firstHit(point, -direction);
    if (!back) return PathOutcome::Lit;
    // Something stands between. What light meets first decides: an object keeps it, a surface has launched it.
    const double far = glm::length(point - caster_.meshCentre()) + 2 * caster_.meshRadius() + back.distance;
    const RayHit first = caster_.firstHit(point - far * direction, direction, far);
    const Target::Kind kind = first ? first.target.kind : back.target.kind;
    return kind == Target::Kind::Surface ? PathOutcome::Hidden : PathOutcome::Blocked;
}

OpticalScene::LegEnd OpticalScene::legEnd(const glm::dvec3& origin, const glm::dvec3& direction) const {
    LegEnd end{{}, std::numeric_limits<double>::infinity()};
    if (caster_.empty()) return end;
    end.hit = caster_.firstHit(origin, direction);
    end.deposit_end = light_end_.distance(origin, direction, end.hit);
    return end;
}

}  // namespace photic
