// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/ext/quaternion_double.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <set>

#include "bake/image/atomic_file.h"
#include "bake/libraries/tiny_gltf.h"
#include "bake/report/error.h"
#include "bake/scene/mesh_file.h"

namespace photic {
namespace {

using UseBytes = std::function<void(std::string_view)>;

bool ignoreImage(tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*, int, void*) {
    return true;
}

bool fileExists(const std::string& path, void*) { return std::filesystem::is_regular_file(path); }
std::string samePath(const std::string& path, void*) { return path; }
bool readWholeFile(std::vector<unsigned char>* out, std::string* error, const std::string& path, void* use_bytes) {
    try {
        const std::string bytes = readFileBytes(path);
        (*static_cast<const UseBytes*>(use_bytes))(bytes);
        out->assign(bytes.begin(), bytes.end());
        return true;
    } catch (const Error& failure) {
        *error = failure.what();
        return false;
    }
}

class GltfReader {
public:
    GltfReader(const tinygltf::Model& model, const std::string& path)
        : model_(model), path_(path), visited_(model.nodes.size(), 0) {}

    RawMesh read() {
        static const std::set<std::string> compressing{"KHR_draco_mesh_compression", "EXT_meshopt_compression",
                                                       "KHR_mesh_quantization"};
        for (const std::string& extension : model_.extensionsRequired)
            if (compressing.count(extension))
                fail(fmt::format("needs the extension {}, which is not read; export without mesh compression",
                                 extension));

        if (model_.scenes.empty()) {
            std::vector<char> is_child(model_.nodes.size(), 0);
            for (const tinygltf::Node& node : model_.nodes)
                for (const int child : node.children) is_child[checked(child, model_.nodes.size(), "node")] = 1;
            for (std::size_t i = 0; i < is_child.size(); ++i)
                if (!is_child[i]) addNode(static_cast<int>(i), glm::dmat4(1), 0);
        } else {
            const std::size_t scene =
                model_.defaultScene < 0 ? 0 : checked(model_.defaultScene, model_.scenes.size(), "scene");
            for (const int node : model_.scenes[scene].nodes) addNode(node, glm::dmat4(1), 0);
        }
        if (!has_normals_) mesh_.normals.clear();
        return std::move(mesh_);
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw Error(ErrorCode::Input, fmt::format("'{}' {}", path_, what));
    }

    std::size_t checked(int index, std::size_t count, const char* what) const {
        if (index < 0 || static_cast<std::size_t>(index) >= count)
            fail(fmt::format("refers to {} {}, but has {}", what, index, count));
        return static_cast<std::size_t>(index);
    }

    /// Parent-from-node transform.
    static glm::dmat4 transformOf(const tinygltf::Node& node) {
        glm::dmat4 m(1);
        if (node.matrix.size() == 16) {
            for (int c = 0; c < 4; ++c)
                for (int r = 0; r < 4; ++r) m[c][r] = node.matrix[static_cast<std::size_t>(4 * c + r)];
            return m;
        }
        if (node.rotation.size() == 4)
            m = glm::mat4_cast(glm::dquat(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]));
        for (std::size_t a = 0; a < 3; ++a) {
            if (node.scale.size() == 3) m[static_cast<int>(a)] *= node.scale[a];
            if (node.translation.size() == 3) m[3][static_cast<int>(a)] = node.translation[a];
        }
        return m;
    }

    void addNode(int index, const glm::dmat4& world_from_parent, int depth) {
        const std::size_t i = checked(index, model_.nodes.size(), "node");
        // A node has one parent: a second visit is a loop or a knot.
        if (visited_[i]++ || depth > 1000)
            fail(
                fmt::format("node {} ('{}') has more than one parent; nodes must form trees", i, model_.nodes[i].name));
        const tinygltf::Node& node = model_.nodes[i];
        const glm::dmat4 world_from_node = world_from_parent * transformOf(node);
        if (node.mesh >= 0)
            for (const tinygltf::Primitive& primitive :
                 model_.meshes[checked(node.mesh, model_.meshes.size(), "mesh")].primitives)
                addPrimitive(primitive, world_from_node, node.name);
        for (const int child : node.children) addNode(child, world_from_node, depth + 1);
    }

