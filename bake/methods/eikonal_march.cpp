// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/methods/eikonal_front.h"
#include "bake/methods/eikonal_grid.h"
#include "bake/methods/eikonal_index.h"
#include "bake/methods/eikonal_mercier.h"
#include "bake/methods/eikonal_slopes.h"
#include "bake/numerics/amplitude_transport.h"
#include "bake/numerics/wavefront_curvature.h"
#include "bake/optics/beer_lambert.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr double kSeedDepth = 3;  // [cells] along the ray: the second-order stencil sees two on every axis
constexpr int kStrip = 8;         // columns that are swept at each side, so that sheets of rays find each other

/// Seeds by foot points: beside the surface, and in the ghost columns at the sides.
class SurfaceSeeds {
public:
    SurfaceSeeds(const EikonalFront& front, EikonalGrid& grid) : front_(front), grid_(grid) {}

    /// Cells close below the surface, down to the layer that is returned, where the transport of density starts.
    /// @param shares  gets the irradiance of these layers in units of the sun's; empty when nobody asks
    int besideSurface(std::vector<double>& density, std::vector<float>& shares) {
        const EikonalGrid& g = grid_;
        const double* c = front_.table().coefficients();
        const double lowest =
            *std::min_element(c, c + std::ptrdiff_t(front_.table().countX()) * front_.table().countY());
        const double h = g.spacing;
        int last = g.size.z - 1;
        PointLayers points = layersFrom({0, 0}, {g.size.x, g.size.y});
        sweepFootPoints(front_.front(), points, [&](int k, const FootPointLayer& layer) {
            const int z = g.size.z - 1 - k;
            last = z;
            const bool final = g.centre({0, 0, z}).z < lowest - (kSeedDepth + 1) * h || z == 0;
            parallelFor(g.size.y, [&](std::int64_t j) {
                for (int i = 0; i < g.size.x; ++i) {
                    const glm::ivec3 cell(i, int(j), z);
                    const std::size_t at = layer.at(std::size_t(i), std::size_t(j));
                    if (layer.arrival[at] >= FootPointLayer::kAboveSurface)
                        grid_.freeze(cell, kUnreached);
                    else if (layer.distance[at] <= kSeedDepth * h)
                        grid_.freeze(cell, front_.index() ? arrivalThroughIndex(front_, g.centre(cell),
                                                                                {layer.foot_x[at], layer.foot_y[at]})
                                                          : layer.arrival[at]);
                }
            });
            density.resize(std::size_t(g.size.x) * std::size_t(g.size.y));
            if (!shares.empty()) fillShares(z, layer, density, shares);
            if (!final) return true;
            return false;
        });
        return last;
    }

    /// Ghost columns, all the way down, with their irradiances where `shares` asks for them.
    void atSides(std::vector<float>& shares) {
        const glm::ivec3 n = grid_.size;
        // A domain may be narrower than a strip, which is then the whole of it.
        const glm::ivec2 strip = glm::min(glm::ivec2(kStrip), glm::ivec2(n));
        for (const auto& [low, count] : {std::pair{glm::ivec2(0, 0), glm::ivec2(strip.x, n.y)},
                                         {glm::ivec2(n.x - strip.x, 0), glm::ivec2(strip.x, n.y)},
                                         {glm::ivec2(0, 0), glm::ivec2(n.x, strip.y)},
                                         {glm::ivec2(0, n.y - strip.y), glm::ivec2(n.x, strip.y)}}) {
            sweepFootPoints(front_.front(), layersFrom(low, count),
                            [&, low = low, count = count](int k, const FootPointLayer& layer) {
                                for (int j = 0; j < count.y; ++j)
                                    for (int i = 0; i < count.x; ++i) {
                                        const glm::ivec3 cell(low.x + i, low.y + j, n.z - 1 - k);
                                        const double t = layer.arrival[layer.at(std::size_t(i), std::size_t(j))];
                                        if (!grid_.isGhost(cell) || t >= FootPointLayer::kAboveSurface) continue;
                                        grid_.freeze(cell, t);
                                        if (!shares.empty())
                                            shares[grid_.flat(cell + grid_.shift)] =
                                                shareAt(layer, layer.at(std::size_t(i), std::size_t(j)), cell);
                                    }
                                return true;
                            });
        }
    }

private:
    void fillShares(int z, const FootPointLayer& layer, std::vector<double>& density,
                    std::vector<float>& shares) const {
        const EikonalGrid& g = grid_;
        parallelFor(g.size.y, [&](std::int64_t j) {
            for (int i = 0; i < g.size.x; ++i) {
                const std::size_t at = layer.at(std::size_t(i), std::size_t(j));
                const glm::ivec3 cell(i, int(j), z);
                if (layer.arrival[at] >= FootPointLayer::kAboveSurface) continue;
                const float share = shareAt(layer, at, cell);
                shares[g.flat(cell + g.shift)] = share;
                density[std::size_t(j) * std::size_t(g.size.x) + std::size_t(i)] =
                    double(share) * (layer.foot_z[at] - g.centre(cell).z) / layer.distance[at];
            }
        });
    }
    /// Irradiance of the first arrival in units of the sun's.
    float shareAt(const FootPointLayer& layer, std::size_t at, const glm::ivec3& cell) const {
        const glm::dvec3 foot(layer.foot_x[at], layer.foot_y[at], layer.foot_z[at]);
        const glm::dvec3 w = (grid_.centre(cell) - foot) / layer.distance[at];
        return static_cast<float>(front_.entering(foot, layer.slope_x[at], layer.slope_y[at], w) /
                                  std::max(layer.spread[at], 1e-3));
    }

