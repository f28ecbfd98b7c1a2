// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/eikonal_front.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "bake/optics/snell.h"
#include "bake/paths/launch_domain.h"
#include "bake/report/error.h"
#include "bake/scene/index_volume.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr int kMaxSamples = 6000;  // a side of the table
constexpr double kSamplesAFeature =
    6;  // features are an eighth of a wavelength: 48 samples a wave, curvature to 1.4e-3

/// The steepest slope of the surface over a rectangle, by samples.
double steepestSlope(const HeightField& field, const Rectangle& over) {
    double steepest = 0;
    for (int j = 0; j < 128; ++j)
        for (int i = 0; i < 128; ++i) {
            const glm::dvec3 n = field.at(glm::mix(over.low, over.high, glm::dvec2(i, j) / 127.0)).normal;
            steepest = std::max(steepest, std::hypot(n.x, n.y) / std::max(n.z, 1e-3));
        }
    return steepest;
}

/// Where first arrivals in the box may have left the surface.
Rectangle reachOf(const Scene& scene, const Surface& surface, const Light& light, const GridFrame& frame,
                  bool infinite) {
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    for (unsigned c = 0; c < 8; ++c) {
        glm::dvec3 index;
        for (int a = 0; a < 3; ++a) index[a] = c >> a & 1 ? frame.max[a] + 4 : frame.min[a] - 4;
        const glm::dvec3 p = frame.worldFromIndex(index);
        low = glm::min(low, p), high = glm::max(high, p);
    }
    Rectangle r{glm::dvec2(low), glm::dvec2(high)};
    const HeightField& field = *surface.height_field;
    const double depth = std::max(0.0, field.maxZ() - low.z);
    // Rays that leave along the normal get as far to the side as the water is deep, times the slope.
    const auto widened = [&](const Rectangle& from) {
        const double reach = depth * std::min(1.2 * steepestSlope(field, {from.low - depth, from.high + depth}), 1.0);
        return Rectangle{from.low - reach, from.high + reach};
    };
    if (infinite) return widened(r);
    if (light.position) {
        // Straight lines cross the surface further towards the light than refracted ones.
        const glm::dvec3 source = *light.position;
        for (const double z : {field.minZ(), field.maxZ()})
            for (unsigned c = 0; c < 4; ++c) {
                const glm::dvec3 corner(c & 1 ? high.x : low.x, c & 2 ? high.y : low.y, low.z);
                const double part = std::clamp((source.z - z) / (source.z - corner.z), 0.0, 1.0);
                const glm::dvec2 crossing(glm::mix(source, corner, part));
                r.low = glm::min(r.low, crossing), r.high = glm::max(r.high, crossing);
            }
        r = widened(r);
    } else {
        Surface least = surface;  // rays run further to the side where n is less
        if (scene.index) least.ior_below = scene.index->least();
        const LaunchDomain launched = launchDomain(scene, least, light, frame);
        if (!launched.empty()) r.low = glm::min(r.low, launched.min), r.high = glm::max(r.high, launched.max);
    }
    if (scene.index) {
        // A ray bends by |grad n| / n a metre. At the sides nothing comes in, and differences spread that inwards by
        // some cells, as the root of the way.
        const glm::dvec2 bend = 0.5 * depth / scene.index->least() * glm::dvec2(scene.index->steepest());
        const double h = frame.worldFromIndex()[0].x;
        const glm::dvec2 aside = glm::min(bend, glm::dvec2(1)) * depth + (6 + 2 * std::sqrt(depth / h)) * h;
        r.low -= aside, r.high += aside;
    }
    return r;
}

/// Heights over world x and y, horizontal displacement undone.
std::vector<double> heightsOn(const HeightField& field, glm::dvec2 corner, double spacing, int nx, int ny) {
    std::vector<double> heights(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny));
    const bool displaced = field.maxDisplacement() > 0;
    parallelFor(ny, [&](std::int64_t j) {
        double* out = &heights[static_cast<std::size_t>(j) * static_cast<std::size_t>(nx)];
        const glm::dvec2 start = corner + glm::dvec2(0, static_cast<double>(j) * spacing);
        if (!displaced) {
            thread_local SurfaceRow row;
            field.row(start, spacing, static_cast<std::size_t>(nx), row);
            std::copy(row.pz.begin(), row.pz.end(), out);
            return;
        }
        for (int i = 0; i < nx; ++i) {
            const glm::dvec2 wanted = start + glm::dvec2(i * spacing, 0);
            glm::dvec2 uv = wanted;
            SurfacePoint p;
            for (int step = 0; step < 30; ++step) {
                p = field.at(uv);
                const glm::dvec2 miss = wanted - glm::dvec2(p.position);
                uv += miss;
                if (std::fabs(miss.x) + std::fabs(miss.y) < 1e-10 * spacing) break;
            }
            out[i] = p.position.z;
        }
    });
    return heights;
}

}  // namespace

