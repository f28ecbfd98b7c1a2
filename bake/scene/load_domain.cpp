// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "bake/report/error.h"
#include "bake/scene/light_bounds.h"
#include "bake/scene/load_parts.h"

namespace photic {
namespace {

constexpr int kDefaultResolution = 128;
constexpr int kMarginVoxels = 2;
constexpr int kLightMarginVoxels = 3;           // so that look-ups on a wall at the box's side find light behind it
constexpr double kMostVoxels = 274877906944.0;  // 2^38
constexpr double kFarthest = 1e9;               // [m]

}  // namespace

DomainRequest loadDomain(const ConfigValue* value, const std::string& name) {
    DomainRequest request;
    request.where = value ? value->where : name;
    request.resolution = kDefaultResolution;
    if (!value) return request;
    const TableReader table(*value, "[domain]",
                            {"min", "max", "fit", "voxel_size", "resolution", "shear", "layer_height"});

    Domain& domain = request.domain;
    const auto min = table.vector3("min", withinReach("m")), max = table.vector3("max", withinReach("m"));
    if (min.has_value() != max.has_value())
        table.fail(fmt::format("[domain] has '{}' without '{}'; give both, or neither for the scene's bounds",
                               min ? "min" : "max", min ? "max" : "min"));
    if (min) {
        for (int a = 0; a < 3; ++a)
            if ((*min)[a] >= (*max)[a])
                table.fail("max", fmt::format("max.{0} is {1}, min.{0} is {2}: the box is empty; max must be greater",
                                              "xyz"[a], (*max)[a], (*min)[a]));
        domain.min = *min, domain.max = *max, request.has_box = true;
    }

    if (table.find("fit")) request.fits_light = *table.choice("fit", {"scene", "light"}) == 1;
    if (table.find("fit") && min)
        table.fail("fit", "[domain] has 'fit' beside 'min' and 'max'; give the box, or how it is found");

    table.exclusive({"voxel_size", "resolution"});
    request.is_sized = table.find("voxel_size") || table.find("resolution");
    if (const auto size = table.number("voxel_size", positive("m"))) {
        domain.voxel_size = *size, request.resolution = 0;
        if (request.has_box) {
            const glm::dvec3 extent = domain.max - domain.min;
            // Layers of a height of their own are checked against the box's height below.
            const double height = table.find("layer_height") ? *size : extent.z;
            const double least = std::min({extent.x, extent.y, height});
            if (*size > least)
                table.fail("voxel_size", fmt::format("voxel_size {} m exceeds the {} m domain; use {} or less", *size,
                                                     least, least / 2));
        }
    }
    if (const auto resolution = table.integer("resolution", 1, 1 << 20))
        request.resolution = static_cast<int>(*resolution);
    domain.layer_height = table.number("layer_height", positive("m")).value_or(0);

    if (const ConfigValue* shear = table.find("shear")) {
        if (shear->kind == ConfigValue::Kind::Array)
            domain.shear_mode = ShearMode::Explicit, domain.shear = *table.vector2("shear", between(-100, 100));
        else
            domain.shear_mode = *table.choice("shear", {"none", "light"}) == 1 ? ShearMode::Light : ShearMode::None;
    }
    return request;
}

void finishDomain(const DomainRequest& request, Scene& scene) {
    Domain& domain = scene.domain = request.domain;
    const auto longest = [&] {
        return std::max({domain.max.x - domain.min.x, domain.max.y - domain.min.y, domain.max.z - domain.min.z});
    };
    if (!request.has_box) {
        const Bounds3 box = request.fits_light ? lightBounds(scene) : sceneBounds(scene);
        const int margin_voxels = request.fits_light ? kLightMarginVoxels : kMarginVoxels;
        if (box.empty())
            throw Error(ErrorCode::Input,
                        "the scene has no bounds: its media fill the world; give [domain] min and max, in metres",
                        request.where);
        for (int a = 0; a < 3; ++a)
            if (!(std::fabs(box.min[a]) <= kFarthest && std::fabs(box.max[a]) <= kFarthest))
                throw Error(
                    ErrorCode::Input,
                    fmt::format("the scene reaches from {:.3g} to {:.3g} m along {}, and the limit is {:g} m from the "
                                "origin; give [domain] min and max, or move what lies far away",
                                box.min[a], box.max[a], "xyz"[a], kFarthest),
                    request.where);
        domain.min = box.min, domain.max = box.max;
        if (request.resolution > 0) domain.voxel_size = longest() / request.resolution;
        const glm::dvec3 margin(margin_voxels * domain.voxel_size, margin_voxels * domain.voxel_size,
                                margin_voxels * (domain.layer_height > 0 ? domain.layer_height : domain.voxel_size));
        domain.min -= margin, domain.max += margin;
    } else if (request.resolution > 0) {
        domain.voxel_size = longest() / request.resolution;
    }

    const double layer = domain.layer_height > 0 ? domain.layer_height : domain.voxel_size;
    const glm::dvec3 extent = domain.max - domain.min;
    const double columns = std::ceil(extent.x / domain.voxel_size), rows = std::ceil(extent.y / domain.voxel_size),
                 layers = std::ceil(extent.z / layer);
    if (layer > extent.z)
        throw Error(
            ErrorCode::Input,
            fmt::format("voxels {} m high exceed the {} m domain; use {} or less", layer, extent.z, extent.z / 2),
            request.where);
    if (columns * rows * layers > kMostVoxels)
        throw Error(
            ErrorCode::Input,
            fmt::format("the box has {:.6g} x {:.6g} x {:.6g} voxels of {} m; the limit is 2^38 = {:.3g}; {} or a "
                        "smaller box",
                        columns, rows, layers, domain.voxel_size, kMostVoxels,
                        domain.layer_height > 0 ? std::string("use a larger voxel_size or layer_height")
                                                : fmt::format("use voxels of {:.3g} m",
                                                              std::cbrt(extent.x * extent.y * extent.z / kMostVoxels))),
            request.where);
}

}  // namespace photic
