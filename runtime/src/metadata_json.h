// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "photic/runtime.h"

namespace photic::runtime {

/// Reads one JSON object: its numbers, texts and arrays of three numbers whose keys are those of docs/light_volume.md
/// without `photic:`. Other keys are passed over, whatever they hold; what follows the object too.
/// @throws Failure{Format} for text that is no JSON object, for a newer version, and for values that make no sense
Metadata readMetadata(std::string_view json);

}  // namespace photic::runtime
