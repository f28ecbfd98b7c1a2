// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/wavefront.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>

#include "bake/methods/method_options.h"
#include "bake/methods/wavefront_launch.h"
#include "bake/paths/emission.h"
#include "bake/report/error.h"
#include "bake/scene/graded_index.h"
#include "bake/scene/index_volume.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

using Clock = std::chrono::steady_clock;

const std::vector<OptionBinding<WavefrontOptions>>& wavefrontOptions() {
    static const std::vector<OptionBinding<WavefrontOptions>> bindings{
        bindOption("spacing", &WavefrontOptions::spacing, {0.05, 16}, "voxels",
                   "between the rays of a front where it starts"),
        bindOption("steps", &WavefrontOptions::steps, {1, 8}, "",
                   "of a ray, a layer of voxels; more of themselves where the index changes sharply"),
        bindOption("disc_samples", &WavefrontOptions::disc_samples, {1, 4096}, "",
                   "directions on the sun's disc; 1: a point sun"),
        bindOption("turns", &WavefrontOptions::turns, {0, 1000}, "",
                   "times that light may change the axis along which it is followed"),
        bindOption(
            "spline", &WavefrontOptions::spline,
            {{"auto", WavefrontSpline::Auto}, {"through", WavefrontSpline::Through}, {"plain", WavefrontSpline::Plain}},
            "how samples of the index become smooth: through them, or blurred by 0.58 voxel, which never rings "
            "at jumps; auto goes through smooth ones"),
    };
    return bindings;
}

/// The media of a scene as one channel's fronts see them.
struct Media {
    explicit Media(const Scene& scene) : objects(scene.index->objects()) {}
    const std::vector<GradedObject>& objects;

