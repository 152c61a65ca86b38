/* SPDX-License-Identifier: MIT */
/*
 * The data of a plan: the snapped mesh, the draws, the configuration of a build, its buffers. plan.c and the other
 * files of this folder fill it; front ends and stages read it.
 *
 * The files of this room:
 *
 *   plan           svo_plan: checks a request, and takes the mesh on the host or by kernels
 *   grid           on the host: accepts triangles, fits the grid, snaps, classifies
 *   voxel_grid     the grid with voxels of a given width, for callers
 *   closed         whether a mesh is closed
 *   attributes     payload inputs, and payload that is the same in every node
 *   device_plan    grid and attributes by kernels
 *   arrays         the mesh's and the plan's arrays, between host and device
 *   estimate       how many fragments and nodes a plan has to expect
 *   chunking       the cut of the fragment list into chunks, and of large triangles into tiles
 *   configuration  what a build does, leaves out and compiles; the choice of a front end
 *   accounts       what a running call tells its callback, and the bytes that it holds
 *   update         plans whose mesh moves
 *   part           the header of all parts of a tree
 *   proof          known answers of the kernels (core/proof.h), on the meshes of proof_mesh
 */
#ifndef SVO_LIB_PLAN_PLAN_DATA_H
#define SVO_LIB_PLAN_PLAN_DATA_H

#include <stdbool.h>

#include "core/program.h"
#include "shared/layout.h"
#include "svocl/build.h"
#include "svocl/plan.h"

/* Variants of the overlap test in kernels/stages/voxelize.cl; kernels/shared/overlap.clh explains them. */
typedef enum svo_i_test {
    SVO_I_TEST_NONE = 0, /* no test: every triangle is inside one voxel */
    SVO_I_TEST_NARROW, /* 32-bit edge functions */
    SVO_I_TEST_REGULAR, /* 64-bit edge functions */
    SVO_I_TEST_WIDE, /* plane test in 93 bits */
    SVO_I_TEST_COUNT
} svo_i_test;

#define SVO_I_LEFT_OUT_MAX  24
#define SVO_I_DEFINES_BYTES 256
/* Most programs of the stages of one plan, besides those of front ends; a voxelizer adds one per test. */
#define SVO_I_STAGE_PROGRAMS_MAX 8
#define SVO_I_KERNELS_MAX        (SVO_I_STAGE_PROGRAMS_MAX + SVO_I_TEST_COUNT)

typedef struct svo_i_left_out {
    const char *what; /* static string */
    svo_message reason;
} svo_i_left_out;

/* The configuration of a build: what runs, and what is left out. */
typedef struct svo_i_work {
    uint32_t made; /* svo_need bits of payload that kernels compute per node */
    uint32_t constant; /* svo_need bits of payload that is the same in every node */
    uint32_t constant_color; /* RGBA8 */
    int16_t constant_normal[3];
    uint16_t constant_material;

    bool sorted; /* SVO_BUILDER_SORTED: nodes from the sorted list */
    bool lists; /* sorted leaf lists */
    bool ranges; /* the range of each leaf's entries: for leaf lists or materials */
    bool filter; /* color, normal or fill per node, or projected areas */
    bool drop; /* some pair may have too little alpha */
    bool surface; /* some stage reads the mesh's attributes */
    bool order; /* fragments in the order of their leaves, for kernels/stages/pairs.cl */
    bool pair_lanes; /* pairs are evaluated eight at a time: on CPUs whose doubles are known to be exact */
    bool positions; /* some stage reads vertex positions to weigh or clip a triangle's part in a voxel */
    bool both_sides; /* projected areas: the mesh is open, and its triangles count from both sides */
    bool vertex_colors, vertex_normals, textures; /* inputs that vary over the mesh and are read */
    bool long_codes; /* Morton codes of more than 32 bits */
    bool tests[SVO_I_TEST_COUNT]; /* the variants of the overlap test that run */

    /* The programs: name and -D options. */
    struct {
        const char *name;
        char defines[SVO_I_DEFINES_BYTES];
    } kernels[SVO_I_KERNELS_MAX];
    size_t kernels_count;

    svo_i_left_out left_out[SVO_I_LEFT_OUT_MAX];
    size_t left_out_count;
} svo_i_work;

/* A coordinate of a mesh that the host has. */
static inline double svo_i_mesh_coordinate(const svo_mesh *mesh, size_t vertex, unsigned axis)
{
    const size_t index = vertex * 3 + axis;
    return mesh->positions_double != NULL ? mesh->positions_double[index] : (double)mesh->positions[index];
}

/* Classes of triangles, by the arithmetic that their overlap test needs; see kernels/shared/overlap.clh. */
typedef enum svo_i_class {
    SVO_I_CLASS_POINT = 0, /* inside one voxel: no test */
    SVO_I_CLASS_NARROW, /* at most SVO_NARROW_VOXELS wide: 32 bits */
    SVO_I_CLASS_REGULAR, /* inside a grid of 2^20 units: 64 bits */
    SVO_I_CLASS_WIDE, /* reaches outside the grid, or the grid is finer: 93 bits */
    SVO_I_CLASS_COUNT
} svo_i_class;

