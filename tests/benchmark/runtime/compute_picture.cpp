// SPDX-License-Identifier: Apache-2.0
#include "tests/benchmark/runtime/compute_picture.h"

#include <cstring>
#include <stdexcept>

#include "runtime/src/gl_program.h"

namespace photic::benchmark {

using namespace runtime;

namespace {
constexpr GLuint kBinding = 7;
constexpr int kGroup = 8;  // of the shader's local size
}  // namespace

ComputePicture::ComputePicture(const GlFunctions& gl, const std::string& text, int width, int height)
    : gl_(gl), width_(width), height_(height) {
    const std::string all = "#version 430 core\n" + text + R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = 7) writeonly buffer PhoticOut { vec4 photic_out[]; };
uniform ivec4 photic_out_size;
void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = photic_out_size.xy;
    if (any(greaterThanEqual(pixel, size))) return;
    photic_out[pixel.y * size.x + pixel.x] = photicPixel((vec2(pixel) + 0.5) / vec2(size));
}
)";
    const auto program = makeProgram(gl, std::vector<ShaderSourceText>{{GL_COMPUTE_SHADER, {all, {"picture"}}}});
    if (!program) throw std::runtime_error(program.error().message);
    program_ = *program;
    gl.GenBuffers(1, &out_);
    gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, out_);
    gl.BufferData(GL_SHADER_STORAGE_BUFFER, GLsizeiptr{16} * width * height, nullptr, GL_DYNAMIC_COPY);
}

ComputePicture::~ComputePicture() {
    gl_.UseProgram(0);
    gl_.DeleteBuffers(1, &out_);
    gl_.DeleteProgram(program_);
}

void ComputePicture::draw(const std::function<void(const Uniforms&)>& bind) const {
    const Uniforms uniforms(gl_, program_);
    bind(uniforms);
    uniforms.set("photic_out_size", width_, height_, 0, 0);
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kBinding, out_);
    gl_.DispatchCompute(static_cast<GLuint>((width_ + kGroup - 1) / kGroup),
                        static_cast<GLuint>((height_ + kGroup - 1) / kGroup), 1);
}

std::vector<float> ComputePicture::pixels() const {
    std::vector<float> out(4 * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
    const std::size_t bytes = out.size() * sizeof(float);
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, out_);
    if (const void* mapped =
            gl_.MapBufferRange(GL_SHADER_STORAGE_BUFFER, 0, static_cast<GLsizeiptr>(bytes), GL_MAP_READ_BIT)) {
        std::memcpy(out.data(), mapped, bytes);
        gl_.UnmapBuffer(GL_SHADER_STORAGE_BUFFER);
    }
    return out;
}

}  // namespace photic::benchmark
