// SPDX-License-Identifier: Apache-2.0
#include "bake/field/grid_laws.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

// Sums of many arrivals in single precision round to this, of the brightest voxel: coloured seas over a mesh leave a
// few voxels behind it at -3e-6.
constexpr double kRounding = 1e-5;
constexpr std::int64_t kBlock = 1024;  // leaves whose sums are kept apart, so that the total does not depend on threads

template <class Body>
void forEachLitVoxel(const LightField& field, int slot, Body body) {
    if (field.state(slot) == LeafState::Empty) return;
    const auto& mask = field.needed().mask(slot);
    const auto channels = static_cast<std::size_t>(field.channels().count());
    std::array<float, 8> v{};
    for (int i = 0; i < LightField::kLeafVoxels; ++i) {
        if (!NeededVoxels::maskBit(mask, i)) continue;
        for (std::size_t c = 0; c < channels; ++c)
            v[c] = field.state(slot) == LeafState::Dense
                       ? field.dense(slot)[c * LightField::kLeafVoxels + static_cast<std::size_t>(i)]
                       : field.constant(slot)[c];
        body(i, v);
    }
}

/// What body(result, values) finds in all lit voxels, block by block.
template <class Result, class Body>
std::vector<Result> ofBlocks(const LightField& field, Body body) {
    const std::int64_t blocks = (field.leafCount() + kBlock - 1) / kBlock;
    std::vector<Result> found(static_cast<std::size_t>(blocks));
    parallelFor(blocks, [&](std::int64_t block) {
        Result& result = found[static_cast<std::size_t>(block)];
        const auto end = std::min<std::int64_t>((block + 1) * kBlock, field.leafCount());
        for (auto slot = static_cast<int>(block * kBlock); slot < end; ++slot)
            forEachLitVoxel(field, slot, [&](int, const std::array<float, 8>& v) { body(result, v); });
    });
    return found;
}

/// Whether a leaf surely keeps the laws; plain loops, so that they compile to vectors. A leaf's voxels that are not
/// needed are looked at too, and may make it doubtful for nothing.
bool surelyKept(const LightField& field, int slot) {
    constexpr int n = LightField::kLeafVoxels;
    if (field.state(slot) != LeafState::Dense) return field.state(slot) == LeafState::Empty;
    const float* data = field.dense(slot);
    const int colours = field.channels().irradiance;
    float mean[n];
    int kept = 1;
    for (int c = 0; c < colours; ++c) {
        const float* e = data + c * n;
        // Comparisons with NaN are false.
        for (int i = 0; i < n; ++i) kept &= int(e[i] >= 0) & int(e[i] <= std::numeric_limits<float>::max());
        for (int i = 0; i < n; ++i) mean[i] = c == 0 ? e[i] : mean[i] + e[i];
    }
    if (!field.channels().flux) return kept != 0;
    const float* f = data + colours * n;
    const auto longest = static_cast<float>((1 + 0.5 * kRounding) / colours);
    for (int i = 0; i < n; ++i) {
        const float e = mean[i] * longest;
        kept &= int(f[i] * f[i] + f[n + i] * f[n + i] + f[2 * n + i] * f[2 * n + i] <= e * e);
    }
    return kept != 0;
}

double meanIrradiance(const LightField& field, const std::array<float, 8>& v) {
    double sum = 0;
    for (int c = 0; c < field.channels().irradiance; ++c) sum += double(v[static_cast<std::size_t>(c)]);
    return sum / field.channels().irradiance;
}

}  // namespace

double netFluxThroughBox(const LightField& field, const glm::ivec3& min, const glm::ivec3& max) {
    const glm::dmat3& m = field.frame().worldFromIndex();
    double net = 0, total = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        // Area vector of a voxel's face, towards growing index; right for sheared and mirrored grids.
        glm::dvec3 area = glm::cross(m[u], m[v]);
        if (glm::dot(area, m[axis]) < 0) area = -area;
        for (const int side : {0, 1}) {
            glm::ivec3 in(0), out(0);
            in[axis] = side ? max[axis] : min[axis];
            out[axis] = side ? in[axis] + 1 : in[axis] - 1;
            for (in[u] = out[u] = min[u]; in[u] <= max[u]; out[u] = ++in[u])
                for (in[v] = out[v] = min[v]; in[v] <= max[v]; out[v] = ++in[v]) {
                    const double power = 0.5 * glm::dot(field.flux(in) + field.flux(out), area);
                    net += side ? power : -power;
                    total += std::fabs(power);
                }
        }
    }
    return total > 0 ? net / total : 0.0;
}

