// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bake/baker/bake_tile.h"
#include "bake/cli/terminal.h"
#include "bake/file/nvdb.h"
#include "bake/file/vdb.h"

namespace photic::cli {

struct FrameRange {
    int first = 0, last = 0;  ///< inclusive
};

struct BakeArguments {
    std::string scene;
    std::string output;  ///< empty: the scene's name with .vdb, in the current directory
    std::optional<FrameRange> frames;
    std::optional<Tile> tile;
    bool dry_run = false, force = false, json = false;
    std::string report_file;
    std::string standard_error_file;
    VdbOptions file;
    // Settings that replace the scene's.
    std::vector<std::string> set;  ///< METHOD.OPTION=VALUE
    std::optional<std::string> method, where, paths;
    std::optional<double> voxel_size, tolerance;
    std::optional<int> resolution, quadrature, lobes;
    std::optional<bool> prefilter;
    std::string measure = "quick";  ///< of kMeasureNames: look-ups on receivers
    std::string error;              ///< share or per cent that look-ups may be off by; empty: what the scene says
    std::optional<double> budget;   ///< [MB]
    std::optional<double> seconds;  ///< [s]
    std::optional<double> detail;   ///< [m] that they are measured on
    std::vector<std::string> grids;
    std::vector<std::string> post;  ///< steps on the caustic grid (post_steps.h)
};

struct MergeArguments {
    std::vector<std::string> tiles;
    std::string output;
    bool json = false;
};

struct PostArguments {
    std::string volume, output;
    std::vector<std::string> steps;
    bool as_light = false;
    VdbOptions file;
};

struct InspectArguments {
    std::string volume;
    bool json = false, strict = false;
};

struct CompareArguments {
    std::string a, b;  ///< b is the reference
    std::optional<double> max_error;
    std::string standard_error;  ///< a volume whose irradiance is the standard error of b
    double bias_allowance = 0.005;
    std::optional<double> most_standard_error;  ///< share of b's light that scored voxels may have at most
    std::string difference;                     ///< PNG of a - b, images only
    bool json = false;
};

struct PictureArguments {
    std::string scene;
    std::vector<std::string> volumes;
    std::string directory = ".";
    std::vector<std::string> receivers, slices, xrays;
    int resolution = 512;
    double exposure = 1;
    std::optional<double> max;  ///< [W/m2] top of the colour bar
    std::string colour_map = "magma";
    bool film_strip = false;
    int columns = 4;
    bool view = false;  ///< beside the other pictures
    bool view_only = false;
    std::string eye, target, size;
    std::optional<double> field_of_view_deg, shafts, shaft_anisotropy;
    double tile_size = 0;
    int samples = 2;
    bool show_surface = true;
    std::string look = "cutaway";
};

/// How an .nvdb holds what goes to a GPU: half floats, blocks of BC6H, or whichever has the smaller error in a budget.
enum class ExportBodies { Sharp, Samples };
enum class ExportTexels { None, Bc6h, Auto };

struct ExportArguments {
    std::vector<std::string> volumes;  ///< several: frames of a sequence, laid out alike
    std::string output;                ///< its extension says the format
    std::string web;                   ///< the folder of a page instead
    bool shared_script = false;        ///< the page's own script beside that folder, not in it
    bool l1 = false;                   ///< harmonics of what faces get, instead of flux and irradiance
    std::optional<NvdbPrecision> precision;
    std::optional<NvdbCodec> codec;
    std::optional<double> budget_mb;       ///< of memory in a game
    int levels = 2;                        ///< of voxels that the budget may use at once, of an .nvdb
    std::optional<ExportTexels> compress;  ///< of an .nvdb; nothing: half floats
    std::string scene;                     ///< where the receivers are, for the budget and the page
    std::string box;                       ///< x,y,z,x,y,z [m]: what dense files hold, instead of the voxels with light
    /// All volumes of the sequence of which `volumes` are a part, for what its files share; empty: they are all.
    std::vector<std::string> sequence;
    std::optional<double> voxel_size;    ///< [m] of formulas in an .ivol; absent: the scene's
    std::optional<ExportBodies> bodies;  ///< of an .ivol; nothing: sharp
    bool json = false;
};

struct SampleArguments {
    std::vector<std::string> volumes;  ///< with the points last, where they stand behind several volumes
    std::string points;
    std::string output;                ///< empty or "-": stdout
    std::optional<FrameRange> frames;  ///< of names with ####
    bool json = false;
};

struct SceneArguments {
    std::string gltf, output;
};

struct VoxeliseArguments {
    std::string input, output;
    std::optional<double> ior, voxel_size;
    std::optional<double> smooth;    ///< [voxels]
    std::vector<double> absorption;  ///< [1/m]: none, one, or three
};

struct MethodsArguments {
    bool json = false;
};

/// What follows `view`, as it is: photic-view parses it.
struct ViewArguments {
    std::vector<std::string> arguments;
};

/// A verb with its arguments. Returns the exit code; failures are thrown as photic::Error.
using VerbRun = std::function<int(Terminal&)>;

// Each runs one verb and returns its exit code; failures are thrown as photic::Error.
int run(const BakeArguments& arguments, Terminal& terminal);
int run(const SceneArguments& arguments, Terminal& terminal);
int run(const InspectArguments& arguments, Terminal& terminal);
int run(const CompareArguments& arguments, Terminal& terminal);
int run(const PictureArguments& arguments, Terminal& terminal);
int run(const ExportArguments& arguments, Terminal& terminal);
int run(const SampleArguments& arguments, Terminal& terminal);
int run(const VoxeliseArguments& arguments, Terminal& terminal);
int run(const MethodsArguments& arguments, Terminal& terminal);
int run(const PostArguments& arguments, Terminal& terminal);
int run(const MergeArguments& arguments, Terminal& terminal);
/// Becomes photic-view; returns only by throwing.
int run(const ViewArguments& arguments, Terminal& terminal);

}  // namespace photic::cli
