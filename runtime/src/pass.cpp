// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/pass.h"

#include "runtime/src/gl_program.h"
#include "runtime/src/gpu_volume_impl.h"
#include "runtime/src/guarded.h"
#include "runtime/src/mover_parameters.h"

namespace photic::runtime {

FullScreenPass::~FullScreenPass() {
    for (const auto& [key, program] : programs_) gl().DeleteProgram(program);
    if (vertex_array_) gl().DeleteVertexArrays(1, &vertex_array_);
    if (nearest_) gl().DeleteSamplers(1, &nearest_);
    if (movers_) gl().DeleteBuffers(1, &movers_);
}

GLuint FullScreenPass::program(const std::vector<Define>& defines) {
    std::string key;
    for (const Define& define : defines) key += define.name + "=" + define.value + ";";
    const auto known = programs_.find(key);
    if (known != programs_.end()) return known->second;
    const Result<GLuint> made =
        makeProgram(gl(), {{GL_VERTEX_SHADER, "full_screen.vert.glsl"}, {GL_FRAGMENT_SHADER, file_}}, defines);
    if (!made) throw Failure{made.error()};
    return programs_[key] = *made;
}

GLuint FullScreenPass::programFor(const GpuVolume& volume, std::vector<Define> defines) {
    switch (volume.info().layout) {
        case Layout::Buffer:
            defines.push_back({"PHOTIC_LIGHT_IN_BUFFER", "1"});
            break;
        case Layout::Dense:
            defines.push_back({"PHOTIC_LAYOUT", "2"});
            break;
        case Layout::Atlas:
        case Layout::Automatic:
            defines.push_back({"PHOTIC_LAYOUT", "1"});
            break;
    }
    const VolumeParameters& parameters = volume.impl().parameters;
    defines.push_back({"PHOTIC_COLOURED", parameters.coloured != 0 ? "1" : "0"});
    defines.push_back({"PHOTIC_REPEATS", parameters.repeats != 0 ? "1" : "0"});
    if (volume.impl().filter == Filter::Exact) defines.push_back({"PHOTIC_EXACT", "1"});
    return program(defines);
}

GLuint FullScreenPass::programFor(const GpuVolume& volume, const MoverShadows& shadows) {
    if (!shadows.movers) return programFor(volume);
    const GLuint made = programFor(volume, {{"PHOTIC_MOVERS", "1"}});
    bindMovers(shadows);
    return made;
}

void FullScreenPass::bindMovers(const MoverShadows& shadows) {
    if (!nearest_) nearest_ = makeNearestSampler(gl());
    runtime::bindMovers(gl(), shadows, movers_, nearest_);
}

void FullScreenPass::drawTriangle() {
    if (!vertex_array_) gl().GenVertexArrays(1, &vertex_array_);
    gl().BindVertexArray(vertex_array_);
    gl().DrawArrays(GL_TRIANGLES, 0, 3);
}

void FullScreenPass::abandon() {
    programs_.clear();
    vertex_array_ = nearest_ = movers_ = 0;
}

void bindTarget(const GlFunctions& gl, const Target& target) {
    if (target.width <= 0 || target.height <= 0) {
        fail(ErrorCode::Usage, "the target is " + std::to_string(target.width) + " x " + std::to_string(target.height) +
                                   " pixels; give it the size of its framebuffer");
    }
    gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, target.framebuffer);
    gl.setViewport(target.x, target.y, target.width, target.height);
}

GLuint makeNearestSampler(const GlFunctions& gl) {
    GLuint sampler = 0;
    gl.GenSamplers(1, &sampler);
    gl.SamplerParameteri(sampler, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.SamplerParameteri(sampler, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl.SamplerParameteri(sampler, GL_TEXTURE_COMPARE_MODE, GL_NONE);
    return sampler;
}

void bindGBuffer(const GlFunctions& gl, const Uniforms& uniforms, const GBuffer& surfaces, GLuint nearest) {
    const auto texture = [&](unsigned unit, GLuint name) {
        gl.ActiveTexture(GL_TEXTURE0 + unit);
        gl.BindTexture(GL_TEXTURE_2D, name);
        gl.BindSampler(unit, nearest);
    };
    texture(4, surfaces.depth);
    texture(5, surfaces.normals);
    texture(6, surfaces.albedo);
    uniforms.setMatrix("photic_world_from_clip", surfaces.world_from_clip);
    uniforms.set3("photic_camera", surfaces.camera);
    uniforms.set("photic_empty_depth", surfaces.empty_depth);
    uniforms.set("photic_clip_depth", surfaces.clip_depth == ClipDepth::ZeroToOne ? 1 : 0,
                 surfaces.normal_encoding == NormalEncoding::Unsigned ? 1 : 0);
}

void bindMovers(const GlFunctions& gl, const MoverShadows& shadows, GLuint& buffer, GLuint nearest) {
    const MoverParameters parameters = moverParameters(*shadows.movers);
    if (parameters.count[1] > 0 && shadows.map == 0)
        fail(ErrorCode::Usage, "Movers::map has a size, but there is no texture of it; set MoverShadows::map");
    if (!buffer) gl.GenBuffers(1, &buffer);
    gl.BindBuffer(GL_UNIFORM_BUFFER, buffer);
    fillBuffer(gl, GL_UNIFORM_BUFFER, &parameters, sizeof(parameters), GL_STREAM_DRAW, "what moves");
    gl.BindBufferBase(GL_UNIFORM_BUFFER, 1, buffer);
    gl.ActiveTexture(GL_TEXTURE3);
    gl.BindTexture(GL_TEXTURE_2D, shadows.map);
    gl.BindSampler(3, nearest);
}

void FullScreenPass::bindGBuffer(const Uniforms& uniforms, const GBuffer& surfaces) {
    if (!nearest_) nearest_ = makeNearestSampler(gl());
    runtime::bindGBuffer(gl(), uniforms, surfaces, nearest_);
}

void FullScreenPass::bindNearest(unsigned unit, GLuint texture) {
    if (!nearest_) nearest_ = makeNearestSampler(gl());
    gl().ActiveTexture(GL_TEXTURE0 + unit);
    gl().BindTexture(GL_TEXTURE_2D, texture);
    gl().BindSampler(unit, nearest_);
}

std::vector<LitVolume> allLobes(const std::vector<LitVolume>& volumes) {
    std::vector<LitVolume> lobes;
    for (const LitVolume& v : volumes) {
        if (!v.volume) fail(ErrorCode::Usage, "a LitVolume has no volume");
        lobes.push_back(v);
        if (GpuVolume* second = v.volume->secondLobe()) lobes.push_back({second, v.weight});
    }
    return lobes;
}

}  // namespace photic::runtime
