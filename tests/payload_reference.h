/* SPDX-License-Identifier: MIT */
/*
 * Second reference for the payload: the colour and the normal of every node, in plain C on the host, from the exact pairs
 * and the exact tree. It shares no code with kernels/ or lib/, only the definition: what a triangle contributes to a voxel
 * (kernels/attribute.clh), and that a node has the mean over all its pairs, rounded once (kernels/filter.cl).
 */
#ifndef SVOCL_PAYLOAD_REFERENCE_H
#define SVOCL_PAYLOAD_REFERENCE_H

#include "compare_tree.h"

typedef struct payload_reference {
    uint8_t *colors; /* node_count * 4 */
    int16_t *normals; /* node_count * 3 */
} payload_reference;

/* expected: of the same mesh, from exact_create. Inside a running cmocka test. */
void payload_reference_create(const svo_mesh *mesh, const exact *expected, payload_reference *out);
void payload_reference_destroy(payload_reference *made);

/* The colour of each leaf in double precision, 0 .. 255 per channel. rgba: leaf_count * 4. */
void payload_double_colors(const svo_mesh *mesh, const exact *expected, double *rgba);

#endif
