# A shared svocl: built without tests and samples, it exports what is listed, is installed, runs from wherever the
# installation lies without LD_LIBRARY_PATH, and is removed again by the target `uninstall`.
# SOURCE_DIR, WORK_DIR, C_COMPILER and GENERATOR come from the command line.
include(${CMAKE_CURRENT_LIST_DIR}/common.cmake)
set(build ${WORK_DIR}/build)
set(prefix ${WORK_DIR}/prefix)
file(REMOVE_RECURSE ${WORK_DIR})
unset(ENV{LD_LIBRARY_PATH})

# Unoptimized, for it is the installation that is tested.
run(${CMAKE_COMMAND} -S ${SOURCE_DIR} -B ${build} -G ${GENERATOR} -DCMAKE_C_COMPILER=${C_COMPILER}
    -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG=-O0 -DCMAKE_INSTALL_PREFIX=${prefix} -DBUILD_SHARED_LIBS=ON
    -DSVOCL_TESTS=OFF -DSVOCL_SAMPLES=OFF -DSVOCL_EMBREE=OFF -DSVOCL_OPENVDB=OFF)
run(${CMAKE_COMMAND} --build ${build})
run(${CMAKE_COMMAND} --install ${build})
file(GLOB_RECURSE svocl ${prefix}/libsvocl.so)
file(GLOB_RECURSE gl ${prefix}/libsvocl_gl.so)
file(GLOB_RECURSE io ${prefix}/libsvocl_io.so)
run(${SOURCE_DIR}/tests/exports/exports.sh ${SOURCE_DIR} ${svocl} ${gl} ${io})

# Moved away from where it was installed, and out of reach of the build folder.
file(COPY ${prefix} DESTINATION ${WORK_DIR}/moved)
set(moved ${WORK_DIR}/moved/prefix)
file(RENAME ${build} ${build}.away)
file(RENAME ${prefix} ${prefix}.away)
run(${moved}/bin/svocl --version)
expect_match("svocl --version" "${out}" "${VERSION}")
run(ldd ${moved}/bin/svocl)
foreach(library libsvocl libsvocl_gl libsvocl_io)
  expect_match("what the program loads" "${out}" "${library}[.]so[.][0-9.]* => ${moved}/[^ ]*/${library}[.]so")
endforeach()
file(COPY ${SOURCE_DIR}/samples/01_minimal/main.c ${SOURCE_DIR}/tests/install/consumer/CMakeLists.txt
     DESTINATION ${WORK_DIR}/consumer)
run(${CMAKE_COMMAND} -S ${WORK_DIR}/consumer -B ${WORK_DIR}/consumer/build -G ${GENERATOR}
    -DCMAKE_C_COMPILER=${C_COMPILER} -DCMAKE_PREFIX_PATH=${moved})
run(${CMAKE_COMMAND} --build ${WORK_DIR}/consumer/build)
run(${WORK_DIR}/consumer/build/voxels)
expect_match("the output of the program" "${out}" "^96776 leaves, 128073 nodes, hash ")
file(RENAME ${build}.away ${build})
file(RENAME ${prefix}.away ${prefix})

run(${CMAKE_COMMAND} --build ${build} --target uninstall)
expect_no_file(${prefix} ".")
