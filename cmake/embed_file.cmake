# Writes OUTPUT, a C file with the text of FILES as the NUL-terminated array NAME, and OUTPUT.d, which lists the files
# that were read. A file named in #include "..." comes once, before the first file that includes it, regardless of #if
# around that line. It is searched for in the folder of the file that includes it, then in FOLDERS. The #include "..."
# lines are removed; #include <...> lines are kept. KERNELS: the texts are kernels that a caller puts before its own;
# they come as the library's own do, and the lines of what follows them count from 1.
cmake_minimum_required(VERSION 3.22)
include(${CMAKE_CURRENT_LIST_DIR}/embedded_text.cmake)

# append_file(path): appends the files that the file includes, then the file, to the global property EMBEDDED_TEXT.
function(append_file path)
  get_property(paths GLOBAL PROPERTY EMBEDDED_PATHS)
  if(path IN_LIST paths)
    return()
  endif()
  set_property(GLOBAL APPEND PROPERTY EMBEDDED_PATHS ${path})
  file(READ ${path} text)
  svocl_take_includes(text ${path} included)
  foreach(file IN LISTS included)
    append_file(${file})
  endforeach()
  if(KERNELS)
    svocl_kernel_name(${path} name)
    svocl_shorten_kernel(text ${name})
  endif()
  set_property(GLOBAL APPEND_STRING PROPERTY EMBEDDED_TEXT "\n${text}")
endfunction()

foreach(file IN LISTS FILES)
  file(REAL_PATH ${file} path)
  append_file(${path})
endforeach()

get_property(text GLOBAL PROPERTY EMBEDDED_TEXT)
if(KERNELS)
  set(text "/* SPDX-License-Identifier: MIT */${text}#line 1 \"caller\"\n")
endif()
svocl_bytes_of_text("${text}" bytes)
file(WRITE ${OUTPUT}.tmp "extern const char ${NAME}[];\nconst char ${NAME}[] = {\n${bytes}0};\n")
file(RENAME ${OUTPUT}.tmp ${OUTPUT})

get_property(paths GLOBAL PROPERTY EMBEDDED_PATHS)
list(TRANSFORM paths REPLACE " " "\\\\ ")
list(JOIN paths " \\\n  " dependencies)
string(REPLACE " " "\\ " target "${OUTPUT}")
file(WRITE ${OUTPUT}.d "${target}: \\\n  ${dependencies}\n")
