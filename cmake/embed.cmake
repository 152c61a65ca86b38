# svocl_embed(target name FILE...): compiles the text of the files into target as "extern const char name[]", in the
# given order, so that no kernel or shader is looked for at run time.
function(svocl_embed target name)
  set(output ${CMAKE_CURRENT_BINARY_DIR}/embedded/${target}/${name}.c)
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${output} -DNAME=${name} "-DFILES=${ARGN}" -P
            ${PROJECT_SOURCE_DIR}/cmake/embed_file.cmake
    DEPENDS ${ARGN} ${PROJECT_SOURCE_DIR}/cmake/embed_file.cmake
    COMMENT "Embedding ${name}"
    VERBATIM)
  target_sources(${target} PRIVATE ${output})
endfunction()
