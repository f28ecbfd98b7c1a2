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
    for (const Source s :
         {Source::BakedA, Source::BakedB, Source::CausticMap, Source::Lookup, Source::WarpedVolumes, Source::None}) {
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

}  // namespace

std::optional<Options> parseOptions(int argc, const char* const* argv) {
    CLI::App app{"Shows light volumes, and water that nobody baked, as a game would.", "photic view"};
    app.footer(
        "In the window: drag turns, the wheel comes nearer, the right button drags the ball, Shift shifts the view,\n"
        "space plays frames. Without a screen, --screenshot still works.");
    Options o;
    std::vector<std::string> files;
    std::string size, frames, eye, target, ball;
    Source left = Source::BakedA, right = Source::BakedA;
    float split = 0.5f, ambient = 0, field_of_view = 0, scattering = 0, anisotropy = 0;
    bool no_surface = false;
    app.add_option("FILES", files,
                   "A scene (.toml), one or two volumes (.vdb, .nvdb; #### is the frame), or both; and what is seen "
                   "through: .ivol")
        ->required();
    app.add_option("--screenshot", o.screenshot, "Write one picture (.png) instead of opening a window");
    app.add_option("--size", size, "Pixels, for instance 1280x800");
    app.add_option("--supersample", o.supersample, "Of a screenshot, a side")->check(CLI::Range(1, 4));
    app.add_option("--frames", frames, "Of #### in file names and of moving water: 7 or 1-48");
    const auto names = CLI::CheckedTransformer(sources(), CLI::ignore_case);
    auto* left_option = app.add_option("--left", left, "What lights the left half")->transform(names);
    auto* right_option = app.add_option("--right", right, "What lights the right half, or all of it")->transform(names);
    auto* split_option =
        app.add_option("--split", split, "Part of the width that the left half takes")->check(CLI::Range(0.0, 1.0));
    app.add_option("--eye", eye, "Camera [m], for instance -3,-4,2");
    app.add_option("--target", target, "What the camera looks at [m]");
    auto* view_option =
        app.add_option("--fov", field_of_view, "Field of view of the height [degrees]")->check(CLI::Range(1.0, 150.0));
    auto* shaft_option = app.add_option("--shafts", scattering, "Scattering of the water [1/m], instead of the scene's")
                             ->check(CLI::Range(0.0, 1e3));
    auto* g_option =
        app.add_option("--shafts-g", anisotropy, "Its Henyey-Greenstein g")->check(CLI::Range(-0.99, 0.99));
    app.add_option("--ball", ball, "Receiver to drag: centre and radius [m], for instance 0,0,-0.5,0.2");
    app.add_option("--environment", o.environment, "Around objects: a panorama (.exr) instead of a studio");
    app.add_option("--turn", o.turn_deg, "Of the environment about z [degrees]")->check(CLI::Range(-360.0, 360.0));
    app.add_option("--exposure", o.exposure, "Brightness")->check(CLI::Range(1e-3, 1e3));
    auto* ambient_option =
        app.add_option("--ambient", ambient, "Skylight over the reference irradiance")->check(CLI::Range(0.0, 10.0));
    app.add_option("--tiles", o.tile_size, "Size of tiles on receivers [m]")->check(CLI::Range(0.0, 1e6));
    app.add_option("--frames-to-draw", o.frames_to_draw, "Close the window after so many (for tests)");
    app.add_flag("--no-surface", no_surface, "Do not show the water's surface");
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& help) {
        app.exit(help);
        return std::nullopt;
    } catch (const CLI::ParseError& error) {
        throw Error(ErrorCode::Usage, fmt::format("{}; see photic view --help", error.what()));
    }
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
    int used = 0;
    if (!size.empty() && (std::sscanf(size.c_str(), "%5dx%5d%n", &o.width, &o.height, &used) != 2 ||
                          used != static_cast<int>(size.size()) || o.width < 16 || o.height < 16 || o.width > 16384 ||
                          o.height > 16384)) {
        throw Error(ErrorCode::Usage, fmt::format("'{}' is no size from 16x16 to 16384x16384; write 1280x800", size),
                    "--size");
    }
    if (!frames.empty()) {
        const bool pair = std::sscanf(frames.c_str(), "%7d-%7d%n", &o.first_frame, &o.last_frame, &used) == 2;
        if (!pair) {
            if (std::sscanf(frames.c_str(), "%7d%n", &o.first_frame, &used) != 1) used = -1;
            o.last_frame = o.first_frame;
        }
        if (used != static_cast<int>(frames.size()) || o.first_frame < 0 || o.last_frame < o.first_frame) {
            throw Error(ErrorCode::Usage, fmt::format("'{}' is no range of frames; write 1-48 or 7", frames),
                        "--frames");
        }
    }
    if (*left_option) o.left = left;
    if (*right_option) o.right = right;
    if (*split_option) o.split = split;
    o.eye = place(eye, "--eye"), o.target = place(target, "--target");
    if (*view_option) o.field_of_view_deg = field_of_view;
    if (*ambient_option) o.ambient = ambient;
    if (*shaft_option) o.scattering = scattering;
    if (*g_option) o.anisotropy = anisotropy;
    if (!ball.empty()) {
        const auto v = numbers(ball, 4, "--ball");
        o.ball = glm::vec4(v[0], v[1], v[2], v[3]);
    }
    o.surface = !no_surface;
    return o;
}

}  // namespace photic::viewer
