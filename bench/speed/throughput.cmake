# SPDX-License-Identifier: Apache-2.0
# Target `throughput`, added to the project from outside: -DCMAKE_PROJECT_caustics_INCLUDE=<this file>. See run.sh.
set(SPEED_FOLDER ${CMAKE_CURRENT_LIST_DIR})

function(speed_add_throughput)
  # throughput.c includes embree.c to reach the bare query, so that object stays out; --wrap puts the clock around the
  # stages of the real passes.
  add_executable(throughput EXCLUDE_FROM_ALL ${SPEED_FOLDER}/throughput.c
    $<FILTER:$<TARGET_OBJECTS:caustics-objects>,EXCLUDE,trace/embree\\.c> $<TARGET_OBJECTS:caustics-io-objects>
    $<TARGET_OBJECTS:caustics_core_objects> $<TARGET_OBJECTS:caustics_image_objects>)
  caustics_compile(throughput)
  target_link_libraries(throughput PRIVATE caustics_embree PkgConfig::JANSSON PkgConfig::ASSIMP PkgConfig::DEFLATE
    OpenEXR::OpenEXR OpenEXR::OpenEXRCore m Threads::Threads)
  foreach(stage trace_nearest eye_trace photons_trace photon_tree_build gather_photons film_add)
    target_link_options(throughput PRIVATE LINKER:--wrap=${stage})
  endforeach()
endfunction()
cmake_language(DEFER CALL speed_add_throughput)
