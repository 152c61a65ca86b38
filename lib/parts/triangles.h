/* SPDX-License-Identifier: MIT */
/*
 * The triangles of a part in a file: records of one size, each with all that its three corners have, so that triangles
 * can be divided among parts without an index. After the records follows their XXH3.
 */
#ifndef SVO_LIB_PARTS_TRIANGLES_H
#define SVO_LIB_PARTS_TRIANGLES_H

#include "core/memory.h"
#include "output/output.h"
#include "svocl/mesh.h"
#include "svocl/part_types.h"

/* What a record has besides its name and material: bits. */
#define TRIANGLE_DOUBLES 1u /* positions are doubles */
#define TRIANGLE_NORMALS 2u
#define TRIANGLE_COLORS  4u
#define TRIANGLE_UVS     8u

uint32_t svo_i_triangle_fields(const svo_mesh *mesh);
size_t svo_i_triangle_bytes(uint32_t fields);

/* A file of triangles that is being written. */
typedef struct svo_i_triangle_file {
    svo_i_output output;
    const char *path;
    svo_message *message;
    void *hash; /* an XXH3_state_t of the caller's, since memory of svo_i_alloc is not aligned enough for it */
    uint32_t fields;
    size_t record_bytes;
    unsigned char *block; /* NULL: not begun */
    size_t filled, block_bytes;
    uint64_t count; /* of triangles */
} svo_i_triangle_file;

/* Begins a file, appends the triangles of a mesh that ids names, each called by its place in the file, and finishes it.
   hash and path must outlive the file. To be ended also after a failure. *hash: of the records; NULL allowed. */
svo_status svo_i_triangles_begin(svo_i_triangle_file *file, void *hash, const char *path, uint32_t fields,
                                 svo_message *message);
svo_status svo_i_triangles_append(svo_i_triangle_file *file, const svo_mesh *mesh, const uint32_t *ids, uint32_t count);
svo_status svo_i_triangles_finish(svo_i_triangle_file *file, uint64_t *hash);
void svo_i_triangles_end(svo_i_triangle_file *file);
/* All of it: the file of a mesh. */
svo_status svo_i_triangles_save(const svo_mesh *mesh, const uint32_t *ids, uint32_t count, const char *path,
                                uint64_t *hash, svo_message *message);

/* Triangles with corners of their own, as a mesh without materials. */
typedef struct svo_i_soup {
    svo_mesh mesh;
    uint32_t *names; /* positions among the kept triangles of the whole mesh */
    void *positions;
    float *normals;
    uint8_t *colors;
    float *uvs;
    uint16_t *materials;
} svo_i_soup;

svo_status svo_i_triangles_load(const char *path, uint32_t fields, svo_i_soup *soup, svo_message *message);
void svo_i_soup_free(svo_i_soup *soup);

/* Divides the triangles of a part among its eight children by their snapped bounds. paths: of the children's files,
   which are written where a triangle may meet the child. counts: receives how many do. */
svo_status svo_i_triangles_split(const svo_part_header *header, uint32_t fields, const char *path, uint32_t level,
                                 uint64_t code, char *const paths[8], uint64_t counts[8], svo_message *message);

#endif
