// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/photons.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <mutex>
#include <optional>

#include "bake/deposit/track_deposit.h"
#include "bake/methods/graded_photons.h"
#include "bake/methods/lobe_axis.h"
#include "bake/methods/method_options.h"
#include "bake/methods/photon_launch.h"
#include "bake/methods/photon_paths.h"
#include "bake/methods/photon_statistics.h"
#include "bake/methods/photon_tracer.h"
#include "bake/paths/optical_scene.h"
#include "bake/report/stopwatch.h"
#include "bake/threads/parallel_for.h"
#include "bake/tubes/histories.h"

namespace photic {
namespace {

constexpr std::uint64_t kBlock = 1 << 18;           // paths that are put in order together
constexpr std::uint32_t kPathsBetweenLooks = 4096;  // at whether to stop
constexpr unsigned kTiles = 64;  // of the launched patch, a side: a tile's tracks share their voxels in the cache

/// The paths of one light by one surface.
class SurfacePaths final : public PhotonPaths {
public:
    SurfacePaths(PhotonLaunch launch, const PhotonTracer& tracer) : launch_(std::move(launch)), tracer_(tracer) {}
    int dimensions() const override { return launch_.dimensions(); }
    double estimatedPower() const override { return launch_.estimatedPower(); }
    void follow(const std::array<double, 4>& x, double share, TrackSink& field, PhotonTally& tally) const override {
        const PhotonStart start = launch_.start(x);
        if (channelMean(start.power) > 0) tracer_.follow(launch_.surface(), start, start.power * share, field, tally);
    }

private:
    PhotonLaunch launch_;
    const PhotonTracer& tracer_;
};

/// Paths and how many of them a repetition follows.
struct Job {
    std::unique_ptr<const PhotonPaths> paths;
    std::uint64_t paths_a_shift = 0;
};

void shareOut(const PhotonOptions& options, std::vector<Job>& jobs) {
    double total = 0;
    for (const Job& job : jobs) total += job.paths->estimatedPower();
    for (Job& job : jobs) {
        const double share = job.paths->estimatedPower() / total;
        job.paths_a_shift = static_cast<std::uint64_t>(
            std::max(1.0, std::round(share * static_cast<double>(options.count) / options.shifts)));
    }
}

std::vector<Job> surfaceJobs(const Scene& scene, const GridFrame& frame, const PhotonTracer& tracer, BakeReport& report,
                             Monitor& monitor) {
    std::vector<Job> jobs;
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i)
        for (const Light& light : scene.lights) {
            const Surface& surface = scene.surfaces[i];
            PhotonLaunch launch(scene, static_cast<int>(i), light, frame);
            if (launch.empty()) {
                report.skipped.push_back(
                    fmt::format("light '{}' on surface '{}': none of it can reach the grid", light.name, surface.name));
                continue;
            }
            if (!launch.complete())
                monitor.warn(fmt::format(
                    "light '{}' leaves surface '{}' almost horizontally: some of it starts too far away to be "
                    "launched",
                    light.name, surface.name));
            jobs.push_back({std::make_unique<SurfacePaths>(std::move(launch), tracer)});
        }
    return jobs;
}

/// Puts a zero between the low eight bits: two of these interleaved number tiles along a Z curve, which keeps near what
/// is near.
std::uint32_t spread(std::uint32_t x) {
    x = (x | x << 4) & 0x0f0f;
    x = (x | x << 2) & 0x3333;
    return (x | x << 1) & 0x5555;
}

/// Indices of a block of points, tile by tile of the launched patch: neighbouring tracks meet their voxels in the
/// cache. A counting sort, so the order depends on nothing but the points.
void orderByTile(const PhotonPoints& points, std::uint64_t first, std::uint32_t count,
                 std::vector<std::uint32_t>& tiles, std::vector<std::uint32_t>& order) {
    tiles.resize(count), order.resize(count);
    std::vector<std::uint32_t> ends(kTiles * kTiles + 1, 0);
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto x = points.at(first + i);
        tiles[i] =
            spread(static_cast<std::uint32_t>(x[0] * kTiles)) * 2 + spread(static_cast<std::uint32_t>(x[1] * kTiles));
        ++ends[tiles[i] + 1];
    }
    for (std::size_t t = 1; t < ends.size(); ++t) ends[t] += ends[t - 1];
    for (std::uint32_t i = 0; i < count; ++i) order[ends[tiles[i]]++] = i;
}

