# SPDX-License-Identifier: Apache-2.0
# One recipe per dependency. Headers of dependencies are SYSTEM: their warnings are not ours.
find_package(Threads REQUIRED)
find_package(TBB CONFIG REQUIRED)              # before OpenVDB, whose module would look for it in its own way
find_package(OpenEXR CONFIG REQUIRED)
find_package(fmt CONFIG REQUIRED)
find_package(nlohmann_json CONFIG REQUIRED)
find_package(TinyGLTF CONFIG QUIET)

# OpenVDB ships a find module, not a config.
find_library(PHOTIC_OPENVDB_LIBRARY openvdb REQUIRED)
find_path(PHOTIC_OPENVDB_INCLUDE openvdb/openvdb.h REQUIRED)
add_library(photic_openvdb INTERFACE)
target_include_directories(photic_openvdb SYSTEM INTERFACE $<BUILD_INTERFACE:${PHOTIC_OPENVDB_INCLUDE}>)
target_link_libraries(photic_openvdb INTERFACE openvdb TBB::tbb Imath::Imath)

# Embree 3 (Debian 12) or 4 (Ubuntu 24.04); bake/tubes/ray_casting.cpp knows both.
find_library(PHOTIC_EMBREE_LIBRARY NAMES embree4 embree3 REQUIRED)
find_path(PHOTIC_EMBREE_INCLUDE NAMES embree4/rtcore.h embree3/rtcore.h REQUIRED)
add_library(photic_embree INTERFACE)
get_filename_component(embree_name ${PHOTIC_EMBREE_LIBRARY} NAME_WE)
string(REGEX REPLACE "^lib" "" embree_name ${embree_name})
target_link_libraries(photic_embree INTERFACE ${embree_name})
if(EXISTS ${PHOTIC_EMBREE_INCLUDE}/embree4/rtcore.h)
  target_compile_definitions(photic_embree INTERFACE PHOTIC_EMBREE_4)
endif()

find_path(PHOTIC_GLM_INCLUDE glm/glm.hpp REQUIRED)
find_path(PHOTIC_TOMLPP_INCLUDE toml++/toml.h REQUIRED)
find_path(PHOTIC_CLI11_INCLUDE CLI/CLI.hpp REQUIRED)
find_path(PHOTIC_STB_INCLUDE stb/stb_image.h REQUIRED)
