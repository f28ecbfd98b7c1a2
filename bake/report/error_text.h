// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bake/report/error.h"

namespace photic {

/// An error as people read it: the place that is to blame, and what is wrong, naming no file twice.
inline std::string errorText(const Error& error) {
    const std::string what = error.what();
    const bool named = error.where().empty() || what.find(error.where()) != std::string::npos;
    return named ? what : error.where() + ": " + what;
}

}  // namespace photic
