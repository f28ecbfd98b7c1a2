// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
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
#include "bake/scene/gltf_model.h"
#include "bake/scene/mesh_file.h"
#include "bake/scene/plain_text.h"

namespace photic {
namespace {

constexpr std::size_t kMostTriangles = std::size_t{1} << 27;  // of a file

class GltfReader {
public:
    explicit GltfReader(const GltfModel& file) : file_(file), model_(file.parts()), visited_(model_.nodes.size(), 0) {}

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
    [[noreturn]] void fail(const std::string& what) const { file_.fail(what); }
    std::size_t checked(int index, std::size_t count, const char* what) const {
        return file_.checked(index, count, what);
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
            const std::vector<double> values = file_.numbers(attributes.Get(name).GetNumberAsInt(), components, name);
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

    std::vector<glm::dvec3> vectors(int index, const char* what) const {
        const std::vector<double> flat = file_.numbers(index, 3, what);
        std::vector<glm::dvec3> out(flat.size() / 3);
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = {flat[3 * i], flat[3 * i + 1], flat[3 * i + 2]};
        return out;
    }

    std::vector<std::uint32_t> indices(int index) const {
        const int type = model_.accessors[checked(index, model_.accessors.size(), "accessor")].componentType;
        if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
            type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
            fail(fmt::format("accessor {} holds indices of type {}; 8, 16 or 32 unsigned bits are read", index, type));
        const std::vector<double> flat = file_.numbers(index, 1, "indices");
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

    const GltfModel& file_;
    const tinygltf::Model& model_;
    std::vector<char> visited_;
    bool has_normals_ = false;
    int thin_ = 0, hidden_ = 0;
    MeshPart part_;  // that triangles are now added to
    RawMesh mesh_;
};

}  // namespace

RawMesh readGltf(const std::string& bytes, const std::string& path,
                 const std::function<void(std::string_view)>& use_bytes) {
    return readGltf(GltfModel(openGltf(bytes, path, use_bytes), path));
}

RawMesh readGltf(const GltfModel& model) {
    RawMesh mesh = GltfReader(model).read();
    const GltfContainer& shell = model.container();
    mesh.warnings.insert(mesh.warnings.begin(), shell.warnings.begin(), shell.warnings.end());
    mesh.motion = shell.motion;
    return mesh;
}

}  // namespace photic
