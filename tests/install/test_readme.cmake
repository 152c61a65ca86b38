# Fails unless README.md contains the text of each file it claims to show.
file(READ ${SOURCE_DIR}/README.md readme)

function(expect_shown file)
  file(READ ${SOURCE_DIR}/${file} text)
  string(FIND "${readme}" "${text}```" position)
  if(position EQUAL -1)
    message(SEND_ERROR "README.md does not show the current ${file}; copy the file into its block again")
  endif()
endfunction()

# Three sentences, two commands, the sample and where to read on fit this many lines; the rest belongs to docs/.
string(REGEX MATCHALL "\n" lines "${readme}")
list(LENGTH lines line_count)
if(line_count GREATER 150)
  message(SEND_ERROR "README.md has ${line_count} lines, above 150")
endif()

expect_shown(samples/01_minimal/main.c)
expect_shown(tests/install/consumer/CMakeLists.txt)
