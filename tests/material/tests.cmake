# SPDX-License-Identifier: Apache-2.0
# The materials alone, without the rest of the library.
file(GLOB MATERIAL_UNDER_TEST CONFIGURE_DEPENDS
  ${CMAKE_SOURCE_DIR}/render/material/*.c
  ${CMAKE_SOURCE_DIR}/tests/material/*.c)
caustics_test(material SOURCES ${MATERIAL_UNDER_TEST} OBJECTS caustics_core_objects LINK Threads::Threads)
