// SPDX-License-Identifier: Apache-2.0
#include "tests/runtime/water_model.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <stdexcept>

#include "runtime/src/gl_program.h"
#include "tests/support/pool3.h"

namespace photic::test {
namespace {

/// a^2: the part of `ray` across `reference`, along the axis nearest to +x or along both.
double misalignment(const glm::dvec3& ray, const glm::dvec3& reference, int axes) {
    const glm::dvec3 u = glm::normalize(glm::dvec3(1, 0, 0) - reference * reference.x);
    const double a = glm::dot(ray, u), b = glm::dot(ray, glm::cross(reference, u));
    return axes == 2 ? a * a + b * b : a * a;
}

glm::dvec3 normalOf(const glm::dvec2& slopes) { return glm::normalize(glm::dvec3(-slopes.x, -slopes.y, 1)); }

}  // namespace

glm::dvec3 refracted(const glm::dvec3& d, const glm::dvec3& n, double ior_from, double ior_to) {
    const double eta = ior_from / ior_to, cos_in = -glm::dot(d, n), k = 1 - eta * eta * (1 - cos_in * cos_in);
    return k < 0 ? glm::dvec3(0) : eta * d + (eta * cos_in - std::sqrt(k)) * n;
}

glm::dvec3 reflectedAt(const glm::dvec3& d, const glm::dvec3& n) { return d - 2 * glm::dot(d, n) * n; }

double lookupOmega(const glm::dvec2& slopes, const glm::dvec3& sun, double ior, double tau, int axes, double weight) {
    const glm::dvec3 n = normalOf(slopes), up = -refracted(sun, {0, 0, 1}, 1, ior);
    const glm::dvec3 out = refracted(up, -n, ior, 1);
    const double refraction = out == glm::dvec3(0) ? 0 : std::exp(-tau * misalignment(out, -sun, axes));
    const glm::dvec3 back = reflectedAt(up, -n), still = reflectedAt(up, {0, 0, 1});
    return (1 - weight) * refraction + weight * std::exp(-tau * misalignment(back, still, axes));
}

double lookupReflected(const glm::dvec2& slopes, const glm::dvec3& sun, double tau, int axes) {
    const glm::dvec3 down = -reflectedAt(sun, {0, 0, 1});
    return std::exp(-tau * misalignment(reflectedAt(down, normalOf(slopes)), -sun, axes));
}

SampledWater sampleWater(int side, const std::function<double(double x, double y)>& height, double half,
                         runtime::WaterOutside outside) {
    SampledWater out;
    out.heights.resize(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    const double step = 2 * half / side;
    for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
            out.heights[static_cast<std::size_t>(j * side + i)] =
                static_cast<float>(height(-half + (i + 0.5) * step, -half + (j + 0.5) * step));
        }
    }
    out.water.heights = out.heights.data();
    out.water.columns = out.water.rows = side;
    out.water.corner[0] = out.water.corner[1] = static_cast<float>(-half);
    out.water.size[0] = out.water.size[1] = static_cast<float>(2 * half);
    out.water.outside = outside;
    return out;
}

SampledWater pool3Water(int side) {
    return sampleWater(side, [](double x, double y) { return truth::pool3::surface(x, y).x; });
}

runtime::WaterLight pool3Light() {
    runtime::WaterLight light;
    const glm::dvec3 sun = truth::pool3::sun();
    for (int i = 0; i < 3; ++i) {
        light.direction[i] = static_cast<float>(sun[i]);
        light.irradiance[i] = 1;
    }
    light.ior = static_cast<float>(truth::pool3::kIor);
    return light;
}

std::vector<float> evaluate(const runtime::GlFunctions& gl, const std::string& include, const std::string& expression,
                            int width, int height, const std::function<void(const runtime::Uniforms&)>& bind) {
    const auto body = runtime::resolveIncludes(include);
    const auto full_screen = runtime::resolveIncludes("full_screen.vert.glsl");
    if (!body || !full_screen) throw std::runtime_error("no shader " + include);
    const std::string version = "#version 430 core\n";
    const auto program = runtime::makeProgram(
        gl, {{GL_VERTEX_SHADER, {version + *full_screen, {"full_screen.vert.glsl"}}},
             {GL_FRAGMENT_SHADER,
              {version + *body + "out vec4 result;\nvoid main() {\n    vec2 pixel = gl_FragCoord.xy;\n    result = " +
                   expression + ";\n}\n",
               {include}}}});
    if (!program) throw std::runtime_error(program.error().message);

    GLuint target = 0, framebuffer = 0, vertex_array = 0;
    gl.ActiveTexture(GL_TEXTURE0 + 9);
    gl.GenTextures(1, &target);
    gl.BindTexture(GL_TEXTURE_2D, target);
    gl.TexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32F, width, height);
    gl.GenFramebuffers(1, &framebuffer);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target, 0);
    gl.Viewport(0, 0, width, height);
    gl.Disable(GL_BLEND);
    gl.GenVertexArrays(1, &vertex_array);
    gl.BindVertexArray(vertex_array);
    {
        const runtime::Uniforms uniforms(gl, *program);
        bind(uniforms);
    }
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    std::vector<float> out(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4);
    gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, out.data());
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl.DeleteFramebuffers(1, &framebuffer);
    gl.DeleteTextures(1, &target);
    gl.DeleteVertexArrays(1, &vertex_array);
    gl.UseProgram(0);
    gl.DeleteProgram(*program);
    return out;
}

std::string floorPoint(double z, int size) {
    return "vec3(pixel * " + std::to_string(2.0 / size) + " - 1.0, " + std::to_string(z) + ")";
}

Likeness likeness(const std::vector<double>& a, const std::vector<double>& r) {
    double sa = 0, sr = 0, off = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sa += a[i], sr += r[i], off += std::fabs(a[i] - r[i]);
    const double n = static_cast<double>(a.size()), ma = sa / n, mr = sr / n;
    double aa = 0, rr = 0, ar = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        aa += (a[i] - ma) * (a[i] - ma), rr += (r[i] - mr) * (r[i] - mr), ar += (a[i] - ma) * (r[i] - mr);
    }
    return {ar / std::sqrt(aa * rr), sa / sr, off / sr};
}

std::vector<double> channel(const std::vector<float>& pixels, int index) {
    std::vector<double> out(pixels.size() / 4);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = pixels[4 * i + static_cast<std::size_t>(index)];
    return out;
}

}  // namespace photic::test
