// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/catalogue.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bake/methods/beams.h"
#include "bake/methods/eikonal.h"
#include "bake/methods/photons.h"
#include "bake/methods/wave.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"

namespace photic {

std::span<const Method> methodCatalogue() {
    // In the order in which `auto` tries them.
    static const std::vector<Method> rows{
        beamsMethod(),
        photonsMethod(),
        eikonalMethod(),
        waveMethod(),
    };
    return rows;
}

const Method& chooseMethod(const std::string& name, const Scene& scene) {
    std::vector<std::string> names, refusals;
    for (const Method& method : methodCatalogue()) {
        names.push_back(method.name);
        if (name != "auto" && name != method.name) continue;
        const std::string refusal = method.refusal(scene);
        if (refusal.empty()) return method;
        refusals.push_back(fmt::format("{}: {}", method.name, refusal));
    }
    if (refusals.empty()) {
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

}  // namespace photic
