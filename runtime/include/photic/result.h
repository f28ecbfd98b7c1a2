// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace photic::runtime {

enum class ErrorCode {
    File,         ///< cannot be opened or read
    Format,       ///< the bytes are no light volume that this library reads, or they are damaged
    Limit,        ///< larger than a limit of the options or of the GPU
    Memory,       ///< the CPU's or the GPU's memory ran out
    Unsupported,  ///< the GL context lacks what is needed
    Shader,       ///< a program did not compile or link; the message holds the driver's log
    Lost,         ///< the GL context is lost, or none is current
    Usage         ///< an argument makes no sense
};

/// What went wrong: the value, the limit and the remedy, in words for a person.
struct Error {
    ErrorCode code = ErrorCode::Usage;
    std::string message;
};

/// A value, or the error instead of it. The library throws nothing.
template <class T>
class [[nodiscard]] Result {
public:
    Result(T value) : content_(std::in_place_index<0>, std::move(value)) {}
    Result(Error error) : content_(std::in_place_index<1>, std::move(error)) {}

    bool ok() const { return content_.index() == 0; }
    explicit operator bool() const { return ok(); }

    /// Only when ok().
    T& value() & { return *std::get_if<0>(&content_); }
    const T& value() const& { return *std::get_if<0>(&content_); }
    T&& value() && { return std::move(*std::get_if<0>(&content_)); }
    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }
    T* operator->() { return std::get_if<0>(&content_); }
    const T* operator->() const { return std::get_if<0>(&content_); }

    /// Only when not ok().
    const Error& error() const { return *std::get_if<1>(&content_); }

private:
    std::variant<T, Error> content_;
};

/// Of functions that return nothing.
struct Done {};
using Status = Result<Done>;

}  // namespace photic::runtime
