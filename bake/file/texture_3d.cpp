// SPDX-License-Identifier: Apache-2.0
#include "bake/file/texture_3d.h"

#include <Imath/half.h>
#include <fmt/format.h>

#include <array>
#include <atomic>
#include <cstring>
#include <functional>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "bake/file/output_set.h"
#include "bake/file/runtime_metadata.h"
#include "bake/file/sidecar.h"
#include "bake/file/texture_headers.h"
#include "bake/file/voxel_encoding.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

using Json = nlohmann::ordered_json;

// Light of the box's voxels in units of the reference, as single texels.
class BoxLight {
public:
    BoxLight(const LightField& field, const VoxelBox& box, double reference)
        : field_(field), box_(box), scale_(1 / reference) {}

    glm::ivec3 size() const { return box_.size(); }
    const VoxelBox& box() const { return box_; }
    std::int64_t clamped() const { return clamped_; }

    /// Texel (i, j, k) of the box, along Photic's axes.
    float irradiance(const glm::ivec3& texel) const { return cut(field_.irradiance(box_.min + texel) * scale_); }
    glm::vec3 flux(const glm::ivec3& texel) const {
        const glm::dvec3 f = field_.flux(box_.min + texel) * scale_;
        return {cut(f.x), cut(f.y), cut(f.z)};
    }
    glm::vec3 rgb(const glm::ivec3& texel) const {
        const glm::ivec3 v = box_.min + texel;
        return {cut(double(field_.value(v, 0)) * scale_), cut(double(field_.value(v, 1)) * scale_),
                cut(double(field_.value(v, 2)) * scale_)};
    }

private:
    float cut(double v) const {
        std::int64_t count = 0;
        const float kept = cutToRange(static_cast<float>(v), count);
        if (count > 0) clamped_ += count;
        return kept;
    }

    const LightField& field_;
    VoxelBox box_;
    double scale_;
    mutable std::atomic<std::int64_t> clamped_{0};
};

using Texel = std::array<std::uint16_t, 4>;

// Rounded so that |flux| <= irradiance still holds, as voxel_encoding.h does for directions.
Texel lightTexel(const glm::vec3& flux, float irradiance) {
    const float rounded = halfPrecision(irradiance), length = glm::length(flux);
    const glm::vec3 f = length > rounded ? flux * (rounded / length) : flux;
    const glm::vec3 nearest(halfPrecision(f.x), halfPrecision(f.y), halfPrecision(f.z));
    const bool over = glm::dot(nearest, nearest) > rounded * rounded;
    const auto component = [&](int a) { return imath_float_to_half(over ? halfPrecisionBelow(f[a]) : nearest[a]); };
    return {component(0), component(1), component(2), imath_float_to_half(rounded)};
}

// The same of the irradiance per channel, and their mean.
Texel colourTexel(const glm::vec3& rgb, float irradiance) {
    return {imath_float_to_half(rgb.x), imath_float_to_half(rgb.y), imath_float_to_half(rgb.z),
            imath_float_to_half(irradiance)};
}

// One file of a set, with its texels: fill(x, y, z, bytes) writes a texel of the file's own axes.
struct TextureFile {
    std::string path, header;
    glm::ivec3 size;
    std::size_t texel_bytes;
    std::function<void(int, int, int, char*)> fill;
};

void writeTexels(const TextureFile& file, std::ostream& stream) {
    stream.write(file.header.data(), static_cast<std::streamsize>(file.header.size()));
    const std::size_t row = static_cast<std::size_t>(file.size.x) * file.texel_bytes;
    std::vector<char> slice(row * static_cast<std::size_t>(file.size.y));
    for (int z = 0; z < file.size.z; ++z) {
        parallelFor(file.size.y, [&](std::int64_t y) {
            char* at = slice.data() + static_cast<std::size_t>(y) * row;
            for (int x = 0; x < file.size.x; ++x, at += file.texel_bytes) file.fill(x, static_cast<int>(y), z, at);
        });
        stream.write(slice.data(), static_cast<std::streamsize>(slice.size()));
    }
}

void writeAll(OutputSet& outputs, const std::vector<TextureFile>& files) {
    for (const TextureFile& file : files) {
        CheckedFile& open = outputs.open(file.path);
        try {
            writeTexels(file, open.stream());
        } catch (const std::ios_base::failure&) {
            open.fail(open.buffer().failure());
        }
        open.finish();
    }
}

template <class Value>
std::function<void(int, int, int, char*)> texels(const Value& value) {
    return [value](int x, int y, int z, char* to) {
        const auto texel = value(glm::ivec3(x, y, z));
        std::memcpy(to, &texel, sizeof(texel));
    };
}

