// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "bake/scene/scene.h"

namespace photic {

// The words by which scene files, the command line and volumes call the settings of a bake.

/// In the order of `Where`.
inline const std::vector<std::string> kWhereNames{"everywhere", "receivers", "media"};
/// In the order of `Paths`.
inline const std::vector<std::string> kPathsNames{"caustic", "all"};

inline const std::string& nameOf(Where where) { return kWhereNames[static_cast<std::size_t>(where)]; }
inline const std::string& nameOf(Paths paths) { return kPathsNames[static_cast<std::size_t>(paths)]; }

/// The grids that a volume may hold, in the order in which they are told.
struct GridName {
    const char* name;
    bool GridSet::*wanted;
};
inline constexpr GridName kGrids[] = {{"irradiance", &GridSet::irradiance},
                                      {"direction", &GridSet::direction},
                                      {"caustic", &GridSet::caustic},
                                      {"arrival_time", &GridSet::arrival_time},
                                      {"density", &GridSet::density}};

inline std::vector<std::string> gridNames() {
    std::vector<std::string> names;
    for (const GridName& grid : kGrids) names.emplace_back(grid.name);
    return names;
}

/// The names of those that are set.
inline std::vector<std::string> gridNames(const GridSet& set) {
    std::vector<std::string> names;
    for (const GridName& grid : kGrids)
        if (set.*grid.wanted) names.emplace_back(grid.name);
    return names;
}

/// Sets the grid of that name. Returns false where there is none.
inline bool wantGrid(GridSet& set, const std::string& name) {
    for (const GridName& grid : kGrids) {
        if (name != grid.name) continue;
        set.*grid.wanted = true;
        return true;
    }
    return false;
}

/// No grid at all, to be filled by name.
inline constexpr GridSet kNoGrids{false, false, false, false, false};

}  // namespace photic
