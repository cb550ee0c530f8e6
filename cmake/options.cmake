# SPDX-License-Identifier: Apache-2.0
# Warnings, sanitizers and the three kinds of target.

set(CAUSTICS_WARNINGS -Wall -Wextra -Wconversion -Wshadow)
set(CAUSTICS_C_WARNINGS ${CAUSTICS_WARNINGS} -Wstrict-prototypes -Wvla)
if(CAUSTICS_WERROR)
  list(APPEND CAUSTICS_WARNINGS -Werror)
  list(APPEND CAUSTICS_C_WARNINGS -Werror)
endif()

# The same bytes from the same build: no contraction, no fast-math. errno and traps are not used.
set(CAUSTICS_FLAGS -ffp-contract=off -fno-math-errno -fno-trapping-math)
if(CAUSTICS_SANITIZE)
  list(APPEND CAUSTICS_FLAGS -fsanitize=${CAUSTICS_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${CAUSTICS_SANITIZE})
endif()

function(caustics_compile target)
  target_compile_options(${target} PRIVATE ${CAUSTICS_FLAGS}
    $<$<COMPILE_LANGUAGE:C>:${CAUSTICS_C_WARNINGS}> $<$<COMPILE_LANGUAGE:CXX>:${CAUSTICS_WARNINGS}>)
  target_compile_definitions(${target} PRIVATE _GNU_SOURCE CAUSTICS_VERSION="${PROJECT_VERSION}")
  target_include_directories(${target} PRIVATE ${CMAKE_SOURCE_DIR} PUBLIC $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
endfunction()

function(caustics_object_library name)
  cmake_parse_arguments(A "" "" "SOURCES" ${ARGN})
  add_library(${name} OBJECT ${A_SOURCES})
  caustics_compile(${name})
endfunction()

# A static archive of the internals (for tests) and the shared library that is installed.
function(caustics_library name)
  cmake_parse_arguments(A "" "" "SOURCES;OBJECTS;LINK" ${ARGN})
  add_library(${name}-objects OBJECT ${A_SOURCES})
  caustics_compile(${name}-objects)
  target_link_libraries(${name}-objects PUBLIC ${A_OBJECTS} ${A_LINK})
  set(objects $<TARGET_OBJECTS:${name}-objects>)
  foreach(o ${A_OBJECTS})
    list(APPEND objects $<TARGET_OBJECTS:${o}>)
  endforeach()
  add_library(${name} SHARED ${objects})
  set_target_properties(${name} PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION 0)
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${name} PRIVATE ${A_LINK})
  foreach(o ${A_OBJECTS})
    target_link_libraries(${name} PRIVATE $<TARGET_PROPERTY:${o},INTERFACE_LINK_LIBRARIES>)
  endforeach()
endfunction()

function(caustics_program name)
  cmake_parse_arguments(A "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${A_SOURCES} $<TARGET_OBJECTS:caustics_core_objects>)
  caustics_compile(${name})
  target_link_libraries(${name} PRIVATE ${A_LINK} m Threads::Threads)
endfunction()
