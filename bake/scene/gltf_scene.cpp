// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/gltf_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "bake/report/error.h"
#include "bake/scene/gltf_animation.h"
#include "bake/scene/gltf_container.h"
#include "bake/scene/gltf_json.h"
#include "bake/scene/gltf_model.h"
#include "bake/scene/mesh_file.h"
#include "bake/scene/mesh_shape.h"
#include "bake/scene/plain_text.h"

namespace photic {
namespace {

using namespace gltf;

constexpr double kLumensAWatt = 683;  // glTF's exporters, Blender's among them, mean by a lumen 1/683 W
constexpr double kSmooth = 0.2;       // rougher glass and metal make no caustic worth baking
constexpr double kMajority = 0.5;     // of transmission, or of metal, decides
constexpr double kReach = 2;          // sizes of what bends light that its light is followed over
constexpr double kDegree = std::numbers::pi / 180;

/// A number where all channels are equal.
std::string colourText(const glm::dvec3& v) { return v.x == v.y && v.y == v.z ? number(v.x) : vectorText(v); }

/// What a part is to the bake.
enum class Part { Refractor, Mirror, Receiver, Movable, Blocker, Ignored };
constexpr std::array<const char*, 6> kPartNames{"refractor", "mirror", "receiver", "movable", "blocker", "ignored"};

struct Look {
    Part part = Part::Receiver;
    glm::dvec3 colour{1};
    double ior = 1.5, dispersion = 0;
    glm::dvec3 absorption{0};
    int priority = 0;
    bool thin = false;
};

/// Triangles of one node and material.
struct Piece {
    std::size_t node = 0;
    int material = -1;
    std::string name, node_key, material_key, keyframes;
    Look look;
    bool closed = false;
    glm::dvec3 low{0}, high{0};
    double box() const {
        const glm::dvec3 d = high - low;
        return d.x * d.y * d.z;
    }
};

class SceneWriter {
public:
    SceneWriter(const RawMesh& mesh, const Json& root, const GltfModel& model, const std::string& name)
        : mesh_(mesh),
          root_(root),
          path_(model.path()),
          name_(name),
          scene_(shownScene(root)),
          frame_rate_(frameRate(scene_, path_)),
          animation_(root, model, frame_rate_) {}

    GltfScene write() {
        walk();
        collectPieces();
        for (const std::size_t node : nodes_) addLightAndCamera(node);
        if (std::none_of(pieces_.begin(), pieces_.end(), bends)) failPlain();
        out_ = fmt::format("photic = 1\nframe_rate = {}\n", number(frame_rate_));
        Json own = ownExtras(scene_);
        own.erase("frame_rate");
        writeDomain(own);
        if (lights_.empty()) {
            lights_ = "\n[[light]]\nname = \"assumed sun\"\ntype = \"sun\"\ndirection = [0.35, 0.2, -0.9]\n";
            notes_.push_back(
                "it has no light (KHR_lights_punctual); a sun of 1000 W/m2, 24 degrees from the zenith, is "
                "assumed");
        }
        out_ += lights_;
        writePieces();
        out_ += cameras_;
        writeBake(own);
        for (std::string& note : animation_.notes()) notes_.push_back(std::move(note));
        return {std::move(out_), std::move(notes_)};
    }

private:
    [[noreturn]] void failPlain() const {
        throw Error(ErrorCode::Input,
                    fmt::format("'{}' holds nothing that bends or mirrors light: give a material transmission "
                                "(KHR_materials_transmission), or metal a roughness below {}{}",
                                path_, kSmooth,
                                rough_.empty() ? "" : fmt::format("; '{}' would do, but for its roughness", rough_)));
    }

    static Json shownScene(const Json& root) {
        const Json& scenes = memberOf(root, "scenes");
        return scenes.is_array() && !scenes.empty() ? scenes.at(static_cast<std::size_t>(numberOf(root, "scene", 0)))
                                                    : Json::object();
    }

