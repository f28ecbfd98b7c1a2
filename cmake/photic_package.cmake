# SPDX-License-Identifier: Apache-2.0
# `cpack` in the build folder: photic (the program and its viewer), photic-doc (pages and examples), libphotic-runtime-dev
# (what a game links) and libphotic-dev (the rooms of the baker) as .deb files. scripts/package builds what is in them, and
# makes a .tar.gz of all besides.
set(CPACK_PACKAGE_NAME photic)
set(CPACK_PACKAGE_VENDOR "The Photic authors")
set(CPACK_PACKAGE_CONTACT "The Photic authors <noreply@photic.invalid>")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_STRIP_FILES ON)
set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL program doc runtime dev)
set(CPACK_OUTPUT_FILE_PREFIX ${CMAKE_BINARY_DIR}/packages)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME photic)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "bakes caustics into OpenVDB volumes
 Photic bakes the light that water, glass and mirrors focus into sparse volumes that
 shade whatever is then moved through them: in Blender and in games.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS photic-doc)
set(CPACK_DEBIAN_DOC_PACKAGE_NAME photic-doc)
set(CPACK_DEBIAN_DOC_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_DOC_DESCRIPTION "pages and examples of Photic
 What light volumes hold, every command and key, and scenes to bake.")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME libphotic-runtime-dev)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_DEPENDS "libgl-dev")
set(CPACK_DEBIAN_RUNTIME_DESCRIPTION "shows Photic's light volumes in a game
 A static library, its headers and its shaders; it needs none of what the
 baker is made of.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libphotic-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libphotic-runtime-dev (= ${PROJECT_VERSION}), libopenvdb-dev, libnanovdb-dev, libtbb-dev, \
libopenexr-dev, libembree-dev, libglm-dev, libfmt-dev, nlohmann-json3-dev, libboost-dev, libblosc-dev, zlib1g-dev")
set(CPACK_DEBIAN_DEV_DESCRIPTION "bakes light volumes from a program of one's own
 The rooms of Photic's baker as static libraries with their headers.")
include(CPack)
