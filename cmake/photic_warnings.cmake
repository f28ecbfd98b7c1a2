# SPDX-License-Identifier: Apache-2.0
# Warnings and sanitizers, as one interface target that every target of ours links privately.
add_library(photic_build_flags INTERFACE)
target_compile_options(photic_build_flags INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wno-missing-field-initializers)
if(PHOTIC_WERROR)
  target_compile_options(photic_build_flags INTERFACE -Werror)
endif()
if(PHOTIC_SANITIZE)
  target_compile_options(photic_build_flags INTERFACE -fsanitize=${PHOTIC_SANITIZE} -fno-omit-frame-pointer -g1)
  target_link_options(photic_build_flags INTERFACE -fsanitize=${PHOTIC_SANITIZE})
endif()
