// SPDX-License-Identifier: Apache-2.0
#include "bake/web/web_page.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <optional>

#include "bake/file/runtime_metadata.h"
#include "bake/picture/receiver_picture.h"
#include "bake/picture/view_picture.h"
#include "bake/report/error.h"
#include "bake/web/embedded_page.h"
#include "bake/web/packed_array.h"

namespace photic {
namespace {

using Json = nlohmann::ordered_json;

Json vec(const glm::dvec3& v) { return {v.x, v.y, v.z}; }
std::string dumped(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// Heights along each side of the water that is drawn: waves of a tenth of its width are smooth.
constexpr int kWaterSide = 161;

/// The water that is drawn: the scene's first height field, within the domain.
struct Water {
    const Surface* surface = nullptr;
    glm::dvec2 low{0}, size{0};  ///< [m]
};

std::optional<Water> waterOf(const Scene& scene) {
    const auto found = std::find_if(scene.surfaces.begin(), scene.surfaces.end(),
                                    [](const Surface& surface) { return surface.height_field != nullptr; });
    if (found == scene.surfaces.end()) return {};
    glm::dvec2 low(scene.domain.min), high(scene.domain.max);
    if (found->outside == Outside::None) {
        low = glm::max(low, glm::dvec2(found->center) - 0.5 * found->size);
        high = glm::min(high, glm::dvec2(found->center) + 0.5 * found->size);
    }
    if (!(low.x < high.x && low.y < high.y)) return {};
    return Water{&*found, low, high - low};
}

/// The heights as 16-bit steps between the lowest and the highest. What a surface is displaced by sideways is left out:
/// the page draws it, and no light follows from it.
void addHeights(const Water& water, Json& json) {
    std::vector<double> heights;
    heights.reserve(kWaterSide * kWaterSide);
    for (int j = 0; j < kWaterSide; ++j) {
        for (int i = 0; i < kWaterSide; ++i) {
            const glm::dvec2 place = water.low + water.size * glm::dvec2(i, j) / double(kWaterSide - 1);
            heights.push_back(water.surface->height_field->at(place).position.z);
        }
    }
    const auto [lowest, highest] = std::minmax_element(heights.begin(), heights.end());
    const double least = *lowest, range = std::max(*highest - *lowest, 1e-9);
    std::vector<std::uint16_t> codes;
    codes.reserve(heights.size());
    for (const double height : heights)
        codes.push_back(static_cast<std::uint16_t>(std::lround(65535 * (height - least) / range)));
    json["heights"] = packedArray(codes);
    json["lowest"] = least;
    json["highest"] = least + range;
}

Json meshJson(const TriangleMesh& mesh) {
    std::vector<float> positions, normals;
    std::vector<std::uint32_t> triangles;
    for (const glm::dvec3& p : mesh.positions)
        for (int axis = 0; axis < 3; ++axis) positions.push_back(static_cast<float>(p[axis]));
    for (const glm::dvec3& n : mesh.normals)
        for (int axis = 0; axis < 3; ++axis) normals.push_back(static_cast<float>(n[axis]));
    for (const auto& triangle : mesh.triangles) triangles.insert(triangles.end(), triangle.begin(), triangle.end());
    return {{"positions", packedArray(positions)},
            {"normals", packedArray(normals)},
            {"triangles", packedArray(triangles)}};
}

/// The corners of a convex polygon before a plane, those behind it cut away.
std::vector<glm::dvec3> cut(const std::vector<glm::dvec3>& corners, const Plane& plane) {
    std::vector<glm::dvec3> kept;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3 &a = corners[i], &b = corners[(i + 1) % corners.size()];
        const double before_a = glm::dot(a - plane.point, plane.normal),
                     before_b = glm::dot(b - plane.point, plane.normal);
        if (before_a >= 0) kept.push_back(a);
        if ((before_a < 0) != (before_b < 0)) kept.push_back(glm::mix(a, b, before_a / (before_a - before_b)));
    }
    return kept;
}

/// What is seen of a plane: within the domain, and before all other planes. Null where that is nothing.
Json planeJson(const Scene& scene, const Object& object) {
    PictureFrame frame;
    try {
        frame = receiverFrame(scene, object.name, 1);
    } catch (const Error&) {
        return nullptr;  // outside the domain
    }
    std::vector<glm::dvec3> corners{frame.origin, frame.origin + frame.across, frame.origin + frame.across + frame.up,
                                    frame.origin + frame.up};
    for (const Object& other : scene.objects) {
        const auto* plane = std::get_if<Plane>(&other.shape);
        if (plane && &other != &object && other.blocks()) corners = cut(corners, *plane);
    }
    if (corners.size() < 3) return nullptr;
    Json json = Json::array();
    for (const glm::dvec3& corner : corners) json.push_back(vec(corner));
    return {{"corners", json}, {"normal", vec(frame.normal)}};
}

/// Everything solid: receivers, and meshes that only block.
Json solidsOf(const Scene& scene) {
    Json solids = Json::array();
    for (const Object& object : scene.objects) {
        Json solid = {{"name", object.name}, {"albedo", object.albedo ? vec(*object.albedo) : Json(nullptr)}};
        if (const auto* mesh = std::get_if<std::shared_ptr<const TriangleMesh>>(&object.shape)) {
            solid["mesh"] = meshJson(**mesh);
        } else {
            const Json plane = object.receives() ? planeJson(scene, object) : Json(nullptr);
            if (plane.is_null()) continue;
            solid["plane"] = plane;
        }
        solids.push_back(solid);
    }
    return solids;
}

/// Glass, mirrors and meshes of water: what they reflect is drawn, and of closed ones what is absorbed in them.
Json shellsOf(const Scene& scene) {
    Json shells = Json::array();
    for (const Surface& surface : scene.surfaces) {
        if (!surface.mesh) continue;
        const double ior =
            sideOf(scene, surface, Side::Below).ior.mean() / sideOf(scene, surface, Side::Above).ior.mean();
        const bool mirror = surface.event == SurfaceEvent::Mirror;
        const bool tints = surface.closed && !mirror;
        shells.push_back({{"name", surface.name},
                          {"ior", ior},
                          {"mirror", mirror ? vec(surface.colour) : Json(nullptr)},
                          {"absorption", vec(tints ? sideOf(scene, surface, Side::Below).absorption : glm::dvec3(0))},
                          {"mesh", meshJson(*surface.mesh)}});
    }
    return shells;
}

/// The medium that eyes look through. Where the scene states none, clear water has a tint and a little haze: a
/// decoration, which the page's sliders change.
Json mediumOf(const Scene& scene, bool water) {
    constexpr glm::dvec3 kCleanWater{0.35, 0.07, 0.02};  // absorption [1/m], as `photic picture --view` has it
    constexpr double kHazeAcross = 0.25;                 // share of light that haze scatters across the domain
    const double across = glm::length(scene.domain.max - scene.domain.min);
    const glm::dvec3 s = scene.medium.scattering;
    const double scattering = (s.x + s.y + s.z) / 3;
    const double haze = scene.medium.present() ? scattering : water ? kHazeAcross / across : 0;
    return {{"absorption", vec(scene.medium.present() ? scene.medium.absorption
                               : water                ? kCleanWater
                                                      : glm::dvec3(0))},
            {"haze", haze},
            {"most_haze", std::max(4 * haze, 2 / across)},
            {"anisotropy", std::clamp(scene.medium.anisotropy, -0.95, 0.95)}};
}

/// The light that falls on what no volume holds: the strongest sun, above water, in units of the reference.
Json lightOf(const Scene& scene, const LightVolume& volume) {
    const Light* strongest = nullptr;
    for (const Light& light : scene.lights)
        if (!strongest || glm::length(light.irradiance) > glm::length(strongest->irradiance)) strongest = &light;
    const auto paths = volume.metadata.find("paths");
    const bool direct =
        strongest && strongest->type == LightType::Sun && (paths == volume.metadata.end() || paths->second != "all");
    return {{"direction", vec(strongest ? strongest->direction : glm::dvec3(0, 0, -1))},
            {"irradiance", vec(direct ? strongest->irradiance / volume.reference_irradiance : glm::dvec3(0))}};
}

/// "examples/own_pool.toml" is "Own pool".
std::string titleOf(const Scene& scene) {
    std::string title = std::filesystem::path(scene.file).stem().string();
    std::replace(title.begin(), title.end(), '_', ' ');
    if (!title.empty()) title[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(title[0])));
    return title;
}

Json ballOf(const Scene& scene, const std::optional<Water>& water) {
    const glm::dvec3 size = scene.domain.max - scene.domain.min;
    glm::dvec3 centre = 0.5 * (scene.domain.min + scene.domain.max);
    if (water) centre.z = 0.5 * (scene.domain.min.z + std::min(scene.domain.max.z, water->surface->center.z));
    return {{"centre", vec(centre)}, {"radius", 0.085 * std::min({size.x, size.y, size.z})}};
}

/// Tiles make a pool of planes; open seas and rooms of meshes have none.
double tileOf(const Scene& scene) {
    const glm::dvec3 size = scene.domain.max - scene.domain.min;
    constexpr double kLargestPool = 30;  // [m]
    const double longest = std::max(size.x, size.y);
    return waterOf(scene) && longest < kLargestPool ? longest / 16 : 0;
}

}  // namespace