EikonalFront::EikonalFront(const Scene& scene, const EikonalOptions& options, const GridFrame& frame)
    : light_(&scene.lights.front()),
      surface_(&scene.surfaces.front()),
      index_(scene.index.get()),
      infinite_(options.preset == EikonalPreset::Mercier),
      reach_(reachOf(scene, *surface_, *light_, frame, infinite_)),
      slowness_(infinite_ ? 1.0 : surface_->ior_below) {
    const double h = frame.worldFromIndex()[0].x;
    Rectangle reach = reach_;
    if (index_) reach.low -= 8 * h, reach.high += 8 * h;  // feet of the seeds at the sides
    const glm::dvec2 extent = reach.high - reach.low;
    const double longest = std::max(extent.x, extent.y);
    const HeightField& field = *surface_->height_field;
    double spacing = std::min(h, field.featureSize() / kSamplesAFeature);
    if (!std::isfinite(field.featureSize())) spacing = longest / 32;
    if (longest / spacing > kMaxSamples) {
        if (longest / kMaxSamples > field.featureSize())
            throw Error(
                ErrorCode::Input,
                fmt::format("the surface has features of {:.3g} m over {:.3g} m: more than {} samples a side; use a "
                            "smaller domain",
                            field.featureSize(), longest, kMaxSamples),
                surface_->where);
        spacing = longest / kMaxSamples;
    }
    constexpr int margin = HeightTable::kMargin + 2;
    const int nx = static_cast<int>(std::ceil(extent.x / spacing)) + 2 * margin + 1;
    const int ny = static_cast<int>(std::ceil(extent.y / spacing)) + 2 * margin + 1;
    const glm::dvec2 corner = reach.low - margin * spacing;
    table_ = std::make_unique<HeightTable>(corner, spacing, nx, ny, heightsOn(field, corner, spacing, nx, ny));
    if (!index_) return;
    constexpr int kSamples = 24;
    double sum = 0;
    for (int j = 0; j < kSamples; ++j)
        for (int i = 0; i < kSamples; ++i) {
            const glm::dvec2 xy = glm::mix(reach.low, reach.high, (glm::dvec2(i, j) + 0.5) / double(kSamples));
            sum += index_->at({xy, table_->at(xy).h});
        }
    slowness_ = sum / (kSamples * kSamples);
}

FrontOnSurface EikonalFront::front() const {
    FrontOnSurface front{table_.get(), glm::dvec3(0), slowness_};
    if (infinite_) return front;
    if (light_->position)
        front.source = *light_->position, front.outside = surface_->ior_above;
    else
        front.gradient = surface_->ior_above * light_->direction;
    return front;
}

double EikonalFront::slownessAt(const glm::dvec3& place) const { return index_ ? index_->at(place) : slowness_; }

double EikonalFront::entering(const glm::dvec3& foot, double slope_x, double slope_y,
                              const glm::dvec3& direction) const {
    const double inverse = 1 / std::sqrt(1 + slope_x * slope_x + slope_y * slope_y);
    const glm::dvec3 down = glm::dvec3(slope_x, slope_y, -1) * inverse;
    glm::dvec3 coming = light_->direction;
    double share = 1;
    if (light_->position) {
        const glm::dvec3 from = foot - *light_->position, centre = surface_->center - *light_->position;
        coming = glm::normalize(from), share = glm::dot(centre, centre) / glm::dot(from, from);
    }
    const double cos_i = glm::dot(coming, down), cos_t = glm::dot(direction, down);
    if (!(cos_i > 0) || !(cos_t > 0)) return 0;
    if (infinite_) return share * cos_i;
    return share * fresnelTransmittance(cos_i, cos_t, surface_->ior_above, slownessAt(foot)) * cos_i / cos_t;
}

