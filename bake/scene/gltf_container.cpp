// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/gltf_container.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "bake/image/atomic_file.h"
#include "bake/report/error.h"
#include "bake/scene/plain_text.h"

namespace photic {
namespace {

using Json = nlohmann::json;

constexpr int kDeepest = 64;

/// Extensions of a file that says it can't be understood without them, and that are read here or are about looks.
constexpr std::array<std::string_view, 11> kHarmless{"KHR_mesh_quantization", "EXT_mesh_gpu_instancing",
                                                     "KHR_lights_punctual",   "KHR_materials_",
                                                     "KHR_texture_",          "EXT_texture_",
                                                     "MSFT_texture_dds",      "KHR_xmp_json_ld",
                                                     "KHR_animation_pointer", "KHR_node_visibility",
                                                     "EXT_mesh_manifold"};
constexpr std::array<std::string_view, 3> kCompressing{"KHR_draco_mesh_compression", "EXT_meshopt_compression",
                                                       "KHR_meshopt_compression"};

class ContainerReader {
public:
    ContainerReader(const std::string& path, const std::function<void(std::string_view)>& use_bytes)
        : path_(path), use_bytes_(use_bytes) {}

    GltfContainer read(std::string_view bytes) {
        if (bytes.substr(0, 4) == "glTF") {
            readBinary(bytes);
        } else {
            text_ = plainText(bytes, path_);
        }
        checkDepth();
        try {
            root_ = Json::parse(text_);
        } catch (const Json::exception& error) {
            const std::string_view why(error.what());
            damaged(visible(why.substr(std::min(why.find(']') + 1, why.size()), 120)));
        }
        try {
            checkExtensions();
            checkNumbers();
            noteAnimations();
            readBuffers();
        } catch (const Json::exception& error) {
            damaged(visible(error.what()));
        }
        for (const char* key : {"images", "textures", "samplers"}) root_.erase(key);
        Json looks = root_;
        looks.erase("buffers");
        out_.looks = looks.dump();
        // Nothing of these has a shape.
        for (const char* key : {"cameras", "extras", "animations"}) root_.erase(key);
        if (const auto materials = root_.find("materials"); materials != root_.end())
            for (Json& material : *materials) {
                const auto name = material.is_object() ? material.find("name") : material.end();
                Json named = Json::object();
                if (material.is_object() && name != material.end() && name->is_string()) named["name"] = *name;
                material = std::move(named);
            }
        out_.json = root_.dump();
        return std::move(out_);
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw Error(ErrorCode::Input, fmt::format("'{}' {}", path_, what));
    }
    [[noreturn]] void damaged(const std::string& why) const {
        throw Error(ErrorCode::Input, fmt::format("cannot read '{}', which is damaged or no glTF 2.0: {}", path_, why));
    }

    /// A GLB is a header of 12 bytes, a chunk of JSON, and one of bytes; each chunk says its length and type.
    void readBinary(std::string_view bytes) {
        const auto number = [&](std::size_t at) {
            std::uint32_t value = 0;
            if (bytes.size() < at + 4) damaged(fmt::format("it ends after {} bytes", bytes.size()));
            std::memcpy(&value, bytes.data() + at, 4);
            return value;
        };
        if (number(4) != 2) damaged(fmt::format("it is of version {}; version 2 is read", number(4)));
        const std::size_t length = number(8);
        if (length > bytes.size())
            damaged(fmt::format("it says that it has {} bytes, and has {}: it is truncated", length, bytes.size()));
        for (std::size_t at = 12; at + 8 <= length;) {
            const std::size_t size = number(at);
            const std::uint32_t type = number(at + 4);
            if (size > length - at - 8)
                damaged(fmt::format("a chunk of {} bytes begins at byte {} of {}", size, at, length));
            constexpr std::uint32_t kJson = 0x4e4f534a, kBinary = 0x004e4942;
            if (type == kJson && at == 12) text_ = bytes.substr(at + 8, size);
            if (type == kBinary && !binary_) binary_ = bytes.substr(at + 8, size);
            at += 8 + size;
        }
        if (text_.empty()) damaged("its first chunk is no JSON");
    }