    PointLayers layersFrom(glm::ivec2 low, glm::ivec2 count) const {
        PointLayers p;
        p.origin = grid_.centre({low, grid_.size.z - 1});
        p.step_x = p.step_y = grid_.spacing, p.step_z = {0, 0, -grid_.spacing};
        p.count_x = count.x, p.count_y = count.y, p.count_z = grid_.size.z;
        return p;
    }

    const EikonalFront& front_;
    EikonalGrid& grid_;
};

/// Carries the density of the first arrivals' power down layer by layer from `first`, and fills the irradiances below.
void carryDensity(const EikonalGrid& g, int first, std::vector<double> density, std::vector<float>& shares,
                  Monitor& monitor) {
    const auto count = std::size_t(g.size.x) * std::size_t(g.size.y);
    std::vector<double> slope_x[2], slope_y[2], down(count);
    for (int s = 0; s < 2; ++s) slope_x[s].resize(count), slope_y[s].resize(count);
    RaySlopes rays(g);
    const auto slopes = [&](int z, int into) { rays.layer(z, slope_x[into], slope_y[into], down); };
    const auto keep = [&](int z) {
        parallelFor(g.size.y, [&](std::int64_t j) {
            for (int i = 0; i < g.size.x; ++i) {
                const std::size_t c = std::size_t(j) * std::size_t(g.size.x) + std::size_t(i),
                                  at = std::size_t(z) * count + c;
                // What comes in from the sides is known.
                if (g.isGhost({i, int(j), z}))
                    density[c] = double(shares[at]) * down[c];
                else
                    shares[at] = static_cast<float>(std::max(density[c], 0.0) / down[c]);
            }
        });
    };
    AmplitudeTransport transport(g.size.x, g.size.y);
    slopes(first, 0);
    for (int z = first - 1; z >= 0; --z) {
        monitor.checkCancelled();
        const int from = (first - 1 - z) % 2;
        slopes(z, 1 - from);
        transport.advance(density, slope_x[from], slope_y[from], slope_x[1 - from], slope_y[1 - from]);
        keep(z);
    }
}

/// Writes what was marched into the fields, block by block.
class MarchedWriter {
public:
    MarchedWriter(const EikonalBake& bake, const EikonalGrid& grid, const std::vector<float>& shares,
                  EikonalFields& fields)
        : bake_(bake),
          grid_(grid),
          shares_(shares),
          fields_(fields),
          needed_(fields.light.needed()),
          sun_(bake.front.light().irradiance),
          extinction_(bake.scene.medium.extinction()),
          level_(bake.front.surface().center.z),
          channels_(fields.light.channels().irradiance),
          curvature_sign_(bake.options.preset == EikonalPreset::Mercier ? -1.0f : 1.0f) {}