    static double frameRate(const Json& scene, const std::string& path) {
        constexpr double kBlenders = 24;
        const Json own = ownExtras(scene);
        const Json& given = memberOf(own, "frame_rate");
        if (given.is_null()) return kBlenders;
        if (!given.is_number() || !(given.get<double>() >= 1e-3 && given.get<double>() <= 1e6))
            throw Error(ErrorCode::Input,
                        fmt::format("'{}': extras of its scene: 'photic.frame_rate' is {}; it must be "
                                    "frames a second, 0.001 to 1,000,000",
                                    path, excerpt(given.dump())));
        return given.get<double>();
    }

    static bool bends(const Piece& piece) {
        return piece.look.part == Part::Refractor || piece.look.part == Part::Mirror;
    }

    const Json& item(const char* list, std::size_t index) const {
        const Json& items = memberOf(root_, list);
        if (!items.is_array() || index >= items.size())
            throw Error(ErrorCode::Input,
                        fmt::format("'{}' refers to {}[{}], which it does not have", path_, list, index));
        return items[index];
    }

    std::string fresh(const std::string& wanted) {
        std::string name = visible(wanted);
        for (int i = 2; !names_.insert(name).second; ++i) name = fmt::format("{} {}", visible(wanted), i);
        return name;
    }

    Look lookOf(std::size_t node, int material, const std::string& name) {
        const Json none = Json::object();
        const Json& look = material >= 0 ? item("materials", static_cast<std::size_t>(material)) : none;
        const Json& pbr = memberOf(look, "pbrMetallicRoughness");
        Look out;
        out.colour = glm::clamp(vectorOf(memberOf(pbr, "baseColorFactor"), glm::dvec3(1)), 0.0, 1.0);
        const double transmission = numberOf(extensionOf(look, "KHR_materials_transmission"), "transmissionFactor", 0);
        const double metal = material < 0 ? 0 : numberOf(pbr, "metallicFactor", 1);
        const double roughness = numberOf(pbr, "roughnessFactor", 1);
        out.ior = numberOf(extensionOf(look, "KHR_materials_ior"), "ior", 1.5);
        out.dispersion = numberOf(extensionOf(look, "KHR_materials_dispersion"), "dispersion", 0);
        const Json& volume = extensionOf(look, "KHR_materials_volume");
        const double distance = numberOf(volume, "attenuationDistance", 0);
        if (distance > 0)
            out.absorption =
                -glm::log(glm::clamp(vectorOf(memberOf(volume, "attenuationColor"), glm::dvec3(1)), 1e-6, 1.0)) /
                distance;
        const bool transmits = transmission >= kMajority, mirrors = !transmits && metal >= kMajority;
        if ((transmits || mirrors) && roughness > kSmooth) {
            if (rough_.empty()) rough_ = name;
            if (transmits)
                notes_.push_back(
                    fmt::format("'{}' lets light through, but with roughness {:.2g} it makes no caustics: "
                                "it receives light; up to {} is baked as if smooth",
                                name, roughness, kSmooth));
        } else if (transmits) {
            out.part = Part::Refractor;
        } else if (mirrors) {
            out.part = Part::Mirror;
        }
        takeExtras(ownExtras(look), name, out);
        takeExtras(ownExtras(item("nodes", node)), name, out);
        return out;
    }

