// SPDX-License-Identifier: Apache-2.0
// Light volumes as they were: the examples and one scene of every kind at low resolution, against
// tests/data/pinned_volumes.txt. Light changes only where somebody meant it to. After such a change
//     PHOTIC_WRITE_PINS=1 build/release/bin/test_conformance --gtest_filter='PinnedVolumes.*'
// writes the file again; its difference then belongs to the commit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "bake/scene/load_toml.h"
#include "bake/scene/wave_field.h"
#include "tests/conformance/bake_scene.h"

namespace photic {
namespace {

constexpr int kBlock = 8;     // voxels a side
constexpr int kLongest = 48;  // voxels
constexpr double kBlockTolerance = 2e-4, kLayerTolerance = 5e-5;

const char* const kPins = PHOTIC_SOURCE_DIR "/tests/data/pinned_volumes.txt";

/// What may touch the light of a block, so that its exact value isn't pinned.
enum class Touch : char {
    Free = 'f',   ///< nothing: must stay as it is
    Opens = 'o',  ///< the water's surface: tubes open here
    Ends = 'e'    ///< light ends in it or before it: on receivers, in shadows
};

struct BlockMean {
    Touch touch = Touch::Free;
    double value = 0;  ///< mean irradiance [W/m2]
};

/// A field in few numbers.
struct Summary {
    std::string hash;
    glm::ivec3 blocks{0};
    std::vector<BlockMean> means;                   ///< x fastest
    std::vector<std::pair<double, double>> layers;  ///< of the free blocks: sums of irradiance and of downward flux
    const BlockMean& at(int x, int y, int z) const { return means[index(x, y, z)]; }
    std::size_t index(int x, int y, int z) const { return (static_cast<std::size_t>(z) * blocks.y + y) * blocks.x + x; }
};

/// FNV-1a over all values.
std::string hashOf(const LightField& field) {
    std::uint64_t hash = 0xcbf29ce484222325;
    const auto add = [&](const void* data, std::size_t size) {
        for (std::size_t i = 0; i < size; ++i)
            hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 0x100000001b3;
    };
    const auto channels = static_cast<std::size_t>(field.channels().count());
    for (int slot = 0; slot < field.leafCount(); ++slot) {
        const auto state = static_cast<unsigned char>(field.state(slot));
        add(&state, 1);
        if (field.state(slot) == LeafState::Dense)
            add(field.dense(slot), channels * LightField::kLeafVoxels * sizeof(float));
        if (field.state(slot) == LeafState::Constant) add(field.constant(slot).data(), channels * sizeof(float));
    }
    return fmt::format("{:016x}", hash);
}

struct Interval {
    double low, high;
};
Interval surfaceHeights(const Surface& surface) {
    if (surface.height_field) return {surface.height_field->minZ(), surface.height_field->maxZ()};
    Interval z{1e300, -1e300};
    for (const glm::dvec3& p : surface.mesh->positions) z = {std::min(z.low, p.z), std::max(z.high, p.z)};
    return z;
}

Summary summarise(const LightField& field) {
    const GridFrame& f = field.frame();
    Summary s;
    s.hash = hashOf(field);
    s.blocks = (f.size() + kBlock - 1) / kBlock;
    s.means.resize(static_cast<std::size_t>(s.blocks.x) * s.blocks.y * s.blocks.z);
    std::vector<int> count(s.means.size());
    for (int k = 0; k < f.size().z; ++k)
        for (int j = 0; j < f.size().y; ++j)
            for (int i = 0; i < f.size().x; ++i) {
                const std::size_t block = s.index(i / kBlock, j / kBlock, k / kBlock);
                s.means[block].value += field.irradiance(f.min + glm::ivec3(i, j, k)), ++count[block];
            }
    for (std::size_t b = 0; b < count.size(); ++b) s.means[b].value /= count[b];
    return s;
}

/// Sums over the free blocks, layer by layer.
void sumLayers(const LightField& field, Summary& s) {
    const GridFrame& f = field.frame();
    s.layers.assign(static_cast<std::size_t>(f.size().z), {0, 0});
    for (int k = 0; k < f.size().z; ++k)
        for (int j = 0; j < f.size().y; ++j)
            for (int i = 0; i < f.size().x; ++i) {
                if (s.at(i / kBlock, j / kBlock, k / kBlock).touch != Touch::Free) continue;
                auto& [irradiance, down] = s.layers[static_cast<std::size_t>(k)];
                irradiance += field.irradiance(f.min + glm::ivec3(i, j, k));
                if (field.channels().flux) down -= field.flux(f.min + glm::ivec3(i, j, k)).z;
            }
}

/// Blocks at the water's surface open tubes; blocks near something that blocks, or in which light differs without it,
/// see them end.
void classify(const Scene& scene, const Summary& unblocked, const GridFrame& f, Summary& s) {
    double brightest = 0;
    for (const BlockMean& m : unblocked.means) brightest = std::max(brightest, m.value);
    for (int z = 0; z < s.blocks.z; ++z)
        for (int y = 0; y < s.blocks.y; ++y)
            for (int x = 0; x < s.blocks.x; ++x) {
                BlockMean& mean = s.means[s.index(x, y, z)];
                const double open = unblocked.at(x, y, z).value;
                if (std::fabs(mean.value - open) > 1e-3 * open + 1e-6 * brightest) mean.touch = Touch::Ends;
                const glm::dvec3 low = f.worldFromIndex(glm::dvec3(f.min + kBlock * glm::ivec3(x, y, z)) - 0.5),
                                 middle = f.worldFromIndex(
                                     glm::dvec3(f.min + kBlock * glm::ivec3(x, y, z) + kBlock / 2) - 0.5);
                const double voxel = f.worldFromIndex()[0][0], reach = 3 * voxel, height = f.worldFromIndex()[2][2];
                for (const Object& object : scene.objects)
                    if (const auto* plane = std::get_if<Plane>(&object.shape)) {
                        const glm::dvec3 n = glm::abs(plane->normal);
                        const double half = kBlock / 2.0 * (voxel * (n.x + n.y) + height * n.z);
                        if (std::fabs(glm::dot(plane->normal, middle - plane->point)) < half + reach)
                            mean.touch = Touch::Ends;
                    }
                for (const Surface& surface : scene.surfaces) {
                    const auto [bottom, top] = surfaceHeights(surface);
                    if (low.z < top + height && low.z + kBlock * height > bottom - height) mean.touch = Touch::Opens;
                }
            }
}

// --- The scenes.

struct PinnedScene {
    std::string name, method;
    std::function<Scene()> scene;
    bool caustic = false;  ///< the `caustic` grid instead of the light
};

Scene example(const std::string& path, int frame = 0) {
    Monitor monitor;
    Scene scene = loadScene(PHOTIC_SOURCE_DIR "/examples/" + path, frame, monitor);
    const glm::dvec3 size = scene.domain.max - scene.domain.min;
    scene.domain.voxel_size = std::max({size.x, size.y, size.z}) / kLongest;
    return scene;
}

Scene parsed(const std::string& text) {
    Monitor monitor;
    return parseScene(text, "pinned.toml", PHOTIC_SOURCE_DIR "/tests/data", 0, monitor);
}

/// A basin of two waves; `extra` are further tables or keys of the last one.
std::string basin(const std::string& event, const std::string& extra, const std::string& domain = "") {
    return fmt::format(R"(photic = 1
[domain]
min = [-0.5, -0.5, {}]
max = [0.5, 0.5, {}]
voxel_size = 0.020833333333333333
{}
[[light]]
type = "sun"
direction = [0.3, 0.2, -0.9]
irradiance = 100.0
angular_diameter = 0
[[surface]]
name = "water"
event = "{}"
size = [3.0, 3.0]
outside = "none"
waves = [
  {{ amplitude = 0.02, wavelength = 0.8, direction = 20, phase = 0.4 }},
  {{ amplitude = 0.015, wavelength = 0.5, direction = 95, phase = 1.7 }},
]
{}
)",
                       event == "refract" ? -0.75 : -0.5, event == "refract" ? 0.0625 : 0.5, domain, event, extra);
}

/// The basin's waves as a mesh of 40 x 40 squares.
Scene meshWater(SurfaceEvent event) {
    Scene scene = parsed(basin("both", ""));
    auto mesh = std::make_shared<TriangleMesh>();
    constexpr int n = 40;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
            const glm::dvec2 p(-0.6 + 1.2 * i / n, -0.6 + 1.2 * j / n);
            const SurfacePoint at = scene.surfaces[0].height_field->at(p);
            mesh->positions.push_back(at.position), mesh->normals.push_back(glm::normalize(at.normal));
        }
    const auto vertex = [](int i, int j) { return static_cast<std::uint32_t>(j * (n + 1) + i); };
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            mesh->triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
            mesh->triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
        }
    scene.surfaces[0].height_field = nullptr, scene.surfaces[0].mesh = mesh, scene.surfaces[0].event = event;
    return scene;
}

