// SPDX-License-Identifier: Apache-2.0
#include "tests/stability/laws.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <utility>

#include "bake/field/grid_laws.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"
#include "bake/threads/parallel_for.h"
#include "tests/conformance/bake_scene.h"

namespace photic::stability {
namespace {

/// Limits of the laws. Those of ledgers and linearity are rounding; the others are what the method's own settings
/// allow.
constexpr double kLedger = 1e-5, kFarLedger = 1e-3;  // far: more than 1e5 voxels from the origin
constexpr double kLinear = 1e-5;                     // of the brightest voxel
constexpr double kMoved = 5e-3;                      // relative L1 of blocks of 4^3 voxels
constexpr double kBand = 1e-4;                       // relative L1 of the band's voxels
// Of a disc where objects throw shadows [voxels]; where they are planes alone the band is as much wider.
constexpr int kWidestBlur = 2;
constexpr double kRefined = 0.02;       // the same, a quarter of the tolerance
constexpr double kRefinedGlass = 0.05;  // bodies of few voxels, seen through others
constexpr double kPhotons = 0.02;       // relative, of all light; and of the power, of what was emitted
// The same of media whose index varies: which light has met them, and what of it they absorb, is known to a voxel.
constexpr double kPhotonsBent = 0.06;
// Of balls [voxels]: their index is 1 at the rim, so that what they do there fades out between two samples of it.
constexpr double kRimOfBall = 0.25;
constexpr std::int64_t kPhotonCount = 1 << 18;
// Few photons tell that light is right where they say so twice, with half of what is allowed.
constexpr std::int64_t kFewPhotons = 1 << 14;
constexpr double kFewShare = 0.5;
// Tubes half as wide, or four times as many places of a lamp, are off by this of what they were at most.
constexpr double kNearer = 0.8;
constexpr int kEnoughSamples = 64;  // of a lamp's places, to know its light as a whole

Baked bakeModel(const SceneModel& scene, const std::string& directory) {
    Monitor monitor;
    Scene parsed = parseScene(scene.toml(directory), "scene.toml", directory, 0, monitor);
    const std::string method = parsed.bake.method;
    return whole(bakeScene(std::move(parsed), method));
}

bool followsAllLight(const SceneModel& scene) {
    return scene.method == "beams" || scene.method == "photons" || scene.method == "wavefront";
}

// That a scene gives one of its method's options; 0 where it does not.
double number(const SceneModel& scene, const char* key) {
    const std::size_t at = scene.options.find(key);
    return at == std::string::npos ? 0 : std::atof(scene.options.c_str() + at + std::strlen(key));
}

// Of tubes, where the scene says how wide they are to be [voxels]; else a quarter of one and less.
double tubeWidth(const SceneModel& scene) {
    if (const double cells = number(scene, "mesh = "); cells > 0)
        return std::max(1.0, scene.patch) * scene.voxels / cells;
    return number(scene, "spacing = ");
}

// Whether it is the scene that says how wide tubes are, or at how many places a large lamp is sampled.
bool isDividedByHand(const SceneModel& scene) {
    const auto sampled = [](const SceneModel::Lamp& lamp) {
        return lamp.kind == SceneModel::LampKind::Rectangle && lamp.samples < kEnoughSamples;
    };
    return number(scene, "mesh = ") > 0 || number(scene, "spacing = ") > 0 ||
           std::any_of(scene.lamps.begin(), scene.lamps.end(), sampled);
}

void setNumber(SceneModel& scene, const std::string& key, const std::string& line) {
    const std::size_t at = scene.options.find(key);
    if (at != std::string::npos) scene.options.replace(at, scene.options.find('\n', at) + 1 - at, line);
}

SceneModel dividedMore(SceneModel scene) {
    setNumber(scene, "mesh = ", fmt::format("mesh = {}\n", 2 * static_cast<int>(number(scene, "mesh = "))));
    setNumber(scene, "spacing = ", fmt::format("spacing = {:.4f}\n", 0.5 * number(scene, "spacing = ")));
    for (SceneModel::Lamp& lamp : scene.lamps) lamp.samples = std::min(4 * lamp.samples, kEnoughSamples);
    return scene;
}

SceneModel dividedByItself(SceneModel scene) {
    setNumber(scene, "mesh = ", ""), setNumber(scene, "spacing = ", "");
    for (SceneModel::Lamp& lamp : scene.lamps) lamp.samples = kEnoughSamples;
    return scene;
}

// Of light, how well it is known which of it meets a medium whose index varies.
double allowedByIndex(const SceneModel& scene) {
    switch (scene.index) {
        case SceneModel::Index::None:
            return kPhotons;
        case SceneModel::Index::Luneburg:
        case SceneModel::Index::FishEye:
            return kPhotons + 2 * kRimOfBall / (scene.index_radius * scene.voxels);
        default:
            return kPhotonsBent;
    }
}

// Light [W m] too faint to be held to: what goes over an edge or two by a voxel.
double faint(const SceneModel& scene, const BakeReport& report) {
    return 0.02 * report.power.emitted * scene.voxelSize();
}

std::optional<Violation> brokenLedger(const SceneModel& scene, const Baked& baked) {
    const BakeReport& report = baked.result.report;
    if (!followsAllLight(scene)) return std::nullopt;
    const glm::ivec3 s = glm::abs(scene.shift);
    const double limit = std::max({s.x, s.y, s.z}) > 100'000 ? kFarLedger : kLedger;
    if (!(report.power.imbalance() <= limit))
        return Violation{"power_ledger", fmt::format("open by {:.3e}, limit {:.0e}", report.power.imbalance(), limit)};
    // Sums below a millionth of the light are left out.
    const GridFrame& frame = baked.field().frame();
    const double volume = frame.voxelVolume() * static_cast<double>(frame.voxelCount());
    const double left_out = 1e-6 * baked.scene.referenceIrradiance() * volume;
    const double open = std::fabs(report.path.deposited - report.path.expected);
    if (!(open <= limit * report.path.expected + left_out))
        return Violation{"path_ledger",
                         fmt::format("open by {:.3e} (deposited {:.6e}, expected {:.6e}), limit {:.0e}",
                                     report.path.imbalance(), report.path.deposited, report.path.expected, limit)};
    return std::nullopt;
}

Baked withTwiceTheLight(SceneModel scene, const std::string& directory) {
    scene.brightness *= 2;
    return bakeModel(scene, directory);
}

Baked withThreads(int count, const std::function<Baked()>& bake) {
    setThreadCount(count);
    Baked baked = bake();
    setThreadCount(1);
    return baked;
}

bool sameBake(const Baked& one, const Baked& other, float times) {
    return sameBits(one.field(), other.field(), times) &&
           times * one.result.report.power.escaped == other.result.report.power.escaped;
}

std::optional<Violation> brokenByDoubling(const Baked& one, const Baked& two) {
    const GridFrame& f = one.field().frame();
    double worst = 0, brightest = 0;
    for (int k = f.min.z; k <= f.max.z; ++k)
        for (int j = f.min.y; j <= f.max.y; ++j)
            for (int i = f.min.x; i <= f.max.x; ++i) {
                worst = std::max(worst, std::fabs(two.irradiance(i, j, k) - 2 * one.irradiance(i, j, k)));
                brightest = std::max(brightest, two.irradiance(i, j, k));
            }
    if (worst <= kLinear * brightest) return std::nullopt;
    return Violation{"linear", fmt::format("doubled light is off by {:.2e} of the brightest voxel", worst / brightest)};
}

std::optional<Violation> brokenByMoving(const SceneModel& scene, const Baked& here, const std::string& directory) {
    // Tubes as wide as voxels, or wider, are cut elsewhere.
    if (scene.options.find("spacing") != std::string::npos || scene.options.find("mesh") != std::string::npos)
        return std::nullopt;
    // Waves are summed over blocks of 8^3 voxels, and tell them apart where a wave is as long as a voxel.
    glm::ivec3 step = scene.method == "wave" ? glm::ivec3(8, -16, 8) : glm::ivec3(5, -3, 2);
    // Layers lean from the origin on: a box that is moved up holds other rows, and light goes further or less far in
    // it.
    if (scene.leaning) step.z = 0;
    SceneModel moved = scene;
    moved.shift += step;
    const Baked there = bakeModel(moved, directory);
    // Indices may be moved by the frame too (bands fill the fewest leaves).
    const glm::ivec3 shift = there.field().frame().min - here.field().frame().min;
    const glm::ivec3 was = here.field().frame().size(), is = there.field().frame().size();
    if (is != was)
        return Violation{"moved", fmt::format("moved by whole voxels, the grid has {} x {} x {} voxels instead of {} x "
                                              "{} x {}",
                                              is.x, is.y, is.z, was.x, was.y, was.z)};
    const double off = blockDifference(there.field(), here.field(), 4, shift);
    if (off <= kMoved) return std::nullopt;
    return Violation{"moved", fmt::format("moved by whole voxels, the field differs by {:.2e}", off)};
}

std::optional<Violation> brokenByFields(const Baked& baked) {
    std::optional<Violation> broken = brokenByField(baked.field());
    for (const auto& [name, grid] : baked.result.volume.scalars)
        if (!broken) broken = brokenByField(grid);
    return broken;
}

// Of all threads of this process.
double processorSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// The scene with light wherever it goes.
SceneModel everywhere(SceneModel scene) {
    scene.where = "everywhere";
    return scene;
}

std::optional<Violation> brokenByRefining(const SceneModel& scene, const Baked& plain, const std::string& directory) {
    if (scene.method != "beams" || scene.tolerance > 0.25) return std::nullopt;
    SceneModel finer = scene;
    finer.tolerance /= 4;
    const double off = blockDifference(plain.field(), bakeModel(finer, directory).field(), 4);
    if (off <= (scene.glasses.empty() ? kRefined : kRefinedGlass)) return std::nullopt;
    return Violation{"refined", fmt::format("a quarter of the tolerance changes the light by {:.2e}", off)};
}

/// What photons say of a scene, or by how much they may be off.
struct PhotonSums {
    double light = 0;                                                         // [W m]
    double emitted = 0, culled = 0, dropped = 0, received = 0, absorbed = 0;  // [W]
    static constexpr double PhotonSums::*kAll[] = {&PhotonSums::light,   &PhotonSums::emitted,  &PhotonSums::culled,
                                                   &PhotonSums::dropped, &PhotonSums::received, &PhotonSums::absorbed};
};

PhotonSums photonsOf(const SceneModel& scene, std::int64_t count, int seed, const std::string& directory) {
    SceneModel other = scene;
    other.method = "photons", other.caustic = false;
    other.options = fmt::format("count = {}\nseed = {}\n", count, seed);
    if (scene.options.find("\"off\"") != std::string::npos)
        for (SceneModel::Lamp& lamp : other.lamps) lamp.disc = 0;
    const BakeReport report = bakeModel(other, directory).result.report;
    return {report.path.deposited, report.power.emitted,  report.power.culled,
            report.power.dropped,  report.power.received, report.power.absorbed_surface};
}

/// @param error  standard errors of `p`
/// @param share  of what is allowed
std::optional<Violation> brokenBeside(const PhotonSums& p, const PhotonSums& error, const SceneModel& scene,
                                      const BakeReport& b, double share = 1) {
    constexpr double kSigmas = 3;
    const double scale = std::max(b.path.deposited, p.light);
    // Tubes that are wider than voxels, by the scene's own word, tell waves and bodies roughly.
    const double wide = std::max(1.0, tubeWidth(scene));
    if (wide > 1 && !scene.glasses.empty()) return std::nullopt;
    const double allowed = share * wide * allowedByIndex(scene);
    // What is said to be dropped may be missing, at most on its whole way through the box.
    const double dropped = std::fabs(b.power.dropped - p.dropped) * 2 * scene.scale;
    const double slack = share * (faint(scene, b) + dropped);
    if (std::fabs(b.path.deposited - p.light) > allowed * scale + slack + kSigmas * error.light)
        return Violation{"photons_light", fmt::format("beams leave {:.6e} W m, photons {:.6e} +- {:.1e}",
                                                      b.path.deposited, p.light, error.light)};
    // What touches no needed voxel is counted as culled, by a tube as a whole and by a photon for itself: where they
    // differ there, they may elsewhere.
    const double culled = std::fabs(b.power.culled - p.culled);
    if (std::max(std::fabs(b.power.emitted - p.emitted), culled) > 0.005 * p.emitted) {
        if (share == 1) return std::nullopt;
        return Violation{"photons_blocked", "few photons do not say how much touches no needed voxel"};
    }
    const auto differ = [&](double x, double y, double noise) {
        return std::fabs(x - y) > share * kPhotons * p.emitted + kSigmas * noise;
    };
    if (differ(b.power.received, p.received, error.received) ||
        differ(b.power.absorbed_surface, p.absorbed, error.absorbed))
        return Violation{"photons_blocked",
                         fmt::format("of {:.4e} W beams see {:.4e} received and {:.4e} absorbed at surfaces, photons "
                                     "{:.4e} and {:.4e}",
                                     p.emitted, b.power.received, b.power.absorbed_surface, p.received, p.absorbed)};
    return std::nullopt;
}

// Whether a blur may stand for the disc of a sun.
bool mayBlur(const SceneModel& scene) {
    return scene.options.find("\"off\"") == std::string::npos &&
           scene.options.find("\"sample\"") == std::string::npos &&
           std::any_of(scene.lamps.begin(), scene.lamps.end(), [](const auto& lamp) { return lamp.disc > 0; });
}

// Behind planes that stand, light is laid as far as the blur of a disc reaches, and counts as light there.
bool laysLightBehindWalls(const SceneModel& scene) {
    const auto plane = [](const SceneModel::Thing& thing) { return thing.shape == SceneModel::Shape::Plane; };
    return mayBlur(scene) && std::any_of(scene.things.begin(), scene.things.end(), plane);
}

std::optional<Violation> brokenByPhotons(const SceneModel& scene, const Baked& beams, const std::string& directory) {
    if (scene.method != "beams" && scene.method != "wavefront") return std::nullopt;
    if (laysLightBehindWalls(scene)) {
        SceneModel sharp = scene;
        for (SceneModel::Lamp& lamp : sharp.lamps) lamp.disc = 0;
        return brokenByPhotons(sharp, bakeModel(sharp, directory), directory);
    }
    const BakeReport& report = beams.result.report;
    const auto fewAgree = [&](int seed) {
        return !brokenBeside(photonsOf(scene, kFewPhotons, seed, directory), {}, scene, report, kFewShare);
    };
    if (fewAgree(6) && fewAgree(7)) return std::nullopt;
    const PhotonSums once = photonsOf(scene, kPhotonCount, 1, directory);
    if (!brokenBeside(once, {}, scene, report)) return std::nullopt;
    // Of a lamp close over the water few photons hit where its light is: more of them tell, and how well they know.
    constexpr int kRuns = 4;
    PhotonSums runs[kRuns], mean, error;
    for (int i = 0; i < kRuns; ++i) runs[i] = photonsOf(scene, 2 * kPhotonCount, 2 + i, directory);
    for (double PhotonSums::*const sum : PhotonSums::kAll) {
        for (const PhotonSums& run : runs) mean.*sum += run.*sum / kRuns;
        for (const PhotonSums& run : runs) error.*sum += std::pow(run.*sum - mean.*sum, 2) / (kRuns * (kRuns - 1));
        error.*sum = std::sqrt(error.*sum);
    }
    std::optional<Violation> broken = brokenBeside(mean, error, scene, report);
    if (!broken || !isDividedByHand(scene)) return broken;
    // What a scene divides by hand may be too coarse for it. Then more of it must come nearer to the photons, and what
    // the method takes by itself as near as it has to anywhere.
    const BakeReport finer = bakeModel(dividedMore(scene), directory).result.report;
    const double off = std::fabs(report.path.deposited - mean.light);
    if (!(std::fabs(finer.path.deposited - mean.light) < kNearer * off + faint(scene, report) + error.light))
        return broken;
    const SceneModel by_itself = dividedByItself(scene);
    return brokenByPhotons(by_itself, bakeModel(by_itself, directory), directory);
}

}  // namespace

bool sameBits(const LightField& a, const LightField& b, float times) {
    if (a.leafCount() != b.leafCount()) return false;
    const auto channels = static_cast<std::size_t>(a.channels().count());
    for (int slot = 0; slot < a.leafCount(); ++slot) {
        if (a.state(slot) != b.state(slot)) return false;
        const std::size_t values = a.state(slot) == LeafState::Dense      ? channels * LightField::kLeafVoxels
                                   : a.state(slot) == LeafState::Constant ? channels
                                                                          : 0;
        const float* x = a.state(slot) == LeafState::Dense ? a.dense(slot) : a.constant(slot).data();
        const float* y = b.state(slot) == LeafState::Dense ? b.dense(slot) : b.constant(slot).data();
        for (std::size_t i = 0; i < values; ++i)
            if (std::bit_cast<std::uint32_t>(times * x[i]) != std::bit_cast<std::uint32_t>(y[i])) return false;
    }
    return true;
}

std::optional<Violation> brokenByField(const LightField& field) {
    for (const LawCheck& check : checkLaws(field))
        if (!check.holds)
            return Violation{"field", fmt::format("{}: {:.6e}, limit {:.1e}", check.name, check.value, check.limit)};
    return std::nullopt;
}

std::optional<Violation> brokenByBand(const LightField& band, const LightField& whole, int blur) {
    const NeededVoxels& needed = band.needed();
    // What a blur takes from beside the band it takes for like what is in it.
    const auto knowsAllBeside = [&](const glm::ivec3& voxel) {
        for (int x = -blur; x <= blur; ++x)
            for (int y = -blur; y <= blur; ++y)
                if (!needed.contains(voxel + glm::ivec3(x, y, 0))) return false;
        return true;
    };
    // Indices may be moved by the frame (bands fill the fewest leaves).
    const glm::ivec3 shift = whole.frame().min - band.frame().min;
    double off = 0, sum = 0;
    for (int slot = 0; slot < needed.leafCount(); ++slot) {
        const NeededVoxels::Mask& mask = needed.mask(slot);
        for (int index = 0; index < LightField::kLeafVoxels; ++index) {
            if (!(mask[static_cast<std::size_t>(index / 64)] >> (index % 64) & 1)) continue;
            const glm::ivec3 voxel = needed.leafOrigin(slot) + glm::ivec3(index / 64, index / 8 % 8, index % 8);
            if (!knowsAllBeside(voxel)) continue;
            const double x = band.irradiance(voxel), y = whole.irradiance(voxel + shift);
            off += std::fabs(x - y), sum += y;
        }
    }
    if (off <= kBand * sum) return std::nullopt;
    return Violation{"band", fmt::format("around receivers alone the light is off by {:.2e} of what it is there where "
                                         "all is baked",
                                         off / sum)};
}

void judgeLaws(const SceneModel& scene, const std::string& directory, const Tell& tell) {
    double last = processorSeconds();
    const auto judge = [&](const char* law, std::optional<Violation> broken) {
        Judgement judgement{law, 0, std::move(broken)};
        const double now = processorSeconds();
        judgement.seconds = now - last, last = now;
        tell(judgement);
    };
    setThreadCount(1);
    const Baked baked = bakeModel(scene, directory);
    judge("field", brokenByFields(baked));
    judge("ledger", brokenLedger(scene, baked));
    judge("photons", brokenByPhotons(scene, baked, directory));
    // Where all but nothing is lit, what is there is rounding.
    const BakeReport& report = baked.result.report;
    if (report.path.deposited < 1e-9 * report.power.emitted * scene.scale) return;
    // Doubling changes no bit but those of the exponent: where twice the light on three threads is twice that of one
    // thread to the bit, one bake tells both laws.
    const Baked both = withThreads(3, [&] { return withTwiceTheLight(scene, directory); });
    if (sameBake(baked, both, 2)) {
        judge("linear and threads", std::nullopt);
    } else {
        judge("linear", brokenByDoubling(baked, both));
        const bool same = sameBake(baked, withThreads(3, [&] { return bakeModel(scene, directory); }), 1);
        judge("threads",
              same ? std::nullopt : std::optional(Violation{"threads", "one thread and three give other bits"}));
    }
    const auto judgeWhole = [&](const SceneModel& all_of_it, const Baked& bake) {
        judge("moved", brokenByMoving(all_of_it, bake, directory));
        judge("refined", brokenByRefining(all_of_it, bake, directory));
    };
    if (scene.where == "everywhere") return judgeWhole(scene, baked);
    // Blocks of which a band holds a few voxels are no means: light moves in and out of them.
    const SceneModel all_of_it = everywhere(scene);
    const Baked bake = bakeModel(all_of_it, directory);
    judge("band", brokenByBand(baked.field(), bake.field(), mayBlur(scene) ? kWidestBlur : 0));
    judgeWhole(all_of_it, bake);
}

}  // namespace photic::stability
