// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/catalogue.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "bake/methods/beams.h"
#include "bake/methods/eikonal.h"
#include "bake/methods/photons.h"
#include "bake/methods/wave.h"
#include "bake/methods/wavefront.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"
#include "bake/scene/setting_names.h"

namespace photic {

std::span<const Method> methodCatalogue() {
    // In the order in which `auto` tries them.
    static const std::vector<Method> rows{
        beamsMethod(), wavefrontMethod(), photonsMethod(), eikonalMethod(), waveMethod(),
    };
    return rows;
}

const Method* findMethod(const std::string& name) {
    for (const Method& method : methodCatalogue())
        if (method.name == name) return &method;
    return nullptr;
}

std::vector<std::string> catalogueNames() {
    std::vector<std::string> names;
    for (const Method& method : methodCatalogue()) names.push_back(method.name);
    return names;
}

std::vector<std::string> gridsOf(const Method& method) {
    std::vector<std::string> grids = method.grids;
    grids.emplace_back("density");
    return grids;
}

const GivenOptions& givenOptions(const Scene& scene, const Method& method) {
    static const GivenOptions none;
    const auto given = scene.bake.method_options.find(method.name);
    return given == scene.bake.method_options.end() ? none : given->second;
}

namespace {

/// Why a method cannot make what a scene's [bake] asks for.
std::string refusalOf(const Method& method, const Scene& scene) {
    for (const std::string& grid : gridNames(scene.bake.grids)) {
        const std::vector<std::string> known = gridsOf(method);
        if (std::find(known.begin(), known.end(), grid) == known.end())
            return fmt::format("it makes no grid '{}', only {}; leave it out of grids", grid, fmt::join(known, ", "));
    }
    return method.refusal(scene);
}

}  // namespace

const Method& chooseMethod(const std::string& name, const Scene& scene) {
    std::vector<std::string> refusals;
    for (const Method& method : methodCatalogue()) {
        if (name != "auto" && name != method.name) continue;
        const std::string refusal = refusalOf(method, scene);
        if (refusal.empty()) return method;
        refusals.push_back(fmt::format("{}: {}", method.name, refusal));
    }
    if (refusals.empty()) {
        std::vector<std::string> names = catalogueNames();
        names.insert(names.begin(), "auto");
        const std::string nearest = nearestName(name, names);
        throw Error(ErrorCode::Input,
                    fmt::format("there is no method '{}'; {}", name,
                                nearest.empty() ? fmt::format("choose one of {}", fmt::join(names, ", "))
                                                : fmt::format("did you mean '{}'?", nearest)),
                    scene.file);
    }
    throw Error(ErrorCode::Input,
                name == "auto" ? fmt::format("no method can bake this scene: {}", fmt::join(refusals, "; "))
                               : fmt::format("method {}", refusals.front()),
                scene.file);
}

void checkMethodTables(const Scene& scene) {
    for (const auto& [name, options] : scene.bake.method_options) {
        const Method* method = findMethod(name);
        if (!method) {
            const std::string nearest = nearestName(name, catalogueNames());
            throw Error(ErrorCode::Input,
                        fmt::format("[bake.{}] names no method; {}known: {}", name,
                                    nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest),
                                    fmt::join(catalogueNames(), ", ")),
                        options.empty() ? scene.file : options.begin()->second.where);
        }
        validateOptions(*method, options);
    }
}

}  // namespace photic
