/* SPDX-License-Identifier: MIT */
/*
 * Second reference for the payload: color, normal, material and fill of every node and the projected areas of every
 * leaf, in plain C on the host, from the exact pairs and the exact tree. It shares two things with kernels/ and lib/:
 * the unit of weight, and the clipping of kernels/shared/clip.clh, which test_clip.c tests separately. The rest follows
 * the definition alone: the contribution of a triangle to a voxel (kernels/stages/attribute.clh), the mean over all
 * pairs of a node, rounded once (kernels/stages/filter.cl), and the material of the largest weight
 * (kernels/stages/material.cl).
 */
#ifndef SVOCL_TESTS_PAYLOAD_REFERENCE_H
#define SVOCL_TESTS_PAYLOAD_REFERENCE_H

#include <stdbool.h>

#include "compare_tree.h"

/* Compares every attribute that the tree has. expected: of the same mesh, from exact_create. Call inside a running
   cmocka test. */
void assert_payload_is_exact(const svo_mesh *mesh, const exact *expected, const built *actual);

/* Leaves out the pairs whose alpha is below least, 0 .. 1, by the same definition, and makes the tree of those that
   remain. Returns how many were left out. */
size_t payload_drop_pairs(const svo_mesh *mesh, svo_weights weights, double least, exact *expected);

/* The alpha of a node whose rounded mean is given: 0 and 255 are those of nothing and all. sum: of weights times
   alpha. */
uint8_t payload_alpha(uint64_t rounded, uint64_t sum, uint64_t weight);

/* The color of each leaf in double precision, 0 .. 255 per channel. rgba: leaf_count * 4. */
void payload_double_colors(const svo_mesh *mesh, const exact *expected, svo_weights weights, double *rgba);
/* The area of the surface inside each leaf in double precision, in faces of a voxel. */
void payload_double_areas(const exact *expected, double *areas);
/* What rays along +x, -x, +y, -y, +z and -z see of it, in faces of a voxel. seen: leaf_count * 6. */
void payload_double_projections(const exact *expected, bool both_sides, double *seen);

#endif
