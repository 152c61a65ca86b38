/* SPDX-License-Identifier: MIT */
/*
 * What a build of a plan does, and what it leaves out. Decided in one place, decide.c, from the mesh, the request and
 * the depth; the stages, the kernels' keys and the list of buffers obey.
 */
#ifndef SVO_LIB_PLAN_CONFIGURATION_H
#define SVO_LIB_PLAN_CONFIGURATION_H

#include <stdbool.h>

#include "svocl/plan.h"

/* How kernels/voxelize.cl decides whether a triangle touches a voxel. */
typedef enum svo_i_test {
    SVO_I_TEST_NONE = 0, /* every triangle lies inside one voxel */
    SVO_I_TEST_NARROW, /* lines in 32 bits */
    SVO_I_TEST_REGULAR, /* lines in 64 bits */
    SVO_I_TEST_WIDE, /* the plane in 93 bits */
    SVO_I_TEST_COUNT
} svo_i_test;

#define SVO_I_LEFT_OUT_MAX  24
#define SVO_I_DEFINES_BYTES 256
/* Of the builder, of its sort, and one per test. */
#define SVO_I_KERNELS_MAX (2 + SVO_I_TEST_COUNT)

typedef struct svo_i_left_out {
    const char *what; /* static string */
    svo_message reason;
} svo_i_left_out;

typedef struct svo_i_work {
    /* svo_need bits: of the payload that kernels make per node, and of that which is the same in every node. */
    uint32_t made, constant;
    uint32_t constant_color; /* RGBA8 */
    int16_t constant_normal[3];
    uint16_t constant_material;

    bool builder_kernels; /* any of kernels/subdivide.cl to filter.cl; nodes and lists by sorting do without */
    bool sorted; /* nodes are made of the sorted list, else level by level */
    bool lists; /* sorted leaf lists */
    bool ranges; /* where each leaf's entries begin: for the lists, or to choose materials from */
    bool filter; /* means and sums over triangles: color, normal, fill */
    bool surface; /* some stage looks at the mesh's attributes */
    bool places; /* ... at where in the voxel the triangle is */
    bool vertex_colors, vertex_normals, textures; /* that vary over the mesh, and are read */
    bool long_codes; /* Morton codes of more than 32 bits */
    bool tests[SVO_I_TEST_COUNT]; /* which variants of the overlap test run */

    /* The programs of kernels: name and -D keys. */
    struct {
        const char *name;
        char defines[SVO_I_DEFINES_BYTES];
    } kernels[SVO_I_KERNELS_MAX];
    size_t kernels_count;

    svo_i_left_out left_out[SVO_I_LEFT_OUT_MAX];
    size_t left_out_count;
} svo_i_work;

#endif
