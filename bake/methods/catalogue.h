// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
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

/// What a method makes: a field, and grids beside it where it knows them.
struct BakeResult {
    LightField field;
    /// What only the method knows: ledgers, counts, seconds of its stages, what it skipped. bakeScene adds the rest.
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
    /// Light that travels against `BakeSettings::lobe_axis`, where that is given and the method keeps it apart; `field`
    /// holds the rest.
    std::optional<LightField> second = {};
};

/// What is asked of a cost: all of it, or only the bytes, of which a bound will do that needs no look at the light.
enum class CostAsked { Everything, MostBytes };

/// What the cost of a bake depends on.
struct CostQuestion {
    const Scene& scene;
    const GridFrame& frame;
    double needed_voxels;
    const GivenOptions& options;  ///< checked against the row
    CostAsked asked = CostAsked::Everything;
};

/// A stage of a bake: what `Monitor::progress` calls it, and how long it is expected to take.
struct Stage {
    std::string name;
    double seconds = 0;
};

/// What a method is expected to take for a bake.
struct MethodCost {
    /// One after the other, as its progress names them; seconds of one thread of a 2.6 GHz server core.
    std::vector<Stage> stages;
    double bytes = 0;  ///< of memory, besides the field that comes out
    /// The setting that takes most of the time and what would be quicker; empty where none stands out.
    std::string dearest;
};

/// Whether a method knows how far off its voxels are.
enum class StandardError { Unknown, PerVoxel };

/// One row of the catalogue: all that the rest of the program knows of a method.
struct Method {
    std::string name;
    std::string summary;  ///< one line
    /// That it can make, of `kGrids`. Every method's volume may have `density` besides, which belongs to the scene.
    std::vector<std::string> grids;
    std::vector<OptionSpec> options;
    /// Empty when the method can bake the scene, otherwise why not and what can. Grids that it does not make are
    /// refused by chooseMethod.
    std::string (*refusal)(const Scene&);
    MethodCost (*cost)(const CostQuestion&);
    /// @throws Error{Input} for bad options; Error{Cancelled}; Error{Failed}
    BakeResult (*bake)(const Scene&, std::shared_ptr<const NeededVoxels>, const GivenOptions&, Monitor&);
    StandardError standard_error = StandardError::Unknown;
    /// How far [voxels] beyond a tile light must be known for what is in the tile, besides the tubes or paths that
    /// cross it: a blur's reach. Negative where the scene or the options need the whole box at once; null: the method
    /// does.
    int (*tile_reach)(const Scene&, const GridFrame&, const GivenOptions&) = nullptr;
};

/// All methods, in the order in which `auto` tries them.
std::span<const Method> methodCatalogue();

/// The row named `name`, or null.
const Method* findMethod(const std::string& name);
std::vector<std::string> catalogueNames();

/// The row named `name`, or for "auto" the first that can bake `scene`.
/// @throws Error{Input} with a "did you mean" for unknown names, and with every refusal when none fits
const Method& chooseMethod(const std::string& name, const Scene& scene);

/// All grids that a volume by the method may have: its own, and the scene's `density`.
std::vector<std::string> gridsOf(const Method& method);

/// The options that a scene gives a method, in its table [bake.NAME] or on the command line.
const GivenOptions& givenOptions(const Scene& scene, const Method& method);

/// Checks every table [bake.NAME] of a scene: that there is such a method, and as validateOptions.
/// @throws Error{Input}
void checkMethodTables(const Scene& scene);

/// Checks names, types and ranges against the row; used by every method before it reads its options.
/// @throws Error{Input} naming the option's place, value, range and the nearest known name
void validateOptions(const Method& method, const GivenOptions& given);

}  // namespace photic
