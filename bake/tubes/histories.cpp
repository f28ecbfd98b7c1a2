// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/histories.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "bake/paths/light_plane.h"
#include "bake/tubes/lattice.h"

namespace photic {
namespace {

// Shares of an emission's power: below the first a history is followed for one sample of a light only, below the second
// it is divided anew from the launched triangles.
constexpr double kOneSample = 1.0 / 8, kFromRoots = 1.0 / 128;

// Triangles that are looked at one by one: in so many blocks of a sample there are enough that differ.
constexpr std::int64_t kEnoughOfASample = 6000;

// Of a sample's seeds for longer histories so many over the events behind them stand for all, and no fewer than the
// second: there are few histories of few events and many of many.
constexpr std::size_t kSeedsOfASample = 384, kFewestSeedsOfASample = 24;

// Of the tolerance, for light that meets bodies: they gather it into few voxels, where what a chord misplaces is seen,
// and most of their tubes are as small as they are for the sake of an outline.
constexpr double kBodies = 1.0 / 4;

// Of the unfocused light on a voxel's face: seeds that carry less are too faint to be seen one by one.
constexpr double kFaintSeed = 1.0 / 256;

// Of seeds that carry less than `least`, as many as carry that much together; each stands for those before it.
std::vector<TubeSeed> withoutFaint(const std::vector<TubeSeed>& seeds, double least) {
    std::vector<TubeSeed> kept, of_faint;
    double faint = 0, waiting = 0.5 * least;
    for (const TubeSeed& seed : seeds) {
        if (seed.power >= least) {
            kept.push_back(seed);
            continue;
        }
        faint += seed.power, waiting += seed.power;
        if (waiting < least) continue;
        waiting -= least;
        of_faint.push_back(seed);
    }
    if (of_faint.empty()) return seeds;  // so few that they may stay
    for (TubeSeed& seed : of_faint) seed.power = faint / static_cast<double>(of_faint.size());
    // In the order in which they came: those of one launched triangle follow one another.
    kept.insert(kept.end(), of_faint.begin(), of_faint.end());
    std::stable_sort(kept.begin(), kept.end(), [](const TubeSeed& a, const TubeSeed& b) { return a.root < b.root; });
    return kept;
}

// Leaves some seeds of a sample, evenly spread, with the power of all. Returns how many each stands for.
double thinOut(std::vector<TubeSeed>& seeds, std::size_t events) {
    const std::size_t most = std::max(kFewestSeedsOfASample, kSeedsOfASample / events);
    if (seeds.size() <= most) return 1;
    double all = 0, kept = 0;
    for (const TubeSeed& seed : seeds) all += seed.power;
    const double each = static_cast<double>(seeds.size()) / static_cast<double>(most);
    for (std::size_t i = 0; i < most; ++i) {
        seeds[i] = seeds[static_cast<std::size_t>((static_cast<double>(i) + 0.5) * each)];
        kept += seeds[i].power;
    }
    seeds.resize(most);
    for (TubeSeed& seed : seeds) seed.power *= kept > 0 ? all / kept : 1;
    return each;
}

constexpr std::int64_t LaunchTotals::*kWeighed[] = {&LaunchTotals::tubes, &LaunchTotals::corner_rays,
                                                    &LaunchTotals::legs, &LaunchTotals::added, &LaunchTotals::searches};

// The counts that weigh() looks at, without the seeds.
LaunchTotals countsOf(const LaunchTotals& totals) {
    LaunchTotals counts;
    for (std::int64_t LaunchTotals::*const count : kWeighed) counts.*count = totals.*count;
    return counts;
}

// What was counted since `before` counts so many times.
void weigh(const LaunchTotals& before, double times, LaunchTotals& totals) {
    for (std::int64_t LaunchTotals::*const count : kWeighed)
        totals.*count = before.*count + std::llround(times * static_cast<double>(totals.*count - before.*count));
}

std::vector<Branch> branchesOf(const Surface& surface) {
    switch (surface.event) {
        case SurfaceEvent::Refract:
            return {Branch::Refracted};
        case SurfaceEvent::Reflect:
        case SurfaceEvent::Mirror:
            return {Branch::Reflected};
        case SurfaceEvent::Both:
            break;
    }
    return {Branch::Refracted, Branch::Reflected};
}

// Where a dielectric's reflection is all that is asked for, it is what counts: its reflectance straight on.
double fullShare(const OpticalScene& optics, int surface) {
    if (optics.scene().surfaces[static_cast<std::size_t>(surface)].event != SurfaceEvent::Reflect) return 1;
    const double outside = optics.medium(optics.sides(surface).outside).iors[0];
    const double inside = optics.medium(optics.sides(surface).inside).iors[0];
    const double root = (outside - inside) / (outside + inside);
    return std::max(root * root, 1e-4);
}

History continued(const History& history, const PathEvent& event) {
    History out = history;
    out.push_back(event);
    return out;
}

double sumOf(const std::vector<double>& parts) { return std::accumulate(parts.begin(), parts.end(), 0.0); }

std::int64_t trianglesOf(const Lattice& lattice) { return 2 * std::int64_t{lattice.columns} * lattice.rows; }

// Rays of a lattice are traced by the row, and are no legs that are cast one by one.
void launchLattice(Launch& tubes, const Lattice& lattice, LaunchTotals& totals) {
    const std::int64_t legs = totals.legs;
    tubes.heightField(lattice, totals);
    totals.legs = legs, totals.triangles_launched += trianglesOf(lattice);
}

}  // namespace

std::vector<SpectralSample> spectralSamples(int count) {
    const glm::dvec3 channels = RefractiveIndex::kChannels_nm;  // red, green, blue: falling
    const auto power = [](double nm) { return 1 / (nm * nm); };
    // Half a channel's width beyond red and blue.
    const double low = power(channels.x) - 0.5 * (power(channels.y) - power(channels.x));
    const double high = power(channels.z) + 0.5 * (power(channels.z) - power(channels.y));
    std::vector<SpectralSample> samples;
    glm::dvec3 sum(0);
    for (int i = 0; i < count; ++i) {
        const double at = low + (high - low) * (i + 0.5) / count;
        glm::dvec3 weight(0);
        const double g = power(channels.y);
        if (at <= g) {
            weight.y = std::clamp((at - power(channels.x)) / (g - power(channels.x)), 0.0, 1.0);
            weight.x = 1 - weight.y;
        } else {
            weight.z = std::clamp((at - g) / (power(channels.z) - g), 0.0, 1.0);
            weight.y = 1 - weight.z;
        }
        sum += weight;
        samples.push_back({1 / std::sqrt(at), weight});
    }
    for (SpectralSample& sample : samples) sample.weight /= sum;
    return samples;
}

std::vector<double> wavelengthsOf(const std::vector<SpectralSample>& spectrum) {
    std::vector<double> out;
    for (const SpectralSample& sample : spectrum) out.push_back(sample.wavelength_nm);
    return out;
}

FaintLight::Key FaintLight::key(const History& history, int surface, int wavelength) {
    Key key = {surface, wavelength};
    for (const PathEvent& event : history) key.push_back(event.surface * 2 + (event.branch == Branch::Reflected));
    return key;
}

void FaintLight::leave(const History& history, int surface, int wavelength, double power) {
    power_[key(history, surface, wavelength)] += power;
}

double FaintLight::take(const History& history, int surface, int wavelength) {
    const auto found = power_.find(key(history, surface, wavelength));
    return found == power_.end() ? 0.0 : std::exchange(found->second, 0.0);
}

double FaintLight::rest() const {
    double sum = 0;
    for (const auto& [key, power] : power_) sum += power;
    return sum;
}

// The light itself, or its wavelengths where they part at a surface.
std::vector<HistoryLauncher::Light> HistoryLauncher::parted(const Light& light, int surface) const {
    if (light.wavelength > 0 || !optics_.disperses(surface)) return {light};
    std::vector<Light> out;
    for (std::size_t i = 0; i < spectrum_.size(); ++i) {
        LightSample sample = light.emission.sample();
        sample.strength *= spectrum_[i].weight;
        Emission emission(optics_.scene(), light.emission.surfaceIndex(), sample);
        if (light.emission.plane()) emission.launchAcross(*light.emission.plane());
        out.push_back({std::move(emission), static_cast<int>(i) + 1, light.emitted * channelMean(spectrum_[i].weight)});
    }
    return out;
}

// What an emission's unfocused light brings to a voxel's face [W].
double HistoryLauncher::powerOnAVoxel(const Light& light) const {
    const Surface& surface = light.emission.surface();
    const double side = std::cbrt(std::fabs(glm::determinant(optics_.frame().worldFromIndex())));
    return channelMean(light.emission.irradianceAt(surface.center)) * side * side *
           fullShare(optics_, light.emission.surfaceIndex());
}

LaunchOptions HistoryLauncher::optionsFor(const History& history, bool first_branch) const {
    LaunchOptions options = options_;
    options.tubes.counts_emission = first_branch && history.size() == 1;
    options.tubes.counts_event = first_branch;
    const Surface& last = optics_.scene().surfaces[static_cast<std::size_t>(history.back().surface)];
    options.tubes.counts_dropped = !first_branch || branchesOf(last).size() == 1;
    options.tubes.follows_on = static_cast<int>(history.size()) < limits_.events;
    options.refine.full_share = fullShare(optics_, history.front().surface), options.refine.faint = faintness();
    // Light that has come through many faces is faint: its outlines are not worth what they would take.
    constexpr std::size_t kMostFacets = 2;
    options.tubes.faceted =
        history.size() <= kMostFacets && std::all_of(history.begin(), history.end(), [&](const PathEvent& event) {
            const Surface& surface = optics_.scene().surfaces[static_cast<std::size_t>(event.surface)];
            return surface.mesh && !surface.smooth;
        });
    options.refine.fineness = bodyFineness(optics_, history);
    if (history.size() > 1 || optics_.scene().surfaces[static_cast<std::size_t>(history.front().surface)].closed)
        options.refine.tolerance *= kBodies;
    return options;
}

// What is off by faint light is to fall with the tolerance as the rest does, by its square.
double HistoryLauncher::faintness() const {
    constexpr double kUsual = RefineOptions{}.tolerance;
    const double finer = options_.refine.tolerance > 0 ? std::min(1.0, options_.refine.tolerance / kUsual) : 1.0;
    return finer * finer;
}

// How much of the light that counts so many watts are, at most 1.
double HistoryLauncher::shareOf(const Light& light, double power) const {
    const double all = light.emitted * fullShare(optics_, light.emission.surfaceIndex());
    return all > 0 ? std::clamp(power / all, 0.0, 1.0) : 1.0;
}

// Whether the second branch of a body's own event is launched for this sample: a faint one is left to the last sample,
// which takes what the others have left of it. Not for water: what it reflects goes where nothing else does.
// @param shares  of its parts [W]; they and what is emitted become those of all samples that it stands for
bool HistoryLauncher::takesSecond(const History& history, std::vector<double>& shares, Light& light) const {
    constexpr int kThisEvent = -1;  // no surface that it goes on to
    if (!faint_) return true;
    const double power = sumOf(shares);
    if (!takes_faint_) {
        if (power >= kOneSample * light.emitted) return true;
        faint_->leave(history, kThisEvent, light.wavelength, power);
        return false;
    }
    if (!(power > 0)) return true;
    const double times = 1 + faint_->take(history, kThisEvent, light.wavelength) / power;
    light.emitted *= times;
    for (double& watts : shares) watts *= times;
    return true;
}

void HistoryLauncher::launch(const Emission& emission, const LaunchDomain& domain, LaunchTotals& totals) {
    Emission launched = emission;
    if (const auto plane = lightPlane(optics_, emission)) launched.launchAcross(*plane);
    for (Light& light : parted({launched, 0, 0}, emission.surfaceIndex())) begin(std::move(light), domain, totals);
}

// One lattice for both branches, as fine as the one that bends more asks for: they share each part's power out.
std::optional<Lattice> HistoryLauncher::latticeFor(const Light& light, const LaunchDomain& domain) const {
    const Surface& surface = light.emission.surface();
    std::optional<Lattice> lattice;
    if (!surface.height_field || domain.empty()) return lattice;
    for (const Branch branch : branchesOf(surface)) {
        const History history = {{light.emission.surfaceIndex(), branch}};
        const PathTracer tracer(optics_, light.emission, history, light.wavelength);
        const Lattice asked = layLattice(tracer, domain, optionsFor(history, true));
        lattice = lattice ? finerOf(*lattice, asked) : asked;
    }
    return lattice;
}

void HistoryLauncher::begin(Light light, const LaunchDomain& domain, LaunchTotals& totals) {
    const double before = totals.power.emitted;
    bool first_branch = true;
    const int surface = light.emission.surfaceIndex();
    const std::vector<Branch> branches = branchesOf(light.emission.surface());
    std::vector<Lattice> lattices;
    if (const std::optional<Lattice> lattice = latticeFor(light, domain)) {
        lattices = options_.sampled > 0 ? someBlocks(*lattice, options_.sampled) : std::vector{*lattice};
        totals.triangles += static_cast<std::int64_t>(branches.size()) * trianglesOf(*lattice);
    }
    std::vector<std::vector<double>> shares(std::max<std::size_t>(1, lattices.size()));
    const std::int64_t added = totals.added;
    for (const Branch branch : branches) {
        const History history = {{surface, branch}};
        const bool on_body = !light.emission.surface().height_field;
        if (!first_branch && on_body && !takesSecond(history, shares.front(), light)) continue;
        const PathTracer tracer(optics_, light.emission, history, light.wavelength);
        LaunchOptions options = optionsFor(history, first_branch);
        if (!first_branch && on_body) options.tubes.share = shareOf(light, sumOf(shares.front()));
        Launch tubes(tracer, options, sink_, monitor_);
        totals.seeds.clear();
        for (std::size_t i = 0; i < shares.size(); ++i) {
            if (branches.size() > 1) tubes.shareWithOther(shares[i], first_branch);
            if (!light.emission.surface().height_field)
                tubes.mesh(totals);
            else if (i < lattices.size())
                launchLattice(tubes, lattices[i], totals);
            // Both branches are launched in the same parts.
            if (options_.sampled > 0 && first_branch && totals.added - added > kEnoughOfASample) shares.resize(i + 1);
        }
        if (first_branch) light.emitted = totals.power.emitted - before;
        first_branch = false;
        const std::vector<TubeSeed> seeds = std::move(totals.seeds);
        totals.seeds.clear();
        goOn(light, history, seeds, totals);
    }
}

void HistoryLauncher::goOn(const Light& light, const History& history, const std::vector<TubeSeed>& seeds,
                           LaunchTotals& totals) {
    std::map<int, std::vector<TubeSeed>> by_surface;
    for (const TubeSeed& seed : seeds) by_surface[seed.surface].push_back(seed);
    for (auto& [surface, part] : by_surface) {
        double power = 0;
        for (const TubeSeed& seed : part) power += seed.power;
        if (faint_ && !takes_faint_ && power < kOneSample * light.emitted) {
            faint_->leave(history, surface, light.wavelength, power);
            continue;
        }
        const double left = faint_ ? faint_->take(history, surface, light.wavelength) : 0;
        if (power < limits_.threshold * light.emitted) {
            totals.power.dropped += power + left, totals.given_up.threshold += power + left;
            continue;
        }
        for (TubeSeed& seed : part) seed.power *= 1 + left / power;
        const double fineness = bodyFineness(optics_, history);
        // A seed of a sample that stands for others has their power.
        part = withoutFaint(part, stands_for_ * kFaintSeed * faintness() * fineness * fineness * powerOnAVoxel(light));
        const double each = options_.sampled > 0 ? thinOut(part, history.size()) : 1;
        const LaunchTotals before = countsOf(totals);
        stands_for_ *= each;
        followFrom(light, history, surface, part, power, totals);
        stands_for_ /= each;
        if (each > 1) weigh(before, each, totals);
    }
}

// Goes on from seeds on one surface, by wavelengths where they part there.
void HistoryLauncher::followFrom(const Light& light, const History& history, int surface,
                                 const std::vector<TubeSeed>& part, double power, LaunchTotals& totals) {
    const std::vector<Light> lights = parted(light, surface);
    if (lights.size() == 1) return branchAt(lights.front(), history, surface, part, power, totals);
    // Each wavelength gets its own share of what arrives, which depends on the light's colour there.
    const std::vector<glm::dvec3> colours = coloursOf(light, history, surface, part);
    for (std::size_t i = 0; i < lights.size(); ++i) {
        std::vector<TubeSeed> of_one = part;
        double power_of_one = 0;
        for (std::size_t k = 0; k < part.size(); ++k) {
            const double all = channelMean(colours[k]);
            of_one[k].power *=
                all > 0 ? channelMean(colours[k] * spectrum_[i].weight) / all : channelMean(spectrum_[i].weight);
            power_of_one += of_one[k].power;
        }
        branchAt(lights[i], history, surface, of_one, power_of_one, totals);
    }
}

// The light that seeds bring to a surface, by its channels: of those of their corners that come there.
std::vector<glm::dvec3> HistoryLauncher::coloursOf(const Light& light, const History& history, int surface,
                                                   const std::vector<TubeSeed>& seeds) const {
    const PathTracer tracer(optics_, light.emission, history, light.wavelength);
    std::vector<glm::dvec3> colours;
    for (const TubeSeed& seed : seeds) {
        glm::dvec3 sum(0);
        for (const EmissionParam& corner : seed.corner) {
            const Path path = tracer.trace(corner, seed.face);
            if (path.outcome != PathOutcome::Lit || path.end != Target{Target::Kind::Surface, surface}) continue;
            const OpticalMedium& medium = optics_.medium(path.medium);
            for (int c = 0; c < 3; ++c)
                sum[c] += path.arriving[c] * path.fraction[c] *
                          std::exp(-(medium.absorption[c] + medium.scattering[c]) * path.hit_distance);
        }
        colours.push_back(light.emission.sample().strength * (channelMean(sum) > 0 ? sum : glm::dvec3(1)));
    }
    return colours;
}

void HistoryLauncher::branchAt(const Light& light, const History& history, int surface,
                               const std::vector<TubeSeed>& seeds, double power, LaunchTotals& totals) {
    bool first_branch = true;
    std::vector<double> shares;
    const std::vector<Branch> branches = branchesOf(optics_.scene().surfaces[static_cast<std::size_t>(surface)]);
    for (const Branch branch : branches) {
        const History longer = continued(history, {surface, branch});
        const PathTracer tracer(optics_, light.emission, longer, light.wavelength);
        LaunchOptions options = optionsFor(longer, first_branch);
        options.tubes.share = shareOf(light, first_branch ? power : sumOf(shares));
        options.from_roots = !totals.launched_parts && power < kFromRoots * faintness() * light.emitted;
        Launch tubes(tracer, options, sink_, monitor_);
        if (branches.size() > 1) tubes.shareWithOther(shares, first_branch);
        first_branch = false;
        totals.seeds.clear();
        tubes.seeds(seeds, totals);
        const std::vector<TubeSeed> next = std::move(totals.seeds);
        totals.seeds.clear();
        goOn(light, longer, next, totals);
    }
}

}  // namespace photic
