# For the tests in this folder.

# Runs a command and stores its standard output in out. If the command fails, fails with its output.
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE result OUTPUT_VARIABLE out ERROR_VARIABLE err)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGV}\nfailed (${result}):\n${out}${err}")
  endif()
  set(out "${out}" PARENT_SCOPE)
endfunction()

# Fails unless the text matches the regular expression.
function(expect_match what text expression)
  if(NOT text MATCHES "${expression}")
    message(FATAL_ERROR "${what} is\n${text}\nwithout ${expression}")
  endif()
endfunction()

# Fails if a folder holds a file, or a link, whose path from the folder matches the regular expression.
function(expect_no_file folder expression)
  file(GLOB_RECURSE files LIST_DIRECTORIES false RELATIVE ${folder} ${folder}/*)
  list(FILTER files INCLUDE REGEX "${expression}")
  if(files)
    message(FATAL_ERROR "${folder} holds\n${files}")
  endif()
endfunction()

# Installs a build folder that is not the test's own, and stores the list of installed files in MANIFEST. The folder
# keeps its own list, from which its user may uninstall.
function(install_to prefix manifest)
  set(own ${BUILD_DIR}/install_manifest.txt)
  set(kept ${manifest}.kept)
  if(EXISTS ${own})
    file(RENAME ${own} ${kept})
  endif()
  run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix})
  file(RENAME ${own} ${manifest})
  if(EXISTS ${kept})
    file(RENAME ${kept} ${own})
  endif()
endfunction()