/// Tells each track to the accumulator of its lobe.
template <class Real>
class LobeTracks final : public TrackSink {
public:
    /// @param lobes  one accumulator, or two, side by side
    LobeTracks(TrackAccumulator<Real>* lobes, const std::optional<glm::dvec3>& axis) : lobes_(lobes), axis_(axis) {}
    DepositedTrack deposit(const Track& track) override {
        return lobes_[axis_ && glm::dot(track.direction, *axis_) < 0 ? 1 : 0].deposit(track);
    }

private:
    TrackAccumulator<Real>* lobes_;
    const std::optional<glm::dvec3>& axis_;
};

/// All paths of one repetition.
class ShiftRun {
public:
    ShiftRun(const std::vector<Job>& jobs, const PhotonOptions& options, Monitor& monitor)
        : jobs_(jobs), options_(options), monitor_(monitor) {
        for (const Job& job : jobs) {
            const auto blocks_a_shift = (job.paths_a_shift + kBlock - 1) / kBlock;
            blocks_ += static_cast<double>(blocks_a_shift) * options.shifts;
        }
    }

    PhotonTally run(int shift, TrackSink& field) {
        PhotonTally tally;
        std::vector<std::uint32_t> tiles, order;
        for (std::size_t j = 0; j < jobs_.size(); ++j) {
            const Job& job = jobs_[j];
            const PhotonPoints points(options_.sampling, job.paths->dimensions(),
                                      static_cast<std::uint64_t>(options_.seed),
                                      static_cast<std::uint64_t>(shift) * jobs_.size() + j);
            for (std::uint64_t first = 0; first < job.paths_a_shift; first += kBlock) {
                const auto count = static_cast<std::uint32_t>(std::min(kBlock, job.paths_a_shift - first));
                orderByTile(points, first, count, tiles, order);
                for (std::uint32_t n = 0; n < count; ++n) {
                    // A block may take seconds.
                    if (n % kPathsBetweenLooks == 0) monitor_.checkCancelled();
                    job.paths->follow(points.at(first + order[n]), 1 / static_cast<double>(job.paths_a_shift), field,
                                      tally);
                }
                tally.rays += count;
                const std::lock_guard lock(mutex_);
                monitor_.progress("trace", ++blocks_done_ / blocks_);
            }
        }
        return tally;
    }

private:
    const std::vector<Job>& jobs_;
    const PhotonOptions& options_;
    Monitor& monitor_;
    double blocks_ = 0, blocks_done_ = 0;
    std::mutex mutex_;
};

/// Whether a repetition sends so many paths through a voxel that sums in single precision would lose digits: many equal
/// deposits are off by 3e-8 each.
bool crowded(const std::vector<Job>& jobs, const GridFrame& frame) {
    constexpr double kPathsAColumn = 32;
    double paths = 0;
    for (const Job& job : jobs) paths += static_cast<double>(job.paths_a_shift);
    return paths > kPathsAColumn * std::pow(static_cast<double>(frame.voxelCount()), 2.0 / 3);
}

/// What is summed of each track, and where.
struct Lobes {
    const NeededVoxels& needed;
    FieldChannels channels;
    std::optional<glm::dvec3> axis;  ///< that parts the light in two
};