    /// What extras say goes before what a material looks like.
    void takeExtras(const Json& own, const std::string& name, Look& look) const {
        const auto fail = [&](const std::string& key, const std::string& limit) {
            throw Error(ErrorCode::Input, fmt::format("'{}': extras of '{}': 'photic.{}' is {}; it must be {}", path_,
                                                      name, key, excerpt(own.at(key).dump()), limit));
        };
        for (const auto& entry : own.items()) {
            const std::string& key = entry.key();
            const Json& value = entry.value();
            const auto real = [&](double least) {
                if (!value.is_number() || !(value.get<double>() >= least))
                    fail(key, fmt::format("a number of at least {}", least));
                return value.get<double>();
            };
            if (key == "role") {
                const auto found =
                    std::find(kPartNames.begin(), kPartNames.end(), value.is_string() ? value.get<std::string>() : "");
                if (found == kPartNames.end()) fail(key, fmt::format("one of {}", fmt::join(kPartNames, ", ")));
                look.part = static_cast<Part>(found - kPartNames.begin());
            } else if (key == "ior") {
                look.ior = real(0.01);
            } else if (key == "abbe") {
                look.dispersion = 20 / std::max(real(1), 1.0);
            } else if (key == "absorption") {
                if (!value.is_number() && !(value.is_array() && value.size() == 3))
                    fail(key, "a number or three [1/m]");
                look.absorption = value.is_number() ? glm::dvec3(real(0)) : vectorOf(value, glm::dvec3(0));
            } else if (key == "priority") {
                look.priority = static_cast<int>(real(-1e6));
            } else if (key == "thin") {
                if (!value.is_boolean()) fail(key, "true or false");
                look.thin = value.get<bool>();
            } else {
                throw Error(ErrorCode::Input,
                            fmt::format("'{}': extras of '{}' hold 'photic.{}', which is not known; role, ior, abbe, "
                                        "absorption, priority and thin are",
                                        path_, name, visible(key)));
            }
        }
    }

    void collectPieces() {
        std::map<std::pair<std::size_t, int>, std::size_t> known;
        std::map<std::size_t, std::set<int>> materials_of;
        for (const MeshPart& part : mesh_.parts) materials_of[part.node].insert(part.material);
        for (const MeshPart& part : mesh_.parts) {
            if (!known.emplace(std::pair(part.node, part.material), pieces_.size()).second) continue;
            Piece piece;
            piece.node = part.node, piece.material = part.material;
            piece.node_key = fmt::format("#{}", part.node);
            const std::string node = part.node_name.empty() ? fmt::format("node {}", part.node) : part.node_name;
            const bool several = materials_of[part.node].size() > 1;
            if (several) piece.material_key = fmt::format("#{}", part.material);
            piece.name =
                fresh(several ? fmt::format("{}, {}", node,
                                            part.material_name.empty() ? fmt::format("material {}", part.material)
                                                                       : part.material_name)
                              : node);
            piece.look = lookOf(part.node, part.material, piece.name);
            if (piece.look.part == Part::Ignored) continue;
            if (measure(piece)) pieces_.push_back(std::move(piece));
        }
    }

    /// Whether a piece has an area.
    bool measure(Piece& piece) {
        Monitor quiet;
        TriangleMesh mesh;
        try {
            mesh = buildMesh(onlyParts(mesh_, piece.node_key, piece.material_key, path_), UpAxis::Y, path_, quiet);
        } catch (const Error& error) {
            notes_.push_back(fmt::format("'{}' is left out: {}", piece.name, error.what()));
            return false;
        }
        piece.low = piece.high = mesh.positions.front();
        for (const glm::dvec3& p : mesh.positions)
            piece.low = glm::min(piece.low, p), piece.high = glm::max(piece.high, p);
        const glm::dvec3 rest[2] = {piece.low, piece.high};
        bool first = true;
        piece.keyframes = animation_.placementKeyframes(piece.node, piece.name, [&](const glm::dmat4& world_from_rest) {
            for (int corner = 0; corner < 8; ++corner) {
                const glm::dvec3 p(world_from_rest *
                                   glm::dvec4(rest[corner & 1].x, rest[corner >> 1 & 1].y, rest[corner >> 2].z, 1));
                piece.low = first ? p : glm::min(piece.low, p), piece.high = first ? p : glm::max(piece.high, p);
                first = false;
            }
        });
        if (bends(piece)) piece.closed = shapeOf(mesh).closed();
        return true;
    }

