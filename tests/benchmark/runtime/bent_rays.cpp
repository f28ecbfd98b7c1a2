// SPDX-License-Identifier: Apache-2.0
// photic_bent_benchmark [--quick]: what curved eye rays cost at which error, on the GPU at hand: the paper's loop
// beside ours, through Luneburg's lens, whose rays are known. One table, in some minutes on llvmpipe, in seconds on a
// GPU.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <ctime>
#include <exception>
#include <glm/geometric.hpp>

#include "bake/file/index_volume_file.h"
#include "bake/graded/object_samples.h"
#include "bake/scene/graded_index.h"
#include "photic/bent_rays.h"
#include "tests/benchmark/table.h"
#include "tests/runtime/scene_view.h"
#include "tests/support/gl_context.h"

namespace {

using namespace photic;
using namespace photic::runtime;

constexpr double kRadius = 0.8;

template <class T>
T require(Result<T> result) {
    if (!result) throw std::runtime_error(result.error().message);
    return std::move(result).value();
}

GpuIndexVolumes lensOf(const GpuContext& context, int nodes) {
    GradedObject object;
    object.name = "lens";
    object.index = {makeLuneburgLens({0, 0, 0}, kRadius)};
    Monitor monitor;
    const ObjectSamples s = sampleObject({object}, 0, {kRadius / nodes, {}}, monitor);
    const std::string bytes =
        indexVolumeBytes({{object.name, s.world_from_node, s.origin_world, s.count, s.spline, s.attenuation, s.glow,
                           s.faces, object.scattering, object.anisotropy, s.box_low, s.box_high, s.sharp_sides}});
    return require(GpuIndexVolumes::upload(context, require(readIndexVolumes(bytes.data(), bytes.size()))));
}

/// Surroundings whose colour is their direction.
GLuint directions(const GlFunctions& gl) {
    constexpr int kWidth = 1024, kHeight = 512;
    std::vector<float> texels;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const double up = ((y + 0.5) / kHeight - 0.5) * M_PI, turn = (0.5 - (x + 0.5) / kWidth) * 2 * M_PI;
            for (const double v : {std::cos(up) * std::cos(turn), std::cos(up) * std::sin(turn), std::sin(up), 1.0})
                texels.push_back(static_cast<float>(0.5 * v + 0.5));
        }
    GLuint texture = 0;
    gl.GenTextures(1, &texture);
    gl.BindTexture(GL_TEXTURE_2D, texture);
    gl.TexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32F, kWidth, kHeight);
    gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, kWidth, kHeight, GL_RGBA, GL_FLOAT, texels.data());
    for (const GLenum name : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        gl.TexParameteri(GL_TEXTURE_2D, name, GL_LINEAR);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
    gl.BindTexture(GL_TEXTURE_2D, 0);
    return texture;
}

/// Root mean square angle between what left the lens and -x0 / R, for rays within 0.9 of its radius.
double missDegrees(const std::vector<float>& pixels, const test::Eye& eye) {
    double squares = 0;
    int rays = 0;
    for (int y = 0; y < eye.height; ++y)
        for (int x = 0; x < eye.width; ++x) {
            const glm::dvec3 d = eye.direction(x, y), o = eye.position;
            const double b = glm::dot(o, d);
            if (glm::length(o - b * d) > 0.9 * kRadius) continue;
            const glm::dvec3 truth =
                -glm::normalize(o + (-b - std::sqrt(b * b - glm::dot(o, o) + kRadius * kRadius)) * d);
            const float* p = &pixels[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(eye.width) +
                                          static_cast<std::size_t>(x))];
            const glm::dvec3 got = glm::normalize(glm::dvec3(p[0], p[1], p[2]) * 2.0 - 1.0);
            const double angle = std::acos(std::clamp(glm::dot(truth, got), -1.0, 1.0)) * 180 / M_PI;
            squares += angle * angle, ++rays;
        }
    return std::sqrt(squares / rays);
}

