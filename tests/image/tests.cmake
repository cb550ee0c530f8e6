# SPDX-License-Identifier: Apache-2.0
set(IMAGE_TEST_OBJECTS caustics_core_objects caustics_image_objects)
caustics_test(layer_names SOURCES ${CMAKE_SOURCE_DIR}/tests/image/test_layer_names.c OBJECTS ${IMAGE_TEST_OBJECTS})
caustics_test(half SOURCES ${CMAKE_SOURCE_DIR}/tests/image/test_half.c OBJECTS ${IMAGE_TEST_OBJECTS})
caustics_test(exr_write SOURCES ${CMAKE_SOURCE_DIR}/tests/image/test_exr_write.c OBJECTS ${IMAGE_TEST_OBJECTS})

# A Python that has the reference reader; without one the comparison with it is not run.
find_program(CAUSTICS_OIIO_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
if(CAUSTICS_OIIO_PYTHON)
  add_test(NAME exr_write_read_back COMMAND ${CAUSTICS_OIIO_PYTHON}
    ${CMAKE_SOURCE_DIR}/tests/image/read_back.py $<TARGET_FILE:test_exr_write>)
  set_tests_properties(exr_write_read_back PROPERTIES SKIP_RETURN_CODE 77)
endif()