    // The reader of the triangles has found that nodes form trees.
    void walk() {
        const Json& nodes = memberOf(root_, "nodes");
        std::vector<std::size_t> open;
        if (const Json& roots = memberOf(scene_, "nodes"); roots.is_array()) {
            for (const Json& root : roots) open.push_back(root.get<std::size_t>());
        } else if (nodes.is_array()) {
            std::set<std::size_t> children;
            for (const Json& node : nodes)
                for (const Json& child : memberOf(node, "children")) children.insert(child.get<std::size_t>());
            for (std::size_t i = 0; i < nodes.size(); ++i)
                if (!children.contains(i)) open.push_back(i);
        }
        while (!open.empty()) {
            const std::size_t index = open.back();
            open.pop_back();
            nodes_.push_back(index);
            for (const Json& child : memberOf(item("nodes", index), "children")) {
                animation_.hang(child.get<std::size_t>(), index);
                open.push_back(child.get<std::size_t>());
            }
        }
    }

    void addLightAndCamera(std::size_t index) {
        const Json& node = item("nodes", index);
        const std::string name = textOf(node, "name");
        if (const Json& light = memberOf(extensionOf(node, "KHR_lights_punctual"), "light"); light.is_number())
            addLight(light.get<std::size_t>(), name, index);
        if (const Json& camera = memberOf(node, "camera"); camera.is_number())
            addCamera(item("cameras", camera.get<std::size_t>()), name, index);
    }

    void addLight(std::size_t index, const std::string& node_name, std::size_t node) {
        const Json& lights = memberOf(extensionOf(root_, "KHR_lights_punctual"), "lights");
        if (!lights.is_array() || index >= lights.size())
            throw Error(ErrorCode::Input, fmt::format("'{}' refers to light {}, which it does not have", path_, index));
        const Json& light = lights[index];
        const glm::dvec3 level =
            vectorOf(memberOf(light, "color"), glm::dvec3(1)) * numberOf(light, "intensity", 1) / kLumensAWatt;
        const std::string type = textOf(light, "type"), name = node_name.empty() ? textOf(light, "name") : node_name;
        if (!(std::max({level.x, level.y, level.z}) > 0)) {
            notes_.push_back(fmt::format("the light '{}' is dark, and not baked", name));
            return;
        }
        const Json own = ownExtras(light);
        const bool sun = type == "directional", aims = sun || type == "spot";
        lights_ +=
            fmt::format("\n[[light]]\nname = {}\ntype = {}\n", quoted(freshLight(name)), quoted(sun ? "sun" : type));
        const glm::dmat4 world = animation_.worldFromNode(node);
        if (const std::string keyframes = animation_.lightKeyframes(node, !sun, aims); !keyframes.empty()) {
            lights_ += keyframes;
        } else {
            if (!sun) lights_ += fmt::format("position = {}\n", vectorText(zUp(glm::dvec3(world[3]))));
            if (aims) lights_ += fmt::format("direction = {}\n", vectorText(zUp(-glm::dvec3(world[2]))));
        }
        if (sun) {
            lights_ += fmt::format("irradiance = {}\n", colourText(level));
            if (own.contains("angular_diameter"))
                lights_ += fmt::format("angular_diameter = {}\n", number(numberOf(own, "angular_diameter", 0.53)));
            return;
        }
        lights_ += fmt::format("power = {}\n", colourText(4 * std::numbers::pi * level));
        if (type != "spot") return;
        const Json& spot = memberOf(light, "spot");
        const double outer = numberOf(spot, "outerConeAngle", std::numbers::pi / 4),
                     inner = numberOf(spot, "innerConeAngle", 0);
        const double rim = std::cos(outer);
        lights_ += fmt::format("angle = {}\nblend = {}\n", number(2 * outer / kDegree),
                               number(std::clamp((std::cos(inner) - rim) / std::max(1 - rim, 1e-12), 0.0, 1.0)));
    }