    bool disperses() const {
        return std::any_of(objects.begin(), objects.end(), [](const auto& o) { return o.index.size() > 1; });
    }
    const GradedIndex& indexOf(const GradedObject& object, int channel) const {
        return *object.index[object.index.size() > 1 ? static_cast<std::size_t>(channel) : 0];
    }
    /// Which object is at a place, the first of several; -1: none.
    int at(const glm::dvec3& world, int channel) const {
        for (std::size_t i = 0; i < objects.size(); ++i)
            if (indexOf(objects[i], channel).contains(world)) return static_cast<int>(i);
        return -1;
    }
    double halfSquare(const glm::dvec3& world, int channel) const {
        const int object = at(world, channel);
        return object < 0 ? 0.5 : indexOf(objects[static_cast<std::size_t>(object)], channel).at(world).half_square;
    }
    /// Mean over a voxel that a medium's rim goes through: samples of a kink at its rim scatter, and made 3.5 % of
    /// noise in the light of a Luneburg lens at any resolution, where means leave 0.1 %. Elsewhere the middle serves.
    double halfSquareOfVoxel(const glm::dvec3& middle, const glm::dvec3& voxel, int channel) const {
        const int object = at(middle, channel);
        bool alike = true;
        for (int corner = 0; corner < 8 && alike; ++corner) {
            const glm::dvec3 way(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
            alike = at(middle + way * voxel, channel) == object;
        }
        if (alike) return halfSquare(middle, channel);
        constexpr int kPoints = 4;
        double sum = 0;
        for (int i = 0; i < kPoints * kPoints * kPoints; ++i) {
            const glm::dvec3 part(i % kPoints, i / kPoints % kPoints, i / (kPoints * kPoints));
            sum += halfSquare(middle + ((part + 0.5) / double(kPoints) - 0.5) * voxel, channel);
        }
        return sum / (kPoints * kPoints * kPoints);
    }
    bool fillTheWorld() const {
        return std::any_of(objects.begin(), objects.end(), [](const auto& object) {
            return std::any_of(object.index.begin(), object.index.end(), [](const auto& i) { return !i->bounds(); });
        });
    }
    bool attenuate() const {
        return std::any_of(objects.begin(), objects.end(),
                           [](const auto& o) { return o.extinction() != glm::dvec3(0); });
    }
};

/// What holds all media, two voxels around them that a spline may blur them over, and the whole grid where one fills
/// the world.
FrontBox boxOf(const Media& media, const GridFrame& frame) {
    FrontBox box;
    for (const GradedObject& object : media.objects)
        for (const auto& index : object.index) {
            const auto bounds = index->bounds();
            if (bounds)
                box.add(frame.indexFromWorld(bounds->min) - 2.0), box.add(frame.indexFromWorld(bounds->max) + 2.0);
            else
                box.add(glm::dvec3(frame.min) - 0.5), box.add(glm::dvec3(frame.max) + 0.5);
        }
    return box;
}

/// The layers that fronts cross: the target's and the grid's.
FrontSpace frontSpace(const FrontBox& target, const GridFrame& frame) {
    FrontSpace space;
    // A voxel reaches half a step around its centre; what ends on its side does not need the next one.
    constexpr double kTouches = 1e-6;
    space.low = glm::min(frame.min, glm::ivec3(glm::floor(target.min + 0.5 + kTouches)));
    space.high = glm::max(frame.max, glm::ivec3(glm::ceil(target.max - 0.5 - kTouches)));
    return space;
}

void layMedia(const Media& media, const GridFrame& frame, int channel, FrontSpace& space) {
    space.media.clear();
    if (!media.attenuate()) return;
    const glm::ivec3 count = space.index->nodes().count;
    space.media.resize(static_cast<std::size_t>(count.x) * static_cast<std::size_t>(count.y) *
                       static_cast<std::size_t>(count.z));
    parallelFor(count.z, [&](std::int64_t z) {
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x) {
                const glm::ivec3 voxel = space.first_node + glm::ivec3(x, y, static_cast<int>(z));
                const int object = media.at(frame.worldFromIndex(glm::dvec3(voxel)), channel);
                space.media[(static_cast<std::size_t>(z) * static_cast<std::size_t>(count.y) +
                             static_cast<std::size_t>(y)) *
                                static_cast<std::size_t>(count.x) +
                            static_cast<std::size_t>(x)] = static_cast<std::uint8_t>(object + 1);
            }
    });
    glm::dvec3 absorbed(0), attenuated(0);
    for (std::size_t i = 0; i < media.objects.size(); ++i) {
        const glm::dvec3 extinction = media.objects[i].extinction();
        for (int k = 0; k < 3; ++k) space.table.extinction[i + 1][k] = static_cast<float>(extinction[k]);
        absorbed += media.objects[i].absorption, attenuated += extinction;
    }
    for (int k = 0; k < 3; ++k) space.absorbed_share[k] = attenuated[k] > 0 ? absorbed[k] / attenuated[k] : 1;
}

/// Less than that in n^2 turns no ray by 60 degrees but on a way that is many times as long as wide.
constexpr double kGentleContrast = 0.15;

/// Range of n^2 over some places, for an estimate.
double contrastOf(const Media& media, const GridFrame& frame) {
    double least = 1e300, most = 0;
    const auto look = [&](const glm::dvec3& world) {
        const double square = 2 * media.halfSquare(world, 0);
        least = std::min(least, square), most = std::max(most, square);
    };
    for (int i = 0; i < 27; ++i) {
        const glm::dvec3 share = glm::dvec3(i % 3, i / 3 % 3, i / 9) * 0.5;
        look(frame.worldFromIndex(glm::mix(glm::dvec3(frame.min), glm::dvec3(frame.max), share)));
    }
    for (const GradedObject& object : media.objects)
        if (const auto bounds = object.index.front()->bounds()) look(0.5 * (bounds->min + bounds->max));
    return most - least;
}

/// Makes one stage, "fronts", of all fronts of all lights.
class FrontProgress final : public Monitor {
public:
    explicit FrontProgress(Monitor& to) : to_(to) {}
    /// What the next front is of the whole.
    void nextFront(double from, double share) { from_ = from, share_ = share; }

