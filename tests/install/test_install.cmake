# Installs the build into an empty prefix and uses it like a new user: once through find_package, with the minimal
# sample and the CMake lines of the README, and once through pkg-config. Then removes it again.
# BUILD_DIR, SOURCE_DIR, WORK_DIR, C_COMPILER, GENERATOR and VERSION come from the command line.
include(${CMAKE_CURRENT_LIST_DIR}/common.cmake)
set(prefix ${WORK_DIR}/prefix)
string(REGEX MATCH "^[0-9]+\\.[0-9]+" minor_version ${VERSION})
file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR}/consumer ${WORK_DIR}/build)

install_to(${prefix} ${WORK_DIR}/build/install_manifest.txt)
file(GLOB_RECURSE libraries ${prefix}/libsvocl.*)
list(GET libraries 0 library)
cmake_path(GET library PARENT_PATH library_dir)

# The installed program.
run(${prefix}/bin/svocl --version)
if(NOT out MATCHES "${VERSION}")
  message(FATAL_ERROR "svocl --version printed \"${out}\", which lacks ${VERSION}")
endif()

# find_package
file(COPY ${SOURCE_DIR}/samples/01_minimal/main.c ${SOURCE_DIR}/tests/install/consumer/CMakeLists.txt
     DESTINATION ${WORK_DIR}/consumer)
run(${CMAKE_COMMAND} -S ${WORK_DIR}/consumer -B ${WORK_DIR}/consumer/build -G ${GENERATOR}
    -DCMAKE_C_COMPILER=${C_COMPILER} -DCMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${WORK_DIR}/consumer/build)
run(${WORK_DIR}/consumer/build/voxels)
if(NOT out MATCHES "^96776 leaves, 128073 nodes, hash ")
  message(FATAL_ERROR "the program built with find_package printed \"${out}\"")
endif()

# Tests of hashes: one that holds, one that does not, and a hash that is none.
file(MAKE_DIRECTORY ${WORK_DIR}/hash_test)
file(WRITE ${WORK_DIR}/hash_test/part.obj "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
set(hash_project "cmake_minimum_required(VERSION 3.22)\nproject(hashes LANGUAGES C)\nenable_testing()\n"
                 "find_package(svocl ${minor_version} REQUIRED COMPONENTS svocl)\n")
string(JOIN "" hash_project ${hash_project})
run(${prefix}/bin/svocl hash ${WORK_DIR}/hash_test/part.obj -d 3)
string(STRIP "${out}" part_hash)
set(zeros 00000000000000000000000000000000)
file(WRITE ${WORK_DIR}/hash_test/CMakeLists.txt
     "${hash_project}svocl_add_hash_test(NAME part INPUT part.obj HASH ${part_hash} OPTIONS -d 3)\n"
     "svocl_add_hash_test(NAME other INPUT scene:cube HASH ${zeros} OPTIONS -d 3 --need none)\n")
run(${CMAKE_COMMAND} -S ${WORK_DIR}/hash_test -B ${WORK_DIR}/hash_test/build -G ${GENERATOR}
    -DCMAKE_C_COMPILER=${C_COMPILER} -DCMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_CTEST_COMMAND} --test-dir ${WORK_DIR}/hash_test/build -R part)
expect_match("a test of the right hash" "${out}" "100% tests passed, 0 tests failed out of 1")
execute_process(COMMAND ${CMAKE_CTEST_COMMAND} --test-dir ${WORK_DIR}/hash_test/build -R other --output-on-failure
                RESULT_VARIABLE result OUTPUT_VARIABLE out ERROR_VARIABLE out)
expect_match("a test of another hash" "${out}" "scene:cube: the hash is [0-9a-f]+, and --expect is ${zeros}")
if(result EQUAL 0)
  message(FATAL_ERROR "a test of another hash passed")
endif()
file(WRITE ${WORK_DIR}/hash_test/CMakeLists.txt
     "${hash_project}svocl_add_hash_test(NAME short INPUT part.obj HASH 12ab)\n")
execute_process(COMMAND ${CMAKE_COMMAND} ${WORK_DIR}/hash_test/build RESULT_VARIABLE result OUTPUT_QUIET
                ERROR_VARIABLE out)
