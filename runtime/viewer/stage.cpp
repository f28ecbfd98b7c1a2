// SPDX-License-Identifier: Apache-2.0
#include "runtime/viewer/stage.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <variant>

#include "bake/field/density.h"
#include "bake/picture/receiver_picture.h"
#include "bake/picture/view_picture.h"

namespace photic::viewer {
namespace {

constexpr int kWaterSamples = 384;  // a side: finer than the waves of all examples by a factor of ten or more

void addQuad(StageTriangles& out, const glm::vec3& origin, const glm::vec3& across, const glm::vec3& up) {
    const glm::vec3 normal = glm::normalize(glm::cross(across, up));
    const glm::vec3 corner[4] = {origin, origin + across, origin + across + up, origin + up};
    for (const int i : {0, 1, 2, 0, 2, 3}) out.push_back({corner[i], normal});
}

/// A planar receiver within the box, as the bake's pictures frame it.
void addPlane(StageTriangles& out, const Scene& scene, const Object& object) {
    const PictureFrame frame = receiverFrame(scene, object.name, 16);
    const glm::vec3 origin(frame.origin), across(frame.across), up(frame.up);
    const bool upright = glm::dot(glm::cross(across, up), glm::vec3(frame.normal)) > 0;
    upright ? addQuad(out, origin, across, up) : addQuad(out, origin, up, across);
}

void addMesh(StageTriangles& out, const TriangleMesh& mesh) {
    for (const auto& triangle : mesh.triangles) {
        for (const std::uint32_t v : triangle)
            out.push_back({glm::vec3(mesh.positions[v]), glm::vec3(mesh.normals[v])});
    }
}

/// A surface's height field over a rectangle, kWaterSamples a side, row by row.
std::vector<StageVertex> sampledSurface(const Surface& surface, const glm::vec2& low, const glm::vec2& size) {
    std::vector<StageVertex> grid(static_cast<std::size_t>(kWaterSamples) * kWaterSamples);
    for (int j = 0; j < kWaterSamples; ++j) {
        for (int i = 0; i < kWaterSamples; ++i) {
            const glm::vec2 place = low + size * (glm::vec2(i, j) + 0.5f) / static_cast<float>(kWaterSamples);
            const SurfacePoint p = surfaceAbove(*surface.height_field, glm::dvec3(place, 0));
            const auto k = static_cast<std::size_t>(j) * kWaterSamples + static_cast<std::size_t>(i);
            grid[k] = {{place, p.position.z}, glm::vec3(glm::normalize(p.normal))};
        }
    }
    return grid;
}

/// The sheet that is seen: it ends at the box.
void addSheet(Stage& stage, const std::vector<StageVertex>& grid) {
    const auto inside = [&](const StageVertex& v) {
        return v.position.x >= stage.min.x && v.position.y >= stage.min.y && v.position.x <= stage.max.x &&
               v.position.y <= stage.max.y;
    };
    for (std::size_t j = 0; j + 1 < kWaterSamples; ++j) {
        for (std::size_t i = 0; i + 1 < kWaterSamples; ++i) {
            const std::size_t a = j * kWaterSamples + i, b = a + 1, c = a + kWaterSamples, e = c + 1;
            if (!inside(grid[a]) || !inside(grid[e])) continue;
            for (const std::size_t v : {a, b, e, a, e, c}) stage.sheets.push_back(grid[v]);
        }
    }
}

/// Water that light enters: its sheet, and its heights for live light.
void addWater(Stage& stage, const Surface& surface) {
    // The light that reaches the box's far bottom comes from beside the box.
    const glm::vec3 d(stage.light.direction[0], stage.light.direction[1], stage.light.direction[2]);
    const float depth = std::max(0.0f, static_cast<float>(surface.center.z) - stage.min.z);
    const float margin = depth * glm::length(glm::vec2(d)) / std::max(0.3f, -d.z) + 0.3f * depth + 0.1f;
    const glm::vec2 low = glm::vec2(stage.min) - margin, size = glm::vec2(stage.max) + margin - low;
    const std::vector<StageVertex> grid = sampledSurface(surface, low, size);
    stage.heights.reserve(grid.size());
    for (const StageVertex& v : grid) stage.heights.push_back(v.position.z - static_cast<float>(surface.center.z));
    stage.water.heights = stage.heights.data();
    stage.water.columns = stage.water.rows = kWaterSamples;
    for (int axis = 0; axis < 2; ++axis) stage.water.corner[axis] = low[axis], stage.water.size[axis] = size[axis];
    stage.water.level = static_cast<float>(surface.center.z);
    addSheet(stage, grid);
}

/// Every surface that bends or reflects light: the first water that light enters also lights what is below it.
void addSurfaces(Stage& stage, const Scene& scene) {
    for (const Surface& surface : scene.surfaces) {
        if (surface.event == SurfaceEvent::Mirror) {
            stage.sheet_reflectance = static_cast<float>((surface.colour.x + surface.colour.y + surface.colour.z) / 3);
        }
        if (surface.mesh) {
            addMesh(stage.sheets, *surface.mesh);
            continue;
        }
        if (!surface.height_field) continue;
        stage.light.ior = static_cast<float>(surface.ior_below / surface.ior_above);
        const bool entered = surface.event == SurfaceEvent::Refract || surface.event == SurfaceEvent::Both;
        if (entered && stage.heights.empty()) {
            addWater(stage, surface);
        } else {
            addSheet(stage, sampledSurface(surface, glm::vec2(stage.min), glm::vec2(stage.max - stage.min)));
        }
    }
}

/// A rectangle, as far as light arrives: cells at whose corners a volume is dark are left out.
void addLitQuad(StageTriangles& out, const runtime::Volume& volume, const glm::vec3& origin, const glm::vec3& across,
                const glm::vec3& up) {
    constexpr int kCells = 160;
    const glm::vec3 step_x = across / static_cast<float>(kCells), step_y = up / static_cast<float>(kCells);
    std::vector<runtime::Vec3> corners;
    for (int j = 0; j <= kCells; ++j) {
        for (int i = 0; i <= kCells; ++i) {
            const glm::vec3 p = origin + static_cast<float>(i) * step_x + static_cast<float>(j) * step_y;
            corners.push_back({p.x, p.y, p.z});
        }
    }
    std::vector<runtime::Light> light(corners.size());
    volume.sample(corners, light);
    const auto lit = [&](int i, int j) {
        return light[static_cast<std::size_t>(j) * (kCells + 1) + static_cast<std::size_t>(i)].irradiance.y > 0;
    };
    for (int j = 0; j < kCells; ++j) {
        for (int i = 0; i < kCells; ++i) {
            if (!lit(i, j) || !lit(i + 1, j) || !lit(i, j + 1) || !lit(i + 1, j + 1)) continue;
            addQuad(out, origin + static_cast<float>(i) * step_x + static_cast<float>(j) * step_y, step_x, step_y);
        }
    }
}

}  // namespace

Stage stageOf(const Scene& scene) {
    Stage stage;
    stage.min = glm::vec3(scene.domain.min), stage.max = glm::vec3(scene.domain.max);
    stage.reference = static_cast<float>(scene.referenceIrradiance());
    const ViewSettings view = defaultView(scene);
    stage.eye = glm::vec3(view.eye), stage.target = glm::vec3(view.target);
    stage.field_of_view_deg = static_cast<float>(view.field_of_view_deg);
    const Light* sun = nullptr;
    for (const Light& light : scene.lights) {
        if (!sun || glm::length(light.irradiance) > glm::length(sun->irradiance)) sun = &light;
    }
    const glm::dvec3 extinction = scene.medium.extinction();
    for (int axis = 0; axis < 3; ++axis) {
        if (sun) {
            stage.light.direction[axis] = static_cast<float>(sun->direction[axis]);
            stage.light.irradiance[axis] = static_cast<float>(sun->irradiance[axis]);
        }
        stage.light.extinction[axis] = static_cast<float>(extinction[axis]);
        stage.scattering[axis] = static_cast<float>(scene.medium.scattering[axis]);
    }
    stage.has_sun = sun != nullptr;
    stage.anisotropy = static_cast<float>(scene.medium.anisotropy);
    const bool cutaway = std::any_of(scene.surfaces.begin(), scene.surfaces.end(), [](const Surface& surface) {
        return surface.event == SurfaceEvent::Refract || surface.event == SurfaceEvent::Both;
    });
    for (const Object& object : scene.objects) {
        if (!object.receives()) continue;
        if (const auto* mesh = std::get_if<std::shared_ptr<const TriangleMesh>>(&object.shape)) {
            addMesh(stage.solids, **mesh);
        } else {
            // Only around water that is looked into from outside a wall may hide what is behind it.
            addPlane(cutaway ? stage.room : stage.solids, scene, object);
            const auto& plane = std::get<Plane>(object.shape);
            if (object.blocks() && stage.walls.size() < 8) {
                stage.walls.emplace_back(glm::vec3(plane.normal),
                                         static_cast<float>(glm::dot(plane.normal, plane.point)));
            }
        }
    }
    addSurfaces(stage, scene);
    return stage;
}

Stage stageOf(const runtime::Volume& volume) {
    Stage stage;
    const runtime::VoxelBox box = volume.litVoxels();
    glm::vec3 low(1e30f), high(-1e30f);
    for (int corner = 0; corner < 8; ++corner) {
        const auto pick = [&](int axis) { return (corner >> axis & 1) != 0 ? box.max[axis] : box.min[axis]; };
        const runtime::Vec3 p = volume.voxelCentre(pick(0), pick(1), pick(2));
        const glm::vec3 place(p.x, p.y, p.z);
        low = glm::min(low, place), high = glm::max(high, place);
    }
    if (low.x > high.x) low = glm::vec3(-1), high = glm::vec3(1);
    stage.min = low, stage.max = high;
    const runtime::Metadata& m = volume.metadata();
    stage.reference = static_cast<float>(m.reference_irradiance);
    stage.scattering = glm::vec3(m.scattering.x, m.scattering.y, m.scattering.z);
    const glm::vec3 extinction = stage.scattering + glm::vec3(m.absorption.x, m.absorption.y, m.absorption.z);
    for (int axis = 0; axis < 3; ++axis) stage.light.extinction[axis] = extinction[axis];
    stage.anisotropy = static_cast<float>(m.anisotropy);
    // Two voxels inside, where a look-up finds light on both sides.
    const runtime::Vec3 a = volume.voxelCentre(0, 0, 0), b = volume.voxelCentre(1, 1, 1);
    const glm::vec3 inset = 2.0f * glm::abs(glm::vec3(b.x - a.x, b.y - a.y, b.z - a.z));
    const glm::vec3 from = low + inset, to = high - inset, size = to - from;
    addLitQuad(stage.room, volume, from, {size.x, 0, 0}, {0, size.y, 0});
    addLitQuad(stage.room, volume, {to.x, from.y, from.z}, {0, 0, size.z}, {0, size.y, 0});
    addLitQuad(stage.room, volume, {from.x, to.y, from.z}, {size.x, 0, 0}, {0, 0, size.z});
    stage.target = 0.5f * (low + high);
    stage.eye = stage.target + 1.65f * glm::length(high - low) * glm::normalize(glm::vec3(-0.75f, -0.55f, 0.7f));
    return stage;
}

float lightLevel(const runtime::Volume& volume) {
    constexpr int kSamples = 24;  // along each axis of the lit box
    const runtime::VoxelBox box = volume.litVoxels();
    std::vector<runtime::Vec3> places;
    const auto at = [&](int n, int axis) {
        return box.min[axis] + (box.max[axis] - box.min[axis]) * n / (kSamples - 1);
    };
    for (int n = 0; n < kSamples * kSamples * kSamples; ++n) {
        places.push_back(
            volume.voxelCentre(at(n % kSamples, 0), at(n / kSamples % kSamples, 1), at(n / kSamples / kSamples, 2)));
    }
    std::vector<runtime::Light> light(places.size());
    volume.sample(places, light);
    double sum = 0;
    int lit = 0;
    for (const runtime::Light& l : light) {
        if (l.irradiance.y > 0) sum += l.irradiance.y, ++lit;
    }
    if (lit == 0) return 1;
    // Refracted light is a quarter of the reference or more; then all is as bright as ever.
    return static_cast<float>(std::clamp(4 * sum / lit / volume.metadata().reference_irradiance, 1e-3, 1.0));
}

StageTriangles ball() {
    constexpr int kRings = 48, kSegments = 96;
    const auto at = [](int ring, int segment) {
        const double theta = std::numbers::pi * ring / kRings, phi = 2 * std::numbers::pi * segment / kSegments;
        const glm::vec3 p(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
        return StageVertex{p, p};
    };
    StageTriangles out;
    for (int i = 0; i < kRings; ++i) {
        for (int j = 0; j < kSegments; ++j) {
            for (const auto& v : {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)}) {
                out.push_back(v);
            }
        }
    }
    return out;
}

}  // namespace photic::viewer
