// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/wavefront.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <optional>

#include "bake/methods/front_obstacles.h"
#include "bake/methods/graded_space.h"
#include "bake/methods/method_options.h"
#include "bake/methods/paper_fronts.h"
#include "bake/methods/wavefront_launch.h"
#include "bake/methods/wavefront_refine.h"
#include "bake/paths/emission.h"
#include "bake/paths/optical_scene.h"
#include "bake/report/error.h"
#include "bake/report/stopwatch.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

const std::vector<OptionBinding<WavefrontOptions>>& wavefrontOptions() {
    static const std::vector<OptionBinding<WavefrontOptions>> bindings{
        bindOption("spacing", &WavefrontOptions::spacing, {0.05, 16}, "voxels",
                   "between the rays of a front where it starts"),
        bindOption("steps", &WavefrontOptions::steps, {1, 8}, "",
                   "of a ray, a layer of voxels; more of themselves where the index changes sharply"),
        bindOption("integrator", &WavefrontOptions::integrator,
                   {{"planes", FrontIntegrator::Planes},
                    {"runge_kutta", FrontIntegrator::RungeKutta},
                    {"yoshida", FrontIntegrator::Yoshida},
                    {"controlled", FrontIntegrator::Controlled}},
                   "how rays go from layer to layer: in steps of second order, many side by side; or, to compare, one "
                   "by one, by two of fourth order or by one that holds a millionth of a voxel a layer"),
        bindOption("disc_samples", &WavefrontOptions::disc_samples, {1, 4096}, "",
                   "directions on the sun's disc; 1: a point sun"),
        bindOption("turns", &WavefrontOptions::turns, {0, 1000}, "",
                   "times that light may change the axis along which it is followed"),
        bindOption(
            "spline", &WavefrontOptions::spline,
            {{"auto", WavefrontSpline::Auto}, {"through", WavefrontSpline::Through}, {"plain", WavefrontSpline::Plain}},
            "how samples of the index become smooth: through them, or blurred by 0.58 voxel, which never rings "
            "at jumps; auto goes through smooth ones"),
        bindOption("arrivals", &WavefrontOptions::arrivals,
                   {{"all", WavefrontArrivals::All}, {"strongest", WavefrontArrivals::Strongest}},
                   "light that a voxel keeps: all that comes, or only that of the arrival that brings most, as the "
                   "paper does; the report then says what that leaves out"),
        bindOption("preset", &WavefrontOptions::preset,
                   {{"none", WavefrontPreset::None}, {"paper", WavefrontPreset::Paper}},
                   "paper: the simulator of Ihrke et al. 2007, to compare: Euler steps of equal time, patches in the "
                   "voxels of their middles, the strongest kept, none beyond caustics"),
        bindOption("smooth", &WavefrontOptions::smooth, {0, 4}, "voxels",
                   "standard deviation by which the paper's preset blurs n"),
        bindOption("area", &WavefrontOptions::area,
                   {{"corners", PatchArea::Corners}, {"jacobian", PatchArea::Jacobian}},
                   "of a patch of the paper's preset, over which its power is spread: that between its four particles, "
                   "or that of the map of its middle ray (paraxial)"),
        bindOption("rim", &WavefrontOptions::rim, {0, 0.9}, "",
                   "share of the largest difference of n^2 from the air's from which on light counts as having been in "
                   "a medium; 0: a hundredth, and a quarter where faces are sharp"),
    };
    return bindings;
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
          medium_(scene, frame, {options.disc_samples, fitOf(options), options.steps, options.integrator, options.rim}),
          monitor_(monitor) {
        obstacles_.emplace(scene, frame, medium_.space().low, medium_.space().high, medium_.optics());
        medium_.followTurns(options.turns);
        if (!obstacles_->empty()) medium_.standIn(*obstacles_);
        voxelise_.quadrature = scene.bake.quadrature;
        voxelise_.noise_floor = 1e-6 * scene.referenceIrradiance();
    }

    void run(LightField& field) {
        std::vector<std::pair<const Light*, LightSample>> samples;
        for (const Light& light : scene_.lights)
            for (const LightSample& sample : lightSamples(light, options_.disc_samples))
                samples.emplace_back(&light, sample);
        const int passes = medium_.passes();
        const double share = 1.0 / (passes * static_cast<double>(samples.size()));
        double done = 0;
        for (int channel = 0; channel < passes; ++channel) {
            if (options_.arrivals == WavefrontArrivals::Strongest)
                strongest_.emplace(field.neededPtr(), field.channels());
            const Stopwatch watch;
            if (channel == 0) monitor_.progress("index", 0);
            medium_.sample(channel, monitor_);
            if (channel == 0) monitor_.progress("index", 1);
            index_seconds_ += watch.seconds();
            for (const auto& [light, sample] : samples) {
                if (strongest_) strongest_->beginLight();
                addSample(*light, sample, channel, {done, share}, field);
                done += share;
            }
            if (strongest_) takeStrongest(field);
        }
    }
    /// The `arrival_time` grid: of green light where the media disperse.
    void askForArrivalTime(const std::shared_ptr<const NeededVoxels>& needed) { first_.emplace(needed); }
    std::optional<LightField> takeArrivalTime() {
        if (!first_) return {};
        return first_->take();
    }

    /// Counts what run() takes, for an estimate. @param work  must outlive the bake
    void countInto(SweepWork& work) { totals_.work = &work; }

    void report(BakeReport& out, const LightField& field) {
        double sum = 0, beside_tile = 0;
        const int channels = field.channels().irradiance;
        for (int c = 0; c < channels; ++c)
            sum += field.sum(c) / channels, beside_tile += field.sumBesideTile(c) / channels;
        out.power = totals_.power;
        out.path = {sum * frame_.voxelVolume(),
                    totals_.deposit.expected - left_out_ - beside_tile * frame_.voxelVolume()};
        if (options_.arrivals == WavefrontArrivals::Strongest) out.arrivals = arrivalShares();
        out.tubes = totals_.tubes, out.corner_rays = totals_.rays;
        out.instruction_set = name(voxelise_.instruction_set);
        out.seconds.emplace_back("index", index_seconds_);
        out.seconds.emplace_back("trace", totals_.trace_seconds);
        out.seconds.emplace_back("deposit", totals_.deposit_seconds);
        out.field_bytes = field.bytes() + medium_.bytes();
        const double dropped = totals_.power.dropped / totals_.power.emitted;
        if (options_.preset == WavefrontPreset::Paper)
            out.skipped.push_back(
                fmt::format("light beyond caustics, as the paper's simulator does: {:.2g} of it is dropped", dropped));
        else if (dropped > 1e-3)
            monitor_.warn(
                fmt::format("{:.2g} of the light turned too sharply to be followed and is counted as dropped; more "
                            "'turns', smaller 'spacing' or smaller voxels follow more of it",
                            dropped));
        if (std::string coarse = coarseTubes(); !coarse.empty()) out.skipped.push_back(std::move(coarse));
        // A face of glass is spread over two voxels.
        constexpr double kSteep = 0.5;
        if (medium_.jump() > kSteep)
            monitor_.warn(
                fmt::format("n^2 changes by {:.3g} from a voxel to the next: rays bend sharply within it, and end up "
                            "to a voxel from "
                            "where they should; use smaller voxels, or a [[surface]] for a sharp face",
                            2 * medium_.jump()));
    }
    const GradedSpace& medium() const { return medium_; }

private:
    /// Of a pass: the field's own where there is one pass for all channels.
    void takeStrongest(LightField& field) {
        sums_.add(strongest_->sums(voxelise_.noise_floor / medium_.passes()));
        left_out_ += strongest_->leftOut();
        LightField light = strongest_->take();
        strongest_.reset();
        if (medium_.passes() == 1) {
            field = std::move(light);
            return;
        }
        parallelFor(light.leafCount(), [&](std::int64_t i) {
            const int slot = static_cast<int>(i);
            if (light.state(slot) == LeafState::Empty) return;
            float* to = field.makeDense(slot);
            const float* from = light.dense(slot);
            for (int v = 0; v < field.channels().count() * LightField::kLeafVoxels; ++v) to[v] += from[v];
        });
    }

    ArrivalShares arrivalShares() const {
        ArrivalShares shares;
        if (sums_.lit > 0) shares.several = sums_.several / sums_.lit;
        if (sums_.several > 0) shares.strongest = sums_.strongest_shares / sums_.several;
        if (sums_.all > 0) shares.left_out = (sums_.all - sums_.strongest) / sums_.all;
        if (sums_.all_squares > 0) shares.rmse = std::sqrt(sums_.left_out_squares / sums_.all_squares);
        return shares;
    }

    static SplineFit fitOf(const WavefrontOptions& options) {
        if (options.preset == WavefrontPreset::Paper) return SplineFit::Plain;
        return options.spline == WavefrontSpline::Auto      ? SplineFit::Auto
               : options.spline == WavefrontSpline::Through ? SplineFit::Through
                                                            : SplineFit::Plain;
    }

    /// Divides what is too coarse, and what would be given up.
    Front refined(Front front, const FrontLaunch& launch, const LightSample& sample, LightField& field,
                  Monitor& monitor) {
        SweepTotals nobodys;
        nobodys.work = totals_.work;
        FrontSweep probe(launch.space, field, voxelise_, nobodys, monitor);
        FrontRefiner refiner(launch, sample, probe, scene_.bake.tolerance);
        Front out = refiner.refine(std::move(front));
        totals_.trace_seconds += nobodys.trace_seconds;
        coarse_.power += refiner.coarse().power / medium_.passes();
        coarse_.by = std::max(coarse_.by, refiner.coarse().by);
        coarse_.too_many = coarse_.too_many || refiner.coarse().too_many;
        return out;
    }

    /// What is said of tubes that could not be halved as often as they should be; empty where that is next to none.
    std::string coarseTubes() const {
        constexpr double kLeast = 1e-3;
        const double share = coarse_.power / totals_.power.emitted;
        if (!(share > kLeast)) return {};
        return fmt::format(
            "halving of all tubes that bend: {:.2g} of the light goes in tubes that bend by more than 'tolerance', by "
            "up to {:.2g} voxels, since {}; a smaller 'spacing' makes them narrower",
            share, coarse_.by,
            coarse_.too_many ? "there are four times as many as were launched at most"
                             : "each is halved three times at most");
    }

    /// Leaves out the tubes that most rays say are in the shadow of an object.
    void takeShadowed(Front& front) {
        std::erase_if(front.tubes, [&](const Front::Tube& tube) {
            const auto shadowed =
                std::count_if(tube.ray, tube.ray + 3, [&](std::uint32_t ray) { return front.rays[ray].shadowed; });
            if (shadowed < 2) return false;
            totals_.power.absorbed_surface += channelMean(tube.power);
            return true;
        });
    }

    /// What some work is of all fronts' work.
    struct Part {
        double from, share;
    };

    void addSample(const Light& light, const LightSample& sample, int channel, const Part& part, LightField& field) {
        glm::dvec3 channels(1);
        if (medium_.passes() > 1) channels = glm::dvec3(0), channels[channel] = 1;
        const FrontLaunch launch = medium_.launch(sample.source, options_.spacing, channel,
                                                  obstacles_->caster().empty() ? nullptr : &obstacles_->caster());
        FrontProgress progress(monitor_);
        progress.nextFront(part.from, 0);
        if (options_.preset == WavefrontPreset::Paper) {
            if (standsAmong(launch, sample))
                throw Error(ErrorCode::Input,
                            fmt::format("the paper's preset of wavefront knows no lamps among the media; move '{}' out "
                                        "of the domain and the media",
                                        light.name),
                            light.where);
            const Front front = std::move(launchFronts(launch, light, sample).front());
            for (const Front::Tube& tube : front.tubes) totals_.power.emitted += channelMean(tube.power);
            progress.nextFront(part.from, part.share);
            PaperFronts(medium_.space(), frame_, options_.smooth, options_.area).lay(front, field, totals_, progress);
            return;
        }
        std::vector<Front> fronts = launchFronts(launch, light, sample);
        for (Front& front : fronts) {
            front = refined(std::move(front), launch, sample, field, progress);
            for (Front::Tube& tube : front.tubes) {
                tube.power *= channels, tube.least *= channelMean(channels);
                totals_.power.emitted += channelMean(tube.power);
            }
            takeShadowed(front);
        }
        FrontSinks sinks;
        if (strongest_) sinks.strongest = &*strongest_;
        if (first_ && channel == (medium_.passes() > 1 ? 1 : 0)) sinks.first = &*first_;
        FrontSweep sweep(launch.space, field, voxelise_, totals_, progress, sinks);
        sweep.runAll(std::move(fronts), [&](double from, double share) {
            progress.nextFront(part.from + part.share * from, part.share * share);
        });
    }

    const Scene& scene_;
    const WavefrontOptions& options_;
    GridFrame frame_;
    GradedSpace medium_;
    Monitor& monitor_;
    VoxeliseOptions voxelise_;
    SweepTotals totals_;
    FrontCoarse coarse_;
    double index_seconds_ = 0;
    std::optional<FrontObstacles> obstacles_;
    std::optional<StrongestArrival> strongest_;  // of a pass
    std::optional<FirstArrival> first_;
    ArrivalSums sums_;
    double left_out_ = 0;  // [W m]
};

