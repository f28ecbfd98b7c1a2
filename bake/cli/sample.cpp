// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>

#include "bake/baker/version.h"
#include "bake/cli/bake_plan.h"
#include "bake/cli/json.h"
#include "bake/cli/point_table.h"
#include "bake/cli/verbs.h"
#include "bake/file/output_set.h"
#include "bake/image/atomic_file.h"
#include "bake/picture/volume_lookup.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic::cli {
namespace {

constexpr const char* kStdio = "-";

/// Where a point lies in a volume.
enum class Place { Inside, Edge, Dark, Outside };
constexpr const char* kPlaceNames[] = {"inside", "edge", "dark", "outside"};

/// What is known of the light at a point [W/m2]; of one outside nothing is.
struct Sampled {
    Place place = Place::Outside;
    LookedUpLight light;
    glm::dvec3 face_irradiance{0};  ///< on the face that the normal points out of
};

/// The volumes of one run and its points.
struct Request {
    std::vector<std::string> volumes;
    std::string points;  ///< a file, or kStdio
};

Request requestOf(const SampleArguments& arguments) {
    // All that stands on the command line is taken for volumes; the last is the points.
    std::vector<std::string> words = arguments.volumes;
    if (!arguments.points.empty()) words.push_back(arguments.points);
    if (words.size() < 2) {
        throw Error(ErrorCode::Usage,
                    fmt::format("'{}' is a volume or points, and both are wanted: photic sample VOLUME POINTS",
                                words.empty() ? "" : words.front()));
    }
    Request request{{}, words.back()};
    words.pop_back();
    for (const std::string& word : words) {
        if (word == kStdio)
            throw Error(ErrorCode::Usage, "a volume is read from a file; only the points, which stand last, may be -");
        if (std::filesystem::path(word).filename().string().find('#') == std::string::npos) {
            request.volumes.push_back(word);
            continue;
        }
        if (!arguments.frames) {
            throw Error(ErrorCode::Usage,
                        fmt::format("'{}' stands for the volumes of several frames; say which, for instance --frames "
                                    "1-48",
                                    word),
                        "--frames");
        }
        for (int frame = arguments.frames->first; frame <= arguments.frames->last; ++frame)
            request.volumes.push_back(withFrame(word, frame));
    }
    return request;
}

PointTable readPoints(const std::string& source) {
    if (source != kStdio) return parsePoints(readFileBytes(source), source);
    const std::string text{std::istreambuf_iterator<char>(std::cin), {}};
    return parsePoints(text, "stdin");
}

Place placeOf(const LightVolume& volume, const VolumeLookup& lookup, const glm::dvec3& position_world) {
    const double covered = lookup.covered(position_world);
    constexpr double kRounding = 1e-9;  // of eight weights that add up to 1
    if (covered >= 1 - kRounding) return Place::Inside;
    if (covered > 0) return Place::Edge;
    const GridFrame& frame = volume.field.frame();
    const glm::dvec3 index = frame.indexFromWorld(position_world);
    for (int axis = 0; axis < 3; ++axis)
        if (!(index[axis] >= frame.min[axis] - 0.5 && index[axis] <= frame.max[axis] + 0.5)) return Place::Outside;
    return Place::Dark;
}

std::vector<Sampled> sampleAll(const LightVolume& volume, const std::vector<SamplePoint>& points) {
    const VolumeLookup lookup(volume);
    std::vector<Sampled> samples(points.size());
    constexpr std::int64_t kBatch = 1024;  // far more work than handing it to a thread
    const auto count = static_cast<std::int64_t>(points.size());
    parallelFor((count + kBatch - 1) / kBatch, [&](std::int64_t batch) {
        for (std::int64_t i = batch * kBatch; i < std::min(count, (batch + 1) * kBatch); ++i) {
            const SamplePoint& point = points[static_cast<std::size_t>(i)];
            Sampled& sample = samples[static_cast<std::size_t>(i)];
            sample.place = placeOf(volume, lookup, point.position);
            if (sample.place == Place::Outside) continue;
            sample.light = lookup.allAt(point.position);
            if (point.normal) sample.face_irradiance = lookup.receiverIrradiance(point.position, *point.normal);
        }
    });
    return samples;
}

/// What a volume can tell, and how its numbers are written.
struct Columns {
    bool coloured = false, direction = true;
    bool operator==(const Columns&) const = default;
};

/// A number, or nothing where nothing is known.
using Cell = std::optional<double>;

/// The names and values of what is said of a point, in the order of the columns. A volume without direction knows no
/// flux, nor what a face gets of its light.
template <class Body>
void forEachValue(const Sampled& sample, const Columns& columns, bool normals, const Body& body) {
    const bool known = sample.place != Place::Outside, flux = known && columns.direction;
    const auto cell = [](bool there, double value) { return there ? Cell(value) : Cell(); };
    const auto channels = [&](const char* name, bool there, const glm::dvec3& value) {
        constexpr const char* kChannels[] = {"_r", "_g", "_b"};
        if (!columns.coloured) return body(name, cell(there, value.x));
        for (int c = 0; c < 3; ++c) body(fmt::format("{}{}", name, kChannels[c]), cell(there, value[c]));
    };
    channels("irradiance", known, sample.light.irradiance);
    const double mean = sample.light.meanIrradiance();
    constexpr const char* kAxes[] = {"x", "y", "z"};
    for (int axis = 0; axis < 3; ++axis) body(fmt::format("flux_{}", kAxes[axis]), cell(flux, sample.light.flux[axis]));
    for (int axis = 0; axis < 3; ++axis)
        body(fmt::format("direction_{}", kAxes[axis]), cell(flux && mean > 0, sample.light.flux[axis] / mean));
    if (normals) channels("face_irradiance", flux, sample.face_irradiance);
}

/// Where the rows go: stdout, or a file that appears whole.
class Sink {
public:
    Sink(OutputSet& outputs, const std::string& path) : file_(path == kStdio ? nullptr : &outputs.open(path)) {}

