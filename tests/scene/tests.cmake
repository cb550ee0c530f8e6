# SPDX-License-Identifier: Apache-2.0
# The scene stage and its reader alone, without the tracer.
file(GLOB SCENE_UNDER_TEST CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/render/scene/*.c ${CMAKE_SOURCE_DIR}/render/scene/io/*.c
  ${CMAKE_SOURCE_DIR}/render/material/*.c ${CMAKE_SOURCE_DIR}/render/light/*.c)
add_library(scene_under_test OBJECT ${SCENE_UNDER_TEST})
caustics_compile(scene_under_test)
target_link_libraries(scene_under_test PUBLIC PkgConfig::JANSSON PkgConfig::ASSIMP)
foreach(t scene shapes scene_file mesh_file)
  caustics_test(${t} SOURCES ${CMAKE_SOURCE_DIR}/tests/scene/test_${t}.c OBJECTS caustics_core_objects scene_under_test
    LINK Threads::Threads)
endforeach()

# The reference and the schema, generated from the parameter tables: ninja scene_reference_update writes them.
file(GLOB REFERENCE_SOURCES CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/render/scene/reference/*.c)
add_executable(scene_reference ${REFERENCE_SOURCES} $<TARGET_OBJECTS:caustics_core_objects> $<TARGET_OBJECTS:scene_under_test>)
caustics_compile(scene_reference)
target_link_libraries(scene_reference PRIVATE PkgConfig::JANSSON PkgConfig::ASSIMP Threads::Threads m)
add_custom_target(scene_reference_update
  COMMAND scene_reference markdown > ${CMAKE_SOURCE_DIR}/docs/scene-reference.md
  COMMAND scene_reference schema > ${CMAKE_SOURCE_DIR}/docs/scene.schema.json)
add_test(NAME scene_reference COMMAND ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/tests/scene/check_reference.py
  $<TARGET_FILE:scene_reference> ${CMAKE_SOURCE_DIR})
