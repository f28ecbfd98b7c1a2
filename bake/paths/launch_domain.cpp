// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/launch_domain.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <vector>

#include "bake/optics/snell.h"
#include "bake/optics/tangent_frame.h"
#include "bake/paths/height_field_hit.h"
#include "bake/scene/not_built.h"

namespace photic {
namespace {

constexpr double kMaxRun = 50;         // horizontal run per unit of height beyond which light is as good as horizontal
constexpr int kMaxSamples = 128;       // a side, of the surface
constexpr double kSlopeMargin = 0.12;  // samples an eighth of a wavelength apart miss 7.6 % of the steepest slope

struct Range {
    double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
    bool empty() const { return low > high; }
    void add(double x) { low = std::min(low, x), high = std::max(high, x); }
    double at(double f) const { return low + f * (high - low); }
    double span() const { return high - low; }
    void widen(double part) {
        const double more = part * span();
        low -= more, high += more;
    }
};

struct Slopes {
    Range x, y;
};

Slopes slopesOf(const Surface& surface) {
    Slopes slopes;
    const HeightField& field = *surface.height_field;
    if (surface.outside != Outside::None || !std::isfinite(field.featureSize())) slopes.x.add(0), slopes.y.add(0);
    if (std::isfinite(field.featureSize())) {
        const glm::dvec2 size = surface.size * 1.02;  // a little over the rim, where a map fades out
        const auto samples = [&](double length) {
            return std::clamp(static_cast<int>(length / (field.featureSize() * 0.97)) + 1, 24, kMaxSamples);
        };
        const int nx = samples(size.x), ny = samples(size.y);
        SurfaceRow row;
        for (int j = 0; j < ny; ++j) {
            const glm::dvec2 start =
                glm::dvec2(surface.center) + size * glm::dvec2(0.5 / nx - 0.5, (j + 0.5) / ny - 0.5);
            field.row(start, size.x / nx, static_cast<std::size_t>(nx), row);
            for (std::size_t i = 0; i < row.nz.size(); ++i) {
                const double n_z = std::max(row.nz[i], 1e-300);
                slopes.x.add(std::clamp(-row.nx[i] / n_z, -kMaxRun, kMaxRun));
                slopes.y.add(std::clamp(-row.ny[i] / n_z, -kMaxRun, kMaxRun));
            }
        }
    }
    for (Range* r : {&slopes.x, &slopes.y}) {
        const double margin = kSlopeMargin * std::max(std::fabs(r->low), std::fabs(r->high));
        r->low -= margin, r->high += margin;
    }
    return slopes;
}

/// Directions in which light can come to the surface: a sun's centre and the rim of its disc; from a lamp all that go
/// down.
std::vector<glm::dvec3> arrivingDirections(const Light& light) {
    if (light.type != LightType::Sun) {
        std::vector<glm::dvec3> directions{{0, 0, -1}};
        for (const double zenith : {0.4, 0.8, 1.2, 1.5, 1.56})
            for (int k = 0; k < 16; ++k) {
                const double phi = k * std::numbers::pi / 8;
                directions.push_back(
                    {std::sin(zenith) * std::cos(phi), std::sin(zenith) * std::sin(phi), -std::cos(zenith)});
            }
        return directions;
    }
    std::vector<glm::dvec3> directions{light.direction};
    const double radius = 0.5 * light.angular_diameter_deg * std::numbers::pi / 180 * 1.1;
    if (radius == 0) return directions;
    const TangentFrame frame(light.direction);
    for (int k = 0; k < 8; ++k) {
        const double phi = k * std::numbers::pi / 4;
        directions.push_back(std::cos(radius) * light.direction +
                             std::sin(radius) * (std::cos(phi) * frame.across + std::sin(phi) * frame.up));
    }
    return directions;
}

/// Horizontal run per unit of height in the direction of travel.
struct Runs {
    Range x, y;
    bool complete = true;
    void add(const glm::dvec3& direction, bool upwards) {
        const double rise = upwards ? direction.z : -direction.z;
        if (rise <= 0) return;
        const glm::dvec2 run(direction.x / rise, direction.y / rise);
        complete = complete && std::fabs(run.x) <= kMaxRun && std::fabs(run.y) <= kMaxRun;
        x.add(std::clamp(run.x, -kMaxRun, kMaxRun)), y.add(std::clamp(run.y, -kMaxRun, kMaxRun));
    }
};

/// What bounds the ways on from a surface.
struct Bends {
    Slopes slopes;
    double ior_above = 1, ior_below = 1;

