// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <cmath>

#include "bake/methods/eikonal_front.h"
#include "bake/methods/eikonal_shade.h"
#include "bake/optics/beer_lambert.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr int kMargin = 3;  // columns beyond the sides, through which sheets of rays come in

/// Writes layers of foot points into leaves: eight layers are kept in rows along x and then written together, since a
/// leaf's voxels lie along z.
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
          frame_(needed_.frame()),
          nx_(static_cast<std::size_t>(frame_.size().x)),
          ny_(static_cast<std::size_t>(frame_.size().y)) {
        const std::size_t slab = 8 * nx_ * ny_;
        for (auto* rows : {&share_, &w_[0], &w_[1], &w_[2]}) rows->resize(slab);
        if (fields.caustic) curvature_.resize(slab);
        if (fields.arrival) arrival_.resize(slab);
        if (scene.medium.present()) distance_.resize(slab);
        if (caustics) past_.resize(slab);
    }

    int floatsAVoxel() const { return 4 + !curvature_.empty() + !arrival_.empty() + !distance_.empty(); }

    /// Layers come from above, each z once.
    void add(int z, const glm::dvec3& corner, const FootPointLayer& layer) {
        const double step_x = frame_.worldFromIndex()[0].x, step_y = frame_.worldFromIndex()[1].y;
        const std::size_t plane = static_cast<std::size_t>(z & 7) * nx_ * ny_;
        const glm::dvec2 inner = glm::dvec2(corner) + double(kMargin) * glm::dvec2(step_x, step_y);
        if (caustics_) {
            caustics_->layer(corner.z, inner, {step_x, step_y}, frame_.size().x, frame_.size().y, marks_);
            std::copy(marks_.begin(), marks_.end(), past_.begin() + static_cast<std::ptrdiff_t>(plane));
        }
        const auto part = [&](std::vector<float>& rows, std::size_t at) { return rows.empty() ? nullptr : &rows[at]; };
        parallelFor(static_cast<std::int64_t>(ny_), [&](std::int64_t j) {
            const auto y = static_cast<std::size_t>(j);
            const std::size_t at = plane + y * nx_;
            const ShadedRow out{&share_[at],          &w_[0][at],         &w_[1][at],         &w_[2][at],
                                part(curvature_, at), part(arrival_, at), part(distance_, at)};
            shadeRow(front_, layer, layer.at(kMargin, y + kMargin), static_cast<int>(nx_),
                     {inner.x, step_x, inner.y + double(j) * step_y, corner.z, scene_.bake.grids.irradiance}, out);
        });
        if (z == frame_.min.z || (z & 7) == 0) flush(z);
    }

    /// Writes the layers from z up to the end of its leaves.
    void flush(int z) {
        const glm::ivec3 low = frame_.min;
        const int leaf_low_x = low.x >> 3, leaves_x = (frame_.max.x >> 3) - leaf_low_x + 1;
        const int leaf_low_y = low.y >> 3, leaves_y = (frame_.max.y >> 3) - leaf_low_y + 1;
        std::atomic<std::int64_t> single{0}, below{0};
        parallelFor(std::int64_t(leaves_x) * leaves_y, [&](std::int64_t n) {
            const glm::ivec3 origin((leaf_low_x + int(n) / leaves_y) * 8, (leaf_low_y + int(n) % leaves_y) * 8, z & ~7);
            const int slot = needed_.slotOf(origin);
            if (slot < 0) return;
            Counts counts;
            const glm::ivec3 first(glm::max(glm::ivec2(origin), glm::ivec2(low)), z);
            if (!writeWholeLeaf(slot, origin, counts)) writeLeaf(slot, first, glm::min(origin + 7, frame_.max), counts);
            single += counts.single, below += counts.below;
        });
        fields_.single += single, fields_.below += below;
    }