/// Whole repetitions in parallel, as many at a time as there are threads; folded in their order.
template <class Real>
PhotonTally runShifts(const std::vector<Job>& jobs, const PhotonOptions& options, Monitor& monitor, const Lobes& parts,
                      PhotonStatistics& statistics) {
    const int threads = std::min(threadCount(), options.shifts);
    const std::size_t lobes = parts.axis ? 2 : 1;
    std::vector<TrackAccumulator<Real>> scratch;
    for (std::size_t t = 0; t < static_cast<std::size_t>(threads) * lobes; ++t)
        scratch.emplace_back(parts.needed, parts.channels);
    std::vector<PhotonTally> tallies(static_cast<std::size_t>(options.shifts));
    ShiftRun shifts(jobs, options, monitor);
    for (int first = 0; first < options.shifts; first += threads) {
        const int wave = std::min(threads, options.shifts - first);
        parallelFor(wave, [&](std::int64_t i) {
            LobeTracks<Real> tracks(&scratch[static_cast<std::size_t>(i) * lobes], parts.axis);
            tallies[static_cast<std::size_t>(first + i)] = shifts.run(first + static_cast<int>(i), tracks);
        });
        statistics.fold(scratch, static_cast<std::size_t>(wave));
    }
    PhotonTally total;
    for (const PhotonTally& t : tallies) total.add(t);
    return total;
}

void fillLedgers(const PhotonTally& total, int shifts, BakeReport& report) {
    report.power = total.power;
    for (const auto term : PowerLedger::kTerms) report.power.*term /= shifts;
    report.path.expected = total.path / shifts;
    report.corner_rays = total.rays, report.tubes = total.deposited;
}

std::span<const OptionBinding<PhotonOptions>> photonOptions() {
    using O = PhotonOptions;
    static const std::vector<OptionBinding<O>> bindings{
        bindOption<O, PhotonSampling>("sampling", &O::sampling,
                                      {{"quasi", PhotonSampling::Quasi}, {"random", PhotonSampling::Random}},
                                      "points of a quasi-random sequence, or plain random ones for comparison"),
        bindOption("count", &O::count, {1000, 1e12}, "paths", "paths in all, over every light, surface and shift"),
        bindOption("shifts", &O::shifts, {16, 4096}, "",
                   "independent repetitions, whose spread gives the standard error"),
        bindOption("wavelengths", &O::wavelengths, {3, 64}, "", "at which light is traced where media disperse"),
        bindOption("seed", &O::seed, {0, 9007199254740992.0}, "", "of the random numbers"),
    };
    return bindings;
}

bool isGraded(const Scene& scene) { return scene.index && !scene.index->objects().empty(); }

std::string photonRefusal(const Scene& scene) {
    if (isGraded(scene)) return gradedSpaceRefusal(scene);
    if (scene.bake.paths == Paths::All)
        return "paths = \"all\" is not built yet; use \"caustic\" and let the renderer add direct light";
    return specularRefusal(scene);
}

/// What media whose index varies add to a report.
void reportGraded(const GradedPhotons& graded, Monitor& monitor, BakeResult& out) {
    const PowerLedger& power = out.report.power;
    if (const std::string faces = graded.medium().faces(); !faces.empty()) out.report.skipped.push_back(faces);
    out.metadata["spline"] = graded.medium().splineName();
    out.report.field_bytes += graded.bytes();
    if (power.dropped > 1e-3 * power.emitted)
        monitor.warn(
            fmt::format("{:.2g} of the light goes round in a medium until it is given up, and is counted as "
                        "dropped",
                        power.dropped / power.emitted));
}

MethodCost photonCost(const CostQuestion& question) {
    PhotonOptions options;
    applyOptions("photons", options, photonOptions(), question.options);
    const int threads = std::min(threadCount(), options.shifts);
    const double channels = (question.scene.coloured() ? 3 : 1) + (question.scene.bake.grids.direction ? 3 : 0);
    // Seconds of a path's start and of each layer that it crosses, on one thread of a 2.6 GHz server core.
    constexpr double kSecondsAPath = 2e-7, kSecondsALayer = 2e-8, kSecondsAVoxel = 5.5e-8;
    const double trace =
        static_cast<double>(options.count) * (kSecondsAPath + kSecondsALayer * question.frame.size().z);
    MethodCost cost;
    cost.stages = {{"trace", trace}, {"field", question.needed_voxels * kSecondsAVoxel}};
    const double lobes = question.scene.bake.lobes > 1 && lightCanOppose(question.scene) ? 2 : 1;
    cost.bytes = question.needed_voxels * ((lobes * channels + 1) * 8 + threads * lobes * (channels * 8 + 4));
    if (isGraded(question.scene)) {
        // Seconds of a voxel's index, and of a voxel that a photon is bent in.
        constexpr double kSecondsANode = 3e-7, kSecondsAVoxelOfWay = 5e-7;
        const GradedSpace medium(question.scene, question.frame, {});
        const glm::dvec3 size(medium.space().high - medium.space().low + 1);
        const double nodes = size.x * size.y * size.z, passes = medium.passes();
        cost.stages = {{"index", passes * nodes * kSecondsANode},
                       {"trace", static_cast<double>(options.count) * passes * std::cbrt(nodes) * kSecondsAVoxelOfWay},
                       {"field", question.needed_voxels * kSecondsAVoxel}};
        cost.bytes += passes * nodes * (medium.attenuate() ? 5 : 4);
    }
    if (options.count > PhotonOptions{}.count)
        cost.dearest =
            fmt::format("most of the time goes into {} paths: a lower count is quicker in proportion", options.count);
    return cost;
}

