// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/gl_functions.h"

#include <algorithm>
#include <cstring>

namespace photic::runtime {
namespace {

template <class Pointer>
void loadOne(Pointer& pointer, const GlLoader& loader, const char* name) {
    void* address = loader.get_proc_address(loader.user, name);
    // A cast between object and function pointers is only conditionally supported; a copy of the bytes always is.
    static_assert(sizeof(pointer) == sizeof(address));
    std::memcpy(&pointer, &address, sizeof(pointer));
}

std::string textOf(const GLubyte* text) { return text ? reinterpret_cast<const char*>(text) : ""; }

}  // namespace

std::optional<Error> GlFunctions::lost() const {
    if (!GetString(GL_VERSION))
        return Error{ErrorCode::Lost, "no GL context is current in this thread; make the game's current"};
    if (resets && GetGraphicsResetStatus() != GL_NO_ERROR)
        return Error{ErrorCode::Lost,
                     "the GL context is lost; call abandon() on all that was made with it, create the context, and "
                     "make all of it again"};
    return std::nullopt;
}

void GlFunctions::clearErrors() const {
    // Bounded: a lost context may report an error for ever.
    for (int i = 0; i < 64 && GetError() != GL_NO_ERROR; ++i) {
    }
}

GLenum GlFunctions::firstError() const {
    const GLenum first = GetError();
    if (first != GL_NO_ERROR) clearErrors();
    return first;
}

void GlFunctions::setViewport(GLint x, GLint y, GLsizei width, GLsizei height) const {
    if (viewports) {
        ViewportIndexedf(0, static_cast<GLfloat>(x), static_cast<GLfloat>(y), static_cast<GLfloat>(width),
                         static_cast<GLfloat>(height));
    } else {
        Viewport(x, y, width, height);
    }
}

namespace {

bool hasExtension(const GlFunctions& gl, const char* name) {
    GLint count = 0;
    gl.GetIntegerv(GL_NUM_EXTENSIONS, &count);
    for (GLint i = 0; i < count; ++i)
        if (textOf(gl.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i))) == name) return true;
    return false;
}

/// What of the functions that need not be there may be called.
void findOptions(GlFunctions& gl) {
    gl.computes = gl.BindImageTexture && gl.DispatchCompute && gl.MemoryBarrier;
    gl.viewports = !gl.es && gl.ViewportIndexedf && gl.ScissorIndexed && gl.GetFloati_v && gl.Enablei && gl.Disablei &&
                   gl.IsEnabledi;
    const bool each = (!gl.es || gl.minor >= 2 || gl.major > 3) && gl.BlendEquationSeparatei && gl.BlendFuncSeparatei &&
                      gl.ColorMaski && gl.Enablei && gl.Disablei && gl.IsEnabledi && gl.GetBooleani_v;
    constexpr GLuint kMost = 8;  // that desktop GL promises
    GLint count = 1;
    gl.GetIntegerv(GL_MAX_DRAW_BUFFERS, &count);
    gl.draw_buffers = each ? std::clamp(static_cast<GLuint>(count), GLuint{1}, kMost) : 1;
    gl.bc6h = !gl.es || hasExtension(gl, "GL_EXT_texture_compression_bptc");  // OpenGL has it since 4.2
    gl.resets = gl.GetGraphicsResetStatus && (gl.es ? gl.minor >= 2 || gl.major > 3 : gl.minor >= 5 || gl.major > 4);
    // A loader may give pointers to what the context does not have: whether it knows the state tells.
    GLint origin = 0;
    if (gl.ClipControl) gl.GetIntegerv(GL_CLIP_ORIGIN, &origin);
    gl.clip_control = origin != 0;
    gl.clearErrors();
}

}  // namespace

Result<GlFunctions> loadGlFunctions(const GlLoader& loader) {
    if (!loader.get_proc_address) return Error{ErrorCode::Usage, "GlLoader::get_proc_address is null"};
    GlFunctions gl;
    std::string missing;
#define PHOTIC_GL_LOAD(name, type)        \
    loadOne(gl.name, loader, "gl" #name); \
    if (!gl.name) missing += (missing.empty() ? "gl" : ", gl") + std::string(#name);
    PHOTIC_GL_FUNCTIONS(PHOTIC_GL_LOAD)
#undef PHOTIC_GL_LOAD
#define PHOTIC_GL_LOAD(name, type) loadOne(gl.name, loader, "gl" #name);
    PHOTIC_GL_OPTIONAL_FUNCTIONS(PHOTIC_GL_LOAD)
#undef PHOTIC_GL_LOAD

    if (!gl.GetString || !gl.GetIntegerv || !gl.GetError) {
        return Error{ErrorCode::Unsupported, "the loader finds none of GL's functions; make a context current first"};
    }
    const std::string version = textOf(gl.GetString(GL_VERSION));
    if (version.empty()) return Error{ErrorCode::Unsupported, "no GL context is current; make one current first"};
    gl.es = version.rfind("OpenGL ES", 0) == 0;
    gl.GetIntegerv(GL_MAJOR_VERSION, &gl.major);
    gl.GetIntegerv(GL_MINOR_VERSION, &gl.minor);
    const int least_major = gl.es ? 3 : 4, least_minor = gl.es ? 1 : 3;
    if (gl.major < least_major || (gl.major == least_major && gl.minor < least_minor)) {
        return Error{ErrorCode::Unsupported,
                     "the context is '" + version +
                         "'; Photic needs OpenGL 4.3 or OpenGL ES 3.1: ask for one when it is created"};
    }
    if (!missing.empty()) {
        return Error{ErrorCode::Unsupported,
                     "'" + version + "' lacks " + missing + "; update the driver or check the loader"};
    }
    gl.renderer = textOf(gl.GetString(GL_RENDERER));
    gl.GetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &gl.largest_texture_3d);
    gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &gl.largest_texture_2d);
    gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &gl.largest_storage_block);
    findOptions(gl);
    gl.clearErrors();
    return gl;
}

}  // namespace photic::runtime
