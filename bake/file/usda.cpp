// SPDX-License-Identifier: Apache-2.0
#include "bake/file/usda.h"

#include <fmt/format.h>

#include <cctype>
#include <glm/common.hpp>
#include <limits>

namespace photic {
namespace {

/// A name as USD takes it: letters, digits and underscores, and no digit first.
std::string identifier(const std::string& name) {
    std::string out;
    for (const char c : name) out += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
    if (out.empty() || std::isdigit(static_cast<unsigned char>(out[0])) != 0) out = fmt::format("_{}", out);
    return out;
}

std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
    return out + '"';
}

/// A path between at signs; three of them where it holds one.
std::string asset(const std::string& path) {
    const std::string at = path.find('@') == std::string::npos ? "@" : "@@@";
    return at + path + at;
}

struct Grid {
    std::string name;
    bool vector = false, colour = false;
};

std::vector<Grid> gridsOf(const LightVolume& volume) {
    std::vector<Grid> grids;
    const bool coloured = volume.field.channels().irradiance == 3;
    if (volume.has_irradiance) grids.push_back({"irradiance", coloured, coloured});
    if (volume.has_direction) grids.push_back({"direction", true, false});
    if (volume.second) {
        grids.push_back({"irradiance_2", coloured, coloured});
        grids.push_back({"direction_2", true, false});
    }
    for (const auto& [name, field] : volume.scalars) grids.push_back({name});
    return grids;
}

/// Corners of the voxels that the volume holds [m].
std::string extentOf(const GridFrame& frame) {
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 index(corner & 1 ? frame.max.x + 0.5 : frame.min.x - 0.5,
                               corner & 2 ? frame.max.y + 0.5 : frame.min.y - 0.5,
                               corner & 4 ? frame.max.z + 0.5 : frame.min.z - 0.5);
        low = glm::min(low, frame.worldFromIndex(index)), high = glm::max(high, frame.worldFromIndex(index));
    }
    return fmt::format("[({:.9g}, {:.9g}, {:.9g}), ({:.9g}, {:.9g}, {:.9g})]", low.x, low.y, low.z, high.x, high.y,
                       high.z);
}

std::string gridText(const Grid& grid, const std::vector<UsdFrame>& frames) {
    std::string file;
    if (frames.size() == 1) {
        file = fmt::format("            asset filePath = {}\n", asset(frames[0].file));
    } else {
        file = "            asset filePath.timeSamples = {\n";
        for (const UsdFrame& frame : frames)
            file += fmt::format("                {}: {},\n", frame.frame, asset(frame.file));
        file += "            }\n";
    }
    return fmt::format(
        "        def OpenVDBAsset \"{0}\"\n        {{\n{1}            token fieldName = \"{0}\"\n"
        "            token fieldClass = \"fogVolume\"\n            token fieldDataType = \"{2}\"\n"
        "            token vectorDataRoleHint = \"{3}\"\n        }}\n",
        grid.name, file, grid.vector ? "float3" : "float",
        grid.colour   ? "Color"
        : grid.vector ? "Vector"
                      : "None");
}

}  // namespace

std::string usdaLayer(const std::string& name, const LightVolume& first, const std::vector<UsdFrame>& frames,
                      double frames_per_second) {
    const std::string prim = identifier(name);
    std::string text = fmt::format(
        "#usda 1.0\n(\n    defaultPrim = \"{}\"\n"
        "    doc = \"Light baked by Photic. irradiance times reference_irradiance is in W/m2; direction is the mean "
        "direction of travel along the world's axes, at most 1 long, not normalised; a face with the unit normal n "
        "gets "
        "max(0, -dot(n, direction)) of it, and the same of irradiance_2 and direction_2 where they are.\"\n    "
        "metersPerUnit = 1\n    upAxis = \"Z\"\n",
        prim);
    if (frames.size() > 1)
        text += fmt::format("    startTimeCode = {}\n    endTimeCode = {}\n    timeCodesPerSecond = {:.9g}\n",
                            frames.front().frame, frames.back().frame, frames_per_second);
    text += fmt::format(")\n\ndef Volume \"{}\" (\n    customData = {{\n        dictionary photic = {{\n", prim);
    text += fmt::format("            double reference_irradiance = {:.9g}\n", first.reference_irradiance);
    // The rest is text, as the volume has it: what follows a key's name may be anything.
    for (const auto& [key, value] : first.metadata)
        if (key != "reference_irradiance")
            text += fmt::format("            string {} = {}\n", identifier(key), quoted(value));
    text += fmt::format("        }}\n    }}\n)\n{{\n    float3[] extent = {}\n", extentOf(first.field.frame()));
    const std::vector<Grid> grids = gridsOf(first);
    for (const Grid& grid : grids) text += fmt::format("    rel field:{0} = </{1}/Grids/{0}>\n", grid.name, prim);
    text += "\n    def Scope \"Grids\"\n    {\n";
    for (const Grid& grid : grids) text += gridText(grid, frames);
    return text + "    }\n}\n";
}

}  // namespace photic
