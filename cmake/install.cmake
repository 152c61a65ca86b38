# Installs the libraries, their headers, a CMake package, pkg-config files and the programs, and makes the target
# `uninstall`. Each library has its own export, so that users of svocl::svocl need OpenCL only, not the dependencies of
# svocl::gl and svocl::io. The components svocl_library, svocl_development, svocl_tools, svocl_lab and svocl_python
# become packages.
include(CMakePackageConfigHelpers)
set(svocl_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/svocl)
set(svocl_pkgconfig_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
# The relative path from the pkg-config files to the prefix, so that the installed tree can be moved.
file(RELATIVE_PATH svocl_pkgconfig_to_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
get_target_property(svocl_type svocl TYPE)
# What users of static libraries define and link; shared ones bring it themselves.
set(svocl_static FALSE)
set(svocl_pkgconfig_definitions "")
set(svocl_pkgconfig_io_libraries "")
if(svocl_type STREQUAL "STATIC_LIBRARY")
  set(svocl_static TRUE)
  set(svocl_pkgconfig_definitions " -DSVO_STATIC")
  list(JOIN svocl_io_libraries " " svocl_pkgconfig_io_libraries)
endif()

# svocl_install_library(target component name): installs target as svocl::component with svocl-component.cmake and
# name.pc.
function(svocl_install_library target component name)
  install(
    TARGETS ${target}
    EXPORT ${name}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
            COMPONENT svocl_library
            NAMELINK_COMPONENT svocl_development
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT svocl_development
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT svocl_library
    INCLUDES
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(
    EXPORT ${name}
    NAMESPACE svocl::
    FILE svocl-${component}.cmake
    DESTINATION ${svocl_package_dir}
    COMPONENT svocl_development)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/${name}.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
  install(
    FILES ${PROJECT_BINARY_DIR}/${name}.pc
    DESTINATION ${svocl_pkgconfig_dir}
    COMPONENT svocl_development)
endfunction()

svocl_install_library(svocl svocl svocl)
if(SVOCL_GL)
  svocl_install_library(svocl_gl gl svocl-gl)
endif()
if(SVOCL_IO)
  svocl_install_library(svocl_io io svocl-io)
  install(TARGETS svocl_import_helper RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/svocl COMPONENT svocl_library)
endif()
if(SVOCL_TOOLS)
  svocl_run_in_place(svocl_program ${CMAKE_INSTALL_BINDIR})
  svocl_run_in_place(svocl_lab ${CMAKE_INSTALL_BINDIR})
  install(TARGETS svocl_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT svocl_tools)
  install(TARGETS svocl_lab RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT svocl_lab)
endif()
if(SVOCL_PYTHON)
  set(svocl_python_dir lib/python3/dist-packages) # where Debian's Python looks, for all its versions
  svocl_run_in_place(svocl_python ${svocl_python_dir}/svocl)
  install(TARGETS svocl_python LIBRARY DESTINATION ${svocl_python_dir}/svocl COMPONENT svocl_python)
  install(FILES ${svocl_python_types} DESTINATION ${svocl_python_dir}/svocl COMPONENT svocl_python)
  install(FILES ${svocl_python_page} DESTINATION ${svocl_python_dir}/svocl/page COMPONENT svocl_python)
  install(
    DIRECTORY python/src/svocl
    DESTINATION ${svocl_python_dir}
    COMPONENT svocl_python
    FILES_MATCHING
    PATTERN "*.py*"
    PATTERN py.typed
    PATTERN __pycache__ EXCLUDE)
  # For importlib.metadata and pip, which then see that the package is there.
  configure_file(cmake/python-metadata.in ${PROJECT_BINARY_DIR}/METADATA @ONLY)
  install(
    FILES ${PROJECT_BINARY_DIR}/METADATA
    DESTINATION ${svocl_python_dir}/svocl-${PROJECT_VERSION}.dist-info
    COMPONENT svocl_python)
endif()

install(
  DIRECTORY include/svocl
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  COMPONENT svocl_development
  FILES_MATCHING
  PATTERN "*.h")
configure_package_config_file(cmake/svocl-config.cmake.in ${PROJECT_BINARY_DIR}/svocl-config.cmake
                              INSTALL_DESTINATION ${svocl_package_dir})
# Before 1.0 a minor version may change the API.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/svocl-config-version.cmake COMPATIBILITY SameMinorVersion)
install(
  FILES ${PROJECT_BINARY_DIR}/svocl-config.cmake ${PROJECT_BINARY_DIR}/svocl-config-version.cmake
        ${PROJECT_SOURCE_DIR}/cmake/svocl-hash-test.cmake
  DESTINATION ${svocl_package_dir}
  COMPONENT svocl_development)

# In a project that svocl is a part of, this name is the project's.
if(PROJECT_IS_TOP_LEVEL)
  add_custom_target(
    uninstall
    COMMAND ${CMAKE_COMMAND} -DBUILD_DIR=${PROJECT_BINARY_DIR} -P ${PROJECT_SOURCE_DIR}/cmake/uninstall.cmake
    COMMENT "Removing what was installed last"
    VERBATIM)
endif()