std::string wavefrontRefusal(const Scene& scene) {
    if (scene.lights.empty()) return "the scene has no [[light]]";
    if (!scene.index || scene.index->objects().empty())
        return "the scene has no [[medium]] with an 'index' that varies by itself; beams follows light through faces";
    if (std::string why = gradedSpaceRefusal(scene); !why.empty()) return why;
    return {};
}

/// A grid over the same place with voxels `times` as wide.
GridFrame coarser(const GridFrame& frame, int times) {
    const auto whole = [times](const glm::ivec3& voxel) {
        return glm::ivec3(glm::floor(glm::dvec3(voxel) / double(times)));
    };
    return {frame.worldFromIndex() * double(times), frame.worldFromIndex(glm::dvec3(0.5 * (times - 1))),
            whole(frame.min), whole(frame.max)};
}

/// What a bake takes with one direction a light: counted in one with voxels so wide that it is quick. How light turns
/// depends little on them, and all grows with their number.
SweepWork countedWork(const Scene& scene, WavefrontOptions options, const GridFrame& frame, double nodes) {
    constexpr double kNodes = 4e4;
    const int times = std::max(1, static_cast<int>(std::ceil(std::cbrt(nodes / kNodes))));
    options.disc_samples = 1, options.arrivals = WavefrontArrivals::All;
    // The bake refuses it, and says why.
    if (!scene.surfaces.empty()) options.preset = WavefrontPreset::None;
    const auto needed = std::make_shared<const NeededVoxels>(NeededVoxels::everything(coarser(frame, times)));
    LightField field(needed, {scene.coloured() ? 3 : 1, scene.bake.grids.direction});
    Monitor quiet;
    SweepWork work;
    WavefrontBake bake(scene, options, needed->frame(), quiet);
    bake.countInto(work);
    bake.run(field);
    const double grown = static_cast<double>(times) * times * times;
    return {grown * work.ray_steps, grown * work.nodes, work.deposit * grown};
}