struct Row {
    const char* name;
    BentIntegrator integrator;
    IndexLookup lookup;
    float step;
};
constexpr auto kEuler = BentIntegrator::Euler, kOurs = BentIntegrator::DriftKickDrift;
constexpr auto kSpline = IndexLookup::Spline, kGradients = IndexLookup::Gradients;
constexpr Row kRows[] = {{"the paper's: Euler, gradients at nodes", kEuler, kGradients, 1},
                         {"", kEuler, kGradients, 0.5F},
                         {"", kEuler, kGradients, 0.25F},
                         {"", kEuler, kGradients, 0.125F},
                         {"drift - kick - drift, gradients at nodes", kOurs, kGradients, 4},
                         {"", kOurs, kGradients, 2},
                         {"", kOurs, kGradients, 1},
                         {"drift - kick - drift, spline", kOurs, kSpline, 4},
                         {"", kOurs, kSpline, 2},
                         {"", kOurs, kSpline, 1},
                         {"", kOurs, kSpline, 0.5F}};

int run(int width, int height, int repeats) {
    std::string reason;
    const auto headless = test::HeadlessGl::make(reason);
    if (!headless) {
        fmt::print("no GL, nothing to measure: {}\n", reason);
        return 0;
    }
    const GpuContext context = require(GpuContext::create(headless->loader()));
    const GlFunctions& gl = context.gl();
    // A software renderer gets few pixels, and the processor's time instead of the clock's, which others share.
    const bool software = context.renderer().find("llvmpipe") != std::string::npos;
    if (software && width > 100) width /= 8, height /= 8;
    const auto now = [&] {
        if (software) return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
    };
    GpuIndexVolumes lens = lensOf(context, 60);  // 128 nodes a side, as the paper's
    BentRayPass pass = require(BentRayPass::create(context));
    test::Eye eye;
    eye.position = {2.2, 0.3, 0.2}, eye.target = {0, 0, 0};
    eye.vertical_degrees = 42, eye.width = width, eye.height = height;
    const test::DrawnView view(gl, eye, [](const glm::dvec3&, const glm::dvec3&) { return std::nullopt; });
    GBuffer surfaces = view.surfaces;
    surfaces.depth = 0;
    Surroundings around;
    around.environment = directions(gl);
    benchmark::Table table;
    table.title = "Curved eye rays through Luneburg's lens";
    table.note = fmt::format("{} (OpenGL {}.{}), {} x {} pixels, {} nodes a side, least of {} runs{}.",
                             context.renderer(), gl.major, gl.minor, width, height, lens.info().texels[0], repeats,
                             software ? ", processor time" : "");
    table.head = {"", "longest step [nodes]", "error [degrees rms]", "ms a picture"};
    for (const Row& row : kRows) {
        BentRayOptions options;
        options.integrator = row.integrator, options.lookup = row.lookup, options.step = row.step;
        options.turn = 1, options.steps = 20000;
        double least = 1e300;
        for (int i = -1; i < repeats; ++i) {
            gl.Finish();
            const double start = now();
            const Status drawn = pass.draw(surfaces, view.target, lens, {{0}}, around, {}, options);
            if (!drawn) throw std::runtime_error(drawn.error().message);
            gl.Finish();
            if (i >= 0) least = std::min(least, now() - start);  // the first one compiles
        }
        table.rows.push_back({row.name, fmt::format("{}", row.step),
                              fmt::format("{:.4f}", missDegrees(view.pixels(), eye)), fmt::format("{:.1f}", least)});
    }
    fmt::print("{}", markdown(table));
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    const bool quick = argc == 2 && std::strcmp(argv[1], "--quick") == 0;
    if (argc > 1 && !quick) {
        std::fputs("usage: photic_bent_benchmark [--quick]\n", stderr);
        return 2;
    }
    try {
        return quick ? run(80, 60, 1) : run(800, 600, 3);
    } catch (const std::exception& e) {
        fmt::print(stderr, "photic_bent_benchmark: {}\n", e.what());
        return 1;
    }
}
