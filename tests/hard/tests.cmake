# SPDX-License-Identifier: Apache-2.0
# Numerically hard cases. caustics_script_test() comes from tests/exact, which is included before.
caustics_test(rays SOURCES ${CMAKE_SOURCE_DIR}/tests/hard/test_rays.c OBJECTS caustics_core_objects caustics-objects
  LINK embree Threads::Threads)
caustics_script_test(hard_scenes ${CMAKE_SOURCE_DIR}/tests/hard/hard_scenes.py)
