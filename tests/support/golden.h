/* SPDX-License-Identifier: MIT */
/*
 * The golden table (golden/counts.tsv): small scenes of snapped triangles, with the exact number of voxels they touch
 * and of (voxel, triangle) pairs at each depth. Used by the tests of the references and of every front end.
 *
 * The coordinates are 0 .. 2^20 - 1. A build with origin 0 and edge 2^20 does not change them.
 */
#ifndef SVOCL_TESTS_GOLDEN_H
#define SVOCL_TESTS_GOLDEN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define GOLDEN_SNAP_BITS  20
#define GOLDEN_SCENES_MAX 32
#define GOLDEN_COUNTS_MAX 64
#define GOLDEN_NAME_BYTES 32

typedef struct golden_count {
    bool is_closed; /* closed coverage, otherwise half-open */
    unsigned depth; /* from 0, which the library does not build */
    uint64_t voxels;
    uint64_t pairs;
} golden_count;

typedef struct golden_scene {
    char name[GOLDEN_NAME_BYTES];
    int32_t *vertices; /* three vertices of x, y, z per triangle, allocated by malloc */
    size_t triangle_count;
    golden_count counts[GOLDEN_COUNTS_MAX];
    size_t count_count;
} golden_scene;

typedef struct golden_table {
    golden_scene scenes[GOLDEN_SCENES_MAX];
    size_t scene_count;
} golden_table;

/* Reads the table; path is usually GOLDEN_COUNTS_PATH, which the build defines. If a line cannot be parsed, prints the
   path and the line's number to stderr and returns NULL. Released by golden_free. */
golden_table *golden_load(const char *path);
void golden_free(golden_table *table);

#endif