    void write(int block, const FrontBlock& found) {
        const EikonalGrid& g = grid_;
        const glm::ivec3 origin = g.low + g.blocks.origin(block);
        const int slot = needed_.slotOf(glm::clamp(origin, needed_.frame().min, needed_.frame().max));
        if (slot < 0 || needed_.leafOrigin(slot) != origin) return;
        float *light = nullptr, *caustic = nullptr, *arrival = nullptr;
        for (int c = 0; c < BlockGrid::kCells; ++c) {
            const glm::ivec3 in(c & 7, c >> 3 & 7, c >> 6), cell = g.blocks.origin(block) + in;
            const int offset = NeededVoxels::offsetInLeaf(origin + in);
            const double t = g.arrival[std::size_t(block) * BlockGrid::kCells + std::size_t(c)];
            if (!NeededVoxels::maskBit(needed_.mask(slot), offset) || !(t < kUnreached)) continue;
            if (!light) {
                light = fields_.light.makeDense(slot);
                if (fields_.caustic) caustic = fields_.caustic->makeDense(slot);
                if (fields_.arrival) arrival = fields_.arrival->makeDense(slot);
            }
            if (caustic) caustic[offset] = static_cast<float>(curvature_sign_ * found.curvature[c]);
            if (arrival) arrival[offset] = static_cast<float>(t);
            writeLight(cell, {found.direction[0][c], found.direction[1][c], found.direction[2][c]}, light + offset);
        }
    }

private:
    /// @param w    direction of travel
    /// @param out  the cell's first channel
    void writeLight(const glm::ivec3& cell, const glm::dvec3& w, float* out) const {
        const double share = shares_.empty() ? 1.0 : double(shares_[grid_.flat(cell)]);
        const double path = std::max(0.0, (level_ - grid_.centre(cell).z) / std::max(-w.z, 0.1));
        // Attenuation is the mean along the ray through the voxel's layer, not the centre's.
        const double half = 0.5 * needed_.frame().worldFromIndex()[2].z / std::max(-w.z, 0.1);
        const double start = std::max(0.0, path - half), length = path + half - start;
        double mean = 0;
        for (int k = 0; k < channels_; ++k) {
            const double e = share * sun_[k] * meanTransmittance(extinction_[k], start, length);
            out[k * LightField::kLeafVoxels] = static_cast<float>(e);
            mean += e / channels_;
        }
        for (int a = 0; a < 3; ++a) out[(channels_ + a) * LightField::kLeafVoxels] = static_cast<float>(mean * w[a]);
    }

    const EikonalBake& bake_;
    const EikonalGrid& grid_;
    const std::vector<float>& shares_;
    EikonalFields& fields_;
    const NeededVoxels& needed_;
    const glm::dvec3 sun_, extinction_;
    const double level_;  ///< of the surface [m]
    const int channels_;
    const float curvature_sign_;
};

EikonalProblem problemOf(const EikonalBake& bake, const EikonalGrid& g) {
    EikonalProblem problem;
    problem.grid = &g.blocks, problem.spacing = g.spacing, problem.slowness = bake.front.slowness(),
    problem.fixed = &g.fixed, problem.slownesses = g.slowness;
    const bool first = bake.options.preset == EikonalPreset::Mercier || bake.options.order == 1;
    problem.order = first ? MarchingOrder::First : MarchingOrder::Second;
    return problem;
}

/// Marches the front through the grid.
void march(const EikonalProblem& problem, const std::vector<std::uint8_t>& wanted, EikonalGrid& g, BakeReport& report,
           Monitor& monitor) {
    BlockMarchingOptions marching;
    marching.needed_blocks = wanted;
    marching.progress = [&](double part) {
        monitor.checkCancelled();
        monitor.progress("marching", part);
    };
    const BlockMarchingReport marched = marchBlocks(problem, marching, g.arrival);
    if (!marched.converged) monitor.warn("marching met its limit of rounds: some arrivals are rough");
    if (marched.stopped_early)
        report.skipped.emplace_back("blocks past the last needed voxel were not marched to the end");
}

}  // namespace

void bakeByMarching(const EikonalBake& bake, EikonalFields& fields, BakeReport& report) {
    const NeededVoxels& needed = fields.light.needed();
    const EikonalFront& front = bake.front;
    Monitor& monitor = bake.monitor;
    const bool mercier = bake.options.preset == EikonalPreset::Mercier;
    EikonalGrid g(needed, front, bake.scene.file);
    std::vector<double> density;
    std::vector<float> shares;
    if (bake.scene.bake.grids.irradiance && !mercier)
        shares.assign(std::size_t(g.size.x) * std::size_t(g.size.y) * std::size_t(g.size.z), 1.0f);
    int first = g.size.z - 1;
    monitor.progress("seeds", 0);
    if (mercier) {
        seedByVertices(front, bake.options.vertex_spacing, g);
        costsAtSides(front, g);
    } else {
        SurfaceSeeds seeds(front, g);
        first = seeds.besideSurface(density, shares);
        if (!front.index()) seeds.atSides(shares);
    }
    monitor.progress("marching", 0);
    const EikonalProblem problem = problemOf(bake, g);
    march(problem, g.neededBlocks(needed), g, report, monitor);
    fields.solver_bytes = double(g.bytes()) + double(shares.size() * sizeof(float));

    if (!shares.empty()) carryDensity(g, first, density, shares, monitor);
    MarchedWriter writer(bake, g, shares, fields);
    wavefrontCurvature(problem, g.arrival, [&](int block, const FrontBlock& found) { writer.write(block, found); });
}

}  // namespace photic