std::vector<double> layerPower(const LightField& field) {
    const GridFrame& frame = field.frame();
    const auto layers = static_cast<std::size_t>(std::max(frame.size().z, 0));
    std::vector<double> power(layers);
    if (!field.channels().flux || layers == 0) return power;
    const glm::dvec3 area = glm::cross(frame.worldFromIndex()[0], frame.worldFromIndex()[1]);
    const auto f = static_cast<std::size_t>(field.channels().irradiance);
    const std::int64_t blocks = (field.leafCount() + kBlock - 1) / kBlock;
    std::vector<std::vector<double>> sums(static_cast<std::size_t>(blocks));
    parallelFor(blocks, [&](std::int64_t block) {
        auto& sum = sums[static_cast<std::size_t>(block)];
        sum.assign(layers, 0.0);
        const auto end = std::min<std::int64_t>((block + 1) * kBlock, field.leafCount());
        for (auto slot = static_cast<int>(block * kBlock); slot < end; ++slot) {
            const int base = field.needed().leafOrigin(slot).z - frame.min.z;
            forEachLitVoxel(field, slot, [&](int i, const std::array<float, 8>& v) {
                sum[static_cast<std::size_t>(base + (i & 7))] -= glm::dot(area, glm::dvec3(v[f], v[f + 1], v[f + 2]));
            });
        }
    });
    for (const auto& sum : sums)
        for (std::size_t k = 0; k < layers; ++k) power[k] += sum[k];
    return power;
}

std::vector<LawCheck> checkLaws(const LightField& field) {
    const auto f = static_cast<std::size_t>(field.channels().irradiance);
    const auto channels = static_cast<std::size_t>(field.channels().count());
    struct Extremes {
        double not_finite = 0, lowest = 0, brightest = 0;
    };
    Extremes all;
    for (const Extremes& e : ofBlocks<Extremes>(field, [&](Extremes&e, const std::array<float, 8>&v) {
             for (std::size_t c = 0; c < channels; ++c)
                 if (!std::isfinite(v[c])) {
                     e.not_finite += 1;
                     return;
                 }
             for (std::size_t c = 0; c < f; ++c) e.lowest = std::min(e.lowest, double(v[c]));
             e.brightest = std::max(e.brightest, meanIrradiance(field, v));
         })) {
        all.not_finite += e.not_finite;
        all.lowest = std::min(all.lowest, e.lowest), all.brightest = std::max(all.brightest, e.brightest);
    }
    // Where there is no light but what sums round to, flux has no length either that could be compared.
    const double faintest = kRounding * all.brightest;
    double excess = 0;
    if (field.channels().flux)
        for (const double e : ofBlocks<double>(field, [&](double&e, const std::array<float, 8>&v) {
                 const double length = glm::length(glm::dvec3(v[f], v[f + 1], v[f + 2]));
                 const double mean = std::max(meanIrradiance(field, v), 0.0);
                 if (length > mean && length > faintest) e = std::max(e, (length - mean) / length);
             }))
            excess = std::max(excess, e);
    const auto check = [](const char* name, double value, double limit) {
        return LawCheck{name, value, limit, value <= limit};
    };
    return {check("voxels with a value that is not finite", all.not_finite, 0),
            check("negative irradiance, of the brightest voxel",
                  all.brightest > 0 ? -all.lowest / all.brightest : -all.lowest, kRounding),
            check("flux longer than irradiance, of its length", excess, kRounding)};
}

std::vector<LawCheck> brokenLaws(const LightField& field) {
    std::atomic<bool> doubtful{false};
    const std::int64_t blocks = (field.leafCount() + kBlock - 1) / kBlock;
    parallelFor(blocks, [&](std::int64_t block) {
        const auto end = std::min<std::int64_t>((block + 1) * kBlock, field.leafCount());
        for (auto slot = static_cast<int>(block * kBlock); slot < end; ++slot) {
            if (surelyKept(field, slot)) continue;
            doubtful = true;
            return;
        }
    });
    if (!doubtful) return {};
    std::vector<LawCheck> laws = checkLaws(field);
    std::erase_if(laws, [](const LawCheck& law) { return law.holds; });
    return laws;
}

OpposedLight opposedLight(const LightField& field, const LightField* second) {
    constexpr double kShort = 0.9;
    constexpr int kLeaves = 2048;
    if (!field.channels().flux) return {};
    const auto f = static_cast<std::size_t>(field.channels().irradiance);
    double light = 0, opposed = 0, lost = 0;
    const int step = std::max(1, field.leafCount() / kLeaves);
    for (const LightField* lobe : {&field, second}) {
        if (lobe == nullptr) continue;
        for (int slot = 0; slot < lobe->leafCount(); slot += step)
            forEachLitVoxel(*lobe, slot, [&](int, const std::array<float, 8>& v) {
                const double mean = meanIrradiance(*lobe, v);
                if (!(mean > 0)) return;
                light += mean;
                const double length = glm::length(glm::dvec3(v[f], v[f + 1], v[f + 2])) / mean;
                if (length >= kShort) return;
                opposed += mean;
                lost += 0.5 * mean * std::sqrt(1 - length * length);
            });
    }
    return light > 0 ? OpposedLight{opposed / light, opposed > 0 ? lost / opposed : 0} : OpposedLight{};
}

}  // namespace photic
