// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace photic {

/// Asks the C library to keep freed memory for the next bake instead of giving it back to the system, whose fresh pages
/// cost more than what is done in them: for programs that bake frame after frame. Does nothing where it is not known
/// how.
void keepFreedMemory();

}  // namespace photic
