/* SPDX-License-Identifier: MIT */
/*
 * The triangles of a part in a file: records of one size, each with all that its three corners have, so that triangles
 * can be divided among parts without an index.
 *
 *   bytes    what
 *   n * r    n records of r bytes: name and material, 4 bytes each; then for three corners positions (floats or
 *            doubles), normals, colors and texture coordinates, those that the fields name
 *   8        magic
 *   4        version, 4; files of version 1 had nothing but the checksum after the records
 *   4        r
 *   32       svo_i_triangles_of: the plan that the triangles are of, the part's place, the fields
 *   8        XXH3 of the tail before, seeded with the records' hash
 *
 * The records' hash is one of hashes of records, which those of two runs of records make without the records: so
 * several processes may write one file, each its own records, and whoever writes the tail reads none.
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

/* The hash of a run of records: a polynomial of the records' hashes, modulo 2^64 (Karp and Rabin, "Efficient Randomized
   Pattern-Matching Algorithms", 1987). */
typedef struct svo_i_triangle_hash {
    uint64_t count; /* of records */
    uint64_t value;
} svo_i_triangle_hash;

#define TRIANGLE_HASH_FACTOR UINT64_C(0x9e3779b97f4a7c15)

/* The hash of a record but for its name. */
uint64_t svo_i_triangle_hash_of(const unsigned char *record, size_t record_bytes);
/* Appends a record of that hash. name: 0 where records have none yet. */
static inline void svo_i_triangle_hash_add(svo_i_triangle_hash *to, uint64_t of_record, uint32_t name)
{
    ++to->count;
    to->value = to->value * TRIANGLE_HASH_FACTOR + (of_record ^ name * UINT64_C(0xd6e8feb86659fd93));
}
/* Appends a run. */
void svo_i_triangle_hash_append(svo_i_triangle_hash *to, const svo_i_triangle_hash *run);

/* Writes a triangle of a mesh as a record. */
void svo_i_triangle_put(const svo_mesh *mesh, uint32_t fields, uint32_t triangle, uint32_t name, unsigned char *record);

/* A file of triangles that is being written. */
typedef struct svo_i_triangle_file {
    svo_i_output output;
    const char *path;
    svo_message *message;
    svo_i_triangle_hash hash;
    uint32_t fields;
    size_t record_bytes;
    unsigned char *block; /* NULL: not begun */
    size_t filled, block_bytes;
} svo_i_triangle_file;

/* What follows the records of a part's file that is there already, as sections.c writes it. */
svo_status svo_i_triangles_write_tail(const char *path, const svo_i_triangles_of *of, const svo_i_triangle_hash *hash,
                                      svo_message *message);

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
