// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace photic {

/// One file of bake/web/page, made into a string by runtime/embed_shaders.cmake.
struct EmbeddedFile {
    const char* name;
    const char* text;
};

/// In the order of their names. Ends with a null name.
extern const EmbeddedFile kEmbeddedPage[];

}  // namespace photic
