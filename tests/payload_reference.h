/* SPDX-License-Identifier: MIT */
/*
 * Second reference for the payload: color, normal, material and fill of every node, in plain C on the host, from the
 * exact pairs and the exact tree. Of kernels/ and lib/ it shares the unit of weight and the text of kernels/clip.clh,
 * which test_clip.c asks on its own; the rest is only the definition: what a triangle contributes to a voxel
 * (kernels/attribute.clh), that a node has the mean over all its pairs, rounded once (kernels/filter.cl), and the
 * material of the largest weight (kernels/material.cl).
 */
#ifndef SVOCL_TESTS_PAYLOAD_REFERENCE_H
#define SVOCL_TESTS_PAYLOAD_REFERENCE_H

#include "compare_tree.h"

/* Of what the tree holds. expected: of the same mesh, from exact_create. Inside a running cmocka test. */
void assert_payload_is_exact(const svo_mesh *mesh, const exact *expected, const built *actual);

/* The color of each leaf in double precision, 0 .. 255 per channel. rgba: leaf_count * 4. */
void payload_double_colors(const svo_mesh *mesh, const exact *expected, svo_weights weights, double *rgba);
/* The area of the surface inside each leaf in double precision, in faces of a voxel. */
void payload_double_areas(const exact *expected, double *areas);

#endif