    std::string freshLight(const std::string& name) {
        std::string out = visible(name.empty() ? "light" : name);
        for (int i = 2; !light_names_.insert(out).second; ++i) out = fmt::format("{} {}", visible(name), i);
        return out;
    }

    void addCamera(const Json& camera, const std::string& name, std::size_t node) {
        const Json& view = memberOf(camera, "perspective");
        if (!view.is_object()) {
            notes_.push_back(fmt::format("the camera '{}' has no perspective, and is left out", visible(name)));
            return;
        }
        if (animation_.moves(node))
            notes_.push_back(
                fmt::format("the camera '{}' moves, which is not read: it looks from where it rests", visible(name)));
        const glm::dmat4 world = animation_.worldFromNode(node);
        const glm::dvec3 place = zUp(glm::dvec3(world[3]));
        const glm::dvec3 sight = glm::normalize(zUp(glm::dvec3(world * glm::dvec4(0, 0, -1, 0))));
        const glm::dvec3 up = glm::normalize(zUp(glm::dvec3(world * glm::dvec4(0, 1, 0, 0))));
        cameras_ +=
            fmt::format("\n[[camera]]\nname = {}\nposition = {}\ntarget = {}\nup = {}\nfield_of_view = {}\n",
                        quoted(fresh(name.empty() ? "camera" : name)), vectorText(place), vectorText(place + sight),
                        vectorText(up), number(numberOf(view, "yfov", 0.6) / kDegree));
    }

    /// The keys of a table of extras that belong to one table of the scene file.
    static std::string keysOf(const Json& own, bool domain) {
        static const std::set<std::string> kDomain{"min",        "max",   "fit",         "voxel_size",
                                                   "resolution", "shear", "layer_height"};
        std::string out;
        for (const auto& [key, value] : own.items())
            if (kDomain.contains(key) == domain) out += fmt::format("{} = {}\n", key, value.dump());
        return out;
    }

    /// As far as the light of what bends it is followed, inside of what the scene shows.
    void writeDomain(const Json& own) {
        out_ += "\n[domain]\n" + keysOf(own, true);
        if (own.contains("min") || own.contains("max") || own.contains("fit")) return;
        glm::dvec3 low(1e300), high(-1e300), all_low(1e300), all_high(-1e300);
        for (const Piece& piece : pieces_) {
            if (piece.look.part != Part::Blocker)
                all_low = glm::min(all_low, piece.low), all_high = glm::max(all_high, piece.high);
            if (bends(piece)) low = glm::min(low, piece.low), high = glm::max(high, piece.high);
        }
        const glm::dvec3 size = high - low;
        const double reach = kReach * std::max({size.x, size.y, size.z});
        const glm::dvec3 margin(0.02 * std::max({size.x, size.y, size.z}));
        const glm::dvec3 min = glm::max(low - reach, all_low) - margin, max = glm::min(high + reach, all_high) + margin;
        out_ += fmt::format("min = {}\nmax = {}\n", vectorText(min), vectorText(max));
        notes_.push_back(
            fmt::format("the box from {} to {} m is baked: {} sizes around what bends light, as far as there "
                        "is something",
                        vectorText(min), vectorText(max), kReach));
    }

    void writeBake(const Json& own) {
        if (const std::string keys = keysOf(own, false); !keys.empty()) out_ += "\n[bake]\n" + keys;
    }

    std::string shapeText(const Piece& piece) const {
        return fmt::format("name = {}\nfile = {}\nnode = {}\n{}{}", quoted(piece.name), quoted(name_),
                           quoted(piece.node_key),
                           piece.material_key.empty() ? "" : fmt::format("material = {}\n", quoted(piece.material_key)),
                           piece.keyframes);
    }

