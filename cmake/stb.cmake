# svocl_stb: what tools and tests call of stb's headers (libstb-dev), compiled here, since not every system has them as a
# library. The import compiles its own copy of stb_image.
find_path(STB_INCLUDE_DIR stb/stb_image_write.h REQUIRED)
add_library(svocl_stb STATIC tools/support/stb.c)
target_include_directories(svocl_stb SYSTEM PUBLIC ${STB_INCLUDE_DIR})
target_link_libraries(svocl_stb PUBLIC m)
