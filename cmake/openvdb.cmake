# `svocl bench peers` measures OpenVDB when libopenvdb-dev and libboost-dev are there: 15 MB to download, and most of a minute
# to compile one file, so they are no part of the set-up. It is the program's only C++, which is enabled for it alone.
option(SVOCL_OPENVDB "measure OpenVDB in svocl bench, where it is installed" ON)
set(SVOCL_OPENVDB_FOUND OFF)
if(SVOCL_OPENVDB)
  find_path(OPENVDB_INCLUDE_DIR openvdb/tools/MeshToVolume.h)
  find_path(OPENVDB_BOOST_INCLUDE_DIR boost/numeric/conversion/conversion_traits.hpp)
  find_library(OPENVDB_LIBRARY openvdb)
  find_library(OPENVDB_TBB_LIBRARY tbb)
  find_library(OPENVDB_IMATH_LIBRARY Imath)
  include(CheckLanguage)
  check_language(CXX)
  if(OPENVDB_INCLUDE_DIR AND OPENVDB_BOOST_INCLUDE_DIR AND OPENVDB_LIBRARY AND OPENVDB_TBB_LIBRARY
     AND OPENVDB_IMATH_LIBRARY AND CMAKE_CXX_COMPILER)
    enable_language(CXX)
    set(SVOCL_OPENVDB_FOUND ON)
  endif()
endif()
