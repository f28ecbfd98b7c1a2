// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/photons.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>

#include "bake/deposit/track_deposit.h"
#include "bake/methods/method_options.h"
#include "bake/methods/photon_launch.h"
#include "bake/methods/photon_statistics.h"
#include "bake/methods/photon_tracer.h"
#include "bake/paths/optical_scene.h"
#include "bake/threads/parallel_for.h"
#include "bake/tubes/histories.h"

namespace photic {
namespace {

constexpr std::uint64_t kBlock = 1 << 18;           // paths that are put in order together
constexpr std::uint32_t kPathsBetweenLooks = 4096;  // at whether to stop
constexpr unsigned kTiles = 64;  // of the launched patch, a side: a tile's tracks share their voxels in the cache

double secondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// One light on one surface and its share of the paths.
struct Job {
    PhotonLaunch launch;
    std::uint64_t paths_a_shift = 0;
};

std::vector<Job> makeJobs(const Scene& scene, const GridFrame& frame, const PhotonOptions& options, BakeReport& report,
                          Monitor& monitor) {
    std::vector<Job> jobs;
    double total = 0;
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
            total += launch.estimatedPower();
            jobs.push_back({std::move(launch)});
        }
    for (Job& job : jobs) {
        const double share = job.launch.estimatedPower() / total;
        job.paths_a_shift = static_cast<std::uint64_t>(
            std::max(1.0, std::round(share * static_cast<double>(options.count) / options.shifts)));
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

/// All paths of one repetition.
class ShiftRun {
public:
    ShiftRun(const std::vector<Job>& jobs, const PhotonTracer& tracer, const PhotonOptions& options, Monitor& monitor)
        : jobs_(jobs), tracer_(tracer), options_(options), monitor_(monitor) {
        for (const Job& job : jobs) {
            const auto blocks_a_shift = (job.paths_a_shift + kBlock - 1) / kBlock;
            blocks_ += static_cast<double>(blocks_a_shift) * options.shifts;
        }
    }

    template <class Real>
    PhotonTally run(int shift, TrackAccumulator<Real>& field) {
        PhotonTally tally;
        std::vector<std::uint32_t> tiles, order;
        for (std::size_t j = 0; j < jobs_.size(); ++j) {
            const Job& job = jobs_[j];
            const PhotonPoints points(options_.sampling, job.launch.dimensions(),
                                      static_cast<std::uint64_t>(options_.seed),
                                      static_cast<std::uint64_t>(shift) * jobs_.size() + j);
            for (std::uint64_t first = 0; first < job.paths_a_shift; first += kBlock) {
                const auto count = static_cast<std::uint32_t>(std::min(kBlock, job.paths_a_shift - first));
                orderByTile(points, first, count, tiles, order);
                for (std::uint32_t n = 0; n < count; ++n) {
                    // A block may take seconds.
                    if (n % kPathsBetweenLooks == 0) monitor_.checkCancelled();
                    const std::uint32_t i = order[n];
                    const PhotonStart start = job.launch.start(points.at(first + i));
                    if (channelMean(start.power) > 0)
                        tracer_.follow(job.launch.surface(), start,
                                       start.power / static_cast<double>(job.paths_a_shift), field, tally);
                    else
                        ++tally.turned_away;
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
    const PhotonTracer& tracer_;
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

/// Whole repetitions in parallel, as many at a time as there are threads; folded in their order.
template <class Real>
PhotonTally runShifts(const std::vector<Job>& jobs, const PhotonTracer& tracer, const PhotonOptions& options,
                      Monitor& monitor, const NeededVoxels& needed, FieldChannels channels,
                      PhotonStatistics& statistics) {
    const int threads = std::min(threadCount(), options.shifts);
    std::vector<TrackAccumulator<Real>> scratch;
    for (int t = 0; t < threads; ++t) scratch.emplace_back(needed, channels);
    std::vector<PhotonTally> tallies(static_cast<std::size_t>(options.shifts));
    ShiftRun shifts(jobs, tracer, options, monitor);
    for (int first = 0; first < options.shifts; first += threads) {
        const int wave = std::min(threads, options.shifts - first);
        parallelFor(wave, [&](std::int64_t i) {
            tallies[static_cast<std::size_t>(first + i)] =
                shifts.run(first + static_cast<int>(i), scratch[static_cast<std::size_t>(i)]);
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

std::string photonRefusal(const Scene& scene) {
    if (scene.bake.paths == Paths::All)
        return "paths = \"all\" is not built yet; use \"caustic\" and let the renderer add direct light";
    return specularRefusal(scene);
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
    cost.bytes = question.needed_voxels * ((channels + 1) * 8 + threads * (channels * 8 + 4));
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
    const auto start = std::chrono::steady_clock::now();
    const FieldChannels channels{scene.coloured() ? 3 : 1, scene.bake.grids.direction};
    const std::vector<Job> jobs = makeJobs(scene, needed->frame(), options, report, monitor);
    const std::vector<SpectralSample> spectrum = spectralSamples(options.wavelengths);
    const PhotonTracer tracer(scene, needed->frame(), spectrum);

    PhotonStatistics statistics(needed, channels);
    const PhotonTally total = crowded(jobs, needed->frame())
                                  ? runShifts<double>(jobs, tracer, options, monitor, *needed, channels, statistics)
                                  : runShifts<float>(jobs, tracer, options, monitor, *needed, channels, statistics);
    report.seconds.emplace_back("trace", secondsSince(start));

    const auto field_start = std::chrono::steady_clock::now();
    monitor.progress("field", 0);
    PhotonStatistics::Result result = statistics.result();
    fillLedgers(total, options.shifts, report);
    for (int c = 0; c < channels.irradiance; ++c)
        report.path.deposited += result.field.sum(c) * needed->frame().voxelVolume() / channels.irradiance;
    report.active_voxels = result.active_voxels;
    if (total.turned_away > 0)
        monitor.warn(fmt::format(
            "{:.3g} % of the surface turns away from the light; the shadow that it casts on itself is left out",
            100.0 * static_cast<double>(total.turned_away) / static_cast<double>(total.rays)));
    report.seconds.emplace_back("field", secondsSince(field_start));
    return {std::move(result.field), std::move(report), std::move(result.standard_error), std::move(result.path_count),
            std::nullopt};
}

Method photonsMethod() {
    return {"photons",
            "Quasi-random photon paths with a standard error per voxel: the reference",
            {"irradiance", "direction"},
            optionSpecs(photonOptions()),
            photonRefusal,
            photonCost,
            bakeFromCatalogue,
            StandardError::PerVoxel};
}

}  // namespace photic
