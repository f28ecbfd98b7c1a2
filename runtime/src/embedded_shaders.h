// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace photic::runtime {

/// One file of runtime/shaders, made into a string by runtime/embed_shaders.cmake.
struct EmbeddedShader {
    const char* name;
    const char* text;
};

/// Ends with a null name.
extern const EmbeddedShader kEmbeddedShaders[];

}  // namespace photic::runtime
