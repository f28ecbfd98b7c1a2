// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace photic {

/// An array of numbers as text that a script can hold: the first bytes of all numbers, then their second ones and so
/// on, by gzip, as base64. Bytes of one rank resemble one another, which takes a third off what gzip makes of halves.
/// @param bytes           of the numbers, little-endian
/// @param bytes_a_number  that divides bytes.size()
std::string packedArray(std::span<const std::byte> bytes, std::size_t bytes_a_number);

/// The same of a vector of numbers.
template <class Numbers>
std::string packedArray(const Numbers& numbers) {
    return packedArray(std::as_bytes(std::span(numbers)), sizeof(typename Numbers::value_type));
}

}  // namespace photic