CausticMap::CausticMap(const EikonalFront& front, double spacing) : highest_(-std::numeric_limits<double>::infinity()) {
    const HeightTable& table = front.table();
    const glm::dvec2 low = table.corner() + table.spacing() * HeightTable::kMargin;
    const glm::dvec2 high = table.corner() + table.spacing() * (glm::dvec2(table.countX(), table.countY()) - 1.0 -
                                                                double(HeightTable::kMargin));
    const auto nx = static_cast<int>((high.x - low.x) / spacing), ny = static_cast<int>((high.y - low.y) / spacing);
    const double n2 = front.slowness();
    const FrontOnSurface coming = front.front();
    std::vector<std::vector<Ray>> rows(static_cast<std::size_t>(std::max(ny, 0)));
    parallelFor(ny, [&](std::int64_t j) {
        for (int i = 0; i < nx; ++i) {
            const glm::dvec2 xy = low + glm::dvec2(i + 0.5, static_cast<double>(j) + 0.5) * spacing;
            const HeightPoint s = table.at(xy);
            const glm::dvec3 normal = glm::normalize(glm::dvec3(-s.hx, -s.hy, 1)), g = coming.gradientAt({xy, s.h});
            // What the front brings along the surface goes on; the rest follows from |grad T| = n2.
            const glm::dvec3 along = g - glm::dot(g, normal) * normal;
            const double across2 = n2 * n2 - glm::dot(along, along);
            if (across2 <= 0) continue;
            const glm::dvec3 w = (along - std::sqrt(across2) * normal) / n2;
            if (w.z >= -1e-3) continue;
            // As in sweepFootPoints: K = P^-1 A / n2.
            const double bend = g.z - n2 * w.z, wu = w.x + w.z * s.hx, wv = w.y + w.z * s.hy;
            double a11 = bend * s.hxx, a12 = bend * s.hxy, a22 = bend * s.hyy;
            if (coming.outside > 0) {
                const glm::dvec3 way = glm::dvec3(xy, s.h) - coming.source;
                const double far = glm::length(way), q = coming.outside / far;
                const double su = (way.x + way.z * s.hx) / far, sv = (way.y + way.z * s.hy) / far;
                a11 += q * (1 + s.hx * s.hx - su * su), a12 += q * (s.hx * s.hy - su * sv);
                a22 += q * (1 + s.hy * s.hy - sv * sv);
            }
            const double m11 = 1 + s.hx * s.hx - wu * wu, m12 = s.hx * s.hy - wu * wv, m22 = 1 + s.hy * s.hy - wv * wv;
            const double inverse = 1 / (n2 * (m11 * m22 - m12 * m12));
            const double trace = (m22 * a11 - 2 * m12 * a12 + m11 * a22) * inverse;
            const double det = (a11 * a22 - a12 * a12) * inverse / n2;
            const double least = 0.5 * (trace - std::sqrt(std::max(0.0, trace * trace - 4 * det)));  // curvature
            if (!(least < -1e-9)) continue;
            const glm::dvec3 focus = glm::dvec3(xy, s.h) - w / least;
            rows[static_cast<std::size_t>(j)].push_back({focus, glm::dvec2(w) / -w.z});
        }
    });
    for (const auto& row : rows)
        for (const Ray& ray : row) {
            rays_.push_back(ray);
            highest_ = std::max(highest_, ray.focus.z);
        }
    std::sort(rays_.begin(), rays_.end(), [](const Ray& a, const Ray& b) { return a.focus.z > b.focus.z; });
}

void CausticMap::layer(double z, glm::dvec2 corner, glm::dvec2 step, int count_x, int count_y,
                       std::vector<std::uint8_t>& marks) const {
    marks.assign(static_cast<std::size_t>(count_x) * static_cast<std::size_t>(count_y), 0);
    for (const Ray& ray : rays_) {
        if (ray.focus.z < z) break;
        const glm::dvec2 at = (glm::dvec2(ray.focus) + (ray.focus.z - z) * ray.slope - corner) / step;
        const auto i = static_cast<int>(std::floor(at.x)), j = static_cast<int>(std::floor(at.y));
        // The four cells around it: rays past a focus lie apart.
        for (int dj = 0; dj < 2; ++dj)
            for (int di = 0; di < 2; ++di)
                if (i + di >= 0 && i + di < count_x && j + dj >= 0 && j + dj < count_y)
                    marks[static_cast<std::size_t>(j + dj) * static_cast<std::size_t>(count_x) +
                          static_cast<std::size_t>(i + di)] = 1;
    }
}

}  // namespace photic
