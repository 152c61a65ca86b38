# Writes OUTPUT, a C file with the kernel file FILE as the object svo_i_text_NAME (lib/core/kernel_text.h), where NAME is
# the file's path below one of FOLDERS with "_" for what is no letter or digit. The files that it names in
# #include "..." are searched for in its own folder, then in FOLDERS.
cmake_minimum_required(VERSION 3.22)
include(${CMAKE_CURRENT_LIST_DIR}/embedded_text.cmake)

file(REAL_PATH ${FILE} path)
svocl_kernel_name(${path} name)
svocl_kernel_symbol(${name} symbol)
file(READ ${path} text)
svocl_take_includes(text ${path} included)
svocl_shorten_kernel(text ${name})
svocl_bytes_of_text("${text}" bytes)

set(declared "")
set(listed "")
foreach(file IN LISTS included)
  svocl_kernel_name(${file} other)
  svocl_kernel_symbol(${other} other)
  string(APPEND declared "extern const svo_i_kernel_text ${other};\n")
  string(APPEND listed "&${other}, ")
endforeach()
file(
  WRITE ${OUTPUT}.tmp
  "#include \"core/kernel_text.h\"\n${declared}extern const svo_i_kernel_text ${symbol};\n"
  "static const char text[] = {\n${bytes}0};\n"
  "static const svo_i_kernel_text *const includes[] = {${listed}NULL};\n"
  "const svo_i_kernel_text ${symbol} = {text, includes};\n")
file(RENAME ${OUTPUT}.tmp ${OUTPUT})