expect_match("the message of a short hash" "${out}" "HASH '12ab' is not 32")

# Its laboratory, which it finds beside itself.
run(${prefix}/bin/svocl verify scene:cube -d 4)
expect_match("svocl verify" "${out}" "exact: 0 missed, 0 surplus")

# What is only measured: Embree is opened when it is asked for, and svocl has no part of OpenVDB.
find_program(readelf readelf)
if(readelf)
  run(${readelf} -d ${prefix}/bin/svocl ${prefix}/bin/svocl-lab)
  if(out MATCHES "NEEDED[^\n]*embree")
    message(FATAL_ERROR "a program loads Embree: ${out}")
  endif()
  run(${readelf} -d ${prefix}/bin/svocl)
  if(out MATCHES "NEEDED[^\n]*(openvdb|tbb)")
    message(FATAL_ERROR "svocl loads OpenVDB: ${out}")
  endif()
endif()

# pkg-config, svocl::io alone
set(ENV{PKG_CONFIG_PATH} ${library_dir}/pkgconfig)
set(static "")
if(library MATCHES "\\.a$")
  set(static --static)
endif()
run(pkg-config --modversion svocl-io)
if(NOT out STREQUAL "${VERSION}\n")
  message(FATAL_ERROR "pkg-config says that svocl-io is version ${out} instead of ${VERSION}")
endif()
run(pkg-config ${static} --cflags --libs svocl-io)
string(STRIP "${out}" flags)
# The machine may have none of what libzip links itself.
if(flags MATCHES "-l(bz2|ssl|crypto)")
  message(FATAL_ERROR "pkg-config names libraries of libraries: ${flags}")
endif()
separate_arguments(flags UNIX_COMMAND "${flags}")
run(${C_COMPILER} -std=c11 -o ${prefix}/bin/files ${SOURCE_DIR}/tests/install/files.c ${flags})
set(ENV{LD_LIBRARY_PATH} ${library_dir}) # pkg-config says nothing about where shared libraries lie at run time
run(${prefix}/bin/files)

# The import helper, which the library finds in the installation that it or its program belongs to.
file(WRITE ${WORK_DIR}/mesh.obj "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
file(REAL_PATH ${prefix} real_prefix)
run(${prefix}/bin/files ${WORK_DIR}/mesh.obj ${real_prefix}/libexec/svocl/svocl-import)

# A program in C alone links svocl::io, though one of its files is C++.
file(MAKE_DIRECTORY ${WORK_DIR}/consumer_io)
file(COPY ${SOURCE_DIR}/tests/install/files.c DESTINATION ${WORK_DIR}/consumer_io)
file(WRITE ${WORK_DIR}/consumer_io/CMakeLists.txt
     "cmake_minimum_required(VERSION 3.22)\nproject(files LANGUAGES C)\n"
     "find_package(svocl ${minor_version} REQUIRED COMPONENTS io)\n"
     "add_executable(files files.c)\ntarget_link_libraries(files PRIVATE svocl::io)\n")
run(${CMAKE_COMMAND} -S ${WORK_DIR}/consumer_io -B ${WORK_DIR}/consumer_io/build -G ${GENERATOR}
    -DCMAKE_C_COMPILER=${C_COMPILER} -DCMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${WORK_DIR}/consumer_io/build)
run(${WORK_DIR}/consumer_io/build/files)

file(REMOVE ${prefix}/bin/files)

# The script of the target `uninstall`. Files of others stay.
file(WRITE ${prefix}/include/svocl/other.h "")
file(WRITE ${prefix}/include/other.h "")
run(${CMAKE_COMMAND} -DBUILD_DIR=${WORK_DIR}/build -P ${SOURCE_DIR}/cmake/uninstall.cmake)
file(GLOB_RECURSE left RELATIVE ${prefix} ${prefix}/*)
if(NOT left STREQUAL "include/other.h;include/svocl/other.h")
  message(FATAL_ERROR "uninstall left ${left}")
endif()
if(EXISTS ${library_dir}/cmake/svocl)
  message(FATAL_ERROR "uninstall left ${library_dir}/cmake/svocl")
endif()
