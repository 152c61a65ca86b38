# What CPack runs between staging and packing: files as Debian's policy wants them. Manual pages and the changelog are
# compressed, without a time, so that the same files make the same package. `cmake --install` leaves them plain.
find_program(gzip gzip)
if(NOT gzip)
  message(FATAL_ERROR "gzip is missing: Debian packages have compressed manual pages")
endif()
file(GLOB_RECURSE plain LIST_DIRECTORIES FALSE ${CPACK_TEMPORARY_DIRECTORY}/*/usr/share/man/man*/*.[1-9]
     ${CPACK_TEMPORARY_DIRECTORY}/*/usr/share/doc/*/changelog.Debian)
foreach(file IN LISTS plain)
  execute_process(COMMAND ${gzip} --best --no-name --force ${file} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
