// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tests/benchmark/cases.h"
#include "tests/benchmark/table.h"

namespace photic::benchmark {

/// What has been measured so far; every section adds to it.
struct Findings {
    std::vector<Table> tables;
    std::vector<Point> points;  ///< of the 3D pool, for the picture
};

void kernels(const Effort& effort, Findings& findings);       ///< vector kernels against the scalar one
void bakes(const Effort& effort, Findings& findings);         ///< seconds beside the figures to beat
void floorErrors(const Effort& effort, Findings& findings);   ///< mesh against error, exact map
void volumeErrors(const Effort& effort, Findings& findings);  ///< beams and photons at equal error
void threadScaling(const Effort& effort, Findings& findings);
void stages(const Effort& effort, Findings& findings);
void writes(const Effort& effort, Findings& findings);
void skipping(const Effort& effort, Findings& findings);
void eikonalLarge(const Effort& effort, Findings& findings);  ///< the same at 512^3, without peers
void wavesLarge(const Effort& effort, Findings& findings);    ///< waves in the pool at 512^3
void eikonal(const Effort& effort, Findings& findings);       ///< run time against error of fronts, peers beside
void fronts(const Effort& effort, Findings& findings);        ///< through media whose index varies
void frontPeers(const Effort& effort, Findings& findings);    ///< beside the paper's preset, photons and their steps
void waves(const Effort& effort, Findings& findings);         ///< the wave method, beside its paper's table

}  // namespace photic::benchmark
