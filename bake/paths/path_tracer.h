// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/paths/emission.h"
#include "bake/paths/optical_scene.h"
#include "bake/paths/path.h"

namespace photic {

/// Follows one history of one emission: from a parameter through every event to the end of the last leg. The one tracer
/// of tubes; photons take its steps (OpticalScene::arrival, eventAt, legEnd) with all branches.
/// Thread-safe.
class PathTracer {
public:
    /// @param optics  must outlive the tracer
    /// @param history  at least one event, the first at the emission's surface
    /// @param wavelength  of OpticalScene's; 0: white light
    PathTracer(const OpticalScene& optics, const Emission& emission, History history, int wavelength = 0)
        : optics_(optics), emission_(emission), history_(std::move(history)), wavelength_(wavelength) {}

    /// @param face  geometric normal, unit, of the mesh triangle; unused for height fields
    Path trace(const EmissionParam& param, const glm::dvec3& face) const {
        return emission_.plane() ? traceAcross(param) : follow(param, emission_.at(param, face));
    }
    /// From a point of the surface that is known already.
    Path follow(const EmissionParam& param, const EmittedRay& ray) const;

    const OpticalScene& optics() const { return optics_; }
    const Emission& emission() const { return emission_; }
    const History& history() const { return history_; }
    int wavelength() const { return wavelength_; }
    const Surface& surface() const { return emission_.surface(); }

private:
    void takeEvent(const PathEvent& event, const glm::dvec3& direction, const Meeting& at, Path& path) const;
    Path traceAcross(const EmissionParam& param) const;
    void followHistory(const EmittedRay& ray, Path& path) const;
    bool goOn(const PathEvent& event, Path& path) const;

    const OpticalScene& optics_;
    Emission emission_;
    History history_;
    int wavelength_;
};

}  // namespace photic