    void write(const std::string& text) {
        // A failure of stdout is found by main, which checks it at the end.
        if (!file_) return static_cast<void>(std::fwrite(text.data(), 1, text.size(), stdout));
        try {
            file_->stream().write(text.data(), static_cast<std::streamsize>(text.size()));
        } catch (const std::ios_base::failure&) {
            file_->fail(file_->buffer().failure());
        }
    }
    void finish() {
        if (file_) file_->finish();
    }

private:
    CheckedFile* file_;
};

/// A field of a table as it can stand between commas.
std::string csvField(const std::string& text) {
    if (text.find_first_of(",\"") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + '"';
}

std::string csvHeader(const PointTable& table, const Columns& columns) {
    std::string text = fmt::format(
        "# {}: positions in m, Z up, in the scene's frame; irradiance (of all sides), flux and face_irradiance in "
        "W/m2; "
        "direction is that of travel, at most 1 long\n",
        programName());
    text += "frame,x,y,z";
    if (table.normals) text += ",nx,ny,nz";
    for (const std::string& name : table.carried_names) text += fmt::format(",{}", csvField(name));
    text += ",place";
    forEachValue({}, columns, table.normals, [&](const std::string& name, const Cell&) { text += "," + name; });
    return text + "\n";
}

std::string csvRow(const std::optional<int>& frame, const SamplePoint& point, const Sampled& sample,
                   const Columns& columns) {
    std::string row = frame ? fmt::format("{}", *frame) : std::string();
    for (int axis = 0; axis < 3; ++axis) row += fmt::format(",{}", point.position[axis]);
    if (point.normal)
        for (int axis = 0; axis < 3; ++axis) row += fmt::format(",{:.9g}", (*point.normal)[axis]);
    for (const std::string& field : point.carried) row += fmt::format(",{}", csvField(field));
    row += fmt::format(",{}", kPlaceNames[static_cast<int>(sample.place)]);
    forEachValue(sample, columns, point.normal.has_value(), [&](const std::string&, const Cell& value) {
        row += value ? fmt::format(",{:.9g}", *value) : std::string(",");
    });
    return row + "\n";
}

Json pointJson(const SamplePoint& point, const Sampled& sample, const Columns& columns, const PointTable& table) {
    Json json = {{"position", toJson(point.position)}};
    if (point.normal) json["normal"] = toJson(*point.normal);
    if (!table.carried_names.empty()) {
        json["carried"] = Json::object();
        for (std::size_t i = 0; i < point.carried.size(); ++i)
            json["carried"][table.carried_names[i]] = point.carried[i];
    }
    const bool known = sample.place != Place::Outside, flux = known && columns.direction;
    const auto vector = [](bool there, const glm::dvec3& v) { return there ? toJson(v) : Json(nullptr); };
    const auto channels = [&](bool there, const glm::dvec3& v) {
        return there && !columns.coloured ? Json(v.x) : vector(there, v);
    };
    const double mean = sample.light.meanIrradiance();
    json["place"] = kPlaceNames[static_cast<int>(sample.place)];
    json["irradiance"] = channels(known, sample.light.irradiance);
    json["flux"] = vector(flux, sample.light.flux);
    json["direction"] = vector(flux && mean > 0, sample.light.flux / mean);
    if (point.normal) json["face_irradiance"] = channels(flux, sample.face_irradiance);
    return json;
}

/// The samples of all volumes on their way to the output.
class Report {
public:
    Report(const SampleArguments& arguments, const PointTable& table, OutputSet& outputs)
        : json_(arguments.json), table_(table), outputs_(outputs), output_(outputOf(arguments)) {}

    static std::string outputOf(const SampleArguments& arguments) {
        return arguments.output.empty() ? kStdio : arguments.output;
    }

    /// Samples of one volume. @throws Error{Input} when it holds other grids than those before
    void add(const std::string& path, const LightVolume& volume, Terminal& terminal) {
        begin(path, {volume.field.channels().irradiance == 3, volume.has_direction && volume.field.channels().flux},
              terminal);
        const std::vector<Sampled> samples = sampleAll(volume, table_.points);
        const std::optional<int> frame = frameOf(volume);
        Json points = Json::array();
        for (std::size_t p = 0; p < samples.size(); ++p) {
            outside_ += samples[p].place == Place::Outside ? 1u : 0u;
            if (json_)
                points.push_back(pointJson(table_.points[p], samples[p], *columns_, table_));
            else
                sink_->write(csvRow(frame, table_.points[p], samples[p], *columns_));
        }
        if (json_)
            frames_.push_back({{"volume", path}, {"frame", frame ? Json(*frame) : Json(nullptr)}, {"points", points}});
        samples_ += samples.size();
    }

    /// Ends the output, and tells of points that the volumes say nothing of.
    void finish(Terminal& terminal) {
        if (json_) {
            const Json document = {{"schema", "photic-sample-1"},
                                   {"units", {{"position", "m"}, {"irradiance", "W/m2"}, {"flux", "W/m2"}}},
                                   {"up_axis", "Z"},
                                   {"coloured", columns_->coloured},
                                   {"frames", frames_}};
            sink_->write(dump(document, 2) + "\n");
        }
        sink_->finish();
        if (outside_ == 0) return;
        terminal.warn(
            fmt::format("{} of {} samples lie outside the volume's voxels, where it says nothing: they are "
                        "marked 'outside', and hold no numbers",
                        outside_, samples_));
    }

private:
    void begin(const std::string& path, const Columns& columns, Terminal& terminal) {
        if (columns_ && columns != *columns_) {
            throw Error(ErrorCode::Input,
                        fmt::format("holds other grids than '{}'; sample what was baked alike", first_), path);
        }
        if (columns_) return;
        if (!columns.direction) {
            terminal.warn(
                fmt::format("'{}' has no grid 'direction': flux, direction and what faces get are not known; bake "
                            "with --grids irradiance,direction",
                            path));
        }
        first_ = path;
        columns_ = columns;
        sink_.emplace(outputs_, output_);
        if (!json_) sink_->write(csvHeader(table_, columns));
    }

    bool json_;
    const PointTable& table_;
    OutputSet& outputs_;
    std::string output_, first_;
    std::optional<Columns> columns_;
    std::optional<Sink> sink_;
    Json frames_ = Json::array();
    std::size_t outside_ = 0, samples_ = 0;
};

}  // namespace

int run(const SampleArguments& arguments, Terminal& terminal) {
    const Request request = requestOf(arguments);
    const std::string output = Report::outputOf(arguments);
    OutputSet outputs;
    outputs.reads("the volume", request.volumes);
    if (request.points != kStdio) outputs.reads("the points", request.points);
    if (output != kStdio) outputs.writes("the output", output);
    const PointTable table = readPoints(request.points);
    Report report(arguments, table, outputs);
    for (std::size_t i = 0; i < request.volumes.size(); ++i) {
        terminal.progress("sample", static_cast<double>(i) / static_cast<double>(request.volumes.size()));
        const LightVolume volume = readVdb(request.volumes[i]);
        terminal.checkCancelled();
        report.add(request.volumes[i], volume, terminal);
    }
    report.finish(terminal);
    outputs.commit();
    terminal.progress("sample", 1);
    if (output != kStdio)
        terminal.say(fmt::format("{}: {} points in {} volumes", output, table.points.size(), request.volumes.size()));
    return 0;
}

}  // namespace photic::cli
