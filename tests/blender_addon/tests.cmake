# SPDX-License-Identifier: Apache-2.0
# The add-on, in the Blender that is installed; in others: bench/blender/run.sh.
find_program(CAUSTICS_BLENDER blender)
if(CAUSTICS_BLENDER)
  foreach(t scenes bases edges runs hosting)
    add_test(NAME addon_${t} COMMAND ${CAUSTICS_BLENDER} -b --factory-startup --python-exit-code 1
      --python ${CMAKE_SOURCE_DIR}/tests/blender_addon/test_${t}.py)
    set_tests_properties(addon_${t} PROPERTIES LABELS blender SKIP_RETURN_CODE 77 ENVIRONMENT
      "CAUSTICS_BIN=$<TARGET_FILE_DIR:caustic-render>;CAUSTICS_BLENDER=${CAUSTICS_BLENDER};PYTHONDONTWRITEBYTECODE=1")
  endforeach()
endif()