    void progress(std::string_view, double fraction) override { to_.progress("fronts", from_ + share_ * fraction); }
    void warn(const std::string& message) override { to_.warn(message); }
    bool cancelled() const override { return to_.cancelled(); }

private:
    Monitor& to_;
    double from_ = 0, share_ = 1;
};

/// What a bake works on, and what it says of it.
class WavefrontBake {
public:
    WavefrontBake(const Scene& scene, const WavefrontOptions& options, const GridFrame& frame, Monitor& monitor)
        : scene_(scene),
          options_(options),
          frame_(frame),
          media_(scene),
          target_(boxOf(media_, frame)),
          monitor_(monitor) {
        if (media_.objects.size() > 255)
            throw Error(ErrorCode::Input,
                        fmt::format("{} media have an index that varies; up to 255 are baked", media_.objects.size()));
        if (scene.bake.paths == Paths::All)
            target_.add(glm::dvec3(frame.min) - 0.5), target_.add(glm::dvec3(frame.max) + 0.5);
        voxelise_.quadrature = scene.bake.quadrature;
        voxelise_.noise_floor = 1e-6 * scene.referenceIrradiance();
        space_ = frontSpace(target_, frame);
        space_.steps = options.steps;
        if (media_.fillTheWorld()) widen();
    }

    void run(LightField& field) {
        std::vector<std::pair<const Light*, LightSample>> samples;
        for (const Light& light : scene_.lights)
            for (const LightSample& sample : lightSamples(light, options_.disc_samples))
                samples.emplace_back(&light, sample);
        const int passes = media_.disperses() ? 3 : 1;
        const double share = 1.0 / (passes * static_cast<double>(samples.size()));
        double done = 0;
        for (int channel = 0; channel < passes; ++channel) {
            const SplineIndex index = sampled(channel);
            space_.index = &index;
            layMedia(media_, frame_, channel, space_);
            const double contrast = std::max(index.largest() - 0.5, 0.5 - index.least());
            space_.least_lit = scene_.bake.paths == Paths::All
                                   ? -1.0f
                                   : static_cast<float>((index.fit() == SplineFit::Plain ? 0.25 : 0.01) * contrast);
            bytes_ = std::max(bytes_, index.bytes() + static_cast<std::int64_t>(space_.media.size()));
            for (const auto& [light, sample] : samples) {
                addSample(*light, sample, channel, {done, share}, field);
                done += share;
            }
            space_.index = nullptr;
        }
    }

