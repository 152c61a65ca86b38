# An overlay port: svocl from the folder that this file is in, a clone or an unpacked archive.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

vcpkg_check_features(OUT_FEATURE_OPTIONS features FEATURES gl SVOCL_GL io SVOCL_IO)
vcpkg_find_acquire_program(PKGCONFIG)
# svocl::io starts a program to read meshes.
vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS ${features}
          -DSVOCL_TOOLS=OFF
          -DSVOCL_TESTS=OFF
          -DSVOCL_SAMPLES=OFF
          -DCMAKE_INSTALL_LIBEXECDIR=tools
          "-DSVOCL_HELPER_FOLDER=${CURRENT_INSTALLED_DIR}/tools/svocl"
          "-DPKG_CONFIG_EXECUTABLE=${PKGCONFIG}"
  MAYBE_UNUSED_VARIABLES SVOCL_HELPER_FOLDER PKG_CONFIG_EXECUTABLE)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/svocl)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share"
     "${CURRENT_PACKAGES_DIR}/debug/tools")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
