# SPDX-License-Identifier: Apache-2.0
# The rules of the house, checked on the text and on what was built.
function(caustics_house_test name)
  add_test(NAME house_${name} COMMAND ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/tests/house/${name}.py ${ARGN})
  set_tests_properties(house_${name} PROPERTIES SKIP_RETURN_CODE 77 ENVIRONMENT PYTHONDONTWRITEBYTECODE=1)
endfunction()

set(house_sanitize "")
if(CAUSTICS_SANITIZE)
  set(house_sanitize -fsanitize=${CAUSTICS_SANITIZE})
endif()
caustics_house_test(layering)
caustics_house_test(text)
caustics_house_test(format)
caustics_house_test(headers ${CMAKE_C_COMPILER} ${CMAKE_CXX_COMPILER} ${CMAKE_BINARY_DIR}/compile_commands.json)
caustics_house_test(libraries caustics=$<TARGET_FILE:caustics> caustics-io=$<TARGET_FILE:caustics-io>
  caustics-composite=$<TARGET_FILE:caustics-composite>)
# A build for /usr cannot run from elsewhere.
if(CAUSTICS_PROGRAM_RPATH)
  caustics_house_test(install ${CMAKE_BINARY_DIR} ${CMAKE_COMMAND} ${CMAKE_GENERATOR} ${CMAKE_C_COMPILER}
    ${PROJECT_VERSION} "${house_sanitize}")
endif()
caustics_house_test(readme $<TARGET_FILE_DIR:caustic-render>)
