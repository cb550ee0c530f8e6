# SPDX-License-Identifier: Apache-2.0
# Warnings, sanitizers and the four kinds of target.

option(CAUSTICS_TESTS "Build the tests" ON)
option(CAUSTICS_WERROR "Treat warnings as errors" OFF)
set(CAUSTICS_SANITIZE "" CACHE STRING "Sanitizers, as for -fsanitize=")

set(CAUSTICS_WARNINGS -Wall -Wextra -Wconversion -Wshadow)
if(CAUSTICS_WERROR)
  list(APPEND CAUSTICS_WARNINGS -Werror)
endif()
set(CAUSTICS_C_WARNINGS ${CAUSTICS_WARNINGS} -Wstrict-prototypes -Wvla)

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

# Writes the linker's version script: what the headers declare leaves the library, nothing else.
function(caustics_export_map name)
  set(symbols "")
  foreach(header ${ARGN})
    set(path ${CMAKE_SOURCE_DIR}/include/caustics/${header})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${path})
    file(READ ${path} text)
    string(REGEX MATCHALL "CAU_API[^;({]*[ *]cau_[a-z0-9_]+\\(" declarations "${text}")
    foreach(declaration ${declarations})
      string(REGEX REPLACE ".*[ *](cau_[a-z0-9_]+)\\($" "\\1" symbol "${declaration}")
      string(APPEND symbols "    ${symbol};\n")
    endforeach()
  endforeach()
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/${name}.map CONTENT "CAUSTICS_0 {\n  global:\n${symbols}  local: *;\n};\n")
endfunction()

# A shared library: SOURCES of its own (also as <name>-objects, so that tests reach the internals), OBJECTS of the
# object libraries it holds, LINK and its part LINK_PUBLIC that the headers need, and the public HEADERS whose
# functions it exports.
function(caustics_library name)
  cmake_parse_arguments(A "" "" "SOURCES;OBJECTS;LINK;LINK_PUBLIC;HEADERS" ${ARGN})
  add_library(${name}-objects OBJECT ${A_SOURCES})
  caustics_compile(${name}-objects)
  target_link_libraries(${name}-objects PUBLIC ${A_OBJECTS} ${A_LINK} ${A_LINK_PUBLIC})
  set(objects $<TARGET_OBJECTS:${name}-objects>)
  foreach(o ${A_OBJECTS})
    list(APPEND objects $<TARGET_OBJECTS:${o}>)
  endforeach()
  add_library(${name} SHARED ${objects})
  caustics_export_map(${name} ${A_HEADERS})
  set_target_properties(${name} PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION 0
    INSTALL_RPATH "${CAUSTICS_LIBRARY_RPATH}" LINK_DEPENDS ${CMAKE_BINARY_DIR}/${name}.map)
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_options(${name} PRIVATE LINKER:--version-script=${CMAKE_BINARY_DIR}/${name}.map LINKER:--as-needed)
  if(NOT CAUSTICS_SANITIZE)
    target_link_options(${name} PRIVATE LINKER:--no-undefined)
  endif()
  target_link_libraries(${name} PUBLIC ${A_LINK_PUBLIC} PRIVATE ${A_LINK})
  foreach(o ${A_OBJECTS})
    target_link_libraries(${name} PRIVATE $<TARGET_PROPERTY:${o},INTERFACE_LINK_LIBRARIES>)
  endforeach()
  set_property(GLOBAL APPEND PROPERTY CAUSTICS_LIBRARIES ${name})
endfunction()

function(caustics_program name)
  cmake_parse_arguments(A "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${A_SOURCES} $<TARGET_OBJECTS:caustics_core_objects>)
  caustics_compile(${name})
  target_link_libraries(${name} PRIVATE ${A_LINK} m Threads::Threads)
  set_target_properties(${name} PROPERTIES INSTALL_RPATH "${CAUSTICS_PROGRAM_RPATH}")
  set_property(GLOBAL APPEND PROPERTY CAUSTICS_PROGRAMS ${name})
endfunction()

# Makes a C file of each text FILE, with the array host_<name without .py>, and appends it to the list SOURCES.
function(caustics_embed sources)
  foreach(file ${ARGN})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${file})
    get_filename_component(name ${file} NAME_WE)
    file(READ ${file} bytes HEX)
    string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
    set(out ${CMAKE_BINARY_DIR}/embedded/${name}.c)
    file(CONFIGURE OUTPUT ${out} @ONLY CONTENT
      "#include \"composite/hosts/scripts.h\"\n\nconst char host_${name}[] = {${bytes} 0};\n")
    list(APPEND ${sources} ${out})
  endforeach()
  set(${sources} ${${sources}} PARENT_SCOPE)
endfunction()
