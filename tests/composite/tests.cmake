# SPDX-License-Identifier: Apache-2.0
caustics_test(composite_api SOURCES ${CMAKE_SOURCE_DIR}/tests/composite/test_api.c LINK caustics-composite)

# The header must serve C99 and C++17 hosts.
add_library(composite_header_c99 OBJECT ${CMAKE_SOURCE_DIR}/tests/composite/header_c99.c)
target_compile_options(composite_header_c99 PRIVATE -std=c99 -pedantic -Wall -Wextra -Werror)
target_include_directories(composite_header_c99 PRIVATE ${CMAKE_SOURCE_DIR}/include)
add_library(composite_header_cpp OBJECT ${CMAKE_SOURCE_DIR}/tests/composite/header_cpp.cpp)
target_compile_options(composite_header_cpp PRIVATE -std=c++17 -pedantic -Wall -Wextra -Werror)
target_include_directories(composite_header_cpp PRIVATE ${CMAKE_SOURCE_DIR}/include)

# Debian's own Python has the packages python3-numpy and python3-openimageio.
find_program(CAUSTICS_OIIO_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
foreach(t add blender5 odd colour files relight sequence reports rerender)
  if(CAUSTICS_OIIO_PYTHON)
    add_test(NAME merge_${t} COMMAND ${CAUSTICS_OIIO_PYTHON} -B ${CMAKE_SOURCE_DIR}/tests/composite/test_${t}.py -v)
    set(environment CAUSTIC_MERGE=$<TARGET_FILE:caustic-merge> CAUSTIC_RENDER=$<TARGET_FILE:caustic-render>)
    if(CAUSTICS_SANITIZE)
      list(APPEND environment CAUSTICS_SANITIZED=1)
    endif()
    set_tests_properties(merge_${t} PROPERTIES ENVIRONMENT "${environment}" SKIP_RETURN_CODE 77)
  endif()
endforeach()
if(CAUSTICS_OIIO_PYTHON)
  # The long run (200 and more) is bench/composite/run.sh.
  add_test(NAME merge_random COMMAND ${CAUSTICS_OIIO_PYTHON} -B ${CMAKE_SOURCE_DIR}/tests/composite/random_cases.py --count 40)
  set_tests_properties(merge_random PROPERTIES ENVIRONMENT CAUSTIC_MERGE=$<TARGET_FILE:caustic-merge> SKIP_RETURN_CODE 77)
endif()
