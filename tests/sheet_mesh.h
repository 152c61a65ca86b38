/* SPDX-License-Identifier: MIT */
/*
 * A flat sheet of small squares with every attribute, and beside it one more triangle in the same plane, on voxels that
 * the sheet has anyway: with it a build needs more than without, and the nodes are the same.
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

/* The further triangle. For the grid of origin 0 and edge 1, where the sheet's squares are a 128th wide. */
typedef enum sheet_extra {
    SHEET_ALONE = 0, /* there is none */
    SHEET_SPECK, /* a point: it weighs next to nothing, so its attributes change no node that has others */
    SHEET_LARGE, /* a tenth of the grid wide */
    SHEET_OUTSIDE, /* reaching outside the grid */
    SHEET_BRIDGE, /* across two of the sheet's squares, from middle to middle */
    SHEET_REFUSED /* with a vertex that is not finite */
} sheet_extra;

/* Three vertices of its own per triangle; the further one's come last. All may be changed. */
typedef struct sheet_mesh {
    svo_mesh mesh;
    double positions[(SHEET_TRIANGLES + 1) * 9];
    float normals[(SHEET_TRIANGLES + 1) * 9];
    float uvs[(SHEET_TRIANGLES + 1) * 6];
    uint8_t colors[(SHEET_TRIANGLES + 1) * 12];
    uint16_t triangle_materials[SHEET_TRIANGLES + 1];
    svo_material materials[2];
    svo_texture textures[2]; /* a small one of many colors, and a large one that is white */
    uint8_t texels[(SHEET_SMALL_TEXELS + SHEET_LARGE_TEXELS) * 4];
} sheet_mesh;

/* Attributes that differ from vertex to vertex and, the materials, from triangle to triangle; both materials
   untextured. The further triangle is white. covered: the part of each square that is covered, around its middle; 1:
   all of it. */
void sheet_make(sheet_extra extra, double covered, sheet_mesh *out);
/* The same color, normal or material all over the sheet; the further triangle has another (of
   colors white) where differs says so. */
void sheet_set_color(sheet_mesh *sheet, const uint8_t rgba[4], bool differs);
void sheet_set_normal(sheet_mesh *sheet, const float normal[3], bool differs);
void sheet_set_material(sheet_mesh *sheet, uint16_t material, bool differs);

#endif
