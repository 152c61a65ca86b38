# xxHash: hashes of trees, checksums of files, tables. All of it is inlined from its header: nothing is linked, and what
# is installed does not need it.
find_path(SVOCL_XXHASH_INCLUDE_DIR xxhash.h DOC "where xxhash.h of xxHash 0.8 or later lies")
set(svocl_xxhash_version 0)
if(EXISTS ${SVOCL_XXHASH_INCLUDE_DIR}/xxhash.h)
  file(STRINGS ${SVOCL_XXHASH_INCLUDE_DIR}/xxhash.h svocl_xxhash_version REGEX "define XXH_VERSION_M[AI][JN]OR")
  string(REGEX REPLACE "[^0-9]+" "." svocl_xxhash_version ".${svocl_xxhash_version}")
  string(REGEX MATCH "[0-9]+\\.[0-9]+" svocl_xxhash_version "${svocl_xxhash_version}")
endif()
if(svocl_xxhash_version VERSION_LESS 0.8)
  message(FATAL_ERROR "svocl needs the header xxhash.h of xxHash 0.8 or later, which computes the hashes of trees and "
                      "files, and which was not found (SVOCL_XXHASH_INCLUDE_DIR is \"${SVOCL_XXHASH_INCLUDE_DIR}\"). "
                      "Debian has it in libxxhash-dev. Nothing of it is linked.")
endif()
include_directories(SYSTEM ${SVOCL_XXHASH_INCLUDE_DIR})
