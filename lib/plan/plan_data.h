/* SPDX-License-Identifier: MIT */
/*
 * The data of a plan: the snapped mesh, what to draw, what a build does, what it allocates. Made by plan.c and its
 * neighbors in this folder; read by the front ends and the stages.
 */
#ifndef SVO_LIB_PLAN_PLAN_DATA_H
#define SVO_LIB_PLAN_PLAN_DATA_H

#include <stdbool.h>

#include "core/program.h"
#include "shared/layout.h"
#include "svocl/build.h"
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

    /* The programs of kernels: name and -D options. */
    struct {
        const char *name;
        char defines[SVO_I_DEFINES_BYTES];
    } kernels[SVO_I_KERNELS_MAX];
    size_t kernels_count;

    svo_i_left_out left_out[SVO_I_LEFT_OUT_MAX];
    size_t left_out_count;
} svo_i_work;

/* Triangles by the arithmetic their overlap test needs; see kernels/overlap.clh. */
typedef enum svo_i_class {
    SVO_I_CLASS_POINT = 0, /* inside one voxel: no test */
    SVO_I_CLASS_NARROW, /* bounding box of voxels up to 2^14 units: lines in 32 bits */
    SVO_I_CLASS_REGULAR, /* inside a grid of 2^20 units: 64 bits */
    SVO_I_CLASS_WIDE, /* reaching outside, or on a finer grid: the plane in 93 bits */
    SVO_I_CLASS_COUNT
} svo_i_class;

/* Pixels of a viewport, both ways, as a power of two: grids of more voxels are drawn viewport by viewport. Positions in
   a viewport of this size are exact enough in float. */
#define SVO_I_VIEW_LOG2 13u

/* A part of the drawing that goes to one chunk of the list: consecutive items of one class, in a tile of the grid's
   projection (a viewport, or less for single triangles too large for a chunk). */
typedef struct svo_i_draw {
    svo_i_class class_id;
    uint32_t first_item, item_count;
    uint32_t tile_x, tile_y, tile_width, tile_height; /* pixels */
} svo_i_draw;

typedef struct svo_i_chunk {
    uint32_t first_draw, draw_count;
    uint64_t capacity; /* fragments */
} svo_i_chunk;

struct svo_i_tile_cache; /* tiles.h */

/* How the list is cut into chunks of a limited size. */
typedef struct svo_i_chunking {
    svo_i_draw *draws;
    uint32_t draw_count, draw_capacity;
    svo_i_chunk *chunks;
    uint32_t chunk_count, chunk_capacity;
    struct svo_i_tile_cache *tile_cache; /* borrowed; of a list of one chunk that is drawn many times; NULL: none */
} svo_i_chunking;

/* Fragments and nodes are counted in 32 bits, and scans run over whole tiles of them. */
#define SVO_I_FRAGMENTS_MAX (UINT32_MAX - 65536u)

#define SVO_I_BUFFERS_MAX 48

/* The needs that are means or sums over triangles (filter.c), and all that are made of the mesh's attributes. */
#define SVO_I_NEED_FILTER  ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_FILL)
#define SVO_I_NEED_PAYLOAD (SVO_I_NEED_FILTER | (uint32_t)SVO_NEED_MATERIAL)

/* A node's face as its fill counts it. */
#define SVO_I_FILL_LOG2 12u

struct svo_i_build; /* stages/build_state.h */

/* What the number of bytes of a buffer follows from. */
typedef enum svo_i_basis { SVO_I_OF_MESH, SVO_I_OF_FRAGMENTS, SVO_I_OF_LEAVES, SVO_I_OF_NODES } svo_i_basis;

typedef struct svo_i_buffer_kind {
    const char *name;
    svo_i_basis basis;
    bool persistent; /* part of the tree */
} svo_i_buffer_kind;

#define SVO_I_STAGE_KERNELS_MAX 8
#define SVO_I_STAGE_BUFFERS_MAX 14

/* One row of the table of stages: all that the plan and the build know of a stage. */
typedef struct svo_i_stage {
    const char *name;
    svo_stage stage; /* what its time is counted as */
    bool (*runs)(const svo_plan *plan);
    /* The launches, in a build whose earlier stages are done. NULL: the front end runs it. */
    svo_status (*run)(struct svo_i_build *build);
    /* What the plan says when it does not run; NULL: nothing. */
    const char *left_out;
    const char *(*reason)(const svo_plan *plan); /* static string */
    /* The program its kernels are part of, and the defines that select them: appended to text, a space before each. */
    svo_i_program_kind program;
    void (*defines)(const svo_plan *plan, char *text, size_t bytes);
    const char *kernels[SVO_I_STAGE_KERNELS_MAX];
    /* The buffers it allocates. */
    svo_i_buffer_kind buffers[SVO_I_STAGE_BUFFERS_MAX];
} svo_i_stage;

struct svo_plan {
    svo_device *device;
    svo_plan_info info;
    svo_plan_options options;
    svo_i_work work; /* what a build does */
    const svo_i_stage *stages; /* the table of stages, in the order in which they run; build/stage_table.c */
    size_t stage_count;
    uint32_t voxel_log2; /* edge of a voxel in grid units */

    /* The snapped mesh. Vertices no kept triangle uses are 0. */
    int32_t *vertices; /* vertex_count * 3 */
    uint32_t vertex_count;
    uint32_t *indices; /* triangle_count * 3 */
    uint32_t *triangle_ids; /* of the kept triangles: accepted, and not outside */
    uint32_t triangle_count;

    /* What to draw: kept triangles by class. */
    svo_draw_item *items;
    float *item_fragments; /* expected, parallel to items */
    uint32_t class_begin[SVO_I_CLASS_COUNT + 1];
    double estimate[3]; /* sums over the kept triangles: 1, widths, projected areas; in grid units */

    /* Payload inputs; NULL where the request or the mesh has no use for them. */
    svo_triangle_record *records;
    uint32_t *colors; /* RGBA8 per vertex */
    int16_t *normals; /* x, y, z, 0 per vertex */
    int32_t *uvs; /* u, v per vertex, 65536 = 1 */
    svo_material_record *materials;
    uint32_t material_count; /* at least 1 */
    bool materials_vary; /* not all kept triangles have that of the first */
    bool one_normal; /* the same everywhere: work.constant_normal */
    uint32_t *texels;
    uint64_t texel_count;
    size_t textures_given, textures_used; /* of the mesh; by kept triangles */
    uint32_t weight_log2; /* a voxel's face in units of weight, at least SVO_I_FILL_LOG2 + 1 */

    /* What a build allocates. */
    svo_buffer_info buffers[SVO_I_BUFFERS_MAX];
    size_t buffer_count;
    uint64_t live_bytes, peak_bytes;
    uint64_t predicted_bytes; /* peak_bytes before the first build */
    bool counted; /* info.expected_fragments is the real number */
    bool built; /* the list of buffers is a build's, not a prediction */
};

#endif
