# svocl_embed(target name FILE... [FOLDERS folder...]): compiles the text of the files into target as
# "extern const char name[]", so that no kernel or shader is looked for at run time. What they include by #include "..."
# comes first, each file once. It is looked for beside the file that includes it, then in the folders, then in kernels/
# and include/. When any of these files changes, the text is made again.
function(svocl_embed target name)
  cmake_parse_arguments(PARSE_ARGV 2 embed "" "" "FOLDERS")
  set(output ${CMAKE_CURRENT_BINARY_DIR}/embedded/${target}/${name}.c)
  set(folders ${embed_FOLDERS} ${PROJECT_SOURCE_DIR}/kernels ${PROJECT_SOURCE_DIR}/include)
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${output} -DNAME=${name} "-DFILES=${embed_UNPARSED_ARGUMENTS}"
            "-DFOLDERS=${folders}" -P ${PROJECT_SOURCE_DIR}/cmake/embed_file.cmake
    DEPENDS ${embed_UNPARSED_ARGUMENTS} ${PROJECT_SOURCE_DIR}/cmake/embed_file.cmake
    DEPFILE ${output}.d
    COMMENT "Embedding ${name}"
    VERBATIM)
  target_sources(${target} PRIVATE ${output})
endfunction()
