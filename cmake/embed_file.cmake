# Writes OUTPUT, a C file with the text of FILES as the NUL-terminated array NAME, and OUTPUT.d, which lists the files
# that were read. A file named in #include "..." comes once, before the first file that includes it, regardless of #if
# around that line. It is searched for in the folder of the file that includes it, then in FOLDERS. The #include "..."
# lines are removed; #include <...> lines are kept.
cmake_minimum_required(VERSION 3.22)

# find_included(name file variable): sets variable to the path that `#include "name"` in file refers to.
function(find_included name file variable)
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

# append_file(path): appends the files that the file includes, then the file, to the global property EMBEDDED_TEXT.
function(append_file path)
  get_property(paths GLOBAL PROPERTY EMBEDDED_PATHS)
  if(path IN_LIST paths)
    return()
  endif()
  set_property(GLOBAL APPEND PROPERTY EMBEDDED_PATHS ${path})
  file(READ ${path} text)
  set(text "\n${text}")
  string(REGEX MATCHALL "\n#include \"[^\"\n]*" includes "${text}")
  foreach(include IN LISTS includes)
    string(REGEX REPLACE ".*\"" "" name "${include}")
    find_included(${name} ${path} included)
    append_file(${included})
  endforeach()
  string(REGEX REPLACE "\n#include \"[^\n]*" "\n" text "${text}")
  set_property(GLOBAL APPEND_STRING PROPERTY EMBEDDED_TEXT "${text}")
endfunction()

foreach(file IN LISTS FILES)
  file(REAL_PATH ${file} path)
  append_file(${path})
endforeach()

get_property(text GLOBAL PROPERTY EMBEDDED_TEXT)
string(HEX "${text}" hex)
string(REGEX REPLACE "(..)" "0x\\1," bytes "${hex}")
string(REPEAT "." 100 line)
string(REGEX REPLACE "(${line})" "\\1\n" bytes "${bytes}")
# As numbers, bytes above 127 do not fit a signed char.
string(REGEX REPLACE "0x([89a-f].)," "'\\\\x\\1'," bytes "${bytes}")
file(WRITE ${OUTPUT}.tmp "extern const char ${NAME}[];\nconst char ${NAME}[] = {\n${bytes}0};\n")
file(RENAME ${OUTPUT}.tmp ${OUTPUT})

get_property(paths GLOBAL PROPERTY EMBEDDED_PATHS)
list(TRANSFORM paths REPLACE " " "\\\\ ")
list(JOIN paths " \\\n  " dependencies)
string(REPLACE " " "\\ " target "${OUTPUT}")
file(WRITE ${OUTPUT}.d "${target}: \\\n  ${dependencies}\n")