void refuseLarge(const glm::ivec3& size, double voxel_size) {
    const int longest = std::max({size.x, size.y, size.z});
    if (longest <= format::kTextureLargestSide) return;
    throw Error(ErrorCode::Input, fmt::format("a texture of {} x {} x {} texels exceeds {} a side, the limit of 3D "
                                              "textures on current GPUs; bake with voxel_size = "
                                              "{:.3g} or more or a smaller domain, or export with --budget",
                                              size.x, size.y, size.z, format::kTextureLargestSide,
                                              voxel_size * 1.01 * longest / format::kTextureLargestSide));
}

Json rowsOf(const glm::dmat4& m) {
    Json rows = Json::array();
    for (int row = 0; row < 4; ++row) rows.push_back({m[0][row], m[1][row], m[2][row], m[3][row]});
    return rows;
}

// From texture coordinates 0..1 to the world, texel (0, 0, 0) centred at half a texel.
glm::dmat4 worldFromTexture(const GridFrame& frame, const VoxelBox& box) {
    glm::dmat4 m(1.0);
    const glm::dvec3 size(box.size());
    for (int axis = 0; axis < 3; ++axis) m[axis] = glm::dvec4(frame.worldFromIndex()[axis] * size[axis], 0);
    m[3] = glm::dvec4(frame.worldFromIndex(glm::dvec3(box.min) - 0.5), 1);
    return m;
}

// Unity's axes: y up, left-handed. Both of a vector's last two components and of a texture's last two axes change
// places.
glm::ivec3 turned(const glm::ivec3& v) { return {v.x, v.z, v.y}; }
glm::vec3 turned(const glm::vec3& v) { return {v.x, v.z, v.y}; }
glm::dmat4 turned(const glm::dmat4& m) {
    glm::dmat4 swap(1.0);
    swap[1] = {0, 0, 1, 0}, swap[2] = {0, 1, 0, 0};
    return swap * m * swap;
}

// Where the textures of a lobe go.
struct LobePaths {
    std::string light, rgb, flux;
};
LobePaths firstPaths(const std::string& path) { return {path, partPath(path, "_rgb"), partPath(path, "_flux")}; }
LobePaths secondPaths(const std::string& path) {
    return {partPath(path, "_2"), partPath(path, "_2_rgb"), partPath(path, "_2_flux")};
}

// The textures of a lobe for Unity; `light` must outlive them.
std::vector<TextureFile> unityFiles(const LobePaths& paths, const BoxLight& light, bool coloured) {
    const glm::ivec3 own = turned(light.size());
    std::vector<TextureFile> files;
    files.push_back({paths.light, vfHeader(own, 'F'), own, sizeof(float),
                     texels([&light](const glm::ivec3& t) { return light.irradiance(turned(t)); })});
    files.push_back({paths.flux, vfHeader(own, 'V'), own, sizeof(glm::vec3),
                     texels([&light](const glm::ivec3& t) { return turned(light.flux(turned(t))); })});
    if (coloured)
        files.push_back({paths.rgb, vfHeader(own, 'V'), own, sizeof(glm::vec3),
                         texels([&light](const glm::ivec3& t) { return light.rgb(turned(t)); })});
    return files;
}

// The textures of a lobe of half floats; `light` must outlive them.
std::vector<TextureFile> lobeFiles(const LobePaths& paths, const std::string& header, const BoxLight& light,
                                   bool coloured) {
    std::vector<TextureFile> files;
    files.push_back({paths.light, header, light.size(), sizeof(Texel),
                     texels([&light](const glm::ivec3& t) { return lightTexel(light.flux(t), light.irradiance(t)); })});
    if (coloured) {
        files.push_back({paths.rgb, header, light.size(), sizeof(Texel), texels([&light](const glm::ivec3& t) {
                             return colourTexel(light.rgb(t), light.irradiance(t));
                         })});
    }
    return files;
}

LobeTexels lobeTexels(const BoxLight& light, bool coloured) {
    const glm::ivec3 size = light.size();
    const auto row = static_cast<std::size_t>(size.x);
    const std::size_t rows = static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z);
    LobeTexels lobe;
    lobe.light.resize(4 * row * rows);
    if (coloured) lobe.rgb.resize(lobe.light.size());
    parallelFor(static_cast<std::int64_t>(rows), [&](std::int64_t at) {
        const int y = static_cast<int>(at % size.y), z = static_cast<int>(at / size.y);
        for (int x = 0; x < size.x; ++x) {
            const glm::ivec3 texel(x, y, z);
            const std::size_t place = 4 * (static_cast<std::size_t>(at) * row + static_cast<std::size_t>(x));
            const float irradiance = light.irradiance(texel);
            const Texel value = lightTexel(light.flux(texel), irradiance);
            std::memcpy(&lobe.light[place], &value, sizeof(value));
            if (!coloured) continue;
            const Texel colour = colourTexel(light.rgb(texel), irradiance);
            std::memcpy(&lobe.rgb[place], &colour, sizeof(colour));
        }
    });
    return lobe;
}

}  // namespace

