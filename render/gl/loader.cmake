# Makes the target warpscope_glad: the OpenGL 4.5 core loader (#include <glad/gl.h>), written by glad 2 at build time.
# It takes the context's own lookup function (eglGetProcAddress, OSMesaGetProcAddress, glfwGetProcAddress): gladLoadGL(lookup).
# Core functions only: with every extension the header is four times as long, in every file that includes it.
find_program(WARPSCOPE_GLAD glad HINTS /usr/bin DOC "glad 2, the generator of OpenGL loaders")
if(NOT WARPSCOPE_GLAD)
  message(FATAL_ERROR "glad was not found; it writes the OpenGL loader. Install it (Debian: python3-glad) or set WARPSCOPE_GLAD to its path.")
endif()

set(WARPSCOPE_GLAD_DIR ${CMAKE_BINARY_DIR}/glad)
add_custom_command(
  OUTPUT ${WARPSCOPE_GLAD_DIR}/src/gl.c ${WARPSCOPE_GLAD_DIR}/include/glad/gl.h ${WARPSCOPE_GLAD_DIR}/include/KHR/khrplatform.h
  # glad belongs to the system's Python; variables meant for another one would lead it astray.
  COMMAND ${CMAKE_COMMAND} -E env --unset=PYTHONHOME --unset=PYTHONPATH
    ${WARPSCOPE_GLAD} --quiet --reproducible --api gl:core=4.5 --extensions=
    --out-path ${WARPSCOPE_GLAD_DIR} c
  COMMENT "Generating the OpenGL loader"
  VERBATIM)

add_library(warpscope_glad STATIC ${WARPSCOPE_GLAD_DIR}/src/gl.c ${WARPSCOPE_GLAD_DIR}/include/glad/gl.h)
target_include_directories(warpscope_glad SYSTEM PUBLIC ${WARPSCOPE_GLAD_DIR}/include)
set_target_properties(warpscope_glad PROPERTIES C_STANDARD 99)
