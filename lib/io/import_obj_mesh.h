/* SPDX-License-Identifier: MIT */
/*
 * An OBJ file as tables, between its parser (import_obj.c) and the mesh (import_obj_mesh.c), in the import child. Of
 * its MTL files: diffuse color, opacity, diffuse texture, emission and the specular lobe.
 */
#ifndef SVO_LIB_IO_IMPORT_OBJ_MESH_H
#define SVO_LIB_IO_IMPORT_OBJ_MESH_H

#include "io/import_reader.h"

#define MTL_NO_MATERIAL UINT32_MAX

/* A texture statement. */
typedef struct mtl_texture {
    char *name; /* NULL: none */
    bool clamps;
    float uv_scale[2], uv_offset[2];
    float bump; /* -bm */
} mtl_texture;

typedef struct mtl_material {
    char *name;
    bool is_defined; /* by an MTL file, and not only used */
    uint64_t used_line; /* of the first "usemtl" */
    float diffuse[3], opacity;
    svo_finish finish; /* as the file has it */
    mtl_texture color, bump;
    bool has_norm; /* bump is that of "norm" */
    uint32_t index[2]; /* in the gathered mesh, without and with its texture; MTL_NO_MATERIAL: not gathered yet */
} mtl_material;

typedef struct mtl_library {
    item_list materials; /* of mtl_material */
    uint32_t *slots; /* hash table of names; MTL_NO_MATERIAL where free */
    size_t slot_count;
} mtl_library;

/* The material of this name, made if there is none. MTL_NO_MATERIAL when memory runs out. */
uint32_t svo_i_mtl_find(mtl_library *library, const char *name, size_t length);
mtl_material *svo_i_mtl_get(const mtl_library *library, uint32_t number);
/* Reads the text of an MTL file. Statements that it cannot read are left out with a warning that names the file. */
svo_status svo_i_mtl_read(mtl_library *library, const mesh_reader *reader, const char *name, const char *bytes,
                          size_t byte_count);
void svo_i_mtl_free(mtl_library *library);

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
