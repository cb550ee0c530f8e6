# SPDX-License-Identifier: Apache-2.0
add_test(NAME render_cli COMMAND ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/tests/cli/test_render_cli.py
  $<TARGET_FILE:caustic-render> ${CMAKE_SOURCE_DIR}/scenes)
set_tests_properties(render_cli PROPERTIES LABELS cli)
