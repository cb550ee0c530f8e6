# SPDX-License-Identifier: Apache-2.0
find_program(CAUSTICS_OIIO_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
foreach(t nuke recipe blender docs)
  if(CAUSTICS_OIIO_PYTHON)
    add_test(NAME hosts_${t} COMMAND ${CAUSTICS_OIIO_PYTHON} -B ${CMAKE_SOURCE_DIR}/tests/hosts/test_${t}.py -v)
    set_tests_properties(hosts_${t} PROPERTIES ENVIRONMENT CAUSTIC_MERGE=$<TARGET_FILE:caustic-merge> SKIP_RETURN_CODE 77)
  endif()
endforeach()

add_test(NAME hosts_pages COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_SOURCE_DIR}/tests/hosts/test_pages.py -v)
set_tests_properties(hosts_pages PROPERTIES ENVIRONMENT
  "CAUSTIC_ACCURACY=$<TARGET_FILE:caustic-accuracy>;CAUSTIC_MERGE=$<TARGET_FILE:caustic-merge>;CAUSTIC_RENDER=$<TARGET_FILE:caustic-render>;CAUSTICS_BUILD=${CMAKE_BINARY_DIR};CMAKE=${CMAKE_COMMAND}")