    Runs of(const std::vector<glm::dvec3>& directions, bool upwards, int steps) const {
        Runs runs;
        for (const glm::dvec3& direction : directions)
            for (int i = 0; i <= steps; ++i)
                for (int j = 0; j <= steps; ++j) {
                    const glm::dvec3 normal =
                        glm::normalize(glm::dvec3(-slopes.x.at(double(i) / steps), -slopes.y.at(double(j) / steps), 1));
                    if (glm::dot(direction, normal) >= 0) continue;
                    const Interface event = interfaceAt(direction, normal, ior_above, ior_below);
                    runs.add(upwards ? event.reflected : event.refracted, upwards);
                }
        return runs;
    }
};

/// Adds the horizontal places at heights [z_low, z_high] from which light with these runs gets into the box. Light
/// travels down; callers turn the world over for light that goes up.
///
/// x = X - drop * run is linear in each of box point, height and run, so its extremes lie on the corners of the box, or
/// where its edges pass the lowest and highest heights.
void addReach(const std::array<glm::dvec3, 8>& corners, double z_low, double z_high, const Runs& runs, Range& x,
              Range& y) {
    for (unsigned a = 0; a < 8; ++a)
        for (unsigned axis = 0; axis < 3; ++axis) {
            if (a & (1u << axis)) continue;
            const glm::dvec3 from = corners[a], to = corners[a | (1u << axis)];
            std::array<double, 4> stops{0, 1, 0, 1};
            if (to.z != from.z)
                stops[2] = std::clamp((z_low - from.z) / (to.z - from.z), 0.0, 1.0),
                stops[3] = std::clamp((z_high - from.z) / (to.z - from.z), 0.0, 1.0);
            for (const double s : stops) {
                const glm::dvec3 p = from + s * (to - from);
                const double highest_drop = z_high - p.z;
                if (highest_drop < -1e-12 * (1 + std::fabs(z_high))) continue;
                for (const double drop : {std::max(0.0, z_low - p.z), std::max(0.0, highest_drop)}) {
                    x.add(p.x - drop * runs.x.low), x.add(p.x - drop * runs.x.high);
                    y.add(p.y - drop * runs.y.low), y.add(p.y - drop * runs.y.high);
                }
            }
        }
}

/// The places of a surface from which light gets into a grid's box.
struct Places {
    Range x, y;
    bool complete = true;
};

class Reach {
public:
    /// @param from_below  light goes up to the surface; the world is turned over for it, z to -z
    Reach(const Scene& scene, const Surface& surface, const GridFrame& frame, bool from_below) : surface_(surface) {
        const HeightField& field = *surface.height_field;
        low_ = from_below ? -field.maxZ() : field.minZ(), high_ = from_below ? -field.minZ() : field.maxZ();
        bends_.slopes = slopesOf(surface);
        bends_.ior_above = sideOf(scene, surface, from_below ? Side::Below : Side::Above).ior.mean();
        bends_.ior_below = sideOf(scene, surface, from_below ? Side::Above : Side::Below).ior.mean();
        for (Range* slope : {&bends_.slopes.x, &bends_.slopes.y})
            if (from_below) *slope = {-slope->high, -slope->low};
        for (unsigned c = 0; c < 8; ++c) {
            glm::dvec3 index;
            for (int a = 0; a < 3; ++a) index[a] = c >> a & 1 ? frame.max[a] + 0.5 : frame.min[a] - 0.5;
            corners_[c] = frame.worldFromIndex(index);
            if (from_below) corners_[c].z = -corners_[c].z;
        }
    }
    double low() const { return low_; }
    double high() const { return high_; }

