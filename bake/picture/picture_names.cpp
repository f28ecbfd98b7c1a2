// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/picture_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string_view>

#include "bake/report/printable.h"

namespace photic {
namespace {

constexpr std::size_t kLongest = 100;  // bytes; of 255, the volume's name takes its part

/// Whether the name would be read as another kind of picture than a receiver's.
bool isReserved(std::string_view name) {
    return name == "view" || name.starts_with("slice_") || name.starts_with("xray_") || name.ends_with("_map") ||
           name.ends_with("_strip");
}

/// What Windows does not let stand in a file's name, and the slash.
bool isForbidden(std::uint32_t c) {
    return c < 0x80 && std::string_view("/\\<>:\"|?*").find(static_cast<char>(c)) != std::string_view::npos;
}

bool isSameButForCapitals(const std::string& a, const std::string& b) {
    const auto small = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
    return a != b &&
           std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](char x, char y) { return small(x) == small(y); });
}

std::uint32_t hashed(std::string_view text) {
    std::uint64_t hash = 0xcbf29ce484222325ull;
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
    return static_cast<std::uint32_t>(hash ^ hash >> 32);
}

}  // namespace

std::string receiverFileName(const std::string& name, const std::vector<std::string>& all) {
    std::string kept;
    for (std::size_t at = 0, length = 1; at < name.size() && kept.size() < kLongest; at += length) {
        const std::uint32_t c = firstCharacter(std::string_view(name).substr(at), length);
        const bool fits = !isForbidden(c) && c < 0x110000 && !actsOnTerminal(c);
        kept += fits ? name.substr(at, length) : "_";
    }
    const bool alone = std::none_of(all.begin(), all.end(),
                                    [&](const std::string& other) { return isSameButForCapitals(name, other); });
    if (kept == name && !isReserved(name) && alone) return name;
    return fmt::format("{}-{:08x}", kept, hashed(name));
}

}  // namespace photic
