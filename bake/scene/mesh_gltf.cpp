// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <charconv>
#include <cstring>
#include <fstream>
#include <glm/ext/quaternion_double.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <nlohmann/json.hpp>

#include "bake/libraries/tiny_gltf.h"
#include "bake/report/error.h"
#include "bake/scene/gltf_container.h"
#include "bake/scene/mesh_file.h"
#include "bake/scene/plain_text.h"

namespace photic {
namespace {

constexpr std::size_t kMostElements = std::size_t{1} << 28;   // of an accessor
constexpr std::size_t kMostTriangles = std::size_t{1} << 27;  // of a file

bool ignoreImage(tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*, int, void*) {
    return true;
}

/// The buffer of the container that a name stands for, or null.
const std::string* bufferNamed(const std::string& name, void* container) {
    constexpr std::string_view kPrefix = "photic-buffer-";
    const auto& buffers = static_cast<const GltfContainer*>(container)->buffers;
    const std::size_t at = name.rfind(kPrefix);
    std::size_t i = buffers.size();
    if (at != name.npos) std::from_chars(name.data() + at + kPrefix.size(), name.data() + name.size(), i);
    return i < buffers.size() ? &buffers[i] : nullptr;
}

bool bufferExists(const std::string& name, void* container) { return bufferNamed(name, container) != nullptr; }
std::string sameName(const std::string& name, void*) { return name; }
bool takeBuffer(std::vector<unsigned char>* out, std::string*, const std::string& name, void* container) {
    const std::string* bytes = bufferNamed(name, container);
    if (bytes) out->assign(bytes->begin(), bytes->end());
    return bytes != nullptr;
}
bool sizeOfBuffer(std::size_t* size, std::string*, const std::string& name, void* container) {
    const std::string* bytes = bufferNamed(name, container);
    if (bytes) *size = bytes->size();
    return bytes != nullptr;
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class GltfReader {
public:
    GltfReader(const tinygltf::Model& model, const std::string& path)
        : model_(model), path_(path), visited_(model.nodes.size(), 0) {}

    RawMesh read() {
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
            if (model_.scenes.size() > 1)
                mesh_.warnings.push_back(fmt::format("of its {} scenes only the default one, '{}', is read",
                                                     model_.scenes.size(), excerpt(model_.scenes[scene].name)));
        }
        if (!has_normals_) mesh_.normals.clear();
        mesh_.holds = fmt::format("{} meshes, of which the scene shows {} with points or lines, and no triangle",
                                  model_.meshes.size(), thin_);
        if (hidden_ > 0) mesh_.holds += fmt::format("; {} nodes are hidden (KHR_node_visibility)", hidden_);
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
        if (node.rotation.size() == 4) {
            const glm::dquat turn(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
            if (glm::length(turn) > 0) m = glm::mat4_cast(glm::normalize(turn));  // some files round it too far
        }
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
            fail(fmt::format("node {} ('{}') has more than one parent; nodes must form trees", i,
                             excerpt(model_.nodes[i].name)));
        const tinygltf::Node& node = model_.nodes[i];
        if (isHidden(node)) {
            ++hidden_;
            return;
        }
        const glm::dmat4 world_from_node = world_from_parent * transformOf(node);
        part_.node = i, part_.node_name = node.name;
        if (node.mesh >= 0) addMesh(node, world_from_node);
        for (const int child : node.children) addNode(child, world_from_node, depth + 1);
    }

    /// KHR_node_visibility: what is invisible is so with all that hangs on it.
    static bool isHidden(const tinygltf::Node& node) {
        const auto extension = node.extensions.find("KHR_node_visibility");
        if (extension == node.extensions.end() || !extension->second.Has("visible")) return false;
        const tinygltf::Value& visible = extension->second.Get("visible");
        return visible.IsBool() && !visible.Get<bool>();
    }

    void addMesh(const tinygltf::Node& node, const glm::dmat4& world_from_node) {
        if (node.skin >= 0)
            fail(fmt::format("node '{}' is bent by bones (a skin), which is not read; apply the armature before export",
                             excerpt(node.name)));
        const tinygltf::Mesh& mesh = model_.meshes[checked(node.mesh, model_.meshes.size(), "mesh")];
        const std::vector<double>& weights = node.weights.empty() ? mesh.weights : node.weights;
        for (const glm::dmat4& node_from_instance : instancesOf(node))
            for (const tinygltf::Primitive& primitive : mesh.primitives)
                addPrimitive(primitive, weights, world_from_node * node_from_instance, node.name);
    }

    /// Copies of a node's mesh (EXT_mesh_gpu_instancing), or the one.
    std::vector<glm::dmat4> instancesOf(const tinygltf::Node& node) const {
        const auto extension = node.extensions.find("EXT_mesh_gpu_instancing");
        if (extension == node.extensions.end()) return {glm::dmat4(1)};
        const tinygltf::Value attributes =
            extension->second.Has("attributes") ? extension->second.Get("attributes") : tinygltf::Value();
        std::vector<glm::dmat4> out;
        const auto forEach = [&](const char* name, std::size_t components, const auto& use) {
            if (!attributes.Has(name)) return;
            const std::vector<double> values = numbers(attributes.Get(name).GetNumberAsInt(), components, name);
            const std::size_t count = values.size() / components;
            if (!out.empty() && out.size() != count)
                fail(fmt::format("node '{}' has {} instances by one attribute and {} by {}", excerpt(node.name),
                                 out.size(), count, name));
            out.resize(count, glm::dmat4(1));
            for (std::size_t i = 0; i < count; ++i) use(out[i], &values[i * components]);
        };
        forEach("ROTATION", 4, [](glm::dmat4& m, const double* v) {
            m = glm::mat4_cast(glm::normalize(glm::dquat(v[3], v[0], v[1], v[2])));
        });
        forEach("SCALE", 3, [](glm::dmat4& m, const double* v) {
            for (int a = 0; a < 3; ++a) m[a] *= v[a];
        });
        forEach("TRANSLATION", 3, [](glm::dmat4& m, const double* v) { m[3] = glm::dvec4(v[0], v[1], v[2], 1); });
        return out;
    }

    /// Elements that follow one another in a buffer view.
    struct Run {
        int buffer_view = -1;
        std::size_t byte_offset = 0;
        std::size_t count = 0, components = 0;
        int component_type = 0;
        bool normalised = false;  ///< integers stand for fractions of their largest
    };

    template <typename T>
    void copyRun(const Run& run, const unsigned char* at, std::size_t step, double* out) const {
        const double unit = run.normalised && std::numeric_limits<T>::is_integer
                                ? 1.0 / static_cast<double>(std::numeric_limits<T>::max())
                                : 1.0;
        for (std::size_t i = 0; i < run.count; ++i, at += step)
            for (std::size_t c = 0; c < run.components; ++c) {
                T value;
                std::memcpy(&value, at + c * sizeof(T), sizeof(T));
                *out++ = std::max(static_cast<double>(value) * unit, unit == 1 ? -kInfinity : -1.0);
            }
    }

    /// The numbers of a run, where all of it lies within its buffer.
    std::vector<double> readRun(const Run& run, int accessor, std::size_t stride) const {
        const tinygltf::BufferView& view =
            model_.bufferViews[checked(run.buffer_view, model_.bufferViews.size(), "buffer view")];
        const std::vector<unsigned char>& data =
            model_.buffers[checked(view.buffer, model_.buffers.size(), "buffer")].data;
        const int component = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(run.component_type));
        const std::size_t size = run.components * static_cast<std::size_t>(std::max(component, 0));
        const std::size_t step = stride > 0 ? stride : size;
        const std::size_t room =
            data.size() < view.byteOffset ? 0 : std::min(data.size() - view.byteOffset, view.byteLength);
        const bool fits = size > 0 && step >= size && run.byte_offset <= room && room - run.byte_offset >= size &&
                          run.count > 0 && run.count - 1 <= (room - run.byte_offset - size) / step;
        if (!fits)
            fail(fmt::format("accessor {} ({} elements) reaches beyond its buffer; the file is damaged or truncated",
                             accessor, run.count));
        std::vector<double> out(run.count * run.components);
        const unsigned char* at = data.data() + view.byteOffset + run.byte_offset;
        switch (run.component_type) {
            case TINYGLTF_COMPONENT_TYPE_BYTE:
                copyRun<std::int8_t>(run, at, step, out.data());
                break;
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
                copyRun<std::uint8_t>(run, at, step, out.data());
                break;
            case TINYGLTF_COMPONENT_TYPE_SHORT:
                copyRun<std::int16_t>(run, at, step, out.data());
                break;
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
                copyRun<std::uint16_t>(run, at, step, out.data());
                break;
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
                copyRun<std::uint32_t>(run, at, step, out.data());
                break;
            case TINYGLTF_COMPONENT_TYPE_FLOAT:
                copyRun<float>(run, at, step, out.data());
                break;
            default:
                fail(fmt::format("accessor {} holds numbers of type {}, which glTF does not know", accessor,
                                 run.component_type));
        }
        return out;
    }

    /// All numbers of an accessor, with what a sparse one replaces.
    std::vector<double> numbers(int index, std::size_t components, const char* what) const {
        const tinygltf::Accessor& accessor = model_.accessors[checked(index, model_.accessors.size(), "accessor")];
        if (tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)) != static_cast<int>(components))
            fail(fmt::format("accessor {} ({}) does not hold {} numbers an element", index, what, components));
        if (accessor.count > kMostElements)
            fail(fmt::format("accessor {} has {} elements; up to {} are read", index, accessor.count, kMostElements));
        Run run{accessor.bufferView, accessor.byteOffset,    accessor.count,
                components,          accessor.componentType, accessor.normalized};
        std::vector<double> out;
        if (accessor.bufferView >= 0) {
            const tinygltf::BufferView& view =
                model_.bufferViews[checked(accessor.bufferView, model_.bufferViews.size(), "buffer view")];
            out = readRun(run, index, view.byteStride);
        } else {
            out.assign(accessor.count * components, 0.0);  // the standard's meaning
        }
        if (!accessor.sparse.isSparse) return out;
        const auto& sparse = accessor.sparse;
        const auto count = static_cast<std::size_t>(std::max(sparse.count, 0));
        const std::vector<double> places =
            readRun({sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset), count, 1,
                     sparse.indices.componentType, false},
                    index, 0);
        run.buffer_view = sparse.values.bufferView, run.count = count;
        run.byte_offset = static_cast<std::size_t>(sparse.values.byteOffset);
        const std::vector<double> values = readRun(run, index, 0);
        for (std::size_t i = 0; i < count; ++i) {
            if (!(places[i] >= 0 && places[i] < static_cast<double>(accessor.count)))
                fail(fmt::format("accessor {} replaces element {} of {}", index, places[i], accessor.count));
            std::copy_n(&values[i * components], components, &out[static_cast<std::size_t>(places[i]) * components]);
        }
        return out;
    }

    std::vector<glm::dvec3> vectors(int index, const char* what) const {
        const std::vector<double> flat = numbers(index, 3, what);
        std::vector<glm::dvec3> out(flat.size() / 3);
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = {flat[3 * i], flat[3 * i + 1], flat[3 * i + 2]};
        return out;
    }

    std::vector<std::uint32_t> indices(int index) const {
        const int type = model_.accessors[checked(index, model_.accessors.size(), "accessor")].componentType;
        if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
            type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
            fail(fmt::format("accessor {} holds indices of type {}; 8, 16 or 32 unsigned bits are read", index, type));
        const std::vector<double> flat = numbers(index, 1, "indices");
        std::vector<std::uint32_t> out(flat.size());
        std::transform(flat.begin(), flat.end(), out.begin(), [](double v) { return static_cast<std::uint32_t>(v); });
        return out;
    }

    /// Positions or normals of a primitive, moved by its morph targets.
    std::vector<glm::dvec3> attribute(const tinygltf::Primitive& primitive, int accessor, const char* name,
                                      const std::vector<double>& weights) const {
        std::vector<glm::dvec3> out = vectors(accessor, name);
        for (std::size_t t = 0; t < std::min(weights.size(), primitive.targets.size()); ++t) {
            const auto moved = primitive.targets[t].find(name);
            if (weights[t] == 0 || moved == primitive.targets[t].end()) continue;
            const std::vector<glm::dvec3> by = vectors(moved->second, name);
            if (by.size() != out.size())
                fail(fmt::format("morph target {} moves {} vertices of {}", t, by.size(), out.size()));
            for (std::size_t i = 0; i < out.size(); ++i) out[i] += weights[t] * by[i];
        }
        return out;
    }

    /// A morph target may move places and say nothing of normals: those of the shape at rest would then bend light as
    /// that shape does, however high the waves. Without normals they are made from the faces.
    static bool losesItsNormals(const tinygltf::Primitive& primitive, const std::vector<double>& weights) {
        for (std::size_t t = 0; t < std::min(weights.size(), primitive.targets.size()); ++t)
            if (weights[t] != 0 && primitive.targets[t].count("POSITION") > 0 &&
                primitive.targets[t].count("NORMAL") == 0)
                return true;
        return false;
    }

    void addPrimitive(const tinygltf::Primitive& primitive, const std::vector<double>& weights,
                      const glm::dmat4& world_from_node, const std::string& name) {
        if (primitive.mode == TINYGLTF_MODE_POINTS || primitive.mode == TINYGLTF_MODE_LINE ||
            primitive.mode == TINYGLTF_MODE_LINE_LOOP || primitive.mode == TINYGLTF_MODE_LINE_STRIP) {
            ++thin_;
            return;  // no surface
        }
        if (primitive.mode != TINYGLTF_MODE_TRIANGLES && primitive.mode != -1)
            fail(fmt::format("node '{}' is made of strips or fans (mode {}), which are not read; export triangles",
                             name, primitive.mode));
        const auto position = primitive.attributes.find("POSITION");
        if (position == primitive.attributes.end()) return;  // nothing to draw, says the standard

        const auto base = static_cast<std::uint32_t>(mesh_.positions.size());
        const std::vector<glm::dvec3> positions = attribute(primitive, position->second, "POSITION", weights);
        for (const glm::dvec3& p : positions) mesh_.positions.push_back(glm::dvec3(world_from_node * glm::dvec4(p, 1)));

        const glm::dmat3 linear(world_from_node);
        const double determinant = glm::determinant(linear);
        const auto normal = primitive.attributes.find("NORMAL");
        mesh_.normals.resize(mesh_.positions.size(), glm::dvec3(0));
        if (normal != primitive.attributes.end() && determinant != 0 && !losesItsNormals(primitive, weights)) {
            const std::vector<glm::dvec3> normals = attribute(primitive, normal->second, "NORMAL", weights);
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
        if (mesh_.triangles.size() + corners.size() / 3 > kMostTriangles)
            fail(fmt::format("has more than {} triangles with all its instances; simplify it", kMostTriangles));
        MeshPart part = part_;
        part.material = primitive.material, part.first = mesh_.triangles.size(), part.count = corners.size() / 3;
        if (primitive.material >= 0)
            part.material_name =
                model_.materials[checked(primitive.material, model_.materials.size(), "material")].name;
        if (part.count > 0) mesh_.parts.push_back(std::move(part));
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
    int thin_ = 0, hidden_ = 0;
    MeshPart part_;  // that triangles are now added to
    RawMesh mesh_;
};

}  // namespace

