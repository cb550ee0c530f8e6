# SPDX-License-Identifier: Apache-2.0
add_test(NAME accuracy_ladder COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_SOURCE_DIR}/tests/accuracy/test_accuracy.py -v)
set_tests_properties(accuracy_ladder PROPERTIES ENVIRONMENT
  "CAUSTIC_ACCURACY=$<TARGET_FILE:caustic-accuracy>;CAUSTIC_RENDER=$<TARGET_FILE:caustic-render>")
add_executable(test_accuracy_metrics ${CMAKE_SOURCE_DIR}/tests/accuracy/test_metrics.c ${CMAKE_SOURCE_DIR}/accuracy/metrics.c
  $<TARGET_OBJECTS:caustics_core_objects>)
caustics_compile(test_accuracy_metrics)
target_link_libraries(test_accuracy_metrics PRIVATE PkgConfig::CMOCKA m Threads::Threads)
add_test(NAME accuracy_metrics COMMAND test_accuracy_metrics)
