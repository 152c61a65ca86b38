/* SPDX-License-Identifier: MIT */
/* Parts that scenes are put together from: curved patches, flat panels, boxes, turned bodies and spheres. */
#ifndef SVOCL_TOOLS_SCENES_PARTS_H
#define SVOCL_TOOLS_SCENES_PARTS_H

#include "builder.h"

/* A point of a parametric surface; u and v run from 0 to 1. */
typedef surface_point (*surface_function)(const void *context, double u, double v);

/* Cells along u and v. A wrapped direction closes on itself and shares the vertices of its seam. */
typedef struct patch_grid {
    uint32_t columns, rows;
    bool wrap_u, wrap_v;
} patch_grid;

/* Two triangles per cell. The outer side is where u turned to v is counter-clockwise. */
void part_patch(scene_builder *builder, patch_grid grid, surface_function surface, const void *context);

/* A flat parallelogram; its outer side is along edge_u x edge_v. */
typedef struct panel {
    vector3 corner, edge_u, edge_v;
    vector3 color;
} panel;
void part_panel(scene_builder *builder, const panel *flat, uint32_t columns, uint32_t rows);

/* The color of one tile of a tiled panel. */
typedef vector3 (*tile_color)(uint32_t seed, uint32_t column, uint32_t row);
/* Tiles of one color each, so that colors do not run into each other; columns and rows count tiles. A tile has
   n * n quads, where n is the mean number of cells rounded up for some tiles and down for the others: so the count of
   triangles grows smoothly with it. */
typedef struct tiling {
    uint32_t columns, rows;
    double mean_cells;
    tile_color color;
    uint32_t seed;
} tiling;
void part_tiles(scene_builder *builder, const panel *flat, const tiling *tiles);

/* An axis-parallel box from its lower to its upper corner; cells per face and axis. */
void part_box(scene_builder *builder, vector3 low, vector3 high, uint32_t cells, vector3 color);
/* The same standing upright, turned about its own vertical axis. */
void part_turned_box(scene_builder *builder, vector3 center, vector3 half, double turns, uint32_t cells, vector3 color);

/* A body turned about a vertical axis: a smooth curve (Catmull and Rom 1974) through the points of its profile, from
   bottom to top. */
typedef struct profile_point {
    double radius, height;
} profile_point;
typedef struct turned_body {
    vector3 base;
    const profile_point *profile;
    uint32_t profile_count; /* at least 2 */
    double scale; /* of radii and heights */
    vector3 color_low, color_high; /* at the bottom and at the top */
} turned_body;
void part_turned_body(scene_builder *builder, const turned_body *body, uint32_t sides, uint32_t rows);

/* A sphere of six square patches, cells * cells each: no triangle degenerates at a pole. */
typedef struct ball {
    vector3 center;
    double radius;
    vector3 color;
} ball;
void part_ball(scene_builder *builder, const ball *sphere, uint32_t cells);

#endif
