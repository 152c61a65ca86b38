# `svocl bench peers` measures OpenVDB if libopenvdb-dev and libboost-dev are installed. They are no part of the set-up:
# they take 15 MB to download, and one file takes most of a minute to compile. C++ is enabled for this file alone.
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
# `svocl bench voxel-rays` measures NanoVDB if libnanovdb-dev is installed, which the set-up of the tests brings for
# .nvdb files, by another such file.
set(SVOCL_NANOVDB_FOUND OFF)
if(SVOCL_OPENVDB)
  find_path(NANOVDB_INCLUDE_DIR nanovdb/util/HDDA.h)
  if(NANOVDB_INCLUDE_DIR AND CMAKE_CXX_COMPILER)
    enable_language(CXX)
    set(SVOCL_NANOVDB_FOUND ON)
  endif()
endif()
