// SPDX-License-Identifier: Apache-2.0
#include "tests/support/pool3.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>
#include <stdexcept>

#include "tests/support/closed_forms.h"

namespace photic::truth {
namespace pool3 {
namespace {

struct Wave {
    double amplitude, wavelength, direction_deg, phase;
};
constexpr std::array<Wave, 3> kWaves{{{0.035, 1.30, 20, 0.4}, {0.025, 0.80, 95, 1.7}, {0.020, 0.50, -40, 2.9}}};

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

FloorMap readMap(const std::string& name) {
    const std::string path = std::string(PHOTIC_SOURCE_DIR) + "/tests/data/" + name;
    std::ifstream in(path, std::ios::binary);
    FloorMap map;
    map.size = 512;
    std::vector<float> raw(512 * 512);
    if (!in.read(reinterpret_cast<char*>(raw.data()), static_cast<std::streamsize>(raw.size() * sizeof(float)))) {
        throw std::runtime_error("cannot read " + path);
    }
    map.values.assign(raw.begin(), raw.end());
    return map;
}

struct Corner {
    glm::dvec3 position{0};
    glm::dvec2 landing{0};  // in pixels
    double transmittance = 0;
};

Corner traceCorner(double x, double y, const glm::dvec3& d, int pixels) {
    const glm::dvec3 s = surface(x, y);
    const glm::dvec3 n = glm::normalize(glm::dvec3(-s.y, -s.z, 1));
    const double cos_in = -glm::dot(d, n), ratio = 1 / kIor;
    const double cos_out = std::sqrt(1 - ratio * ratio * (1 - cos_in * cos_in));
    const glm::dvec3 r = ratio * d + (ratio * cos_in - cos_out) * n;
    Corner c;
    c.position = {x, y, s.x};
    const double t = (kFloor - s.x) / r.z;
    c.landing = (glm::dvec2(x + t * r.x, y + t * r.y) + 1.0) * (pixels / 2.0);
    c.transmittance = fresnelTransmittance(cos_in, 1, kIor);
    return c;
}

/// A convex polygon of at most 3 + 4 corners, and what is left of it on one side of an axis-parallel line.
struct Polygon {
    std::array<glm::dvec2, 8> p{};
    int count = 0;
    double area() const {
        double twice = 0;
        for (int i = 1; i + 1 < count; ++i) {
            const glm::dvec2 a = p[i] - p[0], b = p[i + 1] - p[0];
            twice += a.x * b.y - a.y * b.x;
        }
        return std::fabs(twice) / 2;
    }
    Polygon cut(int axis, double sign, double limit) const {
        Polygon out;
        for (int i = 0; i < count; ++i) {
            const glm::dvec2 &a = p[i], &b = p[(i + 1) % count];
            const double da = sign * (a[axis] - limit), db = sign * (b[axis] - limit);
            if (da >= 0) out.p[out.count++] = a;
            if ((da > 0 && db < 0) || (da < 0 && db > 0)) out.p[out.count++] = a + (b - a) * (da / (da - db));
        }
        return out;
    }
};

void land(FloorMap& map, const Corner& a, const Corner& b, const Corner& c, const glm::dvec3& d) {
    Polygon triangle;
    triangle.p = {a.landing, b.landing, c.landing};
    triangle.count = 3;
    const glm::dvec2 low = glm::dvec2(std::min({a.landing.x, b.landing.x, c.landing.x}),
                                      std::min({a.landing.y, b.landing.y, c.landing.y}));
    const glm::dvec2 high = glm::dvec2(std::max({a.landing.x, b.landing.x, c.landing.x}),
                                       std::max({a.landing.y, b.landing.y, c.landing.y}));
    const int n = map.size;
    if (high.x <= 0 || high.y <= 0 || low.x >= n || low.y >= n) return;

    const double power = std::fabs(glm::dot(glm::cross(b.position - a.position, c.position - a.position), d)) / 2 *
                         (a.transmittance + b.transmittance + c.transmittance) / 3;
    const double area = triangle.area();
    if (area < 1e-9) {  // folded onto a line: too thin to divide by
        const glm::dvec2 middle = (a.landing + b.landing + c.landing) / 3.0;
        const int x = static_cast<int>(std::floor(middle.x)), y = static_cast<int>(std::floor(middle.y));
        if (x >= 0 && y >= 0 && x < n && y < n) map.values[static_cast<std::size_t>(y) * n + x] += power;
        return;
    }
    const auto first = [](double v) { return std::max(0, static_cast<int>(std::floor(v))); };
    const auto last = [n](double v) { return std::min(n - 1, static_cast<int>(std::floor(v))); };
    for (int y = first(low.y); y <= last(high.y); ++y) {
        const Polygon row = triangle.cut(1, 1, y).cut(1, -1, y + 1);
        if (row.count < 3) continue;
        double x_low = row.p[0].x, x_high = x_low;
        for (int i = 1; i < row.count; ++i) x_low = std::min(x_low, row.p[i].x), x_high = std::max(x_high, row.p[i].x);
        for (int x = first(x_low); x <= last(x_high); ++x) {
            const Polygon cell = row.cut(0, 1, x).cut(0, -1, x + 1);
            if (cell.count >= 3) map.values[static_cast<std::size_t>(y) * n + x] += power * cell.area() / area;
        }
    }
}

}  // namespace

glm::dvec3 surface(double x, double y) {
    glm::dvec3 s{0};
    for (const Wave& w : kWaves) {
        const double k = 2 * std::numbers::pi / w.wavelength;
        const double kx = k * std::cos(radians(w.direction_deg)), ky = k * std::sin(radians(w.direction_deg));
        const double angle = kx * x + ky * y + w.phase;
        s.x += w.amplitude * std::sin(angle);
        s.y += w.amplitude * kx * std::cos(angle);
        s.z += w.amplitude * ky * std::cos(angle);
    }
    return s;
}

glm::dvec3 sun() {
    const double zenith = radians(30), azimuth = radians(30);
    return {std::sin(zenith) * std::cos(azimuth), std::sin(zenith) * std::sin(azimuth), -std::cos(zenith)};
}

FloorMap exactFloor() { return readMap("pool3_floor_512.f32"); }
FloorMap exactDiscFloor() { return readMap("pool3_disc_floor_512.f32"); }

FloorMap traceFloor(int mesh, int pixels, const glm::dvec3& direction) {
    FloorMap map;
    map.size = pixels;
    map.values.assign(static_cast<std::size_t>(pixels) * pixels, 0);
    const double h = 4.0 / mesh;
    std::vector<Corner> below(static_cast<std::size_t>(mesh) + 1), above(below.size());
    const auto trace = [&](int row, std::vector<Corner>& out) {
        for (int i = 0; i <= mesh; ++i)
            out[static_cast<std::size_t>(i)] = traceCorner(-2 + i * h, -2 + row * h, direction, pixels);
    };
    trace(0, below);
    for (int row = 1; row <= mesh; ++row) {
        trace(row, above);
        for (std::size_t i = 0; i < static_cast<std::size_t>(mesh); ++i) {
            land(map, below[i], below[i + 1], above[i + 1], direction);
            land(map, below[i], above[i + 1], above[i], direction);
        }
        below.swap(above);
    }
    const double pixel_area = 4.0 / (static_cast<double>(pixels) * pixels);
    for (double& v : map.values) v /= pixel_area;
    return map;
}

std::vector<glm::dvec3> discDirections(const glm::dvec3& axis, double angular_diameter_deg, int count) {
    const glm::dvec3 side =
        glm::normalize(glm::cross(axis, std::fabs(axis.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
    const glm::dvec3 up = glm::cross(side, axis);
    const double radius = std::tan(radians(angular_diameter_deg) / 2);
    const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
    std::vector<glm::dvec3> out;
    for (int i = 0; i < count; ++i) {
        const double r = radius * std::sqrt((i + 0.5) / count), angle = golden * i;
        out.push_back(glm::normalize(axis + r * std::cos(angle) * side + r * std::sin(angle) * up));
    }
    return out;
}

std::string sceneToml(const SceneText& text) {
    std::string waves;
    char line[1024];
    for (const Wave& w : kWaves) {
        std::snprintf(line, sizeof line,
                      "  { amplitude = %.17g, wavelength = %.17g, direction = %.17g, phase = %.17g },\n", w.amplitude,
                      w.wavelength, w.direction_deg, w.phase);
        waves += line;
    }
    const glm::dvec3 d = sun();
    std::snprintf(
        line, sizeof line,
        "photic = 1\n[domain]\nmin = [%.17g, %.17g, %.17g]\nmax = [%.17g, %.17g, %.17g]\nvoxel_size = %.17g\n",
        -text.half.x, -text.half.y, text.z_min, text.half.x, text.half.y, text.z_max, text.voxel_size);
    std::string out = line;
    if (text.layer_height > 0) {
        std::snprintf(line, sizeof line, "layer_height = %.17g\n", text.layer_height);
        out += line;
    }
    out += "shear = " + (text.shear.starts_with("[") ? text.shear : "\"" + text.shear + "\"") + "\n";
    std::snprintf(
        line, sizeof line,
        "[[light]]\ntype = \"sun\"\ndirection = [%.17g, %.17g, %.17g]\nirradiance = %.17g\nangular_diameter = %.17g\n",
        d.x, d.y, d.z, text.irradiance, text.angular_diameter_deg);
    out += line;
    out +=
        "[[surface]]\nname = \"water\"\nkind = \"height_field\"\nsize = [4.0, 4.0]\noutside = \"none\"\nevent = "
        "\"refract\"\n"
        "ior_above = 1.0\nior_below = 1.333\nwaves = [\n" +
        waves + "]\n";
    out += text.objects;
    out += "[bake]\n" + text.bake;
    if (!text.beams.empty()) out += "[bake.beams]\n" + text.beams;
    return out;
}

}  // namespace pool3

double relativeL1(const std::vector<double>& a, const std::vector<double>& reference) {
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < reference.size(); ++i)
        difference += std::fabs(a[i] - reference[i]), sum += reference[i];
    return difference / sum;
}

double relativeRmse(const std::vector<double>& a, const std::vector<double>& reference) {
    double squares = 0, sum = 0;
    for (std::size_t i = 0; i < reference.size(); ++i) {
        squares += (a[i] - reference[i]) * (a[i] - reference[i]);
        sum += reference[i];
    }
    return std::sqrt(squares / static_cast<double>(reference.size())) / (sum / static_cast<double>(reference.size()));
}

}  // namespace photic::truth
