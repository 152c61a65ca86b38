# svocl as a part of another project, by add_subdirectory and by FetchContent: nothing but the libraries is built, and
# nothing is installed unless the project asks for it. The project has settings of its own that must not matter: unity
# builds, an older C, warnings as errors, its own target `uninstall`.
# SOURCE_DIR, WORK_DIR, C_COMPILER and GENERATOR come from the command line.
include(${CMAKE_CURRENT_LIST_DIR}/common.cmake)
file(REMOVE_RECURSE ${WORK_DIR})

# configure(way line [argument...]): a project that gets svocl by that line, in WORK_DIR/way. Sets project and build.
function(configure way line)
  set(project ${WORK_DIR}/${way})
  file(WRITE ${project}/CMakeLists.txt
       "cmake_minimum_required(VERSION 3.22)
project(outside LANGUAGES C)
set(CMAKE_UNITY_BUILD ON)
set(CMAKE_C_STANDARD 99)
add_compile_options(-Werror)
add_custom_target(uninstall)
${line}
add_executable(voxels main.c)
target_link_libraries(voxels PRIVATE svocl::svocl svocl::gl svocl::io)
foreach(target svocl svocl_gl svocl_io)
  get_target_property(unity \${target} UNITY_BUILD)
  message(STATUS \"\${target}: unity build \${unity}\")
endforeach()
enable_testing()
")
  file(COPY ${SOURCE_DIR}/samples/01_minimal/main.c DESTINATION ${project})
  # Unoptimized, for it is the build that is tested.
  run(${CMAKE_COMMAND} -S ${project} -B ${project}/build -G ${GENERATOR} -DCMAKE_C_COMPILER=${C_COMPILER}
      -DCMAKE_C_FLAGS=-O0 ${ARGN})
  foreach(target svocl svocl_gl svocl_io)
    expect_match("the configuration" "${out}" "${target}: unity build (OFF|FALSE)")
  endforeach()
  foreach(own BUILD_SHARED_LIBS CMAKE_EXPORT_COMPILE_COMMANDS)
    file(STRINGS ${project}/build/CMakeCache.txt entry REGEX "^${own}:.*=.")
    if(entry)
      message(FATAL_ERROR "svocl sets ${entry} in the cache of the project")
    endif()
  endforeach()
  set(build ${project}/build PARENT_SCOPE)
endfunction()

# No target of svocl but the three libraries: fails if a program, a test or a sample is built.
function(expect_libraries_only build)
  expect_no_file(${build} "/(bin/svocl|test_[^/]*|sample_[^/]*|svocl_[^/]*|libsvocl_(oracle|scenes)[^/]*)$")
  run(${CMAKE_CTEST_COMMAND} --test-dir ${build} -N)
  expect_match("the list of tests" "${out}" "Total Tests: 0")
endfunction()

configure(subdirectory "add_subdirectory(${SOURCE_DIR} svocl)")
run(${CMAKE_COMMAND} --build ${build})
expect_libraries_only(${build})
run(${build}/voxels)
expect_match("the output of the program" "${out}" "^96776 leaves, 128073 nodes, hash ")
run(${CMAKE_COMMAND} --install ${build} --prefix ${WORK_DIR}/nothing)
expect_no_file(${WORK_DIR}/nothing ".")

# Asked for, the libraries are installed, with their headers and packages.
run(${CMAKE_COMMAND} -DSVOCL_INSTALL=ON ${build})
run(${CMAKE_COMMAND} --install ${build} --prefix ${WORK_DIR}/libraries)
foreach(file include/svocl/svocl.h cmake/svocl/svocl-config[.]cmake libsvocl[.]a libsvocl_gl[.]a libsvocl_io[.]a)
  file(GLOB_RECURSE files ${WORK_DIR}/libraries/*)
  expect_match("what SVOCL_INSTALL installs" "${files}" "/${file}(;|$)")
endforeach()
expect_no_file(${WORK_DIR}/libraries "^bin/")

# FetchContent configures it the same way.
configure(fetch "include(FetchContent)
FetchContent_Declare(svocl SOURCE_DIR ${SOURCE_DIR})
FetchContent_MakeAvailable(svocl)" -DFETCHCONTENT_FULLY_DISCONNECTED=ON)
expect_libraries_only(${build})
