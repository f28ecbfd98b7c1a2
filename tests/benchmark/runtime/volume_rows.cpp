// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "tests/benchmark/runtime/rows.h"
#include "tests/runtime/compute_sampler.h"

namespace photic::benchmark {

using namespace runtime;

namespace {

template <class T>
T orThrow(Result<T> result) {
    if (!result) throw std::runtime_error(result.error().message);
    return std::move(*result);
}

struct Way {
    const char* name;
    Layout layout;
    Filter filter;
};
constexpr Way kWays[] = {{"atlas, filtered", Layout::Atlas, Filter::Hardware},
                         {"atlas, exact", Layout::Atlas, Filter::Exact},
                         {"dense, filtered", Layout::Dense, Filter::Hardware},
                         {"dense, exact", Layout::Dense, Filter::Exact},
                         {"buffer, exact", Layout::Buffer, Filter::Exact}};

GpuVolume upload(const RuntimeStage& stage, const Way& way) {
    UploadOptions options;
    options.layout = way.layout;
    options.filter = way.filter;
    options.budget = std::uint64_t{4} << 30;
    return orThrow(GpuVolume::upload(stage.context, stage.volume, options));
}

enum class CpuCalls { OnePerPoint, OneForAll };

double nanosecondsOnCpu(const RuntimeStage& stage, const test::Positions& positions, CpuCalls calls) {
    std::vector<runtime::Vec3> world;
    for (const auto& p : positions) world.push_back({double(p[0]), double(p[1]), double(p[2])});
    std::vector<runtime::Light> light(world.size());
    double least = 1e30;
    for (int n = 0; n < 5; ++n) {
        const auto start = std::chrono::steady_clock::now();
        if (calls == CpuCalls::OneForAll) {
            stage.volume.sample(world, light);
        } else {
            for (std::size_t i = 0; i < world.size(); ++i) light[i] = stage.volume.sample(world[i]);
        }
        least =
            std::min(least, std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count());
    }
    double sum = 0;
    for (const runtime::Light& l : light) sum += l.irradiance.x;
    if (!(sum >= 0)) throw std::runtime_error("samples are not numbers");  // and the sum is used
    return least / static_cast<double>(positions.size());
}

}  // namespace

double milliseconds(const RuntimeStage& stage, const std::function<void()>& work) {
    const GlFunctions& gl = stage.context.gl();
    gl.Finish();
    const auto start = std::chrono::steady_clock::now();
    work();
    gl.Finish();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

double leastMilliseconds(const RuntimeStage& stage, const std::function<void()>& work) {
    double least = 1e30;
    for (int n = 0; n < 2 + stage.effort.repeats; ++n) {
        const double ms = milliseconds(stage, work);
        if (n >= 2) least = std::min(least, ms);  // the first two compile and warm up
    }
    return least;
}

Table lookUps(const RuntimeStage& stage) {
    const double voxels = static_cast<double>(stage.volume.litVoxelCount());
    Table table;
    table.title = "Look-ups";
    table.note = fmt::format("ns a sample, least of {} runs of {} samples; {:.2f} million lit voxels.",
                             stage.effort.repeats, stage.effort.samples, voxels / 1e6);
    table.head = {"layout", "random", "coherent", "MB", "bytes a lit voxel"};
    const auto random = test::randomPositions(stage.volume, stage.effort.samples, 1);
    const auto coherent = test::coherentPositions(stage.volume, stage.effort.samples);
    for (const Way& way : kWays) {
        GpuVolume volume = upload(stage, way);
        GlslOptions glsl;
        glsl.filter = way.filter;
        glsl.layout = way.layout;
        glsl.coloured = glsl.repeats = Known::No;
        const auto nanoseconds = [&](const test::Positions& positions) {
            const auto sampler = orThrow(
                test::ComputeSampler::make(stage.context.gl(), positions, volume, glsl, test::SampleRead::Light));
            const double ms = leastMilliseconds(stage, [&] { sampler->run(volume); });
            return fmt::format("{:.1f}", ms * 1e6 / static_cast<double>(positions.size()));
        };
        const auto bytes = static_cast<double>(volume.info().bytes);
        table.add({way.name, nanoseconds(random), nanoseconds(coherent), fmt::format("{:.1f}", bytes / 1e6),
                   fmt::format("{:.1f}", bytes / voxels)});
    }
    const auto bytes = static_cast<double>(stage.volume.bytes());
    for (const auto& [name, calls] : {std::pair{"CPU, one thread, a call a point", CpuCalls::OnePerPoint},
                                      {"CPU, one thread, one call", CpuCalls::OneForAll}}) {
        table.add({name, fmt::format("{:.1f}", nanosecondsOnCpu(stage, random, calls)),
                   fmt::format("{:.1f}", nanosecondsOnCpu(stage, coherent, calls)), fmt::format("{:.1f}", bytes / 1e6),
                   fmt::format("{:.1f}", bytes / voxels)});
    }
    return table;
}

void addVolumePasses(const RuntimeStage& stage, Table& passes) {
    ReceiverPass receivers = orThrow(ReceiverPass::create(stage.context));
    MediumPass media = orThrow(MediumPass::create(stage.context));
    MediumOptions water;
    water.scattering[0] = water.scattering[1] = water.scattering[2] = 0.1F;
    water.anisotropy = 0.8F;
    water.surface[2] = 1;
    water.surface[3] = 0;
    const auto check = [](const Status& status) {
        if (!status) throw std::runtime_error(status.error().message);
    };
    const auto row = [&](const std::string& name, const std::function<void()>& work) {
        passes.add({name, fmt::format("{:.2f}", leastMilliseconds(stage, work))});
    };
    for (const Way& way : kWays) {
        GpuVolume volume = upload(stage, way);
        row(fmt::format("receivers, {}", way.name),
            [&] { check(receivers.draw(stage.view.surfaces, stage.view.target, {{&volume}})); });
        const auto medium = [&](const char* name, const MediumOptions& options) {
            row(fmt::format("media, 32 steps{}, {}", name, way.name),
                [&] { check(media.draw(stage.view.surfaces, stage.view.target, {{&volume}}, options)); });
        };
        medium("", water);
        if (way.layout != Layout::Atlas || way.filter != Filter::Hardware) continue;
        MediumOptions other = water;
        other.skipping = Skipping::DarkPages;
        medium(", dark pages looked for", other);
        other = water;
        other.resolution = MediumResolution::Halved;
        medium(", half resolution", other);
    }
}

}  // namespace photic::benchmark
