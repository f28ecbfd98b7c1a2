// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bake/field/light_field.h"
#include "bake/report/bake_report.h"
#include "bake/report/monitor.h"
#include "bake/scene/scene.h"

namespace photic {

enum class OptionType { Flag, Integer, Number, Choice };

/// What the catalogue says of one option of a method: enough for --help, JSON and a Blender property.
struct OptionSpec {
    std::string name;
    OptionType type = OptionType::Number;
    std::string unit;  ///< "voxels", "m", "" ...
    OptionValue default_value;
    double min = 0, max = 0;           ///< inclusive; Integer and Number only
    std::vector<std::string> choices;  ///< Choice only
    std::string help;
};

/// A baked field, its report, and per-voxel standard error where the method knows it.
struct BakeResult {
    LightField field;
    BakeReport report;
    /// Standard error of the mean irradiance per voxel [W/m2], one channel, same leaves; photons only.
    std::optional<LightField> standard_error;
    /// Number of paths that crossed each voxel, one channel; photons only.
    std::optional<LightField> path_count;
    /// The `caustic` grid: one channel, the method's own indicator.
    std::optional<LightField> caustic;
    /// The `arrival_time` grid: one channel [m of optical path].
    std::optional<LightField> arrival_time;
    /// What the method has to say of its grids, without the `photic:` prefix; an empty text removes what the program
    /// would say.
    std::map<std::string, std::string> metadata;
};

/// One row of the catalogue.
struct Method {
    std::string name;
    std::string summary;             ///< one line
    std::vector<std::string> grids;  ///< that it can produce
    std::vector<OptionSpec> options;
    /// Empty when the method can bake the scene, otherwise why not and what can.
    std::string (*refusal)(const Scene&);
    /// @throws Error{Input} for bad options; Error{Cancelled}; Error{Failed}
    BakeResult (*bake)(const Scene&, std::shared_ptr<const NeededVoxels>, const GivenOptions&, Monitor&);
};

/// All methods, in the order in which `auto` tries them.
std::span<const Method> methodCatalogue();

/// The row named `name`, or for "auto" the first that can bake `scene`.
/// @throws Error{Input} with a "did you mean" for unknown names, and with every refusal when none fits
const Method& chooseMethod(const std::string& name, const Scene& scene);

/// Checks names, types and ranges against the row; used by every method before it reads its options.
/// @throws Error{Input} naming the option's place, value, range and the nearest known name
void validateOptions(const Method& method, const GivenOptions& given);

}  // namespace photic
