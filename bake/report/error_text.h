// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cctype>
#include <cstddef>
#include <string>
#include <string_view>

#include "bake/report/error.h"

namespace photic {

/// Whether a text names a place (a file, an option) by itself, and not as a part of a longer name.
inline bool namesPlace(std::string_view text, std::string_view place) {
    const auto goesOn = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-'; };
    for (std::size_t at = text.find(place); at != std::string_view::npos; at = text.find(place, at + 1)) {
        const std::size_t end = at + place.size();
        if ((at == 0 || !goesOn(text[at - 1])) && (end == text.size() || !goesOn(text[end]))) return true;
    }
    return false;
}

/// An error as people read it: the place that is to blame, and what is wrong, naming no place twice.
inline std::string errorText(const Error& error) {
    const std::string what = error.what();
    return error.where().empty() || namesPlace(what, error.where()) ? what : error.where() + ": " + what;
}

}  // namespace photic
