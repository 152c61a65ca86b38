/* SPDX-License-Identifier: MIT */
/* A table of svocl bench compact: colors and normals of a shared tree, packed. */
#ifndef SVOCL_LAB_BENCH_COMPACT_PACKED_H
#define SVOCL_LAB_BENCH_COMPACT_PACKED_H

#include "measure/suite.h"

#define COMPACT_PACKED_DEPTH_MAX 9u /* of trees that are measured; zstd -19 takes minutes beyond */

/* Adds the table without rows. */
void compact_packed_begin(suite *all);

/* Adds the rows of a tree on the device. Returns the exit code. */
int compact_packed_run(suite *all, const input *source, const svo_tree *tree);

#endif
