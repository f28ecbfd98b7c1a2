# SPDX-License-Identifier: Apache-2.0
# The game's configuration has looked for nothing of the baker's.
file(READ ${CACHE} cache)
foreach(word OPENVDB EMBREE TBB_DIR OpenEXR)
  if(cache MATCHES "\n[^\n/#]*${word}[^\n]*")
    message(FATAL_ERROR "the runtime alone looks for ${CMAKE_MATCH_0}")
  endif()
endforeach()
