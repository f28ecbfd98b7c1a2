# SPDX-License-Identifier: Apache-2.0
# With PHOTIC_TESTS=OFF the project configures, and has its rooms but no test programs.
file(REMOVE_RECURSE ${BUILD})
execute_process(COMMAND ${CMAKE_COMMAND} -S ${SOURCE} -B ${BUILD} -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${CXX}
  -DCMAKE_BUILD_TYPE=Release -DPHOTIC_TESTS=OFF OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${BUILD} --target help
  OUTPUT_VARIABLE targets COMMAND_ERROR_IS_FATAL ANY)
if(NOT targets MATCHES "photic_scene")
  message(FATAL_ERROR "no target photic_scene in:\n${targets}")
endif()
if(targets MATCHES "test_[a-z]+")
  message(FATAL_ERROR "PHOTIC_TESTS=OFF still has ${CMAKE_MATCH_0}")
endif()
