// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace photic {

/// The text of a file without the byte order mark that editors put before it.
/// @param path  for the message
/// @throws Error{Input} for UTF-16 and UTF-32, by name
std::string_view plainText(std::string_view bytes, const std::string& path);

/// Takes the first line off `rest`, without its end: "\n", "\r\n" or a lone "\r".
std::string_view takeLine(std::string_view& rest);

/// At most 60 characters of something from a file, for a message: control characters, which would cut it or act on a
/// terminal, are written "\x00".
std::string excerpt(std::string_view text);
/// The same of all of it.
std::string visible(std::string_view text);

}  // namespace photic
