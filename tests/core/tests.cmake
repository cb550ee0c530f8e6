# SPDX-License-Identifier: Apache-2.0
caustics_test(core SOURCES ${CMAKE_SOURCE_DIR}/tests/core/test_core.c OBJECTS caustics_core_objects LINK Threads::Threads m)
