# SPDX-License-Identifier: Apache-2.0
# photic_kernels(ROOM NAME...): compiles NAME_per_set.cpp of a room (or of any target) once per instruction set, with PHOTIC_ISA set to
# portable, avx2 or avx512: the namespace photic::PHOTIC_ISA in which everything of it stands. bake/simd/dispatch.h
# declares and chooses what the file defines.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(PHOTIC_X86_KERNELS ON)
else()
  set(PHOTIC_X86_KERNELS OFF)
endif()

function(photic_kernels room)
  # Products may be fused with sums; nothing is reordered, so that the width of a register changes no result.
  set(flags -O3 -ffp-contract=fast -fno-math-errno -fno-trapping-math -Wno-psabi)
  if(PHOTIC_SANITIZE)
    list(APPEND flags -O1)  # the compiler takes five times as long over what sanitizers make of unrolled loops
  endif()
  set(flags_portable)
  set(flags_avx2 -mavx2 -mfma -mf16c)
  set(flags_avx512 ${flags_avx2} -mavx512f -mavx512dq -mavx512vl -mavx512bw -mprefer-vector-width=512)
  set(header_flags -Wno-uninitialized -Wno-maybe-uninitialized)  # GCC 12: its own headers warn
  set(sets portable)
  if(PHOTIC_X86_KERNELS)
    list(APPEND sets avx2 avx512)
  endif()

  set(target photic_${room})
  if(NOT TARGET ${target})
    set(target ${room})
  endif()

  # The files are compiled by objects of their own; a room that lists all of its sources gives them up.
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources EXCLUDE REGEX "_per_set\\.cpp$")
  set_property(TARGET ${target} PROPERTY SOURCES ${sources})
  list(TRANSFORM ARGN APPEND _per_set.cpp OUTPUT_VARIABLE kernels)
  get_target_property(libraries ${target} LINK_LIBRARIES)
  foreach(set ${sets})
    set(objects ${target}_${set})
    add_library(${objects} OBJECT ${kernels})
    target_link_libraries(${objects} PRIVATE ${libraries})
    target_include_directories(${objects} PRIVATE ${PROJECT_SOURCE_DIR})
    target_compile_definitions(${objects} PRIVATE PHOTIC_ISA=${set})
    target_compile_options(${objects} PRIVATE ${flags} ${flags_${set}} ${header_flags})
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:${objects}>)
  endforeach()
endfunction()
