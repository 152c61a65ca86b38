/* SPDX-License-Identifier: MIT */
/* Polygons to triangles, and faces over a list of vertices, as PLY and OFF have them, in the import child. */
#ifndef SVO_LIB_IO_IMPORT_FACES_H
#define SVO_LIB_IO_IMPORT_FACES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "io/import_reader.h"

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

typedef struct face_list {
    const mesh_reader *reader;
    gather_vertex *vertices; /* of the file, vertex_count of them */
    uint32_t *known; /* per vertex its index in the mesh; GATHER_NO_VERTEX before its first use */
    uint32_t *gathered; /* per vertex the one of the mesh that its first corner got; GATHER_NO_VERTEX: no corner */
    uint32_t *first; /* per vertex the first that is equal; NULL: equal ones are found when they are gathered */
    size_t vertex_count;
    int64_t *corners; /* of the face that is read: vertex indices as the file has them */
    float (*corner_uvs)[2]; /* the same: its texture coordinates, if the file has them per corner */
    size_t corner_capacity, uv_capacity;
    polygon shape;
    uint64_t face_count; /* added, with those below */
    uint64_t small_count; /* of fewer than three corners, left out */
    uint64_t bad_count, first_bad_face; /* faces with an index out of range, and the number of the first, from 0 */
    int64_t first_bad; /* that index */
} face_list;

/* Allocates the vertices, white and zero otherwise; svo_i_faces_free releases them. */
svo_status svo_i_faces_begin(face_list *faces, const mesh_reader *reader, uint64_t vertex_count);
/* After the vertices are filled in, before the first face. corner_uvs: faces may have texture coordinates. */
svo_status svo_i_faces_end_vertices(face_list *faces, bool corner_uvs);
/* Room for a face of corner_count corners. */
svo_status svo_i_faces_reserve(face_list *faces, uint64_t corner_count);
/* Room for the texture coordinates of as many. */
svo_status svo_i_faces_reserve_uvs(face_list *faces, uint64_t corner_count);
/* Adds the face whose first corner_count corners were filled in. with_uvs: they have texture coordinates. An index out
   of range gives triangles without that vertex, which a build refuses and counts. */
svo_status svo_i_faces_add(face_list *faces, uint32_t corner_count, bool with_uvs);
/* After the last face: warns of all that was left out, and tells the mesh which of its vertices those of the file
   are. */
void svo_i_faces_end(face_list *faces);
void svo_i_faces_free(face_list *faces);

#endif
