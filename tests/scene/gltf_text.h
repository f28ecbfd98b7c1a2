// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace photic::test {

inline std::string base64(const std::string& bytes) {
    constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t v = 0;
        for (std::size_t k = 0; k < 3; ++k) v = v << 8 | (i + k < bytes.size() ? std::uint8_t(bytes[i + k]) : 0u);
        for (int s = 18; s >= 0; s -= 6) out += digits[v >> s & 63];
        for (std::size_t k = bytes.size() - i; k < 3; ++k) out[out.size() - (3 - k)] = '=';
    }
    return out;
}

/// A glTF that is put together by hand: a square of two triangles, 2 m wide, in the plane y = 0 of its own axes (z = 0
/// of the world), facing up. A test changes what it is about.
struct GltfText {
    nlohmann::json root;
    std::string buffer;

    GltfText() {
        root = {{"asset", {{"version", "2.0"}}},          {"scene", 0},
                {"scenes", {{{"nodes", {0}}}}},           {"nodes", {{{"mesh", 0}, {"name", "sheet"}}}},
                {"bufferViews", nlohmann::json::array()}, {"accessors", nlohmann::json::array()}};
        const int positions = add<float>({-1, 0, 1, 1, 0, 1, 1, 0, -1, -1, 0, -1}, 5126, "VEC3"),
                  indices = add<std::uint16_t>({0, 1, 2, 0, 2, 3}, 5123, "SCALAR");
        root["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}}}}}};
    }
    nlohmann::json& node() { return root["nodes"][0]; }
    nlohmann::json& mesh() { return root["meshes"][0]; }
    nlohmann::json& primitive() { return mesh()["primitives"][0]; }

    template <typename T>
    int addView(const std::vector<T>& values) {
        const std::size_t offset = buffer.size(), length = values.size() * sizeof(T);
        buffer.append(reinterpret_cast<const char*>(values.data()), length);
        buffer.resize((buffer.size() + 3) / 4 * 4);
        root["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", length}});
        return static_cast<int>(root["bufferViews"].size()) - 1;
    }
    template <typename T>
    int add(const std::vector<T>& values, int component_type, const std::string& type) {
        const std::size_t parts = type == "SCALAR" ? 1 : type == "VEC4" ? 4 : 3;
        root["accessors"].push_back({{"bufferView", addView(values)},
                                     {"componentType", component_type},
                                     {"count", values.size() / parts},
                                     {"type", type}});
        return static_cast<int>(root["accessors"].size()) - 1;
    }

    /// With its buffer as a data URI, or as `uri` says.
    std::string text(const std::string& uri = "") const {
        nlohmann::json whole = root;
        whole["buffers"] = {{{"byteLength", buffer.size()},
                             {"uri", uri.empty() ? "data:application/octet-stream;base64," + base64(buffer) : uri}}};
        return whole.dump();
    }
    std::string binary() const {
        nlohmann::json whole = root;
        whole["buffers"] = {{{"byteLength", buffer.size()}}};
        std::string json = whole.dump();
        json.resize((json.size() + 3) / 4 * 4, ' ');
        std::string out = "glTF";
        const auto put = [&](std::size_t value) {
            const auto v = static_cast<std::uint32_t>(value);
            out.append(reinterpret_cast<const char*>(&v), 4);
        };
        put(2), put(12 + 8 + json.size() + 8 + buffer.size());
        put(json.size()), put(0x4e4f534a), out += json;
        put(buffer.size()), put(0x004e4942), out += buffer;
        return out;
    }
};

}  // namespace photic::test
