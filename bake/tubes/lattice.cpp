// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "bake/report/error.h"
#include "bake/scene/scattered_points.h"
#include "bake/scene/spline_field.h"

namespace photic {
namespace {

// What light does over steps of `step` [m] at some scattered points of the surface.
struct Probes {
    std::vector<double> bends;  ///< second differences of where it lands [voxels]
    double fading = 0;          ///< most by which neighbours fade apart
};

Probes probed(const PathTracer& tracer, const LaunchDomain& domain, double step) {
    constexpr int kProbes = 256;
    const PathComparison compare(tracer);
    Probes probes;
    for (int i = 0; i < kProbes; ++i) {
        const glm::dvec2 uv = domain.min + scatteredPoint(i) * (domain.max - domain.min);
        const auto path = [&](double du, double dv) {
            return tracer.trace({{uv.x + du, uv.y + dv, 0}, glm::dvec3(0)}, {0, 0, 1});
        };
        const Path middle = path(0, 0);
        if (middle.outcome != PathOutcome::Lit) continue;
        double most = 0;
        for (const glm::dvec2 s : {glm::dvec2(step, 0), glm::dvec2(0, step), glm::dvec2(step, step)}) {
            const Path a = path(-s.x, -s.y), b = path(s.x, s.y);
            if (!compare.canShareTube(a, b) || !compare.canShareTube(a, middle)) continue;
            most = std::max(most, compare.bend(a, middle, b));
            probes.fading = std::max(probes.fading, compare.fadesApart(a, middle));
        }
        probes.bends.push_back(most);
    }
    return probes;
}

// Cells [voxels] that cost least. A ray of the lattice costs 1; where cells bend more than the tolerance a block of
// them is looked at edge by edge, at the price of some ten rays a ray, and divided until none does. Bend grows with the
// square of the cell.
double cheapestSpacing(const std::vector<double>& bends, double tolerance) {
    constexpr double kLeast = 1.0 / 16, kMost = 32, kDear = 10;
    // A block has 64 cells, and bends as its worst.
    constexpr double kWorstOfBlock = 2;
    double best = kMost, least = std::numeric_limits<double>::infinity();
    for (double cell = kMost; cell >= kLeast; cell /= std::sqrt(std::sqrt(2.0))) {
        double refined = 0;
        for (const double bend : bends) {
            const double excess = kWorstOfBlock * bend * cell * cell / tolerance;
            if (excess > 1) refined += excess;
        }
        const double cost =
            (1 + kDear * refined / static_cast<double>(std::max<std::size_t>(bends.size(), 1))) / (cell * cell);
        if (cost < least) best = cell, least = cost;
    }
    return best;
}

constexpr int kBlockCells = 8;  // a side of what a launch divides a lattice into

// Whether a lattice is to stay where it is from one frame to the next.
bool staysInPlace(const PathTracer& tracer, const LaunchOptions& options) {
    const Surface& surface = tracer.surface();
    return isBoundedSpline(*surface.height_field) && surface.outside != Outside::None && options.cells == 0 &&
           !bendsNowhere(tracer);
}

// The grid's box from above.
struct BoxFromAbove {
    glm::dvec2 low{1e300}, high{-1e300};
    explicit BoxFromAbove(const GridFrame& frame) {
        for (unsigned c = 0; c < 8; ++c) {
            glm::dvec3 index;
            for (int a = 0; a < 3; ++a) index[a] = c >> a & 1 ? frame.max[a] + 0.5 : frame.min[a] - 0.5;
            const glm::dvec2 corner(frame.worldFromIndex(index));
            low = glm::min(low, corner), high = glm::max(high, corner);
        }
    }
    // What a lattice is probed in, which is to change seldom: out to eighths of the box.
    LaunchDomain around(const LaunchDomain& domain) const {
        LaunchDomain out = domain;
        const glm::dvec2 part = 0.125 * (high - low);
        out.min = low - part * glm::ceil((low - domain.min) / part);
        out.max = high + part * glm::ceil((domain.max - high) / part);
        return out;
    }
};

// A lattice of cells of at most `cell` [m] by whole blocks. Cells and the first corner have so few bits that the places
// of all corners are exact in double precision, whichever block a row begins at.
Lattice latticeInPlace(const LaunchDomain& domain, double cell, const BoxFromAbove& box) {
    constexpr int kBits = 12;
    int exponent = 0;
    const double share = std::frexp(cell, &exponent), unit = std::ldexp(1.0, exponent - kBits),
                 step = std::floor(std::ldexp(share, kBits)) * unit, block = kBlockCells * step;
    const glm::dvec2 anchor = glm::floor(box.low / unit) * unit, first = glm::floor((domain.min - anchor) / block),
                     last = glm::ceil((domain.max - anchor) / block), count = glm::max(last - first, glm::dvec2(1));
    constexpr double kMost = 1e6;
    Lattice lattice;
    lattice.origin = anchor + first * block, lattice.step = glm::dvec2(step), lattice.on_raster = true;
    lattice.columns = static_cast<int>(std::min(kBlockCells * count.x, kMost));
    lattice.rows = static_cast<int>(std::min(kBlockCells * count.y, kMost));
    return lattice;
}

glm::dvec2 wantedCells(const PathTracer& tracer, const LaunchDomain& domain, const LaunchOptions& options) {
    const HeightField& surface = *tracer.surface().height_field;
    const GridFrame& frame = tracer.optics().frame();
    const glm::dvec2 extent = domain.max - domain.min;
    const double voxel = std::min(glm::length(frame.worldFromIndex()[0]), glm::length(frame.worldFromIndex()[1]));
    if (options.cells > 0) return glm::dvec2(options.cells);
    if (options.spacing > 0) return extent / (options.spacing * voxel);
    if (bendsNowhere(tracer)) return glm::dvec2(1);
    // Bends are probed over steps that the surface is smooth over.
    const double step = std::min(voxel, 0.5 * surface.featureSize()), in_voxels = step / voxel;
    Probes probes = probed(tracer, staysInPlace(tracer, options) ? BoxFromAbove(frame).around(domain) : domain, step);
    for (double& bend : probes.bends) bend /= in_voxels * in_voxels;
    const double bending = cheapestSpacing(probes.bends, options.refine.tolerance),
                 fading =
                     std::max(1.0, kFading * options.refine.tolerance * in_voxels / std::max(probes.fading, 1e-30));
    return extent / std::min(std::min(bending, fading) * voxel, surface.featureSize());
}

}  // namespace

bool bendsNowhere(const PathTracer& tracer) {
    return tracer.emission().parallel() && !std::isfinite(tracer.surface().height_field->featureSize());
}

Lattice layLattice(const PathTracer& tracer, const LaunchDomain& domain, const LaunchOptions& options) {
    const glm::dvec2 extent = domain.max - domain.min, cells = wantedCells(tracer, domain, options);
    // Far beyond any useful mesh: a surface that towers over the domain, or a spacing of nothing.
    constexpr double kMostCells = 1e10;
    if (!(cells.x * cells.y <= kMostCells))
        throw Error(ErrorCode::Input,
                    fmt::format("surface '{}' would be cut into {:.3g} x {:.3g} cells, {:.3g} m x {:.3g} m of it can "
                                "light the domain; more than {:.0e} in all are refused: use a lower surface "
                                "(amplitude, height, scale), a larger spacing or larger voxels",
                                tracer.surface().name, cells.x, cells.y, extent.x, extent.y, kMostCells));
    if (staysInPlace(tracer, options))
        return latticeInPlace(domain, extent.x / cells.x, BoxFromAbove(tracer.optics().frame()));
    Lattice lattice;
    lattice.origin = domain.min;
    lattice.columns = static_cast<int>(std::clamp(std::ceil(cells.x - 1e-9), 1.0, 1e6));
    lattice.rows = static_cast<int>(std::clamp(std::ceil(cells.y - 1e-9), 1.0, 1e6));
    lattice.step = extent / glm::dvec2(lattice.columns, lattice.rows);
    return lattice;
}

Lattice finerOf(const Lattice& a, const Lattice& b) {
    if (a.on_raster) return a.step.x <= b.step.x ? a : b;
    Lattice finer = a;
    finer.columns = std::max(a.columns, b.columns), finer.rows = std::max(a.rows, b.rows);
    finer.step = a.step * glm::dvec2(a.columns, a.rows) / glm::dvec2(finer.columns, finer.rows);
    return finer;
}

std::vector<Lattice> someBlocks(const Lattice& lattice, int count) {
    constexpr int kCells = kBlockCells, kFew = 32, kPart = 10;  // blocks; of them all
    const int columns = (lattice.columns + kCells - 1) / kCells, rows = (lattice.rows + kCells - 1) / kCells;
    const std::int64_t all = std::int64_t{columns} * rows;
    if (all <= kFew) return {lattice};
    count = static_cast<int>(std::clamp<std::int64_t>(all / kPart, std::min(count, kFew), count));
    std::vector<Lattice> blocks;
    for (int i = 0; i < count; ++i) {
        const glm::ivec2 first = kCells * glm::ivec2(scatteredPoint(i) * glm::dvec2(columns, rows));
        Lattice block = lattice;
        block.origin += block.step * glm::dvec2(first);
        block.columns = std::min(kCells, lattice.columns - first.x);
        block.rows = std::min(kCells, lattice.rows - first.y);
        blocks.push_back(block);
    }
    return blocks;
}

}  // namespace photic
