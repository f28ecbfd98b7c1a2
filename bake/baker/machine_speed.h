// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace photic {

/// How many times as long as the core that estimates are made for (a 2.6 GHz server core) a core of this machine takes:
/// by the processor's time for a small bake, the lesser of two. The first call takes that long, some 20 ms.
double machineSlowness();

}  // namespace photic