    /// @param widened  of the ways on, by this part of how far apart they are
    Places of(const std::vector<glm::dvec3>& directions, int steps, double widened = 0) const {
        Places places;
        for (const bool upwards : {false, true}) {
            const bool mirrors = surface_.event == SurfaceEvent::Reflect || surface_.event == SurfaceEvent::Mirror;
            if (upwards ? surface_.event == SurfaceEvent::Refract : mirrors) continue;
            Runs runs = bends_.of(directions, upwards, steps);
            if (runs.x.empty()) continue;
            runs.x.widen(widened), runs.y.widen(widened);
            places.complete = places.complete && runs.complete;
            std::array<glm::dvec3, 8> corners = corners_;
            for (glm::dvec3& c : corners) c.z = upwards ? -c.z : c.z;
            addReach(corners, upwards ? -high_ : low_, upwards ? -low_ : high_, runs, places.x, places.y);
        }
        return places;
    }

private:
    const Surface& surface_;
    double low_ = 0, high_ = 0;
    Bends bends_;
    std::array<glm::dvec3, 8> corners_;
};

/// Where the light of a lamp goes from a surface into the box. A lamp sends light every way, but to each place one way
/// alone: rectangles that its light cannot go on from are left out, and those that it may are quartered.
class LampReach {
public:
    LampReach(const Light& light, const Reach& reach, double margin)
        : light_(light), reach_(reach), margin_(margin), sources_{*light.position} {
        if (light.type != LightType::Rectangle) return;
        const glm::dvec3 across = 0.5 * light.size.x * light.tangent,
                         up = 0.5 * light.size.y * glm::cross(light.direction, light.tangent);
        for (const double s : {-1.0, 1.0})
            for (const double t : {-1.0, 1.0}) sources_.push_back(*light.position + s * across + t * up);
    }

    Places within(const Places& all) const {
        constexpr int kRounds = 3, kDepth = 6;  // each round begins again within what the last one has left
        Places found = all;
        for (int round = 0; round < kRounds; ++round) {
            const Places before = found;
            found = {};
            search({before.x.low, before.y.low}, {before.x.high, before.y.high}, kDepth, found);
            if (found.x.empty() || found.x.span() * found.y.span() > 0.5 * before.x.span() * before.y.span()) break;
        }
        return found;
    }

private:
    void search(const glm::dvec2& low, const glm::dvec2& high, int depth, Places& found) const {
        const bool known =
            found.x.low <= low.x && found.x.high >= high.x && found.y.low <= low.y && found.y.high >= high.y;
        if (known || !mayReach(low, high, found)) return;
        if (depth == 0) {
            found.x.add(low.x), found.x.add(high.x), found.y.add(low.y), found.y.add(high.y);
            return;
        }
        const glm::dvec2 middle = 0.5 * (low + high);
        search(low, middle, depth - 1, found), search(middle, high, depth - 1, found);
        search({middle.x, low.y}, {high.x, middle.y}, depth - 1, found);
        search({low.x, middle.y}, {middle.x, high.y}, depth - 1, found);
    }

    bool mayReach(const glm::dvec2& low, const glm::dvec2& high, Places& found) const {
        std::vector<glm::dvec3> directions;
        bool shone_on = false;
        for (const glm::dvec3& source : sources_) {
            shone_on = shone_on || shinesOn(source, low, high);
            for (const double x : {low.x, 0.5 * (low.x + high.x), high.x})
                for (const double y : {low.y, 0.5 * (low.y + high.y), high.y})
                    for (const double z : {reach_.low(), reach_.high()}) {
                        const glm::dvec3 to = glm::dvec3(x, y, z) - source;
                        if (to.z < 0) directions.push_back(glm::normalize(to));
                    }
        }
        if (!shone_on || directions.empty()) return false;
        // What comes through the water close to a lamp under it may all lie between places that are totally reflected.
        if (isCloseTo(low, high)) return true;
        constexpr int kSteps = 4;
        constexpr double kWidened = 0.1;  // what lies between the ways that were looked at
        const Places places = reach_.of(directions, kSteps, kWidened);
        if (places.x.empty()) return false;
        const bool reaches = places.x.low - margin_ <= high.x && places.x.high + margin_ >= low.x &&
                             places.y.low - margin_ <= high.y && places.y.high + margin_ >= low.y;
        if (reaches) found.complete = found.complete && places.complete;
        return reaches;
    }

