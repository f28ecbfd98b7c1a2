// SPDX-License-Identifier: Apache-2.0
// make_seeds FOLDER: small good files of every kind, from which the fuzzer sets out: FOLDER/obj, ply, gltf, exr, png,
// vdb.
#include <fmt/format.h>
#include <zlib.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "bake/image/image.h"
#include "tests/file/file_test_support.h"

namespace photic {
namespace {

std::string folder;

std::string seed(const std::string& kind, const std::string& name) {
    std::filesystem::create_directories(folder + "/" + kind);
    return folder + "/" + kind + "/" + name;
}

void meshSeeds() {
    writeBytes(seed("obj", "quad.obj"),
               "# a quad and a triangle\nmtllib a.mtl\no one\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nvn 0 0 1\nvt 0 0\n"
               "usemtl x\ns 1\nf 1/1/1 2/1/1 3/1/1 4/1/1\nf -4 -3 -1\ng two\nf 1//1 \\\n 3//1 4//1\n");
    const std::string head =
        "ply\nformat {} 1.0\ncomment made\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "property double nx\nproperty double ny\nproperty double nz\nelement face 2\nproperty list uchar int "
        "vertex_indices\nend_header\n";
    writeBytes(seed("ply", "ascii.ply"),
               fmt::format(fmt::runtime(head), "ascii") +
                   "0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n4 0 1 2 3\n");
    std::string binary = fmt::format(fmt::runtime(head), "binary_little_endian");
    const auto put = [&](auto value) { binary.append(reinterpret_cast<const char*>(&value), sizeof value); };
    for (int i = 0; i < 4; ++i) {
        for (const float p : {float(i & 1), float(i >> 1), 0.f}) put(p);
        for (const double n : {0.0, 0.0, 1.0}) put(n);
    }
    for (const std::array<int, 3>& t : {std::array{0, 1, 2}, std::array{1, 3, 2}}) {
        put(static_cast<unsigned char>(3));
        for (const int corner : t) put(corner);
    }
    writeBytes(seed("ply", "binary.ply"), binary);
}

void gltfSeed() {
    std::string data;
    const auto put = [&](auto value) { data.append(reinterpret_cast<const char*>(&value), sizeof value); };
    for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, 0.f, 0.f, 1.f, 0.f}) put(x);
    for (const std::uint16_t i : {0, 1, 2, 0, 2, 3}) put(i);
    std::string json =
        R"({"asset":{"version":"2.0"},"extensionsUsed":["KHR_lights_punctual","KHR_materials_transmission",)"
        R"("KHR_materials_ior","KHR_materials_volume","KHR_materials_dispersion"],"scene":0,"scenes":[{"nodes":[0,1,2]}],)"
        R"("nodes":[{"name":"pane","mesh":0,"translation":[0,1,0],"children":[]},{"rotation":[0.7,0,0,0.7],)"
        R"("extensions":{"KHR_lights_punctual":{"light":0}}},{"camera":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,3,1]}],)"
        R"("cameras":[{"type":"perspective","perspective":{"yfov":0.7,"znear":0.1}}],)"
        R"("extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot","intensity":100,"color":[1,0.9,0.8],)"
        R"("spot":{"innerConeAngle":0.1,"outerConeAngle":0.4}}]}},"materials":[{"name":"glass","extensions":)"
        R"({"KHR_materials_transmission":{"transmissionFactor":1},"KHR_materials_ior":{"ior":1.45},)"
        R"("KHR_materials_volume":{"thicknessFactor":1,"attenuationDistance":2,"attenuationColor":[1,0.5,0.4]},)"
        R"("KHR_materials_dispersion":{"dispersion":0.1}},"pbrMetallicRoughness":{"roughnessFactor":0},)"
        R"("extras":{"photic":{"role":"receiver"}}}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,)"
        R"("material":0}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],)"
        R"("max":[1,1,0]},{"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}],"bufferViews":[{"buffer":0,)"
        R"("byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}],"buffers":[{"byteLength":60}]})";
    while (json.size() % 4 != 0) json += ' ';
    std::string file = "glTF";
    const auto number = [&](std::size_t value) {
        const auto n = static_cast<std::uint32_t>(value);
        file.append(reinterpret_cast<const char*>(&n), 4);
    };
    number(2), number(12 + 8 + json.size() + 8 + data.size());
    number(json.size()), file += "JSON" + json;
    number(data.size()), file += std::string("BIN\0", 4) + data;
    writeBytes(seed("gltf", "pane.glb"), file);
}

void imageSeeds() {
    Image image{4, 3, 1, std::vector<float>(12, 0.25f)};
    image.pixels[5] = 1;
    for (const auto& [name, depth] : {std::pair{"half.exr", ChannelDepth::Half},
                                      {"float.exr", ChannelDepth::Float},
                                      {"uint.exr", ChannelDepth::Uint32}})
        writeExr(seed("exr", name), image, depth);
    writeExr(seed("exr", "rgb.exr"), Image{2, 2, 3, std::vector<float>(12, 0.5f)});

    std::string png = "\x89PNG\r\n\x1a\n";
    const auto chunk = [&](const std::string& body) {  // its name first
        const auto put = [&](std::uint32_t n) {
            for (int shift = 24; shift >= 0; shift -= 8) png += static_cast<char>(n >> shift & 255);
        };
        put(static_cast<std::uint32_t>(body.size() - 4)), png += body;
        put(static_cast<std::uint32_t>(
            crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()))));
    };
    chunk(std::string("IHDR\0\0\0\4\0\0\0\3\x10\0\0\0\0", 17));
    std::string rows;
    for (int y = 0; y < 3; ++y) rows += std::string(1, static_cast<char>(y)) + std::string("\1\2\3\4\5\6\7\x8", 8);
    std::vector<Bytef> packed(compressBound(static_cast<uLong>(rows.size())));
    uLongf size = packed.size();
    compress(packed.data(), &size, reinterpret_cast<const Bytef*>(rows.data()), static_cast<uLong>(rows.size()));
    chunk("IDAT" + std::string(reinterpret_cast<const char*>(packed.data()), size));
    chunk("IEND");
    writeBytes(seed("png", "grey16.png"), png);
}

void volumeSeeds() {
    const GridFrame small = straightFrame({6, 6, 6}, {9, 9, 9}, 0.1);
    for (const auto& [name, compression] : {std::pair{"none", Compression::None},
                                            {"mask", Compression::Mask},
                                            {"blosc", Compression::Blosc},
                                            {"zip", Compression::Zip}})
        for (const bool half : {false, true})
            writeVdb(seed("vdb", fmt::format("{}_{}.vdb", name, half ? "half" : "float")),
                     testVolume(half ? small : leaningFrame({0, 0, 0}, {2, 3, 3}, 0.2), half), {compression, half});
}

}  // namespace
}  // namespace photic

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    photic::folder = argv[1];
    photic::meshSeeds(), photic::gltfSeed(), photic::imageSeeds(), photic::volumeSeeds();
    return 0;
}
