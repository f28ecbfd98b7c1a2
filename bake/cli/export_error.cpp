// SPDX-License-Identifier: Apache-2.0
#include "bake/cli/export_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "bake/field/resample.h"
#include "bake/file/voxel_encoding.h"
#include "bake/picture/receiver_picture.h"
#include "bake/report/error.h"

namespace photic::cli {

namespace {

constexpr int kVoxels = LightField::kLeafVoxels;

/// As textures hold it: half floats in units of the reference.
LightField roundedToHalves(const LightField& field, double reference) {
    LightField out(field.neededPtr(), field.channels());
    const auto scale = static_cast<float>(1 / reference), back = static_cast<float>(reference);
    const int values = field.channels().count() * kVoxels;
    forEachLeaf(field.needed(), [&](int slot) {
        if (field.state(slot) == LeafState::Empty) return;
        float* to = out.makeDense(slot);
        for (int i = 0; i < values; ++i) {
            const float v = field.state(slot) == LeafState::Dense
                                ? field.dense(slot)[i]
                                : field.constant(slot)[static_cast<std::size_t>(i / kVoxels)];
            to[i] = halfPrecision(v * scale) * back;
        }
    });
    return out;
}

/// Sums that give relative errors.
struct Difference {
    double absolute = 0, squared = 0, reference = 0, count = 0;
    void add(double value, double truth) {
        const double d = value - truth;
        absolute += std::fabs(d), squared += d * d, reference += std::fabs(truth), count += 1;
    }
    double relativeL1() const { return reference > 0 ? absolute / reference : 0; }
    /// Root mean square over the mean.
    double relativeRmse() const { return reference > 0 ? std::sqrt(squared / count) / (reference / count) : 0; }
};

double meanOf(const std::array<float, 8>& sample, int channels) {
    double sum = 0;
    for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) sum += double(sample[c]);
    return sum / channels;
}

/// The R3 sequence (Roberts): even spread in 0..1.
glm::dvec3 spread(std::int64_t n) {
    const auto part = [n](double step) { return std::fmod(0.5 + static_cast<double>(n) * step, 1.0); };
    return {part(0.8191725134), part(0.6710436067), part(0.5497004779)};
}

/// Whether the voxels with light that a look-up in `source` reads at a point are kept in `exported`.
bool keptAround(const LightField& source, const LightField& exported, const glm::dmat3& index_from_world,
                const glm::dvec3& point) {
    const glm::ivec3 below(glm::floor(point));
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 voxel = below + glm::ivec3(corner >> 2, corner >> 1 & 1, corner & 1);
        if (!source.needed().contains(voxel)) continue;
        const glm::dvec3 there =
            index_from_world * (source.frame().worldFromIndex(voxel) - exported.frame().origin_world);
        if (!exported.needed().contains(glm::ivec3(glm::floor(there + 0.5)))) return false;
    }
    return true;
}

/// What an export did to the light of one lobe or more.
struct VolumeError {
    Difference difference;
    double kept = 0, all = 0;
};

void addError(const LightField& source, const LightField& exported, VolumeError& error) {
    constexpr std::int64_t kMostSamples = 1000000;
    const std::int64_t stride = source.needed().count() / kMostSamples + 1;
    const GridFrame &from = source.frame(), &to = exported.frame();
    const glm::dmat3& index_from_world = to.indexFromWorld();
    Difference& difference = error.difference;
    double &kept = error.kept, &all = error.all;
    std::int64_t n = 0;
    for (int slot = 0; slot < source.leafCount(); ++slot) {
        if (source.state(slot) == LeafState::Empty) continue;
        const auto& mask = source.needed().mask(slot);
        const glm::ivec3 origin = source.needed().leafOrigin(slot);
        for (int i = 0; i < kVoxels; ++i) {
            if (!NeededVoxels::maskBit(mask, i) || n++ % stride != 0) continue;
            const glm::ivec3 voxel = origin + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
            const double light = source.irradiance(voxel);
            all += light;
            const glm::dvec3 here = index_from_world * (from.worldFromIndex(voxel) - to.origin_world);
            if (!exported.needed().contains(glm::ivec3(glm::floor(here + 0.5)))) continue;
            kept += light;
            const glm::dvec3 point = glm::dvec3(voxel) + spread(n) - 0.5;
            if (!keptAround(source, exported, index_from_world, point)) continue;
            const double truth = meanOf(sampleTrilinear(source, point), source.channels().irradiance);
            const auto sample =
                sampleTrilinear(exported, index_from_world * (from.worldFromIndex(point) - to.origin_world));
            difference.add(meanOf(sample, exported.channels().irradiance), truth);
        }
    }
}

Json volumeError(const LightVolume& source, const LightVolume& exported) {
    VolumeError error;
    addError(source.field, exported.field, error);
    if (source.second && exported.second) addError(*source.second, *exported.second, error);
    return {{"relative_l1", error.difference.relativeL1()},
            {"relative_rmse", error.difference.relativeRmse()},
            {"samples", static_cast<std::int64_t>(error.difference.count)},
            {"light_kept", error.all > 0 ? error.kept / error.all : 1.0}};
}

}  // namespace

Json exportError(const LightVolume& source, const LightVolume& exported, const Scene* scene) {
    LightVolume rounded{roundedToHalves(exported.field, exported.reference_irradiance),
                        exported.reference_irradiance,
                        true,
                        exported.has_direction,
                        {},
                        {}};
    if (exported.second) rounded.second = roundedToHalves(*exported.second, exported.reference_irradiance);
    Json receivers = Json::array();
    constexpr int kTexels = 512;
    for (const std::string& name : scene != nullptr ? planarReceivers(*scene) : std::vector<std::string>{}) {
        const PictureFrame frame = receiverFrame(*scene, name, kTexels);
        const Image truth = receiverPicture(source, frame), picture = receiverPicture(rounded, frame);
        Difference difference;
        for (std::size_t i = 0; i < truth.pixels.size(); ++i)
            difference.add(double(picture.pixels[i]), double(truth.pixels[i]));
        receivers.push_back(
            {{"name", name}, {"relative_l1", difference.relativeL1()}, {"relative_rmse", difference.relativeRmse()}});
    }
    return {{"volume", volumeError(source, rounded)}, {"receivers", receivers}};
}

double meanError(const Json& error) {
    double sum = 0;
    for (const Json& receiver : error["receivers"]) sum += receiver["relative_l1"].get<double>();
    const auto count = static_cast<double>(error["receivers"].size());
    return count > 0 ? sum / count : error["volume"]["relative_l1"].get<double>();
}

std::string errorText(const Json& error) {
    const auto percent = [](const Json& of) {
        return fmt::format("{:.3g} % (L1), {:.3g} % (RMSE)", 100 * of["relative_l1"].get<double>(),
                           100 * of["relative_rmse"].get<double>());
    };
    std::string text = fmt::format("error of irradiance {} in the voxels kept, which hold {:.1f} % of the light",
                                   percent(error["volume"]), 100 * error["volume"]["light_kept"].get<double>());
    for (const Json& receiver : error["receivers"])
        text += fmt::format("; on {} {}", receiver["name"].get<std::string>(), percent(receiver));
    return text;
}

}  // namespace photic::cli
