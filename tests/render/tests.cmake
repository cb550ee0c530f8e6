# SPDX-License-Identifier: Apache-2.0
caustics_test(gather SOURCES ${CMAKE_SOURCE_DIR}/tests/render/test_gather.c OBJECTS caustics_core_objects caustics-objects
  LINK embree Threads::Threads)
caustics_test(plan SOURCES ${CMAKE_SOURCE_DIR}/tests/render/test_plan.c OBJECTS caustics_core_objects caustics-objects
  LINK embree Threads::Threads)
caustics_test(forecast SOURCES ${CMAKE_SOURCE_DIR}/tests/render/test_forecast.c OBJECTS caustics_core_objects caustics-objects
  LINK embree Threads::Threads)
