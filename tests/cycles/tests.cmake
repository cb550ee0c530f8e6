# SPDX-License-Identifier: Apache-2.0
# The same pictures as Cycles, in short. Long versions: bench/cycles/compare_off.py, compare_on.py.
find_program(CAUSTICS_OIIO_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)

# caustics_cycles_test(NAME ARGUMENTS...)
function(caustics_cycles_test name)
  if(NOT CAUSTICS_OIIO_PYTHON)
    return()
  endif()
  add_test(NAME ${name} COMMAND ${CAUSTICS_OIIO_PYTHON} ${ARGN})
  set_tests_properties(${name} PROPERTIES SKIP_RETURN_CODE 77 ENVIRONMENT
    "CAUSTIC_RENDER=$<TARGET_FILE:caustic-render>;PYTHONDONTWRITEBYTECODE=1")
endfunction()

set(CYCLES_BEAUTY ${CMAKE_SOURCE_DIR}/tests/cycles/beauty.py)
caustics_cycles_test(cycles_beauty ${CYCLES_BEAUTY})
# What is wrong by 2 % must be noticed.
foreach(case "shift;field" "shift;light" "filter_gauss;filter")
  list(GET case 0 scene)
  list(GET case 1 quantity)
  caustics_cycles_test(cycles_beauty_notices_${quantity} ${CYCLES_BEAUTY} ${scene} --off ${quantity} --expect-wrong)
endforeach()
