// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/wave_release.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "bake/methods/wave_index.h"
#include "bake/optics/beer_lambert.h"
#include "bake/optics/snell.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

/// One refracted ray of the surface.
struct Ray {
    glm::dvec3 position{0}, direction{0};
    double power = 0;     ///< that it carries per unit of parameter area
    double arriving = 0;  ///< the same before the surface
};

class Refractor {
public:
    Refractor(const Surface& surface, const glm::dvec3& direction, const WaveIndex* index)
        : surface_(surface), direction_(direction), index_(index) {}

    Ray at(glm::dvec2 uv) const {
        const SurfacePoint p = surface_.height_field->at(uv);
        Ray ray;
        ray.position = p.position;
        const double facing = -glm::dot(p.normal, direction_);
        const Interface i = interfaceAt(direction_, glm::normalize(p.normal), surface_.ior_above,
                                        index_ ? index_->at(p.position) : surface_.ior_below);
        ray.direction = i.refracted;
        if (surface_.outside == Outside::None) {
            const glm::dvec2 off = glm::abs(uv - glm::dvec2(surface_.center)) - 0.5 * surface_.size;
            if (off.x > 0 || off.y > 0) return ray;
        }
        if (facing > 0) ray.arriving = facing, ray.power = facing * i.transmittance;
        return ray;
    }
    /// Where the ray of uv is at height z.
    static glm::dvec2 landing(const Ray& ray, double z) {
        const double run = (z - ray.position.z) / std::min(ray.direction.z, -1e-3);
        return glm::dvec2(ray.position) + run * glm::dvec2(ray.direction);
    }
    /// The parameter whose ray passes `point`. Near the surface the map is close to the identity, and corrected
    /// values converge by the ratio of the distance to the focal length.
    glm::dvec2 foot(const glm::dvec3& point, double tolerance) const {
        glm::dvec2 uv(point);
        for (int i = 0; i < 40; ++i) {
            const glm::dvec2 miss = glm::dvec2(point) - landing(at(uv), point.z);
            uv += miss;
            if (glm::dot(miss, miss) < tolerance * tolerance) break;
        }
        return uv;
    }

private:
    const Surface& surface_;
    glm::dvec3 direction_;
    const WaveIndex* index_;
};

std::size_t columnIndex(const glm::ivec3& size, int x, int y) {
    return static_cast<std::size_t>(x) * static_cast<std::size_t>(size.y) + static_cast<std::size_t>(y);
}

/// Integral of the power of 1 W along a ray within the cells that count [m].
double pathWithin(const WaveCells& cells, const Ray& ray, double extinction) {
    const glm::dvec3 low = cells.world(glm::dvec3(cells.asked_low) - 0.5),
                     high = cells.world(glm::dvec3(cells.asked_high) + 0.5);
    double from = 0, to = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a) {
        if (cells.grid.periodic[static_cast<std::size_t>(a)]) continue;  // what leaves comes in again
        if (ray.direction[a] == 0) {
            if (ray.position[a] < low[a] || ray.position[a] > high[a]) return 0;
            continue;
        }
        const double one = (low[a] - ray.position[a]) / ray.direction[a],
                     other = (high[a] - ray.position[a]) / ray.direction[a];
        from = std::max(from, std::min(one, other)), to = std::min(to, std::max(one, other));
    }
    return to > from ? meanTransmittance(extinction, from, to - from) * (to - from) : 0;
}

int blockOf(const WaveCells& cells, const glm::ivec3& local) { return cells.grid.index(local >> 3); }
int offsetOf(const glm::ivec3& local) { return (local.x & 7) << 6 | (local.y & 7) << 3 | (local.z & 7); }

/// Highest wet cell of a column, from the lowest.
int wetTop(float level) { return static_cast<int>(std::ceil(level)) - 1; }

/// What one x of the columns releases.
struct ReleasedRow {
    std::vector<WaveDriven> driven;
    std::vector<WaveRim> rim;
    double launched = 0, reflected = 0, path = 0;
    int folded = 0;
};

/// The pulse of one light, column by column.
class PulseRelease {
public:
    PulseRelease(const WaveCells& cells, const LitSurface& lit, const PulseInWater& water, const WaveRelease& surface)
        : cells_(cells),
          water_(water),
          surface_(surface),
          rays_(lit.surface, lit.light.direction, water.index),
          direction_(lit.light.direction),
          slowness_(lit.surface.ior_above / lit.surface.ior_below),
          step_(0.25 * std::min(cells.grid.spacing.x, cells.grid.spacing.y)) {}

