// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/photon_tracer.h"

#include <algorithm>

namespace photic {

PhotonTracer::PhotonTracer(const Scene& scene, const GridFrame& frame, const std::vector<SpectralSample>& spectrum)
    : spectrum_(spectrum), optics_(scene, frame, wavelengthsOf(spectrum)) {
    limits_.events = scene.bake.bounces.value_or(kDefaultBounces);
    limits_.threshold = scene.bake.threshold.value_or(kDefaultThreshold);
}

void PhotonTracer::follow(int surface, const PhotonStart& start, const glm::dvec3& power, TrackSink& field,
                          PhotonTally& tally) const {
    const PathOutcome arrival = optics_.arrivalOn(surface, start.position, start.direction, start.source);
    if (arrival == PathOutcome::Hidden) return;
    tally.power.emitted += channelMean(power);
    if (arrival == PathOutcome::Blocked) {
        tally.power.absorbed_surface += channelMean(power);
        return;
    }
    Photon photon;
    photon.direction = start.direction, photon.power = power, photon.least = limits_.threshold * channelMean(power);
    photon.inside = optics_.startingInside(surface, start.direction, start.face, start.source);
    if (start.source) {
        PowerLedger handed_on;
        photon.power = countLeg(optics_.medium(optics_.mediumOf(photon.inside)), power,
                                glm::length(start.position - *start.source), &PowerLedger::received, handed_on);
        tally.power.absorbed_medium += handed_on.absorbed_medium, tally.power.scattered += handed_on.scattered;
    }
    meet(photon, surface, {start.position, start.normal, start.face}, field, tally);
}

// Light comes to a surface: its wavelengths part there where they do, then its branches.
void PhotonTracer::meet(const Photon& photon, int surface, const Meeting& at, TrackSink& field,
                        PhotonTally& tally) const {
    if (photon.wavelength == 0 && optics_.disperses(surface)) {
        for (std::size_t i = 0; i < spectrum_.size(); ++i) {
            Photon part = photon;
            part.wavelength = static_cast<int>(i) + 1, part.power *= spectrum_[i].weight;
            part.least *= channelMean(spectrum_[i].weight);
            meet(part, surface, at, field, tally);
        }
        return;
    }
    const OpticalScene::Event event = optics_.eventAt(surface, photon.wavelength, photon.inside, photon.direction, at);
    Photon next = photon;
    ++next.events;
    if (event.void_surface) {
        next.inside = event.beyond;
        return runLeg(next, at.position, field, tally);
    }
    tally.power.reflected += event.light.untraced * channelMean(photon.power);
    tally.power.dropped += event.light.dropped * channelMean(photon.power);
    tally.power.absorbed_surface += channelMean(event.light.absorbed * photon.power);
    for (int b = 0; b < event.light.count; ++b) {
        const SpecularBranch& branch = event.light.branches[static_cast<std::size_t>(b)];
        next.direction = branch.direction, next.power = branch.fraction * photon.power;
        next.inside = branch.crosses ? event.beyond : photon.inside;
        runLeg(next, at.position, field, tally);
    }
}

void PhotonTracer::runLeg(Photon photon, const glm::dvec3& origin, TrackSink& field, PhotonTally& tally) const {
    const OpticalMedium& medium = optics_.medium(optics_.mediumOf(photon.inside));
    Track track;
    track.origin = origin, track.direction = photon.direction, track.power = photon.power;
    track.extinction = medium.extinction();
    const OpticalScene::LegEnd leg = optics_.legEnd(origin, photon.direction, photon.inside);

    double inside_from = 0, inside_to = 0;
    const bool inside = optics_.frame().clip(origin, photon.direction, inside_from, inside_to);
    DepositedTrack deposited;
    track.begin = inside_from, track.end = std::min(inside_to, leg.deposit_end);
    if (inside && track.begin < track.end) deposited = field.deposit(track);
    if (deposited.touched) ++tally.deposited, tally.path += deposited.path;

    const bool goes_on = leg.hit.target.kind == Target::Kind::Surface && photon.events < limits_.events &&
                         channelMean(photon.power) >= photon.least;
    if (goes_on) {
        PowerLedger handed_on;
        photon.power = countLeg(medium, photon.power, leg.hit.distance, &PowerLedger::received, handed_on);
        tally.power.absorbed_medium += handed_on.absorbed_medium, tally.power.scattered += handed_on.scattered;
        photon.inside = leg.inside;
        return meet(photon, leg.hit.target.index, leg.meeting, field, tally);
    }
    if (!deposited.touched) {
        tally.power.culled += channelMean(photon.power);
        return;
    }
    // Where the power ends: in the box's side, on an object, or on a surface where it is given up.
    const bool hits = leg.hit.distance <= inside_to;
    double PowerLedger::*const end = !hits                                          ? &PowerLedger::escaped
                                     : leg.hit.target.kind == Target::Kind::Surface ? &PowerLedger::dropped
                                                                                    : &PowerLedger::received;
    countLeg(medium, photon.power, hits ? leg.hit.distance : inside_to, end, tally.power);
}

}  // namespace photic