RawMesh readGltf(const std::string& bytes, const std::string& path,
                 const std::function<void(std::string_view)>& use_bytes) {
    return readGltf(openGltf(bytes, path, use_bytes), path);
}

RawMesh readGltf(GltfContainer container, const std::string& path) {
    if (container.json.size() > std::numeric_limits<unsigned>::max())
        throw Error(ErrorCode::Input,
                    fmt::format("'{}' has {} bytes of JSON; it may have up to 4 GiB", path, container.json.size()));
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(ignoreImage, nullptr);
    gltf::useFiles(loader, {bufferExists, sameName, takeBuffer, sizeOfBuffer, &container});
    tinygltf::Model model;
    std::string error, warning;
    bool ok = false;
    try {
        ok = loader.LoadASCIIFromString(&model, &error, &warning, container.json.data(),
                                        static_cast<unsigned>(container.json.size()), "");
    } catch (const std::exception& failure) {
        error = failure.what();
    }
    if (!ok) {
        while (!error.empty() && error.back() == '\n') error.pop_back();
        throw Error(ErrorCode::Input, fmt::format("cannot read '{}', which is damaged or no glTF 2.0: {}", path,
                                                  error.empty() ? "unknown reason" : error));
    }
    container.buffers.clear();  // the model has its own
    RawMesh mesh = GltfReader(model, path).read();
    mesh.warnings.insert(mesh.warnings.begin(), container.warnings.begin(), container.warnings.end());
    return mesh;
}

}  // namespace photic
