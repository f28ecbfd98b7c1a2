// SPDX-License-Identifier: Apache-2.0
// Lamps that stand among the media: what they are inside of.
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <iterator>
#include <limits>

#include "bake/methods/graded_space.h"
#include "bake/paths/height_field_hit.h"

namespace photic {

/// Rays of a lamp that stands a few voxels beside the space would come into it far apart: it is in it.
void GradedSpace::addLampsNear(const Scene& scene) {
    constexpr double kNear = 8;  // voxels
    for (const Light& light : scene.lights) {
        if (!light.position) continue;
        const glm::dvec3 place = frame_.indexFromWorld(*light.position),
                         beside = glm::max(target_.min - place, place - target_.max);
        const double most = std::max({beside.x, beside.y, beside.z});
        if (most > -1 && most < kNear) target_.add(place - 1.0), target_.add(place + 1.0);
    }
}

MediumStack GradedSpace::insideAt(const glm::dvec3& world) const {
    MediumStack stack = start_;
    if (!optics_) return stack;
    const std::vector<Surface>& surfaces = optics_->scene().surfaces;
    constexpr double kFar = std::numeric_limits<double>::infinity();
    for (std::size_t s = 0; s < surfaces.size(); ++s)
        if (surfaces[s].height_field && std::isfinite(hitHeightField(surfaces[s], world, {0, 0, 1}, 0, kFar).distance))
            stack.base = static_cast<std::int16_t>(optics_->sides(static_cast<int>(s)).inside);
    // A ray from there leaves what holds the place, the innermost first; what it enters on its way it leaves again.
    const glm::dvec3 direction = glm::normalize(glm::dvec3(0.0123, 0.0171, 1));  // along no axis
    constexpr int kMost = 256;
    const double hair = 1e-6 * frame_.worldFromIndex()[2][2];
    std::vector<int> left, entered;
    glm::dvec3 from = world;
    for (int i = 0; i < kMost; ++i) {
        Meeting meeting;
        const RayHit hit = optics_->firstHit(from, direction, kFar, meeting);
        if (!hit) break;
        from += (hit.distance + hair) * direction;
        const int surface = hit.target.index;
        if (hit.target.kind != Target::Kind::Surface || !optics_->sides(surface).nested) continue;
        const auto open = std::find(entered.rbegin(), entered.rend(), surface);
        if (glm::dot(direction, meeting.face) < 0)
            entered.push_back(surface);
        else if (open != entered.rend())
            entered.erase(std::next(open).base());
        else
            left.push_back(surface);
    }
    for (auto surface = left.rbegin(); surface != left.rend(); ++surface)
        stack = optics_->across(stack, *surface, true);
    return stack;
}

}  // namespace photic