    /// Adds the column (x, y): its driven cells, and its light through the whole box.
    void addColumn(int x, int y, ReleasedRow& out) const {
        const glm::ivec3 size = cells_.size(), low = cells_.lowCell();
        const float level = surface_.level[columnIndex(size, x, y)];
        const int first = std::max(wetTop(level) + 1, 0), top = surface_.top[columnIndex(size, x, y)];
        for (int z = first; z <= top; ++z) addCell({x, y, z}, level, out);
        const Ray ray = rays_.at(glm::dvec2(cells_.world(glm::dvec3(low + glm::ivec3(x, y, 0)))));
        out.launched += ray.arriving, out.reflected += ray.arriving - ray.power;
        if (ray.power > 0) out.path += ray.power * pathWithin(cells_, ray, water_.extinction);
    }

private:
    void addCell(const glm::ivec3& local, float level, ReleasedRow& out) const {
        const int block = blockOf(cells_, local);
        if (!cells_.grid.has(block)) return;
        const glm::ivec3 cell = cells_.lowCell() + local;
        const glm::dvec3 point = cells_.world(glm::dvec3(cell));
        const glm::dvec2 uv = rays_.foot(point, 1e-6 * step_);
        const Ray ray = rays_.at(uv);
        double spread = spreadAt(uv, point.z);
        if (spread < 0.1) ++out.folded, spread = 0.1;
        const double irradiance = ray.power / (spread * std::max(-ray.direction.z, 1e-3));
        if (irradiance <= 0) return;
        const double along = (point.z - ray.position.z) / ray.direction.z;
        WaveDriven d;
        d.block = block, d.cell = static_cast<std::uint16_t>(offsetOf(local));
        const WaveIndex* index = water_.index;
        const double carried = index ? index->carriedAt(point) : 1,
                     here = index ? index->slownessAt(0.5 * (point + ray.position)) : 1;
        d.amplitude = static_cast<float>(std::sqrt(irradiance / carried) * std::exp(-0.5 * water_.extinction * along));
        d.arrival = slowness_ * glm::dot(direction_, ray.position) + here * along;
        out.driven.push_back(d);
        const double below = level + 0.5 - local.z;
        if (below > 0) out.rim.push_back({cell, static_cast<float>(irradiance * below), glm::vec3(ray.direction)});
    }

    /// How far the rays around uv have spread at height z: |d(landing)/d(uv)|, signed.
    double spreadAt(const glm::dvec2& uv, double z) const {
        const auto landing = [&](double du, double dv) {
            return Refractor::landing(rays_.at(uv + glm::dvec2(du, dv)), z);
        };
        const glm::dvec2 a = (landing(step_, 0) - landing(-step_, 0)) / (2 * step_),
                         b = (landing(0, step_) - landing(0, -step_)) / (2 * step_);
        return a.x * b.y - a.y * b.x;
    }

    const WaveCells& cells_;
    const PulseInWater& water_;
    const WaveRelease& surface_;
    const Refractor rays_;
    const glm::dvec3 direction_;
    const double slowness_;  ///< above the surface, over that below
    const double step_;      ///< [m], of the differences
};

/// Joins the rows in order, so that sums do not depend on threads.
void joinRows(const std::vector<ReleasedRow>& rows, const WaveCells& cells, WaveRelease& release) {
    double folded = 0;
    for (const ReleasedRow& r : rows) {
        release.source.driven.insert(release.source.driven.end(), r.driven.begin(), r.driven.end());
        release.rim.insert(release.rim.end(), r.rim.begin(), r.rim.end());
        release.launched += r.launched, release.reflected += r.reflected, release.path += r.path;
        folded += r.folded;
    }
    const double area = cells.grid.spacing.x * cells.grid.spacing.y;
    release.launched *= area, release.reflected *= area, release.path *= area;
    if (!release.source.driven.empty()) release.folded = folded / static_cast<double>(release.source.driven.size());
}

/// What is above the surface is held.
void holdAbove(const WaveCells& cells, WaveRelease& release) {
    const glm::ivec3 size = cells.size();
    std::vector<std::int32_t> held_of(static_cast<std::size_t>(cells.grid.count()), -1);
    for (int x = 0; x < size.x; ++x)
        for (int y = 0; y < size.y; ++y) {
            const int first = std::max(wetTop(release.level[columnIndex(size, x, y)]) + 1, 0);
            for (int z = first; z < size.z; ++z) {
                const glm::ivec3 local(x, y, z);
                const int block = blockOf(cells, local);
                if (!cells.grid.has(block)) continue;
                std::int32_t& number = held_of[static_cast<std::size_t>(block)];
                if (number < 0) {
                    number = static_cast<std::int32_t>(release.source.held.size());
                    release.source.held.push_back({block, {}});
                }
                const int offset = offsetOf(local);
                release.source.held[static_cast<std::size_t>(number)].cells[static_cast<std::size_t>(offset >> 6)] |=
                    std::uint64_t{1} << (offset & 63);
            }
        }
}

}  // namespace

