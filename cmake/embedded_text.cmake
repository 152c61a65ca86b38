# What cmake/embed_file.cmake and cmake/embed_kernel.cmake have in common: included files, short texts, texts as C.

# svocl_find_included(name file variable): sets variable to the path that `#include "name"` in file refers to: in the
# file's folder, else in FOLDERS.
function(svocl_find_included name file variable)
  cmake_path(GET file PARENT_PATH own_folder)
  foreach(folder IN LISTS own_folder FOLDERS)
    if(EXISTS ${folder}/${name})
      file(REAL_PATH ${folder}/${name} path)
      set(${variable} ${path} PARENT_SCOPE)
      return()
    endif()
  endforeach()
  message(FATAL_ERROR "${file}: \"${name}\" is not in ${own_folder};${FOLDERS}")
endfunction()

# svocl_take_includes(text file paths): empties the #include "..." lines of the text of file, and sets paths to the files
# that they name.
function(svocl_take_includes text_variable file paths)
  set(found "")
  set(content "\n${${text_variable}}")
  string(REGEX MATCHALL "\n#include \"[^\"\n]*" includes "${content}")
  foreach(include IN LISTS includes)
    string(REGEX REPLACE ".*\"" "" name "${include}")
    svocl_find_included(${name} ${file} included)
    list(APPEND found ${included})
  endforeach()
  string(REGEX REPLACE "\n#include \"[^\n]*" "\n" content "${content}")
  string(SUBSTRING "${content}" 1 -1 content)
  set(${text_variable} "${content}" PARENT_SCOPE)
  set(${paths} "${found}" PARENT_SCOPE)
endfunction()

# svocl_kernel_name(path variable): the path of a kernel file below one of FOLDERS: "stages/scan.cl".
function(svocl_kernel_name path variable)
  foreach(folder IN LISTS FOLDERS)
    cmake_path(IS_PREFIX folder ${path} NORMALIZE is_below)
    if(is_below)
      file(RELATIVE_PATH name ${folder} ${path})
      set(${variable} ${name} PARENT_SCOPE)
      return()
    endif()
  endforeach()
  message(FATAL_ERROR "${path} is not in ${FOLDERS}")
endfunction()

# svocl_kernel_symbol(name variable): the object of that kernel file: svo_i_text_stages_scan_cl.
function(svocl_kernel_symbol name variable)
  string(REGEX REPLACE "[^A-Za-z0-9]" "_" symbol "${name}")
  set(${variable} svo_i_text_${symbol} PARENT_SCOPE)
endfunction()

# svocl_shorten_kernel(text name): takes comments and alignment out of the text of a kernel file and puts a #line with
# its name before it. Lines keep their numbers, so that messages of compilers tell where they are.
function(svocl_shorten_kernel text_variable name)
  set(rest "${${text_variable}}")
  set(short "#line 1 \"${name}\"\n")
  string(FIND "${rest}" "/*" begin)
  while(NOT begin EQUAL -1)
    string(SUBSTRING "${rest}" 0 ${begin} before)
    string(SUBSTRING "${rest}" ${begin} -1 rest)
    string(FIND "${rest}" "*/" end)
    string(SUBSTRING "${rest}" 0 ${end} comment)
    math(EXPR end "${end} + 2")
    string(SUBSTRING "${rest}" ${end} -1 rest)
    string(REGEX REPLACE "[^\n]+" "" lines "${comment}")
    string(APPEND short "${before}${lines}")
    string(FIND "${rest}" "/*" begin)
  endwhile()
  string(APPEND short "${rest}")
  string(REGEX REPLACE "    " "\t" short "${short}")
  string(REGEX REPLACE "[ \t]+\n" "\n" short "${short}")
  string(REGEX REPLACE "([^\n\t ])[ \t][ \t]+" "\\1 " short "${short}")
  set(${text_variable} "${short}" PARENT_SCOPE)
endfunction()

# svocl_bytes_of_text(text variable): the elements of a C array of char, each followed by a comma.
function(svocl_bytes_of_text text variable)
  string(HEX "${text}" hex)
  string(REGEX REPLACE "(..)" "0x\\1," bytes "${hex}")
  string(REPEAT "." 100 line)
  string(REGEX REPLACE "(${line})" "\\1\n" bytes "${bytes}")
  # As numbers, bytes above 127 do not fit a signed char.
  string(REGEX REPLACE "0x([89a-f].)," "'\\\\x\\1'," bytes "${bytes}")
  set(${variable} "${bytes}" PARENT_SCOPE)
endfunction()