    /// Elements of an accessor, each `components` numbers of T, where all of them lie within the buffer.
    template <typename T, typename Use>
    void forEachElement(const tinygltf::Accessor& accessor, int index, std::size_t components, const Use& use) const {
        if (accessor.sparse.isSparse || accessor.bufferView < 0)
            fail(fmt::format("accessor {} is sparse, which is not read; export plain buffers", index));
        const tinygltf::BufferView& view =
            model_.bufferViews[checked(accessor.bufferView, model_.bufferViews.size(), "buffer view")];
        const std::vector<unsigned char>& data =
            model_.buffers[checked(view.buffer, model_.buffers.size(), "buffer")].data;
        const int stride = accessor.ByteStride(view);
        const std::size_t size = components * sizeof(T), step = static_cast<std::size_t>(std::max(stride, 0));
        const std::size_t room =
            data.size() < view.byteOffset ? 0 : std::min(data.size() - view.byteOffset, view.byteLength);
        const bool fits = stride > 0 && step >= size && accessor.byteOffset <= room &&
                          room - accessor.byteOffset >= size && accessor.count > 0 &&
                          accessor.count - 1 <= (room - accessor.byteOffset - size) / step;
        if (!fits)
            fail(fmt::format("accessor {} ({} elements) reaches beyond its buffer; the file is damaged or truncated",
                             index, accessor.count));
        const unsigned char* at = data.data() + view.byteOffset + accessor.byteOffset;
        for (std::size_t i = 0; i < accessor.count; ++i, at += step) {
            T values[4];
            std::memcpy(values, at, size);
            use(values);
        }
    }

    std::vector<glm::dvec3> vectors(int index, const char* what) const {
        const tinygltf::Accessor& accessor = model_.accessors[checked(index, model_.accessors.size(), "accessor")];
        if (accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT || accessor.type != TINYGLTF_TYPE_VEC3)
            fail(fmt::format("accessor {} ({}) does not hold float vectors; export without quantisation", index, what));
        std::vector<glm::dvec3> out;
        forEachElement<float>(accessor, index, 3, [&](const float* v) { out.emplace_back(v[0], v[1], v[2]); });
        return out;
    }

    std::vector<std::uint32_t> indices(int index) const {
        const tinygltf::Accessor& accessor = model_.accessors[checked(index, model_.accessors.size(), "accessor")];
        std::vector<std::uint32_t> out;
        const auto add = [&](const auto* v) { out.push_back(static_cast<std::uint32_t>(v[0])); };
        switch (accessor.componentType) {
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
                forEachElement<std::uint8_t>(accessor, index, 1, add);
                break;
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
                forEachElement<std::uint16_t>(accessor, index, 1, add);
                break;
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
                forEachElement<std::uint32_t>(accessor, index, 1, add);
                break;
            default:
                fail(fmt::format("accessor {} holds indices of type {}; 8, 16 or 32 unsigned bits are read", index,
                                 accessor.componentType));
        }
        return out;
    }

