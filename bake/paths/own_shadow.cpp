// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/own_shadow.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>

#include "bake/paths/height_field_hit.h"
#include "bake/paths/launch_domain.h"

namespace photic {
namespace {

constexpr int kBlock = 16;             // cells a side of a block
constexpr int kMostCells = 2048;       // a side
constexpr int kLooks = 128;            // a side, for a part that turns away
constexpr double kSlopeMargin = 0.12;  // as of the launch domain: what lies between the samples is steeper
constexpr double kNone = -std::numeric_limits<double>::infinity();

// Where a light stands; none for a sun.
std::vector<glm::dvec3> placesOf(const Light& light) {
    std::vector<glm::dvec3> places;
    if (!light.position) return places;
    places.push_back(*light.position);
    if (light.type != LightType::Rectangle) return places;
    const glm::dvec3 across = 0.5 * light.size.x * light.tangent,
                     up = 0.5 * light.size.y * glm::cross(light.direction, light.tangent);
    for (const double s : {-1.0, 1.0})
        for (const double t : {-1.0, 1.0}) places.push_back(*light.position + s * across + t * up);
    return places;
}

// The greatest of each value and its neighbours up to `radius` away, along one line of an array.
void dilate(float* first, std::ptrdiff_t stride, int count, int radius, std::vector<float>& scratch) {
    scratch.resize(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) scratch[static_cast<std::size_t>(i)] = first[i * stride];
    for (int i = 0; i < count; ++i)
        for (int k = std::max(0, i - radius); k <= std::min(count - 1, i + radius); ++k)
            first[i * stride] = std::max(first[i * stride], scratch[static_cast<std::size_t>(k)]);
}

}  // namespace

void OwnShadow::Part::add(const glm::dvec2& p) { min = glm::min(min, p), max = glm::max(max, p); }

std::optional<OwnShadow> OwnShadow::of(const Scene& scene, const Surface& surface, const GridFrame& frame) {
    if (!surface.height_field || !std::isfinite(surface.height_field->featureSize())) return std::nullopt;
    const HeightField& field = *surface.height_field;
    Part all;
    bool needed = false;
    for (const Light& light : scene.lights) {
        const LaunchDomain launched = launchDomain(scene, surface, light, frame);
        if (launched.empty()) continue;
        Part part;
        part.add(launched.min - field.maxDisplacement()), part.add(launched.max + field.maxDisplacement());
        for (const glm::dvec3& place : placesOf(light)) part.add(glm::dvec2(place));
        if (!light.position && light.direction.z < 0) {
            const glm::dvec2 run = glm::dvec2(light.direction) * ((field.maxZ() - field.minZ()) / -light.direction.z);
            const Part here = part;
            part.add(here.min - run), part.add(here.max - run);
        }
        if (surface.outside == Outside::None) {
            const glm::dvec2 half = 0.5 * surface.size + field.maxDisplacement();
            part.min = glm::max(part.min, glm::dvec2(surface.center) - half);
            part.max = glm::min(part.max, glm::dvec2(surface.center) + half);
        }
        if (!(part.max.x > part.min.x && part.max.y > part.min.y)) continue;
        all.add(part.min), all.add(part.max);
        needed = needed || turnsAway(surface, part, light);
    }
    if (!needed) return std::nullopt;
    return OwnShadow(surface, all);
}

// A smooth surface stands in its own light only where a part of it turns away from it.
bool OwnShadow::turnsAway(const Surface& surface, const Part& part, const Light& light) {
    const std::vector<glm::dvec3> places = placesOf(light);
    const double disc = std::sin(0.55 * light.angular_diameter_deg * std::numbers::pi / 180);
    const glm::dvec2 step = (part.max - part.min) / double(kLooks);
    SurfaceRow row;
    for (int j = 0; j < kLooks; ++j) {
        surface.height_field->row(part.min + step * glm::dvec2(0.5, j + 0.5), step.x, kLooks, row);
        for (std::size_t i = 0; i < row.pz.size(); ++i) {
            const glm::dvec3 steeper = glm::normalize(
                glm::dvec3(glm::dvec2(row.nx[i], row.ny[i]) * (1 + kSlopeMargin), std::max(row.nz[i], 0.0)));
            if (places.empty() && light.direction.z < 0 && -glm::dot(light.direction, steeper) < disc) return true;
            for (const glm::dvec3& place : places) {
                const glm::dvec3 to = glm::dvec3(row.px[i], row.py[i], row.pz[i]) - place;
                if (to.z < 0 && glm::dot(to, steeper) > 0) return true;
            }
        }
    }
    return false;
}

OwnShadow::OwnShadow(const Surface& surface, const Part& part) : surface_(&surface), part_(part) {
    const glm::dvec2 size = part.max - part.min;
    const double feature = surface.height_field->featureSize();
    for (int a = 0; a < 2; ++a)
        cells_[a] = static_cast<int>(std::clamp(std::ceil(size[a] / feature), 1.0, double(kMostCells)));
    cell_ = size / glm::dvec2(cells_);
    boundHeights();
}

// Between samples the surface lies within a quarter of its second differences of what they span.
void OwnShadow::boundHeights() {
    const HeightField& field = *surface_->height_field;
    bounds_.assign(static_cast<std::size_t>(cells_.x) * static_cast<std::size_t>(cells_.y), float(kNone));
    // What stands beside the part may be displaced into it, and the outermost samples have neighbours too.
    const glm::ivec2 border = glm::ivec2(glm::ceil(field.maxDisplacement() / cell_)) + 2;
    SurfaceRow before, row, after;
    const auto sample = [&](int j, SurfaceRow& out) {
        field.row(part_.min + cell_ * (glm::dvec2(-border.x, j) + 0.5), cell_.x,
                  static_cast<std::size_t>(cells_.x + 2 * border.x), out);
    };
    sample(-border.y, row), sample(1 - border.y, after);
    glm::dvec2 apart(0);  // neighbouring samples
    for (int j = 1 - border.y; j + 1 < cells_.y + border.y; ++j) {
        std::swap(before, row), std::swap(row, after);
        sample(j + 1, after);
        for (std::size_t i = 1; i + 1 < row.pz.size(); ++i) {
            apart =
                glm::max(apart, glm::dvec2(std::fabs(row.px[i] - row.px[i - 1]), std::fabs(row.py[i] - before.py[i])));
            const glm::ivec2 at(glm::floor((glm::dvec2(row.px[i], row.py[i]) - part_.min) / cell_));
            if (at.x < 0 || at.y < 0 || at.x >= cells_.x || at.y >= cells_.y) continue;
            const double bend = std::max(std::fabs(row.pz[i + 1] - 2 * row.pz[i] + row.pz[i - 1]),
                                         std::fabs(after.pz[i] - 2 * row.pz[i] + before.pz[i]));
            float& bound = bounds_[static_cast<std::size_t>(at.y * cells_.x + at.x)];
            bound = std::max(bound, static_cast<float>(row.pz[i] + 0.5 * bend));
        }
    }
    const glm::ivec2 radius = glm::min(glm::ivec2(glm::ceil(apart / cell_ - 1e-6)), 64);
    std::vector<float> scratch;
    for (int j = 0; j < cells_.y; ++j)
        dilate(&bounds_[static_cast<std::size_t>(j * cells_.x)], 1, cells_.x, radius.x, scratch);
    for (int i = 0; i < cells_.x; ++i)
        dilate(&bounds_[static_cast<std::size_t>(i)], cells_.x, cells_.y, radius.y, scratch);
    const double rounding = 1e-6 * std::max(std::fabs(field.minZ()), std::fabs(field.maxZ()));
    // Over a part so wide that samples miss whole waves their bounds tell nothing.
    constexpr double kWidest = 4;  // features
    const bool coarse = std::max(cell_.x, cell_.y) > kWidest * field.featureSize();
    const glm::ivec2 blocks = (cells_ + kBlock - 1) / kBlock;
    of_blocks_.assign(static_cast<std::size_t>(blocks.x) * static_cast<std::size_t>(blocks.y), float(kNone));
    for (int j = 0; j < cells_.y; ++j)
        for (int i = 0; i < cells_.x; ++i) {
            float& bound = bounds_[static_cast<std::size_t>(j * cells_.x + i)];
            // A cell that no sample fell into may hold anything.
            bound = coarse || bound == float(kNone) ? float(field.maxZ()) : static_cast<float>(bound + rounding);
            float& of_block = of_blocks_[static_cast<std::size_t>(j / kBlock * blocks.x + i / kBlock)];
            of_block = std::max(of_block, bound);
        }
}

bool OwnShadow::covers(const glm::dvec3& point, const glm::dvec3& direction, double max_distance) const {
    const HeightField& field = *surface_->height_field;
    const double rise = -direction.z;
    if (!(rise > 0)) return false;
    const glm::dvec3 back = -direction;
    const glm::dvec2 run(back);
    const double end = std::min(max_distance, (field.maxZ() - point.z) / rise);
    const double feature = std::min(1.0, field.featureSize());
    double t = 1e-12 * glm::length(point) + 1e-6 * feature;
    const double least = 1e-6 * std::min(cell_.x, cell_.y) / std::max(glm::length(run), 1e-12);
    // A part of the way, not yet looked at, on which the surface may be met.
    double doubtful = t;
    bool doubt = false;
    const auto meets = [&](double to) {
        return doubt && std::isfinite(hitHeightField(*surface_, point, back, doubtful, to).distance);
    };
    // Where the ray leaves the square of `side` cells that it is in.
    const auto leaves = [&](const glm::ivec2& square, int side) {
        double nearest = end;
        for (int a = 0; a < 2; ++a) {
            if (run[a] == 0) continue;
            const double border = part_.min[a] + cell_[a] * side * (square[a] + (run[a] > 0 ? 1 : 0));
            nearest = std::min(nearest, (border - point[a]) / run[a]);
        }
        return std::max(nearest, t + least);
    };
    const int blocks = (cells_.x + kBlock - 1) / kBlock;
    while (t < end) {
        const glm::ivec2 at(glm::floor((glm::dvec2(point) + t * run - part_.min) / cell_));
        if (at.x < 0 || at.y < 0 || at.x >= cells_.x || at.y >= cells_.y) {
            if (!doubt) doubtful = t, doubt = true;
            t = end;
            break;
        }
        const double height = point.z + t * rise;
        const glm::ivec2 block = at / kBlock;
        const bool above_block = height > of_blocks_[static_cast<std::size_t>(block.y * blocks + block.x)];
        const bool above = above_block || height > bounds_[static_cast<std::size_t>(at.y * cells_.x + at.x)];
        if (above && meets(t)) return true;
        if (above)
            doubt = false;
        else if (!doubt)
            doubtful = t, doubt = true;
        t = above_block ? leaves(block, kBlock) : leaves(at, 1);
    }
    return meets(end);
}

}  // namespace photic
