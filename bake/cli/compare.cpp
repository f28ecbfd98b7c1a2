// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "bake/cli/difference.h"
#include "bake/cli/json.h"
#include "bake/cli/scores.h"
#include "bake/cli/verbs.h"
#include "bake/cli/voxel_walk.h"
#include "bake/file/output_set.h"
#include "bake/image/image.h"
#include "bake/picture/display.h"
#include "bake/report/error.h"

namespace photic::cli {

namespace {

Json numbers(const Difference& d) {
    return {
        {"relative_l1", d.relativeL1()},
        {"relative_l2", d.relativeL2()},
        {"energy_ratio", d.energyRatio()},
        {"worst", {{"difference", d.worst()}, {"relative", d.relativeWorst()}, {"a", d.worstA()}, {"b", d.worstB()}}}};
}

/// What to add to b's index to get a's. The lattices must coincide, up to whole voxels: bakes of receivers alone number
/// theirs by their leaves.
glm::ivec3 offsetBetween(const CompareArguments& arguments, const GridFrame& a, const GridFrame& b) {
    const glm::dvec3 offset = glm::round(a.indexFromWorld(b.worldFromIndex(b.min)) - glm::dvec3(b.min));
    double apart = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 index(corner & 1 ? b.max.x : b.min.x, corner & 2 ? b.max.y : b.min.y,
                               corner & 4 ? b.max.z : b.min.z);
        apart = std::max(apart, glm::length(a.worldFromIndex(index + offset) - b.worldFromIndex(index)));
    }
    const double voxel = std::cbrt(b.voxelVolume());
    if (apart <= 1e-3 * voxel) return glm::ivec3(offset);
    throw Error(ErrorCode::Input,
                fmt::format("the volumes' voxels do not coincide (they are up to {:.3g} m apart, a voxel is {:.3g} m); "
                            "bake both on one grid",
                            apart, voxel),
                arguments.a + ", " + arguments.b);
}

Json compareVolumes(const CompareArguments& arguments, Terminal& terminal, double& error) {
    terminal.progress("read", 0);
    // Lobes are parted by axes of their own: what is compared is all light.
    const LightVolume a = withoutLobes(readVdb(arguments.a)), b = withoutLobes(readVdb(arguments.b));
    terminal.checkCancelled();
    const glm::ivec3 in_a = offsetBetween(arguments, a.field.frame(), b.field.frame());
    const bool flux = a.has_direction && b.has_direction && a.field.channels().flux && b.field.channels().flux;
    if (a.field.channels().irradiance != b.field.channels().irradiance) {
        throw Error(ErrorCode::Input,
                    "one volume is coloured and the other is not; bake both with the same lights and medium",
                    arguments.a + ", " + arguments.b);
    }
    std::optional<LightVolume> sigma;
    glm::ivec3 in_sigma{0};
    if (!arguments.standard_error.empty()) {
        sigma.emplace(readVdb(arguments.standard_error));
        in_sigma = offsetBetween(arguments, sigma->field.frame(), b.field.frame());
    }

    Difference light, flow;
    Scores scores(arguments.bias_allowance,
                  arguments.most_standard_error.value_or(std::numeric_limits<double>::infinity()));
    glm::ivec3 worst_voxel{0};
    const auto visit = [&](const glm::ivec3& voxel) {
        for (int c = 0; c < b.field.channels().irradiance; ++c) {
            if (light.add(static_cast<double>(a.field.value(voxel + in_a, c)),
                          static_cast<double>(b.field.value(voxel, c))))
                worst_voxel = voxel;
        }
        if (flux) {
            const glm::dvec3 fa = a.field.flux(voxel + in_a), fb = b.field.flux(voxel);
            for (int c = 0; c < 3; ++c) flow.add(fa[c], fb[c]);
        }
        if (sigma)
            scores.add(voxel, a.field.irradiance(voxel + in_a), b.field.irradiance(voxel),
                       sigma->field.irradiance(voxel + in_sigma));
    };
    forEachVoxel(b.field.needed(), visit);
    forEachVoxel(a.field.needed(), [&](const glm::ivec3& voxel) {
        if (!b.field.needed().contains(voxel - in_a)) visit(voxel - in_a);
    });

    error = light.relativeL1();
    if (flux && !(flow.relativeL1() <= error)) error = flow.relativeL1();  // NaN wins
    Json irradiance = numbers(light);
    irradiance["worst"]["index"] = toJson(worst_voxel);
    irradiance["worst"]["world"] = toJson(b.field.frame().worldFromIndex(glm::dvec3(worst_voxel)));
    Json scored(nullptr);
    if (sigma) {
        scored = scores.json();
        scored["worst_index"] = toJson(scores.worstVoxel());
        scored["worst_world"] = toJson(b.field.frame().worldFromIndex(glm::dvec3(scores.worstVoxel())));
    }
    return {{"kind", "volume"},
            {"count", light.count() / b.field.channels().irradiance},
            {"irradiance", irradiance},
            {"flux", flux ? numbers(flow) : Json(nullptr)},
            {"standard_error", scored}};
}

Json compareImages(const CompareArguments& arguments, OutputSet& outputs, double& error) {
    const Image a = readExr(arguments.a), b = readExr(arguments.b);
    if (a.width != b.width || a.height != b.height || a.channels != b.channels) {
        throw Error(
            ErrorCode::Input,
            fmt::format(
                "the images differ in shape: {} x {} with {} channels, {} x {} with {}; make both at one resolution",
                a.width, a.height, a.channels, b.width, b.height, b.channels),
            arguments.a + ", " + arguments.b);
    }
    Difference light;
    int worst_x = 0, worst_y = 0;
    for (int y = 0; y < b.height; ++y) {
        for (int x = 0; x < b.width; ++x) {
            for (int c = 0; c < std::min(3, b.channels); ++c) {
                if (light.add(static_cast<double>(a.at(x, y, c)), static_cast<double>(b.at(x, y, c))))
                    worst_x = x, worst_y = y;
            }
        }
    }
    if (!arguments.difference.empty()) {
        Image difference{b.width, b.height, 1,
                         std::vector<float>(static_cast<std::size_t>(b.width) * static_cast<std::size_t>(b.height))};
        Image magnitude = difference;
        for (int y = 0; y < b.height; ++y) {
            for (int x = 0; x < b.width; ++x) {
                difference.at(x, y, 0) = static_cast<float>(pixelMean(a, x, y) - pixelMean(b, x, y));
                magnitude.at(x, y, 0) = std::fabs(difference.at(x, y, 0));
            }
        }
        const double range = niceCeiling(percentile(magnitude, 0.998));
        outputs.write(
            arguments.difference,
            encodePng(arguments.difference, displayMapped(difference, ColourMap::BlueRed, -range, range, "W/m2")));
        outputs.commit();
    }
    error = light.relativeL1();
    Json irradiance = numbers(light);
    irradiance["worst"]["pixel"] = Json::array({worst_x, worst_y});
    return {{"kind", "image"}, {"count", static_cast<std::int64_t>(b.width) * b.height}, {"irradiance", irradiance}};
}

std::string describe(const Json& d) {
    const auto line = [](const char* name, const Json& n) {
        // Infinite where the reference is dark.
        const auto percent = [&](const char* key) {
            return n[key].is_number() && std::isfinite(n[key].get<double>())
                       ? fmt::format("{:.4g} %", n[key].get<double>() * 100)
                       : std::string("infinite");
        };
        return fmt::format("{}: relative L1 {}, L2 {}, energy ratio {:.7g}, worst {:.4g} ({:.5g} against {:.5g})", name,
                           percent("relative_l1"), percent("relative_l2"), n["energy_ratio"].get<double>(),
                           n["worst"]["difference"].get<double>(), n["worst"]["a"].get<double>(),
                           n["worst"]["b"].get<double>());
    };
    const Json& light = d["irradiance"];
    std::string text = line("irradiance", light);
    if (d["kind"] == "volume") {
        const Json &i = light["worst"]["index"], &w = light["worst"]["world"];
        text +=
            fmt::format(" at voxel ({}, {}, {}), world ({:.5g}, {:.5g}, {:.5g}) m", i[0].get<int>(), i[1].get<int>(),
                        i[2].get<int>(), w[0].get<double>(), w[1].get<double>(), w[2].get<double>());
        if (!d["flux"].is_null()) text += fmt::format("\n{}", line("flux", d["flux"]));
        if (!d["standard_error"].is_null()) {
            const Json& s = d["standard_error"];
            const auto number = [&](const char* key) { return s[key].get<double>(); };
            text += fmt::format(
                "\nagainst the standard error of {} voxels: chi2/n {:.4f}, {:.3g} % above 3, worst z {:.2f}; without "
                "the "
                "allowance of {:.3g} % {:.4f}, with it in quadrature {:.4f}; a bias of {:.3g} % in quadrature makes it "
                "1",
                s["voxels"].get<std::int64_t>(), number("chi2_per_voxel"), number("share_above_3") * 100,
                number("worst_z"), 100 * number("bias_allowance"), number("chi2_per_voxel_without_allowance"),
                number("chi2_per_voxel_in_quadrature"), 100 * number("bias_in_quadrature"));
        }
    } else {
        text += fmt::format(" at pixel ({}, {})", light["worst"]["pixel"][0].get<int>(),
                            light["worst"]["pixel"][1].get<int>());
    }
    text += '\n';
    return text;
}

}  // namespace

