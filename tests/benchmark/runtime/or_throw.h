// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <utility>

#include "photic/result.h"

namespace photic::benchmark {

/// The runtime's results in a program whose errors are exceptions. @throws std::runtime_error
inline void check(const runtime::Status& status) {
    if (!status) throw std::runtime_error(status.error().message);
}

template <class T>
T orThrow(runtime::Result<T> result) {
    if (!result) throw std::runtime_error(result.error().message);
    return std::move(*result);
}

}  // namespace photic::benchmark