MethodCost wavefrontCost(const CostQuestion& question) {
    WavefrontOptions options;
    applyOptions<WavefrontOptions>("wavefront", options, wavefrontOptions(), question.options);
    const Scene& scene = question.scene;
    // Seconds of one thread of a 2.6 GHz server core.
    constexpr double kSecondsANode = 1.8e-7, kSecondsASampledNode = 1.1e-6, kSecondsARayStep = 2.8e-8,
                     kSecondsAPlaneNode = 4.4e-9, kSecondsATube = 2.6e-7, kSecondsAnArrival = 9e-6,
                     kSecondsAnEdgeCell = 6.3e-9, kSecondsAValue = 7e-9;
    const int channels = (scene.coloured() ? 3 : 1) + (scene.bake.grids.direction ? 3 : 0);
    const GradedSpace medium(scene, question.frame, {options.disc_samples, SplineFit::Auto, options.steps});
    const glm::dvec3 size(medium.space().high - medium.space().low + 1);
    const double nodes = size.x * size.y * size.z;
    double directions = 0;
    for (const Light& light : scene.lights)
        directions += static_cast<double>(lightSamples(light, options.disc_samples).size());
    const SweepWork work = countedWork(scene, options, question.frame, nodes);
    const double needed = std::min(1.0, question.needed_voxels / static_cast<double>(question.frame.voxelCount()));
    // The strongest arrival is sought tube by tube and layer by layer.
    const double a_tube = options.arrivals == WavefrontArrivals::Strongest ? kSecondsAnArrival : kSecondsATube;
    const double fronts =
        work.ray_steps * kSecondsARayStep + work.nodes * kSecondsAPlaneNode +
        needed * (work.deposit.tubes * a_tube + work.deposit.cells * kSecondsAnEdgeCell * (channels / 4.0));
    const auto& objects = scene.index->objects();
    const bool sampled = std::any_of(objects.begin(), objects.end(),
                                     [](const GradedObject& object) { return object.index.front()->samples(); });
    const double lights = static_cast<double>(scene.lights.size());
    MethodCost cost;
    cost.stages = {
        {"index", medium.passes() * nodes * (sampled ? kSecondsASampledNode : kSecondsANode)},
        {"fronts", directions / lights * fronts + directions * question.needed_voxels * channels * kSecondsAValue}};
    cost.bytes = nodes * (medium.attenuate() ? 5 : 4);
    if (directions > 4 * lights)
        cost.dearest = fmt::format(
            "most of the time goes into {:.0f} directions of light: fewer disc_samples are quicker in proportion",
            directions);
    return cost;
}