std::string webPageHtml(std::string_view script) {
    std::string html;
    for (const EmbeddedFile* file = kEmbeddedPage; file->name; ++file)
        if (std::string_view(file->name).ends_with(".html")) html = file->text;
    constexpr std::string_view kScript = "src=\"photic.js\"";
    html.replace(html.find(kScript), kScript.size(), "src=\"" + std::string(script) + "\"");
    return html;
}

std::string webPageScript() {
    // One script with a scope of its own, so that its names meet nothing else on a page that includes it.
    std::string script = "(() => {\n\"use strict\";\n";
    for (const EmbeddedFile* file = kEmbeddedPage; file->name; ++file)
        if (std::string_view(file->name).ends_with(".js")) script += file->text;
    return script + "})();\n";
}

std::string webFrameScript(int frame, const DenseTexels& light, const Scene& scene) {
    Json json = Json::object();
    const auto addLobe = [&](const LobeTexels& lobe, const std::string& suffix) {
        json["light" + suffix] = packedArray(lobe.light);
        if (!lobe.rgb.empty()) json["rgb" + suffix] = packedArray(lobe.rgb);
    };
    addLobe(light.first, "");
    if (light.second) addLobe(*light.second, "_2");
    if (const auto water = waterOf(scene)) addHeights(*water, json);
    return "photicFrame(" + std::to_string(frame) + ", " + dumped(json) + ");\n";
}