std::vector<PinnedScene> pinnedScenes() {
    const std::string secondSun =
        "[[light]]\ntype = \"sun\"\ndirection = [-0.2, 0.4, -0.9]\nirradiance = [10, 40, 60]\nangular_diameter = 0.5\n";
    return {
        {"pool", "beams", [] { return example("pool/pool.toml"); }},
        {"pool_animated_3", "beams", [] { return example("pool/animated.toml", 3); }},
        {"pool_stratified", "eikonal", [] { return example("pool/stratified.toml"); }},
        {"ocean_64", "beams", [] { return example("ocean/ocean_64.toml"); }},
        {"ocean_128", "beams", [] { return example("ocean/ocean_128.toml"); }},
        {"blender_ocean", "beams", [] { return example("ocean/blender_ocean.toml"); }},
        {"buried_in_sand", "beams", [] { return example("buried_in_sand/buried_in_sand.toml"); }},
        {"waves", "beams", [] { return parsed(basin("refract", "")); }},
        {"mirror", "beams", [] { return parsed(basin("reflect", "")); }},
        {"both", "beams", [] { return parsed(basin("both", "")); }},
        {"mesh_water", "beams", [] { return meshWater(SurfaceEvent::Refract); }},
        {"mesh_mirror", "beams", [] { return meshWater(SurfaceEvent::Reflect); }},
        {"coloured_medium", "beams",
         [] { return parsed(basin("refract", "[medium]\nabsorption = [1.0, 0.3, 0.1]\nscattering = 0.2\n")); }},
        {"two_suns", "beams", [=] { return parsed(basin("refract", secondSun)); }},
        {"leaning", "beams", [] { return parsed(basin("refract", "", "shear = \"light\"\nlayer_height = 0.0625\n")); }},
        {"four_planes", "beams", [] { return parsed(basin("refract", "[bake]\nquadrature = 4\n")); }},
        {"caustic", "beams",
         [] { return parsed(basin("refract", "[bake]\ngrids = [\"irradiance\", \"direction\", \"caustic\"]\n")); },
         true},
        {"receivers", "beams",
         [] {
             return parsed(
                 basin("refract", "[[object]]\nplane = { point = [0, 0, -0.6] }\n[bake]\nwhere = \"receivers\"\n"));
         }},
        {"flat", "beams",
         [] {
             Scene scene = parsed(basin("refract", ""));
             scene.surfaces[0].height_field = makeFlatField(0);
             return scene;
         }},
    };
}

