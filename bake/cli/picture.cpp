// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <utility>

#include "bake/cli/another_scene.h"
#include "bake/cli/bake_plan.h"
#include "bake/cli/verbs.h"
#include "bake/field/scene_grid.h"
#include "bake/file/output_set.h"
#include "bake/image/atomic_file.h"
#include "bake/image/colour_map.h"
#include "bake/picture/display.h"
#include "bake/picture/picture_names.h"
#include "bake/picture/receiver_picture.h"
#include "bake/picture/view_picture.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"

namespace photic::cli {

namespace {

namespace fs = std::filesystem;

// Display white of receiver pictures, in units of the light across the beam: focused light is several times brighter,
// and unfocused light should not be black.
constexpr double kWhiteOverReference = 3.0;
// Bars and exposures leave out the brightest voxels: a caustic's peak would make the rest dark.
constexpr double kTopPercentile = 0.99;

/// One volume with the scene of its frame.
struct Shot {
    Scene scene;
    LightVolume volume;
    std::string stem;
};

/// What is left of a shot once its images are made.
struct Taken {
    std::string stem;
    double reference_irradiance = 1;
};

/// Something that is pictured: how an image of it is made, and how it is displayed.
struct Subject {
    std::string name;  ///< as it stands in file names
    std::function<Image(const Shot&)> make;
    bool view = false;            ///< filmic radiance instead of irradiance
    bool linear_display = false;  ///< also a plain linear PNG (receivers)
    int enlarge_to = 0;           ///< pixels of the shorter side; 0: as it is
};

int axisNamed(char letter) { return letter - 'x'; }

ColourMap colourMapNamed(const std::string& name) {
    const auto& names = colourMapNames();
    return static_cast<ColourMap>(std::find(names.begin(), names.end(), name) - names.begin());
}

glm::dvec3 parsePoint(const std::string& text, const char* option) {
    glm::dvec3 p{0};
    int used = 0;
    if (std::sscanf(text.c_str(), "%lf,%lf,%lf%n", &p.x, &p.y, &p.z, &used) != 3 ||
        used != static_cast<int>(text.size())) {
        throw Error(ErrorCode::Usage, fmt::format("'{}' is no point; write {}=x,y,z in metres", text, option), option);
    }
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
        throw Error(ErrorCode::Usage, fmt::format("'{}' is not finite; write {}=x,y,z in metres", text, option),
                    option);
    return p;
}

ViewSettings viewSettings(const PictureArguments& arguments, const Scene& scene) {
    ViewSettings view = defaultView(scene);
    if (!arguments.eye.empty()) view.eye = parsePoint(arguments.eye, "--eye");
    if (!arguments.target.empty()) view.target = parsePoint(arguments.target, "--target");
    if (arguments.field_of_view_deg) view.field_of_view_deg = *arguments.field_of_view_deg;
    if (!arguments.size.empty()) {
        int used = 0;
        const bool pair = std::sscanf(arguments.size.c_str(), "%5dx%5d%n", &view.width, &view.height, &used) == 2;
        if (!pair || used != static_cast<int>(arguments.size.size()) || std::min(view.width, view.height) < 1 ||
            std::max(view.width, view.height) > 16384) {
            throw Error(ErrorCode::Usage,
                        fmt::format("'{}' is no size; write --size 960x640, at most 16384 a side", arguments.size),
                        "--size");
        }
    }
    view.samples = arguments.samples;
    view.tile_size = arguments.tile_size;
    view.shaft_scattering = arguments.shafts;
    view.shaft_anisotropy = arguments.shaft_anisotropy;
    view.show_surface = arguments.show_surface;
    if (arguments.look == "natural") {
        view.look = ViewLook::Natural;
        // Only the top is open: look down into it.
        const glm::dvec3 back = view.eye - view.target;
        const double distance = glm::length(back);
        if (arguments.eye.empty())
            view.eye =
                view.target + distance * glm::normalize(glm::dvec3(back.x, back.y, 1.3 * std::hypot(back.x, back.y)));
    }
    return view;
}

/// "z=-0.5": the axis, and the world coordinate of the layer's centre.
std::pair<int, double> parseSlice(const std::string& text) {
    char letter = 0;
    double place = 0;
    int used = 0;
    const bool fits =
        std::sscanf(text.c_str(), "%c=%lf%n", &letter, &place, &used) == 2 && used == static_cast<int>(text.size());
    if (!fits || letter < 'x' || letter > 'z' || !std::isfinite(place)) {
        throw Error(ErrorCode::Usage, fmt::format("'{}' is no slice; write for instance --slice z=-0.5", text),
                    "--slice");
    }
    return {axisNamed(letter), place};
}

/// The layer of voxels at a world coordinate, seen from the middle of the grid (sheared grids lean).
int layerAt(const GridFrame& frame, int axis, double place) {
    glm::dvec3 world = frame.worldFromIndex(0.5 * glm::dvec3(frame.min + frame.max));
    world[axis] = place;
    const double index = frame.indexFromWorld(world)[axis];
    const double low = frame.min[axis], high = frame.max[axis];
    if (!(index >= low - 0.5 && index <= high + 0.5)) {
        const char letter = static_cast<char>('x' + axis);
        glm::dvec3 first = 0.5 * glm::dvec3(frame.min + frame.max), last = first;
        first[axis] = low, last[axis] = high;
        throw Error(ErrorCode::Usage,
                    fmt::format("{} = {} m lies outside of the volume, which reaches from {:.4g} to {:.4g} m", letter,
                                place, frame.worldFromIndex(first)[axis], frame.worldFromIndex(last)[axis]),
                    "--slice");
    }
    return static_cast<int>(std::lround(std::clamp(index, low, high)));
}

/// Height of a pixel over its width in a picture across `axis`.
double pixelAspect(const GridFrame& frame, int axis) {
    const auto& m = frame.worldFromIndex();
    const int right = axis == 0 ? 1 : 0, up = axis == 2 ? 1 : 2;
    return std::fabs(m[up][up] / m[right][right]);
}

std::vector<Subject> chooseSubjects(const PictureArguments& arguments, const Scene& scene) {
    std::vector<Subject> subjects;
    const bool asked =
        !arguments.receivers.empty() || !arguments.slices.empty() || !arguments.xrays.empty() || arguments.view_only;
    auto receivers = arguments.receivers, xrays = arguments.xrays;
    if (!asked) {
        receivers = receiverNames(scene);
        xrays = {"y"};
    }
    for (const std::string& name : receivers) {
        const int resolution = arguments.resolution;
        const auto known = receiverNames(scene);
        // Refuses unknown names before any work.
        if (std::find(known.begin(), known.end(), name) == known.end()) receiverFrame(scene, name, resolution);
        subjects.push_back({receiverFileName(name, known),
                            [name, resolution](const Shot& shot) {
                                return receiverPicture(shot.volume, shot.scene, name, resolution);
                            },
                            false, true, 0});
    }
    for (const std::string& text : arguments.slices) {
        const auto [axis, place] = parseSlice(text);
        std::string spaceless = text;
        std::erase_if(spaceless, [](unsigned char c) { return std::isspace(c) != 0; });
        subjects.push_back({"slice_" + spaceless,
                            [axis = axis, place = place](const Shot& shot) {
                                const GridFrame& frame = shot.volume.field.frame();
                                const Image image = slicePicture(shot.volume, axis, layerAt(frame, axis, place));
                                return pixelAspect(frame, axis) == 1 ? image
                                                                     : enlarge(image, 0, pixelAspect(frame, axis));
                            },
                            false, false, arguments.resolution});
    }
    for (const std::string& letter : xrays) {
        const int axis = axisNamed(letter[0]);
        subjects.push_back({"xray_" + letter,
                            [axis](const Shot& shot) {
                                const double aspect = pixelAspect(shot.volume.field.frame(), axis);
                                const Image image = xrayPicture(shot.volume, axis);
                                return aspect == 1 ? image : enlarge(image, 0, aspect);
                            },
                            false, false, arguments.resolution});
    }
    if (arguments.view || arguments.view_only) {
        subjects.push_back({"view",
                            [&arguments](const Shot& shot) {
                                return viewPicture(shot.scene, shot.volume, viewSettings(arguments, shot.scene));
                            },
                            true, false, 0});
    }
    if (subjects.empty()) throw Error(ErrorCode::Input, "nothing to picture", scene.file);
    // What was asked for twice is pictured once.
    std::vector<Subject> each;
    for (Subject& subject : subjects) {
        const auto same = [&](const Subject& other) { return other.name == subject.name; };
        if (std::none_of(each.begin(), each.end(), same)) each.push_back(std::move(subject));
    }
    return each;
}

Shot loadShot(const PictureArguments& arguments, const std::string& path, Terminal& terminal) {
    LightVolume volume = readVdb(path);
    Shot shot{loadScene(arguments.scene, frameOf(volume).value_or(0), terminal), std::move(volume),
              fs::path(path).stem().string()};
    warnOfAnotherScene(shot.scene, shot.volume, path, terminal);
    return shot;
}

/// The value that the brightest of some images should be shown at.
double commonTop(const std::vector<Image>& images, double fraction) {
    double top = 0;
    for (const Image& image : images) top = std::max(top, percentile(image, fraction));
    return top;
}

/// The files of one run: pictures beside one another, or strips of them.
class Album {
public:
    Album(const PictureArguments& arguments, OutputSet& outputs)
        : arguments_(arguments), outputs_(outputs), map_(colourMapNamed(arguments.colour_map)) {}

