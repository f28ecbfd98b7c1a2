// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/beams.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "bake/deposit/ernst_deposit.h"
#include "bake/deposit/kept_tiles.h"
#include "bake/deposit/voxelise.h"
#include "bake/field/lobes.h"
#include "bake/methods/beams_cost.h"
#include "bake/methods/disc_samples.h"
#include "bake/methods/method_options.h"
#include "bake/methods/sun_disc.h"
#include "bake/report/error.h"
#include "bake/report/stopwatch.h"
#include "bake/scene/wave_field.h"
#include "bake/threads/parallel_for.h"
#include "bake/tubes/histories.h"

namespace photic {
namespace {

constexpr std::size_t kTubesADeposit = 200'000;

const std::vector<OptionBinding<BeamsOptions>>& beamsOptions() {
    static const std::vector<OptionBinding<BeamsOptions>> bindings{
        bindOption("mesh", &BeamsOptions::mesh, {0, 65536}, "",
                   "corner rays a side of the launched patch; 0: by spacing"),
        bindOption("spacing", &BeamsOptions::spacing, {0, 64}, "voxels",
                   "between corner rays; 0: adaptive, by bake.tolerance"),
        bindOption("silhouette", &BeamsOptions::silhouette, {0.01, 4}, "voxels", "smallest tube at a shadow's edge"),
        bindOption("disc", &BeamsOptions::disc,
                   {{"auto", BeamsDisc::Auto},
                    {"off", BeamsDisc::Off},
                    {"blur", BeamsDisc::Blur},
                    {"sample", BeamsDisc::Sample}},
                   "the sun's disc: one blur a layer, or one bake a direction; auto blurs where that is right"),
        bindOption(
            "disc_samples", &BeamsOptions::disc_samples, {1, 4096}, "",
            "directions on the sun's disc when it is sampled; with disc = \"auto\" at most: a narrow disc needs fewer"),
        bindOption("wavelengths", &BeamsOptions::wavelengths, {3, 64}, "",
                   "at which light is traced where media disperse"),
        bindOption("kernel", &BeamsOptions::kernel, {{"edges", BeamsKernel::Edges}, {"scalar", BeamsKernel::Scalar}},
                   "how deposits are summed: by signed edge coverage, or tube by tube (slow, the same result)"),
        bindOption(
            "interpolation", &BeamsOptions::interpolation,
            {{"constant", BeamsInterpolation::Constant}, {"ernst", BeamsInterpolation::Ernst}},
            "density inside a tube: constant, exact in energy, or Ernst's interpolated areas at voxel centres (the "
            "paper's preset)"),
    };
    return bindings;
}

// How far blurs reach into walls [voxels].
double behindWalls(const Scene& scene, const GridFrame& frame, const BeamsOptions& options) {
    double reach = 0;
    for (const Light& light : scene.lights)
        if (discFor(scene, light, frame, options) == BeamsDisc::Blur)
            reach = std::max(reach, std::ceil(blurReach(scene.surfaces.front(), light, frame)));
    return reach;
}

// One light on one surface, or one direction of a disc: adds its tubes to the field of their lobe.
class BeamsBake {
public:
    BeamsBake(const Scene& scene, const BeamsOptions& options, const GridFrame& frame, BeamsProgress& monitor)
        : scene_(scene),
          options_(options),
          frame_(frame),
          spectrum_(spectralSamples(options.wavelengths)),
          optics_(scene, frame, wavelengthsOf(spectrum_), behindWalls(scene, frame, options)),
          monitor_(monitor) {
        limits_ = followLimits(scene);
        launch_ = launchOptions(scene, options);
        voxelise_ = voxeliseOptions(scene, options);
        voxelise_.kept = KeptTiles::used();
    }

    void addLight(const Light& light, LobeFields& field) {
        // A ten-millionth of the light's own is about the least that a half float of it can hold, and above its sums'
        // rounding. Light that a few small bodies throw all around is fainter than a millionth in most voxels.
        const double own = std::max({light.irradiance.x, light.irradiance.y, light.irradiance.z});
        voxelise_.noise_floor = 1e-7 * (own > 0 ? own : scene_.referenceIrradiance());
        if (!blurs(light)) {
            std::vector<LightSample> samples = lightSamples(light, discDirections(optics_, light, options_));
            // The first stands nearest to the middle: it goes last, for all that is too faint to be told apart.
            std::reverse(samples.begin(), samples.end());
            FaintLight faint;
            for (const LightSample& sample : samples)
                addSample(light, sample, field, samples.size() > 1 ? &faint : nullptr, &sample == &samples.back());
            launched_.power.dropped += faint.rest(), launched_.given_up.threshold += faint.rest();
            layWaiting(field);
            return;
        }
        addSample(light, lightSamples(light, 1).front(), field, nullptr, true);
        layWaiting(field);
        measureDeposit(field);
        const Stopwatch watch;
        const auto kernels = discKernels(scene_.surfaces.front(), light, frame_);
        blurLayers(field.first, kernels, BeyondNeeded::Alike);
        if (field.second) blurLayers(*field.second, kernels, BeyondNeeded::Alike);
        disc_seconds_ += watch.seconds();
    }

