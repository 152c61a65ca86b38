# Writes a C file that holds the text of FILES as a NUL-terminated array of bytes. Lines #include "..." are left out:
# the order of FILES takes their place.
set(all "")
foreach(file IN LISTS FILES)
  file(READ ${file} text)
  string(APPEND all "\n${text}")
endforeach()
string(REGEX REPLACE "\n#include \"[^\n]*" "\n" all "${all}")
string(HEX "${all}" hex)
string(REGEX REPLACE "(..)" "0x\\1," bytes "${hex}")
string(REPEAT "." 100 line)
string(REGEX REPLACE "(${line})" "\\1\n" bytes "${bytes}")
# Bytes above 127 do not fit a signed char as numbers.
string(REGEX REPLACE "0x([89a-f].)," "'\\\\x\\1'," bytes "${bytes}")
file(WRITE ${OUTPUT}.tmp "extern const char ${NAME}[];\nconst char ${NAME}[] = {\n${bytes}0};\n")
file(RENAME ${OUTPUT}.tmp ${OUTPUT})
