# SPDX-License-Identifier: Apache-2.0
# Man pages and completions, made from what the built programs say under --help.
find_package(Python3 QUIET COMPONENTS Interpreter)
if(NOT Python3_FOUND OR CMAKE_CROSSCOMPILING)
  message(STATUS "No man pages and completions: they need Python and a program that runs here")
  return()
endif()

set(python ${CMAKE_COMMAND} -E env PYTHONDONTWRITEBYTECODE=1 ${Python3_EXECUTABLE})
set(help_text ${CMAKE_SOURCE_DIR}/man/help_text.py)
set(pages "")
foreach(program caustic-accuracy caustic-merge caustic-render)
  set(page ${CMAKE_BINARY_DIR}/man/${program}.1)
  set(template ${CMAKE_SOURCE_DIR}/man/${program}.1.in)
  set(maker ${CMAKE_SOURCE_DIR}/man/make_page.py)
  add_custom_command(OUTPUT ${page} DEPENDS ${program} ${maker} ${help_text} ${template}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${CMAKE_BINARY_DIR}/man
    COMMAND ${python} ${maker} $<TARGET_FILE:${program}> ${template} ${PROJECT_VERSION} ${page} VERBATIM)
  set(folder ${CMAKE_BINARY_DIR}/completions)
  set(scripts ${folder}/bash/${program} ${folder}/zsh/_${program} ${folder}/fish/${program}.fish)
  set(maker ${CMAKE_SOURCE_DIR}/completions/make_completions.py)
  add_custom_command(OUTPUT ${scripts} DEPENDS ${program} ${maker} ${help_text}
    COMMAND ${python} ${maker} $<TARGET_FILE:${program}> ${folder} VERBATIM)
  list(APPEND pages ${page} ${scripts})
  install(FILES ${page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
  install(FILES ${folder}/bash/${program} DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
  install(FILES ${folder}/zsh/_${program} DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
  install(FILES ${folder}/fish/${program}.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
endforeach()
add_custom_target(pages ALL DEPENDS ${pages})
