/* SPDX-License-Identifier: MIT */
/* A dense pyramid of six directions of the same scene on the same device: its bytes, and its passes from level to
   level. */
#ifndef SVOCL_TOOLS_BENCH_DENSE_FACES_H
#define SVOCL_TOOLS_BENCH_DENSE_FACES_H

#include <stdbool.h>

#include "support/session.h"

typedef struct dense_faces dense_faces;

/* RGBA8: one value a voxel on the finest level, six on each other one. */
uint64_t dense_faces_bytes(unsigned depth);

/* Allocates it and places the leaves of a tree that is downloaded and has colors. NULL where the device cannot hold it,
   or on failure. */
dense_faces *dense_faces_create(const session *opened, const svo_tree *tree);
void dense_faces_destroy(dense_faces **pyramid); /* a pointer to NULL is allowed */

/* Computes all levels from the finest; returns the milliseconds, below 0 on failure. */
double dense_faces_merge(const dense_faces *pyramid);

#endif
