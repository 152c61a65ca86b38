/* SPDX-License-Identifier: MIT */
/*
 * Meshes that become given voxels with given payload: a triangle inside each voxel. Call inside a running cmocka test;
 * the test fails when memory runs out.
 */
#ifndef SVOCL_TESTS_VOXEL_MESH_H
#define SVOCL_TESTS_VOXEL_MESH_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/plan.h"

typedef struct voxel {
    uint32_t cell[3];
    uint8_t rgba[4];
    float normal[3];
    uint16_t material;
    double width; /* of the triangle, in voxels: 0 .. 0.9. Its square is the fill */
} voxel;

typedef struct voxel_mesh {
    svo_mesh mesh;
    svo_plan_options options; /* the grid of the voxels; need is 0 */
    double *positions;
    float *normals;
    uint8_t *colors;
    uint16_t *materials;
} voxel_mesh;

#define VOXEL_MATERIALS 16

/* depth: cells are below 2^depth. Released by voxel_mesh_free. */
void voxel_mesh_make(const voxel *voxels, size_t voxel_count, unsigned depth, voxel_mesh *out);
void voxel_mesh_free(voxel_mesh *made);

#endif
