// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/solids.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>
#include <utility>

#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr double kMostVoxels = 268435456.0;  // 2^28: 1 GiB of samples
constexpr int kColumns = 4;                  // a voxel's side
constexpr int kTurnSteps = 256;              // a chord is 8e-5 of the radius off

/// Where a vertical line goes through a mesh, and into it or out of it.
struct Crossing {
    double z;
    int into;
};

/// The vertical lines of one row of voxels, four by four a voxel.
class RowOfColumns {
public:
    RowOfColumns(const SolidVolume& volume, int row) : volume_(volume), row_(row) {
        lines_.resize(static_cast<std::size_t>(volume.size.x) * kColumns * kColumns);
    }

    void add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
        // In columns: line (i, j) stands at (i, j).
        const glm::dvec2 p = inColumns(a), q = inColumns(b), r = inColumns(c);
        const double area = (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
        if (area == 0) return;
        const int low = std::max(0, static_cast<int>(std::ceil(std::min({p.y, q.y, r.y})))),
                  high = std::min(kColumns - 1, static_cast<int>(std::floor(std::max({p.y, q.y, r.y}))));
        const int first = std::max(0, static_cast<int>(std::ceil(std::min({p.x, q.x, r.x})))),
                  last =
                      std::min(volume_.size.x * kColumns - 1, static_cast<int>(std::floor(std::max({p.x, q.x, r.x}))));
        const auto side = [](const glm::dvec2& from, const glm::dvec2& to, const glm::dvec2& at) {
            return (to.x - from.x) * (at.y - from.y) - (to.y - from.y) * (at.x - from.x);
        };
        for (int j = low; j <= high; ++j)
            for (int i = first; i <= last; ++i) {
                const glm::dvec2 at(i, j);
                const double wa = side(q, r, at) / area, wb = side(r, p, at) / area, wc = 1 - wa - wb;
                if (wa < 0 || wb < 0 || wc < 0) continue;
                line(i, j).push_back({wa * a.z + wb * b.z + wc * c.z, area > 0 ? -1 : 1});
            }
    }

    /// Each voxel's share of the body in this row, by share(x, z, part).
    template <class Share>
    void shares(const Share& share) {
        for (int i = 0; i < volume_.size.x * kColumns; ++i)
            for (int j = 0; j < kColumns; ++j) {
                std::vector<Crossing>& crossings = line(i, j);
                std::sort(crossings.begin(), crossings.end(),
                          [](const Crossing& a, const Crossing& b) { return a.z < b.z; });
                int depth = 0;
                for (const Crossing& crossing : crossings) depth += crossing.into;
                if (depth != 0) continue;  // it goes exactly along an edge
                for (std::size_t k = 0; k < crossings.size(); ++k) {
                    depth += crossings[k].into;
                    if (depth != 0 && k + 1 < crossings.size())
                        lay(i / kColumns, crossings[k].z, crossings[k + 1].z, share);
                }
            }
    }

private:
    glm::dvec2 inColumns(const glm::dvec3& p) const {
        // A little beside what meshes are likely to have edges at.
        constexpr double kAsideX = 0.5 + 1.3e-4, kAsideY = 0.5 + 2.1e-4;
        return {(p.x / volume_.voxel_size - volume_.min.x) * kColumns - kAsideX,
                (p.y / volume_.voxel_size - row_ - volume_.min.y) * kColumns - kAsideY};
    }
    std::vector<Crossing>& line(int i, int j) { return lines_[static_cast<std::size_t>(i * kColumns + j)]; }
    template <class Share>
    void lay(int x, double z_low, double z_high, const Share& share) const {
        const double low = z_low / volume_.voxel_size - volume_.min.z,
                     high = z_high / volume_.voxel_size - volume_.min.z;
        const int last = std::min(volume_.size.z - 1, static_cast<int>(std::floor(high)));
        for (int z = std::max(0, static_cast<int>(std::floor(low))); z <= last; ++z) {
            const double part = std::min(high, z + 1.0) - std::max(low, double(z));
            if (part > 0) share(x, z, part / (kColumns * kColumns));
        }
    }

    const SolidVolume& volume_;
    int row_;
    std::vector<std::vector<Crossing>> lines_;
};

