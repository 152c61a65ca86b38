/* SPDX-License-Identifier: MIT */
/* .svo files as versions 1 and 2 wrote them. */
#ifndef SVO_TESTS_OLDER_FILE_H
#define SVO_TESTS_OLDER_FILE_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/tree.h"

/* The file of a tree with host arrays, stored without compression. version: 1, without the mesh's own positions, or 2.
   The caller frees it. */
uint8_t *older_file_make(const svo_tree *tree, uint32_t version, size_t *byte_count);

#endif