    /// Readers descend a level per bracket, and never ask how deep they are.
    void checkDepth() const {
        int depth = 0;
        bool quoted = false;
        for (std::size_t i = 0; i < text_.size(); ++i) {
            const char c = text_[i];
            if (quoted) {
                if (c == '\\') ++i;
                quoted = c != '"';
            } else if (c == '"') {
                quoted = true;
            } else if (c == '[' || c == '{') {
                if (++depth > kDeepest)
                    damaged(fmt::format("its JSON is nested more than {} deep at byte {}", kDeepest, i));
            } else if (c == ']' || c == '}') {
                --depth;
            }
        }
    }

    bool uses(std::string_view extension) const {
        const auto lists = [&](const char* key) {
            const auto list = root_.find(key);
            return list != root_.end() && list->is_array() &&
                   std::any_of(list->begin(), list->end(), [&](const Json& name) {
                       return name.is_string() && name.get<std::string>() == extension;
                   });
        };
        return lists("extensionsUsed") || lists("extensionsRequired");
    }

    [[noreturn]] void failCompressed(std::string_view extension) const {
        fail(fmt::format("needs the extension {}, which is not read; export without mesh compression", extension));
    }

    void checkExtensions() const {
        if (!root_.is_object() || !root_.contains("asset")) damaged("it has no 'asset'");
        const std::string version = root_.at("asset").value("version", "");
        if (version.substr(0, 2) != "2.") damaged(fmt::format("it is of version '{}'; 2.0 is read", excerpt(version)));
        const std::string least = root_.at("asset").value("minVersion", "2.0");
        if (least != "2.0")
            fail(fmt::format("asks for readers of glTF '{}' at least; 2.0 is read: export as 2.0", excerpt(least)));
        for (const Json& required : root_.value("extensionsRequired", Json::array())) {
            const std::string name = required.get<std::string>();
            if (std::find(kCompressing.begin(), kCompressing.end(), name) != kCompressing.end()) failCompressed(name);
            if (std::none_of(kHarmless.begin(), kHarmless.end(),
                             [&](std::string_view known) { return name.substr(0, known.size()) == known; }))
                fail(fmt::format("needs the extension {}, which is not read; export without it", excerpt(name)));
        }
        // Compressed parts without a plain copy beside them.
        for (const Json& mesh : root_.value("meshes", Json::array()))
            for (const Json& primitive : mesh.value("primitives", Json::array())) {
                if (!primitive.value("extensions", Json::object()).contains(kCompressing[0])) continue;
                const Json attributes = primitive.value("attributes", Json::object());
                for (const Json& accessor : attributes)
                    if (!root_.at("accessors").at(accessor.get<std::size_t>()).contains("bufferView"))
                        failCompressed(kCompressing[0]);
            }
    }

    /// Offsets and sizes are not negative; the parser would make large ones of them.
    void checkNumbers() const {
        const auto check = [&](const Json& item, const char* list, std::size_t i) {
            for (const char* key : {"byteOffset", "byteLength", "byteStride", "count"}) {
                const auto value = item.find(key);
                if (value != item.end() && (!value->is_number() || value->get<double>() < 0))
                    damaged(fmt::format("'{}' of {} {} is {}", key, list, i, excerpt(value->dump())));
            }
        };
        for (const char* list : {"accessors", "bufferViews", "buffers"}) {
            std::size_t i = 0;
            for (const Json& item : root_.value(list, Json::array())) {
                check(item, list, i);
                if (const auto sparse = item.find("sparse"); sparse != item.end()) {
                    check(*sparse, list, i);
                    check(sparse->value("indices", Json::object()), list, i);
                    check(sparse->value("values", Json::object()), list, i);
                }
                ++i;
            }
        }
    }

    /// A mesh is read as it stands.
    void noteAnimations() {
        std::size_t moving = 0;
        for (const Json& animation : root_.value("animations", Json::array()))
            for (const Json& channel : animation.value("channels", Json::array())) {
                const Json target = channel.value("target", Json::object());
                moving += target.contains("node") || target.value("path", "") == "pointer";
            }
        if (moving > 0)
            out_.motion = fmt::format(
                "its {} animated channels are not read: everything stays where the file puts it; bake the "
                "glTF as a scene, or let photic scene write one, for it to move",
                moving);
    }

    static int hexDigit(char c) {
        if (c >= '0' && c <= '9') return c - '0';
        if (c >= 'a' && c <= 'f') return c - 'a' + 10;
        if (c >= 'A' && c <= 'F') return c - 'A' + 10;
        return -1;
    }