/// Calls share(x, y, z, part) for each voxel that a mesh fills in part, some of them several times; rows in parallel.
void cover(const TriangleMesh& mesh, const SolidVolume& volume, Monitor& monitor,
           const std::function<void(int, int, int, double)>& share) {
    std::vector<std::vector<std::uint32_t>> rows(static_cast<std::size_t>(volume.size.y));
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        double low = 1e300, high = -1e300;
        for (const std::uint32_t v : mesh.triangles[t])
            low = std::min(low, mesh.positions[v].y), high = std::max(high, mesh.positions[v].y);
        const int first = static_cast<int>(std::floor(low / volume.voxel_size)) - volume.min.y,
                  last = static_cast<int>(std::floor(high / volume.voxel_size)) - volume.min.y;
        for (int y = std::max(first, 0); y <= std::min(last, volume.size.y - 1); ++y)
            rows[static_cast<std::size_t>(y)].push_back(t);
    }
    parallelFor(volume.size.y, [&](std::int64_t row) {
        monitor.checkCancelled();
        const int y = static_cast<int>(row);
        RowOfColumns columns(volume, y);
        for (const std::uint32_t t : rows[static_cast<std::size_t>(row)]) {
            const auto& v = mesh.triangles[t];
            columns.add(mesh.positions[v[0]], mesh.positions[v[1]], mesh.positions[v[2]]);
        }
        columns.shares([&](int x, int z, double part) { share(x, y, z, part); });
    });
}

/// The integral of a Gaussian over voxels, from the middle one on.
std::vector<double> gaussian(double sigma) {
    const int reach = static_cast<int>(std::ceil(4 * sigma));
    std::vector<double> weights;
    double sum = 0;
    for (int i = 0; i <= reach; ++i) {
        const auto below = [&](double x) { return 0.5 * std::erf(x / (sigma * std::numbers::sqrt2)); };
        weights.push_back(below(i + 0.5) - below(i - 0.5));
        sum += (i == 0 ? 1 : 2) * weights.back();
    }
    for (double& weight : weights) weight /= sum;
    return weights;
}

}  // namespace

glm::dvec3 Solid::absorptionAt(const glm::dvec3& world) const {
    if (!pattern.varies()) return absorption;
    return pattern.at(glm::transpose(placement.rotation) * (world - placement.position) / placement.scale, absorption);
}

TriangleMesh revolve(std::vector<glm::dvec2> profile) {
    if (profile.front().x > 0) profile.insert(profile.begin(), {0, profile.front().y});
    if (profile.back().x > 0) profile.emplace_back(0, profile.back().y);
    // Anticlockwise, with the axis to the left, has its outside outside.
    double area = 0;
    for (std::size_t i = 0; i < profile.size(); ++i) {
        const glm::dvec2 &a = profile[i], &b = profile[(i + 1) % profile.size()];
        area += a.x * b.y - a.y * b.x;
    }
    if (area < 0) std::reverse(profile.begin(), profile.end());
    TriangleMesh mesh;
    std::vector<std::uint32_t> ring;
    for (const glm::dvec2& p : profile) {
        ring.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
        for (int i = 0; i < (p.x > 0 ? kTurnSteps : 1); ++i) {
            const double angle = 2 * std::numbers::pi * i / kTurnSteps;
            mesh.positions.emplace_back(p.x * std::cos(angle), p.x * std::sin(angle), p.y);
        }
    }
    for (std::size_t k = 0; k + 1 < profile.size(); ++k)
        for (std::uint32_t i = 0; i < kTurnSteps; ++i) {
            const std::uint32_t n = (i + 1) % kTurnSteps;
            const bool low = profile[k].x > 0, high = profile[k + 1].x > 0;
            const std::uint32_t a = ring[k] + (low ? i : 0), b = ring[k] + (low ? n : 0),
                                c = ring[k + 1] + (high ? n : 0), d = ring[k + 1] + (high ? i : 0);
            if (low) mesh.triangles.push_back({a, b, c});
            if (high) mesh.triangles.push_back({a, c, d});
        }
    return mesh;
}

