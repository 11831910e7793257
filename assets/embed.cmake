# warpscope_embed(TARGET NAMESPACE FILE...): compiles files into TARGET, so that the program needs no data folder at run time.
# Each becomes one entry of warpscope::NAMESPACE::files(); see the generated header NAMESPACE.h.
set(WARPSCOPE_EMBED_SCRIPT ${CMAKE_CURRENT_LIST_DIR}/embed_files.cmake)

function(warpscope_embed target namespace)
  set(directory ${CMAKE_CURRENT_BINARY_DIR}/embedded)
  set(output ${directory}/${namespace})
  set(files ${ARGN})
  list(TRANSFORM files PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ REGEX "^[^/]")  # the script runs in the build folder
  list(JOIN files "|" joined)
  add_custom_command(
    OUTPUT ${output}.cpp ${output}.h
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${output} -DNAMESPACE=${namespace} "-DFILES=${joined}" -P ${WARPSCOPE_EMBED_SCRIPT}
    DEPENDS ${files} ${WARPSCOPE_EMBED_SCRIPT}
    COMMENT "Embedding ${namespace}"
    VERBATIM)
  target_sources(${target} PRIVATE ${output}.cpp ${output}.h)
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${directory}>)
endfunction()
