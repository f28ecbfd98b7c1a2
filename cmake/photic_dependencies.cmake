# SPDX-License-Identifier: Apache-2.0
# One recipe per dependency. Headers of dependencies are SYSTEM: their warnings are not ours.
find_package(Threads REQUIRED)
find_package(TBB CONFIG REQUIRED)              # before OpenVDB, whose module would look for it in its own way
set(CMAKE_MESSAGE_LOG_LEVEL WARNING)           # Debian's Imath tells at length that its Python bindings are not there
find_package(OpenEXR CONFIG REQUIRED)
unset(CMAKE_MESSAGE_LOG_LEVEL)
find_package(fmt CONFIG REQUIRED)
find_package(nlohmann_json CONFIG REQUIRED)
find_package(TinyGLTF CONFIG QUIET)

# These become imported targets under the same names in the build tree and, through the installed copy of this file,
# in a project that calls find_package(photic).

# OpenVDB ships a find module, not a config.
find_library(PHOTIC_OPENVDB_LIBRARY openvdb REQUIRED)
find_path(PHOTIC_OPENVDB_INCLUDE openvdb/openvdb.h REQUIRED)
if(NOT TARGET photic_openvdb)
  add_library(photic_openvdb INTERFACE IMPORTED)
  target_include_directories(photic_openvdb INTERFACE ${PHOTIC_OPENVDB_INCLUDE})
  target_link_libraries(photic_openvdb INTERFACE ${PHOTIC_OPENVDB_LIBRARY} TBB::tbb Imath::Imath)
endif()

# What .vdb and .nvdb files are packed with.
find_library(PHOTIC_ZLIB_LIBRARY z REQUIRED)
find_library(PHOTIC_BLOSC_LIBRARY blosc REQUIRED)
if(NOT TARGET photic_codecs)
  add_library(photic_codecs INTERFACE IMPORTED)
  target_link_libraries(photic_codecs INTERFACE ${PHOTIC_BLOSC_LIBRARY} ${PHOTIC_ZLIB_LIBRARY})
endif()

# NanoVDB is headers; its two codecs are options of `photic export --codec`.
find_path(PHOTIC_NANOVDB_INCLUDE nanovdb/NanoVDB.h REQUIRED)
if(NOT TARGET photic_nanovdb)
  add_library(photic_nanovdb INTERFACE IMPORTED)
  target_include_directories(photic_nanovdb INTERFACE ${PHOTIC_NANOVDB_INCLUDE})
  target_link_libraries(photic_nanovdb INTERFACE photic_codecs)
  target_compile_definitions(photic_nanovdb INTERFACE NANOVDB_USE_ZIP NANOVDB_USE_BLOSC)
endif()

# Embree 3 (Debian 12) or 4; bake/libraries/embree.h knows both.
find_library(PHOTIC_EMBREE_LIBRARY NAMES embree4 embree3 REQUIRED)
find_path(PHOTIC_EMBREE_INCLUDE NAMES embree4/rtcore.h embree3/rtcore.h REQUIRED)
if(NOT TARGET photic_embree)
  add_library(photic_embree INTERFACE IMPORTED)
  target_include_directories(photic_embree INTERFACE ${PHOTIC_EMBREE_INCLUDE})
  target_link_libraries(photic_embree INTERFACE ${PHOTIC_EMBREE_LIBRARY})
endif()

# In the public headers, hence needed by whoever links a room.
find_path(PHOTIC_GLM_INCLUDE glm/glm.hpp REQUIRED)
if(NOT TARGET photic_glm)
  add_library(photic_glm INTERFACE IMPORTED)
  target_include_directories(photic_glm INTERFACE ${PHOTIC_GLM_INCLUDE})
endif()

if(PHOTIC_PACKAGE_ONLY)
  return()  # what follows is needed to compile Photic, not to use it
endif()
find_path(PHOTIC_TOMLPP_INCLUDE toml++/toml.h REQUIRED)
find_path(PHOTIC_CLI11_INCLUDE CLI/CLI.hpp REQUIRED)
find_path(PHOTIC_STB_INCLUDE stb/stb_image.h REQUIRED)
