# SPDX-License-Identifier: Apache-2.0
# The Blender add-on as one zip, with programs and libraries: cmake --build build --target blender_zip
find_package(Python3 QUIET COMPONENTS Interpreter)
if(NOT Python3_FOUND OR NOT CMAKE_SYSTEM_NAME STREQUAL "Linux")
  message(STATUS "No target blender_zip: it needs Python and Linux")
  return()
endif()
string(TOLOWER ${CMAKE_SYSTEM_PROCESSOR} processor)
if(processor MATCHES "^(x86_64|amd64)$")
  set(processor x64)
elseif(processor MATCHES "^(aarch64|arm64)$")
  set(processor arm64)
endif()
set(CAUSTICS_BLENDER_ZIP ${CMAKE_BINARY_DIR}/caustics-${PROJECT_VERSION}-linux-${processor}.zip)
file(GLOB addon_sources CONFIGURE_DEPENDS plugins/blender/caustics/*.py plugins/blender/caustics/*.toml)
add_custom_command(OUTPUT ${CAUSTICS_BLENDER_ZIP}
  DEPENDS caustic-render caustic-merge ${addon_sources} plugins/blender/make_zip.py LICENSE
  COMMAND ${CMAKE_COMMAND} -E env PYTHONDONTWRITEBYTECODE=1 ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/plugins/blender/make_zip.py
    ${CMAKE_BINARY_DIR} ${PROJECT_VERSION} linux-${processor} ${CMAKE_SOURCE_DIR}/LICENSE
    $<TARGET_FILE:caustic-render> $<TARGET_FILE:caustic-merge> VERBATIM)
add_custom_target(blender_zip DEPENDS ${CAUSTICS_BLENDER_ZIP})
