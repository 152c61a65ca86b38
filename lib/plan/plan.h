/* SPDX-License-Identifier: MIT */
/*
 * The plan's insides: the snapped mesh, what to draw, what to allocate. Made by plan.c with grid.c (grid, snap,
 * classes) and attributes.c (payload inputs); read by the front ends and the builder.
 */
#ifndef SVO_LIB_PLAN_PLAN_H
#define SVO_LIB_PLAN_PLAN_H

#include <stdbool.h>

#include "core/device.h"
#include "plan/configuration.h"
#include "shared/layout.h"
#include "svocl/plan.h"

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

/* How the list is cut; made for a limit on the bytes of a chunk. */
typedef struct svo_i_layout {
    svo_i_draw *draws;
    uint32_t draw_count, draw_capacity;
    svo_i_chunk *chunks;
    uint32_t chunk_count, chunk_capacity;
} svo_i_layout;

/* Fragments and nodes are counted in 32 bits, and scans run over whole tiles of them. */
#define SVO_I_FRAGMENTS_MAX (UINT32_MAX - 65536u)

#define SVO_I_BUFFERS_MAX 48

/* The needs that are means or sums over triangles (filter.c), and all that are made of the mesh's attributes. */
#define SVO_I_NEED_FILTER  ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_FILL)
#define SVO_I_NEED_PAYLOAD (SVO_I_NEED_FILTER | (uint32_t)SVO_NEED_MATERIAL)

/* A node's face as its fill counts it. */
#define SVO_I_FILL_LOG2 12u

struct svo_plan {
    svo_device *device;
    svo_plan_info info;
    svo_plan_options options;
    svo_i_work work; /* what a build does */
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

SVO_I_SHARED_BEGIN

/* grid.c: fills the snapped mesh, items and law from the mesh. */
svo_status svo_i_plan_grid(svo_plan *plan, const svo_mesh *mesh);
/* grid.c: twice the areas of a snapped triangle's projections along x, y, z, with sign: its normal. Exact: at most
   2^61. */
void svo_i_plan_normal(const svo_plan *plan, const uint32_t corners[3], int64_t normal[3]);
/* attributes.c: resolves need and fills the payload inputs. */
svo_status svo_i_plan_attributes(svo_plan *plan, const svo_mesh *mesh);
/* constant.c: vertex colors that are all the same become part of the materials; normals that are, of the plan. */
void svo_i_plan_fold_colors(svo_plan *plan);
void svo_i_plan_fold_normals(svo_plan *plan);
/* constant.c: which payload is the same in every node. Frees its inputs. */
void svo_i_plan_find_constants(svo_plan *plan);

/* decide.c: fills plan->work, the last step before sizes are predicted. */
void svo_i_plan_configure(svo_plan *plan);
/* decide.c: the -D keys, a space before each, of the builder's kernels; of those that sort the list for it; and of a
   variant of the OpenCL front end's. bytes: SVO_I_DEFINES_BYTES are enough. */
void svo_i_plan_defines(const svo_plan *plan, char *defines, size_t bytes);
const char *svo_i_plan_sort_defines(const svo_plan *plan);
void svo_i_plan_test_defines(const svo_plan *plan, svo_i_test test, char *defines, size_t bytes);

/* law.c: adds a kept triangle to the fragment estimate; returns the fragments expected of it alone. */
float svo_i_estimate_add(svo_plan *plan, const uint32_t corners[3]);
/* law.c: fragments expected at a level. */
double svo_i_plan_expected(const svo_plan *plan, uint32_t level);
/* law.c: room for that many expected fragments: some slack for scenes that do not lie at random. */
uint64_t svo_i_with_slack(double expected);
uint32_t svo_i_plan_fragment_bytes(const svo_plan *plan);
/* Nodes an inner level may have, and the whole tree on all inner levels, given the number of fragments: the fragment
   estimate with slack, or what cannot be exceeded. */
uint64_t svo_i_plan_level_nodes(const svo_plan *plan, uint32_t level, uint64_t fragments, bool worst_case);
uint64_t svo_i_plan_inner_nodes(const svo_plan *plan, uint64_t fragments, bool worst_case);

/* layout.c: cuts the list. needed: NULL, or per chunk of *layout how many fragments it turned out to need, then *layout
   is replaced by one in which those fit. */
svo_status svo_i_layout_create(const svo_plan *plan, uint64_t chunk_bytes, svo_i_layout *layout);
svo_status svo_i_layout_grow(const svo_plan *plan, uint64_t chunk_bytes, const uint64_t *needed, svo_i_layout *layout);
void svo_i_layout_destroy(svo_i_layout *layout);

/* predict.c: what a build will allocate. */
svo_status svo_i_plan_predict(svo_plan *plan);

/* predict.c: the list of buffers: begin anew, one more, one less. */
void svo_i_plan_buffers_reset(svo_plan *plan);
void svo_i_plan_buffer_add(svo_plan *plan, const char *name, uint64_t bytes);
void svo_i_plan_buffer_remove(svo_plan *plan, uint64_t bytes);

SVO_I_SHARED_END

#endif