    void writePieces() {
        // Where bodies overlap, the smaller one is what is there.
        std::vector<const Piece*> glass;
        for (const Piece& piece : pieces_)
            if (piece.look.part == Part::Refractor) glass.push_back(&piece);
        std::stable_sort(glass.begin(), glass.end(),
                         [](const Piece* a, const Piece* b) { return a->box() > b->box(); });
        std::string surfaces, objects;
        int priority = 0, received = 0;
        for (const Piece* piece : glass) surfaces += refractorText(*piece, piece->closed ? ++priority : 0);
        for (const Piece& piece : pieces_) {
            if (piece.look.part == Part::Refractor) continue;
            if (piece.look.part == Part::Mirror) {
                surfaces += fmt::format("\n[[surface]]\n{}kind = \"mesh\"\nevent = \"mirror\"\ncolour = {}\n",
                                        shapeText(piece), colourText(piece.look.colour));
                notes_.push_back(fmt::format("'{}' is a mirror", piece.name));
                continue;
            }
            received += piece.look.part != Part::Blocker;
            objects +=
                fmt::format("\n[[object]]\n{}role = \"{}\"\nalbedo = {}\n", shapeText(piece),
                            kPartNames[static_cast<std::size_t>(piece.look.part)], colourText(piece.look.colour));
        }
        out_ += surfaces + objects;
        notes_.push_back(received > 0 ? fmt::format("{} other parts receive light", received)
                                      : "nothing else receives light: it shows in the air alone");
    }

    std::string refractorText(const Piece& piece, int by_size) {
        const Look& look = piece.look;
        const std::string medium = fmt::format("inside of {}", piece.name);
        std::string out = fmt::format("\n[[medium]]\nname = {}\n", quoted(medium));
        // KHR_materials_dispersion is 20 over Abbe's number.
        out += look.dispersion > 0 ? fmt::format("abbe = [{}, {}]\n", number(look.ior), number(20 / look.dispersion))
                                   : fmt::format("ior = {}\n", number(look.ior));
        if (look.absorption != glm::dvec3(0)) out += fmt::format("absorption = {}\n", colourText(look.absorption));
        out += fmt::format("priority = {}\n", look.priority != 0 ? look.priority : by_size);
        out += fmt::format("\n[[surface]]\n{}kind = \"mesh\"\ninside = {}\nevent = \"{}\"\n{}", shapeText(piece),
                           quoted(medium), piece.closed || look.thin ? "both" : "refract",
                           look.thin ? "thin = true\n" : "");
        notes_.push_back(fmt::format("'{}' is {} of index {}", piece.name,
                                     look.thin      ? "a thin pane"
                                     : piece.closed ? "a body"
                                                    : "open, and taken for the surface of a medium",
                                     number(look.ior)));
        return out;
    }

    const RawMesh& mesh_;
    const Json& root_;
    const std::string& path_;
    const std::string& name_;
    Json scene_;
    double frame_rate_;
    GltfAnimation animation_;
    std::vector<std::size_t> nodes_;  // that the scene shows
    std::vector<Piece> pieces_;
    std::set<std::string> names_, light_names_;
    std::vector<std::string> notes_;
    std::string out_, lights_, cameras_, rough_;
};

}  // namespace

GltfScene sceneOfGltf(const std::string& bytes, const std::string& path, const std::string& name,
                      const std::function<void(std::string_view)>& use_bytes) {
    GltfContainer container = openGltf(bytes, path, use_bytes);
    const std::string looks = std::move(container.looks);
    const GltfModel model(std::move(container), path);
    const RawMesh mesh = readGltf(model);
    try {
        const Json root = Json::parse(looks);
        GltfScene scene = SceneWriter(mesh, root, model, name).write();
        scene.notes.insert(scene.notes.begin(), mesh.warnings.begin(), mesh.warnings.end());
        return scene;
    } catch (const Json::exception& error) {
        throw Error(ErrorCode::Input,
                    fmt::format("cannot read '{}', which is damaged or no glTF 2.0: {}", path, visible(error.what())));
    }
}

}  // namespace photic
