// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "photic/runtime.h"
#include "runtime/src/bytes.h"

namespace photic::runtime {

/// The volume of a `.nvdb` (loadVolume() says which grids make one).
/// @throws Failure{Format}, Failure{Limit}
Volume readNvdbFile(const Bytes& file, const LoadOptions& options);

}  // namespace photic::runtime
