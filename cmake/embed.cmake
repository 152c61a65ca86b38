include(${CMAKE_CURRENT_LIST_DIR}/embedded_text.cmake)

# svocl_embed(target name FILE... [FOLDERS folder...] [KERNELS]): compiles the text of the files into target as
# "extern const char name[]", so that no kernel or shader is read from a file at run time. Files that they include by
# #include "..." come first, each once. They are searched for in the folder of the file that includes them, then in the
# given folders, then in kernels/ and include/. A change of any of these files generates the text again. KERNELS: a
# caller puts the text before its own kernels.
function(svocl_embed target name)
  cmake_parse_arguments(PARSE_ARGV 2 embed "KERNELS" "" "FOLDERS")
  set(output ${CMAKE_CURRENT_BINARY_DIR}/embedded/${target}/${name}.c)
  set(folders ${embed_FOLDERS} ${PROJECT_SOURCE_DIR}/kernels ${PROJECT_SOURCE_DIR}/include)
  set(scripts ${PROJECT_SOURCE_DIR}/cmake/embed_file.cmake ${PROJECT_SOURCE_DIR}/cmake/embedded_text.cmake)
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${output} -DNAME=${name} "-DFILES=${embed_UNPARSED_ARGUMENTS}"
            "-DFOLDERS=${folders}" -DKERNELS=${embed_KERNELS} -P ${PROJECT_SOURCE_DIR}/cmake/embed_file.cmake
    DEPENDS ${embed_UNPARSED_ARGUMENTS} ${scripts}
    DEPFILE ${output}.d
    COMMENT "Embedding ${name}"
    VERBATIM)
  target_sources(${target} PRIVATE ${output})
endfunction()

# svocl_kernel_files(variable): the files of kernels/ and the public headers that they include.
function(svocl_kernel_files variable)
  file(GLOB files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/kernels/*/*.cl ${PROJECT_SOURCE_DIR}/kernels/*/*.clh
       ${PROJECT_SOURCE_DIR}/kernels/*/*.h)
  foreach(header light_types probe_types ray_types record scene_types tree_types)
    list(APPEND files ${PROJECT_SOURCE_DIR}/include/svocl/${header}.h)
  endforeach()
  set(${variable} ${files} PARENT_SCOPE)
endfunction()

# svocl_embed_kernels(target): compiles each of these files into target as an object of its own, svo_i_text_...
# (lib/core/kernel_text.h). Programs of static libraries contain what their kernels use.
function(svocl_embed_kernels target)
  set(folders ${PROJECT_SOURCE_DIR}/kernels ${PROJECT_SOURCE_DIR}/include)
  set(scripts ${PROJECT_SOURCE_DIR}/cmake/embed_kernel.cmake ${PROJECT_SOURCE_DIR}/cmake/embedded_text.cmake)
  svocl_kernel_files(files)
  foreach(file IN LISTS files)
    cmake_path(GET file PARENT_PATH folder)
    cmake_path(GET folder FILENAME room)
    cmake_path(GET file FILENAME name)
    set(output ${CMAKE_CURRENT_BINARY_DIR}/embedded/${target}/${room}/${name}.c)
    add_custom_command(
      OUTPUT ${output}
      COMMAND ${CMAKE_COMMAND} -DOUTPUT=${output} -DFILE=${file} "-DFOLDERS=${folders}" -P
              ${PROJECT_SOURCE_DIR}/cmake/embed_kernel.cmake
      DEPENDS ${file} ${scripts}
      COMMENT "Embedding ${room}/${name}"
      VERBATIM)
    target_sources(${target} PRIVATE ${output})
  endforeach()
endfunction()

# svocl_list_kernels(target name): compiles a list of these objects into target, for a test of all of them, as
# "extern const svo_i_kernel_text *const name[]", which ends with NULL.
function(svocl_list_kernels target name)
  set(FOLDERS ${PROJECT_SOURCE_DIR}/kernels ${PROJECT_SOURCE_DIR}/include)
  svocl_kernel_files(files)
  set(declared "")
  set(listed "")
  foreach(file IN LISTS files)
    svocl_kernel_name(${file} symbol)
    svocl_kernel_symbol(${symbol} symbol)
    string(APPEND declared "extern const svo_i_kernel_text ${symbol};\n")
    string(APPEND listed "&${symbol},\n")
  endforeach()
  set(output ${CMAKE_CURRENT_BINARY_DIR}/embedded/${target}/${name}.c)
  set(type "svo_i_kernel_text *const ${name}[]")
  file(CONFIGURE OUTPUT ${output} @ONLY CONTENT
       "#include \"core/kernel_text.h\"\n${declared}extern const ${type};\nconst ${type} = {\n${listed}NULL};\n")
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
