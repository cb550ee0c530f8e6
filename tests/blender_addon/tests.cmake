# SPDX-License-Identifier: Apache-2.0
# The add-on, in the Blender that is installed; in others: bench/blender/run.sh.
find_program(CAUSTICS_BLENDER blender)
if(CAUSTICS_BLENDER)
  foreach(t scenes surfaces baking bases edges runs hosting)
    add_test(NAME addon_${t} COMMAND ${CAUSTICS_BLENDER} -b --factory-startup --python-exit-code 1
      --python ${CMAKE_SOURCE_DIR}/tests/blender_addon/test_${t}.py)
    set_tests_properties(addon_${t} PROPERTIES LABELS blender SKIP_RETURN_CODE 77 ENVIRONMENT
      "CAUSTICS_BIN=$<TARGET_FILE_DIR:caustic-render>;CAUSTICS_BLENDER=${CAUSTICS_BLENDER};PYTHONDONTWRITEBYTECODE=1")
  endforeach()
endif()

# The renderer in a host's process: a host, and an allocator, that would capture its calls.
if(NOT CAUSTICS_SANITIZE)
  foreach(foreign host allocator)
    add_library(foreign_${foreign} MODULE ${CMAKE_CURRENT_LIST_DIR}/foreign_${foreign}.c)
    caustics_compile(foreign_${foreign})
    set_target_properties(foreign_${foreign} PROPERTIES C_VISIBILITY_PRESET default)
  endforeach()
  add_test(NAME addon_inprocess COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_LIST_DIR}/test_inprocess.py)
  set_tests_properties(addon_inprocess PROPERTIES LABELS blender ENVIRONMENT
    "CAUSTICS_BIN=$<TARGET_FILE_DIR:caustic-render>;CAUSTICS_FOREIGN_HOST=$<TARGET_FILE:foreign_host>;CAUSTICS_FOREIGN_ALLOCATOR=$<TARGET_FILE:foreign_allocator>")
endif()