DenseTexels denseTexels(const LightVolume& volume, const std::optional<VoxelBox>& wanted) {
    const StraightField straight(volume);
    const GridFrame& frame = straight.field().frame();
    const BoxLight light(straight.field(), straight.box(wanted), volume.reference_irradiance);
    refuseLarge(light.size(), frame.worldFromIndex()[0].x);
    const bool coloured = straight.field().channels().irradiance == 3;
    DenseTexels dense{light.size(), worldFromTexture(frame, light.box()), lobeTexels(light, coloured), {}, 0};
    dense.clamped = light.clamped();
    if (!straight.second()) return dense;
    const BoxLight second(*straight.second(), light.box(), volume.reference_irradiance);
    dense.second = lobeTexels(second, coloured);
    dense.clamped += second.clamped();
    return dense;
}

DenseWritten writeTextures(const std::string& path, const LightVolume& volume, TextureFormat format,
                           const std::optional<VoxelBox>& wanted) {
    OutputSet outputs;
    const DenseWritten written = writeTextures(outputs, path, volume, format, wanted);
    outputs.commit();
    return written;
}

DenseWritten writeTextures(OutputSet& outputs, const std::string& path, const LightVolume& volume, TextureFormat format,
                           const std::optional<VoxelBox>& wanted) {
    const StraightField straight(volume);
    const GridFrame& frame = straight.field().frame();
    const BoxLight light(straight.field(), straight.box(wanted), volume.reference_irradiance);
    std::optional<BoxLight> second;
    if (straight.second()) second.emplace(*straight.second(), light.box(), volume.reference_irradiance);
    const glm::ivec3 size = light.size();
    const glm::dvec3 voxel(frame.worldFromIndex()[0].x, frame.worldFromIndex()[1].y, frame.worldFromIndex()[2].z);
    refuseLarge(size, voxel.x);
    const bool coloured = straight.field().channels().irradiance == 3, unity = format == TextureFormat::UnityVf;
    const glm::dmat4 world = worldFromTexture(frame, light.box());

    const LobePaths paths = firstPaths(path), second_paths = secondPaths(path);
    const auto announce = [&](const LobePaths& of) {
        if (&of != &paths) outputs.writesBeside("the texture of the second lobe", of.light, isTexture);
        if (coloured) outputs.writesBeside("the texture of the colours", of.rgb, isTexture);
        if (unity) outputs.writesBeside("the texture of the flux", of.flux, isTexture);
    };
    announce(paths);
    if (second) announce(second_paths);
    Json json = runtimeMetadata(volume);
    json["world_from_texture"] = rowsOf(unity ? turned(world) : world);
    json["texture_size"] = unity ? Json{size.x, size.z, size.y} : Json{size.x, size.y, size.z};
    json["resampled"] = straight.resampled();
    if (unity) json["up_axis"] = "Y";
    json["handedness"] = unity ? "left" : "right";
    const auto name = [](const LobePaths& of, const std::string LobePaths::*which, bool there) {
        return there ? Json(nameOf(of.*which)) : Json(nullptr);
    };
    json["texture"] = nameOf(path);
    json["flux_texture"] = name(paths, &LobePaths::flux, unity);
    json["rgb_texture"] = name(paths, &LobePaths::rgb, coloured);
    json["texture_2"] = name(second_paths, &LobePaths::light, second.has_value());
    json["flux_texture_2"] = name(second_paths, &LobePaths::flux, second && unity);
    json["rgb_texture_2"] = name(second_paths, &LobePaths::rgb, second && coloured);
    const std::string metadata = json.dump(-1, ' ', false, Json::error_handler_t::replace);

    const std::string header = format == TextureFormat::Ktx2 ? ktx2Header(size, metadata) : ddsHeader(size);
    std::vector<TextureFile> files =
        unity ? unityFiles(paths, light, coloured) : lobeFiles(paths, header, light, coloured);
    if (second)
        for (TextureFile& file :
             unity ? unityFiles(second_paths, *second, coloured) : lobeFiles(second_paths, header, *second, coloured))
            files.push_back(std::move(file));
    writeAll(outputs, files);

    DenseWritten written{{}, size, light.clamped() + (second ? second->clamped() : 0)};
    for (const TextureFile& file : files) written.files.push_back(file.path);
    if (format != TextureFormat::Ktx2) {
        // The sidecar last: a reader that finds it finds the textures too.
        written.files.push_back(sidecarPath(path));
        outputs.write(written.files.back(), json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
    }
    return written;
}

}  // namespace photic