    /// "%20" is a space; "+" is itself (RFC 3986; only forms write spaces so).
    static std::string decoded(std::string_view uri) {
        std::string out;
        for (std::size_t i = 0; i < uri.size(); ++i) {
            const bool escaped =
                uri[i] == '%' && i + 2 < uri.size() && hexDigit(uri[i + 1]) >= 0 && hexDigit(uri[i + 2]) >= 0;
            out += escaped ? static_cast<char>(16 * hexDigit(uri[i + 1]) + hexDigit(uri[i + 2])) : uri[i];
            if (escaped) i += 2;
        }
        return out;
    }

    std::string fromBase64(std::string_view text, std::size_t buffer) const {
        std::string out;
        std::uint32_t bits = 0;
        int count = 0;
        for (const char c : text.substr(0, std::min(text.find('='), text.size()))) {
            int v = -1;
            if (c >= 'A' && c <= 'Z') v = c - 'A';
            if (c >= 'a' && c <= 'z') v = c - 'a' + 26;
            if (c >= '0' && c <= '9') v = c - '0' + 52;
            if (c == '+' || c == '-') v = 62;
            if (c == '/' || c == '_') v = 63;
            if (v < 0) damaged(fmt::format("the data of buffer {} is no base64", buffer));
            bits = bits << 6 | static_cast<std::uint32_t>(v);
            if ((count += 6) >= 8) count -= 8, out += static_cast<char>(bits >> count);
        }
        return out;
    }

    std::string fromDataUri(std::string_view uri, std::size_t buffer) const {
        const std::size_t comma = uri.find(',');
        const std::string_view header = uri.substr(0, std::min(comma, uri.size()));
        if (comma == uri.npos ||
            (header != "data:application/octet-stream;base64" && header != "data:application/gltf-buffer;base64"))
            fail(
                fmt::format("holds buffer {} as '{}', whose media type is not that of a buffer; it must be "
                            "data:application/octet-stream;base64",
                            buffer, excerpt(header)));
        return fromBase64(uri.substr(comma + 1), buffer);
    }

    std::string fromFile(const std::string& uri, std::size_t buffer) const {
        const std::string file = decoded(uri);
        const std::size_t colon = file.find(':');
        // "C:" is a drive, "https:" a scheme.
        if (std::filesystem::path(file).is_absolute() || file.front() == '\\' ||
            (colon != file.npos && colon < file.find('/')) || file.find('\0') != file.npos)
            fail(fmt::format("looks for buffer {} at '{}'; only files beside it are read, by a relative name", buffer,
                             excerpt(file)));
        std::string bytes = readFileBytes((std::filesystem::path(path_).parent_path() / file).string());
        use_bytes_(bytes);
        return bytes;
    }

    void readBuffers() {
        const auto buffers = root_.find("buffers");
        if (buffers == root_.end()) return;
        for (std::size_t i = 0; i < buffers->size(); ++i) {
            Json& buffer = buffers->at(i);
            const auto length = buffer.value("byteLength", std::uint64_t{0});
            const std::string uri = buffer.value("uri", "");
            std::string bytes;
            if (!uri.empty()) {
                bytes = uri.substr(0, 5) == "data:" ? fromDataUri(uri, i) : fromFile(uri, i);
            } else if (i == 0 && binary_) {
                bytes = *binary_;
            } else {
                for (const std::string_view extension : kCompressing)
                    if (uses(extension)) failCompressed(extension);
                damaged(fmt::format("buffer {} has no uri", i));
            }
            if (bytes.size() < length || length == 0)
                damaged(fmt::format("buffer {} claims {} bytes and has {}; it is damaged or truncated", i, length,
                                    bytes.size()));
            bytes.resize(length);  // files may be padded
            out_.buffers.push_back(std::move(bytes));
            buffer = {{"byteLength", length}, {"uri", fmt::format("photic-buffer-{}", i)}};
        }
    }

    const std::string& path_;
    const std::function<void(std::string_view)>& use_bytes_;
    std::string_view text_;
    std::optional<std::string_view> binary_;
    Json root_;
    GltfContainer out_;
};

}  // namespace

GltfContainer openGltf(const std::string& bytes, const std::string& path,
                       const std::function<void(std::string_view)>& use_bytes) {
    return ContainerReader(path, use_bytes).read(bytes);
}

}  // namespace photic
