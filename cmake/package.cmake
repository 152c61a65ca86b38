# Debian packages by CPack, from the components of cmake/install.cmake: libsvocl0.1, libsvocl-dev, svocl, the program,
# and python3-svocl. `tools/dev deb` configures, builds and tests them. Of a static build there is no libsvocl0.1.
set(CPACK_PACKAGE_NAME svocl)
set(CPACK_PACKAGE_VENDOR "The svocl authors")
if(NOT CPACK_PACKAGE_CONTACT)
  set(CPACK_PACKAGE_CONTACT "The svocl authors <authors@svocl.invalid>") # -DCPACK_PACKAGE_CONTACT=... is yours
endif()
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_SOURCE_IGNORE_FILES /[.]git /build /demo/)
set(CPACK_STRIP_FILES ON)
set(CPACK_VERBATIM_VARIABLES ON)
if(NOT CPACK_GENERATOR)
  set(CPACK_GENERATOR DEB)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib ${PROJECT_BINARY_DIR}/lib/io
                                                ${PROJECT_BINARY_DIR}/glinterop)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)

set(svocl_description
    "svocl builds sparse voxel octrees from triangle meshes with OpenCL. The octree
is exact, and it is the same on every device and in every run, bit for bit. No
GPU is needed: PoCL suffices.")
set(svocl_opencl_package "pocl-opencl-icd | opencl-icd")
set(CPACK_COMPONENTS_ALL svocl_development)

# svocl_package(component name section what): the component becomes the package of that name, with a copy of the license
# where Debian has it; `cmake --install` leaves that copy out.
function(svocl_package component name section what)
  string(TOUPPER ${component} prefix)
  set(CPACK_DEBIAN_${prefix}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${prefix}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_COMPONENT_${prefix}_DESCRIPTION "${svocl_description}\nThis package has ${what}." PARENT_SCOPE)
  install(
    FILES ${PROJECT_SOURCE_DIR}/LICENSE
    DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/${name}
    RENAME copyright
    COMPONENT ${component}
    EXCLUDE_FROM_ALL)
endfunction()

svocl_package(svocl_development libsvocl-dev libdevel "headers and CMake files for programs that use it")
set(CPACK_DEBIAN_SVOCL_DEVELOPMENT_PACKAGE_DEPENDS "ocl-icd-opencl-dev | opencl-dev")
if(svocl_static)
  if(SVOCL_IO)
    string(APPEND CPACK_DEBIAN_SVOCL_DEVELOPMENT_PACKAGE_DEPENDS ", libassimp-dev, libcjson-dev, libzstd-dev")
    if(svocl_svx_modules)
      string(APPEND CPACK_DEBIAN_SVOCL_DEVELOPMENT_PACKAGE_DEPENDS ", libzip-dev, libexpat1-dev")
    endif()
  endif()
else()
  list(APPEND CPACK_COMPONENTS_ALL svocl_library)
  svocl_package(svocl_library libsvocl${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} libs "its shared libraries")
  set(CPACK_DEBIAN_SVOCL_LIBRARY_PACKAGE_RECOMMENDS "${svocl_opencl_package}")
  set(CPACK_DEBIAN_SVOCL_LIBRARY_PACKAGE_SUGGESTS "libegl1, libgl1-mesa-dri") # svocl::gl opens them
  set(CPACK_COMPONENT_SVOCL_DEVELOPMENT_DEPENDS svocl_library)
endif()
if(SVOCL_TOOLS)
  list(APPEND CPACK_COMPONENTS_ALL svocl_tools)
  svocl_package(svocl_tools svocl graphics "its program")
  set(CPACK_DEBIAN_SVOCL_TOOLS_PACKAGE_RECOMMENDS "${svocl_opencl_package}")
  if(NOT svocl_static)
    set(CPACK_COMPONENT_SVOCL_TOOLS_DEPENDS svocl_library)
  endif()
endif()
if(SVOCL_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL svocl_python)
  svocl_package(svocl_python python3-svocl python "its Python package")
  set(CPACK_DEBIAN_SVOCL_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.9), python3-cffi, python3-numpy")
  set(CPACK_DEBIAN_SVOCL_PYTHON_PACKAGE_RECOMMENDS "${svocl_opencl_package}")
  set(CPACK_DEBIAN_SVOCL_PYTHON_PACKAGE_SUGGESTS "python3-distributed, python3-pyopencl, python3-tqdm")
  # Python compiles its files when the package is installed, and they go with it.
  set(CPACK_DEBIAN_SVOCL_PYTHON_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/cmake/python3-svocl/postinst
                                                      ${PROJECT_SOURCE_DIR}/cmake/python3-svocl/prerm)
  if(NOT svocl_static)
    set(CPACK_COMPONENT_SVOCL_PYTHON_DEPENDS svocl_library)
  endif()
endif()
include(CPack)
