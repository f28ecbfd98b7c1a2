# SPDX-License-Identifier: Apache-2.0
# `cmake --install` gives the program, the rooms as static libraries with their headers, and a package for find_package(photic).
# Four components, which are packages of their own (photic_package.cmake): program, doc, runtime (what a game links), dev.
include(CMakePackageConfigHelpers)

set(photic_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/photic)
get_property(photic_rooms GLOBAL PROPERTY PHOTIC_ROOMS)

# All that is installed, and no tests: what has to be built before.
add_custom_target(installed DEPENDS ${photic_rooms} photic_runtime photic)
foreach(target photic_viewer manual_and_completions)
  if(TARGET ${target})
    add_dependencies(installed ${target})
  endif()
endforeach()

install(TARGETS ${photic_rooms} EXPORT photic_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
install(EXPORT photic_targets NAMESPACE photic:: DESTINATION ${photic_package_dir} COMPONENT dev)
# What a game links, in an export of its own: it needs none of the baker's dependencies.
install(TARGETS photic_runtime EXPORT photic_runtime_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime)
install(EXPORT photic_runtime_targets NAMESPACE photic:: DESTINATION ${photic_package_dir} COMPONENT runtime)
install(DIRECTORY runtime/include/photic DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT runtime FILES_MATCHING PATTERN "*.h")
install(DIRECTORY runtime/shaders DESTINATION ${CMAKE_INSTALL_DATADIR}/photic COMPONENT runtime
  FILES_MATCHING PATTERN "*.glsl" PATTERN "README.md")
if(TARGET photic)
  install(TARGETS photic RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
endif()

# Headers keep their rooms: include/photic/bake/scene/scene.h is included as "bake/scene/scene.h".
install(DIRECTORY bake DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/photic COMPONENT dev
  FILES_MATCHING PATTERN "*.h" PATTERN cli EXCLUDE PATTERN libraries EXCLUDE)
install(DIRECTORY runtime/format DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/photic/runtime COMPONENT dev FILES_MATCHING PATTERN "*.h")

# The pages in the order in which they stand in the tree, so that their links lead somewhere.
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright COMPONENT program)
foreach(component doc:photic-doc runtime:libphotic-runtime-dev dev:libphotic-dev)
  string(REPLACE ":" ";" component ${component})
  list(GET component 0 name)
  list(GET component 1 package)
  install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} RENAME copyright COMPONENT ${name})
endforeach()
install(FILES LICENSE README.md CHANGELOG.md CONTRIBUTING.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT doc)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT doc)
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT doc
  PATTERN "out" EXCLUDE PATTERN "__pycache__" EXCLUDE PATTERN "*.vdb" EXCLUDE PATTERN "*.nvdb" EXCLUDE)
install(DIRECTORY tests/consume/stranger DESTINATION ${CMAKE_INSTALL_DOCDIR}/tests/consume COMPONENT doc)

configure_package_config_file(cmake/photic-config.cmake.in ${CMAKE_BINARY_DIR}/photic-config.cmake
  INSTALL_DESTINATION ${photic_package_dir})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/photic-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/photic-config.cmake ${CMAKE_BINARY_DIR}/photic-config-version.cmake
  DESTINATION ${photic_package_dir} COMPONENT runtime)
install(FILES cmake/photic_dependencies.cmake DESTINATION ${photic_package_dir} COMPONENT dev)
