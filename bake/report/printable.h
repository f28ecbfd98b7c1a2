// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace photic {

/// Whether a terminal may act on a character of a text instead of showing it: control characters (C0, DEL, C1), and
/// Unicode's marks that turn the direction of writing or end lines.
inline bool actsOnTerminal(std::uint32_t c) {
    return c < 0x20 || (c >= 0x7f && c < 0xa0) || (c >= 0x200e && c <= 0x200f) || (c >= 0x2028 && c <= 0x202e) ||
           (c >= 0x2066 && c <= 0x2069);
}

/// One character of UTF-8 at the start of `text`, which is not empty.
/// @param length  of the character [bytes]; 1 for a byte that is no UTF-8, which is returned as 0x110000 + byte
inline std::uint32_t firstCharacter(std::string_view text, std::size_t& length) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const std::uint32_t lead = byte(0);
    length = 1;
    if (lead < 0x80) return lead;
    const std::size_t size = lead >= 0xf0 && lead < 0xf8 ? 4 : lead >= 0xe0 ? 3 : lead >= 0xc2 ? 2 : 0;
    if (size == 0 || lead >= 0xf8 || text.size() < size) return 0x110000 + lead;
    std::uint32_t c = lead & (0xffu >> (size + 1));
    for (std::size_t i = 1; i < size; ++i) {
        if ((byte(i) & 0xc0) != 0x80) return 0x110000 + lead;
        c = c << 6 | (byte(i) & 0x3fu);
    }
    length = size;
    return c;
}

/// `text` as one line that a terminal only shows: characters that it would act on, and bytes that are no UTF-8, are
/// written "\x1b".
inline std::string printable(std::string_view text) {
    constexpr char kDigits[] = "0123456789abcdef";
    std::string shown;
    for (std::size_t at = 0, length = 1; at < text.size(); at += length) {
        const std::uint32_t c = firstCharacter(text.substr(at), length);
        if (!actsOnTerminal(c) && c < 0x110000) {
            shown += text.substr(at, length);
            continue;
        }
        for (const char byte : text.substr(at, length)) {
            const auto value = static_cast<unsigned char>(byte);
            shown += "\\x";
            shown += kDigits[value >> 4];
            shown += kDigits[value & 15];
        }
    }
    return shown;
}

}  // namespace photic
