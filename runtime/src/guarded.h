// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

#include "photic/result.h"

namespace photic::runtime {

/// Thrown inside the library only; guarded() turns it into a result at the border.
struct Failure {
    Error error;
};

[[noreturn]] inline void fail(ErrorCode code, std::string message) { throw Failure{{code, std::move(message)}}; }

/// The border that no exception crosses: runs `body`, which returns a Result.
template <class Body>
auto guarded(const Body& body) -> decltype(body()) {
    try {
        return body();
    } catch (Failure& failure) {
        return std::move(failure.error);
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::Memory, "out of memory"};
    } catch (const std::length_error&) {
        return Error{ErrorCode::Memory, "out of memory"};
    } catch (const std::exception& e) {
        return Error{ErrorCode::Usage, e.what()};
    }
}

}  // namespace photic::runtime
