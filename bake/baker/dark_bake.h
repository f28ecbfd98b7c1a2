// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bake/report/bake_report.h"

namespace photic {

/// A sentence for a bake that lit nothing, with where its light went [W] and what to look at.
std::string darkBakeWarning(const PowerLedger& power);

}  // namespace photic
