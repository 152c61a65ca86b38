# The core alone where there is no xxhash.h, or an older one: the configuration ends and names the package.
# SOURCE_DIR, WORK_DIR, C_COMPILER and GENERATOR come from the command line.
include(${CMAKE_CURRENT_LIST_DIR}/common.cmake)
file(REMOVE_RECURSE ${WORK_DIR})
file(WRITE ${WORK_DIR}/older/xxhash.h "#define XXH_VERSION_MAJOR    0\n#define XXH_VERSION_MINOR    7\n")
foreach(folder IN ITEMS missing older)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -S ${SOURCE_DIR} -B ${WORK_DIR}/build-${folder} -G ${GENERATOR}
            -DCMAKE_C_COMPILER=${C_COMPILER} -DSVOCL_XXHASH_INCLUDE_DIR=${WORK_DIR}/${folder} -DSVOCL_IO=OFF
            -DSVOCL_GL=OFF -DSVOCL_TOOLS=OFF -DSVOCL_TESTS=OFF -DSVOCL_SAMPLES=OFF
    RESULT_VARIABLE result
    OUTPUT_VARIABLE text
    ERROR_VARIABLE text)
  if(result EQUAL 0)
    message(FATAL_ERROR "the configuration goes on with xxhash.h ${folder}")
  endif()
  string(REGEX REPLACE "[ \n]+" " " text "${text}") # CMake wraps the lines of errors
  expect_match("the output with xxhash.h ${folder}" "${text}" "needs the header xxhash.h of xxHash 0.8 or later")
  expect_match("the output with xxhash.h ${folder}" "${text}" "libxxhash-dev")
endforeach()
