/* SPDX-License-Identifier: MIT */
/*
 * A flat sheet of small squares with every attribute, and one further triangle in the same plane, on voxels that the
 * sheet already occupies. With it, a build needs more memory or kernels, but the nodes do not change.
 */
#ifndef SVOCL_TESTS_SHEET_MESH_H
#define SVOCL_TESTS_SHEET_MESH_H

#include <stdbool.h>

#include "svocl/mesh.h"

enum {
    SHEET_SQUARES = 16,
    SHEET_TRIANGLES = 2 * SHEET_SQUARES * SHEET_SQUARES,
    SHEET_SMALL_TEXELS = 16 * 16,
    SHEET_LARGE_TEXELS = 64 * 64
};

/* The further triangle. Sizes are for the grid of origin 0 and edge 1, where the sheet's squares are 1/128 wide. */
typedef enum sheet_extra {
    SHEET_ALONE = 0, /* no further triangle */
    SHEET_SPECK, /* a point: its tiny weight changes no node with other triangles */
    SHEET_LARGE, /* a tenth of the grid wide */
    SHEET_OUTSIDE, /* reaching outside the grid */
    SHEET_BRIDGE, /* across two of the sheet's squares, from center to center */
    SHEET_REFUSED /* with a vertex that is not finite */
} sheet_extra;

/* Every triangle has three vertices of its own; those of the further one come last. All may be changed. */
typedef struct sheet_mesh {
    svo_mesh mesh;
    double positions[(SHEET_TRIANGLES + 1) * 9];
    float normals[(SHEET_TRIANGLES + 1) * 9];
    float uvs[(SHEET_TRIANGLES + 1) * 6];
    uint8_t colors[(SHEET_TRIANGLES + 1) * 12];
    uint16_t triangle_materials[SHEET_TRIANGLES + 1];
    svo_material materials[2];
    svo_texture textures[2]; /* a small one with many colors and a large white one */
    uint8_t texels[(SHEET_SMALL_TEXELS + SHEET_LARGE_TEXELS) * 4];
} sheet_mesh;

/* Colors and normals differ per vertex, materials per triangle; both materials are untextured. The further triangle is
   white. covered: the fraction of each square's edge that is covered, around its center; 1: all of it. */
void sheet_make(sheet_extra extra, double covered, sheet_mesh *out);
/* One color, normal or material for the whole sheet. If differs is set, the further triangle has another; its color
   is white. */
void sheet_set_color(sheet_mesh *sheet, const uint8_t rgba[4], bool differs);
void sheet_set_normal(sheet_mesh *sheet, const float normal[3], bool differs);
void sheet_set_material(sheet_mesh *sheet, uint16_t material, bool differs);

#endif
