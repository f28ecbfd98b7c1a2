// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>
#include <string>

#include "bake/file/vdb.h"

namespace photic {

/// A folder of its own that goes with the object.
class TemporaryFolder {
public:
    TemporaryFolder() {
        std::string pattern = (std::filesystem::temp_directory_path() / "photic_file_XXXXXX").string();
        path_ = mkdtemp(pattern.data());
    }
    ~TemporaryFolder() { std::filesystem::remove_all(path_); }
    std::string operator/(const std::string& name) const { return (path_ / name).string(); }
    std::size_t fileCount() const {
        return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
    }

private:
    std::filesystem::path path_;
};

inline std::string bytesOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}
inline void writeBytes(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

inline GridFrame straightFrame(const glm::ivec3& min, const glm::ivec3& max, double h) {
    return {glm::dmat3(h), glm::dvec3(0.5 * h), min, max};
}

inline GridFrame leaningFrame(const glm::ivec3& min, const glm::ivec3& max, double h) {
    glm::dmat3 world_from_index(h);
    world_from_index[2] = glm::dvec3(0.4, -0.25, 1.0) * (2 * h);
    return {world_from_index, world_from_index * glm::dvec3(0.5), min, max};
}

/// Light at a point [W/m2]: smooth, dark below z = 0 where `dark_below`.
struct TestLight {
    double red, green, blue;
    glm::dvec3 direction;
    double mean() const { return (red + green + blue) / 3; }
};
inline TestLight testLight(const glm::dvec3& p) {
    const double e = 900 + 500 * std::sin(3 * p.x + p.y) * std::cos(2 * p.z);
    return {e, 0.8 * e, 0.5 * e + 20,
            glm::normalize(glm::dvec3(0.3 * std::sin(p.y), 0.2, -1)) * (0.9 + 0.1 * std::cos(p.x))};
}

/// A volume of testLight at voxel centres, zero where `lit(voxel)` is false; leaves without light stay Empty.
template <class Lit>
LightVolume testVolume(const GridFrame& frame, bool coloured, Lit lit) {
    const FieldChannels channels{coloured ? 3 : 1, true};
    LightVolume volume{LightField(std::make_shared<NeededVoxels>(NeededVoxels::everything(frame)), channels),
                       1000,
                       true,
                       true,
                       {},
                       {}};
    LightField& field = volume.field;
    for (int slot = 0; slot < field.leafCount(); ++slot)
        for (int i = 0; i < 512; ++i) {
            const glm::ivec3 v = field.needed().leafOrigin(slot) + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
            if (!field.needed().contains(v) || !lit(v)) continue;
            float* leaf = field.makeDense(slot);
            const TestLight light = testLight(frame.worldFromIndex(v));
            if (coloured)
                leaf[i] = float(light.red), leaf[512 + i] = float(light.green), leaf[1024 + i] = float(light.blue);
            else
                leaf[i] = float(light.mean());
            for (int a = 0; a < 3; ++a)
                leaf[(channels.irradiance + a) * 512 + i] = float(light.mean() * light.direction[a]);
        }
    return volume;
}
inline LightVolume testVolume(const GridFrame& frame, bool coloured) {
    return testVolume(frame, coloured, [](const glm::ivec3&) { return true; });
}

}  // namespace photic
