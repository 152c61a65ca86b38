/* SPDX-License-Identifier: MIT */
/* Polygons to triangles, in the import child. */
#ifndef SVO_LIB_IO_IMPORT_POLYGON_H
#define SVO_LIB_IO_IMPORT_POLYGON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* One polygon after the other; all zero at first. */
typedef struct polygon {
    float (*corners)[3]; /* what the caller fills in, corner_count of them */
    uint32_t *triangles; /* the result: three corners for each of corner_count - 2 triangles */
    size_t corner_capacity;
    float (*flat)[2]; /* the corners on the plane that they are projected to */
    uint32_t *before, *after; /* the corners that are left, as a ring */
    uint8_t *ears; /* whether a corner is an ear, as far as that is known */
    uint64_t crossed_count; /* polygons that cross themselves so far, and were cut all the same */
} polygon;

/* Room for this many corners. Returns false when memory runs out. */
bool svo_i_polygon_reserve(polygon *shape, size_t corner_count);
/*
 * Cuts the polygon into triangles of the same winding. Four corners: a fan from the corner that points inwards, else
 * from the first. More: ears in the order of the corners (Meisters, "Polygons have ears", 1975), on the axis-aligned
 * plane that it covers most of. The cost grows with the square of corner_count.
 *
 * corner_count: at least 3, reserved before.
 */
void svo_i_polygon_cut(polygon *shape, uint32_t corner_count);
void svo_i_polygon_free(polygon *shape);

#endif
