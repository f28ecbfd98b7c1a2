// SPDX-License-Identifier: Apache-2.0
#include "tests/runtime/every_call.h"

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/gtc/type_ptr.hpp>

#include "tests/runtime/bent_fixture.h"
#include "tests/runtime/loaded_volume.h"

namespace photic::test {

using namespace runtime;

namespace {

NvdbSpec sheets(bool coloured) {
    NvdbSpec spec;
    spec.max = {31, 31, 23};
    spec.world_from_index = {0.0625, 0, 0, 0, 0.0625, 0, 0, 0, 0.0625};
    spec.origin_world = {-0.97, -0.97, -1.47};
    spec.values = swirl;
    spec.active = [](int i, int j, int) { return i < 14 || j > 18; };
    spec.coloured = coloured;
    spec.json = R"({"reference_irradiance": 50})";
    return spec;
}

Eye eyeOverPool() {
    Eye eye;
    eye.position = {-1.6, -2.2, 1.2}, eye.target = {0, 0, -0.9};
    eye.width = 40, eye.height = 28;
    return eye;
}

/// What `make` made, or its error.
template <class T, class Use>
Status with(Result<T> made, const Use& use) {
    if (!made) return made.error();
    return use(*made);
}

Status inOrder(std::initializer_list<std::function<Status()>> steps) {
    for (const auto& step : steps) {
        if (const Status done = step(); !done) return done;
    }
    return Done{};
}

}  // namespace

CallInputs::CallInputs()
    : drawing(drawingOf(eyeOverPool(), planes({{{0, 0, -1.4}, {0, 0, 1}}, {{0.93, 0, 0}, {-1, 0, 0}}}))),
      volume(loaded(sheets(false))),
      coloured(loaded(sheets(true))),
      objects(readBack({ball(1.3, 0.4, 0.1, 2, {0, 0, -0.8})})) {
    constexpr int kSide = 24;
    for (int j = 0; j < kSide; ++j)
        for (int i = 0; i < kSide; ++i)
            heights.push_back(static_cast<float>(0.02 * std::sin(0.8 * i) + 0.02 * std::cos(0.6 * j + 0.3 * i)));
    water.heights = heights.data(), water.columns = water.rows = kSide;
    water.corner[0] = water.corner[1] = -1, water.size[0] = water.size[1] = 2;
    light.direction[0] = 0.3F, light.direction[1] = 0.2F, light.direction[2] = -1;
    light.extinction[0] = 0.2F;
    movers = moversIn(volume.metadata());
    movers.sun = {0.3, 0.2, -1};
    movers.shapes = {sphere({0, 0.2, -0.9}, 0.3), box({0.4, -0.4, -1}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.2})};
    for (int n = 0; n < 2; ++n) {
        const auto path = std::filesystem::temp_directory_path() /
                          ("photic_every_call_" + std::to_string(::getpid()) + "_" + std::to_string(n) + ".nvdb");
        const auto bytes = makeNvdb(sheets(n == 1));
        std::ofstream(path, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        frames.push_back(path.string());
    }
    const glm::mat4 clip(eyeOverPool().clipFromWorld());
    clip_from_world.assign(glm::value_ptr(clip), glm::value_ptr(clip) + 16);
}

CallInputs::~CallInputs() {
    for (const std::string& file : frames) std::filesystem::remove(file);
}

std::vector<Call> CallInputs::everyCall() const {
    std::vector<Call> calls;
    const auto add = [&](const std::string& name, auto run) { calls.push_back({name, std::move(run)}); };
    const auto uploaded = [this](const GpuContext& gpu, const Volume& of, const UploadOptions& options,
                                 const auto& use) { return with(GpuVolume::upload(gpu, of, options), use); };
    const auto wet = [this](const GpuContext& gpu, const auto& use) {
        return with(LiveWater::create(gpu), [&](LiveWater& live) {
            return inOrder({[&] { return live.setHeights(water); }, [&] { return live.setLight(light); },
                            [&] { return use(live); }});
        });
    };
    for (const Layout layout : {Layout::Atlas, Layout::Dense, Layout::Buffer}) {
        const std::string of = layout == Layout::Atlas ? "atlas" : layout == Layout::Dense ? "dense" : "buffer";
        UploadOptions options;
        options.layout = layout, options.when_too_large = WhenTooLarge::Refuse;
        add("GpuVolume::upload, " + of, [=, this](const GpuContext& gpu, const DrawnView&) {
            return uploaded(gpu, coloured, options, [](GpuVolume&) -> Status { return Done{}; });
        });
        add("ReceiverPass::draw, " + of, [=, this](const GpuContext& gpu, const DrawnView& view) {
            return uploaded(gpu, coloured, options, [&](GpuVolume& of_light) {
                return with(ReceiverPass::create(gpu),
                            [&](ReceiverPass& pass) { return pass.draw(view.surfaces, view.target, {{&of_light}}); });
            });
        });
    }
    add("GpuUpload::step", [=, this](const GpuContext& gpu, const DrawnView&) {
        return with(GpuUpload::start(gpu, volume, {.when_too_large = WhenTooLarge::Refuse}), [&](GpuUpload& coming) {
            while (!coming.step(20000)) {
            }
            return with(coming.take(), [](GpuVolume&) -> Status { return Done{}; });
        });
    });
    add("GpuSequence::at", [=, this](const GpuContext& gpu, const DrawnView&) -> Status {
        auto files = VolumeSequence::open(frames);
        if (!files) return files.error();
        GpuSequence sequence(gpu, std::move(*files), {.when_too_large = WhenTooLarge::Refuse});
        const auto lit = sequence.at(0.02, WhenLate::Wait);
        if (!lit) return lit.error();
        return Done{};
    });
    const auto receivers = [=, this](const ReceiverOptions& options) {
        return [=, this](const GpuContext& gpu, const DrawnView& view) {
            return uploaded(gpu, volume, {}, [&](GpuVolume& of_light) {
                return with(ReceiverPass::create(gpu), [&](ReceiverPass& pass) {
                    return pass.draw(view.surfaces, view.target, {{&of_light}}, options);
                });
            });
        };
    };
    ReceiverOptions shadowed;
    shadowed.shadows.movers = &movers;
    add("ReceiverPass::draw, movers", receivers(shadowed));
    for (const bool halved : {false, true}) {
        MediumOptions medium;
        medium.scattering[0] = medium.scattering[1] = medium.scattering[2] = 0.3F;
        medium.absorption[0] = 0.1F, medium.steps = 8;
        medium.resolution = halved ? MediumResolution::Halved : MediumResolution::Full;
        if (!halved) medium.shadows.movers = &movers;
        add(halved ? "MediumPass::draw, halved" : "MediumPass::draw, movers",
            [=, this](const GpuContext& gpu, const DrawnView& view) {
                return uploaded(gpu, volume, {}, [&](GpuVolume& of_light) {
                    return with(MediumPass::create(gpu), [&](MediumPass& pass) {
                        return pass.draw(view.surfaces, view.target, {{&of_light}}, medium);
                    });
                });
            });
    }
    const CausticMapOptions map{.bottom = -1.4F, .layers = 3, .resolution = 32};
    const auto lit = [=](LightSource source) {
        return [=](const GpuContext& gpu, const DrawnView& view) {
            return wet(gpu, [&](LiveWater& live) {
                return with(ReceiverPass::create(gpu), [&](ReceiverPass& pass) {
                    return inOrder({[&] {
                                        return source == LightSource::CausticMap ? live.updateCausticMap(map)
                                                                                 : Status(Done{});
                                    },
                                    [&] {
                                        return pass.drawLit(view.surfaces, view.target, {source, {}, &live});
                                    }});
                });
            });
        };
    };
    add("ReceiverPass::drawLit, look-up", lit(LightSource::Lookup));
    add("ReceiverPass::drawLit, caustic map", lit(LightSource::CausticMap));
    add("LiveWater::drawGodRays", [=](const GpuContext& gpu, const DrawnView& view) {
        return wet(gpu, [&](LiveWater& live) { return live.drawGodRays(view.surfaces, view.target); });
    });
    add("LiveWater::drawWarpedVolumes", [=, this](const GpuContext& gpu, const DrawnView& view) {
        WarpedVolumesOptions options;
        options.bottom = -1.5F, options.step = 2;
        for (float& s : options.scattering) s = 0.2F;
        return wet(gpu, [&](LiveWater& live) {
            return live.drawWarpedVolumes(view.surfaces, clip_from_world.data(), view.target, options);
        });
    });
    add("LiveBake::update", [=](const GpuContext& gpu, const DrawnView& view) {
        LiveBakeOptions options;
        options.min = {-1, -1, -1.5F}, options.max = {1, 1, 0.1F}, options.voxels = {20, 20, 16};
        options.angular_diameter_deg = 3;
        return wet(gpu, [&](LiveWater& live) {
            return with(LiveBake::create(gpu, options), [&](LiveBake& bake) {
                return with(ReceiverPass::create(gpu), [&](ReceiverPass& pass) {
                    return inOrder({[&] { return bake.update(live); },
                                    [&] { return pass.draw(view.surfaces, view.target, {{&bake.volume()}}); }});
                });
            });
        });
    });
    add("BentRayPass::draw", [=, this](const GpuContext& gpu, const DrawnView& view) {
        return uploaded(gpu, volume, {}, [&](GpuVolume& of_light) {
            return with(GpuIndexVolumes::upload(gpu, objects), [&](GpuIndexVolumes& bodies) {
                return with(BentRayPass::create(gpu), [&](BentRayPass& pass) {
                    Surroundings around;
                    around.colour[0] = 0.5F;
                    return pass.draw(view.surfaces, view.target, bodies, {{}}, around, {{&of_light}});
                });
            });
        });
    });
    return calls;
}

}  // namespace photic::test