    void report(BakeReport& out, const LightField& field) {
        double sum = 0;
        const int channels = field.channels().irradiance;
        for (int c = 0; c < channels; ++c) sum += field.sum(c) / channels;
        out.power = totals_.power;
        out.path = {sum * frame_.voxelVolume(), totals_.deposit.expected};
        out.tubes = totals_.tubes, out.corner_rays = totals_.rays;
        out.instruction_set = name(voxelise_.instruction_set);
        out.seconds.emplace_back("index", index_seconds_);
        out.seconds.emplace_back("trace", totals_.trace_seconds);
        out.seconds.emplace_back("deposit", totals_.deposit_seconds);
        out.field_bytes = field.bytes() + bytes_;
        if (totals_.power.dropped > 1e-3 * totals_.power.emitted)
            monitor_.warn(
                fmt::format("{:.2g} of the light turned too sharply to be followed and is counted as dropped; more "
                            "'turns', smaller 'spacing' or smaller voxels follow more of it",
                            totals_.power.dropped / totals_.power.emitted));
        // A face of glass is spread over two voxels.
        constexpr double kSteep = 0.5;
        if (jump_ > kSteep)
            monitor_.warn(
                fmt::format("n^2 changes by {:.3g} from a voxel to the next: rays bend sharply within it, and end up "
                            "to a voxel from "
                            "where they should; use smaller voxels, or a [[surface]] for a sharp face",
                            2 * jump_));
    }
    /// What becomes of faces, for the report; empty where there are none.
    std::string faces() const {
        if (spline_ != SplineFit::Plain) return {};
        return "reflection at faces: the index jumps from a voxel to the next, and is blurred by 0.58 voxels there";
    }
    SplineFit spline() const { return spline_; }

private:
    /// Slanting light comes into a grid by its sides too, from a medium that goes on there: the space holds where it
    /// comes from. Not where the light is so level that this would be more than eight times as much.
    void widen() {
        known_ = space_;
        FrontBox entries;
        entries.add(glm::dvec3(space_.low)), entries.add(glm::dvec3(space_.high));
        for (const Light& light : scene_.lights)
            for (const LightSample& sample : lightSamples(light, options_.disc_samples)) {
                const FrontBox entry = entryOf({frame_, space_, target_}, sample);
                entries.add(entry.min), entries.add(entry.max);
            }
        const glm::dvec3 low = glm::floor(entries.min), high = glm::ceil(entries.max), size = high - low + 1.0,
                         before(space_.high - space_.low + 1);
        if (!(size.x * size.y * size.z <= 8 * before.x * before.y * before.z)) return;
        for (int a = 0; a < 3; ++a) {
            // Light enters on the side that it comes from, which stays where it is.
            if (entries.min[a] < space_.low[a] - 0.5) space_.low[a] = static_cast<int>(low[a]);
            if (entries.max[a] > space_.high[a] + 0.5) space_.high[a] = static_cast<int>(high[a]);
        }
    }

    /// n^2 / 2 of a voxel: beyond the grid, where a formula may end, that of the nearest one in it.
    double halfSquareAt(const glm::dvec3& world, const glm::dvec3& voxel, int channel) const {
        const double value = media_.halfSquareOfVoxel(world, voxel, channel);
        if (value > 0 || !media_.fillTheWorld()) return value;
        const glm::dvec3 inside = glm::clamp(frame_.indexFromWorld(world), glm::dvec3(known_.low - kMargin),
                                             glm::dvec3(known_.high + kMargin));
        return media_.halfSquareOfVoxel(frame_.worldFromIndex(inside), voxel, channel);
    }

    SplineIndex sampled(int channel) {
        const auto start = Clock::now();
        if (channel == 0) monitor_.progress("index", 0);
        space_.first_node = space_.low - kMargin;
        SplineIndex::Nodes nodes;
        nodes.count = space_.high - space_.low + 1 + 2 * kMargin;
        nodes.first_world = frame_.worldFromIndex(glm::dvec3(space_.first_node));
        for (int a = 0; a < 3; ++a) nodes.spacing[a] = frame_.worldFromIndex()[a][a];
        const SplineFit fit = options_.spline == WavefrontSpline::Auto      ? SplineFit::Auto
                              : options_.spline == WavefrontSpline::Through ? SplineFit::Through
                                                                            : SplineFit::Plain;
        SplineIndex index(
            nodes,
            [&](const glm::dvec3& p) {
                monitor_.checkCancelled();
                return halfSquareAt(p, nodes.spacing, channel);
            },
            fit);
        spline_ = index.fit(), jump_ = std::max(jump_, index.steepest() * (index.largest() - index.least()));
        if (channel == 0) monitor_.progress("index", 1);
        index_seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
        return index;
    }

