// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bake/file/checked_file.h"

namespace photic {

/// Writes the volume of one frame as that of another frame of equal inputs: the bytes of its voxels as they are, with
/// another number and hash.
/// @param hash       inputHash() of the other frame
/// @param of_source  that of the file's own: what is there now may be another file
/// @return false where the file is not the volume of that hash, or cannot be read; nothing is written then
/// @throws Error{Failed}
bool copyFrame(const std::string& from, const std::string& of_source, CheckedFile& to, int frame,
               const std::string& hash);

}  // namespace photic
