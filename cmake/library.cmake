# What svocl::svocl, svocl::gl and svocl::io have in common.

# svocl_library(target component exports): target is svocl::component, whose shared library exports the symbols that the
# file `exports` lists and no others. A static library exports nothing, wherever it is linked into.
function(svocl_library target component exports)
  add_library(svocl::${component} ALIAS ${target})
  # Before 1.0 a minor version may change the ABI.
  set(abi ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${component} VERSION ${PROJECT_VERSION} SOVERSION ${abi}
                                             UNITY_BUILD OFF)
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "STATIC_LIBRARY")
    target_compile_definitions(${target} PUBLIC SVO_STATIC)
  else()
    svocl_limit_exports(${target} ${exports} SVOCL_${abi})
  endif()
  svocl_run_in_place(${target} ${CMAKE_INSTALL_LIBDIR})
  svocl_count_lines(${target})
endfunction()

# svocl_limit_exports(target list version): the linker's version script for a shared library. Symbols have a version of
# their own, so that one process can load two versions of svocl. Those of other libraries of svocl, svo_i_, stand apart.
# On Windows it is a module definition file, which knows no versions.
function(svocl_limit_exports target list version)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${list})
  if(WIN32)
    file(STRINGS ${list} names REGEX "^svo_")
    list(JOIN names "\n  " names)
    set(definition ${CMAKE_CURRENT_BINARY_DIR}/${target}.def)
    file(CONFIGURE OUTPUT ${definition} CONTENT "EXPORTS\n  ${names}\n" @ONLY)
    target_sources(${target} PRIVATE ${definition})
  endif()
  if(NOT CMAKE_SYSTEM_NAME STREQUAL "Linux")
    return()
  endif()
  file(STRINGS ${list} public REGEX "^svo_")
  set(internal ${public})
  list(FILTER public EXCLUDE REGEX "^svo_i_")
  list(FILTER internal INCLUDE REGEX "^svo_i_")
  list(JOIN public ";\n  " public)
  set(text "${version} {\nglobal:\n  ${public};\nlocal:\n  *;\n};\n")
  if(internal)
    list(JOIN internal ";\n  " internal)
    string(APPEND text "${version}_INTERNAL {\nglobal:\n  ${internal};\n};\n")
  endif()
  set(script ${CMAKE_CURRENT_BINARY_DIR}/${target}.map)
  file(CONFIGURE OUTPUT ${script} CONTENT "${text}" @ONLY)
  target_link_options(${target} PRIVATE "LINKER:--version-script=${script}")
  set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS ${script})
endfunction()

# svocl_run_in_place(target folder): target, installed into that folder below the prefix, finds the shared libraries of
# svocl wherever the prefix lies. -DCMAKE_SKIP_INSTALL_RPATH=ON and an own CMAKE_INSTALL_RPATH go first.
function(svocl_run_in_place target folder)
  if(BUILD_SHARED_LIBS AND NOT DEFINED CMAKE_INSTALL_RPATH)
    cmake_path(ABSOLUTE_PATH folder BASE_DIRECTORY ${CMAKE_INSTALL_PREFIX})
    file(RELATIVE_PATH to_libraries ${folder} ${CMAKE_INSTALL_FULL_LIBDIR})
    set(origin "$ORIGIN")
    if(APPLE)
      set(origin "@loader_path")
    endif()
    cmake_path(APPEND origin ${to_libraries})
    set_target_properties(${target} PROPERTIES INSTALL_RPATH "${origin}")
  endif()
endfunction()
