// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace photic {

/// From now on every parallelFor ends with Error{Cancelled} once `wanted` is true: for what must end soon whatever it
/// is busy with, as a process that takes too much memory. Asked before each call of a body; null: never.
void stopLoopsWhen(bool (*wanted)());

}  // namespace photic
