// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Before a function: compile it for wider vectors too, and let the loader choose by processor. Other compilers, other
/// processors and the sanitizers (whose run time is not up when the loader chooses) get the portable one alone.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define PHOTIC_VECTOR_CLONES __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define PHOTIC_VECTOR_CLONES
#endif
