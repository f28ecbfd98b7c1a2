// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/plain_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "bake/report/error.h"

namespace photic {

std::string_view plainText(std::string_view bytes, const std::string& path) {
    constexpr std::string_view kUtf8("\xef\xbb\xbf"), kLittle("\xff\xfe"), kBig("\xfe\xff"), kBig32("\0\0\xfe\xff", 4);
    if (bytes.substr(0, kUtf8.size()) == kUtf8) return bytes.substr(kUtf8.size());
    // Without a mark, every second byte of Latin text is 0 in UTF-16.
    const auto zero = [&](std::size_t i) { return bytes[i] == '\0'; };
    const bool unmarked = bytes.size() >= 4 && zero(0) != zero(1) && zero(0) == zero(2) && zero(1) == zero(3);
    if (bytes.substr(0, 2) == kLittle || bytes.substr(0, 2) == kBig || bytes.substr(0, 4) == kBig32 || unmarked)
        throw Error(ErrorCode::Input, fmt::format("'{}' is text in UTF-16 or UTF-32; save it as UTF-8", path));
    return bytes;
}

std::string_view takeLine(std::string_view& rest) {
    const std::size_t end = std::min(rest.find_first_of("\r\n"), rest.size());
    const std::string_view line = rest.substr(0, end);
    const bool two = rest.substr(end, 2) == "\r\n";
    rest.remove_prefix(std::min(end + (two ? 2 : 1), rest.size()));
    return line;
}

std::string excerpt(std::string_view text) { return visible(text.substr(0, 60)); }

std::string visible(std::string_view text) {
    std::string out;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        out += byte < 0x20 || byte == 0x7f ? fmt::format("\\x{:02x}", byte) : std::string(1, c);
    }
    return out;
}

}  // namespace photic
