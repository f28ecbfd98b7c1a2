// SPDX-License-Identifier: Apache-2.0
#include "runtime/viewer/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <map>

#include "bake/report/error.h"

namespace photic::viewer {
namespace {

std::map<std::string, Source> sources() {
    std::map<std::string, Source> out;
    for (const Source s : {Source::BakedA, Source::BakedB, Source::LiveBake, Source::CausticMap, Source::Lookup,
                           Source::WarpedVolumes, Source::None}) {
        std::string name = kSourceNames[static_cast<int>(s)];
        std::replace(name.begin(), name.end(), ' ', '-');
        out[name] = s;
    }
    return out;
}

/// "1,2,3" as numbers.
std::vector<float> numbers(const std::string& text, std::size_t count, const std::string& option) {
    std::vector<float> out;
    std::size_t from = 0;
    while (from <= text.size()) {
        const std::size_t end = std::min(text.find(',', from), text.size());
        const std::string part = text.substr(from, end - from);
        float value = 0;
        int used = 0;
        if (std::sscanf(part.c_str(), "%f%n", &value, &used) != 1 || used != static_cast<int>(part.size()) ||
            !std::isfinite(value)) {
            break;
        }
        out.push_back(value);
        from = end + 1;
    }
    if (out.size() != count || from != text.size() + 1) {
        throw Error(ErrorCode::Usage, fmt::format("'{}' is not {} numbers with commas between", text, count), option);
    }
    return out;
}

std::optional<glm::vec3> place(const std::string& text, const std::string& option) {
    if (text.empty()) return std::nullopt;
    const auto v = numbers(text, 3, option);
    return glm::vec3(v[0], v[1], v[2]);
}

/// What is given as text, and what only counts where it is given.
struct Given {
    std::vector<std::string> files;
    std::string size, frames, eye, target, ball, light_direction, light_position;
    Source left = Source::BakedA, right = Source::BakedA;
    float split = 0.5f, ambient = 0, field_of_view = 0, scattering = 0, anisotropy = 0;
    bool no_surface = false;
    CLI::Option *left_option, *right_option, *split_option, *view_option, *shaft_option, *g_option, *ambient_option;
};

void bindView(CLI::App& app, Options& o, Given& g) {
    app.add_option("FILES", g.files,
                   "A scene (.toml), one or two volumes (.vdb, .nvdb; #### is the frame), or both; and what is seen "
                   "through: .ivol")
        ->required();
    app.add_option("--screenshot", o.screenshot, "Write one picture (.png) instead of opening a window");
    app.add_option("--size", g.size, "Pixels, for instance 1280x800");
    app.add_option("--supersample", o.supersample, "Of a screenshot, a side")->check(CLI::Range(1, 4));
    app.add_option("--frames", g.frames, "Of #### in file names and of moving water: 7 or 1-48");
    const auto names = CLI::CheckedTransformer(sources(), CLI::ignore_case);
    g.left_option = app.add_option("--left", g.left, "What lights the left half")->transform(names);
    g.right_option = app.add_option("--right", g.right, "What lights the right half, or all of it")->transform(names);
    g.split_option =
        app.add_option("--split", g.split, "Part of the width that the left half takes")->check(CLI::Range(0.0, 1.0));
    app.add_option("--eye", g.eye, "Camera [m], for instance -3,-4,2");
    app.add_option("--target", g.target, "What the camera looks at [m]");
    g.view_option = app.add_option("--fov", g.field_of_view, "Field of view of the height [degrees]")
                        ->check(CLI::Range(1.0, 150.0));
}

void bindSurroundings(CLI::App& app, Options& o, Given& g) {
    g.shaft_option = app.add_option("--shafts", g.scattering, "Scattering of the water [1/m], instead of the scene's")
                         ->check(CLI::Range(0.0, 1e3));
    g.g_option = app.add_option("--shafts-g", g.anisotropy, "Its Henyey-Greenstein g")->check(CLI::Range(-0.99, 0.99));
    app.add_option("--ball", g.ball, "Receiver to drag: centre and radius [m], for instance 0,0,-0.5,0.2");
    app.add_option("--environment", o.environment,
                   "Around objects: a panorama (.exr; #### is the frame) instead of a studio");
    app.add_option("--turn", o.turn_deg, "Of the environment about z [degrees]")->check(CLI::Range(-360.0, 360.0));
    app.add_option("--exposure", o.exposure, "Brightness")->check(CLI::Range(1e-3, 1e3));
    g.ambient_option =
        app.add_option("--ambient", g.ambient, "Skylight over the reference irradiance")->check(CLI::Range(0.0, 10.0));
    app.add_option("--tiles", o.tile_size, "Size of tiles on receivers [m]")->check(CLI::Range(0.0, 1e6));
    app.add_option("--frames-to-draw", o.frames_to_draw, "Close the window after so many (for tests)");
    app.add_flag("--no-surface", g.no_surface, "Do not show the water's surface");
}

void bindBake(CLI::App& app, Options& o, Given& g) {
    app.add_flag("--bake", o.bake, "Bake the scene, beside what is shown, and again when its light is moved");
    app.add_option("--bake-with", o.bake_arguments,
                   "Options of such a bake, for instance '--voxel-size 0.02 --where receivers'");
    app.add_flag("--watch", o.watch, "Bake again whenever the scene or a file that it names changes");
    app.add_option("--light-direction", g.light_direction, "Move a light: where it shines, for instance 0.3,0,-1");
    app.add_option("--light-position", g.light_position, "Move a lamp: where it stands [m]");
    app.add_option("--light", o.light, "Name of the light that is moved (default: the brightest that can be)");
}

/// Tells scenes, volumes and objects apart by their extensions.
void sortFiles(const std::vector<std::string>& files, Options& o) {
    for (const std::string& file : files) {
        const std::string extension = std::filesystem::path(file).extension().string();
        if (extension == ".toml" && o.scene.empty()) {
            o.scene = file;
        } else if ((extension == ".vdb" || extension == ".nvdb") && o.volumes.size() < 2) {
            o.volumes.push_back(file);
        } else if (extension == ".ivol") {
            o.objects.push_back(file);
        } else {
            throw Error(ErrorCode::Usage,
                        "give one scene (.toml), at most two volumes (.vdb, .nvdb), and objects (.ivol)", file);
        }
    }
    if (o.scene.empty() && o.volumes.empty())
        throw Error(ErrorCode::Usage, "give a scene (.toml) or a volume (.vdb, .nvdb) beside the objects");
}

void readSize(const std::string& size, Options& o) {
    int used = 0;
    if (std::sscanf(size.c_str(), "%5dx%5d%n", &o.width, &o.height, &used) != 2 ||
        used != static_cast<int>(size.size()) || o.width < 16 || o.height < 16 || o.width > 16384 || o.height > 16384) {
        throw Error(ErrorCode::Usage, fmt::format("'{}' is no size from 16x16 to 16384x16384; write 1280x800", size),
                    "--size");
    }
}

void readFrames(const std::string& frames, Options& o) {
    int used = 0;
    const bool pair = std::sscanf(frames.c_str(), "%7d-%7d%n", &o.first_frame, &o.last_frame, &used) == 2;
    if (!pair) {
        if (std::sscanf(frames.c_str(), "%7d%n", &o.first_frame, &used) != 1) used = -1;
        o.last_frame = o.first_frame;
    }
    if (used != static_cast<int>(frames.size()) || o.first_frame < 0 || o.last_frame < o.first_frame) {
        throw Error(ErrorCode::Usage, fmt::format("'{}' is no range of frames; write 1-48 or 7", frames), "--frames");
    }
}

/// What was given, into the options.
void take(const Given& g, Options& o) {
    sortFiles(g.files, o);
    if (!g.size.empty()) readSize(g.size, o);
    if (!g.frames.empty()) readFrames(g.frames, o);
    if (*g.left_option) o.left = g.left;
    if (*g.right_option) o.right = g.right;
    if (*g.split_option) o.split = g.split;
    o.eye = place(g.eye, "--eye"), o.target = place(g.target, "--target");
    if (*g.view_option) o.field_of_view_deg = g.field_of_view;
    if (*g.ambient_option) o.ambient = g.ambient;
    if (*g.shaft_option) o.scattering = g.scattering;
    if (*g.g_option) o.anisotropy = g.anisotropy;
    if (!g.ball.empty()) {
        const auto v = numbers(g.ball, 4, "--ball");
        o.ball = glm::vec4(v[0], v[1], v[2], v[3]);
    }
    o.surface = !g.no_surface;
    o.light_direction = place(g.light_direction, "--light-direction");
    o.light_position = place(g.light_position, "--light-position");
    if (!o.environment.empty() && o.objects.empty())
        throw Error(ErrorCode::Usage, "a panorama lies around what is seen through; give its file (.ivol) too",
                    "--environment");
    o.bake = o.bake || o.light_direction || o.light_position;
    if ((o.bake || o.watch) && o.scene.empty())
        throw Error(ErrorCode::Usage, "what is to be baked is a scene; give its file (.toml)",
                    o.watch ? "--watch" : "--bake");
}

}  // namespace

std::optional<Options> parseOptions(int argc, const char* const* argv) {
    CLI::App app{"Shows light volumes, and water that nobody baked, as a game would.", "photic view"};
    app.footer(
        "In the window: drag turns, the wheel comes nearer, the right button drags the ball, Shift shifts the view,\n"
        "space plays frames; with Ctrl it moves the light, and the scene is baked again. Without a screen, "
        "--screenshot\n"
        "still works.");
    Options o;
    Given given;
    bindView(app, o, given);
    bindSurroundings(app, o, given);
    bindBake(app, o, given);
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& help) {
        app.exit(help);
        return std::nullopt;
    } catch (const CLI::ParseError& error) {
        throw Error(ErrorCode::Usage, fmt::format("{}; see photic view --help", error.what()));
    }
    take(given, o);
    return o;
}

}  // namespace photic::viewer
