# SPDX-License-Identifier: Apache-2.0
add_test(NAME render_cli COMMAND ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/tests/cli/test_render_cli.py
  $<TARGET_FILE:caustic-render> ${CMAKE_SOURCE_DIR}/scenes)
set_tests_properties(render_cli PROPERTIES LABELS cli)
add_test(NAME long_renders COMMAND ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/tests/cli/test_long_renders.py
  $<TARGET_FILE:caustic-render> $<TARGET_FILE:caustic-merge> ${CMAKE_SOURCE_DIR}/scenes)
set_tests_properties(long_renders PROPERTIES LABELS cli)