std::string webSceneScript(const WebScene& page, const LightVolume& volume, const DenseTexels& light) {
    const Scene& scene = page.scene;
    const ViewSettings view = defaultView(scene);
    const auto water = waterOf(scene);
    Json frames = Json::array(), rows = Json::array();
    for (const WebFrame& frame : page.frames) frames.push_back({{"frame", frame.frame}, {"file", frame.file}});
    const glm::dmat4& m = light.world_from_texture;
    for (int row = 0; row < 4; ++row) rows.push_back({m[0][row], m[1][row], m[2][row], m[3][row]});
    const auto program = volume.metadata.find("program");
    Json json = {
        {"photic", 1},
        {"title", titleOf(scene)},
        {"program", program == volume.metadata.end() ? "photic" : program->second},
        {"metadata", runtimeMetadata(volume)},
        {"world_from_texture", rows},
        {"texture_size", {light.size.x, light.size.y, light.size.z}},
        {"coloured", !light.first.rgb.empty()},
        {"frames", frames},
        {"frame_rate", page.frames_per_second},
        {"domain", {{"min", vec(scene.domain.min)}, {"max", vec(scene.domain.max)}}},
        {"medium", mediumOf(scene, water.has_value())},
        {"light", lightOf(scene, volume)},
        {"water", nullptr},
        {"tile", tileOf(scene)},
        {"ball", ballOf(scene, water)},
        {"camera", {{"eye", vec(view.eye)}, {"target", vec(view.target)}, {"field_of_view", view.field_of_view_deg}}},
        {"receivers", solidsOf(scene)},
        {"shells", shellsOf(scene)}};
    if (water) {
        json["water"] = {{"low", {water->low.x, water->low.y}},
                         {"size", {water->size.x, water->size.y}},
                         {"side", kWaterSide},
                         {"level", water->surface->center.z},
                         {"ior", water->surface->ior_below / water->surface->ior_above}};
    }
    return "photicScene(" + dumped(json) + ");\n";
}

}  // namespace photic
