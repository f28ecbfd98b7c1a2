// SPDX-License-Identifier: Apache-2.0
#include "bake/field/heap.h"

#if defined(__GLIBC__) || __has_include(<malloc.h>)
#include <malloc.h>
#endif

namespace photic {

void keepFreedMemory() {
#if defined(M_TRIM_THRESHOLD) && defined(M_MMAP_THRESHOLD)
    // Tubes and rays of a batch are far smaller; what is larger goes back to the system as before.
    constexpr int kKept = 64 << 20;
    mallopt(M_MMAP_THRESHOLD, kKept / 2);
    mallopt(M_TRIM_THRESHOLD, kKept * 4);
#endif
}

}  // namespace photic
