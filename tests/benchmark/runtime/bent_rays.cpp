// SPDX-License-Identifier: Apache-2.0
// photic_bent_benchmark [--quick] [FILE.ivol...]: what curved eye rays cost at which error, on the GPU at hand: the
// paper's loop beside ours, through Luneburg's lens, whose rays are known; then what a picture of each file costs. In
// some minutes on llvmpipe, in seconds on a GPU.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <exception>
#include <filesystem>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <stdexcept>

#include "bake/file/index_volume_file.h"
#include "bake/graded/object_samples.h"
#include "bake/scene/graded_index.h"
#include "photic/bent_rays.h"
#include "tests/benchmark/runtime/compute_picture.h"
#include "tests/benchmark/runtime/or_throw.h"
#include "tests/benchmark/table.h"
#include "tests/runtime/environment_map.h"
#include "tests/runtime/scene_view.h"
#include "tests/support/gl_context.h"

namespace {

using namespace photic;
using namespace photic::runtime;
using benchmark::check, benchmark::orThrow;

constexpr double kRadius = 0.8;

GpuIndexVolumes lensOf(const GpuContext& context, int nodes) {
    GradedObject object;
    object.name = "lens";
    object.index = {makeLuneburgLens({0, 0, 0}, kRadius)};
    Monitor monitor;
    const ObjectSamples s = sampleObject({object}, 0, {kRadius / nodes, {}}, monitor);
    const std::string bytes =
        indexVolumeBytes({{object.name, s.world_from_node, s.origin_world, s.count, s.spline, s.attenuation, s.glow,
                           s.faces, object.scattering, object.anisotropy, s.box_low, s.box_high, s.sharp_sides}});
    return orThrow(GpuIndexVolumes::upload(context, orThrow(readIndexVolumes(bytes.data(), bytes.size()))));
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

/// What a pixel of a computed picture tells: its light, or how often the index was looked up for it.
enum class Told { Light, Looks };

/// The same eye's picture by a compute shader of a game's own.
class ComputedRays {
public:
    ComputedRays(const GlFunctions& gl, const test::Eye& eye, const BentRayOptions& options, bool shapes = false,
                 Told told = Told::Light)
        : eye_(eye), picture_(gl, text(options, shapes, told), eye.width, eye.height) {}
    void draw(BentRayPass& pass, const GpuIndexVolumes& objects, const std::vector<PlacedObject>& placed,
              const Surroundings& around, const BentRayOptions& options) const {
        picture_.draw([&](const Uniforms& u) {
            u.texture("photic_bent_environment", 3, GL_TEXTURE_2D, around.environment);
            const glm::mat4 place_from_clip(glm::translate(glm::dmat4(1), -eye_.position) *
                                            glm::inverse(eye_.clipFromWorld()));
            u.setMatrix("photic_place_from_clip", &place_from_clip[0][0]);
            const float camera[3] = {float(eye_.position.x), float(eye_.position.y), float(eye_.position.z)};
            check(pass.bind(camera, objects, placed, options));
        });
    }
    std::vector<float> pixels() const { return picture_.pixels(); }

private:
    static std::string text(const BentRayOptions& options, bool shapes, Told told) {
        BentGlslOptions glsl;
        glsl.lookup = options.lookup, glsl.shapes = shapes;
        const std::string defines =
            std::string(options.integrator == BentIntegrator::Euler ? "#define PHOTIC_EULER 1\n" : "") +
            (told == Told::Looks ? "#define PHOTIC_BENT_COUNTS 1\n" : "");
        return defines + bentGlsl(glsl) + R"(
layout(binding = 3) uniform highp sampler2D photic_bent_environment;
uniform mat4 photic_place_from_clip;
vec3 photicEnvironment(vec3 d) {
    vec2 uv = vec2(fract(0.5 - atan(d.y, d.x) * 0.15915494309), 0.5 + asin(clamp(d.z, -1.0, 1.0)) * 0.31830988618);
    return textureLod(photic_bent_environment, uv, 0.0).rgb;
}
bool photicNearby(vec3 from, vec3 direction, float limit, out vec3 radiance) {
    radiance = vec3(0.0);
    return false;
}
vec4 photicPixel(vec2 uv) {
    vec4 place = photic_place_from_clip * vec4(2.0 * uv - 1.0, 0.5, 1.0);
    bool touched;
    vec4 light = vec4(photicBentRadiance(vec3(0.0), normalize(place.xyz / place.w), vec3(1.0), 0, touched), 1.0);
#ifdef PHOTIC_BENT_COUNTS
    return vec4(photic_bent_looks);
#else
    return light;
#endif
}
)";
    }
    const test::Eye& eye_;
    benchmark::ComputePicture picture_;
};

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

/// Time of a picture [ms]. Short ones are drawn many times before the wait, as frames are.
double leastMilliseconds(const GlFunctions& gl, bool software, int repeats, const std::function<void()>& draw) {
    // The processor's time for a software renderer, whose clock others share.
    const auto now = [&] {
        if (software) return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
    };
    const auto times = [&](int count) {
        gl.Finish();
        const double start = now();
        for (int n = 0; n < count; ++n) draw();
        gl.Finish();
        return (now() - start) / count;
    };
    draw();  // compiles
    double least = 1e300;
    for (int i = 0; i < repeats; ++i) {
        const double once = times(1);
        least =
            std::min(least, once < 20 ? times(std::min(1000, static_cast<int>(20 / std::max(once, 1e-3)) + 1)) : once);
    }
    return least;
}

/// How often the index is looked up for a pixel that sees an object, on average.
struct Looks {
    std::array<double, 4> kinds{};  ///< where it bends nothing, where it does, along a ray for a face, at one
    double all = 0;
    double busiest = 0;  ///< the same if each pixel took as long as the busiest of its 8 x 4, as on a GPU
};

Looks looksOf(const std::vector<float>& pixels, int width, int height) {
    Looks out;
    int seen = 0;
    for (int top = 0; top < height; top += 4)
        for (int left = 0; left < width; left += 8) {
            double most = 0;
            for (int i = 0; i < 32; ++i) {
                const int x = left + i % 8, y = top + i / 8;
                if (x >= width || y >= height) continue;
                const float* p = &pixels[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                              static_cast<std::size_t>(x))];
                const double all = double(p[0]) + double(p[1]) + double(p[2]) + double(p[3]);
                for (std::size_t k = 0; k < 4; ++k) out.kinds[k] += double(p[k]);
                out.all += all, most = std::max(most, all), seen += all > 0 ? 1 : 0;
            }
            out.busiest += 32 * most;
        }
    for (double* v : {&out.kinds[0], &out.kinds[1], &out.kinds[2], &out.kinds[3], &out.all, &out.busiest})
        *v /= std::max(seen, 1);
    return out;
}

