# A portable build's way to fast instructions: this library is compiled several times, and the dynamic loader takes the best that the processor
# has, before the program starts (GNU C Library, "glibc-hwcaps"; x86-64 psABI, "Micro-Architecture Levels"). So whole files are compiled for one
# level, inline functions included, no code chooses, and none of one level can be linked into another. Where a loader does not know of this, or a
# processor has none of the levels, lib/libwarpscope_render.so itself is taken, compiled for WARPSCOPE_MARCH.
set(libraries ${CMAKE_BINARY_DIR}/lib)

# Calls within the library stay within it: as fast as in a static one. Not so data, of which the program may have the one copy.
function(warpscope_make_private target)
  target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-fvisibility-inlines-hidden -fno-semantic-interposition>)
  target_link_options(${target} PRIVATE LINKER:-Bsymbolic-functions)
endfunction()

warpscope_make_private(warpscope_render)
set_target_properties(warpscope_render PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${libraries} INSTALL_RPATH $ORIGIN)
if(WARPSCOPE_HAS_CUDA)
  # It and render/ call each other; what it takes from there, it takes from the level that the loader has chosen.
  warpscope_make_private(warpscope_cuda)
  set_target_properties(warpscope_cuda PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${libraries})
endif()
foreach(level IN LISTS WARPSCOPE_LEVELS)
  set(target warpscope_render_${level})
  get_target_property(sources warpscope_render SOURCES)
  add_library(${target} SHARED ${sources})
  foreach(property LINK_LIBRARIES INCLUDE_DIRECTORIES COMPILE_DEFINITIONS COMPILE_OPTIONS LINK_OPTIONS)
    get_target_property(value warpscope_render ${property})
    if(value)
      set_target_properties(${target} PROPERTIES ${property} "${value}")
    endif()
  endforeach()
  target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-march=${level}>)
  set_target_properties(${target} PROPERTIES
    OUTPUT_NAME warpscope_render
    LIBRARY_OUTPUT_DIRECTORY ${libraries}/glibc-hwcaps/${level}
    INSTALL_RPATH $ORIGIN/../..)
  add_dependencies(warpscope_render ${target})  # who builds the one wants them all
endforeach()
