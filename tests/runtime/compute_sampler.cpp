// SPDX-License-Identifier: Apache-2.0
#include "tests/runtime/compute_sampler.h"

#include <cmath>
#include <cstring>
#include <random>

#include "runtime/src/gl_program.h"

namespace photic::test {

using namespace runtime;

namespace {

/// World position of a point of the lit box: 0 to 1 along its axes.
std::array<float, 4> inBox(const Volume& volume, double u, double v, double w) {
    const VoxelBox box = volume.litVoxels();
    const auto at = [&](int axis, double t) { return box.min[axis] + t * (box.max[axis] - box.min[axis]); };
    // voxelCentre is affine: build it from its corners, for fractions.
    const Vec3 o = volume.voxelCentre(0, 0, 0), x = volume.voxelCentre(1, 0, 0), y = volume.voxelCentre(0, 1, 0),
               z = volume.voxelCentre(0, 0, 1);
    const double i = at(0, u), j = at(1, v), k = at(2, w);
    return {static_cast<float>(o.x + i * (x.x - o.x) + j * (y.x - o.x) + k * (z.x - o.x)),
            static_cast<float>(o.y + i * (x.y - o.y) + j * (y.y - o.y) + k * (z.y - o.y)),
            static_cast<float>(o.z + i * (x.z - o.z) + j * (y.z - o.z) + k * (z.z - o.z)), 0.0F};
}

}  // namespace

std::vector<std::array<float, 4>> randomPositions(const Volume& volume, std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-0.06, 1.06);
    std::vector<std::array<float, 4>> out(count);
    for (auto& p : out) {
        const double u = unit(random), v = unit(random), w = unit(random);
        p = inBox(volume, u, v, w);
    }
    return out;
}

std::vector<std::array<float, 4>> coherentPositions(const Volume& volume, std::size_t count) {
    std::vector<std::array<float, 4>> out(count);
    const auto width = static_cast<std::size_t>(std::sqrt(static_cast<double>(count)));
    for (std::size_t n = 0; n < count; ++n) {
        const double u = static_cast<double>(n % width) / static_cast<double>(width);
        const double v = static_cast<double>(n / width) / static_cast<double>(width);
        out[n] = inBox(volume, u, v, 0.1 + 0.7 * u * v);
    }
    return out;
}

namespace {

GLuint makeStorage(const GlFunctions& gl, GLuint binding, std::size_t bytes, const void* data) {
    GLuint buffer = 0;
    gl.GenBuffers(1, &buffer);
    gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    gl.BufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(bytes), data, GL_DYNAMIC_COPY);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer);
    return buffer;
}

}  // namespace

Result<std::unique_ptr<ComputeSampler>> ComputeSampler::make(const GlFunctions& gl, const Positions& positions,
                                                             const GpuVolume& volume, GlslOptions options,
                                                             SampleRead read) {
    if (volume.info().layout == Layout::Buffer) options.layout = Layout::Buffer;
    std::string text =
        std::string(gl.es ? "#version 310 es\nprecision highp float;\nprecision highp int;\n" : "#version 430 core\n") +
        volumeGlsl(options) + R"(
        layout(local_size_x = 64) in;
        layout(std430, binding = 4) readonly buffer In { vec4 positions[]; };
        layout(std430, binding = 5) writeonly buffer Out { vec4 samples[]; };
        uniform uint count;
        void main() {
            uint n = gl_GlobalInvocationID.x;
            if (n >= count) return;
            PhoticLight light = PREFIXSample(positions[n].xyz);
            samples[2u * n] = vec4(light.flux, light.mean);
            samples[2u * n + 1u] = vec4(light.irradiance, WITH_DARK);
        }
    )";
    const std::string dark =
        read == SampleRead::LightAndDark ? "PREFIXEmpty(positions[n].xyz, vec3(1.0, 0.0, 0.0))" : "0.0";
    text.replace(text.find("WITH_DARK"), 9, dark);
    for (std::size_t at; (at = text.find("PREFIX")) != std::string::npos;) text.replace(at, 6, options.prefix);
    const auto program = makeProgram(gl, std::vector<ShaderSourceText>{{GL_COMPUTE_SHADER, {text, {"sampler"}}}});
    if (!program) return program.error();
    std::unique_ptr<ComputeSampler> made(new ComputeSampler(gl, options, positions.size()));
    made->program_ = *program;
    made->in_ = makeStorage(gl, 4, positions.size() * sizeof(positions[0]), positions.data());
    made->out_ = makeStorage(gl, 5, positions.size() * sizeof(GpuSample), nullptr);
    return made;
}

ComputeSampler::~ComputeSampler() {
    gl_.UseProgram(0);
    gl_.DeleteBuffers(1, &in_);
    gl_.DeleteBuffers(1, &out_);
    gl_.DeleteProgram(program_);
}

void ComputeSampler::run(GpuVolume& volume) {
    gl_.UseProgram(program_);
    gl_.Uniform1ui(gl_.GetUniformLocation(program_, "count"), static_cast<GLuint>(count_));
    volume.bind(options_.first_texture, options_.first_buffer);
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, in_);
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 5, out_);
    gl_.DispatchCompute(static_cast<GLuint>((count_ + 63) / 64), 1, 1);
}

std::vector<GpuSample> ComputeSampler::samples() const {
    std::vector<GpuSample> result(count_);
    const std::size_t bytes = count_ * sizeof(GpuSample);
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, out_);
    if (const void* mapped =
            gl_.MapBufferRange(GL_SHADER_STORAGE_BUFFER, 0, static_cast<GLsizeiptr>(bytes), GL_MAP_READ_BIT)) {
        std::memcpy(result.data(), mapped, bytes);
        gl_.UnmapBuffer(GL_SHADER_STORAGE_BUFFER);
    }
    return result;
}

}  // namespace photic::test
