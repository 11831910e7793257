# What `cmake --install` puts where: the program, its man page, what the desktop knows of it, its documents. GNU's installation directories.
# Nothing of it is read at run time but the program itself, and in a portable build its library: scenes, shaders and fonts are compiled in.
include(GNUInstallDirs)
set(WARPSCOPE_PACKAGE_DIR ${CMAKE_CURRENT_LIST_DIR})
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME warpscope)

install(TARGETS warpscope RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
if(WARPSCOPE_LEVELS)
  # The program finds its library from where it is itself, so that the whole may be moved; the loader looks in glibc-hwcaps/ by itself. For
  # libraries in lib/warpscope/ CPack would have ldconfig run, which is for public ones.
  set(libraries ${CMAKE_INSTALL_LIBDIR}/warpscope/render)
  file(RELATIVE_PATH librariesFromProgram /${CMAKE_INSTALL_BINDIR} /${libraries})
  set_target_properties(warpscope PROPERTIES INSTALL_RPATH "$ORIGIN/${librariesFromProgram}")
  install(TARGETS warpscope_render LIBRARY DESTINATION ${libraries})
  if(WARPSCOPE_HAS_CUDA)
    install(TARGETS warpscope_cuda LIBRARY DESTINATION ${libraries})
  endif()
  foreach(level IN LISTS WARPSCOPE_LEVELS)
    install(TARGETS warpscope_render_${level} LIBRARY DESTINATION ${libraries}/glibc-hwcaps/${level})
  endforeach()
endif()
if(TARGET warpscope_mpi)
  install(TARGETS warpscope_mpi LIBRARY DESTINATION lib/warpscope COMPONENT mpi)  # where process_ranks.cpp looks for it
endif()
install(FILES ${WARPSCOPE_PACKAGE_DIR}/warpscope.desktop DESTINATION ${CMAKE_INSTALL_DATADIR}/applications)
install(FILES ${WARPSCOPE_PACKAGE_DIR}/warpscope.svg DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps)
install(FILES ${WARPSCOPE_PACKAGE_DIR}/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR})
# Each where the others' links look for it.
foreach(folder "" app render net assets/package assets/scenes tests tests/bench tests/stability)
  install(FILES ${CMAKE_SOURCE_DIR}/${folder}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/${folder})
endforeach()
install(DIRECTORY ${CMAKE_SOURCE_DIR}/assets/pictures DESTINATION ${CMAKE_INSTALL_DOCDIR}/assets)
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
