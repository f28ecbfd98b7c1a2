// SPDX-License-Identifier: Apache-2.0
#include "tests/stability/random_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>

#include "tests/support/blocked_light.h"

namespace photic::stability {
namespace {

using truth::Dice;

bool chance(Dice& dice, double probability) { return dice.uniform() < probability; }

glm::dvec3 drawIrradiance(Dice& dice) {
    const glm::dvec3 grey(dice.logBetween(1e-3, 1e4));
    return chance(dice, 0.25) ? grey * glm::dvec3(dice.uniform(), dice.uniform(), 1) : grey;
}

SceneModel::Lamp drawSun(Dice& dice) {
    SceneModel::Lamp sun;
    // One in seven grazes the water.
    const double zenith = chance(dice, 0.15) ? dice.between(1.4, 1.57) : dice.between(0, 1.3);
    const double azimuth = dice.between(0, 2 * std::numbers::pi);
    sun.direction = {std::sin(zenith) * std::cos(azimuth), std::sin(zenith) * std::sin(azimuth), -std::cos(zenith)};
    if (chance(dice, 0.1)) sun.direction = {0, 0, -1};
    sun.irradiance = drawIrradiance(dice);
    if (chance(dice, 0.3)) sun.disc = dice.logBetween(0.01, 4);
    return sun;
}

SceneModel::Lamp drawLamp(Dice& dice) {
    SceneModel::Lamp lamp = drawSun(dice);
    lamp.kind = static_cast<SceneModel::LampKind>(1 + dice.below(3));
    // It shines on the box from where a sun would, near or far, and now and then from within.
    const double distance = chance(dice, 0.1) ? dice.between(0, 0.5) : dice.logBetween(0.7, 30);
    lamp.position = glm::dvec3(0, 0, -0.2) - distance * lamp.direction;
    lamp.angle = dice.logBetween(2, 180), lamp.blend = chance(dice, 0.2) ? 0 : dice.uniform();
    lamp.size = dice.logBetween(1e-3, 1);
    return lamp;
}

SceneModel::Glass drawGlass(Dice& dice, double voxel) {
    SceneModel::Glass glass;
    glass.shape = static_cast<SceneModel::GlassShape>(dice.below(4));
    glass.seed = static_cast<std::uint64_t>(dice.below(1000));
    for (int a = 0; a < 3; ++a) glass.center[a] = dice.between(-0.3, 0.3);
    glass.center.z -= 0.25;
    glass.size = glm::dvec3(dice.logBetween(2 * voxel, 0.6));
    if (chance(dice, 0.1)) glass.size = glm::dvec3(dice.logBetween(0.1 * voxel, 2 * voxel));
    if (glass.shape == SceneModel::GlassShape::Box) {
        for (int a = 0; a < 3; ++a) glass.size[a] *= dice.between(0.1, 1);
        if (chance(dice, 0.2)) glass.center = glm::dvec3(0, 0, -0.25), glass.size = glm::dvec3(0.25);
    }
    if (chance(dice, 0.7))
        for (int a = 0; a < 3; ++a) glass.rotation[a] = dice.between(-180, 180);
    glass.ior = chance(dice, 0.15) ? dice.logBetween(0.5, 4) : dice.between(1.05, 1.9);
    if (chance(dice, 0.05)) glass.ior = 1;
    const char* const events[] = {"both", "both", "both", "refract", "reflect", "mirror"};
    glass.event = events[dice.below(6)];
    if (chance(dice, 0.3))
        glass.absorption = dice.logBetween(0.01, 100) * glm::dvec3(dice.uniform(), dice.uniform(), dice.uniform());
    glass.priority = dice.below(3);
    // Smoothed over its edges a box is none.
    glass.facets = glass.shape == SceneModel::GlassShape::Box || chance(dice, 0.3);
    // A pane is an open sheet: a mirror, or thin.
    if (glass.shape == SceneModel::GlassShape::Pane) {
        glass.thin = glass.event != "mirror" && chance(dice, 0.8);
        glass.inverted = chance(dice, 0.3);
    }
    return glass;
}

void drawIndex(SceneModel& scene, Dice& dice) {
    scene.index = static_cast<SceneModel::Index>(1 + dice.below(4));
    scene.water = SceneModel::Water::None, scene.event = "refract";
    scene.things.clear(), scene.glasses.clear();
    scene.index_radius = dice.between(0.1, 0.4), scene.index_strength = dice.logBetween(0.01, 0.5);
    scene.index_center = {dice.between(-0.1, 0.1), dice.between(-0.1, 0.1), dice.between(-0.3, -0.2)};
    scene.method = chance(dice, 0.8) ? "wavefront" : "photons";
    scene.high.z = std::max(scene.high.z, 0.25), scene.low.z = std::min(scene.low.z, -0.75);
}

void drawWater(SceneModel& scene, Dice& dice) {
    const double kind = dice.uniform();
    scene.water = kind < 0.15   ? SceneModel::Water::Flat
                  : kind < 0.65 ? SceneModel::Water::Waves
                  : kind < 0.75 ? SceneModel::Water::Bump
                  : kind < 0.85 ? SceneModel::Water::Sea
                                : SceneModel::Water::Mesh;
    const int count = 1 + dice.below(4);
    for (int i = 0; i < count; ++i) {
        const double wavelength = dice.logBetween(0.05, 10);
        const double steep = chance(dice, 0.1) ? dice.between(0.3, 1) : dice.logBetween(1e-4, 0.3);
        scene.waves.push_back({steep * wavelength / (2 * std::numbers::pi * count), wavelength, dice.between(0, 360),
                               dice.between(0, 6.28)});
    }
    scene.height = dice.logBetween(1e-4, 0.08);
    scene.patch = dice.logBetween(0.3, 6);
    const double event = dice.uniform();
    scene.event = event < 0.6 ? "refract" : event < 0.8 ? "reflect" : "both";
    const char* const outsides[] = {"flat", "periodic", "none"};
    scene.outside = outsides[dice.below(3)];
    // Waves that turn flat at the patch's edge end in a cliff, which photons launched from above do not see.
    const bool rough = scene.water == SceneModel::Water::Waves || scene.water == SceneModel::Water::Sea;
    if (rough && scene.outside == "flat") scene.outside = "periodic";
    if (chance(dice, 0.2)) scene.ior_below = dice.between(0.7, 2.5);
    if (chance(dice, 0.1)) scene.ior_above = dice.between(0.7, 2.5);
    if (chance(dice, 0.1)) scene.ior_below = scene.ior_above;
    if (chance(dice, 0.4)) {
        scene.absorption = glm::dvec3(dice.logBetween(1e-3, 100));
        if (chance(dice, 0.5)) scene.absorption *= glm::dvec3(dice.uniform(), dice.uniform(), dice.uniform());
        if (chance(dice, 0.5)) scene.scattering = glm::dvec3(dice.logBetween(1e-3, 10));
    }
}

SceneModel::Thing drawThing(const SceneModel& scene, Dice& dice) {
    SceneModel::Thing thing;
    thing.shape = static_cast<SceneModel::Shape>(dice.below(4));
    thing.seed = static_cast<std::uint64_t>(dice.below(1000));
    const char* const roles[] = {"receiver", "receiver", "blocker", "movable"};
    thing.role = roles[dice.below(4)];
    for (int a = 0; a < 3; ++a) thing.center[a] = dice.between(scene.low[a] - 0.1, scene.high[a] + 0.1);
    if (chance(dice, 0.7)) thing.center.z = dice.between(scene.low.z, -0.1);
    if (thing.shape == SceneModel::Shape::Plane) {
        thing.size = {0, 0, 1};
        if (chance(dice, 0.4)) thing.size = {dice.between(-1, 1), dice.between(-1, 1), dice.between(-1, 1)};
        if (chance(dice, 0.2)) thing.size = {1, 0, 0};
        return thing;
    }
    // From far smaller than a voxel to larger than the box; thin in one way, or coplanar with water or box.
    thing.size = glm::dvec3(dice.logBetween(0.02 / scene.voxels, 1.5));
    if (thing.shape == SceneModel::Shape::Box) {
        for (int a = 0; a < 3; ++a) thing.size[a] *= dice.between(0.3, 1);
        if (chance(dice, 0.3)) thing.size[dice.below(3)] = dice.logBetween(1e-3, 1) / scene.voxels;
        if (chance(dice, 0.15)) thing.center.z = -0.5 * thing.size.z;
        if (chance(dice, 0.15)) thing.center.z = scene.low.z + 0.5 * thing.size.z;
    }
    return thing;
}

std::string methodOptions(const std::string& method, Dice& dice) {
    if (method == "photons")
        return fmt::format("count = {}\nsampling = \"{}\"\n", 1 << (12 + dice.below(5)),
                           chance(dice, 0.3) ? "random" : "quasi");
    if (method != "beams") return "";
    std::string text = "disc_samples = 8\n";
    if (chance(dice, 0.15))
        text += fmt::format("mesh = {}\n", 1 + dice.below(200));
    else if (chance(dice, 0.15))
        text += fmt::format("spacing = {:.3f}\n", dice.logBetween(0.25, 8));
    if (chance(dice, 0.1)) text += "kernel = \"scalar\"\n";
    const char* const discs[] = {"auto", "off", "blur", "sample"};
    if (chance(dice, 0.3)) text += fmt::format("disc = \"{}\"\n", discs[dice.below(4)]);
    return text;
}

}  // namespace

SceneModel randomScene(std::uint64_t seed) {
    Dice dice(seed * 2 + 1);
    SceneModel scene;
    scene.seed = seed;
    const double method = dice.uniform();
    scene.method = method < 0.7 ? "beams" : method < 0.88 ? "photons" : method < 0.98 ? "eikonal" : "wave";
    scene.voxels = 10 + dice.below(22);
    scene.low.z = -dice.between(0.2, 1.2), scene.high.z = dice.between(-0.05, 0.6);
    const int lamps = chance(dice, 0.2) ? 2 : 1;
    const bool traced = scene.method == "beams" || scene.method == "photons";
    for (int i = 0; i < lamps; ++i)
        scene.lamps.push_back(traced && chance(dice, 0.25) ? drawLamp(dice) : drawSun(dice));
    drawWater(scene, dice);
    const int things = dice.below(4);
    for (int i = 0; i < things; ++i) scene.things.push_back(drawThing(scene, dice));
    if (traced && chance(dice, 0.4)) {
        if (chance(dice, 0.75)) scene.water = SceneModel::Water::None;
        const int glasses = 1 + dice.below(3);
        for (int i = 0; i < glasses; ++i) scene.glasses.push_back(drawGlass(dice, 1.0 / scene.voxels));
    } else if (traced && chance(dice, 0.12)) {
        drawIndex(scene, dice);
    }
    scene.leaning = chance(dice, 0.12);
    if (chance(dice, 0.2)) scene.scale = dice.logBetween(1e-6, 1e6);
    if (chance(dice, 0.2)) {
        const double far = dice.logBetween(10, 1e7);
        for (int a = 0; a < 3; ++a) scene.shift[a] = static_cast<int>(far * dice.between(-1, 1));
    }
    const bool receives = std::any_of(scene.things.begin(), scene.things.end(),
                                      [](const SceneModel::Thing& thing) { return thing.role != "blocker"; });
    if (chance(dice, 0.25) && receives) scene.where = "receivers";
    const int planes[] = {1, 1, 1, 2, 4};
    scene.quadrature = planes[dice.below(5)];
    if (chance(dice, 0.2)) scene.tolerance = dice.logBetween(0.05, 2);
    scene.caustic = scene.method == "beams" && chance(dice, 0.1);
    scene.options = methodOptions(scene.method, dice);
    if (scene.method == "eikonal" || scene.method == "wave") scene.lamps.resize(1), scene.lamps[0].disc = 0;
    return scene;
}

std::vector<SceneModel> simpler(const SceneModel& scene) {
    std::vector<SceneModel> steps;
    const auto step = [&](auto change) {
        SceneModel next = scene;
        change(next);
        steps.push_back(std::move(next));
    };
    if (!scene.things.empty()) step([](SceneModel& s) { s.things.clear(), s.where = "everywhere"; });
    for (std::size_t i = 0; i < scene.things.size() && scene.things.size() > 1; ++i)
        step([&](SceneModel& s) { s.things.erase(s.things.begin() + static_cast<std::ptrdiff_t>(i)); });
    for (std::size_t i = 0; i < scene.lamps.size() && scene.lamps.size() > 1; ++i)
        step([&](SceneModel& s) { s.lamps.erase(s.lamps.begin() + static_cast<std::ptrdiff_t>(i)); });
    for (std::size_t i = 0; i < scene.glasses.size() && scene.glasses.size() > 1; ++i)
        step([&](SceneModel& s) { s.glasses.erase(s.glasses.begin() + static_cast<std::ptrdiff_t>(i)); });
    const bool other = scene.index != SceneModel::Index::None || !scene.glasses.empty();
    if (other && scene.water != SceneModel::Water::None) step([](SceneModel& s) { s.water = SceneModel::Water::None; });
    if (!other && scene.water != SceneModel::Water::Flat)
        step([](SceneModel& s) { s.water = SceneModel::Water::Flat; });
    for (std::size_t i = 0; i < scene.waves.size() && scene.waves.size() > 1; ++i)
        step([&](SceneModel& s) { s.waves.erase(s.waves.begin() + static_cast<std::ptrdiff_t>(i)); });
    const SceneModel plain;
    if (scene.scale != 1) step([](SceneModel& s) { s.scale = 1; });
    if (scene.shift != plain.shift) step([](SceneModel& s) { s.shift = glm::ivec3(0); });
    if (scene.leaning) step([](SceneModel& s) { s.leaning = false; });
    if (scene.caustic) step([](SceneModel& s) { s.caustic = false; });
    if (!scene.options.empty() && scene.method == "beams") step([](SceneModel& s) { s.options.clear(); });
    if (scene.event != "refract") step([](SceneModel& s) { s.event = "refract"; });
    if (scene.outside != "flat") step([](SceneModel& s) { s.outside = "flat"; });
    if (scene.absorption != glm::dvec3(0) || scene.scattering != glm::dvec3(0))
        step([](SceneModel& s) { s.absorption = s.scattering = glm::dvec3(0); });
    if (scene.ior_above != plain.ior_above || scene.ior_below != plain.ior_below)
        step([&](SceneModel& s) { s.ior_above = plain.ior_above, s.ior_below = plain.ior_below; });
    if (scene.where != "everywhere") step([](SceneModel& s) { s.where = "everywhere"; });
    if (scene.quadrature != 1) step([](SceneModel& s) { s.quadrature = 1; });
    if (scene.tolerance != plain.tolerance) step([&](SceneModel& s) { s.tolerance = plain.tolerance; });
    for (std::size_t i = 0; i < scene.lamps.size(); ++i) {
        if (scene.lamps[i].kind != SceneModel::LampKind::Sun)
            step([&](SceneModel& s) { s.lamps[i].kind = SceneModel::LampKind::Sun; });
        if (scene.lamps[i].disc > 0) step([&](SceneModel& s) { s.lamps[i].disc = 0; });
        if (scene.lamps[i].irradiance != glm::dvec3(1))
            step([&](SceneModel& s) { s.lamps[i].irradiance = glm::dvec3(1); });
        if (scene.lamps[i].direction.x != 0 || scene.lamps[i].direction.y != 0)
            step([&](SceneModel& s) { s.lamps[i].direction = {0, 0, -1}; });
    }
    for (std::size_t i = 0; i < scene.glasses.size(); ++i) {
        const SceneModel::Glass& glass = scene.glasses[i];
        if (glass.absorption != glm::dvec3(0)) step([&](SceneModel& s) { s.glasses[i].absorption = glm::dvec3(0); });
        if (glass.rotation != glm::dvec3(0)) step([&](SceneModel& s) { s.glasses[i].rotation = glm::dvec3(0); });
        if (glass.event == "both") step([&](SceneModel& s) { s.glasses[i].event = "refract"; });
        if (glass.ior != 1.5 && !glass.thin) step([&](SceneModel& s) { s.glasses[i].ior = 1.5; });
        if (glass.shape != SceneModel::GlassShape::Sphere && !glass.thin)
            step([&](SceneModel& s) { s.glasses[i].shape = SceneModel::GlassShape::Sphere; });
    }
    for (std::size_t i = 0; i < scene.things.size(); ++i)
        if (scene.things[i].role != "receiver") step([&](SceneModel& s) { s.things[i].role = "receiver"; });
    if (scene.voxels > 8) step([](SceneModel& s) { s.voxels = std::max(8, s.voxels / 2); });
    return steps;
}

SceneModel shrink(SceneModel scene, const std::function<bool(const SceneModel&)>& fails, int most_tries) {
    for (bool smaller = true; smaller && most_tries > 0;) {
        smaller = false;
        for (const SceneModel& next : simpler(scene)) {
            if (most_tries-- <= 0) break;
            if (!fails(next)) continue;
            scene = next, smaller = true;
            break;
        }
    }
    return scene;
}

}  // namespace photic::stability
