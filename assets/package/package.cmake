# What `cpack` makes: packages for Debian 12, of what install.cmake installs; what needs MPI is one of its own. `./warpscope package` is the short way to them.
# Debian Policy Manual 4.6, sections 5 (control files), 8.6 (shared libraries) and 12 (documentation).
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME warpscope)
set(CPACK_PACKAGE_CONTACT "warpscope developers <developers@warpscope.invalid>")  # .invalid: nobody's address (RFC 2606)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "what image warping does to the pictures of a remote volume renderer")
string(JOIN "\n" CPACK_PACKAGE_DESCRIPTION
  "A volume renderer on a machine far away reaches its viewer late. Image"
  "warping hides that: the server sends a depth with each colour, and the"
  "viewer redraws these samples for the camera of now. warpscope shows different"
  "ways of warping side by side, over the same frames, with their errors, holes"
  "and times: in a window, and without one for tests and figures.")
set(CPACK_STRIP_FILES ON)
# Whatever the umask of who packs.
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL warpscope)
set(CPACK_DEBIAN_WARPSCOPE_PACKAGE_NAME warpscope)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
if(WARPSCOPE_LEVELS)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR}/lib)  # the package's own libraries are no other's
endif()
# What is loaded by name at run time, which dpkg-shlibdeps cannot see: Mesa's drivers, for EGL as well as for GLX, Mesa into memory, and what GLFW takes from X11.
set(CPACK_DEBIAN_WARPSCOPE_PACKAGE_DEPENDS
  "libgl1-mesa-dri, libosmesa6, libx11-xcb1, libxcursor1, libxi6, libxinerama1, libxrandr2, libxrender1, libxxf86vm1")
if(WARPSCOPE_HAS_CUDA)
  set(CPACK_DEBIAN_WARPSCOPE_PACKAGE_SUGGESTS libcuda1)  # the driver; CUDA's runtime library is linked in
endif()
if(TARGET warpscope_mpi)
  # Of its own, so that who has one process needs nothing of MPI.
  list(APPEND CPACK_COMPONENTS_ALL mpi)
  set(CPACK_DEBIAN_MPI_PACKAGE_NAME warpscope-mpi)
  set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "warpscope (= ${PROJECT_VERSION}), openmpi-bin")
  string(JOIN "\n" CPACK_DEBIAN_MPI_DESCRIPTION
    "what image warping does to the pictures of a remote volume renderer: MPI"
    "With this, warpscope serves one volume from several processes that mpirun or"
    "srun has started, on one machine or on many: each holds a part of it. Without"
    "it, warpscope is one process.")
endif()

# The changelog's first entry is of this version: the package's version comes from CMake alone.
set(changelog ${CMAKE_CURRENT_LIST_DIR}/changelog)
file(STRINGS ${changelog} firstEntry LIMIT_COUNT 1)
if(NOT firstEntry MATCHES "^warpscope \\(${PROJECT_VERSION}\\) ")
  message(FATAL_ERROR "assets/package/changelog begins with '${firstEntry}', but this is version ${PROJECT_VERSION}: it needs an entry.")
endif()
find_program(WARPSCOPE_GZIP gzip REQUIRED)
add_custom_command(
  OUTPUT ${CMAKE_BINARY_DIR}/changelog.gz
  COMMAND ${WARPSCOPE_GZIP} -9 --no-name --stdout ${changelog} > ${CMAKE_BINARY_DIR}/changelog.gz
  DEPENDS ${changelog}
  COMMENT "Compressing the changelog")
add_custom_target(changelog ALL DEPENDS ${CMAKE_BINARY_DIR}/changelog.gz)
install(FILES ${CMAKE_BINARY_DIR}/changelog.gz DESTINATION ${CMAKE_INSTALL_DOCDIR})
if(TARGET warpscope_mpi)
  install(FILES ${CMAKE_CURRENT_LIST_DIR}/copyright ${CMAKE_BINARY_DIR}/changelog.gz DESTINATION ${CMAKE_INSTALL_DOCDIR}-mpi COMPONENT mpi EXCLUDE_FROM_ALL)
endif()

include(CPack)
