# SPDX-License-Identifier: Apache-2.0
# The scene stage and its reader alone, without the tracer.
file(GLOB SCENE_UNDER_TEST CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/render/scene/*.c ${CMAKE_SOURCE_DIR}/render/scene/io/*.c
  ${CMAKE_SOURCE_DIR}/render/material/*.c ${CMAKE_SOURCE_DIR}/render/light/*.c)
add_library(scene_under_test OBJECT ${SCENE_UNDER_TEST})
caustics_compile(scene_under_test)
target_link_libraries(scene_under_test PUBLIC PkgConfig::JANSSON PkgConfig::ASSIMP)
foreach(t scene shapes scene_file)
  caustics_test(${t} SOURCES ${CMAKE_SOURCE_DIR}/tests/scene/test_${t}.c OBJECTS caustics_core_objects scene_under_test
    LINK Threads::Threads)
endforeach()
