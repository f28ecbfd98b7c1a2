// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/wavefront_launch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <tuple>
#include <utility>

#include "bake/methods/front_obstacles.h"
#include "bake/paths/optical_scene.h"
#include "bake/report/error.h"

namespace photic {
namespace {

constexpr double kMostRays = 67108864;  // 2^26: 4 GB
constexpr int kBlock = 8;               // cells a side of a block of tubes

// Sides of a triangle over the radius of a spot's cone there, up to which its strength is asked for by the middles of
// the sides; and the halvings after which it is, whatever the cone.
constexpr double kNarrowCone = 0.1;
constexpr int kMostHalvings = 14;

[[noreturn]] void refuseLamp(const Light& light, const std::string& why) {
    throw Error(ErrorCode::Input, fmt::format("the light '{}' {}", light.name, why), light.where);
}

void requireFew(const Light& light, double rays, double spacing) {
    if (!(rays <= kMostRays))
        refuseLamp(light, fmt::format("would have a front of {:.3g} rays; the limit is 2^26: use a larger spacing than "
                                      "{} voxels, or larger voxels",
                                      rays, spacing));
}

void setLeast(const FrontLaunch& launch, Front& front) {
    for (Front::Tube& tube : front.tubes) tube.least = launch.space.limits.threshold * channelMean(tube.power);
}

}  // namespace

bool standsAmong(const FrontLaunch& launch, const LightSample& sample) {
    if (!sample.source) return false;
    const glm::dvec3 place = launch.frame.indexFromWorld(*sample.source);
    for (int a = 0; a < 3; ++a) {
        const double low = launch.straight ? launch.target.min[a] : launch.space.low[a] - 0.5,
                     high = launch.straight ? launch.target.max[a] : launch.space.high[a] + 0.5;
        if (!(place[a] >= low && place[a] <= high)) return false;
    }
    return true;
}

LaunchPlane::LaunchPlane(const FrontLaunch& launch, const LightSample& sample, std::optional<LampSide> side)
    : launch_(launch), sample_(sample), from_lamp_(side.has_value()) {
    if (sample.source) source_ = launch.frame.indexFromWorld(*sample.source);
    const glm::dvec3 middle = launch.frame.worldFromIndex(0.5 * (launch.target.min + launch.target.max));
    const glm::dvec3 way = sample.source ? middle - *sample.source : sample.direction;
    const int along = mainAxis(way);
    way_ = side.value_or(LampSide{along, way[along] > 0 ? 1 : -1});
    axis_ = side ? side->first : launch.across.value_or(along);
    sense_ = side ? side->second : way[axis_] > 0 ? 1 : -1;
    plane_ = side ? source_[axis_] + sense_ : sideAlong(axis_, sense_);
    // A lamp that is beside the space along that axis is before it along another one.
    for (int a = 0; a < 3 && behindLamp() && !launch.across; ++a) {
        const int sense = way[a] > 0 ? 1 : -1;
        const double plane = sideAlong(a, sense);
        if (sense * (plane - source_[a]) > 0) axis_ = a, sense_ = sense, plane_ = plane;
    }
    axes_ = axesFor(axis_);
}

/// Where the space begins for what comes along an axis.
double LaunchPlane::sideAlong(int axis, int sense) const {
    if (launch_.straight) return sense > 0 ? launch_.target.min[axis] : launch_.target.max[axis];
    return sense > 0 ? launch_.space.low[axis] - 0.5 : launch_.space.high[axis] + 0.5;
}

glm::dvec2 LaunchPlane::placeOf(const Front::Ray& ray) const {
    glm::dvec3 voxel = ray.voxel;
    if (from_lamp_) {
        const glm::dvec3 way = launch_.frame.indexDirection(ray.momentum);
        voxel += (plane_ - source_[axis_]) / way[axis_] * way;
    }
    return {voxel[axes_[0]], voxel[axes_[1]]};
}

glm::dvec2 LaunchPlane::shadowOf(const glm::dvec3& voxel) const {
    const glm::dvec3 way = sample_.source ? voxel - source_ : launch_.frame.indexDirection(sample_.direction);
    const double back = (voxel[axis_] - plane_) / way[axis_];
    return {voxel[axes_[0]] - back * way[axes_[0]], voxel[axes_[1]] - back * way[axes_[1]]};
}

glm::dvec3 LaunchPlane::voxelAt(const glm::dvec2& uv) const {
    glm::dvec3 voxel;
    voxel[axes_[0]] = uv.x, voxel[axes_[1]] = uv.y, voxel[axis_] = plane_;
    return voxel;
}

glm::dvec3 LaunchPlane::directionAt(const glm::dvec3& world) const {
    return sample_.source ? glm::normalize(world - *sample_.source) : sample_.direction;
}

Front::Ray LaunchPlane::rayAt(const glm::dvec2& uv) const {
    Front::Ray ray;
    ray.voxel = voxelAt(uv);
    const glm::dvec3 world = launch_.frame.worldFromIndex(ray.voxel), direction = directionAt(world);
    if (from_lamp_) {
        ray.voxel = source_;
        ray.momentum = std::sqrt(2 * launch_.space.halfSquareAt(*sample_.source)) * direction;
        ray.lit = launch_.lit || launch_.in_medium(*sample_.source);
        return ray;
    }
    // Snell's law at a flat face keeps what lies in it; air is outside.
    const double square = 2 * launch_.space.halfSquareAt(world);
    ray.momentum = direction;
    const double across = 1 - direction[axis_] * direction[axis_];
    constexpr double kLeast = 1e-6;
    ray.momentum[axis_] = sense_ * std::sqrt(std::max(square - across, kLeast));
    ray.lit = launch_.lit || launch_.in_medium(world);
    ray.time = sample_.source ? glm::distance(world, *sample_.source) : glm::dot(direction, world);
    ray.shadowed = launch_.caster && standsBefore(*launch_.caster, sample_, world);
    return ray;
}

/// Of a lamp towards a direction, per channel [W/sr].
glm::dvec3 LaunchPlane::strengthTowards(const glm::dvec3& direction) const {
    const double cosine = glm::dot(direction, sample_.direction);
    const bool panel = sample_.light->type == LightType::Rectangle;
    return sample_.strength * (panel ? std::max(0.0, cosine) : sample_.light->spotFalloff(cosine));
}

glm::dvec3 LaunchPlane::power(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) const {
    const glm::dvec3 p[3] = {launch_.frame.worldFromIndex(voxelAt(a)), launch_.frame.worldFromIndex(voxelAt(b)),
                             launch_.frame.worldFromIndex(voxelAt(c))};
    if (!sample_.source) {
        const double area = 0.5 * glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
        return sample_.strength * (area * std::fabs(sample_.direction[axis_]));
    }
    return lampPower({p[0], p[1], p[2]}, 0);
}

// Of a spot over a triangle.
LaunchPlane::Cone LaunchPlane::coneOver(const std::array<glm::dvec3, 3>& corner) const {
    if (sample_.light->type != LightType::Spot) return Cone::Even;
    const glm::dvec3 to = (corner[0] + corner[1] + corner[2]) / 3.0 - *sample_.source;
    const double distance = glm::length(to), half_cone = 0.5 * sample_.light->cone_angle_deg * std::numbers::pi / 180;
    double reach = 0;
    for (std::size_t i = 0; i < 3; ++i) reach = std::max(reach, glm::distance(corner[i], corner[(i + 1) % 3]));
    const double off = std::acos(std::clamp(glm::dot(to, sample_.direction) / distance, -1.0, 1.0));
    if (distance > reach && off - std::asin(reach / distance) > half_cone) return Cone::Beside;
    return reach > kNarrowCone * distance * std::tan(std::min(half_cone, 1.0)) ? Cone::Narrow : Cone::Even;
}

// A cone may be as narrow as a cell or narrower: its parts are asked then, or its corners would tell too much light or
// none.
glm::dvec3 LaunchPlane::lampPower(const std::array<glm::dvec3, 3>& corner, int halvings) const {
    const Cone cone = coneOver(corner);
    if (cone == Cone::Beside) return glm::dvec3(0);
    std::array<glm::dvec3, 3> middle;
    for (std::size_t i = 0; i < 3; ++i) middle[i] = 0.5 * (corner[i] + corner[(i + 1) % 3]);
    if (cone == Cone::Narrow && halvings < kMostHalvings) {
        glm::dvec3 sum = lampPower(middle, halvings + 1);
        for (std::size_t i = 0; i < 3; ++i) sum += lampPower({corner[i], middle[i], middle[(i + 2) % 3]}, halvings + 1);
        return sum;
    }
    // Exact where strength is quadratic.
    glm::dvec3 d[3], strength(0);
    for (std::size_t i = 0; i < 3; ++i)
        d[i] = directionAt(corner[i]), strength += strengthTowards(directionAt(middle[i])) / 3.0;
    // Solid angle [Van Oosterom and Strackee 1983].
    const double volume = std::fabs(glm::dot(d[0], glm::cross(d[1], d[2])));
    return strength * 2.0 * std::atan2(volume, 1 + glm::dot(d[0], d[1]) + glm::dot(d[1], d[2]) + glm::dot(d[2], d[0]));
}

glm::dvec3 LaunchPlane::irradianceAt(const glm::dvec2& uv) const {
    const glm::dvec3 world = launch_.frame.worldFromIndex(voxelAt(uv)), direction = directionAt(world);
    const double cosine = std::fabs(direction[axis_]);
    if (!sample_.source) return sample_.strength * cosine;
    const glm::dvec3 way = world - *sample_.source;
    return strengthTowards(direction) * (cosine / glm::dot(way, way));
}

FrontBox entryOf(const FrontLaunch& launch, const LightSample& sample) {
    const LaunchPlane plane(launch, sample);
    FrontBox entry;
    for (int corner = 0; corner < 8; ++corner) {
        glm::dvec3 p;
        for (int a = 0; a < 3; ++a) p[a] = corner >> a & 1 ? launch.target.max[a] : launch.target.min[a];
        entry.add(plane.voxelAt(plane.shadowOf(p)));
    }
    return entry;
}

void requireWay(const FrontLaunch& launch, const LightSample& sample, const Light& light) {
    if (!sample.source || standsAmong(launch, sample)) return;
    const LaunchPlane plane(launch, sample);
    const double top = launch.frame.worldFromIndex(glm::dvec3(launch.space.high) + 0.5).z;
    if (launch.across && plane.sense() > 0)
        refuseLamp(light, "stands below the water and outside of the domain; move it into the domain");
    if (plane.behindLamp())
        refuseLamp(light, fmt::format("stands beside the domain and not above the water that it shines on; move it "
                                      "into the domain, or above z = {:.4g} m",
                                      top));
}

namespace {

/// What a light sends through a part of a plane, in whole blocks of cells.
Front frontThrough(const FrontLaunch& launch, const LaunchPlane& plane, const glm::dvec2& low, const glm::dvec2& high,
                   const glm::ivec2& blocks) {
    const glm::ivec2 cells = blocks * kBlock;
    const glm::dvec2 spacing = (high - low) / glm::dvec2(cells);
    Front front;
    std::tie(front.axis, front.sense) = plane.way();
    front.inside = launch.inside, front.cells = cells;
    const auto place = [&](int i, int j) { return low + spacing * glm::dvec2(i, j); };
    for (int j = 0; j <= cells.y; ++j)
        for (int i = 0; i <= cells.x; ++i) front.rays.push_back(plane.rayAt(place(i, j)));
    const auto id = [&](int i, int j) { return static_cast<std::uint32_t>(j * (cells.x + 1) + i); };
    front.tubes.reserve(static_cast<std::size_t>(2 * cells.x) * static_cast<std::size_t>(cells.y));
    for (int block = 0; block < blocks.x * blocks.y; ++block)
        for (int cell = 0; cell < kBlock * kBlock; ++cell) {
            const int i = block % blocks.x * kBlock + cell % kBlock, j = block / blocks.x * kBlock + cell / kBlock;
            const glm::dvec2 a = place(i, j), b = place(i + 1, j), c = place(i + 1, j + 1), d = place(i, j + 1);
            front.tubes.push_back({{id(i, j), id(i + 1, j), id(i + 1, j + 1)}, plane.power(a, b, c), 0, {i, j}});
            front.tubes.push_back({{id(i, j), id(i + 1, j + 1), id(i, j + 1)}, plane.power(a, c, d), 0, {i, j}});
        }
    setLeast(launch, front);
    return front;
}

/// What a lamp that stands among the media sends to one side.
Front frontToSide(const FrontLaunch& launch, const Light& light, const LightSample& sample, const LampSide& side) {
    const LaunchPlane plane(launch, sample, side);
    const auto [axis, sense] = side;
    const auto axes = axesFor(axis);
    const glm::dvec3 lamp = launch.frame.indexFromWorld(*sample.source);
    // Rays are `spacing` apart where they leave the space.
    const double far =
        sense > 0 ? launch.space.high[axis] + 0.5 - lamp[axis] : lamp[axis] - launch.space.low[axis] + 0.5;
    const double blocks = std::max(1.0, std::ceil(2 * far / (launch.spacing * kBlock)));
    requireFew(light, (blocks * kBlock + 1) * (blocks * kBlock + 1), launch.spacing);
    const glm::dvec2 middle(lamp[axes[0]], lamp[axes[1]]);
    Front front = frontThrough(launch, plane, middle - 1.0, middle + 1.0, glm::ivec2(static_cast<int>(blocks)));
    // A spot leaves most of them dark.
    std::erase_if(front.tubes, [](const Front::Tube& tube) { return !(channelMean(tube.power) > 0); });
    return front;
}

}  // namespace

std::vector<Front> launchFronts(const FrontLaunch& launch, const Light& light, const LightSample& sample) {
    requireWay(launch, sample, light);
    std::vector<Front> fronts;
    if (standsAmong(launch, sample)) {
        for (int side = 0; side < 6; ++side)
            fronts.push_back(frontToSide(launch, light, sample, {side / 2, side % 2 ? 1 : -1}));
        std::erase_if(fronts, [](const Front& front) { return front.tubes.empty(); });
        return fronts;
    }
    const LaunchPlane plane(launch, sample);
    const FrontBox entry = entryOf(launch, sample);
    const auto axes = axesFor(plane.axis());
    const glm::dvec2 low(entry.min[axes[0]], entry.min[axes[1]]), high(entry.max[axes[0]], entry.max[axes[1]]);
    // Whole blocks of cells that end with the shadow: beyond it a medium that fills the world may not be known.
    glm::ivec2 blocks;
    for (int a = 0; a < 2; ++a) {
        const double whole = std::max(1.0, std::ceil((high[a] - low[a]) / (launch.spacing * kBlock) - 1e-9));
        if (!(whole * kBlock <= 1e6))
            refuseLamp(light,
                       "enters the domain almost level, in a front of more than a million rays a side; turn it, "
                       "or move it away from the domain's side");
        blocks[a] = static_cast<int>(whole);
    }
    requireFew(light, (blocks.x * kBlock + 1.0) * (blocks.y * kBlock + 1.0), launch.spacing);
    fronts.push_back(frontThrough(launch, plane, low, high, blocks));
    return fronts;
}

}  // namespace photic