/* Width and height of a viewport in pixels, as a power of two. Larger grids are drawn viewport by viewport. Float
   positions in a viewport of this size are accurate enough. */
#define SVO_I_VIEW_LOG2 13u

/* A draw writes to one chunk of the list: consecutive items of one class, in a tile of the grid's projection. The tile
   is a viewport, or smaller for a single triangle that is too large for a chunk. */
typedef struct svo_i_draw {
    svo_i_class class_id;
    uint32_t first_item, item_count;
    uint32_t tile_x, tile_y, tile_width, tile_height; /* pixels */
} svo_i_draw;

typedef struct svo_i_chunk {
    uint32_t first_draw, draw_count;
    uint64_t capacity; /* fragments */
} svo_i_chunk;

struct svo_i_tile_cache; /* chunking.h */

/* The cut of the list into chunks of limited size. */
typedef struct svo_i_chunking {
    const svo_i_memory *memory; /* where the arrays come from */
    svo_i_draw *draws;
    uint32_t draw_count, draw_capacity;
    svo_i_chunk *chunks;
    uint32_t chunk_count, chunk_capacity;
    uint32_t most_columns; /* triangles of more are drawn by others; 0: none are */
    struct svo_i_tile_cache *tile_cache; /* borrowed; for a list of one chunk that is drawn repeatedly; NULL: none */
} svo_i_chunking;

/* Fragments and nodes are counted in 32 bits, and scans round their number up. */
#define SVO_I_FRAGMENTS_MAX (UINT32_MAX - 65536u)

#define SVO_I_BUFFERS_MAX 48

/* svo_need bits of payload that stages/filter.c computes for all levels, and of all payload. */
#define SVO_I_NEED_FILTER  ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_FILL)
#define SVO_I_NEED_PAYLOAD (SVO_I_NEED_FILTER | (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_PROJECTED_AREA)

/* Unit of fill: a node's face is 2^SVO_I_FILL_LOG2. */
#define SVO_I_FILL_LOG2 12u
/* Limits on the weight of a voxel's face, as a power of two: fills must be representable, and pairs of the largest area
   in a voxel fit 32 bits. */
#define SVO_I_WEIGHT_LOG2_MIN (SVO_I_FILL_LOG2 + 1u)
#define SVO_I_WEIGHT_LOG2_MAX 30u

struct svo_i_build; /* stages/build_state.h */

/* What the size of a buffer depends on. */
typedef enum svo_i_basis { SVO_I_OF_MESH, SVO_I_OF_FRAGMENTS, SVO_I_OF_LEAVES, SVO_I_OF_NODES } svo_i_basis;

typedef struct svo_i_buffer_kind {
    const char *name;
    svo_i_basis basis;
    bool persistent; /* part of the tree */
} svo_i_buffer_kind;

/* A row of the table of stages: all that plans and builds know of a stage. */
typedef struct svo_i_stage {
    const char *name;
    svo_stage stage; /* under which its time is reported */
    bool (*runs)(const svo_plan *plan); /* whether builds of the plan need the stage */
    /* Runs the stage; earlier stages have run. NULL: a front end or another stage runs it. */
    svo_status (*run)(struct svo_i_build *build);
    /* What the plan lists as left out when the stage does not run, and why. NULL: nothing. */
    const char *left_out;
    const char *(*reason)(const svo_plan *plan); /* returns a static string */
    const svo_i_program *program; /* that its kernels are part of */
    /* Writes the defines that select its kernels, a space before each. NULL: none. */
    void (*defines)(const svo_plan *plan, char *text, size_t bytes);
    double item_ns; /* rough time of a work-item in nanoseconds, for the progress; stages may set a better one */
    /* All buffers that the stage may allocate. */
    const svo_i_buffer_kind *buffers; /* the last has no name */
} svo_i_stage;

/* The progress of the call that is running on a plan; plan/accounts.h has the functions. */
typedef struct svo_i_progress {
    svo_progress_callback callback; /* NULL: nobody asks */
    void *user;
    const char *function; /* that is running, for the message */
    uint32_t stages; /* bits of the svo_stages that the running call goes through */
    double expected_ns[SVO_STAGE_COUNT]; /* predicted times */
    double done_ns[SVO_STAGE_COUNT]; /* of those, what is done */
    double untold_ns; /* done since the callback was called */
    double fraction; /* that it was told */
} svo_i_progress;

/* Sums over the kept triangles, in grid units: of their widths, and of twice the areas of their projections in two
   parts, below and from 2^32 on. */
typedef struct svo_i_sums {
    uint64_t widths, areas_low, areas_high;
} svo_i_sums;

/* The arrays of a plan that kernels made, in place of the host's; all NULL in other plans. */
typedef struct svo_i_plan_memory {
    cl_mem vertices, indices, triangle_ids, items, item_fragments;
    cl_mem remainders; /* NULL without payload */
    cl_mem positions, positions_double; /* at most one */
    cl_mem records, colors, normals, uvs; /* NULL where the request does not read them or the mesh has none */
} svo_i_plan_memory;

