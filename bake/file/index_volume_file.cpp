// SPDX-License-Identifier: Apache-2.0
#include "bake/file/index_volume_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "bake/volume/half_floats.h"
#include "runtime/format/index_volume_format.h"
#include "runtime/format/light_volume_format.h"

namespace photic {
namespace {

template <class Number>
void put(std::string& bytes, std::size_t at, Number value) {
    std::memcpy(bytes.data() + at, &value, sizeof(value));
}

/// Appends an array at the next place that is aligned. @return that place
std::uint64_t append(std::string& bytes, const void* from, std::size_t size) {
    bytes.resize((bytes.size() + format::kIndexAlignment - 1) / format::kIndexAlignment * format::kIndexAlignment, 0);
    const std::uint64_t at = bytes.size();
    bytes.append(static_cast<const char*>(from), size);
    return at;
}

std::uint64_t appendHalves(std::string& bytes, const std::vector<glm::vec4>& values) {
    std::vector<float> floats;
    floats.reserve(4 * values.size());
    for (const glm::vec4& v : values)
        for (int c = 0; c < 4; ++c) floats.push_back(std::clamp(v[c], -format::kLargest, format::kLargest));
    std::vector<std::uint16_t> halves(floats.size());
    halfConversion().toHalf(floats.data(), floats.size(), halves.data());
    return append(bytes, halves.data(), halves.size() * sizeof(std::uint16_t));
}

std::uint64_t appendCoat(std::string& bytes, const std::vector<glm::vec3>& values) {
    std::vector<std::uint8_t> coat;
    coat.reserve(3 * values.size());
    for (const glm::vec3& v : values)
        for (int c = 0; c < 3; ++c)
            coat.push_back(static_cast<std::uint8_t>(std::lround(255 * std::clamp(v[c], 0.0f, 1.0f))));
    return append(bytes, coat.data(), coat.size());
}

void putHeader(std::string& bytes, std::size_t at, const IndexVolumeObject& object) {
    std::memcpy(bytes.data() + at + format::kIndexNameAt, object.name.data(),
                std::min<std::size_t>(object.name.size(), format::kIndexNameSize - 1));
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
            put(bytes, at + format::kIndexWorldFromNodeAt + 8 * static_cast<std::size_t>(4 * row + column),
                column < 3 ? object.world_from_node[column][row] : object.origin_world[row]);
    for (int a = 0; a < 3; ++a) {
        const auto place = static_cast<std::size_t>(4 * a);
        put(bytes, at + format::kIndexNodesAt + place, static_cast<std::uint32_t>(object.count[a]));
        put(bytes, at + format::kIndexScatteringAt + place, static_cast<float>(object.scattering[a]));
        put(bytes, at + format::kIndexBoxAt + place, object.box_low[a]);
        put(bytes, at + format::kIndexBoxAt + 12 + place, object.box_high[a]);
    }
    put(bytes, at + format::kIndexChannelsAt, static_cast<std::uint32_t>(object.spline.size()));
    put(bytes, at + format::kIndexFlagsAt, std::uint32_t{object.sharp_sides ? format::kIndexSharpSides : 0u});
    put(bytes, at + format::kIndexAnisotropyAt, static_cast<float>(object.anisotropy));
}

std::uint64_t appendShape(std::string& bytes, const SharpShape& shape) {
    const bool ball = shape.triangles.empty();
    std::string block(format::kShapeHeader, '\0');
    put(block, format::kShapeKindAt,
        std::uint32_t{ball                    ? format::kShapeBall
                      : shape.normals.empty() ? format::kShapeFlat
                                              : format::kShapeSmooth});
    put(block, format::kShapeVerticesAt, static_cast<std::uint32_t>(ball ? 0 : shape.positions.size()));
    put(block, format::kShapeTrianglesAt, static_cast<std::uint32_t>(shape.triangles.size()));
    put(block, format::kShapeFacesAt, static_cast<std::uint32_t>(shape.faces));
    put(block, format::kShapeRankAt, static_cast<std::uint32_t>(shape.rank));
    for (int c = 0; c < 3; ++c) {
        const auto place = static_cast<std::size_t>(4 * c);
        put(block, format::kShapeIndexAt + place, static_cast<float>(shape.index[c]));
        put(block, format::kShapeAbsorptionAt + place, static_cast<float>(shape.absorption[c]));
        put(block, format::kShapeColourAt + place, static_cast<float>(shape.colour[c]));
    }
    if (ball) {
        for (int c = 0; c < 4; ++c) put(block, format::kShapeBallAt + 4 * static_cast<std::size_t>(c), shape.ball[c]);
    } else {
        for (const auto* vectors : {&shape.positions, &shape.normals})
            for (const glm::vec3& v : *vectors)
                for (int c = 0; c < 3; ++c) block.append(reinterpret_cast<const char*>(&v[c]), sizeof(float));
        block.append(reinterpret_cast<const char*>(shape.triangles.data()),
                     shape.triangles.size() * sizeof(shape.triangles[0]));
    }
    return append(bytes, block.data(), block.size());
}

unsigned versionOf(const std::vector<IndexVolumeObject>& objects) {
    unsigned version = format::kIndexFirstVersion;
    for (const IndexVolumeObject& object : objects) {
        if (object.shape) return format::kIndexVersion;
        if (object.reflects()) version = format::kIndexCoatVersion;
    }
    return version;
}

}  // namespace

std::string indexVolumeBytes(const std::vector<IndexVolumeObject>& objects) {
    const unsigned version = versionOf(objects);
    const unsigned header =
        version == format::kIndexFirstVersion ? format::kIndexFirstHeader : format::kIndexObjectHeader;
    std::string bytes(format::kIndexFileHeader + header * objects.size(), '\0');
    std::memcpy(bytes.data(), format::kIndexMagic, 8);
    put(bytes, format::kIndexVersionAt, std::uint32_t{version});
    put(bytes, format::kIndexObjectsAt, static_cast<std::uint32_t>(objects.size()));
    for (std::size_t i = 0; i < objects.size(); ++i) {
        const IndexVolumeObject& object = objects[i];
        const std::size_t at = format::kIndexFileHeader + header * i;
        putHeader(bytes, at, object);
        std::vector<float> all;
        for (const auto& channel : object.spline) all.insert(all.end(), channel.begin(), channel.end());
        std::array<std::uint64_t, 4> offsets{};
        if (!all.empty()) offsets[format::kIndexSpline] = append(bytes, all.data(), all.size() * sizeof(float));
        if (!object.attenuation.empty()) offsets[format::kIndexAttenuation] = appendHalves(bytes, object.attenuation);
        if (!object.glow.empty()) offsets[format::kIndexGlow] = appendHalves(bytes, object.glow);
        if (!object.faces.empty())
            offsets[format::kIndexFaces] = append(bytes, object.faces.data(), object.faces.size());
        for (std::size_t k = 0; k < offsets.size(); ++k) put(bytes, at + format::kIndexOffsetsAt + 8 * k, offsets[k]);
        if (version == format::kIndexFirstVersion) continue;
        for (int c = 0; c < 3; ++c)
            put(bytes, at + format::kIndexAlbedoAt + 4 * static_cast<std::size_t>(c),
                static_cast<float>(object.albedo[c]));
        put(bytes, at + format::kIndexRoughnessAt, static_cast<float>(object.roughness));
        if (!object.coat.empty()) {
            const std::uint64_t coat = appendCoat(bytes, object.coat);
            put(bytes, at + format::kIndexCoatAt, coat);
        }
        if (object.shape) {
            const std::uint64_t shape = appendShape(bytes, *object.shape);
            put(bytes, at + format::kIndexShapeAt, shape);
        }
    }
    put(bytes, format::kIndexFileSizeAt, static_cast<std::uint64_t>(bytes.size()));
    return bytes;
}

}  // namespace photic
