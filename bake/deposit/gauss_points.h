// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace photic {

/// A plane in a layer of voxels, and what of the layer it stands for.
struct LayerPoint {
    double offset;  ///< 0 where light enters the layer, 1 where it leaves
    double weight;
};

/// Gauss and Legendre's points on [0, 1]. @param count  1, 2, 4, 6, 8 or 12
inline std::vector<LayerPoint> gaussPoints(int count) {
    // Those past the middle; the others are their mirror images.
    static constexpr LayerPoint kTwo[] = {{0.78867513459481288, 0.5}};
    static constexpr LayerPoint kFour[] = {{0.66999052179242813, 0.32607257743127307},
                                           {0.93056815579702629, 0.17392742256872693}};
    static constexpr LayerPoint kSix[] = {{0.61930959304159849, 0.23395696728634569},
                                          {0.83060469323313224, 0.18038078652406947},
                                          {0.96623475710157603, 0.085662246189584873}};
    static constexpr LayerPoint kEight[] = {{0.59171732124782483, 0.18134189168918088},
                                            {0.7627662049581645, 0.15685332293894352},
                                            {0.89833323870681336, 0.11119051722668717},
                                            {0.98014492824876809, 0.050614268145188344}};
    static constexpr LayerPoint kTwelve[] = {
        {0.5626167042557344, 0.12457352290670134},   {0.68391574949909006, 0.11674626826917732},
        {0.79365897714330869, 0.10158371336153282},  {0.88495133709715235, 0.080039164271673055},
        {0.95205862818523745, 0.053469662997659442}, {0.99078031712335957, 0.023587668193256011}};
    const auto both = [](std::span<const LayerPoint> past) {
        std::vector<LayerPoint> all;
        for (std::size_t i = past.size(); i-- > 0;) all.push_back({1 - past[i].offset, past[i].weight});
        all.insert(all.end(), past.begin(), past.end());
        return all;
    };
    switch (count) {
        case 1:
            return {{0.5, 1.0}};
        case 2:
            return both(kTwo);
        case 6:
            return both(kSix);
        case 8:
            return both(kEight);
        case 12:
            return both(kTwelve);
        default:
            return both(kFour);
    }
}

}  // namespace photic