    void addPrimitive(const tinygltf::Primitive& primitive, const glm::dmat4& world_from_node,
                      const std::string& name) {
        if (primitive.mode == TINYGLTF_MODE_POINTS || primitive.mode == TINYGLTF_MODE_LINE ||
            primitive.mode == TINYGLTF_MODE_LINE_LOOP || primitive.mode == TINYGLTF_MODE_LINE_STRIP)
            return;  // no surface
        if (primitive.mode != TINYGLTF_MODE_TRIANGLES && primitive.mode != -1)
            fail(fmt::format("node '{}' is made of strips or fans (mode {}), which are not read; export triangles",
                             name, primitive.mode));
        const auto position = primitive.attributes.find("POSITION");
        if (position == primitive.attributes.end()) return;  // nothing to draw, says the standard

        const auto base = static_cast<std::uint32_t>(mesh_.positions.size());
        const std::vector<glm::dvec3> positions = vectors(position->second, "POSITION");
        for (const glm::dvec3& p : positions) mesh_.positions.push_back(glm::dvec3(world_from_node * glm::dvec4(p, 1)));

        const glm::dmat3 linear(world_from_node);
        const double determinant = glm::determinant(linear);
        const auto normal = primitive.attributes.find("NORMAL");
        mesh_.normals.resize(mesh_.positions.size(), glm::dvec3(0));
        if (normal != primitive.attributes.end() && determinant != 0) {
            const std::vector<glm::dvec3> normals = vectors(normal->second, "NORMAL");
            if (normals.size() != positions.size())
                fail(fmt::format("node '{}' has {} positions and {} normals", name, positions.size(), normals.size()));
            const glm::dmat3 world_from_normal = glm::transpose(glm::inverse(linear));
            for (std::size_t i = 0; i < normals.size(); ++i) mesh_.normals[base + i] = world_from_normal * normals[i];
            has_normals_ = true;
        }

        std::vector<std::uint32_t> corners;
        if (primitive.indices >= 0)
            corners = indices(primitive.indices);
        else
            for (std::uint32_t i = 0; i < positions.size(); ++i) corners.push_back(i);
        if (corners.size() % 3 != 0)
            fail(fmt::format("node '{}' has {} corners, no multiple of 3", name, corners.size()));
        for (std::size_t i = 0; i < corners.size(); i += 3) {
            std::array<std::uint32_t, 3> triangle{corners[i], corners[i + 1], corners[i + 2]};
            for (std::uint32_t& corner : triangle) {
                if (corner >= positions.size())
                    fail(fmt::format("node '{}': triangle {} uses vertex {}, which is out of range; there are {}", name,
                                     i / 3, corner, positions.size()));
                corner += base;
            }
            if (determinant < 0) std::swap(triangle[1], triangle[2]);  // a mirroring transform turns the winding
            mesh_.triangles.push_back(triangle);
        }
    }

    const tinygltf::Model& model_;
    const std::string& path_;
    std::vector<char> visited_;
    bool has_normals_ = false;
    RawMesh mesh_;
};

}  // namespace

RawMesh readGltf(const std::string& bytes, const std::string& path, const UseBytes& use_bytes) {
    if (bytes.size() > std::numeric_limits<unsigned>::max())
        throw Error(ErrorCode::Input,
                    fmt::format("'{}' has {} bytes; a glTF may have up to 4 GiB", path, bytes.size()));
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(ignoreImage, nullptr);
    gltf::useFiles(loader, {fileExists, samePath, readWholeFile, const_cast<UseBytes*>(&use_bytes)});
    tinygltf::Model model;
    std::string error, warning;
    bool ok = false;
    try {
        const std::string directory = std::filesystem::path(path).parent_path().string();
        const auto length = static_cast<unsigned>(bytes.size());
        const bool binary = bytes.compare(0, 4, "glTF") == 0;
        ok = binary
                 ? loader.LoadBinaryFromMemory(&model, &error, &warning,
                                               reinterpret_cast<const unsigned char*>(bytes.data()), length, directory)
                 : loader.LoadASCIIFromString(&model, &error, &warning, bytes.data(), length, directory);
    } catch (const std::exception& failure) {
        error = failure.what();
    }
    if (!ok) {
        while (!error.empty() && error.back() == '\n') error.pop_back();
        throw Error(ErrorCode::Input, fmt::format("cannot read '{}', which is damaged or no glTF 2.0: {}", path,
                                                  error.empty() ? "unknown reason" : error));
    }
    return GltfReader(model, path).read();
}

}  // namespace photic
