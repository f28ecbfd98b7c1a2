// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace photic::benchmark {

/// What another program made of the same front: seconds of processor time, and arrivals, x fastest.
struct PeerRun {
    double seconds = 0;
    std::vector<double> arrival;
};

/// scikit-fmm's travel_time, run by the interpreter that PHOTIC_PYTHON names (python3 without it); nothing when it has
/// none.
std::optional<PeerRun> scikitFmm(int n, int order, const std::string& height_in_python);

/// ITK's fast marching (FastMarchingImageFilter, double precision, first order) from cells whose arrival is known;
/// nothing where it was not there when the benchmark was configured.
/// @param known  [cells], x fastest; 1e60 where a cell is to be marched to
std::optional<PeerRun> itkMarching(int n, const std::vector<double>& known);

/// OpenVDB's fast sweeping (tools::sdfToSdf, one iteration, single precision) of the level set z - height, row after
/// row.
PeerRun openvdbSweeping(int n, const std::vector<double>& level_set);

}  // namespace photic::benchmark
