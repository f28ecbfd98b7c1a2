# SPDX-License-Identifier: Apache-2.0
# photic_precompile(TARGET): the standard library's, glm's and, for tests, GoogleTest's headers are half of what the
# compiler does. With PHOTIC_PRECOMPILED_HEADERS they are read once for all rooms and once for all tests. Not together with
# ccache, which could not tell what has changed.
option(PHOTIC_PRECOMPILED_HEADERS "Precompile other people's headers" OFF)

set(PHOTIC_COMMON_HEADERS <algorithm> <array> <atomic> <cmath> <cstdint> <cstring> <functional> <limits> <map> <memory>
  <optional> <span> <string> <string_view> <utility> <vector> <glm/glm.hpp>)

if(PHOTIC_PRECOMPILED_HEADERS)
  # A file that is compiled otherwise than the rest reads the headers themselves: slower, and right.
  target_compile_options(photic_build_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-error=invalid-pch>)
  set(photic_nothing ${CMAKE_CURRENT_BINARY_DIR}/precompiled.cpp)
  file(GENERATE OUTPUT ${photic_nothing} CONTENT "int main() { return 0; }\n")
  add_library(photic_precompiled OBJECT EXCLUDE_FROM_ALL ${photic_nothing})
  target_link_libraries(photic_precompiled PRIVATE photic_build_flags photic_glm)
  target_precompile_headers(photic_precompiled PRIVATE ${PHOTIC_COMMON_HEADERS})
endif()

function(photic_precompile target)
  if(PHOTIC_PRECOMPILED_HEADERS)
    target_precompile_headers(${target} REUSE_FROM photic_precompiled)
  endif()
endfunction()

# The same for tests, which are programs and are compiled otherwise than libraries.
function(photic_precompile_test target)
  if(NOT PHOTIC_PRECOMPILED_HEADERS)
    return()
  endif()
  if(NOT TARGET photic_precompiled_tests)
    add_executable(photic_precompiled_tests EXCLUDE_FROM_ALL ${photic_nothing})
    target_link_libraries(photic_precompiled_tests PRIVATE photic_build_flags photic_glm GTest::gtest)
    target_precompile_headers(photic_precompiled_tests PRIVATE ${PHOTIC_COMMON_HEADERS} <gtest/gtest.h>)
  endif()
  target_precompile_headers(${target} REUSE_FROM photic_precompiled_tests)
endfunction()
