// SPDX-License-Identifier: Apache-2.0
#include "tests/runtime/gpu_fixture.h"

#include <algorithm>
#include <cmath>

#include "runtime/src/gl_program.h"
#include "tests/runtime/loaded_volume.h"

namespace photic::test {

using namespace runtime;

Volume makeVolume(const NvdbSpec& spec) { return loaded(spec); }

GpuVolume WithGpu::upload(const Volume& volume, const UploadOptions& options) {
    auto uploaded = GpuVolume::upload(*gpu_, volume, options);
    if (!uploaded) {
        ADD_FAILURE() << uploaded.error().message;
        uploaded = GpuVolume::upload(*gpu_, Volume());
    }
    return std::move(*uploaded);
}

std::vector<GpuSample> WithGpu::sample(GpuVolume& volume, const std::vector<std::array<float, 4>>& positions,
                                       const GlslOptions& options) {
    auto sampler = ComputeSampler::make(gl_, positions, volume, options);
    if (!sampler) {
        ADD_FAILURE() << sampler.error().message;
        return std::vector<GpuSample>(positions.size());
    }
    (*sampler)->run(volume);
    return (*sampler)->samples();
}

double WithGpu::filterError() {
    constexpr int kPlaces = 4096;
    const std::string text =
        std::string(gl_.es ? "#version 310 es\nprecision highp float;\n" : "#version 430 core\n") + R"(
        layout(local_size_x = 64) in;
        layout(binding = 0) uniform highp sampler3D ramp;
        layout(std430, binding = 5) writeonly buffer Out { float weights[]; };
        void main() {
            uint n = gl_GlobalInvocationID.x;
            weights[n] = textureLod(ramp, vec3(0.25 + 0.5 * (float(n) + 0.5) / 4096.0, 0.5, 0.5), 0.0).r;
        }
    )";
    const auto program = makeProgram(gl_, std::vector<ShaderSourceText>{{GL_COMPUTE_SHADER, {text, {"filter"}}}});
    if (!program) {
        ADD_FAILURE() << program.error().message;
        return 0;
    }
    const std::uint16_t halves[8] = {0, 0, 0, 0, 0x3c00, 0, 0, 0};  // 0 and 1
    GLuint texture = 0, out = 0;
    gl_.GenTextures(1, &texture);
    gl_.ActiveTexture(GL_TEXTURE0);
    gl_.BindSampler(0, 0);
    gl_.BindTexture(GL_TEXTURE_3D, texture);
    gl_.TexStorage3D(GL_TEXTURE_3D, 1, GL_RGBA16F, 2, 1, 1);
    gl_.TexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, 2, 1, 1, GL_RGBA, GL_HALF_FLOAT, halves);
    for (const GLenum name : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        gl_.TexParameteri(GL_TEXTURE_3D, name, GL_LINEAR);
    gl_.GenBuffers(1, &out);
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 5, out);
    gl_.BufferData(GL_SHADER_STORAGE_BUFFER, kPlaces * sizeof(float), nullptr, GL_DYNAMIC_COPY);
    gl_.UseProgram(*program);
    gl_.DispatchCompute(kPlaces / 64, 1, 1);
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    double worst = 0;
    const void* mapped = gl_.MapBufferRange(GL_SHADER_STORAGE_BUFFER, 0, kPlaces * sizeof(float), GL_MAP_READ_BIT);
    if (mapped) {
        const auto* weights = static_cast<const float*>(mapped);
        for (int n = 0; n < kPlaces; ++n)
            worst = std::max(worst, std::fabs(static_cast<double>(weights[n]) - (n + 0.5) / kPlaces));
        gl_.UnmapBuffer(GL_SHADER_STORAGE_BUFFER);
    } else {
        ADD_FAILURE() << "the weights cannot be read back";
    }
    gl_.UseProgram(0);
    gl_.DeleteProgram(*program);
    gl_.DeleteBuffers(1, &out);
    gl_.DeleteTextures(1, &texture);
    EXPECT_LT(worst, 1.0 / 128) << "the filter is coarser than any GPU's that is known";
    return worst;
}

}  // namespace photic::test
