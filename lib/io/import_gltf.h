/* SPDX-License-Identifier: MIT */
/*
 * A glTF 2.0 file in the import child: its JSON, its buffers, and accessors, the typed arrays in these
 * (import_gltf_file.c); its materials (import_gltf_material.c). import_gltf_scene.c gathers the triangles. Every index,
 * offset and count is checked where it is used; failures name it.
 */
#ifndef SVO_LIB_IO_IMPORT_GLTF_H
#define SVO_LIB_IO_IMPORT_GLTF_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

#include "io/import_reader.h"

#define GLTF_NONE UINT32_MAX /* no index */

/* The arrays of the file that others name elements of. */
typedef enum gltf_kind {
    GLTF_ACCESSOR = 0,
    GLTF_BUFFER_VIEW,
    GLTF_BUFFER,
    GLTF_IMAGE,
    GLTF_MATERIAL,
    GLTF_MESH,
    GLTF_NODE,
    GLTF_SAMPLER,
    GLTF_SCENE,
    GLTF_TEXTURE,
    GLTF_KIND_COUNT
} gltf_kind;

typedef struct gltf_table {
    const cJSON **items;
    uint32_t count;
} gltf_table;

/* Bytes of a buffer, a view or an image. */
typedef struct gltf_bytes {
    const uint8_t *bytes;
    uint64_t byte_count;
} gltf_bytes;

/* A buffer that has been opened: a file, bytes of the mesh file, or bytes that were text. */
typedef struct gltf_buffer {
    gltf_bytes content;
    file_bytes file;
    uint8_t *owned;
} gltf_buffer;

typedef struct gltf_file {
    const mesh_reader *reader;
    cJSON *root;
    gltf_table tables[GLTF_KIND_COUNT];
    gltf_buffer *buffers;
    gltf_bytes chunk; /* of a binary file */
} gltf_file;

/* An array of elements of several components. */
typedef struct gltf_accessor {
    const uint8_t *bytes; /* of the first element; NULL: there is no such array */
    size_t stride;
    uint32_t count, width; /* elements, components of each */
    uint32_t component; /* glTF's number of the component's type */
    bool normalized;
    uint8_t *owned; /* where values replace others; released by svo_i_gltf_accessor_free */
} gltf_accessor;

/* Opens a file. To be closed also after a failure. *is_older: it is of glTF 1.0, which has another structure. */
svo_status svo_i_gltf_open(const mesh_reader *reader, gltf_file *file, bool *is_older);
void svo_i_gltf_close(gltf_file *file);

/* The index that a property of an object names, GLTF_NONE where it has none. */
svo_status svo_i_gltf_index(const gltf_file *file, const cJSON *owner, const char *name, gltf_kind kind,
                            uint32_t *index);
/* The same for an element of an array of indices. */
svo_status svo_i_gltf_element(const gltf_file *file, const cJSON *element, const char *name, gltf_kind kind,
                              uint32_t *index);
/* A property that is an array of count numbers, or with count 1 a number; values stay where there is none. */
svo_status svo_i_gltf_numbers(const gltf_file *file, const cJSON *owner, const char *name, double *values, int count);
/* A property of an object, NULL where the object is NULL or has none. */
const cJSON *svo_i_gltf_get(const cJSON *owner, const char *name);
/* An extension of an object. */
const cJSON *svo_i_gltf_extension(const cJSON *owner, const char *name);

svo_status svo_i_gltf_view(gltf_file *file, uint32_t index, gltf_bytes *view);
svo_status svo_i_gltf_accessor(gltf_file *file, uint32_t index, gltf_accessor *accessor);
/* Also one that was never opened. */
void svo_i_gltf_accessor_free(gltf_accessor *accessor);
/* A component of an element: a number, in [-1, 1] where it is normalized. */
double svo_i_gltf_component(const gltf_accessor *accessor, uint32_t element, uint32_t component);
/* An element of an array of indices. */
uint32_t svo_i_gltf_vertex(const gltf_accessor *accessor, uint32_t element);

/* What a URI holds or names. data: its bytes, from malloc; path: of a file, from malloc. One of them is NULL. */
svo_status svo_i_gltf_uri(const gltf_file *file, const char *uri, uint8_t **data, uint64_t *byte_count, char **path);

/* ---- materials ---- */

/* What alpha means: alphaMode, alphaCutoff, and the base color's alpha, by which others are multiplied. */
typedef struct gltf_alpha {
    bool is_opaque; /* there is none */
    bool is_mask; /* all or nothing */
    double factor, cutoff;
} gltf_alpha;

/* A texture's coordinates: of a set of the mesh, rows of a 2 x 3 matrix applied to u, v, 1. */
typedef struct gltf_uvs {
    uint32_t set;
    bool is_identity;
    double matrix[2][3];
} gltf_uvs;

typedef struct gltf_look {
    gather_material material;
    gltf_alpha alpha;
    gltf_uvs uvs; /* of its textures */
} gltf_look;

/* A material of the file; index GLTF_NONE: the default one. with_texture: false leaves its textures out. A new image is
   sent, or a warning. */
svo_status svo_i_gltf_material(gltf_file *file, texture_list *textures, uint32_t index, bool with_texture,
                               gltf_look *look);

/* The alpha of a vertex, without the base color's. */
uint8_t svo_i_gltf_alpha_byte(const gltf_alpha *alpha, double value);

#endif