    /// Halves what would be given up, up to three times and to three times as many tubes: at the rim of a lens, where
    /// one ray of a tube goes straight on and another turns, only the narrowest tubes are lost then.
    Front refined(Front front, const FrontLaunch& launch, const LightSample& sample, LightField& field,
                  Monitor& monitor) {
        constexpr int kHalvings = 3;
        if (2 * (space_.index->largest() - space_.index->least()) < kGentleContrast) return front;
        const std::size_t most = 3 * front.tubes.size();
        SweepTotals nobodys;
        FrontSweep probe(space_, field, voxelise_, nobodys, monitor);
        Front whole;
        whole.axis = front.axis, whole.sense = front.sense;
        for (int halving = 0; halving < kHalvings; ++halving) {
            const std::vector<std::uint32_t> lost = probe.findLost(front, options_.turns);
            if (lost.empty() || whole.tubes.size() + front.tubes.size() + 3 * lost.size() > most) break;
            Front parts = splitTubes(launch, sample, front, lost);
            for (auto tube = lost.rbegin(); tube != lost.rend(); ++tube) front.tubes[*tube].ray[0] = kGone;
            std::erase_if(front.tubes, [](const Front::Tube& tube) { return tube.ray[0] == kGone; });
            whole.append(front);
            front = std::move(parts);
        }
        whole.append(front);
        totals_.trace_seconds += nobodys.trace_seconds;
        return whole;
    }

    /// What some work is of all fronts' work.
    struct Part {
        double from, share;
    };

    void addSample(const Light& light, const LightSample& sample, int channel, const Part& part, LightField& field) {
        glm::dvec3 channels(1);
        if (media_.disperses()) channels = glm::dvec3(0), channels[channel] = 1;
        const FrontLaunch launch{
            frame_, space_, target_, options_.spacing, scene_.bake.paths == Paths::All, [&](const glm::dvec3& world) {
                return media_.at(world, channel) >= 0;
            }};
        FrontProgress progress(monitor_);
        progress.nextFront(part.from, 0);
        std::vector<Front> fronts{refined(launchFront(launch, light, sample), launch, sample, field, progress)};
        for (Front::Tube& tube : fronts.front().tubes) {
            tube.power *= channels;
            totals_.power.emitted += (tube.power.x + tube.power.y + tube.power.z) / 3;
        }
        FrontSweep sweep(space_, field, voxelise_, totals_, progress);
        Part of_turn{part.from, 0.7 * part.share};  // the fronts that turned away are fewer and fewer
        for (int turn = 0; turn <= options_.turns && !fronts.empty(); ++turn) {
            std::vector<Front> next;
            const double share = of_turn.share / static_cast<double>(fronts.size());
            for (std::size_t i = 0; i < fronts.size(); ++i) {
                progress.nextFront(of_turn.from + share * static_cast<double>(i), share);
                for (Front& on : sweep.run(fronts[i])) next.push_back(std::move(on));
            }
            fronts = std::move(next);
            of_turn.from += of_turn.share, of_turn.share = 0.5 * (part.from + part.share - of_turn.from);
        }
        for (const Front& front : fronts)
            for (const Front::Tube& tube : front.tubes)
                totals_.power.dropped += (tube.power.x + tube.power.y + tube.power.z) / 3;
    }

    const Scene& scene_;
    const WavefrontOptions& options_;
    GridFrame frame_;
    Media media_;
    FrontBox target_;
    Monitor& monitor_;
    VoxeliseOptions voxelise_;
    static constexpr std::uint32_t kGone = 0xffffffff;
    static constexpr int kMargin = 3;  // nodes, that a spline reaches and a little more
    FrontSpace space_, known_;         // known: before it was widened
    SweepTotals totals_;
    SplineFit spline_ = SplineFit::Auto;
    double jump_ = 0;  ///< of n^2 / 2 from a voxel to the next
    double index_seconds_ = 0;
    std::int64_t bytes_ = 0;
};

std::string wavefrontRefusal(const Scene& scene) {
    if (scene.lights.empty()) return "the scene has no [[light]]";
    if (!scene.index || scene.index->objects().empty())
        return "the scene has no [[medium]] with an 'index' that varies by itself; beams follows light through faces";
    if (!scene.surfaces.empty())
        return fmt::format(
            "the surface '{}' lies beside media whose index varies, which is not built yet; remove it, or give the "
            "medium as an index",
            scene.surfaces.front().name);
    for (const Object& object : scene.objects)
        if (object.blocks())
            return fmt::format(
                "the object '{}' would block light, which is not built yet beside media whose index varies; give it "
                "role = \"movable\"",
                object.name);
    if (scene.domain.shear_mode != ShearMode::None)
        return "a sheared grid is not built yet for wavefront; remove [domain] shear";
    return {};
}

