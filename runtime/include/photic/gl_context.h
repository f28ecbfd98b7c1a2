// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace photic::runtime {

/// How the library finds GL's functions: the game's own loader, so that nothing is imposed on it.
/// With GLFW: `{[](void*, const char* name) { return (void*)glfwGetProcAddress(name); }}`; likewise
/// SDL_GL_GetProcAddress, eglGetProcAddress.
struct GlLoader {
    void* (*get_proc_address)(void* user, const char* name) = nullptr;
    void* user = nullptr;
};

}  // namespace photic::runtime
