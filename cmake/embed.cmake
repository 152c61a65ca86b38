# svocl_embed(target name FILE... [FOLDERS folder...]): compiles the text of the files into target as
# "extern const char name[]", so that no kernel or shader is read from a file at run time. Files that they include by
# #include "..." come first, each once. They are searched for in the folder of the file that includes them, then in the
# given folders, then in kernels/ and include/. A change of any of these files generates the text again.
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

# svocl_embed_bytes(target name file): compiles the bytes of a file into target as "extern const unsigned char
# name_bytes[]", with their number in "extern const unsigned name_byte_count".
function(svocl_embed_bytes target name file)
  set(output ${CMAKE_CURRENT_BINARY_DIR}/embedded/${target}/${name}.c)
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${output} -DNAME=${name} -DFILE=${file} -P
            ${PROJECT_SOURCE_DIR}/cmake/embed_bytes.cmake
    DEPENDS ${file} ${PROJECT_SOURCE_DIR}/cmake/embed_bytes.cmake
    COMMENT "Embedding ${name}"
    VERBATIM)
  target_sources(${target} PRIVATE ${output})
endfunction()
