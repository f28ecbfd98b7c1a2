// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/post_steps.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "bake/field/caustic_steps.h"
#include "bake/report/error.h"

namespace photic {

namespace {

LightField& causticOf(LightVolume& volume) {
    const auto found = volume.scalars.find("caustic");
    if (found == volume.scalars.end()) {
        throw Error(ErrorCode::Input,
                    "the volume has no grid 'caustic' to work on; bake it with --grids irradiance,direction,caustic");
    }
    return found->second;
}

struct Step {
    bool sharpens;
    double first, second;
};

Step parsed(const std::string& text) {
    Step step{};
    int used = 0;
    const auto is = [&](const char* pattern) {
        return std::sscanf(text.c_str(), pattern, &step.first, &step.second, &used) == 2 &&
               used == static_cast<int>(text.size()) && std::isfinite(step.first) && std::isfinite(step.second);
    };
    step.sharpens = is("sharpen=%lf,%lf%n");
    if (!step.sharpens && !is("dissipate=%lf,%lf%n")) {
        throw Error(ErrorCode::Usage,
                    "that is no step; write sharpen=A,B for a * phi^b, or dissipate=Z,SPEED with the height [m] below "
                    "which it acts and 0 to 0.7 voxels a layer",
                    text);
    }
    if (step.sharpens && (!(step.first > 0) || !(step.second > 0))) {
        throw Error(ErrorCode::Usage,
                    fmt::format("sharpen needs A and B above 0, and they are {} and {}", step.first, step.second),
                    text);
    }
    if (!step.sharpens && (!(step.second >= 0) || step.second > kFastestDissipation)) {
        throw Error(
            ErrorCode::Usage,
            fmt::format("a dissipation speed of {} voxels a layer; it must lie in 0 to {}, or the wave is not stable",
                        step.second, kFastestDissipation),
            text);
    }
    return step;
}

}  // namespace

void checkPostSteps(const std::vector<std::string>& steps) {
    for (const std::string& step : steps) parsed(step);
}

void applyPostSteps(const std::vector<std::string>& steps, LightVolume& volume) {
    if (steps.empty()) return;
    checkPostSteps(steps);
    LightField& caustic = causticOf(volume);
    std::string& kind = volume.metadata["caustic_kind"];
    if (kind.find("negative where light converges") != std::string::npos) {
        sharpenCaustic(caustic, 1, 1, -1);
        kind = "curvature of the front [1/m], positive where light converges";
    }
    for (const std::string& text : steps) {
        const Step step = parsed(text);
        if (step.sharpens) {
            sharpenCaustic(caustic, step.first, step.second, 1);
        } else {
            dissipateCaustic(caustic, step.first, step.second);
        }
        kind += (kind.empty() ? "" : "; ") + text;
    }
}

void causticAsLight(LightVolume& volume) {
    causticOf(volume);
    volume = withoutLobes(std::move(volume));
    const LightField& caustic = causticOf(volume);
    LightField& light = volume.field;
    if (!light.channels().flux) {
        throw Error(
            ErrorCode::Input,
            "the volume has no grid 'direction', which light needs; bake it with --grids irradiance,direction,caustic");
    }
    const int colours = light.channels().irradiance;
    forEachLeaf(light.needed(), [&](int slot) {
        if (light.state(slot) == LeafState::Empty) return;
        float* data = light.makeDense(slot);
        const int from = caustic.needed().slotOf(light.needed().leafOrigin(slot));
        for (int i = 0; i < LightField::kLeafVoxels; ++i) {
            float value = 0, mean = 0;
            if (from >= 0 && caustic.state(from) == LeafState::Dense) value = caustic.dense(from)[i];
            if (from >= 0 && caustic.state(from) == LeafState::Constant) value = caustic.constant(from)[0];
            value = std::max(0.0f, value) * static_cast<float>(volume.reference_irradiance);
            for (int c = 0; c < colours; ++c)
                mean += data[c * LightField::kLeafVoxels + i] / static_cast<float>(colours);
            const float scale = mean > 0 ? value / mean : 0;
            for (int c = 0; c < colours; ++c) data[c * LightField::kLeafVoxels + i] = value;
            for (int a = colours; a < colours + 3; ++a) data[a * LightField::kLeafVoxels + i] *= scale;
        }
    });
    volume.has_irradiance = true;
    volume.metadata["method"] += " caustic as light";
    volume.metadata.erase("ledger");
}

}  // namespace photic
