// SPDX-License-Identifier: Apache-2.0
// Water that nobody baked: times beside the volume's, and how near its light comes to the truth.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>

#include "bake/file/nvdb.h"
#include "runtime/src/live_water_impl.h"
#include "tests/benchmark/runtime/or_throw.h"
#include "tests/benchmark/runtime/rows.h"
#include "tests/runtime/baked_scene.h"
#include "tests/runtime/water_model.h"
#include "tests/support/pool3.h"

namespace photic::benchmark {

using namespace runtime;

namespace {

LiveWater pool3(const RuntimeStage& stage, int side) {
    LiveWater water = orThrow(LiveWater::create(stage.context));
    check(water.setLight(test::pool3Light()));
    check(water.setHeights(test::pool3Water(side).water));
    return water;
}

/// As in the paper; planes so near that a pixel has all its 32 samples.
LookupOptions paperLookup() {
    LookupOptions paper;
    paper.axes = LookupAxes::One;
    paper.projection = LookupProjection::TriPlanar;
    paper.gain_mode = LookupGain::Fixed;
    paper.reflected = 0.3F;
    paper.plane_distance = 0.02F;
    return paper;
}

/// Means over 2 x 2 points of each pixel of the floor's map.
std::vector<double> overPixels(const std::vector<double>& fine, int size) {
    std::vector<double> out(static_cast<std::size_t>(size) * static_cast<std::size_t>(size), 0.0);
    for (int j = 0; j < 2 * size; ++j) {
        for (int i = 0; i < 2 * size; ++i) {
            out[static_cast<std::size_t>(j / 2 * size + i / 2)] += fine[static_cast<std::size_t>(j * 2 * size + i)] / 4;
        }
    }
    return out;
}

}  // namespace

void addWaterPasses(const RuntimeStage& stage, Table& passes) {
    const int side = stage.effort.samples > 100000 ? 256 : 32;
    LiveWater water = pool3(stage, side);
    ReceiverPass receivers = orThrow(ReceiverPass::create(stage.context));
    const auto row = [&](const std::string& name, const std::function<void()>& work) {
        passes.add({name, fmt::format("{:.3f}", leastMilliseconds(stage, work))});
    };
    const auto& g = stage.view.surfaces;
    const auto& target = stage.view.target;
    check(water.setLookup(paperLookup()));
    const auto lookUp = [&] { check(receivers.drawLit(g, target, {LightSource::Lookup, {}, &water})); };
    row("receivers, the paper's look-up (tri-planar, with the reflected ray)", lookUp);
    for (const int samples : {4, 8, 16, 32}) {
        LookupOptions options = paperLookup();
        options.plane_samples = samples;
        check(water.setLookup(options));
        row(fmt::format("god rays, the paper's, {} samples", samples), [&] { check(water.drawGodRays(g, target)); });
    }
    check(water.setLookup({}));
    row("receivers, look-up along the light, both axes", lookUp);
    CausticMapOptions map;
    map.bottom = -1, map.layers = 8, map.resolution = side * 2;
    row(fmt::format("caustic map of {0} x {0} cells, 8 layers of {1}, drawn", side, map.resolution),
        [&] { check(water.updateCausticMap(map)); });
    row("receivers, caustic map", [&] { check(receivers.drawLit(g, target, {LightSource::CausticMap, {}, &water})); });
    WarpedVolumesOptions volumes;
    volumes.bottom = -1.1F;
    const glm::mat4 clip(glm::inverse(glm::dmat4(glm::make_mat4(g.world_from_clip))));
    for (const auto& [view, cells] : {std::pair{&stage.view, 64}, {&stage.square, 64}, {&stage.square, 128}}) {
        volumes.step = std::max(1, side / cells);
        row(fmt::format("receivers, warped volumes of {0} x {0} cells, {1} x {2} pixels", side / volumes.step,
                        view->target.width, view->target.height),
            [&] { check(water.drawWarpedVolumes(view->surfaces, glm::value_ptr(clip), view->target, volumes)); });
    }
}

Table sideBySide(const RuntimeStage& stage) {
    const int rounds = 3 * stage.effort.repeats;
    Table table;
    table.title = "Side by side";
    table.note = fmt::format("Least of {} turns [ms]; each turn runs a row's two passes one after the other.", rounds);
    table.head = {"baked", "[ms]", "the paper's, no bake", "[ms]", "baked / the paper's"};
    LiveWater water = pool3(stage, stage.effort.samples > 100000 ? 256 : 32);
    check(water.setLookup(paperLookup()));
    ReceiverPass receivers = orThrow(ReceiverPass::create(stage.context));
    MediumPass media = orThrow(MediumPass::create(stage.context));
    MediumOptions medium;
    medium.scattering[0] = medium.scattering[1] = medium.scattering[2] = 0.1F;
    medium.anisotropy = 0.8F;
    medium.surface[2] = 1, medium.surface[3] = 0;
    const auto& g = stage.view.surfaces;
    const auto& target = stage.view.target;
    const auto row = [&](const std::string& ours, const std::function<void()>& a, const std::string& theirs,
                         const std::function<void()>& b) {
        double least_a = 1e30, least_b = 1e30;
        for (int n = 0; n < 1 + rounds; ++n) {
            const double ms_a = milliseconds(stage, a), ms_b = milliseconds(stage, b);
            if (n > 0) least_a = std::min(least_a, ms_a), least_b = std::min(least_b, ms_b);
        }
        table.add({ours, fmt::format("{:.2f}", least_a), theirs, fmt::format("{:.2f}", least_b),
                   fmt::format("{:.2f}", least_a / least_b)});
    };
    for (const Layout layout : {Layout::Dense, Layout::Atlas}) {
        UploadOptions upload;
        upload.layout = layout;
        GpuVolume volume = orThrow(GpuVolume::upload(stage.context, stage.volume, upload));
        const std::string name = layout == Layout::Dense ? "dense" : "atlas";
        row(
            "receivers, " + name, [&] { check(receivers.draw(g, target, {{&volume}})); }, "look-up, tri-planar",
            [&] {
                check(receivers.drawLit(g, target, {LightSource::Lookup, {}, &water}));
            });
        row(
            "media, 32 steps, " + name, [&] { check(media.draw(g, target, {{&volume}}, medium)); },
            "god rays, 32 samples", [&] { check(water.drawGodRays(g, target)); });
    }
    return table;
}

Table floorAccuracy(const RuntimeStage& stage) {
    Table table;
    table.title = "The floor of pool3 against its exact map";
    table.note = "Pixels of 3.9 mm under a point sun (tests/data). The look-up at the tau that suits it best.";
    table.head = {"light", "correlation", "energy", "relative L1"};
    const auto exact = truth::pool3::exactFloor();
    const bool quick = stage.effort.samples <= 100000;
    const int size = exact.size, fine = 2 * size, side = quick ? 64 : 512;
    const auto add = [&](const std::string& name, const std::vector<double>& pixels) {
        const auto like = test::likeness(pixels, exact.values);
        table.add({name, fmt::format("{:.3f}", like.correlation), fmt::format("{:.3f}", like.energy),
                   fmt::format("{:.3f}", like.relative_l1)});
        return like;
    };

    truth::pool3::SceneText text;
    text.voxel_size = quick ? 1.0 / 16 : 1.0 / 256;
    text.z_min = truth::pool3::kFloor - 2 * text.voxel_size;
    text.z_max = 0.1;
    text.bake = "where = \"receivers\"\nprefilter = true";
    text.objects = "[[object]]\nname = \"floor\"\nplane = { point = [0, 0, -1.5], normal = [0, 0, 1] }\n";
    const test::BakedScene baked = test::bake(truth::pool3::sceneToml(text));
    const Volume volume = test::asGameVolume(baked.volume, NvdbPrecision::Half);
    std::vector<double> values(static_cast<std::size_t>(fine) * static_cast<std::size_t>(fine));
    for (int j = 0; j < fine; ++j) {
        for (int i = 0; i < fine; ++i) {
            values[static_cast<std::size_t>(j * fine + i)] =
                volume.irradiance({(i + 0.5) / size - 1, (j + 0.5) / size - 1, truth::pool3::kFloor}, {0, 0, 1}).x;
        }
    }
    add(fmt::format("baked, voxels of {:.1f} mm", 1000 * text.voxel_size), overPixels(values, size));

    LiveWater water = pool3(stage, side);
    const auto onFloor = [&](const char* include, const char* function,
                             const std::function<void(const Uniforms&)>& bind) {
        const auto pixels = test::evaluate(stage.context.gl(), include,
                                           "vec4(" + std::string(function) + "(" +
                                               test::floorPoint(truth::pool3::kFloor, fine) + ", vec3(0, 0, 1)), 0)",
                                           fine, fine, bind);
        return overPixels(test::channel(pixels, 0), size);
    };
    CausticMapOptions map;
    map.bottom = truth::pool3::kFloor, map.layers = 1, map.resolution = 4 * side;
    check(water.updateCausticMap(map));
    add(fmt::format("caustic map of {0} x {0} cells", side),
        onFloor("photic_caustic_map.glsl", "photicCausticIrradiance",
                [&](const Uniforms& u) { water.impl().setCausticMap(u, 0); }));
    for (const bool paper : {false, true}) {
        double best = -1;
        std::vector<double> kept;
        float kept_tau = 0;
        for (const float tau : {10.0F, 30.0F, 100.0F, 300.0F, 1000.0F}) {
            LookupOptions options;
            options.tightening = tau, options.tightening_per_metre = 0;
            if (paper) {
                options.axes = LookupAxes::One, options.projection = LookupProjection::TriPlanar;
                options.reflected = 0.3F;
            }
            check(water.setLookup(options));
            const auto pixels = onFloor("photic_water_lookup.glsl", "photicLookupIrradiance",
                                        [&](const Uniforms& u) { water.impl().setLookup(u, 0); });
            const double correlation = test::likeness(pixels, exact.values).correlation;
            if (correlation > best) best = correlation, kept = pixels, kept_tau = tau;
        }
        add(fmt::format("{}, tau {:.0f}", paper ? "the paper's look-up" : "look-up along the light, both axes",
                        kept_tau),
            kept);
    }
    return table;
}

}  // namespace photic::benchmark