LightField bakePinned(const PinnedScene& pin, Scene scene) {
    scene.bake.prefilter = false;
    LightVolume volume = withoutLobes(std::move(bakeScene(std::move(scene), pin.method).result.volume));
    return pin.caustic ? std::move(volume.scalars.at("caustic")) : std::move(volume.field);
}

// --- The file: for each scene its hash (of one instruction set; told, not held to), its blocks and its layers.

using Pins = std::map<std::string, Summary>;

std::string written(const std::string& name, const Summary& s) {
    std::string text =
        fmt::format("scene {} hash {} blocks {} {} {}\n", name, s.hash, s.blocks.x, s.blocks.y, s.blocks.z);
    for (int z = 0; z < s.blocks.z; ++z) {
        for (int y = 0; y < s.blocks.y; ++y) {
            for (int x = 0; x < s.blocks.x; ++x)
                text += fmt::format("{}{} {:.5g}", x > 0 ? "  " : "", static_cast<char>(s.at(x, y, z).touch),
                                    s.at(x, y, z).value);
            text += "\n";
        }
    }
    text += fmt::format("layers {}\n", s.layers.size());
    for (const auto& [irradiance, down] : s.layers) text += fmt::format("{:.7g} {:.7g}\n", irradiance, down);
    return text;
}

