# find_package(svocl) where a dependency of svocl::io is missing: the caller's configuration goes on, svocl_FOUND is
# false with the reason, and the libraries that need less are found. pkg-config finds libzstd here but not assimp.
# BUILD_DIR, WORK_DIR, C_COMPILER, GENERATOR and SHARED come from the command line.
include(${CMAKE_CURRENT_LIST_DIR}/common.cmake)
set(prefix ${WORK_DIR}/prefix)
file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR})
install_to(${prefix} ${WORK_DIR}/install_manifest.txt)
run(pkg-config --variable=pcfiledir libzstd)
string(STRIP "${out}" modules)
file(COPY ${modules}/libzstd.pc DESTINATION ${WORK_DIR}/modules)
set(ENV{PKG_CONFIG_LIBDIR} ${WORK_DIR}/modules)
set(ENV{PKG_CONFIG_PATH} "")

# try_find(name result arguments expression...): configures a project with find_package(svocl arguments), which ends
# with the result 0 or 1 and prints text that matches each expression.
function(try_find name result arguments)
  set(project ${WORK_DIR}/${name})
  file(WRITE ${project}/CMakeLists.txt
       "cmake_minimum_required(VERSION 3.22)
project(${name} LANGUAGES C)
find_package(svocl ${arguments})
message(STATUS \"found: \${svocl_FOUND}, io: \${svocl_io_FOUND}, gl: \${svocl_gl_FOUND}\")
message(STATUS \"reason: \${svocl_NOT_FOUND_MESSAGE}\")
foreach(library svocl gl io)
  if(TARGET svocl::\${library})
    message(STATUS \"target \${library}\")
  endif()
endforeach()
")
  execute_process(
    COMMAND ${CMAKE_COMMAND} -S ${project} -B ${project}/build -G ${GENERATOR} -DCMAKE_C_COMPILER=${C_COMPILER}
            -DCMAKE_PREFIX_PATH=${prefix}
    RESULT_VARIABLE actual
    OUTPUT_VARIABLE text
    ERROR_VARIABLE text)
  if(NOT actual EQUAL result)
    message(FATAL_ERROR "find_package(svocl ${arguments}) ended with ${actual} instead of ${result}:\n${text}")
  endif()
  # CMake wraps the lines of errors.
  string(REGEX REPLACE "[ \n]+" " " text "${text}")
  foreach(expression IN LISTS ARGN)
    expect_match("the output of find_package(svocl ${arguments})" "${text}" "${expression}")
  endforeach()
endfunction()

if(SHARED)
  # A shared svocl_io brings assimp itself.
  try_find(everything 0 "QUIET" "found: (1|TRUE), io: TRUE, gl: TRUE" "target io")
else()
  set(reason "svocl::io needs assimp, which pkg-config does not find")
  try_find(everything 0 "QUIET" "found: (0|FALSE), io: FALSE" "reason: ${reason}")
  try_find(required 1 "REQUIRED" "${reason}")
  try_find(io 0 "QUIET COMPONENTS io" "found: (0|FALSE), io: FALSE" "reason: ${reason}")
  try_find(optional 0 "REQUIRED COMPONENTS svocl OPTIONAL_COMPONENTS io" "found: (1|TRUE), io: FALSE" "target svocl")
endif()
try_find(svocl 0 "REQUIRED COMPONENTS svocl" "found: (1|TRUE), io: , gl: " "target svocl")
try_find(gl 0 "REQUIRED COMPONENTS gl" "found: (1|TRUE), io: , gl: TRUE" "target svocl" "target gl")
try_find(unknown 0 "QUIET COMPONENTS svocl qt" "found: (0|FALSE)" "svocl::qt is not a library of svocl")
