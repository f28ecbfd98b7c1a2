// SPDX-License-Identifier: Apache-2.0
/// toml++ 3.0 to 3.4, with exceptions, and without its assumption about malformed keys.
#pragma once

#define TOML_EXCEPTIONS 1

// toml++ assumes that a key starts with a key's character before it has looked: on malformed files its assertion
// would end the program, and without assertions the assumption is undefined. Its parser reports the character by
// itself. The macro is made in a header of its own, which 3.4 renamed.
#if __has_include(<toml++/impl/preprocessor.hpp>)
#include <toml++/impl/preprocessor.hpp>
#else
#include <toml++/impl/preprocessor.h>
#endif
#undef TOML_ASSERT_ASSUME
#define TOML_ASSERT_ASSUME(expr) static_cast<void>(0)

#if __has_include(<toml++/toml.hpp>)
#include <toml++/toml.hpp>
#else
#include <toml++/toml.h>
#endif
