# Where headers are not where Debian has them. Without xxhash.h or stb_image.h, or with an older xxhash.h, the
# configuration ends and names the package. The headers of stb alone, in no folder of their own, suffice.
# SOURCE_DIR, WORK_DIR, C_COMPILER and GENERATOR come from the command line.
include(${CMAKE_CURRENT_LIST_DIR}/common.cmake)
file(REMOVE_RECURSE ${WORK_DIR})
set(configure ${CMAKE_COMMAND} -S ${SOURCE_DIR} -G ${GENERATOR} -DCMAKE_C_COMPILER=${C_COMPILER} -DCMAKE_BUILD_TYPE=Debug
              -DSVOCL_GL=OFF -DSVOCL_TESTS=OFF -DSVOCL_SAMPLES=OFF -DSVOCL_OPENVDB=OFF)

# Fails unless the configuration fails, with messages that match.
function(expect_refusal name)
  cmake_parse_arguments(PARSE_ARGV 1 of "" "" "OPTIONS;MESSAGES")
  execute_process(COMMAND ${configure} -B ${WORK_DIR}/build-${name} -DSVOCL_TOOLS=OFF ${of_OPTIONS}
                  RESULT_VARIABLE result OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(result EQUAL 0)
    message(FATAL_ERROR "the configuration goes on with headers that are ${name}")
  endif()
  string(REGEX REPLACE "[ \n]+" " " text "${text}") # CMake wraps the lines of errors
  foreach(expression IN LISTS of_MESSAGES)
    expect_match("the output with headers that are ${name}" "${text}" "${expression}")
  endforeach()
endfunction()

file(WRITE ${WORK_DIR}/older/xxhash.h "#define XXH_VERSION_MAJOR    0\n#define XXH_VERSION_MINOR    7\n")
foreach(folder IN ITEMS missing older)
  expect_refusal(${folder} OPTIONS -DSVOCL_IO=OFF -DSVOCL_XXHASH_INCLUDE_DIR=${WORK_DIR}/${folder}
                 MESSAGES "needs the header xxhash.h of xxHash 0.8 or later" "libxxhash-dev")
endforeach()
expect_refusal(without-stb OPTIONS -DSVOCL_STB_INCLUDE_DIR=${WORK_DIR}/missing
               MESSAGES "need the headers of stb, stb_image.h and others" "libstb-dev")

file(GLOB headers ${STB_INCLUDE_DIR}/stb/stb_*.h)
file(COPY ${headers} DESTINATION ${WORK_DIR}/plain)
run(${configure} -B ${WORK_DIR}/build-plain -DSVOCL_STB_INCLUDE_DIR=${WORK_DIR}/plain -DSTB_LIBRARY=OFF)
run(${CMAKE_COMMAND} --build ${WORK_DIR}/build-plain --target svocl_stb)
file(GLOB_RECURSE made ${WORK_DIR}/build-plain/libsvocl_stb.a)
if(NOT made)
  message(FATAL_ERROR "no libsvocl_stb.a was made of the headers of stb in ${WORK_DIR}/plain")
endif()