BakeResult bakeFromCatalogue(const Scene& scene, std::shared_ptr<const NeededVoxels> needed, const GivenOptions& given,
                             Monitor& monitor) {
    PhotonOptions options;
    applyOptions("photons", options, photonOptions(), given);
    return bakePhotons(scene, std::move(needed), options, monitor);
}

}  // namespace

BakeResult bakePhotons(const Scene& scene, std::shared_ptr<const NeededVoxels> needed, const PhotonOptions& options,
                       Monitor& monitor) {
    BakeReport report;
    const Stopwatch watch;
    const FieldChannels channels{scene.coloured() ? 3 : 1, scene.bake.grids.direction};
    const std::vector<SpectralSample> spectrum = spectralSamples(options.wavelengths);
    std::optional<PhotonTracer> tracer;
    std::optional<GradedPhotons> graded;
    std::vector<Job> jobs;
    if (isGraded(scene)) {
        graded.emplace(scene, needed->frame(), monitor);
        for (const Light& light : scene.lights) jobs.push_back({graded->pathsOf(light)});
    } else {
        tracer.emplace(scene, needed->frame(), spectrum);
        jobs = surfaceJobs(scene, needed->frame(), *tracer, report, monitor);
    }
    shareOut(options, jobs);

    const Lobes parts{*needed, channels, channels.flux ? scene.bake.lobe_axis : std::nullopt};
    PhotonStatistics statistics(needed, channels, parts.axis ? 2 : 1);
    const PhotonTally total = crowded(jobs, needed->frame())
                                  ? runShifts<double>(jobs, options, monitor, parts, statistics)
                                  : runShifts<float>(jobs, options, monitor, parts, statistics);
    report.seconds.emplace_back("trace", watch.seconds());

    const Stopwatch field_watch;
    monitor.progress("field", 0);
    PhotonStatistics::Result result = statistics.result();
    fillLedgers(total, options.shifts, report);
    const auto& [first, second] = result.field;
    const double share = needed->frame().voxelVolume() / channels.irradiance;
    for (int c = 0; c < channels.irradiance; ++c) {
        report.path.deposited += (first.sum(c) + (parts.axis ? second->sum(c) : 0)) * share;
        report.path.expected -= (first.sumBesideTile(c) + (parts.axis ? second->sumBesideTile(c) : 0)) * share;
    }
    report.active_voxels = result.active_voxels;
    report.seconds.emplace_back("field", field_watch.seconds());
    BakeResult out{std::move(result.field.first),
                   std::move(report),
                   std::move(result.standard_error),
                   std::move(result.path_count),
                   {},
                   {},
                   {}};
    out.second = std::move(result.field.second);
    if (graded) reportGraded(*graded, monitor, out);
    return out;
}

Method photonsMethod() {
    return {"photons",
            "Quasi-random photon paths with a standard error per voxel: the reference",
            {"irradiance", "direction"},
            optionSpecs(photonOptions()),
            photonRefusal,
            photonCost,
            bakeFromCatalogue,
            StandardError::PerVoxel,
            [](const Scene&, const GridFrame&, const GivenOptions&) { return 0; }};
}

}  // namespace photic
