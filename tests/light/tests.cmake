# SPDX-License-Identifier: Apache-2.0
# The lights alone, without the rest of the library.
file(GLOB LIGHT_UNDER_TEST CONFIGURE_DEPENDS
  ${CMAKE_SOURCE_DIR}/render/light/*.c
  ${CMAKE_SOURCE_DIR}/tests/light/*.c)
caustics_test(light SOURCES ${LIGHT_UNDER_TEST} OBJECTS caustics_core_objects LINK Threads::Threads)
