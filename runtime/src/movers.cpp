// SPDX-License-Identifier: Apache-2.0
// photic_movers.glsl in double: the same steps under the same names, so that one can be read beside the other.
#include "photic/movers.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>

#include "runtime/src/guarded.h"
#include "runtime/src/mover_parameters.h"

namespace photic::runtime {
namespace {

constexpr double kPi = std::numbers::pi;

Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
Vec3 operator*(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
double length(const Vec3& a) { return std::sqrt(dot(a, a)); }
Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
bool finite(const Vec3& a) { return std::isfinite(a.x + a.y + a.z); }

struct Vec2 {
    double x = 0, y = 0;
};
double cross(const Vec2& a, const Vec2& b) { return a.x * b.y - a.y * b.x; }

struct Cone {
    Cone(const Vec3& from, const Vec3& along, double tan, double begin, double end)
        : apex(from), axis(along), tangent(tan), near(begin), far(end) {
        // Duff et al. 2017, Building an Orthonormal Basis, Revisited.
        const double s = axis.z < 0 ? -1 : 1, a = -1 / (s + axis.z), b = axis.x * axis.y * a;
        u = {1 + s * axis.x * axis.x * a, s * b, -s * axis.x};
        v = {b, s + axis.y * axis.y * a, -axis.y};
    }
    Vec3 inFrame(const Vec3& w) const { return {dot(u, w), dot(v, w), dot(axis, w)}; }
    Vec3 apex, axis, u, v;
    double tangent, near, far;
};

double discsOverlap(double radius, double apart) {
    if (apart >= 1 + radius) return 0;
    if (apart <= std::fabs(radius - 1)) return radius >= 1 ? 1 : radius * radius;
    if (radius > 50) {
        const double s = std::clamp(radius - apart, -1.0, 1.0);
        return 0.5 + (s * std::sqrt(1 - s * s) + std::asin(s)) / kPi;
    }
    const double square = apart * apart, r2 = radius * radius;
    const double alpha = std::acos(std::clamp((square + 1 - r2) / (2 * apart), -1.0, 1.0));
    const double beta = std::acos(std::clamp((square + r2 - 1) / (2 * apart * radius), -1.0, 1.0));
    const double kite = 0.5 * std::sqrt(std::max(0.0, (1 + radius - apart) * (apart + 1 - radius) *
                                                          (apart - 1 + radius) * (apart + 1 + radius)));
    return std::clamp((alpha + r2 * beta - kite) / kPi, 0.0, 1.0);
}

double angle(const Vec2& a, const Vec2& b) { return std::atan2(cross(a, b), a.x * b.x + a.y * b.y); }

/// Twice the area that the unit disc shares with the triangle of its centre, a and b; signed.
double discTriangle(const Vec2& a, const Vec2& b) {
    const Vec2 d = {b.x - a.x, b.y - a.y};
    const double length2 = d.x * d.x + d.y * d.y, across = cross(a, b), inside = length2 - across * across;
    if (inside <= 0) return angle(a, b);
    const double middle = -(a.x * d.x + a.y * d.y), s = std::sqrt(inside);
    const double first = std::clamp((middle - s) / length2, 0.0, 1.0);
    const double last = std::clamp((middle + s) / length2, 0.0, 1.0);
    const Vec2 p = {a.x + first * d.x, a.y + first * d.y}, q = {a.x + last * d.x, a.y + last * d.y};
    return angle(a, p) + angle(q, b) + cross(p, q);
}

double discQuad(const std::array<Vec3, 4>& corners, double near, double tangent) {
    double sum = 0;
    Vec2 leaves, enters;
    bool cut = false;
    const auto seen = [&](const Vec3& p, double z) { return Vec2{p.x / (z * tangent), p.y / (z * tangent)}; };
    for (std::size_t i = 0; i < 4; ++i) {
        const Vec3 &p = corners[i], &q = corners[(i + 1) % 4];
        const bool from = p.z >= near, to = q.z >= near;
        if (!from && !to) continue;
        Vec2 border;
        if (from != to) {
            border = seen(p + (near - p.z) / (q.z - p.z) * (q - p), near);
            cut = true;
        }
        if (from && !to) leaves = border;
        if (!from && to) enters = border;
        sum += discTriangle(from ? seen(p, p.z) : border, to ? seen(q, q.z) : border);
    }
    return cut ? sum + discTriangle(leaves, enters) : sum;
}

double boxCovers(const Cone& cone, const Mover& box) {
    const Vec3 c = cone.inFrame(box.centre - cone.apex);
    const Vec3 axes[3] = {cone.inFrame(box.half_axes[0]), cone.inFrame(box.half_axes[1]),
                          cone.inFrame(box.half_axes[2])};
    double left = 0, entered = 0;
    for (std::size_t n = 0; n < 6; ++n) {
        Vec3 out = axes[n / 2], a = axes[(n / 2 + 1) % 3];
        const Vec3 b = axes[(n / 2 + 2) % 3];
        if (n & 1) out = -out, a = -a;
        const Vec3 middle = c + out;
        Vec3 normal = cross(a, b);
        if (dot(normal, out) < 0) normal = -normal;
        const bool faces = dot(normal, middle) < 0;
        const double part = discQuad({middle - a - b, middle + a - b, middle + a + b, middle - a + b},
                                     faces ? cone.far : cone.near, cone.tangent);
        (faces ? entered : left) += part;
    }
    return std::clamp((std::fabs(left) - std::fabs(entered)) / (2 * kPi), 0.0, 1.0);
}

double aroundRadius(const Mover& mover) {
    if (mover.shape == MoverShape::Sphere) return mover.radius;
    // The farthest of four corners; the others are their opposites.
    const Vec3 &x = mover.half_axes[0], &y = mover.half_axes[1], &z = mover.half_axes[2];
    return std::max({length(x + y + z), length(x + y - z), length(x - y + z), length(x - y - z)});
}

/// Whether a place at `from` its middle is on a mover's own skin, where it faces the light.
bool onLitSkin(const Vec3& from, const Vec3& back, double radius, const Mover& mover) {
    double out_by = length(from) / std::max(radius, 1e-9), faces = dot(from, back);
    if (mover.shape == MoverShape::Box) {
        out_by = 0;
        for (const Vec3& half : mover.half_axes) {
            const double at = dot(from, half) / dot(half, half);
            if (std::fabs(at) > out_by) out_by = std::fabs(at), faces = at * dot(half, back);
        }
    }
    return out_by > 0.9 && out_by < 1.02 && faces > 0;
}

double shapeCovers(const Cone& cone, const Mover& mover) {
    const Vec3 to = mover.centre - cone.apex;
    const double z = dot(to, cone.axis), radius = aroundRadius(mover);
    if (onLitSkin(-to, cone.axis, radius, mover)) return 0;
    if (z + radius <= cone.near || z - radius >= cone.far) return 0;
    const double apart = length(to - z * cone.axis);
    if (apart > (radius + std::max(0.0, z + radius) * cone.tangent) * (1 + cone.tangent)) return 0;
    if (mover.shape == MoverShape::Box) return boxCovers(cone, mover);
    const double at = std::clamp(z, cone.near, cone.far), wide = at * cone.tangent;
    return discsOverlap(std::sqrt(std::max(0.0, radius * radius - (z - at) * (z - at))) / wide, apart / wide);
}

/// Rows of the map: where a place lies on it, 0 to 1, and its depth.
struct MapRows {
    explicit MapRows(const MoverMap& map) {
        const Vec3 sides[3] = {1 / dot(map.across, map.across) * map.across, 1 / dot(map.up, map.up) * map.up,
                               map.direction};
        for (std::size_t r = 0; r < 3; ++r) way[r] = sides[r], shift[r] = -dot(sides[r], map.corner);
    }
    Vec3 place(const Vec3& p) const {
        return {dot(way[0], p) + shift[0], dot(way[1], p) + shift[1], dot(way[2], p) + shift[2]};
    }
    Vec3 rate(const Vec3& d) const { return {dot(way[0], d), dot(way[1], d), dot(way[2], d)}; }
    Vec3 way[3];
    double shift[3];
};

/// Whether one ray, apex + z * way, meets what the map shows.
bool mapMeets(const Movers& movers, const MapRows& rows, const Cone& cone, const Vec3& way) {
    const MoverMap& map = movers.map;
    const Vec3 start = rows.place(cone.apex), rate = rows.rate(way);
    double begin = cone.near, end = cone.far;
    const auto between = [&](double from, double speed, double low, double high) {
        const double safe = std::fabs(speed) < 1e-9 ? 1e-9 : speed;
        const double a = (low - from) / safe, b = (high - from) / safe;
        begin = std::max(begin, std::min(a, b)), end = std::min(end, std::max(a, b));
    };
    between(start.x, rate.x, 0, 1);
    between(start.y, rate.y, 0, 1);
    between(start.z, rate.z, map.nearest, map.farthest);
    if (!(end > begin)) return false;
    const double step = (end - begin) / movers.map_steps;
    const auto texel = [](double part, int count) {
        return static_cast<std::size_t>(std::clamp(static_cast<int>(part * count), 0, count - 1));
    };
    for (int i = 0; i < movers.map_steps; ++i) {
        const double z = begin + i * step, d0 = start.z + z * rate.z, d1 = d0 + step * rate.z;
        const std::size_t column = texel(start.x + (z + 0.5 * step) * rate.x, map.columns),
                          row = texel(start.y + (z + 0.5 * step) * rate.y, map.rows);
        const float* at = map.depths + 2 * (row * static_cast<std::size_t>(map.columns) + column);
        if (std::max(d0, d1) >= -double(at[0]) && std::min(d0, d1) <= double(at[1])) return true;
    }
    return false;
}

double mapCovers(const Movers& movers, const MapRows& rows, const Cone& cone) {
    int met = 0;
    for (int ray = 0; ray < movers.map_rays; ++ray) {
        const double turn = 2.399963 * ray, out = cone.tangent * std::sqrt((ray + 0.5) / movers.map_rays);
        met += mapMeets(movers, rows, cone, cone.axis + out * std::cos(turn) * cone.u + out * std::sin(turn) * cone.v);
    }
    return static_cast<double>(met) / std::max(1, movers.map_rays);
}

double conePasses(const Movers& movers, const Cone& cone) {
    if (!(cone.far > cone.near)) return 1;
    double passes = 1;
    for (const Mover& mover : movers.shapes) passes *= 1 - shapeCovers(cone, mover);
    if (movers.map.columns > 0 && movers.map.rows > 0 && movers.map.depths && passes > 0)
        passes *= 1 - mapCovers(movers, MapRows(movers.map), cone);
    return passes;
}

/// Tangents of the sun's half angle below and above the surface.
std::array<double, 2> sunTangents(const Movers& movers) {
    constexpr double kLeast = 1e-4;  // a disc of no width has no area to cover
    const double above = std::max(kLeast, std::tan(movers.angular_diameter_deg * kPi / 360));
    return {std::max(kLeast, above / std::max(1.0, movers.ior)), above};
}

void writeRow(float* out, const Vec3& v, double w) {
    out[0] = float(v.x), out[1] = float(v.y), out[2] = float(v.z), out[3] = float(w);
}

}  // namespace

Mover sphere(const Vec3& centre, double radius) { return {MoverShape::Sphere, centre, radius, {}}; }
Mover box(const Vec3& centre, const Vec3& half_x, const Vec3& half_y, const Vec3& half_z) {
    return {MoverShape::Box, centre, 0, {half_x, half_y, half_z}};
}

Movers moversIn(const Metadata& metadata) {
    Movers movers;
    std::copy_n(metadata.surface, 4, movers.surface);
    movers.ior = metadata.ior;
    return movers;
}

double passesMovers(const Movers& movers, const Vec3& world, const Vec3& flux, double mean) {
    const double size = length(flux);
    if (!(size > 0) || !std::isfinite(size)) return 1;
    const Vec3 back = -1 / size * flux;
    const double cosine = std::clamp(2 * (size / std::max(mean, size) + 0.001) - 1, 0.7, 1.0);
    const auto [sun, air] = sunTangents(movers);
    const double tangent = std::max(sun, movers.spread * std::sqrt(1 - cosine * cosine) / cosine);
    const Vec3 normal = {movers.surface[0], movers.surface[1], movers.surface[2]};
    const double below = movers.surface[3] - dot(normal, world), rate = dot(normal, back);
    const double surface = below >= 0 && rate > 0 ? below / rate : movers.reach;
    const double passes = conePasses(movers, Cone(world, back, tangent, movers.bias, std::min(surface, movers.reach)));
    const double sun_size = length(movers.sun);
    if (sun_size == 0 || !(surface < movers.reach) || !(passes > 0)) return passes;
    const Vec3 down = 1 / sun_size * movers.sun;
    const double wide = std::max(surface * tangent, 1e-4), height = wide / air;
    return passes * conePasses(movers, Cone(world + surface * back + height * down, -down, air, height,
                                            height + movers.reach - surface));
}

Light sample(const Volume& volume, const Vec3& world, const Movers& movers) {
    Light first = volume.sample(world), out;
    const auto add = [&](const Light& lobe) {
        const double mean = (lobe.irradiance.x + lobe.irradiance.y + lobe.irradiance.z) / 3;
        const double passes = passesMovers(movers, world, lobe.flux, mean);
        out.irradiance = out.irradiance + passes * lobe.irradiance;
        out.flux = out.flux + passes * lobe.flux;
    };
    if (volume.hasSecondLobe()) {
        const Light second = volume.secondLobe().sample(world);
        first.irradiance = first.irradiance - second.irradiance, first.flux = first.flux - second.flux;
        add(second);
    }
    add(first);
    return out;
}

Vec3 irradiance(const Volume& volume, const Vec3& world, const Vec3& normal, const Movers& movers) {
    Light first = volume.sample(world);
    Vec3 received = volume.irradiance(world, normal), out;
    const auto add = [&](const Light& lobe, const Vec3& gets) {
        const double mean = (lobe.irradiance.x + lobe.irradiance.y + lobe.irradiance.z) / 3;
        out = out + passesMovers(movers, world, lobe.flux, mean) * gets;
    };
    if (volume.hasSecondLobe()) {
        const Volume lobe = volume.secondLobe();
        const Light second = lobe.sample(world);
        const Vec3 gets = lobe.irradiance(world, normal);
        first.irradiance = first.irradiance - second.irradiance, first.flux = first.flux - second.flux;
        received = received - gets;
        add(second, gets);
    }
    add(first, received);
    return out;
}

namespace {

void requireSense(const Movers& movers) {
    if (movers.shapes.size() > static_cast<std::size_t>(Movers::kMostShapes)) {
        fail(ErrorCode::Usage, std::to_string(movers.shapes.size()) + " movers; at most " +
                                   std::to_string(Movers::kMostShapes) +
                                   " darken at once: leave out the farthest, or "
                                   "draw them to a map");
    }
    for (std::size_t n = 0; n < movers.shapes.size(); ++n) {
        const double around = aroundRadius(movers.shapes[n]);
        if (!finite(movers.shapes[n].centre) || !(around >= 0) || !std::isfinite(around))
            fail(ErrorCode::Usage, "mover " + std::to_string(n) +
                                       " has a place or a size that is not finite, or a "
                                       "radius below 0");
    }
    const bool sound = movers.spread >= 0 && movers.spread <= 1 && movers.reach > 0 && movers.bias > 0 &&
                       movers.angular_diameter_deg >= 0 && movers.angular_diameter_deg <= 60 && finite(movers.sun);
    if (!sound)
        fail(ErrorCode::Usage,
             "Movers: spread 0 to 1, reach and bias above 0 m, angular_diameter_deg 0 to 60, and a "
             "sun that is finite");
    const MoverMap& map = movers.map;
    if (map.columns <= 0 || map.rows <= 0) return;
    constexpr int kMost = 4096;
    if (movers.map_steps < 1 || movers.map_steps > kMost || movers.map_rays < 1 || movers.map_rays > kMost)
        fail(ErrorCode::Usage, "a map of movers takes 1 to 4096 steps and rays");
    if (!(dot(map.across, map.across) > 0 && dot(map.up, map.up) > 0 && map.farthest >= map.nearest &&
          std::fabs(length(map.direction) - 1) < 1e-3))
        fail(ErrorCode::Usage,
             "a map of movers has sides of some length, a unit direction, and nearest before farthest");
}

}  // namespace

MoverParameters moverParameters(const Movers& movers) {
    requireSense(movers);
    MoverParameters p{};
    // What is infinite stands for "nowhere", and GLSL need not know infinity.
    constexpr double kNowhere = 1e30;
    writeRow(p.surface, {movers.surface[0], movers.surface[1], movers.surface[2]},
             std::clamp(movers.surface[3], -kNowhere, kNowhere));
    const double sun_size = length(movers.sun);
    if (sun_size > 0) writeRow(p.sun, 1 / sun_size * movers.sun, 1);
    const auto [below, above] = sunTangents(movers);
    writeRow(p.cone, {below, above, movers.spread}, std::min(movers.reach, kNowhere));
    p.range[2] = float(movers.bias);
    p.count[0] = static_cast<std::int32_t>(movers.shapes.size());
    if (movers.map.columns > 0 && movers.map.rows > 0) {
        p.count[1] = movers.map_steps, p.count[2] = movers.map_rays;
        const MapRows rows(movers.map);
        float* const to[3] = {p.map_u, p.map_v, p.map_d};
        for (std::size_t r = 0; r < 3; ++r) writeRow(to[r], rows.way[r], rows.shift[r]);
        p.range[0] = float(movers.map.nearest), p.range[1] = float(movers.map.farthest);
    }
    for (std::size_t n = 0; n < movers.shapes.size(); ++n) {
        const Mover& mover = movers.shapes[n];
        writeRow(p.shapes[4 * n], mover.centre, aroundRadius(mover));
        for (std::size_t a = 0; a < 3 && mover.shape == MoverShape::Box; ++a)
            writeRow(p.shapes[4 * n + 1 + a], mover.half_axes[a], 1);
    }
    return p;
}

Result<MoverBytes> packMovers(const Movers& movers) {
    return guarded([&]() -> Result<MoverBytes> {
        MoverBytes bytes;
        const MoverParameters parameters = moverParameters(movers);
        static_assert(sizeof(parameters) == sizeof(bytes));
        std::memcpy(bytes.data(), &parameters, sizeof(bytes));
        return bytes;
    });
}

}  // namespace photic::runtime
