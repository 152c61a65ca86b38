# Builds that watch themselves run: SVOCL_FUZZ, SVOCL_SANITIZE and SVOCL_COVERAGE.
if(SVOCL_FUZZ)
  if(NOT CMAKE_C_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "SVOCL_FUZZ needs clang with libFuzzer: -DCMAKE_C_COMPILER=clang")
  endif()
  add_compile_options(-g -fno-omit-frame-pointer -fno-sanitize-recover=all
                      -fsanitize=fuzzer-no-link,address,undefined,float-cast-overflow)
  add_link_options(-fsanitize=address,undefined,float-cast-overflow)
endif()

if(SVOCL_SANITIZE)
  add_compile_options(-g -fno-omit-frame-pointer -fno-sanitize-recover=all -fsanitize=${SVOCL_SANITIZE})
  add_link_options(-fsanitize=${SVOCL_SANITIZE})
endif()

# svocl_count_lines(target): with SVOCL_COVERAGE, writes how often each line of the target ran (gcov). Unoptimized, so
# that each line is code of its own; counted atomically, since drivers call back on their threads. Other targets stay
# optimized: the tests take no longer.
function(svocl_count_lines target)
  if(SVOCL_COVERAGE)
    target_compile_options(${target} PRIVATE -O0 -g --coverage -fprofile-update=atomic)
    target_link_options(${target} PUBLIC --coverage)
  endif()
endfunction()
