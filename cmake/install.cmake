# SPDX-License-Identifier: Apache-2.0
# Programs, libraries with their headers, pkg-config files and the CMake package.
include(CMakePackageConfigHelpers)

get_property(libraries GLOBAL PROPERTY CAUSTICS_LIBRARIES)
get_property(programs GLOBAL PROPERTY CAUSTICS_PROGRAMS)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/caustics)

# caustics::caustics, caustics::io and caustics::composite.
foreach(library ${libraries})
  string(REPLACE "caustics-" "" short ${library})
  set_target_properties(${library} PROPERTIES EXPORT_NAME ${short})
  add_library(caustics::${short} ALIAS ${library})
endforeach()
install(TARGETS ${programs} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS ${libraries} EXPORT caustics-targets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY include/caustics DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(FILES README.md CHANGELOG.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

install(EXPORT caustics-targets NAMESPACE caustics:: DESTINATION ${package_dir})
configure_package_config_file(cmake/caustics-config.cmake.in caustics-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(caustics-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/caustics-config.cmake ${CMAKE_BINARY_DIR}/caustics-config-version.cmake
  DESTINATION ${package_dir})

# The .pc files find their prefix from where they lie, so that a tree may be moved.
file(RELATIVE_PATH pc_prefix /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
function(caustics_pkgconfig name description requires)
  set(PC_NAME ${name})
  set(PC_DESCRIPTION ${description})
  set(PC_REQUIRES ${requires})
  set(PC_PREFIX "\${pcfiledir}/${pc_prefix}")
  configure_file(cmake/caustics.pc.in ${name}.pc @ONLY)
  install(FILES ${CMAKE_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()
caustics_pkgconfig(caustics "Caustics for Cycles pictures: scenes and renders in memory" "")
caustics_pkgconfig(caustics-io "Caustics for Cycles pictures: scene, mesh and EXR files" caustics)
caustics_pkgconfig(caustics-composite "Caustics for Cycles pictures: adding layers to a picture" "")
