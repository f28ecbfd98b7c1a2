// SPDX-License-Identifier: Apache-2.0
#include "bake/file/slice_atlas.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "bake/file/output_set.h"
#include "bake/file/sidecar.h"
#include "bake/file/voxel_encoding.h"
#include "bake/image/image.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"
#include "runtime/format/light_volume_format.h"

namespace photic {
namespace {

struct Layout {
    int columns, rows;
};

// Slices of w x h texels, n of them, as near to a square as they go; nothing when they don't fit.
std::optional<Layout> layoutFor(std::int64_t w, std::int64_t h, std::int64_t n) {
    const std::int64_t limit = format::kAtlasLargestSide;
    if (w > limit || h > limit) return {};
    std::optional<Layout> best;
    std::int64_t best_side = std::numeric_limits<std::int64_t>::max();
    for (std::int64_t columns = 1; columns <= std::min(n, limit / w); ++columns) {
        const std::int64_t rows = (n + columns - 1) / columns, side = std::max(columns * w, rows * h);
        if (rows * h > limit || side >= best_side) continue;
        best_side = side;
        best = Layout{static_cast<int>(columns), static_cast<int>(rows)};
    }
    return best;
}

Layout fittingLayout(const glm::ivec3& size, double voxel_size) {
    if (const auto layout = layoutFor(size.x, size.y, size.z)) return *layout;
    double scale = 1.05;
    const auto scaled = [&](int n) { return static_cast<std::int64_t>(std::ceil(n / scale)); };
    while (!layoutFor(scaled(size.x), scaled(size.y), scaled(size.z))) scale *= 1.05;
    throw Error(ErrorCode::Input, fmt::format("an atlas of {} slices of {} x {} texels exceeds {} texels a side; bake "
                                              "with voxel_size = {:.3g} or more, or a smaller domain",
                                              size.z, size.x, size.y, format::kAtlasLargestSide, voxel_size * scale));
}

/// One image of the atlas.
struct AtlasPart {
    const LightField* lobe;
    std::string path;
    bool rgb;          ///< the colours' irradiance, instead of flux and mean
    std::string what;  ///< in messages
};

/// What an atlas says of its grid.
struct AtlasGrid {
    VoxelBox box;
    glm::dvec3 voxel;  ///< [m]
    Layout layout;
};

Image atlasImage(const AtlasPart& part, const AtlasGrid& grid, double reference, std::atomic<std::int64_t>& clamped) {
    const LightField& field = *part.lobe;
    const VoxelBox& box = grid.box;
    const Layout& layout = grid.layout;
    const bool rgb = part.rgb;
    const glm::ivec3 size = box.max - box.min + 1;
    Image image;
    image.width = layout.columns * size.x, image.height = layout.rows * size.y, image.channels = rgb ? 3 : 4;
    image.pixels.assign(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                            static_cast<std::size_t>(image.channels),
                        0.0f);
    parallelFor(size.z, [&](std::int64_t k) {
        const int x0 = static_cast<int>(k) % layout.columns * size.x,
                  y0 = static_cast<int>(k) / layout.columns * size.y;
        std::int64_t cut = 0;
        const auto stored = [&](double v) { return cutToRange(static_cast<float>(v / reference), cut); };
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const glm::ivec3 voxel = box.min + glm::ivec3(x, y, static_cast<int>(k));
                if (rgb) {
                    for (int c = 0; c < 3; ++c) image.at(x0 + x, y0 + y, c) = stored(double(field.value(voxel, c)));
                    continue;
                }
                const glm::dvec3 flux = field.flux(voxel);
                for (int a = 0; a < 3; ++a) image.at(x0 + x, y0 + y, a) = stored(flux[a]);
                image.at(x0 + x, y0 + y, 3) = stored(field.irradiance(voxel));
            }
        clamped += cut;
    });
    return image;
}

nlohmann::json jsonOf(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

nlohmann::json sidecarOf(const StraightField& straight, const LightVolume& volume, const AtlasGrid& grid,
                         const std::string& path) {
    const GridFrame& frame = straight.field().frame();
    const auto& [box, voxel, layout] = grid;
    const glm::ivec3 size = box.max - box.min + 1;
    const bool coloured = straight.field().channels().irradiance == 3, second = straight.second() != nullptr;
    const auto named = [&](bool there, const char* part) {
        return there ? nlohmann::json(nameOf(partPath(path, part))) : nlohmann::json(nullptr);
    };
    const glm::dvec3 origin = frame.worldFromIndex(box.min);
    const glm::dvec3 a = origin - 0.5 * voxel, b = frame.worldFromIndex(box.max) + 0.5 * voxel;
    return {{"photic_atlas", format::kAtlasVersion},
            {"image", nameOf(path)},
            {"rgb_image", named(coloured, "_rgb")},
            {"image_2", named(second, "_2")},
            {"rgb_image_2", named(second && coloured, "_2_rgb")},
            {"width", layout.columns * size.x},
            {"height", layout.rows * size.y},
            {"columns", layout.columns},
            {"rows", layout.rows},
            {"slices", size.z},
            {"slice_width", size.x},
            {"slice_height", size.y},
            {"texel_of_voxel",
             "x = (k % columns) * slice_width + i, y = (k / columns) * slice_height + j, row 0 at the top"},
            {"sample_position", "cell_centre"},
            {"channels", {{"R", "flux_x"}, {"G", "flux_y"}, {"B", "flux_z"}, {"A", "irradiance_mean"}}},
            {"scale", volume.reference_irradiance},
            {"unit", "W/m2"},
            {"up_axis", "Z"},
            {"voxel_size", jsonOf(voxel)},
            {"bounds_world", {{"min", jsonOf(glm::min(a, b))}, {"max", jsonOf(glm::max(a, b))}}},
            {"world_from_index",
             {{voxel.x, 0, 0, origin.x}, {0, voxel.y, 0, origin.y}, {0, 0, voxel.z, origin.z}, {0, 0, 0, 1}}},
            {"index_min", {box.min.x, box.min.y, box.min.z}},
            {"resampled", straight.resampled()},
            {"metadata", volume.metadata}};
}

std::vector<AtlasPart> partsOf(const StraightField& straight, const std::string& path) {
    const LightField *first = &straight.field(), *second = straight.second();
    const bool coloured = first->channels().irradiance == 3;
    std::vector<AtlasPart> parts{{first, path, false, "the atlas"}};
    if (coloured) parts.push_back({first, partPath(path, "_rgb"), true, "the atlas of the colours"});
    if (second) parts.push_back({second, partPath(path, "_2"), false, "the atlas of the second lobe"});
    if (second && coloured)
        parts.push_back({second, partPath(path, "_2_rgb"), true, "the atlas of the second lobe's colours"});
    return parts;
}

}  // namespace

DenseWritten writeSliceAtlas(const std::string& path, const LightVolume& volume,
                             const std::optional<VoxelBox>& wanted) {
    OutputSet outputs;
    const DenseWritten written = writeSliceAtlas(outputs, path, volume, wanted);
    outputs.commit();
    return written;
}

DenseWritten writeSliceAtlas(OutputSet& outputs, const std::string& path, const LightVolume& volume,
                             const std::optional<VoxelBox>& wanted) {
    const StraightField straight(volume);
    const glm::dmat3& axes = straight.field().frame().worldFromIndex();
    const VoxelBox box = straight.box(wanted);
    const glm::ivec3 size = box.max - box.min + 1;
    const glm::dvec3 voxel(axes[0].x, axes[1].y, axes[2].z);
    const AtlasGrid grid{box, voxel, fittingLayout(size, voxel.x)};
    const std::vector<AtlasPart> parts = partsOf(straight, path);
    for (std::size_t i = 1; i < parts.size(); ++i) outputs.writesBeside(parts[i].what, parts[i].path, isTexture);
    const nlohmann::json json = sidecarOf(straight, volume, grid, path);

    // The sidecar last: a reader that finds it finds the images too.
    DenseWritten written{{}, size, 0};
    std::atomic<std::int64_t> clamped{0};
    for (const AtlasPart& part : parts) {
        outputs.write(part.path, encodeExr(part.path, atlasImage(part, grid, volume.reference_irradiance, clamped),
                                           ChannelDepth::Half));
        written.files.push_back(part.path);
    }
    written.clamped = clamped;
    const std::string sidecar_path = sidecarPath(path);
    written.files.push_back(sidecar_path);
    outputs.write(sidecar_path, json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
    return written;
}

}  // namespace photic
