# What `cmake --install` puts where: the program, its man page, what the desktop knows of it, its documents. GNU's installation directories.
# Nothing of it is read at run time but the program itself: scenes, shaders and fonts are compiled in.
include(GNUInstallDirs)
set(WARPSCOPE_PACKAGE_DIR ${CMAKE_CURRENT_LIST_DIR})

install(TARGETS warpscope RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(FILES ${WARPSCOPE_PACKAGE_DIR}/warpscope.desktop DESTINATION ${CMAKE_INSTALL_DATADIR}/applications)
install(FILES ${WARPSCOPE_PACKAGE_DIR}/warpscope.svg DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps)
install(FILES ${WARPSCOPE_PACKAGE_DIR}/copyright ${CMAKE_SOURCE_DIR}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY ${CMAKE_SOURCE_DIR}/assets/scenes DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples
  FILES_MATCHING PATTERN *.json PATTERN README.md)

# The man page is what the program says of itself, which needs a program that runs here.
if(CMAKE_CROSSCOMPILING)
  message(STATUS "warpscope: the man page is left out, because the program is built for another machine and cannot be asked for it")
else()
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  set(manual ${CMAKE_BINARY_DIR}/warpscope.1.gz)
  add_custom_command(
    OUTPUT ${manual}
    COMMAND ${Python3_EXECUTABLE} ${WARPSCOPE_PACKAGE_DIR}/man_page.py $<TARGET_FILE:warpscope> ${PROJECT_VERSION} ${manual}
    DEPENDS warpscope ${WARPSCOPE_PACKAGE_DIR}/man_page.py
    COMMENT "Writing the man page"
    VERBATIM)
  add_custom_target(manual ALL DEPENDS ${manual})
  install(FILES ${manual} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
endif()