/* The place of a part in the whole tree; header.depth is 0 in a plan of a whole tree. */
typedef struct svo_i_plan_part {
    svo_part_header header;
    uint32_t level;
    uint64_t code;
    int32_t corner[3]; /* minimum corner of the part in the whole grid, grid units */
    uint32_t *positions; /* of the kept triangles among those that the whole keeps; NULL once triangle_ids has them */
} svo_i_plan_part;

struct svo_i_update; /* update.h */

struct svo_plan {
    svo_device *device;
    struct svo_i_update *update; /* of a plan that is updatable; else NULL */
    svo_i_progress progress;
    svo_plan_info info;
    svo_plan_options options;
    svo_i_plan_part part;
    bool has_grid; /* info has it before the mesh is taken: part.c */
    svo_i_work work; /* what a build does */
    const svo_i_stage *stages; /* the table of stages, in stages/stage_table.c */
    size_t stage_count;
    uint32_t voxel_log2; /* edge of a voxel in grid units */
    uint32_t least_alpha; /* 1 .. 255: pairs of less alpha are dropped; 0: none are */

    svo_i_plan_memory memory; /* plan/arrays.h brings it to the host */
    /* The snapped mesh. Vertices that no kept triangle uses are 0. */
    int32_t *vertices; /* vertex_count * 3 */
    uint64_t *remainders; /* vertex_count: what vertices lack in sub-units (shared/fine.clh); NULL without payload */
    uint32_t vertex_count;
    uint32_t *indices; /* triangle_count * 3 */
    uint32_t *triangle_ids; /* mesh indices of the kept triangles: accepted and not outside the grid */
    uint32_t triangle_count;
    /* The same vertices as the mesh has them, in one of these arrays; both NULL where no ray meets triangles. */
    float *positions; /* vertex_count * 3 */
    double *positions_double;

    /* The draw items: kept triangles, sorted by class and, within blocks of the mesh, by size (grid.c). In an updatable
       plan each class has room for all triangles, and its other items are SVO_DRAW_NOTHING; triangle_count is that of
       the mesh. */
    svo_draw_item *items;
    float *item_fragments; /* expected fragments of each item */
    uint32_t class_begin[SVO_I_CLASS_COUNT + 1];
    svo_i_sums sums;
    double estimate[3]; /* of the kept triangles: their number, sum of widths, of projected areas; in grid units */
    svo_large_item *large; /* those of more than SVO_TILE_COLUMNS columns, by item */
    uint32_t large_count;

    /* Payload inputs; NULL where the request does not read them or the mesh has none. */
    svo_triangle_record *records;
    uint32_t *colors; /* RGBA8 per vertex */
    int16_t *normals; /* x, y, z, 0 per vertex */
    const int16_t *exact_normals; /* svo_i_plan_input.exact_normals, while the plan is made */
    int32_t *uvs; /* u, v per vertex, 65536 = 1 */
    svo_material_record *materials;
    uint32_t material_count; /* at least 1 */
    bool materials_vary; /* the kept triangles have more than one material */
    bool one_normal; /* all normals are work.constant_normal */
    uint32_t *texels;
    uint64_t texel_count;
    size_t textures_given, textures_used; /* textures of the mesh, and of kept triangles */
    uint32_t weight_log2; /* weight of a voxel's face, as a power of two; SVO_I_WEIGHT_LOG2_MIN and more */

    /* The buffers that a build allocates. */
    svo_buffer_info buffers[SVO_I_BUFFERS_MAX];
    size_t buffer_count;
    uint64_t live_bytes, peak_bytes;
    uint64_t predicted_bytes, predicted_tree_bytes; /* peak_bytes and the tree's bytes before the first build */
    bool counted; /* the capacity of the list is the exact number of fragments */
    bool built; /* buffers are those of a build, not a prediction */
};

/* Whether a plan is that of a part of a larger tree. */
static inline bool svo_i_plan_is_part(const svo_plan *plan)
{
    return plan->part.header.depth != 0;
}

/* Whether payload or its inputs are asked for, before it is known what the mesh has. */
static inline bool svo_i_plan_asks_payload(const svo_plan *plan)
{
    return plan->options.need == SVO_NEED_DEFAULT || (plan->options.need & SVO_I_NEED_PAYLOAD) != 0 ||
           plan->least_alpha != 0;
}

/* svo_need bits of payload whose inputs the plan takes from the mesh: alpha is that of colors. */
static inline uint32_t svo_i_plan_reads(const svo_plan *plan)
{
    return (plan->info.need & SVO_I_NEED_PAYLOAD) | (plan->least_alpha != 0 ? (uint32_t)SVO_NEED_COLOR : 0u);
}

/* Whether trees have the mesh's own positions, for rays that meet triangles. */
static inline bool svo_i_plan_stores_positions(const svo_plan *plan)
{
    return (plan->info.need & SVO_NEED_RAYS) != 0 && plan->info.coverage != SVO_COVERAGE_THIN;
}

/* Whether a level above the part sums up its root's payload. */
static inline bool svo_i_part_sums_root(const svo_plan *plan)
{
    return svo_i_plan_is_part(plan) && plan->part.header.payload_level < plan->part.level;
}

#endif
