/* SPDX-License-Identifier: MIT */
/*
 * The format in which an input of fuzz_mesh encodes svo_plan_create's arguments. Every input is valid; fields beyond
 * its end are zero. Arrays have exactly the size that the mesh's counts require, so that a sanitizer detects a read
 * past their end.
 */
#ifndef SVOCL_TESTS_FUZZ_MESH_INPUT_H
#define SVOCL_TESTS_FUZZ_MESH_INPUT_H

#include <stdbool.h>

#include "svocl/plan.h"

/* Encoding of positions; raw ones hold any bits: NaN, infinities, denormals. */
typedef enum position_form {
    POSITION_FLOAT = 0, /* four bytes per coordinate */
    POSITION_DOUBLE, /* eight bytes */
    POSITION_SMALL_FLOAT, /* two bytes: an integer / 256 */
    POSITION_SMALL_DOUBLE, /* the same, as doubles */
    POSITION_NONE, /* no array, which is an error */
    POSITION_BOTH, /* two arrays, which is an error too */
    POSITION_FORMS
} position_form;

/* Bits of mesh_input_head.arrays: which optional arrays exist. */
#define ARRAY_INDICES            1u
#define ARRAY_NORMALS            2u
#define ARRAY_COLORS             4u
#define ARRAY_UVS                8u
#define ARRAY_TRIANGLE_MATERIALS 16u
#define ARRAY_MATERIALS          32u
#define ARRAY_TEXTURES           64u

/* Bits of mesh_input_head.options: whether options are given, and which of their parts are not zero. */
#define OPTIONS_GIVEN    1u
#define OPTIONS_GRID     2u
#define OPTIONS_CAPACITY 4u
#define OPTIONS_NEED_ANY 8u /* need is used unchanged, else modulo 32 */

/* The first bytes of an input; the arrays follow in the order of svo_mesh. */
typedef struct mesh_input_head {
    uint8_t depth; /* modulo the largest + 2 */
    uint8_t position_form; /* modulo POSITION_FORMS */
    uint8_t arrays;
    uint8_t options;
    uint8_t coverage; /* modulo their number + 1 */
    uint8_t vertex_count, triangle_count, material_count, texture_count;
    uint8_t weights; /* modulo their number + 1 */
    uint8_t reserved[2];
    uint32_t need;
    uint32_t chunk_kibibytes; /* the list is split into chunks of this size if above 16 */
    double origin[3], edge;
    uint64_t fragment_capacity;
} mesh_input_head;

#define MESH_INPUT_ARRAYS_MAX (16 + UINT8_MAX)

typedef struct mesh_input {
    svo_mesh mesh;
    svo_plan_options options;
    bool options_given;
    unsigned depth;
    uint64_t chunk_bytes;
    uint64_t seed; /* for choices that take no bytes of the input */
    void *arrays[MESH_INPUT_ARRAYS_MAX]; /* owned */
    size_t array_count;
} mesh_input;

void mesh_input_read(mesh_input *input, const uint8_t *data, size_t byte_count);
void mesh_input_free(mesh_input *input);

/* Coordinate `axis` of a vertex as the library reads it: a double. */
double mesh_input_coordinate(const mesh_input *input, size_t vertex, unsigned axis);

#endif
