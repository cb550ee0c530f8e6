# SPDX-License-Identifier: Apache-2.0
# Answers that are known, by the program alone. Long versions: bench/exact.
find_program(CAUSTICS_OIIO_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)

# caustics_script_test(NAME SCRIPT ARGUMENTS...): a Python test that drives caustic-render.
function(caustics_script_test name script)
  if(NOT CAUSTICS_OIIO_PYTHON)
    return()
  endif()
  add_test(NAME ${name} COMMAND ${CAUSTICS_OIIO_PYTHON} ${script} ${ARGN})
  set_tests_properties(${name} PROPERTIES SKIP_RETURN_CODE 77 ENVIRONMENT
    "CAUSTIC_RENDER=$<TARGET_FILE:caustic-render>;PYTHONDONTWRITEBYTECODE=1;PYTHONPATH=${CMAKE_SOURCE_DIR}/tests/exact")
endfunction()

set(EXACT ${CMAKE_SOURCE_DIR}/tests/exact)
caustics_script_test(exact_answers ${EXACT}/exact_answers.py 0.25)
# A truth that is wrong by 4 % must be noticed.
caustics_script_test(exact_answers_can_fail ${EXACT}/exact_answers.py 0.25 straight --off 0.04)
caustics_script_test(flux_account ${EXACT}/flux_account.py)
caustics_script_test(lights ${EXACT}/lights.py)
caustics_script_test(peak_memory ${EXACT}/lights.py memory 1e6 4e6)
if(CAUSTICS_OIIO_PYTHON)
  set_tests_properties(exact_answers_can_fail PROPERTIES WILL_FAIL TRUE)
endif()
# Coarse meshes with smooth normals: P's four ways through a bent normal against R.
caustics_script_test(bent ${EXACT}/bent.py)
caustics_script_test(kernels ${EXACT}/kernels.py)
caustics_script_test(wave ${EXACT}/wave.py)
caustics_script_test(contact ${EXACT}/contact.py)
caustics_script_test(agreement ${EXACT}/agreement.py 1e5 6e5 --small --soft plastic_room b_ring)
caustics_script_test(coverage ${EXACT}/coverage.py 1e5 2e6 --small --estimators P b_ring plastic_room)
caustics_script_test(coverage_waves ${EXACT}/coverage.py 1e5 6e5 --small --estimators W a_ball)
