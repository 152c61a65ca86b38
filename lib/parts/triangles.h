/* SPDX-License-Identifier: MIT */
/*
 * The triangles of a part in a file: records of one size, each with all that its three corners have, so that triangles
 * can be divided among parts without an index.
 *
 *   bytes    what
 *   n * r    n records of r bytes: name and material, 4 bytes each; then for three corners positions (floats or
 *            doubles), normals, colors and texture coordinates, those that the fields name
 *   8        magic
 *   4        version, 3; files of version 1 had nothing but the checksum after the records
 *   4        r
 *   32       svo_i_triangles_of: the plan that the triangles are of, the part's place, the fields
 *   8        XXH3 of all before
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

/* What the triangles of a file are of; its bytes are in the file. */
typedef struct svo_i_triangles_of {
    uint64_t plan[2]; /* svo_i_part_identity */
    uint64_t code; /* of the part */
    uint32_t level;
    uint32_t fields;
} svo_i_triangles_of;

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
   hash and path must outlive the file. To be ended also after a failure. */
svo_status svo_i_triangles_begin(svo_i_triangle_file *file, void *hash, const char *path, uint32_t fields,
                                 svo_message *message);
svo_status svo_i_triangles_append(svo_i_triangle_file *file, const svo_mesh *mesh, const uint32_t *ids, uint32_t count);
/* The hash of all records, before the file is finished. */
svo_status svo_i_triangles_hash(svo_i_triangle_file *file, uint64_t *hash);
svo_status svo_i_triangles_finish(svo_i_triangle_file *file, const svo_i_triangles_of *of);
void svo_i_triangles_end(svo_i_triangle_file *file);
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

/* Fails for a file of another plan or part than of. */
svo_status svo_i_triangles_load(const char *path, const svo_i_triangles_of *of, svo_i_soup *soup, svo_message *message);
void svo_i_soup_free(svo_i_soup *soup);

/* Divides the triangles of a part among its eight children by their snapped bounds. paths: of the children's files,
   which are written where a triangle may meet the child. of: the part. counts: receives how many do. */
svo_status svo_i_triangles_split(const svo_part_header *header, const svo_i_triangles_of *of, const char *path,
                                 char *const paths[8], uint64_t counts[8], svo_message *message);

#endif
