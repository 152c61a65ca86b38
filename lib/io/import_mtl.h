/* SPDX-License-Identifier: MIT */
/* Materials of OBJ files, from their MTL files, in the import child: diffuse color, opacity, diffuse texture,
   emission and the specular lobe. */
#ifndef SVO_LIB_IO_IMPORT_MTL_H
#define SVO_LIB_IO_IMPORT_MTL_H

#include "io/import_list.h"
#include "io/import_reader.h"
#include "io/import_texture.h"

#define MTL_NO_MATERIAL UINT32_MAX

typedef struct mtl_material {
    char *name;
    bool is_defined; /* by an MTL file, and not only used */
    uint64_t used_line; /* of the first "usemtl" */
    float diffuse[3], opacity;
    svo_finish finish; /* as the file has it */
    char *texture; /* NULL: none */
    bool clamps;
    float uv_scale[2], uv_offset[2];
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
/*
 * The index of a material in the gathered mesh. number: MTL_NO_MATERIAL for faces before any "usemtl", which are white.
 * textured: the faces have texture coordinates; the texture is then loaded and sent.
 */
svo_status svo_i_mtl_gather(mtl_library *library, const mesh_reader *reader, texture_list *textures, uint32_t number,
                            bool textured, uint32_t *default_index, uint16_t *index);
void svo_i_mtl_free(mtl_library *library);

#endif