    /// Names the files of all subjects, before any is made.
    void claim(const std::vector<Subject>& subjects, const std::string& stem) {
        for (const Subject& subject : subjects) {
            const std::string role = fmt::format("the picture '{}'", subject.name), base = baseOf(subject, stem);
            if (!arguments_.film_strip) outputs_.writes(role, base + ".exr");
            if (!subject.view) outputs_.writes(role, base + "_map.png");
            if (subject.view || subject.linear_display) outputs_.writes(role, base + ".png");
        }
    }

    /// Writes all pictures of one subject from the images of every shot.
    void add(const Subject& subject, const std::vector<Image>& images, const std::vector<Taken>& shots) {
        std::vector<Image> mapped, linear;
        const double top = arguments_.max.value_or(niceCeiling(commonTop(images, kTopPercentile)));
        const double radiance_top = subject.view ? commonTop(images, 0.97) : 0;
        for (std::size_t i = 0; i < images.size(); ++i) {
            const Image shown = subject.enlarge_to > 0 ? enlarge(images[i], subject.enlarge_to) : images[i];
            if (subject.view) {
                linear.push_back(displayFilmic(images[i], 0.65 * arguments_.exposure / std::max(radiance_top, 1e-30)));
            } else {
                mapped.push_back(displayMapped(shown, map_, 0, top, "W/m2"));
                if (subject.linear_display)
                    linear.push_back(displayLinear(
                        shown, kWhiteOverReference * shots[i].reference_irradiance / arguments_.exposure));
            }
        }
        const std::string base = baseOf(subject, shots.front().stem);
        if (arguments_.film_strip) {
            std::vector<std::string> captions;
            for (const Taken& shot : shots) captions.push_back(shot.stem);
            for (std::vector<Image>* strip : {&linear, &mapped})
                if (!strip->empty()) *strip = {filmStrip(*strip, captions, arguments_.columns)};
        } else {
            write(base + ".exr", encodeExr(base + ".exr", images.front()));
        }
        if (!mapped.empty()) write(base + "_map.png", encodePng(base + "_map.png", mapped.front()));
        if (!linear.empty()) write(base + ".png", encodePng(base + ".png", linear.front()));
    }

