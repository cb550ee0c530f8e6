# SPDX-License-Identifier: Apache-2.0
# Other programs read our files: Blender, and OpenEXR's and OpenImageIO's own tools.
find_program(CAUSTICS_OIIO_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
if(CAUSTICS_OIIO_PYTHON)
  foreach(t opens_in_blender exr_tools)
    add_test(NAME ${t} COMMAND ${CAUSTICS_OIIO_PYTHON} ${CMAKE_SOURCE_DIR}/tests/blender/${t}.py)
    set_tests_properties(${t} PROPERTIES SKIP_RETURN_CODE 77 ENVIRONMENT
      "CAUSTIC_RENDER=$<TARGET_FILE:caustic-render>;PYTHONDONTWRITEBYTECODE=1")
  endforeach()
endif()
