// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "runtime/src/shader_source.h"
#include "tests/benchmark/runtime/compute_picture.h"
#include "tests/benchmark/runtime/or_throw.h"
#include "tests/benchmark/runtime/rows.h"
#include "tests/runtime/compute_sampler.h"

namespace photic::benchmark {

using namespace runtime;

namespace {

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

GpuVolume upload(const RuntimeStage& stage, const Way& way, const Volume& volume) {
    UploadOptions options;
    options.layout = way.layout;
    options.filter = way.filter;
    options.budget = std::uint64_t{4} << 30;
    return orThrow(GpuVolume::upload(stage.context, volume, options));
}

/// The receivers' and the media's arithmetic in a compute shader: of the pool's floor and wall, as the passes draw
/// them.
std::string computeText(const Way& way, bool media) {
    GlslOptions glsl;
    glsl.filter = way.filter, glsl.layout = way.layout;
    glsl.coloured = glsl.repeats = Known::No;
    std::string text = volumeGlsl(glsl);
    for (const char* file : {"g_buffer.glsl", "eye_segment.glsl"}) text += orThrow(resolveIncludes(file));
    return text + (media ? R"(
vec4 photicPixel(vec2 uv) {
    PhoticSegment s = photicSegment(ivec2(uv * vec2(textureSize(photic_depth, 0))));
    if (!(s.end > s.begin)) return vec4(0.0);
    PhoticMedium medium = PhoticMedium(vec3(0.1), vec3(0.0), 0.8);
    PhoticRay ray = PhoticRay(photic_camera + s.begin * s.direction, s.direction);
    return vec4(photicInscatter(ray, s.end - s.begin, medium, 32, 0.5, false), s.end);
}
)"
                         : R"(
vec4 photicPixel(vec2 uv) {
    ivec2 texel = ivec2(uv * vec2(textureSize(photic_depth, 0)));
    float depth = texelFetch(photic_depth, texel, 0).r;
    if (depth == photic_empty_depth) return vec4(0.0);
    return vec4(photicIrradiance(photicWorld(uv, depth), photicNormal(texel)) * 0.31830988618, 0.0);
}
)");
}

/// ms a picture of the stage's view.
double inCompute(const RuntimeStage& stage, const Way& way, GpuVolume& volume, bool media) {
    const GlFunctions& gl = stage.context.gl();
    const GBuffer& g = stage.view.surfaces;
    const ComputePicture picture(gl, computeText(way, media), stage.view.target.width, stage.view.target.height);
    return leastMilliseconds(stage, [&] {
        picture.draw([&](const Uniforms& u) {
            u.texture("photic_depth", 4, GL_TEXTURE_2D, g.depth);
            u.texture("photic_normals", 5, GL_TEXTURE_2D, g.normals);
            u.setMatrix("photic_world_from_clip", g.world_from_clip);
            u.set3("photic_camera", g.camera);
            u.set("photic_empty_depth", g.empty_depth);
            u.set("photic_clip_depth", g.clip_depth == ClipDepth::ZeroToOne ? 1 : 0,
                  g.normal_encoding == NormalEncoding::Unsigned ? 1 : 0);
            u.set("photic_medium_surface", 0, 0, 1, 0);
            volume.bind();
        });
    });
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
    constexpr double kLongEnough = 20;  // [ms]
    constexpr int kMost = 1000;
    const GlFunctions& gl = stage.context.gl();
    const auto times = [&](int count) {
        gl.Finish();
        const auto start = std::chrono::steady_clock::now();
        for (int n = 0; n < count; ++n) work();
        gl.Finish();
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count() / count;
    };
    const double once = times(1);
    if (once >= kLongEnough) return once;
    return times(std::min(kMost, static_cast<int>(kLongEnough / std::max(once, 1e-3)) + 1));
}

double leastMilliseconds(const RuntimeStage& stage, const std::function<void()>& work) {
    // The first runs compile, and bring a GPU that has rested back to its pace.
    constexpr auto kWarm = std::chrono::milliseconds(200);
    const auto start = std::chrono::steady_clock::now();
    for (int n = 0; n < 2 || (n < 20 && std::chrono::steady_clock::now() - start < kWarm); ++n)
        milliseconds(stage, work);
    double least = 1e30;
    for (int n = 0; n < stage.effort.repeats; ++n) least = std::min(least, milliseconds(stage, work));
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
        GpuVolume volume = upload(stage, way, stage.volume);
        GlslOptions glsl;
        glsl.filter = way.filter;
        glsl.layout = way.layout;
        glsl.coloured = glsl.repeats = Known::No;
        const auto nanoseconds = [&](const test::Positions& positions) {
            const auto sampler = orThrow(
                test::ComputeSampler::make(stage.context.gl(), positions, volume, glsl, test::SampleRead::Light));
            const double ms = leastMilliseconds(stage, [&] { sampler->run(volume); });
            return fmt::format("{:.4g}", ms * 1e6 / static_cast<double>(positions.size()));
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
    const auto row = [&](const std::string& name, const std::function<void()>& work) {
        passes.add({name, fmt::format("{:.3f}", leastMilliseconds(stage, work))});
    };
    for (const Way& way : kWays) {
        GpuVolume volume = upload(stage, way, stage.volume);
        row(fmt::format("receivers, {}", way.name),
            [&] { check(receivers.draw(stage.view.surfaces, stage.view.target, {{&volume}})); });
        const auto medium = [&](const char* name, const MediumOptions& options) {
            row(fmt::format("media, 32 steps{}, {}", name, way.name),
                [&] { check(media.draw(stage.view.surfaces, stage.view.target, {{&volume}}, options)); });
        };
        medium("", water);
        if (way.filter == Filter::Hardware) {
            for (const bool media_too : {false, true})
                passes.add(
                    {fmt::format("{}, in a compute shader, {}", media_too ? "media, 32 steps" : "receivers", way.name),
                     fmt::format("{:.3f}", inCompute(stage, way, volume, media_too))});
        }
        if (way.layout != Layout::Atlas || way.filter != Filter::Hardware) continue;
        MediumOptions other = water;
        other.skipping = Skipping::DarkPages;
        medium(", dark pages looked for", other);
        other = water;
        other.resolution = MediumResolution::Halved;
        medium(", half resolution", other);
    }
    GpuVolume two_levels = upload(stage, kWays[0], stage.two_levels);
    row(fmt::format("receivers, two levels ({:.1f} MB)", static_cast<double>(two_levels.info().bytes) / 1e6),
        [&] { check(receivers.draw(stage.view.surfaces, stage.view.target, {{&two_levels}})); });
    row("media, 32 steps, two levels",
        [&] { check(media.draw(stage.view.surfaces, stage.view.target, {{&two_levels}}, water)); });
    UploadOptions whichever;
    whichever.budget = std::uint64_t{4} << 30;
    GpuVolume blocks = orThrow(GpuVolume::upload(stage.context, stage.blocks, whichever));
    const char* kind = blocks.info().bc6h ? "BC6H" : "BC6H as halves, which this GPU reads";
    row(fmt::format("receivers, {} ({:.1f} MB)", kind, static_cast<double>(blocks.info().bytes) / 1e6),
        [&] { check(receivers.draw(stage.view.surfaces, stage.view.target, {{&blocks}})); });
    row(fmt::format("media, 32 steps, {}", kind),
        [&] { check(media.draw(stage.view.surfaces, stage.view.target, {{&blocks}}, water)); });
}

Table uploads(const RuntimeStage& stage) {
    Table table;
    table.title = "Uploads";
    table.note = fmt::format("A volume in memory, {} lit voxels, packed and sent; least of {} runs.",
                             stage.volume.litVoxelCount(), stage.effort.repeats);
    table.head = {"layout", "MB", "ms", "GB/s"};
    for (const Way& way : {kWays[0], kWays[2], kWays[4]}) {
        double bytes = 0;
        const double ms = leastMilliseconds(
            stage, [&] { bytes = static_cast<double>(upload(stage, way, stage.volume).info().bytes); });
        table.add({way.name, fmt::format("{:.1f}", bytes / 1e6), fmt::format("{:.1f}", ms),
                   fmt::format("{:.2f}", bytes / ms / 1e6)});
    }
    return table;
}

}  // namespace photic::benchmark