    /// How often a surface will be launched from: once for each light, or direction on its disc, whatever its
    /// histories.
    int launches() const {
        std::size_t samples = 0;
        for (const Light& light : scene_.lights)
            samples += lightSamples(light, discDirections(optics_, light, options_)).size();
        return static_cast<int>(samples * scene_.surfaces.size());
    }

    bool blurs(const Light& light) const { return discFor(scene_, light, frame_, options_) == BeamsDisc::Blur; }

    // The path ledger's deposited side is taken before the blur moves light across the frame's border.
    void measureDeposit(const LobeFields& field) {
        double sum = 0;
        const int channels = field.first.channels().irradiance;
        double beside_tile = 0;
        for (int c = 0; c < channels; ++c) {
            sum += (field.first.sum(c) + (field.second ? field.second->sum(c) : 0)) / channels;
            beside_tile +=
                (field.first.sumBesideTile(c) + (field.second ? field.second->sumBesideTile(c) : 0)) / channels;
        }
        deposited_ += sum * frame_.voxelVolume(), beside_tile_ += beside_tile * frame_.voxelVolume();
    }

    void report(BakeReport& out) const {
        out.power = launched_.power;
        out.given_up = launched_.given_up, out.astride = launched_.astride;
        out.path = {deposited_, totals_.expected - beside_tile_};
        out.tubes = launched_.tubes;
        out.corner_rays = launched_.corner_rays;
        out.seconds.emplace_back("trace", launched_.seconds);
        out.seconds.emplace_back("deposit", deposit_seconds_);
        if (disc_seconds_ > 0) out.seconds.emplace_back("disc", disc_seconds_);
        if (totals_.constant_leaves > 0)
            out.skipped.push_back(std::to_string(totals_.constant_leaves) +
                                  " leaves under flat water are constant and were not summed");
        if (const KeptTiles* kept = voxelise_.kept; kept && kept->found() > 0)
            out.skipped.push_back(std::to_string(kept->found()) + " of " + std::to_string(kept->lookedFor()) +
                                  " tiles of light are as in the frame before and were not summed");
    }

private:
    // One sample of a light through every surface, and on through every history that it begins.
    void addSample(const Light& light, const LightSample& sample, LobeFields& field, FaintLight* faint, bool is_last) {
        const TubeSink sink = [&](TubeSets&& sets) { lay(std::move(sets), field); };
        LaunchOptions options = launch_;
        options.tubes.channels = field.first.channels().irradiance;
        HistoryLauncher launcher(optics_, spectrum_, options, limits_, sink, monitor_);
        launcher.shareFaint(faint, is_last);
        for (std::size_t i = 0; i < scene_.surfaces.size(); ++i) {
            const Surface& surface = scene_.surfaces[i];
            const LaunchDomain domain =
                surface.height_field ? launchDomain(scene_, surface, light, frame_) : LaunchDomain{};
            launcher.launch(Emission(scene_, static_cast<int>(i), sample), domain, launched_);
            monitor_.nextLaunch();
        }
    }

    // A deposit goes through all leaves: the few tubes of a long history wait for others.
    void lay(TubeSets&& sets, LobeFields& field) {
        std::size_t tubes = 0;
        for (std::size_t s = 0; s < sets.size(); ++s) {
            if (waiting_[s].empty())
                waiting_[s] = std::move(sets[s]);
            else
                waiting_[s].append(sets[s]);
            tubes += waiting_[s].tubes.size();
        }
        if (tubes >= kTubesADeposit) layWaiting(field);
    }

    void layWaiting(LobeFields& field) {
        const Stopwatch watch;
        std::optional<ErnstFans> fans;
        if (options_.interpolation == BeamsInterpolation::Ernst) fans.emplace(waiting_);
        for (std::size_t s = 0; s < waiting_.size(); ++s) {
            const TubeSet& set = waiting_[s];
            if (set.empty()) continue;
            LightField& lobe = s < kSetsALobe ? field.first : *field.second;
            if (!fans) {
                voxelise(set, lobe, voxelise_, totals_, monitor_);
                continue;
            }
            depositErnst(set, *fans, s, lobe, monitor_);
            // What the tubes carry, for the ledger: its imbalance is the interpolation's error in energy.
            LightField exact(lobe.neededPtr(), {lobe.channels().irradiance, false});
            voxelise(set, exact, voxelise_, totals_, monitor_);
        }
        for (TubeSet& set : waiting_) set = TubeSet{};
        deposit_seconds_ += watch.seconds();
    }

