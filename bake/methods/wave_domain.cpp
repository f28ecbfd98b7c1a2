// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/wave_domain.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "bake/field/floor_div.h"
#include "bake/paths/launch_domain.h"
#include "bake/scene/index_volume.h"

namespace photic {
namespace {

constexpr int kBlock = kWaveSide;

/// Light and surface are the same after a step of the grid's width along an axis, and nothing ends them in between.
bool repeats(const Scene& scene, const LitSurface& lit, const GridFrame& frame, int axis, int cells) {
    const Surface& surface = lit.surface;
    if (axis == 2 || cells % kBlock != 0 || surface.outside == Outside::None) return false;
    if (std::fabs(lit.light.direction[axis]) > 1e-9) return false;
    if (scene.index && scene.index->steepest()[axis] > 0) return false;
    for (const Object& object : scene.objects) {
        const Plane* plane = std::get_if<Plane>(&object.shape);
        if (object.blocks() && (!plane || std::fabs(plane->normal[axis]) > 1e-9)) return false;
    }
    const glm::dvec3 low = frame.worldFromIndex(glm::dvec3(frame.min) - 0.5),
                     high = frame.worldFromIndex(glm::dvec3(frame.max) + 0.5);
    const HeightField& field = *surface.height_field;
    const double tolerance = 1e-7 * (high - low)[axis];
    constexpr int kSamples = 33;
    for (int i = 0; i < kSamples; ++i)
        for (int j = 0; j < kSamples; ++j) {
            glm::dvec2 uv(glm::mix(glm::dvec2(low), glm::dvec2(high), glm::dvec2(i, j) / double(kSamples - 1)));
            const SurfacePoint here = field.at(uv);
            glm::dvec2 step(0);
            step[axis] = (high - low)[axis];
            const SurfacePoint there = field.at(uv + step);
            if (std::fabs(here.position.z - there.position.z) > tolerance) return false;
            if (glm::distance(glm::normalize(here.normal), glm::normalize(there.normal)) > 1e-6) return false;
        }
    return true;
}

/// The box of cells that is asked for, less what lies further than two voxels behind planes that block.
void clipByPlanes(const Scene& scene, const WaveCells& cells, glm::ivec3& low, glm::ivec3& high) {
    const glm::dvec3 middle = cells.world(0.5 * glm::dvec3(low + high));
    for (const Object& object : scene.objects) {
        const Plane* plane = std::get_if<Plane>(&object.shape);
        if (!plane || !object.blocks()) continue;
        for (int a = 0; a < 3; ++a) {
            if (std::fabs(std::fabs(plane->normal[a]) - 1) > 1e-9) continue;
            const double at = cells.cell(plane->point)[a];
            const int past = 2 * cells.per_voxel;
            if (middle[a] > plane->point[a])
                low[a] = std::max(low[a], static_cast<int>(std::floor(at)) - past);
            else
                high[a] = std::min(high[a], static_cast<int>(std::ceil(at)) + past);
        }
    }
}

/// What light can come from beside the box, at the surface [cells].
struct SideReach {
    glm::dvec2 low{0}, high{0};  ///< beyond the box
    glm::dvec2 margin{0};        ///< of it: half a Fresnel zone, and how far an index that varies bends rays
};

/// Where light of the box can come from. Marks the axes along which light and surface repeat, and which need none.
SideReach reachSideways(const Scene& scene, const LitSurface& lit, const WaveDomainSettings& settings,
                        WaveCells& cells) {
    const glm::ivec3 low = cells.asked_low, high = cells.asked_high;
    SideReach reach;
    const double bottom_world = cells.world(glm::dvec3(low)).z;
    const double depth = std::max(lit.surface.height_field->maxZ() - bottom_world, 0.0);
    glm::dvec2 beside(0.5 * std::sqrt(settings.wavelength * depth));
    if (scene.index)  // a ray bends by |grad n| / n a metre
        beside +=
            depth * glm::min(0.5 * depth / scene.index->least() * glm::dvec2(scene.index->steepest()), glm::dvec2(1));
    reach.margin = beside / glm::dvec2(cells.grid.spacing);
    GridFrame left = cells.frame;  // the box that planes have left
    left.min = glm::ivec3(glm::floor(glm::dvec3(low) / double(cells.per_voxel)));
    left.max = glm::ivec3(glm::floor(glm::dvec3(high) / double(cells.per_voxel)));
    const LaunchDomain launch = launchDomain(scene, lit.surface, lit.light, left);
    for (int a = 0; a < 2; ++a) {
        const bool periodic = (high[a] - low[a] + 1) % kBlock == 0 && floorDiv(low[a], kBlock) * kBlock == low[a] &&
                              repeats(scene, lit, left, a, high[a] - low[a] + 1);
        cells.grid.periodic[static_cast<std::size_t>(a)] = periodic;
        if (periodic || settings.both_sides || launch.empty()) continue;
        reach.low[a] = std::max(0.0, low[a] - cells.cell({launch.min.x, launch.min.y, 0})[a]) + reach.margin[a];
        reach.high[a] = std::max(0.0, cells.cell({launch.max.x, launch.max.y, 0})[a] - high[a]) + reach.margin[a];
    }
    return reach;
}

/// Width of the absorbing layer [blocks].
int layerBlocks(const WaveDomainSettings& settings) {
    switch (settings.absorber) {
        case WaveAbsorber::Sponge:
            return (settings.sponge_cells + kBlock - 1) / kBlock;
        case WaveAbsorber::Pml:
            return 1;
        default:
            return 0;
    }
}

/// The blocks of the box, with the layer around; above, the driven cells.
/// @param surface_top  highest place of the surface [cells]
void layBlocks(const SideReach& reach, const WaveDomainSettings& settings, double surface_top, WaveCells& cells) {
    const int layer = layerBlocks(settings);
    glm::ivec3 low_block, high_block;
    for (int a = 0; a < 3; ++a) {
        const bool wraps = cells.grid.periodic[static_cast<std::size_t>(a)];
        const double before = a < 2 ? reach.low[a] : 0, after = a < 2 ? reach.high[a] : 0;
        low_block[a] =
            floorDiv(static_cast<int>(std::floor(cells.asked_low[a] - before)), kBlock) - (wraps ? 0 : layer);
        high_block[a] =
            floorDiv(static_cast<int>(std::ceil(cells.asked_high[a] + after)), kBlock) + (wraps ? 0 : layer);
    }
    if (!settings.both_sides) high_block.z = floorDiv(static_cast<int>(std::ceil(surface_top)) + 3, kBlock);
    high_block = glm::max(high_block, low_block);
    cells.low_block = low_block;
    cells.grid.blocks = high_block - low_block + 1;
}

/// The blocks that light on its way to the box passes, less the absorbing layer.
std::vector<std::uint8_t> blocksOnTheWay(const WaveCells& cells, const SideReach& reach,
                                         const WaveDomainSettings& settings, double surface_top) {
    std::vector<std::uint8_t> core(static_cast<std::size_t>(cells.grid.count()), 0);
    const glm::ivec3 origin = cells.lowCell(), low = cells.asked_low, high = cells.asked_high;
    for (int b = 0; b < cells.grid.count(); ++b) {
        const glm::ivec3 first = origin + cells.grid.place(b) * kBlock, last = first + (kBlock - 1);
        bool inside = last.z >= low.z;
        if (settings.absorber != WaveAbsorber::Pml) {  // the sponge lies along the sides of the box
            core[static_cast<std::size_t>(b)] = 1;
            continue;
        }
        const double up = std::clamp((last.z - low.z) / std::max(surface_top - low.z, 1.0), 0.0, 1.0);
        for (int a = 0; a < 2; ++a) {
            if (cells.grid.periodic[static_cast<std::size_t>(a)]) continue;
            const double spread_low = (reach.low[a] - reach.margin[a]) * up + reach.margin[a],
                         spread_high = (reach.high[a] - reach.margin[a]) * up + reach.margin[a];
            inside = inside && last[a] >= low[a] - spread_low && first[a] <= high[a] + spread_high;
        }
        core[static_cast<std::size_t>(b)] = inside;
    }
    return core;
}

/// Whether the block at `place` is of the core, or of the absorbing layer beside or below it.
bool nearCore(const WaveGrid& grid, const std::vector<std::uint8_t>& core, const glm::ivec3& place, int layer) {
    if (core[static_cast<std::size_t>(grid.index(place))] != 0) return true;
    for (int dx = -layer; dx <= layer; ++dx)
        for (int dy = -layer; dy <= layer; ++dy)
            for (int dz = 0; dz <= layer; ++dz) {
                const glm::ivec3 other = place + glm::ivec3(dx, dy, dz);
                if (glm::any(glm::lessThan(other, glm::ivec3(0))) ||
                    glm::any(glm::greaterThanEqual(other, grid.blocks)))
                    continue;
                if (core[static_cast<std::size_t>(grid.index(other))] != 0) return true;
            }
    return false;
}

/// Highest cell that is driven or wet in the columns of the block whose first cell is `first`.
int topOfBlock(const WaveCells& cells, const WaveRelease& release, const glm::ivec3& first) {
    int top = -1;
    const glm::ivec3 size = cells.size();
    for (int x = first.x; x < first.x + kBlock; ++x)
        for (int y = first.y; y < first.y + kBlock; ++y)
            top = std::max(top, release.top[static_cast<std::size_t>(x) * static_cast<std::size_t>(size.y) +
                                            static_cast<std::size_t>(y)]);
    return top;
}

}  // namespace

WaveCells waveCells(const Scene& scene, const LitSurface& lit, const GridFrame& frame,
                    const WaveDomainSettings& settings, WaveRelease& release) {
    WaveCells cells;
    cells.frame = frame, cells.per_voxel = settings.cells_per_voxel;
    const int r = cells.per_voxel;
    for (int a = 0; a < 3; ++a) cells.grid.spacing[a] = std::fabs(frame.worldFromIndex()[a][a]) / r;
    cells.asked_low = frame.min * r, cells.asked_high = (frame.max + 1) * r - 1;
    clipByPlanes(scene, cells, cells.asked_low, cells.asked_high);

    const double surface_top = cells.cell({0, 0, lit.surface.height_field->maxZ()}).z;
    const SideReach reach = reachSideways(scene, lit, settings, cells);
    layBlocks(reach, settings, surface_top, cells);
    levelSurface(cells, lit.surface, release);
    if (settings.both_sides) return cells;

    // Left out: blocks above the driven cells, and those that light on its way to the box does not pass.
    const std::vector<std::uint8_t> core = blocksOnTheWay(cells, reach, settings, surface_top);
    cells.grid.present.assign(core.size(), 0);
    for (int b = 0; b < cells.grid.count(); ++b) {
        const glm::ivec3 place = cells.grid.place(b);
        if (!nearCore(cells.grid, core, place, layerBlocks(settings))) continue;
        const glm::ivec3 first = place * kBlock;
        cells.grid.present[static_cast<std::size_t>(b)] = first.z <= topOfBlock(cells, release, first);
    }
    return cells;
}

}  // namespace photic
