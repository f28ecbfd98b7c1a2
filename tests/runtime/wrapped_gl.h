// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>
#include <map>
#include <string>

#include "runtime/src/gl_functions.h"

namespace photic::test {

/// A GL of which some functions are hidden, or replaced by the test's own: what a poorer driver offers. Must outlive
/// the contexts made with it, until they have loaded their functions.
class WrappedGl {
public:
    explicit WrappedGl(runtime::GlLoader real) : real_(real) {}
    WrappedGl(const WrappedGl&) = delete;
    WrappedGl& operator=(const WrappedGl&) = delete;

    /// @param name  with its `gl`
    void hide(const std::string& name) { other_[name] = nullptr; }
    template <class Function>
    void replace(const std::string& name, Function function) {
        other_[name] = reinterpret_cast<void*>(function);
    }
    /// The driver's own, for what replaces it to call.
    template <class Pointer>
    void real(const char* name, Pointer& pointer) const {
        void* address = real_.get_proc_address(real_.user, name);
        std::memcpy(&pointer, &address, sizeof(pointer));
    }
    runtime::GlLoader loader() { return {find, this}; }

private:
    static void* find(void* user, const char* name) {
        const auto* self = static_cast<const WrappedGl*>(user);
        const auto other = self->other_.find(name);
        return other == self->other_.end() ? self->real_.get_proc_address(self->real_.user, name) : other->second;
    }

    runtime::GlLoader real_;
    std::map<std::string, void*> other_;
};

/// A GL whose 3D textures above a size find no memory.
class StarvedGl : public WrappedGl {
public:
    explicit StarvedGl(runtime::GlLoader driver, int most = 0) : WrappedGl(driver) {
        largest = most, pending = false;
        real("glTexStorage3D", real_storage);
        real("glGetError", real_error);
        replace("glTexStorage3D", &storage);
        replace("glGetError", &error);
    }
    static inline int largest = 0;  ///< [texels]

private:
    static inline PFNGLTEXSTORAGE3DPROC real_storage = nullptr;
    static inline PFNGLGETERRORPROC real_error = nullptr;
    static inline bool pending = false;

    static void storage(GLenum target, GLsizei levels, GLenum format, GLsizei w, GLsizei h, GLsizei d) {
        if (w * h * d > largest) {
            pending = true;
        } else {
            real_storage(target, levels, format, w, h, d);
        }
    }
    static GLenum error() {
        if (!pending) return real_error();
        pending = false;
        return GL_OUT_OF_MEMORY;
    }
};

}  // namespace photic::test