    const Scene& scene_;
    const BeamsOptions& options_;
    GridFrame frame_;
    std::vector<SpectralSample> spectrum_;
    OpticalScene optics_;
    FollowLimits limits_;
    BeamsProgress& monitor_;
    LaunchOptions launch_;
    VoxeliseOptions voxelise_;
    LaunchTotals launched_;
    DepositTotals totals_;
    TubeSets waiting_;
    double deposit_seconds_ = 0, disc_seconds_ = 0, deposited_ = 0, beside_tile_ = 0;
};

/// @param empty  of the channels that are baked
LobeFields bakeLights(const Scene& scene, LobeFields empty, const BeamsOptions& options, BeamsProgress& monitor,
                      BakeReport& report) {
    LobeFields field = std::move(empty);
    const auto needed = field.first.neededPtr();
    const FieldChannels channels = field.first.channels();
    BeamsBake bake(scene, options, needed->frame(), monitor);
    monitor.beginRun(bake.launches());
    // Lights without a blur share the field; a blur belongs to one light, so the others are baked beside it and added.
    bool dark = true;
    for (const Light& light : scene.lights)
        if (!bake.blurs(light)) bake.addLight(light, field), dark = false;
    bake.measureDeposit(field);
    for (const Light& light : scene.lights) {
        if (!bake.blurs(light)) continue;
        if (dark) {
            bake.addLight(light, field), dark = false;
            continue;
        }
        LobeFields part = emptyLobes(needed, channels, scene.bake.lobe_axis.has_value());
        bake.addLight(light, part);
        addField(field.first, part.first);
        if (part.second) addField(*field.second, *part.second);
    }
    bake.report(report);
    return field;
}

// The `caustic` grid: irradiance over that of the same scene with a flat surface; 0 where the flat one is dark.
LightField causticGrid(const Scene& scene, const LobeFields& lobes, const BeamsOptions& options,
                       BeamsProgress& monitor) {
    Scene flat = scene;
    flat.bake.lobe_axis.reset();
    for (Surface& surface : flat.surfaces)
        if (surface.height_field) surface.height_field = makeFlatField(surface.center.z);
    BakeReport unused;
    const LobeFields level =
        bakeLights(flat, emptyLobes(lobes.first.neededPtr(), {1, false}, false), options, monitor, unused);
    LightField caustic(lobes.first.neededPtr(), {1, false});
    const double dark = 1e-3 * scene.referenceIrradiance();
    forEachLeaf(caustic.needed(), [&](int slot) {
        std::array<double, LightField::kLeafVoxels> lit, unfocused;
        if (!totalIrradiance(lobes, slot, lit.data()) || !totalIrradiance(level, slot, unfocused.data())) return;
        float* out = caustic.makeDense(slot);
        for (std::size_t v = 0; v < lit.size(); ++v)
            out[v] = unfocused[v] > dark ? static_cast<float>(lit[v] / unfocused[v]) : 0.0f;
    });
    return caustic;
}

std::string beamsRefusal(const Scene& scene) {
    if (scene.bake.paths == Paths::All) return "paths = \"all\" is not built yet; use paths = \"caustic\"";
    return specularRefusal(scene);
}

BeamsOptions givenOptions(const Scene& scene, const GivenOptions& given) {
    BeamsOptions options;
    applyOptions<BeamsOptions>("beams", options, beamsOptions(), given);
    if (options.disc != BeamsDisc::Blur) return options;
    const bool discs = std::any_of(scene.lights.begin(), scene.lights.end(),
                                   [](const Light& light) { return light.angular_diameter_deg > 0; });
    const std::string why = discs ? blurRefusal(scene) : std::string();
    if (!why.empty())
        throw Error(ErrorCode::Input,
                    "beams.disc = \"blur\" lays one blur over the light: " + why + "; use \"sample\", or leave it out",
                    given.at("disc").where);
    return options;
}

// Blurs take light from beside a tile; a disc is widened a little for its second moment.
int beamsReach(const Scene& scene, const GridFrame& frame, const GivenOptions& given) {
    constexpr double kWidened = 2;
    const double reach = behindWalls(scene, frame, givenOptions(scene, given));
    return reach > 0 ? static_cast<int>(reach + kWidened) : 0;
}

BakeResult bakeBeams(const Scene& scene, std::shared_ptr<const NeededVoxels> needed, const GivenOptions& given,
                     Monitor& monitor) {
    const BeamsOptions options = givenOptions(scene, given);
    const bool flux = scene.bake.grids.direction;
    const FieldChannels channels{scene.coloured() ? 3 : 1, flux};
    BakeReport report;
    BeamsProgress progress(monitor, scene.bake.grids.caustic ? 2 : 1);
    LobeFields field =
        bakeLights(scene, emptyLobes(needed, channels, scene.bake.lobe_axis.has_value()), options, progress, report);
    std::optional<LightField> caustic;
    if (scene.bake.grids.caustic) caustic = causticGrid(scene, field, options, progress);
    BakeResult result{std::move(field.first), std::move(report), std::nullopt, std::nullopt, std::move(caustic)};
    result.second = std::move(field.second);
    return result;
}

}  // namespace

Method beamsMethod() {
    return {"beams",
            "Ray tubes, exact in energy: water, glass, mirrors, many bounces, shadows, colour, the sun's disc",
            {"irradiance", "direction", "caustic"},
            optionSpecs<BeamsOptions>(beamsOptions()),
            beamsRefusal,
            [](const CostQuestion& question) {
                return beamsCost(question, givenOptions(question.scene, question.options));
            },
            bakeBeams,
            StandardError::Unknown,
            beamsReach};
}

}  // namespace photic
