// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/dark_bake.h"

#include <fmt/format.h>

#include <array>

namespace photic {
namespace {

struct Way {
    double PowerLedger::*power;
    const char* words;  ///< completes "98 % of it ..."
};

// Where light can go without lighting a voxel, and what would help.
constexpr std::array<Way, 5> kWays{{
    {&PowerLedger::absorbed_surface,
     "ends on objects before it meets a surface (move them, or give role = \"movable\", which blocks nothing)"},
    {&PowerLedger::reflected, "is reflected (event = \"reflect\" or \"both\" follows that)"},
    {&PowerLedger::culled, "passes beside the voxels that are asked for (move or enlarge the domain)"},
    {&PowerLedger::escaped, "leaves the domain"},
    {&PowerLedger::absorbed_medium, "is absorbed by the medium"},
}};

}  // namespace

std::string darkBakeWarning(const PowerLedger& power) {
    if (!(power.emitted > 0))
        return "nothing is lit: no light meets a surface from which it could get into the domain; look at where the "
               "lights stand and shine, at where the surfaces lie, and at the domain";
    constexpr double kWorthSaying = 0.01;
    std::string ways;
    for (const Way& way : kWays) {
        const double share = power.*way.power / power.emitted;
        if (share < kWorthSaying) continue;
        ways += fmt::format("{}{:.3g} % of it {}", ways.empty() ? ": " : ", ", 100 * share, way.words);
    }
    return fmt::format("nothing is lit by the {:.4g} W of the lights{}", power.emitted, ways);
}

}  // namespace photic