/// An eye that has all of some objects before it.
test::Eye before(const std::vector<runtime::IndexVolume>& objects) {
    glm::dvec3 low(1e300), high(-1e300);
    for (const runtime::IndexVolume& object : objects) {
        Vec3 a, b;
        object.box(a, b);
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3 p = object.node((corner & 1) ? a.x : b.x, (corner & 2) ? a.y : b.y, (corner & 4) ? a.z : b.z);
            low = glm::min(low, glm::dvec3(p.x, p.y, p.z)), high = glm::max(high, glm::dvec3(p.x, p.y, p.z));
        }
    }
    test::Eye eye;
    eye.target = (low + high) / 2.0;
    eye.position = eye.target + glm::length(high - low) * glm::normalize(glm::dvec3(1, 0.4, 0.35));
    eye.near = 0.01 * glm::length(high - low);
    return eye;
}

int run(int width, int height, int repeats, const std::vector<std::string>& files) {
    std::string reason;
    const auto headless = test::HeadlessGl::make(reason);
    if (!headless) {
        fmt::print("no GL, nothing to measure: {}\n", reason);
        return 0;
    }
    const GpuContext context = orThrow(GpuContext::create(headless->loader()));
    const GlFunctions& gl = context.gl();
    const bool software = context.renderer().find("llvmpipe") != std::string::npos;
    if (software && width > 100) width /= 8, height /= 8;
    GpuIndexVolumes lens = lensOf(context, 60);  // 128 nodes a side, as the paper's
    BentRayPass pass = orThrow(BentRayPass::create(context));
    test::Eye eye;
    eye.position = {2.2, 0.3, 0.2}, eye.target = {0, 0, 0};
    eye.vertical_degrees = 42, eye.width = width, eye.height = height;
    const test::DrawnView view(gl, eye, [](const glm::dvec3&, const glm::dvec3&) { return std::nullopt; });
    GBuffer surfaces = view.surfaces;
    surfaces.depth = 0;
    Surroundings around;
    const test::DirectionMap directions(gl);
    around.environment = directions.texture;
    benchmark::Table table;
    table.title = "Curved eye rays through Luneburg's lens";
    table.note = fmt::format("{} (OpenGL {}.{}), {} x {} pixels, {} nodes a side, least of {} runs{}.",
                             context.renderer(), gl.major, gl.minor, width, height, lens.info().texels[0], repeats,
                             software ? ", processor time" : "");
    table.head = {"", "longest step [nodes]", "error [degrees rms]", "ms a picture", "in a compute shader"};
    for (const Row& row : kRows) {
        BentRayOptions options;
        options.integrator = row.integrator, options.lookup = row.lookup, options.step = row.step;
        options.turn = 1, options.steps = 20000;
        const double least = leastMilliseconds(
            gl, software, repeats, [&] { check(pass.draw(surfaces, view.target, lens, {{0}}, around, {}, options)); });
        const double miss = missDegrees(view.pixels(), eye);
        const ComputedRays computed(gl, eye, options);
        const double by_compute =
            leastMilliseconds(gl, software, repeats, [&] { computed.draw(pass, lens, {{0}}, around, options); });
        if (!(std::fabs(missDegrees(computed.pixels(), eye) - miss) < 0.1 * miss))
            throw std::runtime_error("a compute shader's rays leave elsewhere than the pass's");
        table.rows.push_back({row.name, fmt::format("{}", row.step), fmt::format("{:.4f}", miss),
                              fmt::format("{:.2f}", least), fmt::format("{:.2f}", by_compute)});
    }
    fmt::print("{}", markdown(table));
    if (files.empty()) return 0;

    benchmark::Table pictures;
    pictures.title = "Pictures of files";
    pictures.note =
        fmt::format("{} x {} pixels, all of the objects in view, faces and what they reflect included.", width, height);
    pictures.head = {"file", "objects", "MB", "look-ups", "ms a picture", "in a compute shader"};
    benchmark::Table looks;
    looks.title = "Look-ups of the index a pixel";
    looks.note = "400 x 300 pixels, on average over those that see an object, by the spline.";
    looks.head = {
        "file", "nothing bends", "bent", "along, for a face", "at a face", "all", "the busiest of 8 x 4 pixels"};
    for (const std::string& file : files) {
        const std::vector<runtime::IndexVolume> objects = orThrow(loadIndexVolumes(file));
        GpuIndexVolumes uploaded = orThrow(GpuIndexVolumes::upload(context, objects));
        std::vector<PlacedObject> placed;
        for (unsigned n = 0; n < objects.size(); ++n) placed.push_back({n});
        const bool shapes = std::any_of(objects.begin(), objects.end(), [](const runtime::IndexVolume& object) {
            return object.shape() != IndexShape::Samples;
        });
        test::Eye from = before(objects);
        from.width = width, from.height = height;
        const test::DrawnView seen(gl, from, [](const glm::dvec3&, const glm::dvec3&) { return std::nullopt; });
        GBuffer empty = seen.surfaces;
        empty.depth = 0;
        for (const IndexLookup lookup : {kSpline, kGradients}) {
            BentRayOptions options;
            options.lookup = lookup;
            const double least = leastMilliseconds(gl, software, repeats, [&] {
                check(pass.draw(empty, seen.target, uploaded, placed, around, {}, options));
            });
            const ComputedRays computed(gl, from, options, shapes);
            const double by_compute = leastMilliseconds(
                gl, software, repeats, [&] { computed.draw(pass, uploaded, placed, around, options); });
            pictures.rows.push_back({std::filesystem::path(file).stem().string(), fmt::format("{}", objects.size()),
                                     fmt::format("{:.3g}", static_cast<double>(uploaded.info().bytes) / 1e6),
                                     lookup == kSpline ? "spline" : "gradients at nodes", fmt::format("{:.2f}", least),
                                     fmt::format("{:.2f}", by_compute)});
        }
        from.width = 400, from.height = 300;
        const ComputedRays counted(gl, from, {}, shapes, Told::Looks);
        counted.draw(pass, uploaded, placed, around, {});
        const Looks l = looksOf(counted.pixels(), from.width, from.height);
        looks.rows.push_back({std::filesystem::path(file).stem().string(), fmt::format("{:.1f}", l.kinds[0]),
                              fmt::format("{:.1f}", l.kinds[1]), fmt::format("{:.1f}", l.kinds[2]),
                              fmt::format("{:.1f}", l.kinds[3]), fmt::format("{:.1f}", l.all),
                              fmt::format("{:.1f}", l.busiest)});
    }
    fmt::print("\n{}\n{}", markdown(pictures), markdown(looks));
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    bool quick = false;
    std::vector<std::string> files;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "--quick") {
            quick = true;
        } else if (word.rfind("-", 0) == 0) {
            std::fputs("usage: photic_bent_benchmark [--quick] [FILE.ivol...]\n", stderr);
            return 2;
        } else {
            files.push_back(word);
        }
    }
    try {
        return quick ? run(80, 60, 1, files) : run(800, 600, 3, files);
    } catch (const std::exception& e) {
        fmt::print(stderr, "photic_bent_benchmark: {}\n", e.what());
        return 1;
    }
}