MethodCost wavefrontCost(const CostQuestion& question) {
    WavefrontOptions options;
    applyOptions<WavefrontOptions>("wavefront", options, wavefrontOptions(), question.options);
    const Scene& scene = question.scene;
    // Seconds of one thread of a 2.6 GHz server core.
    constexpr double kSecondsANode = 3e-7, kSecondsARayStep = 4e-8, kSecondsATubeLayer = 2e-8, kSecondsAValue = 2e-8;
    // Where light may turn, what would be lost is looked for first, and layers are evaluated at more points.
    constexpr double kTurning = 5;
    const int channels = (scene.coloured() ? 3 : 1) + (scene.bake.grids.direction ? 3 : 0);
    const Media media(scene);
    const int passes = media.disperses() ? 3 : 1;
    const FrontSpace space = frontSpace(boxOf(media, question.frame), question.frame);
    const glm::dvec3 size(space.high - space.low + 1);
    double directions = 0, fronts = 0;
    for (const Light& light : scene.lights) {
        const auto samples = static_cast<double>(lightSamples(light, options.disc_samples).size());
        const int axis = mainAxis(light.direction);
        const double rays = size.x * size.y * size.z / size[axis] / (options.spacing * options.spacing);
        directions += samples;
        fronts += samples * rays * size[axis] * (options.steps * kSecondsARayStep + 2 * kSecondsATubeLayer) +
                  samples * question.needed_voxels * channels * kSecondsAValue;
    }
    MethodCost cost;
    const double nodes = size.x * size.y * size.z;
    cost.stages = {{"index", passes * nodes * kSecondsANode},
                   {"fronts", passes * fronts * (contrastOf(media, question.frame) < kGentleContrast ? 1 : kTurning)}};
    cost.bytes = nodes * (media.attenuate() ? 5 : 4);
    if (directions > 4 * static_cast<double>(scene.lights.size()))
        cost.dearest = fmt::format(
            "most of the time goes into {:.0f} directions of light: fewer disc_samples are quicker in proportion",
            directions);
    return cost;
}

BakeResult bakeWavefront(const Scene& scene, std::shared_ptr<const NeededVoxels> needed, const GivenOptions& given,
                         Monitor& monitor) {
    WavefrontOptions options;
    applyOptions<WavefrontOptions>("wavefront", options, wavefrontOptions(), given);
    const FieldChannels channels{scene.coloured() ? 3 : 1, scene.bake.grids.direction};
    BakeReport report;
    if (options.disc_samples == 1)
        for (const Light& light : scene.lights)
            if (light.angular_diameter_deg > 0) {
                report.skipped.emplace_back("the sun's disc: disc_samples is 1");
                break;
            }
    WavefrontBake bake(scene, options, needed->frame(), monitor);
    LightField field(needed, channels);
    bake.run(field);
    bake.report(report, field);
    if (const std::string faces = bake.faces(); !faces.empty()) report.skipped.push_back(faces);
    BakeResult result{std::move(field), std::move(report), {}, {}, {}, {}, {}};
    result.metadata["spline"] = bake.spline() == SplineFit::Plain ? "plain" : "through";
    return result;
}

}  // namespace

Method wavefrontMethod() {
    return {"wavefront",
            "Fronts through media whose index varies: lenses without faces, hot air, salt; exact in energy",
            {"irradiance", "direction"},
            optionSpecs<WavefrontOptions>(wavefrontOptions()),
            wavefrontRefusal,
            wavefrontCost,
            bakeWavefront};
}

}  // namespace photic
