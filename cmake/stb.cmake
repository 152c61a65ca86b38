# svocl_stb: what tools, tests and Dear ImGui call of stb (libstb-dev). Not every system has it as a library; where it
# is none, it is compiled here from its headers. The import compiles its own copy of stb_image.
find_path(STB_INCLUDE_DIR stb/stb_image_write.h REQUIRED)
find_library(STB_LIBRARY stb)
if(STB_LIBRARY)
  add_library(svocl_stb INTERFACE)
  target_include_directories(svocl_stb SYSTEM INTERFACE ${STB_INCLUDE_DIR})
  target_link_libraries(svocl_stb INTERFACE ${STB_LIBRARY})
else()
  add_library(svocl_stb STATIC tools/support/stb.c)
  target_include_directories(svocl_stb SYSTEM PUBLIC ${STB_INCLUDE_DIR})
  target_link_libraries(svocl_stb PUBLIC m)
endif()