    /// Renames all pictures together, and says their names.
    void finish(Terminal& terminal) {
        outputs_.commit();
        for (const std::string& file : files_) terminal.say(file);
    }

private:
    std::string baseOf(const Subject& subject, const std::string& stem) const {
        const std::string name = arguments_.film_strip
                                     ? fs::path(arguments_.scene).stem().string() + "_" + subject.name + "_strip"
                                     : stem + "_" + subject.name;
        return (fs::path(arguments_.directory) / name).string();
    }
    void write(const std::string& path, const std::string& bytes) {
        outputs_.write(path, bytes);
        files_.push_back(path);
    }

    const PictureArguments& arguments_;
    OutputSet& outputs_;
    std::vector<std::string> files_;
    ColourMap map_;
};

}  // namespace

int run(const PictureArguments& arguments, Terminal& terminal) {
    if (arguments.volumes.size() > 1 && !arguments.film_strip) {
        throw Error(ErrorCode::Usage,
                    fmt::format("{} volumes were given; several are for --film-strip", arguments.volumes.size()));
    }
    OutputSet outputs;
    outputs.reads("the scene", arguments.scene);
    outputs.reads("the volume", arguments.volumes);
    terminal.progress("read", 0);
    Album album(arguments, outputs);
    std::vector<Taken> taken;
    std::vector<Subject> subjects;
    std::vector<std::vector<Image>> images;
    // One scene and one volume at a time are in memory.
    for (const std::string& path : arguments.volumes) {
        terminal.checkCancelled();
        const FilesRead files;
        const Shot shot = loadShot(arguments, path, terminal);
        outputs.reads("a file of the scene", files.paths());
        if (subjects.empty()) {
            subjects = chooseSubjects(arguments, shot.scene);
            images.resize(subjects.size());
            album.claim(subjects, shot.stem);
        }
        for (std::size_t s = 0; s < subjects.size(); ++s) {
            terminal.checkCancelled();
            terminal.progress("picture", static_cast<double>(s) / static_cast<double>(subjects.size()));
            images[s].push_back(subjects[s].make(shot));
        }
        taken.push_back({shot.stem, shot.volume.reference_irradiance});
    }
    for (std::size_t s = 0; s < subjects.size(); ++s) {
        album.add(subjects[s], images[s], taken);
        images[s].clear();
    }
    album.finish(terminal);
    return 0;
}

}  // namespace photic::cli