Pins readPins() {
    std::ifstream in(kPins);
    Pins pins;
    std::string word, name;
    while (in >> word) {
        Summary s;
        in >> name >> word >> s.hash >> word >> s.blocks.x >> s.blocks.y >> s.blocks.z;
        s.means.resize(static_cast<std::size_t>(s.blocks.x) * s.blocks.y * s.blocks.z);
        for (BlockMean& m : s.means) {
            char touch = 0;
            in >> touch >> m.value;
            m.touch = static_cast<Touch>(touch);
        }
        std::size_t layers = 0;
        in >> word >> layers;
        s.layers.resize(layers);
        for (auto& [irradiance, down] : s.layers) in >> irradiance >> down;
        pins[name] = std::move(s);
    }
    return pins;
}

void compare(const std::string& name, const LightField& field, const Summary& pin) {
    Summary now = summarise(field);
    ASSERT_EQ(now.blocks, pin.blocks) << name;
    double brightest = 0, worst = 0, worst_elsewhere = 0;
    int free = 0;
    for (const BlockMean& m : pin.means) brightest = std::max(brightest, m.value);
    for (std::size_t b = 0; b < pin.means.size(); ++b) {
        now.means[b].touch = pin.means[b].touch;
        // Values are kept to five digits.
        const double off =
            std::fabs(now.means[b].value - pin.means[b].value) / std::max(pin.means[b].value, 1e-3 * brightest);
        if (pin.means[b].touch != Touch::Free) {
            worst_elsewhere = std::max(worst_elsewhere, off);
            continue;
        }
        ++free, worst = std::max(worst, off);
        EXPECT_LT(off, kBlockTolerance) << name << " block " << b << ": " << now.means[b].value << ", was "
                                        << pin.means[b].value;
    }
    sumLayers(field, now);
    ASSERT_EQ(now.layers.size(), pin.layers.size()) << name;
    double most = 0, worst_layer = 0;
    for (const auto& [irradiance, down] : pin.layers) most = std::max(most, irradiance);
    for (std::size_t k = 0; k < pin.layers.size(); ++k) {
        const double off = std::max(std::fabs(now.layers[k].first - pin.layers[k].first),
                                    std::fabs(now.layers[k].second - pin.layers[k].second)) /
                           most;
        if (most == 0) continue;
        worst_layer = std::max(worst_layer, off);
        EXPECT_LT(off, kLayerTolerance) << name << " layer " << k;
    }
    fmt::print("  {:16} {}: {} free blocks off by at most {:.1e}, their layers {:.1e}; {} others by {:.1e}\n", name,
               now.hash == pin.hash ? "same bits " : "other bits", free, worst, worst_layer, pin.means.size() - free,
               worst_elsewhere);
}

TEST(PinnedVolumes, AreAsTheyWere) {
    const bool write = std::getenv("PHOTIC_WRITE_PINS") != nullptr;
    const Pins pins = readPins();
    std::string text;
    for (const PinnedScene& pin : pinnedScenes()) {
        const Scene scene = pin.scene();
        const LightField field = bakePinned(pin, scene);
        if (!write) {
            ASSERT_TRUE(pins.count(pin.name)) << pin.name << " is not in " << kPins;
            compare(pin.name, field, pins.at(pin.name));
            continue;
        }
        Scene unblocked = scene;
        for (Object& object : unblocked.objects) object.role = Role::Movable;
        Summary s = summarise(field);
        classify(scene, summarise(bakePinned(pin, unblocked)), field.frame(), s);
        sumLayers(field, s);
        text += written(pin.name, s);
    }
    if (write) {
        std::ofstream(kPins) << text;
        GTEST_SKIP() << "wrote " << kPins;
    }
    EXPECT_EQ(pins.size(), pinnedScenes().size());
}

}  // namespace
}  // namespace photic
