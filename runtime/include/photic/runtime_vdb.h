// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads `.vdb` files into the runtime's volumes: for tools and editors that link OpenVDB anyway (target
// photic::runtime_vdb). A game loads `.nvdb`, which needs nothing.

#include <string>

#include "photic/runtime.h"

namespace photic::runtime {

/// @param path  of a light volume, or of any .vdb with a grid `irradiance` (docs/light_volume.md)
/// @return Error{File} with OpenVDB's words, Error{Limit} or Error{Memory}
Result<Volume> loadVdb(const std::string& path, const LoadOptions& options = {});

}  // namespace photic::runtime
