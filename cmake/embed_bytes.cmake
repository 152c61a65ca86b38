# Writes OUTPUT, a C file with the bytes of FILE as the array NAME_bytes and their number as NAME_byte_count.
cmake_minimum_required(VERSION 3.22)

file(READ ${FILE} hex HEX)
string(LENGTH "${hex}" digits)
math(EXPR count "${digits} / 2")
string(REGEX REPLACE "(..)" "0x\\1," bytes "${hex}")
string(REPEAT "." 100 line)
string(REGEX REPLACE "(${line})" "\\1\n" bytes "${bytes}")
file(WRITE ${OUTPUT}.tmp
     "extern const unsigned char ${NAME}_bytes[];\nextern const unsigned ${NAME}_byte_count;\n"
     "const unsigned ${NAME}_byte_count = ${count};\nconst unsigned char ${NAME}_bytes[] = {\n${bytes}};\n")
file(RENAME ${OUTPUT}.tmp ${OUTPUT})
