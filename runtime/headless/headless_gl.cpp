// SPDX-License-Identifier: Apache-2.0
#include "runtime/headless/headless_gl.h"

#ifdef PHOTIC_HAS_EGL
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <cstring>
#endif

namespace photic::runtime {

#ifdef PHOTIC_HAS_EGL

namespace {

std::string eglReason(const char* call) {
    char code[16];
    std::snprintf(code, sizeof(code), "0x%04x", static_cast<unsigned>(eglGetError()));
    return std::string(call) + " failed with " + code;
}

EGLDisplay openDisplay() {
    const auto getPlatformDisplay =
        reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
    if (!getPlatformDisplay) return EGL_NO_DISPLAY;
    // Mesa's surfaceless platform first; drivers that have none (NVIDIA's) offer their devices.
    EGLDisplay display = getPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr)) return display;
    const auto queryDevices = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
    EGLDeviceEXT devices[16];
    EGLint count = 0;
    if (!queryDevices || !queryDevices(16, devices, &count)) return EGL_NO_DISPLAY;
    for (EGLint i = 0; i < count; ++i) {
        display = getPlatformDisplay(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr);
        if (display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr)) return display;
    }
    return EGL_NO_DISPLAY;
}

void* getProcAddress(void*, const char* name) { return reinterpret_cast<void*>(eglGetProcAddress(name)); }

}  // namespace

std::unique_ptr<HeadlessGl> HeadlessGl::make(std::string& reason, GlApi api) {
    // Initialised once and never terminated: eglTerminate would pull it from under other contexts of the process.
    static const EGLDisplay display = openDisplay();
    if (display == EGL_NO_DISPLAY) {
        reason = "no EGL display without a screen; is a GL driver installed (libgl1-mesa-dri, libegl1)?";
        return nullptr;
    }
    if (!eglBindAPI(api == GlApi::Es31 ? EGL_OPENGL_ES_API : EGL_OPENGL_API)) {
        reason = eglReason("eglBindAPI");
        return nullptr;
    }
    const EGLint es[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 1, EGL_NONE};
    const EGLint core[] = {EGL_CONTEXT_MAJOR_VERSION,
                           4,
                           EGL_CONTEXT_MINOR_VERSION,
                           api == GlApi::Core45 ? 5 : 3,
                           EGL_CONTEXT_OPENGL_PROFILE_MASK,
                           EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                           EGL_NONE};
    const EGLContext context =
        eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, api == GlApi::Es31 ? es : core);
    if (context == EGL_NO_CONTEXT) {
        reason = eglReason("eglCreateContext");
        return nullptr;
    }
    std::unique_ptr<HeadlessGl> gl(new HeadlessGl);
    gl->display_ = display;
    gl->context_ = context;
    if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
        reason = eglReason("eglMakeCurrent");
        return nullptr;
    }
    return gl;
}

HeadlessGl::~HeadlessGl() {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
}

void HeadlessGl::makeCurrent() const { eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_); }

GlLoader HeadlessGl::loader() const { return {getProcAddress, nullptr}; }

#else

std::unique_ptr<HeadlessGl> HeadlessGl::make(std::string& reason, GlApi) {
    reason = "built without EGL; install libegl-dev and configure again";
    return nullptr;
}
HeadlessGl::~HeadlessGl() = default;
void HeadlessGl::makeCurrent() const {}
GlLoader HeadlessGl::loader() const { return {}; }

#endif

}  // namespace photic::runtime
