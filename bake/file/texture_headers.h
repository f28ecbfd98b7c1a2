// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <string>

namespace photic {

/// What stands before the texels of a KTX 2.0 file with one 3D level of RGBA16F, x fastest, then y, then z.
/// @param metadata  value of the key `photic`
std::string ktx2Header(const glm::ivec3& size, const std::string& metadata);

/// The same for DDS: the header with its DX10 part.
std::string ddsHeader(const glm::ivec3& size);

/// The same for a Unity volume file of version 1, of floats ('F') or of vectors of three floats ('V'), 32 bits each.
std::string vfHeader(const glm::ivec3& size, char kind);

}  // namespace photic