void levelSurface(const WaveCells& cells, const Surface& surface, WaveRelease& release) {
    const glm::ivec3 size = cells.size(), low = cells.lowCell();
    release.level.assign(columnIndex(size, size.x, 0), 0.0f);
    const HeightField& field = *surface.height_field;
    const double tolerance = 1e-6 * std::min(cells.grid.spacing.x, cells.grid.spacing.y);
    parallelFor(size.x, [&](std::int64_t x) {
        for (int y = 0; y < size.y; ++y) {
            const glm::dvec2 place(cells.world(glm::dvec3(low) + glm::dvec3(double(x), y, 0)));
            glm::dvec2 uv = place;
            SurfacePoint p = field.at(uv);
            if (field.maxDisplacement() > 0)
                for (int i = 0; i < 40; ++i) {
                    const glm::dvec2 miss = place - glm::dvec2(p.position);
                    if (glm::dot(miss, miss) < tolerance * tolerance) break;
                    uv += miss;
                    p = field.at(uv);
                }
            release.level[columnIndex(size, static_cast<int>(x), y)] =
                static_cast<float>(cells.cell(glm::dvec3(place, p.position.z)).z - low.z);
        }
    });
    // Driven cells reach two above the column's own wet cells, and as high as the wet cells of columns within two.
    release.top.assign(release.level.size(), 0);
    const auto wrapped = [&](int i, int axis) {
        if (cells.grid.periodic[static_cast<std::size_t>(axis)]) return (i + size[axis]) % size[axis];
        return std::clamp(i, 0, size[axis] - 1);
    };
    parallelFor(size.x, [&](std::int64_t column) {
        const int x = static_cast<int>(column);
        for (int y = 0; y < size.y; ++y) {
            const auto wet = [&](int i, int j) { return wetTop(release.level[columnIndex(size, i, j)]); };
            int top = wet(x, y) + 2;
            for (int k = -2; k <= 2; ++k) top = std::max({top, wet(wrapped(x + k, 0), y), wet(x, wrapped(y + k, 1))});
            release.top[columnIndex(size, x, y)] = std::clamp(top, -1, size.z - 1);
        }
    });
}

void releasePulse(const WaveCells& cells, const LitSurface& lit, const PulseInWater& water, WaveRelease& release) {
    const glm::ivec3 size = cells.size();
    release.source.pulse = water.pulse;
    const PulseRelease pulse(cells, lit, water, release);
    std::vector<ReleasedRow> rows(static_cast<std::size_t>(size.x));
    parallelFor(size.x, [&](std::int64_t x) {
        for (int y = 0; y < size.y; ++y) pulse.addColumn(static_cast<int>(x), y, rows[static_cast<std::size_t>(x)]);
    });
    joinRows(rows, cells, release);
    holdAbove(cells, release);
}

void releaseAtRest(const WaveCells& cells, WaveRelease& release) {
    const glm::ivec3 size = cells.size();
    for (int x = 0; x < size.x; ++x)
        for (int y = 0; y < size.y; ++y) {
            const float level = release.level[columnIndex(size, x, y)];
            // From the lowest to the highest corner of the surface over the column, so that the front has no holes.
            float least = level, most = level;
            for (const glm::ivec2 step : {glm::ivec2(1, 0), glm::ivec2(0, 1)}) {
                const glm::ivec2 other = glm::min(glm::ivec2(x, y) + step, glm::ivec2(size) - 1);
                const float beside = release.level[columnIndex(size, other.x, other.y)];
                least = std::min(least, 0.5f * (level + beside)), most = std::max(most, 0.5f * (level + beside));
            }
            for (int z = static_cast<int>(std::floor(least + 0.5f)); z <= static_cast<int>(std::floor(most + 0.5f));
                 ++z) {
                if (z < 0 || z >= size.z) continue;
                const glm::ivec3 local(x, y, z);
                const int block = blockOf(cells, local);
                if (cells.grid.has(block))
                    release.source.start.push_back({block, static_cast<std::uint16_t>(offsetOf(local)), 1.0f});
            }
        }
}

}  // namespace photic
