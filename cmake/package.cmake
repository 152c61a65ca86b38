# Debian packages by CPack, from the components of cmake/install.cmake: the shared libraries, whose package has their
# version in its name, libsvocl-dev, svocl, the program, svocl-lab, what checks and measures, and python3-svocl.
# `tools/dev deb` configures, builds and tests them. Of a static build there is no package of the libraries.
set(CPACK_PACKAGE_NAME svocl)
set(CPACK_PACKAGE_VENDOR "The svocl authors")
# Who makes packages is responsible for them. The address of the default is one that no mail can reach (RFC 2606).
set(SVOCL_PACKAGE_MAINTAINER "The svocl authors <authors@svocl.invalid>"
    CACHE STRING "maintainer of the packages: NAME <ADDRESS>")
if(NOT SVOCL_PACKAGE_MAINTAINER MATCHES "^[^<>]*[^<> ] <[^<>@ ]+@[^<>@ ]+\\.[^<>@ ]+>$")
  message(FATAL_ERROR "SVOCL_PACKAGE_MAINTAINER is \"${SVOCL_PACKAGE_MAINTAINER}\" and not NAME <ADDRESS>")
endif()
set(CPACK_PACKAGE_CONTACT ${SVOCL_PACKAGE_MAINTAINER})
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
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/debian_files.cmake)

# What each package has in /usr/share/doc: the license in Debian's form, and the changelog of the package.
file(READ ${PROJECT_SOURCE_DIR}/LICENSE svocl_license)
string(REGEX MATCH "Copyright \\(c\\) ([^\n]*)\n+(.*)$" svocl_license "${svocl_license}")
set(svocl_copyright "${CMAKE_MATCH_1}")
string(STRIP "${CMAKE_MATCH_2}" svocl_license)
string(REPLACE "\n\n" "\n.\n" svocl_license "\n${svocl_license}")
string(REPLACE "\n" "\n " svocl_license "${svocl_license}")
string(SUBSTRING "${svocl_license}" 1 -1 svocl_license)
string(TIMESTAMP svocl_date "%a, %d %b %Y %H:%M:%S +0000" UTC) # by SOURCE_DATE_EPOCH, if it is set
foreach(svocl_file IN ITEMS copyright changelog)
  configure_file(cmake/debian-${svocl_file}.in ${PROJECT_BINARY_DIR}/debian-${svocl_file} @ONLY)
endforeach()

# svocl_package(component name section what): the component becomes the package of that name, with its license and its
# changelog where Debian has them; `cmake --install` leaves those out.
function(svocl_package component name section what)
  string(TOUPPER ${component} prefix)
  set(CPACK_DEBIAN_${prefix}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${prefix}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_COMPONENT_${prefix}_DESCRIPTION "${svocl_description}\nThis package has ${what}." PARENT_SCOPE)
  set(folder ${CMAKE_INSTALL_DATAROOTDIR}/doc/${name})
  install(FILES ${PROJECT_BINARY_DIR}/debian-copyright DESTINATION ${folder} RENAME copyright COMPONENT ${component}
          EXCLUDE_FROM_ALL)
  install(FILES ${PROJECT_BINARY_DIR}/debian-changelog DESTINATION ${folder} RENAME changelog.Debian
          COMPONENT ${component} EXCLUDE_FROM_ALL)
endfunction()

svocl_package(svocl_development libsvocl-dev libdevel "headers and CMake files for programs that use it")
set(CPACK_DEBIAN_SVOCL_DEVELOPMENT_PACKAGE_DEPENDS "ocl-icd-opencl-dev | opencl-dev")
if(svocl_static)
  if(SVOCL_IO)
    string(APPEND CPACK_DEBIAN_SVOCL_DEVELOPMENT_PACKAGE_DEPENDS ", libassimp-dev, libcjson-dev, libzstd-dev")
    if(svocl_svx_modules)
      string(APPEND CPACK_DEBIAN_SVOCL_DEVELOPMENT_PACKAGE_DEPENDS ", libzip-dev, libexpat1-dev")
    endif()
    if(SVOCL_ZLIB_FOUND)
      string(APPEND CPACK_DEBIAN_SVOCL_DEVELOPMENT_PACKAGE_DEPENDS ", zlib1g-dev")
    endif()
    if(SVOCL_BLOSC_FOUND)
      string(APPEND CPACK_DEBIAN_SVOCL_DEVELOPMENT_PACKAGE_DEPENDS ", libblosc-dev")
    endif()
  endif()
else()
  list(APPEND CPACK_COMPONENTS_ALL svocl_library)
  svocl_package(svocl_library libsvocl${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} libs "its shared libraries")
  set(CPACK_DEBIAN_SVOCL_LIBRARY_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/cmake/libsvocl/triggers)
  set(CPACK_DEBIAN_SVOCL_LIBRARY_PACKAGE_RECOMMENDS "${svocl_opencl_package}")
  set(CPACK_DEBIAN_SVOCL_LIBRARY_PACKAGE_SUGGESTS "libegl1, libgl1-mesa-dri") # svocl::gl opens them
  set(CPACK_COMPONENT_SVOCL_DEVELOPMENT_DEPENDS svocl_library)
endif()
if(SVOCL_TOOLS)
  list(APPEND CPACK_COMPONENTS_ALL svocl_tools)
  svocl_package(svocl_tools svocl graphics "its program")
  set(CPACK_DEBIAN_SVOCL_TOOLS_PACKAGE_RECOMMENDS "${svocl_opencl_package}")
  set(CPACK_DEBIAN_SVOCL_TOOLS_PACKAGE_SUGGESTS "svocl-lab") # `svocl bench`, `report`, `stress`, `verify`, `reference`
  list(APPEND CPACK_COMPONENTS_ALL svocl_lab)
  svocl_package(svocl_lab svocl-lab graphics "what its program runs to check and to measure")
  set(CPACK_DEBIAN_SVOCL_LAB_PACKAGE_RECOMMENDS "libembree3-3") # `svocl bench rays --vs embree` opens it
  if(EXISTS ${EMBREE_INCLUDE_DIR}/embree4/rtcore.h)
    set(CPACK_DEBIAN_SVOCL_LAB_PACKAGE_RECOMMENDS "libembree4-4")
  endif()
  set(CPACK_COMPONENT_SVOCL_LAB_DEPENDS svocl_tools)
  if(NOT svocl_static)
    set(CPACK_COMPONENT_SVOCL_TOOLS_DEPENDS svocl_library)
    list(APPEND CPACK_COMPONENT_SVOCL_LAB_DEPENDS svocl_library)
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
