/* SPDX-License-Identifier: MIT */
/* The attribute samples of a tree's (voxel, triangle) pairs, and the exact means in double. */
#ifndef SVOCL_TOOLS_ERRORS_ATTRIBUTE_SAMPLES_H
#define SVOCL_TOOLS_ERRORS_ATTRIBUTE_SAMPLES_H

#include <stdbool.h>

#include "svocl/svocl.h"

typedef enum attribute { ATTRIBUTE_COLOR = 0, ATTRIBUTE_NORMAL, ATTRIBUTE_COUNT } attribute;

typedef struct attribute_samples {
    size_t count; /* pairs */
    size_t leaf_count;
    uint32_t *leaves; /* per pair */
    float (*values)[4]; /* per pair, at the projection of the voxel's center: color 0 .. 255; normal -1 .. 1 */
    double (*means)[3]; /* per leaf: weighted by area, at the centroids of the parts inside; normals of any length */
    bool *judged; /* per leaf: it has an area, and its mean normal is not close to zero */
} attribute_samples;

/* mesh: with colors and normals per vertex, without materials. info, arrays: of its downloaded tree with lists. Returns
   false, with nothing to release, when memory runs out or the tree is malformed. */
bool attribute_samples_create(const svo_mesh *mesh, attribute kind, const svo_tree_info *info,
                              const svo_tree_arrays *arrays, attribute_samples *out);
void attribute_samples_free(attribute_samples *made);

/* Shuffles the pairs. */
void attribute_samples_shuffle(attribute_samples *made, uint64_t seed);

#endif
