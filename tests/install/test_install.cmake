# Installs the build into an empty prefix and uses it like a new user: once through find_package, with the minimal
# sample and the CMake lines of the README, and once through pkg-config.
# BUILD_DIR, SOURCE_DIR, WORK_DIR, C_COMPILER, GENERATOR and VERSION come from the command line.
set(prefix ${WORK_DIR}/prefix)
file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR}/consumer)

# Runs a command and stores its standard output in out. If the command fails, fails with its output.
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE result OUTPUT_VARIABLE out ERROR_VARIABLE err)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGV}\nfailed (${result}):\n${out}${err}")
  endif()
  set(out "${out}" PARENT_SCOPE)
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix})
file(GLOB_RECURSE libraries ${prefix}/libsvocl.*)
list(GET libraries 0 library)
cmake_path(GET library PARENT_PATH library_dir)
set(ENV{LD_LIBRARY_PATH} ${library_dir})

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
separate_arguments(flags UNIX_COMMAND "${flags}")
run(${C_COMPILER} -std=c11 -o ${WORK_DIR}/files ${SOURCE_DIR}/tests/install/files.c ${flags})
run(${WORK_DIR}/files)