private:
    struct Counts {
        std::int64_t single = 0, below = 0;
    };

    /// The eight layers of a leaf, x fastest, as the leaf has them: z fastest.
    void turn(const std::vector<float>& rows, const glm::ivec3& origin, float* leaf) const {
        for (int y = 0; y < 8; ++y)
            for (int z = 0; z < 8; ++z) {
                const float* row = &rows[rowAt(origin, y, z)];
                for (int x = 0; x < 8; ++x) leaf[x << 6 | y << 3 | z] = row[x];
            }
    }
    std::size_t rowAt(const glm::ivec3& origin, int y, int z) const {
        return (static_cast<std::size_t>(z) * ny_ + static_cast<std::size_t>(origin.y - frame_.min.y + y)) * nx_ +
               static_cast<std::size_t>(origin.x - frame_.min.x);
    }

    /// A leaf that is wet and needed in all of its voxels, in clear water under white light: nearly every one.
    bool writeWholeLeaf(int slot, const glm::ivec3& origin, Counts& counts) {
        if (scene_.medium.present() || fields_.light.channels().irradiance != 1 || beyond_ == EikonalBeyond::Dark)
            return false;
        for (int a = 0; a < 3; ++a)
            if (origin[a] < frame_.min[a] || origin[a] + 7 > frame_.max[a]) return false;
        for (const std::uint64_t word : needed_.mask(slot))
            if (word != ~std::uint64_t{0}) return false;
        std::int64_t past = 0;
        float least = 1;
        for (int y = 0; y < 8; ++y)
            for (int z = 0; z < 8; ++z)
                for (std::size_t x = 0, row = rowAt(origin, y, z); x < 8; ++x) {
                    least = std::min(least, share_[row + x]);
                    if (!past_.empty()) past += past_[row + x];
                }
        if (!(least >= 0)) return false;
        float* light = fields_.light.makeDense(slot);
        turn(share_, origin, light);
        const auto sun = static_cast<float>(front_.light().irradiance.x);
        for (int v = 0; v < LightField::kLeafVoxels; ++v) light[v] *= sun;
        for (int a = 0; a < 3; ++a) {
            float* flux = light + (a + 1) * LightField::kLeafVoxels;
            turn(w_[a], origin, flux);
            for (int v = 0; v < LightField::kLeafVoxels; ++v) flux[v] *= light[v];
        }
        if (fields_.caustic) turn(curvature_, origin, fields_.caustic->makeDense(slot));
        if (fields_.arrival) turn(arrival_, origin, fields_.arrival->makeDense(slot));
        counts.below = LightField::kLeafVoxels, counts.single = LightField::kLeafVoxels - past;
        return true;
    }

    void writeLeaf(int slot, const glm::ivec3& first, const glm::ivec3& last, Counts& counts) {
        const auto& mask = needed_.mask(slot);
        float *light = nullptr, *caustic = nullptr, *arrival = nullptr;
        const int channels = fields_.light.channels().irradiance;
        const glm::dvec3 sun = front_.light().irradiance;
        const bool clear = !scene_.medium.present();
        for (int x = first.x; x <= last.x; ++x)
            for (int y = first.y; y <= last.y; ++y)
                for (int z = first.z; z <= last.z; ++z) {
                    const int offset = NeededVoxels::offsetInLeaf({x, y, z});
                    const std::size_t at =
                        (static_cast<std::size_t>(z & 7) * ny_ + static_cast<std::size_t>(y - frame_.min.y)) * nx_ +
                        static_cast<std::size_t>(x - frame_.min.x);
                    const float share = share_[at];
                    if (!(share >= 0) || !NeededVoxels::maskBit(mask, offset)) continue;
                    ++counts.below;
                    if (!light) {
                        light = fields_.light.makeDense(slot);
                        if (fields_.caustic) caustic = fields_.caustic->makeDense(slot);
                        if (fields_.arrival) arrival = fields_.arrival->makeDense(slot);
                    }
                    const bool past = !past_.empty() && past_[at] != 0;
                    counts.single += past ? 0 : 1;
                    if (caustic) caustic[offset] = curvature_[at];
                    if (arrival) arrival[offset] = arrival_[at];
                    if (past && beyond_ == EikonalBeyond::Dark && scene_.bake.grids.irradiance) continue;
                    const glm::vec3 w(w_[0][at], w_[1][at], w_[2][at]);
                    float mean = 0;
                    for (int c = 0; c < channels; ++c) {
                        const double through = clear ? 1.0 : transmittance(c, double(distance_[at]), double(w.z));
                        const auto e = static_cast<float>(double(share) * sun[c] * through);
                        light[c * LightField::kLeafVoxels + offset] = e;
                        mean += e / static_cast<float>(channels);
                    }
                    for (int a = 0; a < 3; ++a) light[(channels + a) * LightField::kLeafVoxels + offset] = mean * w[a];
                }
    }

    /// The mean along the ray through the voxel's layer, not the centre's.
    double transmittance(int channel, double distance, double fall) const {
        const double half = 0.5 * frame_.worldFromIndex()[2].z / std::max(-fall, 0.1);
        const double start = std::max(0.0, distance - half);
        return meanTransmittance(scene_.medium.extinction()[channel], start, distance + half - start);
    }

    const Scene& scene_;
    const EikonalFront& front_;
    const CausticMap* caustics_;
    EikonalBeyond beyond_;
    EikonalFields& fields_;
    const NeededVoxels& needed_;
    GridFrame frame_;
    std::size_t nx_, ny_;
    std::vector<float> share_, w_[3], curvature_, arrival_, distance_;  // eight layers, x fastest
    std::vector<std::uint8_t> past_, marks_;
};

}  // namespace

void bakeByFootPoints(const EikonalBake& bake, const CausticMap* caustics, EikonalFields& fields) {
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
    points.step_x = frame.worldFromIndex()[0].x, points.step_y = frame.worldFromIndex()[1].y;
    points.step_z = -frame.worldFromIndex()[2];
    points.count_x = frame.size().x + 2 * kMargin, points.count_y = frame.size().y + 2 * kMargin;
    points.count_z = frame.max.z - lowest + 1;
    LayerWriter writer(bake.scene, bake.front, caustics, bake.options.beyond, fields);
    sweepFootPoints(bake.front.front(), points, [&](int k, const FootPointLayer& layer) {
        bake.monitor.checkCancelled();
        if (k % 8 == 0) bake.monitor.progress("foot points", double(k) / points.count_z);
        const int z = frame.max.z - k;
        if (z <= highest) writer.add(z, points.origin + static_cast<double>(k) * points.step_z, layer);
        return true;
    });
    // Two layers of ten values, and the eight layers that are being written.
    const double column = 2 * 10 * sizeof(double) + 8.0 * (writer.floatsAVoxel() * sizeof(float) + 1);
    fields.solver_bytes = column * points.count_x * points.count_y;
}

}  // namespace photic
