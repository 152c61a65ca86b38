# Installs the libraries, their headers, a CMake package, pkg-config files and the program. Each library has its own
# export, so that users of svocl::svocl need OpenCL only, not the dependencies of svocl::gl and svocl::io.
include(CMakePackageConfigHelpers)
set(svocl_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/svocl)
set(svocl_pkgconfig_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
# The relative path from the pkg-config files to the prefix, so that the installed tree can be moved.
string(REGEX REPLACE "[^/]+" ".." svocl_pkgconfig_to_prefix ${svocl_pkgconfig_dir})

# svocl_install_library(target component name): installs target as svocl::component with svocl-component.cmake and
# name.pc.
function(svocl_install_library target component name)
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${component} VERSION ${PROJECT_VERSION}
                                             SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  install(
    TARGETS ${target}
    EXPORT ${name}
    INCLUDES
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT ${name} NAMESPACE svocl:: FILE svocl-${component}.cmake DESTINATION ${svocl_package_dir})
  configure_file(${PROJECT_SOURCE_DIR}/cmake/${name}.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${svocl_pkgconfig_dir})
endfunction()

svocl_install_library(svocl svocl svocl)
if(SVOCL_GL)
  svocl_install_library(svocl_gl gl svocl-gl)
endif()
if(SVOCL_IO)
  svocl_install_library(svocl_io io svocl-io)
endif()

install(
  DIRECTORY include/svocl
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING
  PATTERN "*.h")
configure_package_config_file(cmake/svocl-config.cmake.in ${PROJECT_BINARY_DIR}/svocl-config.cmake
                              INSTALL_DESTINATION ${svocl_package_dir})
# Before 1.0 a minor version may change the API.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/svocl-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/svocl-config.cmake ${PROJECT_BINARY_DIR}/svocl-config-version.cmake
        DESTINATION ${svocl_package_dir})