/// @throws Error{Input} for what the paper's simulator does not know
void refusePreset(const Scene& scene, const WavefrontOptions& options) {
    const auto refuse = [](const std::string& why) {
        throw Error(ErrorCode::Input, "the paper's preset of wavefront " + why, "bake.wavefront.preset");
    };
    for (const Object& object : scene.objects)
        if (object.blocks())
            refuse(fmt::format("knows nothing that stands in the light; give '{}' the role \"movable\"", object.name));
    if (!scene.surfaces.empty())
        refuse(fmt::format("knows no sharp surfaces; remove '{}', or give it an index", scene.surfaces.front().name));
    if (GradedMedia(scene).disperses()) refuse("has one index for all colours; give the media one");
    if (scene.bake.grids.arrival_time) refuse("has no grid 'arrival_time'; leave it out of bake.grids");
    if (options.integrator != FrontIntegrator::Planes) refuse("takes Euler's steps; leave out 'integrator'");
    if (options.arrivals == WavefrontArrivals::Strongest)
        refuse("keeps the strongest patch of a voxel anyhow; leave out 'arrivals'");
}

/// @throws Error{Input} for what only the paper's simulator has
void refusePresetsOwn(const GivenOptions& given) {
    for (const char* name : {"smooth", "area"})
        if (const auto option = given.find(name); option != given.end())
            throw Error(
                ErrorCode::Input,
                fmt::format("'{}' is for the paper's preset of wavefront; add preset = \"paper\", or leave it out",
                            name),
                option->second.where);
}