int run(const CompareArguments& arguments, Terminal& terminal) {
    const std::string kind_a = std::filesystem::path(arguments.a).extension(),
                      kind_b = std::filesystem::path(arguments.b).extension();
    if (kind_a != kind_b || (kind_a != ".vdb" && kind_a != ".exr")) {
        throw Error(ErrorCode::Usage, fmt::format("'{}' and '{}' cannot be compared; give two .vdb or two .exr files",
                                                  arguments.a, arguments.b));
    }
    const bool volumes = kind_a == ".vdb";
    if (volumes && !arguments.difference.empty())
        throw Error(ErrorCode::Usage, "--difference is for images; make pictures of the volumes first", "--difference");
    if (!volumes && !arguments.standard_error.empty())
        throw Error(ErrorCode::Usage, "--standard-error is for volumes", "--standard-error");
    if (arguments.most_standard_error && arguments.standard_error.empty())
        throw Error(ErrorCode::Usage, "--most-standard-error chooses voxels by the volume that --standard-error gives",
                    "--most-standard-error");

    OutputSet outputs;
    outputs.reads("A", arguments.a);
    outputs.reads("B", arguments.b);
    if (!arguments.difference.empty()) outputs.writes("the difference", arguments.difference);
    double error = 0;
    const Json result = volumes ? compareVolumes(arguments, terminal, error) : compareImages(arguments, outputs, error);
    // A NaN is further apart than any limit.
    const bool within = !arguments.max_error || error <= *arguments.max_error;
    if (arguments.json) {
        Json document{{"schema", "photic-compare-1"}, {"a", arguments.a}, {"b", arguments.b}};
        document.update(result);
        document["error"] = error;
        document["max_error"] = arguments.max_error ? Json(*arguments.max_error) : Json(nullptr);
        document["within"] = within;
        print(document);
    } else {
        std::fputs(describe(result).c_str(), stdout);
    }
    if (!within) terminal.say(fmt::format("the error {:.4g} is above --max-error {:.4g}", error, *arguments.max_error));
    return within ? 0 : 1;
}

}  // namespace photic::cli