SolidVolume voxelise(const std::vector<Solid>& solids, double voxel_size, int margin, Monitor& monitor) {
    glm::dvec3 low(1e300), high(-1e300);
    for (const Solid& solid : solids)
        for (const glm::dvec3& p : solid.mesh.positions) low = glm::min(low, p), high = glm::max(high, p);
    const glm::dvec3 count = glm::ceil(high / voxel_size) - glm::floor(low / voxel_size) + 2.0 * margin;
    if (!(count.x * count.y * count.z <= kMostVoxels))
        throw Error(ErrorCode::Input,
                    fmt::format("the bodies would take {:.0f} x {:.0f} x {:.0f} voxels of {} m, more than 2^28; use "
                                "larger voxels",
                                count.x, count.y, count.z, voxel_size));
    SolidVolume volume;
    volume.voxel_size = voxel_size;
    volume.min = glm::ivec3(glm::floor(low / voxel_size)) - margin, volume.size = glm::ivec3(count);
    const std::size_t voxels = volume.flat(0, 0, volume.size.z);
    volume.index.assign(voxels, 1.0f), volume.inside.assign(voxels, 0);
    if (std::any_of(solids.begin(), solids.end(), [](const Solid& s) { return s.absorbs(); }))
        volume.absorption.assign(3 * voxels, 0.0f);
    if (std::any_of(solids.begin(), solids.end(), [](const Solid& s) { return s.albedo != glm::dvec3(0); }))
        volume.albedo.assign(3 * voxels, 0.0f);
    std::vector<float> part(voxels);
    const auto columns = static_cast<std::size_t>(volume.size.x), rows = static_cast<std::size_t>(volume.size.y);
    for (std::size_t s = 0; s < solids.size(); ++s) {
        const Solid& solid = solids[s];
        monitor.progress("voxelise", static_cast<double>(s) / static_cast<double>(solids.size()));
        std::fill(part.begin(), part.end(), 0.0f);
        cover(solid.mesh, volume, monitor,
              [&](int x, int y, int z, double share) { part[volume.flat(x, y, z)] += static_cast<float>(share); });
        for (std::size_t i = 0; i < voxels; ++i) {
            if (part[i] <= 0) continue;
            const float share = std::min(part[i], 1.0f);
            volume.inside[i] = 1;
            const glm::ivec3 voxel =
                volume.min + glm::ivec3(static_cast<int>(i % columns), static_cast<int>(i / columns % rows),
                                        static_cast<int>(i / (columns * rows)));
            const glm::dvec3 absorption = solid.absorptionAt((glm::dvec3(voxel) + 0.5) * voxel_size);
            volume.index[i] += share * (static_cast<float>(solid.ior) - volume.index[i]);
            for (std::size_t c = 0; c < 3 && !volume.absorption.empty(); ++c) {
                float& there = volume.absorption[3 * i + c];
                there += share * (static_cast<float>(absorption[static_cast<int>(c)]) - there);
            }
            // Paint is not thinner where a face cuts a voxel.
            for (std::size_t c = 0; c < 3 && !volume.albedo.empty(); ++c) {
                const auto own = static_cast<float>(solid.albedo[static_cast<int>(c)]);
                volume.albedo[3 * i + c] = share > 0.5f ? own : std::max(own, volume.albedo[3 * i + c]);
            }
        }
    }
    monitor.progress("voxelise", 1);
    return volume;
}

SmoothingEffect smooth(SolidVolume& volume, double sigma) {
    SmoothingEffect effect;
    if (!(sigma > 0)) return effect;
    const std::vector<double> weights = gaussian(sigma);
    const std::vector<float> before = volume.index;
    const int reach = static_cast<int>(weights.size()) - 1;
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3, count = volume.size[axis];
        parallelFor(volume.size[v], [&](std::int64_t row) {
            std::vector<double> line(static_cast<std::size_t>(count));
            glm::ivec3 at;
            at[v] = static_cast<int>(row);
            for (at[u] = 0; at[u] < volume.size[u]; ++at[u]) {
                for (at[axis] = 0; at[axis] < count; ++at[axis])
                    line[static_cast<std::size_t>(at[axis])] = double(volume.index[volume.flat(at.x, at.y, at.z)]);
                for (at[axis] = 0; at[axis] < count; ++at[axis]) {
                    double sum = 0;
                    for (int i = -reach; i <= reach; ++i) {
                        const int from = at[axis] + i;
                        sum += weights[static_cast<std::size_t>(std::abs(i))] *
                               (from >= 0 && from < count ? line[static_cast<std::size_t>(from)] : 1.0);
                    }
                    volume.index[volume.flat(at.x, at.y, at.z)] = static_cast<float>(sum);
                }
            }
        });
    }
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
        const double change = std::fabs(double(volume.index[i]) - double(before[i]));
        effect.largest = std::max(effect.largest, change);
        if (change > 1e-4) sum += change, ++count;
    }
    effect.mean = count > 0 ? sum / count : 0;
    constexpr double kTenToNinety = 2.5631;  // of a normal distribution's deviation
    effect.face_voxels = kTenToNinety * sigma;
    return effect;
}

}  // namespace photic