// What is said of the strongest arrivals is said of all voxels.
int wavefrontReach(const Scene&, const GridFrame&, const GivenOptions& given) {
    WavefrontOptions options;
    applyOptions<WavefrontOptions>("wavefront", options, wavefrontOptions(), given);
    return options.arrivals == WavefrontArrivals::All && options.preset == WavefrontPreset::None ? 0 : -1;
}

BakeResult bakeWavefront(const Scene& scene, std::shared_ptr<const NeededVoxels> needed, const GivenOptions& given,
                         Monitor& monitor) {
    WavefrontOptions options;
    applyOptions<WavefrontOptions>("wavefront", options, wavefrontOptions(), given);
    const FieldChannels channels{scene.coloured() ? 3 : 1, scene.bake.grids.direction};
    if (options.preset == WavefrontPreset::Paper)
        refusePreset(scene, options);
    else
        refusePresetsOwn(given);
    BakeReport report;
    if (options.disc_samples == 1)
        for (const Light& light : scene.lights)
            if (light.angular_diameter_deg > 0) {
                report.skipped.emplace_back("the sun's disc: disc_samples is 1");
                break;
            }
    WavefrontBake bake(scene, options, needed->frame(), monitor);
    LightField field(needed, channels);
    if (scene.bake.grids.arrival_time) bake.askForArrivalTime(needed);
    bake.run(field);
    bake.report(report, field);
    const std::string faces = bake.medium().faces();
    if (!faces.empty() && options.preset == WavefrontPreset::None) report.skipped.push_back(faces);
    std::optional<LightField> caustic;
    if (scene.bake.grids.caustic) caustic = causticBesideMedia(scene, field);
    BakeResult result{std::move(field), std::move(report), {}, {}, std::move(caustic), bake.takeArrivalTime(), {}};
    result.metadata["spline"] = bake.medium().splineName();
    if (options.preset == WavefrontPreset::Paper) {
        // Samples of light do not close the path ledger; the report says by how much.
        result.metadata["spline"] = "trilinear", result.metadata["arrivals"] = "strongest";
        result.metadata["ledger"] = "";
    }
    if (const std::optional<ArrivalShares>& arrivals = result.report.arrivals) {
        result.metadata["arrivals"] = "strongest";
        result.metadata["several_arrivals"] = fmt::format("{:.4f}", arrivals->several);
        result.metadata["strongest_share"] = fmt::format("{:.4f}", arrivals->strongest);
        result.metadata["left_out"] = fmt::format("{:.4f}", arrivals->left_out);
    }
    return result;
}

}  // namespace

Method wavefrontMethod() {
    return {"wavefront",
            "Fronts through media whose index varies: lenses without faces, hot air, salt; exact in energy",
            {"irradiance", "direction", "caustic", "arrival_time"},
            optionSpecs<WavefrontOptions>(wavefrontOptions()),
            wavefrontRefusal,
            wavefrontCost,
            bakeWavefront,
            StandardError::Unknown,
            wavefrontReach};
}

}  // namespace photic
