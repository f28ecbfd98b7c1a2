// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "bake/deposit/track_deposit.h"
#include "bake/field/leaf_arena.h"
#include "bake/field/lobes.h"

namespace photic {

/// Mean, spread and path counts of independent repetitions. Repetitions are folded in their order, so the result does
/// not depend on who computed them.
class PhotonStatistics {
public:
    /// @param lobes  1 or 2: accumulators of a repetition, which stand side by side
    PhotonStatistics(std::shared_ptr<const NeededVoxels> needed, FieldChannels channels, int lobes = 1);

    /// Adds the first `count` repetitions, and sets them back to zero.
    template <class Real>
    void fold(std::vector<TrackAccumulator<Real>>& repetitions, std::size_t count);

    struct Result {
        LobeFields field;
        LightField standard_error, path_count;
        std::int64_t active_voxels = 0;  ///< crossed by at least one path
    };
    /// Mean fluence rate and flux [W/m2], its standard error (of the channels' mean; right on average, where
    /// repetitions are about normal: the root's bias is made up for) and the number of paths. At least two repetitions.
    Result result() const;

private:
    template <class Real>
    void foldLeaf(int slot, std::vector<TrackAccumulator<Real>>& repetitions, std::size_t count);

    std::shared_ptr<const NeededVoxels> needed_;
    FieldChannels channels_;
    std::size_t lobes_;
    int repetitions_ = 0;
    std::size_t leaf_bytes_;
    LeafArena arena_;
    std::vector<double*> leaves_;  // 512 x channels sums of each lobe, 512 sums of squares, 512 counts
};

extern template void PhotonStatistics::fold(std::vector<TrackAccumulator<float>>&, std::size_t);
extern template void PhotonStatistics::fold(std::vector<TrackAccumulator<double>>&, std::size_t);

}  // namespace photic
