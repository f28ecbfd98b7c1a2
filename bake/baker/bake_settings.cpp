// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/bake_settings.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string_view>

#include "bake/baker/report_json.h"
#include "bake/baker/version.h"
#include "bake/scene/setting_names.h"

namespace photic {

namespace {

using Json = nlohmann::ordered_json;

std::uint64_t fnv1a(std::string_view text, std::uint64_t hash) {
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
    return hash;
}

/// The method's own options, defaults included.
Json optionsOf(const Scene& scene, const Method& method) {
    Json options = Json::object();
    const GivenOptions& given = givenOptions(scene, method);
    for (const OptionSpec& spec : method.options) {
        const auto own = given.find(spec.name);
        options[spec.name] = toJson(own == given.end() ? spec.default_value : own->second.value);
    }
    return options;
}

}  // namespace

double errorGoal(const BakeSettings& bake) { return bake.error.value_or(bake.sizes_itself ? kDefaultError : 0); }

std::string settingsText(const Scene& scene, const Method& method, const BakeChoices& choices) {
    const BakeSettings& bake = scene.bake;
    constexpr const char* kCompression[] = {"none", "mask", "blosc", "zip"};
    Json settings{{"method", method.name},
                  {"voxel_size", scene.domain.voxel_size},
                  {"layer_height", scene.domain.layer_height > 0 ? scene.domain.layer_height : scene.domain.voxel_size},
                  {"grids", gridNames(bake.grids)},
                  {"where", nameOf(bake.where)},
                  {"band", bake.band},
                  {"paths", nameOf(bake.paths)},
                  {"quadrature", bake.quadrature},
                  {"tolerance", bake.tolerance},
                  {"prefilter", bake.prefilter},
                  {"lobes", bake.lobes},
                  {"half", choices.file.half},
                  {"compression", kCompression[static_cast<int>(choices.file.compression)]},
                  {"options", optionsOf(scene, method)}};
    if (const double goal = errorGoal(bake); goal > 0) {
        settings["error"] = goal;
        settings["budget_bytes"] = choices.budget_bytes, settings["seconds"] = choices.seconds;
    }
    if (bake.lobe_axis) settings["lobe_axis"] = {bake.lobe_axis->x, bake.lobe_axis->y, bake.lobe_axis->z};
    if (!choices.post.empty()) settings["post"] = choices.post;
    return dump(settings);
}

std::string inputHash(const Scene& scene, const Method& method, const BakeChoices& choices) {
    std::uint64_t hash = fnv1a(settingsText(scene, method, choices), 0xcbf29ce484222325ULL);
    hash = fnv1a(programVersion(), hash);
    hash = fnv1a(fmt::format("{:016x} {}", scene.hash, scene.frame), hash);
    return fmt::format("{:016x}", hash);
}

}  // namespace photic
