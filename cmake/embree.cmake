# SPDX-License-Identifier: Apache-2.0
# Target caustics_embree: Embree 4, else 3.13; or the one that embree_DIR names. render/trace/embree_internal.h,
# the only file that includes its headers, is told which by CAUSTICS_EMBREE.
find_package(embree 4 QUIET CONFIG)
if(NOT embree_FOUND)
  find_package(embree 3.13 REQUIRED CONFIG)
endif()
string(REGEX MATCH "^[0-9]+" CAUSTICS_EMBREE "${embree_VERSION}")
message(STATUS "Embree ${embree_VERSION}")
add_library(caustics_embree INTERFACE)
target_link_libraries(caustics_embree INTERFACE embree)
target_compile_definitions(caustics_embree INTERFACE CAUSTICS_EMBREE=${CAUSTICS_EMBREE})