    /// Whether a lamp is nearer to a rectangle of the surface than that is wide.
    bool isCloseTo(const glm::dvec2& low, const glm::dvec2& high) const {
        const double wide = glm::length(high - low);
        return std::any_of(sources_.begin(), sources_.end(), [&](const glm::dvec3& source) {
            const glm::dvec3 nearest = glm::clamp(source, {low, reach_.low()}, {high, reach_.high()});
            return source.z > reach_.low() && glm::length(source - nearest) < wide;
        });
    }

    /// Whether a lamp's own shape sends light to any place of a rectangle.
    bool shinesOn(const glm::dvec3& source, const glm::dvec2& low, const glm::dvec2& high) const {
        if (light_.type == LightType::Point) return true;
        const glm::dvec3 middle(0.5 * (low + high), 0.5 * (reach_.low() + reach_.high()));
        const double radius =
            glm::length(glm::dvec3(0.5 * (high - low) + margin_, 0.5 * (reach_.high() - reach_.low())));
        const glm::dvec3 to = middle - source;
        const double distance = glm::length(to);
        if (distance <= radius) return true;
        const double cone = light_.type == LightType::Spot ? 0.5 * light_.cone_angle_deg * std::numbers::pi / 180
                                                           : 0.5 * std::numbers::pi;
        const double off = std::acos(std::clamp(glm::dot(to, light_.direction) / distance, -1.0, 1.0));
        return off - std::asin(radius / distance) <= cone;
    }

    const Light& light_;
    const Reach& reach_;
    double margin_;
    std::vector<glm::dvec3> sources_;
};

}  // namespace

LaunchDomain launchDomain(const Scene& scene, const Surface& surface, const Light& light, const GridFrame& frame) {
    LaunchDomain domain;
    if (!surface.height_field || frame.size().x <= 0) return domain;
    const bool from_below = standsBelow(light, surface);
    const Reach reach(scene, surface, frame, from_below);
    constexpr int kSteps = 8;
    Places places = reach.of(arrivingDirections(light), kSteps);
    const double displaced = surface.height_field->maxDisplacement();
    if (light.position && !places.x.empty()) {
        Light lamp = light;
        if (from_below) lamp.position->z *= -1, lamp.direction.z *= -1, lamp.tangent.z *= -1;
        places = LampReach(lamp, reach, displaced).within(places);
    }
    domain.complete = places.complete;
    if (places.x.empty()) return domain;

    const double margin = displaced + 1e-9 * std::max(places.x.span(), places.y.span());
    domain.min = {places.x.low - margin, places.y.low - margin};
    domain.max = {places.x.high + margin, places.y.high + margin};
    if (surface.outside == Outside::None) {
        domain.min = glm::max(domain.min, glm::dvec2(surface.center) - 0.5 * surface.size);
        domain.max = glm::min(domain.max, glm::dvec2(surface.center) + 0.5 * surface.size);
    }
    return domain;
}

std::string specularRefusal(const Scene& scene) {
    if (scene.lights.empty()) return "the scene has no [[light]]";
    if (std::string why = gradedRefusal(scene); !why.empty()) return why;
    if (scene.surfaces.empty()) return "the scene has no [[surface]] that could focus light";
    if (scene.index)
        return "light bends on its way through an [[index]], and rays go straight here; choose another method, or "
               "remove it";
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i)
        for (std::size_t j = i + 1; j < scene.surfaces.size(); ++j) {
            const Surface &a = scene.surfaces[i], &b = scene.surfaces[j];
            if (!a.height_field || !b.height_field) continue;
            const auto apart = [&](int axis) {
                return a.outside == Outside::None && b.outside == Outside::None &&
                       std::fabs(a.center[axis] - b.center[axis]) >= 0.5 * (a.size[axis] + b.size[axis]);
            };
            if (!apart(0) && !apart(1))
                return fmt::format(
                    "height fields '{}' and '{}' overlap: light would enter twice; bake them as two scenes, or keep "
                    "them "
                    "apart with outside = \"none\"",
                    a.name, b.name);
        }
    return {};
}

}  // namespace photic
