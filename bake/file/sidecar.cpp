// SPDX-License-Identifier: Apache-2.0
#include "bake/file/sidecar.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

namespace photic {

namespace fs = std::filesystem;

std::string sidecarPath(const std::string& path) { return path + ".json"; }

std::string partPath(const std::string& path, const char* suffix) {
    const fs::path target(path);
    return (target.parent_path() / (target.stem().string() + suffix + target.extension().string())).string();
}

std::string nameOf(const std::string& path) { return fs::path(path).filename().string(); }

bool isSidecar(const std::string& path) {
    constexpr std::uintmax_t kLargest = std::uintmax_t{1} << 24;
    std::error_code failure;
    if (fs::file_size(path, failure) > kLargest || failure) return false;
    std::ifstream file(path, std::ios::binary);
    const auto json = nlohmann::json::parse(file, nullptr, false);
    return json.is_object() &&
           (json.contains("photic_atlas") || (json.contains("texture") && json.contains("world_from_texture")));
}

bool isTexture(const std::string& path) {
    constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kBeginnings{
        {{".exr", "\x76\x2f\x31\x01"}, {".dds", "DDS "}, {".ktx2", "\xabKTX 20"}, {".vf", "VF_"}}};
    std::ifstream file(path, std::ios::binary);
    std::array<char, 8> begin{};
    file.read(begin.data(), begin.size());
    const std::string extension = fs::path(path).extension().string();
    for (const auto& [ending, bytes] : kBeginnings)
        if (extension == ending) return std::string_view(begin.data(), bytes.size()) == bytes;
    return false;
}

}  // namespace photic
