// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "bake/methods/eikonal_front.h"
#include "bake/optics/beer_lambert.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr int kMargin = 3;  // columns beyond the sides, through which sheets of rays come in

/// Writes layers of foot points into leaves.
class LayerWriter {
public:
    LayerWriter(const Scene& scene, const EikonalFront& front, const CausticMap* caustics, EikonalBeyond beyond,
                EikonalFields& fields)
        : scene_(scene),
          front_(front),
          caustics_(caustics),
          beyond_(beyond),
          fields_(fields),
          needed_(fields.light.needed()),
          frame_(needed_.frame()) {}

    void write(int z, const glm::dvec3& corner, const FootPointLayer& layer) {
        const glm::ivec3 size = frame_.size(), low = frame_.min;
        if (caustics_)
            caustics_->layer(corner.z,
                             glm::dvec2(corner) + double(kMargin) * glm::dvec2(frame_.world_from_index[0].x,
                                                                               frame_.world_from_index[1].y),
                             {frame_.world_from_index[0].x, frame_.world_from_index[1].y}, size.x, size.y, past_);
        const int leaf_low_x = low.x >> 3, leaves_x = (frame_.max.x >> 3) - leaf_low_x + 1;
        const int leaf_low_y = low.y >> 3, leaves_y = (frame_.max.y >> 3) - leaf_low_y + 1;
        std::atomic<std::int64_t> single{0}, below{0};
        parallelFor(std::int64_t(leaves_x) * leaves_y, [&](std::int64_t n) {
            const glm::ivec3 origin((leaf_low_x + int(n) / leaves_y) * 8, (leaf_low_y + int(n) % leaves_y) * 8, z & ~7);
            const int slot = needed_.slotOf(origin);
            if (slot < 0) return;
            Counts counts;
            writeLeaf(slot, glm::max(origin, low), glm::min(origin + 7, frame_.max), z, corner, layer, counts);
            single += counts.single, below += counts.below;
        });
        fields_.single += single, fields_.below += below;
    }

private:
    struct Counts {
        std::int64_t single = 0, below = 0;
    };

    void writeLeaf(int slot, const glm::ivec3& first, const glm::ivec3& last, int z, const glm::dvec3& corner,
                   const FootPointLayer& layer, Counts& counts) {
        const auto& mask = needed_.mask(slot);
        float *light = nullptr, *caustic = nullptr, *arrival = nullptr;
        const int channels = fields_.light.channels().irradiance;
        const glm::dvec3 sun = front_.light().irradiance, extinction = scene_.medium.extinction();
        const bool clear = !scene_.medium.present(), lit = scene_.bake.grids.irradiance;
        const glm::dvec2 step(frame_.world_from_index[0].x, frame_.world_from_index[1].y);
        for (int x = first.x; x <= last.x; ++x)
            for (int y = first.y; y <= last.y; ++y) {
                const int offset = NeededVoxels::offsetInLeaf({x, y, z});
                const std::size_t at = layer.at(static_cast<std::size_t>(x - frame_.min.x + kMargin),
                                                static_cast<std::size_t>(y - frame_.min.y + kMargin));
                if (layer.arrival[at] >= FootPointLayer::kAboveSurface || !NeededVoxels::maskBit(mask, offset))
                    continue;
                ++counts.below;
                if (!light) {
                    light = fields_.light.makeDense(slot);
                    if (fields_.caustic) caustic = fields_.caustic->makeDense(slot);
                    if (fields_.arrival) arrival = fields_.arrival->makeDense(slot);
                }
                const bool past =
                    !past_.empty() &&
                    past_[static_cast<std::size_t>(y - frame_.min.y) * static_cast<std::size_t>(frame_.size().x) +
                          static_cast<std::size_t>(x - frame_.min.x)] != 0;
                counts.single += past ? 0 : 1;
                if (caustic) caustic[offset] = static_cast<float>(layer.curvature[at]);
                if (arrival) arrival[offset] = static_cast<float>(layer.arrival[at]);
                const double inverse = 1 / layer.distance[at];
                const glm::dvec3 w(inverse * (corner.x + (x - frame_.min.x + kMargin) * step.x - layer.foot_x[at]),
                                   inverse * (corner.y + (y - frame_.min.y + kMargin) * step.y - layer.foot_y[at]),
                                   inverse * (corner.z - layer.foot_z[at]));
                double share = 1;
                if (lit) {
                    // A voxel is no point: its mean stays bounded where the rays of its centre meet.
                    const double least = std::min(0.2, 0.5 * step.x * inverse);
                    share =
                        front_.entering(layer.slope_x[at], layer.slope_y[at], w) / std::max(layer.spread[at], least);
                    if (past && beyond_ == EikonalBeyond::Dark) continue;
                }
                // Attenuation is the mean along the ray through the voxel's layer, not the centre's.
                const double half = 0.5 * frame_.world_from_index[2].z / std::max(-w.z, 0.1);
                const double start = std::max(0.0, layer.distance[at] - half), length = layer.distance[at] + half - start;
                double mean = 0;
                for (int c = 0; c < channels; ++c) {
                    const double e = share * sun[c] * (clear ? 1.0 : meanTransmittance(extinction[c], start, length));
                    light[c * LightField::kLeafVoxels + offset] = static_cast<float>(e);
                    mean += e / channels;
                }
                for (int a = 0; a < 3; ++a)
                    light[(channels + a) * LightField::kLeafVoxels + offset] = static_cast<float>(mean * w[a]);
            }
    }

    const Scene& scene_;
    const EikonalFront& front_;
    const CausticMap* caustics_;
    EikonalBeyond beyond_;
    EikonalFields& fields_;
    const NeededVoxels& needed_;
    GridFrame frame_;
    std::vector<std::uint8_t> past_;
};

}  // namespace

void bakeByFootPoints(const Scene& scene, const EikonalFront& front, const CausticMap* caustics, EikonalBeyond beyond,
                      EikonalFields& fields, Monitor& monitor) {
    const NeededVoxels& needed = fields.light.needed();
    const GridFrame& frame = needed.frame();
    int lowest = frame.max.z + 1, highest = frame.min.z - 1;
    for (int slot = 0; slot < needed.leafCount(); ++slot) {
        lowest = std::min(lowest, std::max(frame.min.z, needed.leafOrigin(slot).z));
        highest = std::max(highest, std::min(frame.max.z, needed.leafOrigin(slot).z + 7));
    }
    if (highest < lowest) return;
    PointLayers points;
    points.origin = frame.worldFromIndex({frame.min.x - kMargin, frame.min.y - kMargin, frame.max.z});
    points.step_x = frame.world_from_index[0].x, points.step_y = frame.world_from_index[1].y;
    points.step_z = -frame.world_from_index[2];
    points.count_x = frame.size().x + 2 * kMargin, points.count_y = frame.size().y + 2 * kMargin;
    points.count_z = frame.max.z - lowest + 1;
    LayerWriter writer(scene, front, caustics, beyond, fields);
    sweepFootPoints(front.front(), points, [&](int k, const FootPointLayer& layer) {
        monitor.checkCancelled();
        if (k % 8 == 0) monitor.progress("sweep", double(k) / points.count_z);
        const int z = frame.max.z - k;
        if (z <= highest) writer.write(z, points.origin + static_cast<double>(k) * points.step_z, layer);
        return true;
    });
    fields.marked_bytes_a_voxel = 24.0 * 8 / points.count_z;
}

}  // namespace photic
