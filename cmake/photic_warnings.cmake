# SPDX-License-Identifier: Apache-2.0
# Warnings and sanitizers, as one interface target that every target of ours links privately.
add_library(photic_build_flags INTERFACE)
target_compile_options(photic_build_flags INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wno-missing-field-initializers)
# GCC 13 and 14 take any reference that a function returns for one to its temporary arguments, a name beside a container too.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13)
  target_compile_options(photic_build_flags INTERFACE -Wno-dangling-reference)
endif()
if(PHOTIC_WERROR)
  target_compile_options(photic_build_flags INTERFACE -Werror)
endif()
if(PHOTIC_SANITIZE)
  target_compile_options(photic_build_flags INTERFACE -fsanitize=${PHOTIC_SANITIZE} -fno-omit-frame-pointer -g1)
  target_link_options(photic_build_flags INTERFACE -fsanitize=${PHOTIC_SANITIZE})
endif()
