/* SPDX-License-Identifier: MIT */
/* An OBJ file as tables, between its parser (import_obj.c) and the mesh (import_obj_mesh.c), in the import child. */
#ifndef SVO_LIB_IO_IMPORT_OBJ_MESH_H
#define SVO_LIB_IO_IMPORT_OBJ_MESH_H

#include "io/import_mtl.h"

#define OBJ_NONE UINT32_MAX /* of a corner: no texture coordinates, no normal */

/* A corner's indices, from 0 on. An index may name what the file defines later, or nothing. */
typedef struct obj_corner {
    uint32_t position, uv, normal;
} obj_corner;

/* Faces in a row with the same material, which share whether they are textured. */
typedef struct obj_run {
    uint32_t material; /* number in the library, or MTL_NO_MATERIAL */
    uint64_t face_count;
    bool has_uvs; /* any corner has texture coordinates */
} obj_run;

typedef struct obj_file {
    item_list positions; /* float[3] */
    item_list colors; /* uint8_t[4] per position; empty: none has one */
    item_list uvs; /* float[2] */
    item_list normals; /* float[3] */
    item_list corners; /* obj_corner */
    item_list faces; /* uint32_t: number of corners, at least 3 */
    item_list runs; /* obj_run */
    mtl_library library;
} obj_file;

/* Gathers the faces of a file, whose positions are all defined. Warns of what does not fit. */
svo_status svo_i_obj_gather(const mesh_reader *reader, obj_file *file);

#endif
