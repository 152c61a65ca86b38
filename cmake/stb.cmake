# stb: svocl::io compiles stb_image into itself, tools, tests and Dear ImGui use svocl_stb. Systems have its headers in a
# folder stb (Debian, Fedora, Arch) or straight among the others (vcpkg, Conan, a copy), where the folder is made here.
find_path(SVOCL_STB_INCLUDE_DIR NAMES stb/stb_image.h stb_image.h
          DOC "where stb/stb_image.h or stb_image.h of stb lies, with stb's other headers")
if(NOT EXISTS ${SVOCL_STB_INCLUDE_DIR}/stb/stb_image.h AND NOT EXISTS ${SVOCL_STB_INCLUDE_DIR}/stb_image.h)
  message(FATAL_ERROR "svocl::io and the programs need the headers of stb, stb_image.h and others, which were not found "
                      "(SVOCL_STB_INCLUDE_DIR is \"${SVOCL_STB_INCLUDE_DIR}\"). Debian has them in libstb-dev. Its library is not needed.")
endif()
set(svocl_stb_folder ${SVOCL_STB_INCLUDE_DIR})
if(NOT EXISTS ${SVOCL_STB_INCLUDE_DIR}/stb/stb_image.h)
  set(svocl_stb_folder ${CMAKE_CURRENT_BINARY_DIR}/stb_headers)
  file(GLOB svocl_stb_headers ${SVOCL_STB_INCLUDE_DIR}/stb_*.h)
  foreach(header IN LISTS svocl_stb_headers)
    cmake_path(GET header FILENAME name)
    file(CONFIGURE OUTPUT ${svocl_stb_folder}/stb/${name} CONTENT "#include \"${header}\"\n" @ONLY)
  endforeach()
endif()

# svocl_add_stb(): the target svocl_stb, what tools and tests call of stb. Not every system has it as a library; where
# it is none, it is compiled here from its headers.
function(svocl_add_stb)
  find_library(STB_LIBRARY stb)
  if(STB_LIBRARY)
    add_library(svocl_stb INTERFACE)
    target_include_directories(svocl_stb SYSTEM INTERFACE ${svocl_stb_folder})
    target_link_libraries(svocl_stb INTERFACE ${STB_LIBRARY})
  else()
    add_library(svocl_stb STATIC ${PROJECT_SOURCE_DIR}/tools/support/stb.c)
    target_include_directories(svocl_stb SYSTEM PUBLIC ${svocl_stb_folder})
    target_link_libraries(svocl_stb PUBLIC m)
  endif()
endfunction()
