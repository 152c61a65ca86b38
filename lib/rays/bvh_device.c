/* SPDX-License-Identifier: MIT */
/*
 * Launches kernels/bvh: items, the binary tree over them, its collapse into nodes of eight children, leaves, and the
 * boxes of nodes. Levels are split and opened several at a time: the host launches as many work-items as a level may
 * have, and kernels read from the state how many it has. What is read back: the reach of the vertices, the number of
 * jobs, and where levels of nodes begin, with the words of all leaves; more often only for trees of many levels.
 */
#include "rays/bvh_device.h"

#include "core/work.h"
#include "rays/bvh_fit.h"
#include "rays/programs.h"
#include "stages/sort.h"

/* Work-items that look through the vertices. */
#define REACH_ITEMS 1024u
/* Numbers that a pass of the sort counts. */
#define SORT_CELLS ((uint64_t)SVO_SORT_DIGITS * SVO_SORT_BLOCKS)
/* Bits of the codes of SVO_BVH_FAST. */
#define CODE_BITS 30
/* Levels more than a balanced tree has, which are launched before the host looks whether there are more. */
#define SPARE_RANGE_LEVELS 5
#define SPARE_NODE_LEVELS  3

/* Temporary buffers. */
typedef enum work_buffer {
    STATE,
    ITEMS_A,
    ITEMS_B,
    LISTED, /* marks of triangles; later the units of leaves */
    PLACES, /* sums of the former */
    RANGES_A,
    RANGES_B,
    JOBS,
    BRANCHES,
    CHUNK_BOXES,
    CHUNK_COUNTS,
    CHUNK_PLACES,
    CHUNK_RANGES,
    FRAGMENTS, /* of SVO_BVH_FAST: codes and items */
    FRAGMENTS_2,
    NODES, /* three words each: see svo_k_bvh_open */
    COUNTS, /* of nodes of the next level, per group of nodes */
    WORK_BUFFERS
} work_buffer;

static const char *const names[WORK_BUFFERS] = {
    "bvh_state",        "bvh_items",     "bvh_items_2",     "bvh_listed",      "bvh_places",       "bvh_ranges",
    "bvh_ranges_2",     "bvh_jobs",      "bvh_branches",    "bvh_chunk_boxes", "bvh_chunk_counts", "bvh_chunk_places",
    "bvh_chunk_ranges", "bvh_fragments", "bvh_fragments_2", "bvh_nodes",       "bvh_counts"};

typedef struct maker {
    svo_i_device_work work;
    const svo_i_bvh_mesh *mesh;
    svo_i_device_bvh *out;
    cl_mem buffers[WORK_BUFFERS]; /* of the work */
    svo_bvh_params params;
    svo_bvh_state state; /* as read last */
    uint32_t units; /* of 16 bytes, of all leaves beside the empty one */
} maker;

/* ---- buffers ---- */

/* Makes those of the temporary buffers that have bytes. */
static svo_status make_works(maker *m, const uint64_t bytes[WORK_BUFFERS])
{
    for (int i = 0; i < WORK_BUFFERS; ++i) {
        if (bytes[i] > 0) {
            SVO_I_TRY(svo_i_work_alloc(&m->work, names[i], bytes[i], &m->buffers[i]));
        }
    }
    return SVO_OK;
}

/* The most nodes: a node has eight children unless all of them are leaves, and those of a lowest node hold more
   triangles than a leaf. */
static uint64_t nodes_max(uint64_t item_count)
{
    return item_count / 7 + 1;
}

/* ---- launches ---- */

static svo_status run(maker *m, const char *name, const svo_i_argument *arguments, cl_uint argument_count,
                      uint64_t items)
{
    return svo_i_work_launch(&m->work, name, arguments, argument_count, items);
}

/* So many groups of the work-items that share a chunk, a range or a job: see kernels/bvh/lanes.clh. */
static svo_status run_lanes(maker *m, const char *name, const svo_i_argument *arguments, cl_uint argument_count,
                            uint64_t groups)
{
    const size_t lanes = svo_i_bvh_lanes(m->work.device);
    return svo_i_work_launch_groups(&m->work, name, arguments, argument_count, groups * lanes, lanes);
}

/* A kernel for one work-item. */
static svo_status run_one(maker *m, const char *name, const svo_i_argument *arguments, cl_uint argument_count)
{
    return svo_i_work_launch_groups(&m->work, name, arguments, argument_count, 1, 1);
}

/* Exclusive sums of so many numbers of LISTED into PLACES, and all of them after the last, which *total receives. */
static svo_status scan(maker *m, uint32_t count, uint32_t *total)
{
    SVO_I_TRY(svo_i_work_scan(&m->work, m->buffers[LISTED], m->buffers[PLACES], count));
    return svo_i_work_read(&m->work, m->buffers[PLACES], (uint64_t)count * sizeof(cl_uint), total, sizeof *total);
}

static svo_status read_state(maker *m)
{
    return svo_i_work_read(&m->work, m->buffers[STATE], 0, &m->state, sizeof m->state);
}

/* ---- items ---- */

/* Counts the triangles that the tree lists, and places them. */
static svo_status place_listed(maker *m)
{
    const uint32_t count = m->mesh->triangle_count;
    const cl_uint list_count = (cl_uint)m->mesh->list_count;
    const svo_i_argument mark[] = {SVO_I_ARGUMENT(m->mesh->list), SVO_I_ARGUMENT(m->buffers[LISTED]),
                                   SVO_I_ARGUMENT(list_count), SVO_I_ARGUMENT(m->mesh->first_triangle),
                                   SVO_I_ARGUMENT(count)};
    SVO_I_TRY(svo_i_work_fill_zero(&m->work, m->buffers[LISTED], (uint64_t)count * sizeof(cl_uint)));
    SVO_I_TRY(run(m, "svo_k_bvh_mark", SVO_I_ARGUMENTS(mark), list_count));
    m->params.use_list = 1;
    return scan(m, count, &m->params.item_count);
}

/* Finds the reach of the vertices, and whether the device fuses. */
static svo_status find_reach(maker *m)
{
    const cl_uint first_vertex = (cl_uint)m->mesh->first_vertex;
    const cl_uint vertex_count = (cl_uint)m->mesh->vertex_count;
    /* See svo_bvh_fuses of kernels/bvh/fusion.clh. */
    const cl_float4 factors = {{0x1.000002p0F, 0x1.000006p0F, 0x1.000002p0F, 0x1.000006p0F}};
    const svo_i_argument reach[] = {SVO_I_ARGUMENT(m->mesh->vertices),  SVO_I_ARGUMENT(m->buffers[STATE]),
                                    SVO_I_ARGUMENT(first_vertex),       SVO_I_ARGUMENT(vertex_count),
                                    SVO_I_ARGUMENT(m->mesh->snap_bits), SVO_I_ARGUMENT(factors)};
    SVO_I_TRY(svo_i_work_fill_zero(&m->work, m->buffers[STATE], sizeof(svo_bvh_state)));
    return run(m, "svo_k_bvh_reach", SVO_I_ARGUMENTS(reach), REACH_ITEMS);
}

/* The same, and how many triangles the BVH holds. Refuses a device on which rays are wrong. */
static svo_status find_extent(maker *m)
{
    const float width = (float)(1u << m->mesh->snap_bits);
    const svo_bvh_state *state = &m->state;
    SVO_I_TRY(find_reach(m));
    SVO_I_TRY(read_state(m));
    if (state->fuses != 0) {
        return svo_i_device_fail(m->work.device, SVO_UNSUPPORTED,
                                 "%s: %s fuses multiplications and additions although the kernels forbid it, so rays "
                                 "could pass between triangles",
                                 m->work.function, m->work.device->name);
    }
    m->out->reach = (float)state->reach > width ? (float)state->reach : width;
    m->out->clips = state->outside != 0;
    m->params.item_count = m->mesh->triangle_count;
    return state->outside != 0 && m->params.item_count > 0 ? place_listed(m) : SVO_OK;
}

/* Buffers whose sizes follow from the number of triangles. */
static svo_status make_first_buffers(maker *m)
{
    const uint64_t count = m->mesh->triangle_count > SORT_CELLS ? m->mesh->triangle_count : SORT_CELLS;
    const uint64_t bytes[WORK_BUFFERS] = {[STATE] = sizeof(svo_bvh_state),
                                          [LISTED] = (count + 1) * sizeof(cl_uint),
                                          [PLACES] = (count + 1) * sizeof(cl_uint)};
    return make_works(m, bytes);
}

static svo_status make_shape(maker *m, svo_i_bvh_shape_buffer which, const char *name, uint64_t bytes)
{
    return svo_i_work_result(&m->work, name, bytes, &m->out->shape[which]);
}

/* Keeps a temporary buffer, which the fit uses once the binary tree is made. */
static svo_status keep_shape(maker *m, svo_i_bvh_shape_buffer which, work_buffer from)
{
    const cl_int error = clRetainMemObject(m->buffers[from]);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(m->work.device, m->work.function, "clRetainMemObject", error);
    }
    m->out->shape[which] = m->buffers[from];
    return SVO_OK;
}

/* The most ranges of a level: there are no more than jobs' worth of items. */
static uint64_t ranges_max(const maker *m)
{
    return m->params.item_count / m->params.subtree_items + 1;
}

/* The most chunks of so many ranges. */
static uint64_t chunks_max(const maker *m, uint64_t ranges)
{
    return m->params.item_count / m->params.chunk_items + ranges;
}

/* Buffers whose sizes follow from the number of items. */
static svo_status make_buffers(maker *m)
{
    const bool fast = m->out->quality == SVO_BVH_FAST;
    const uint64_t count = m->params.item_count;
    const uint64_t ranges = ranges_max(m);
    const uint64_t chunks = fast ? 0 : chunks_max(m, ranges);
    const uint64_t jobs = SVO_BVH_DEPTH_MAX * ranges + 1;
    const uint64_t bytes[WORK_BUFFERS] = {
        [ITEMS_A] = (count + 1) * sizeof(cl_float8),
        [ITEMS_B] = (count + 1) * sizeof(cl_float8),
        [RANGES_A] = (fast ? 1 : ranges) * sizeof(svo_bvh_range),
        [RANGES_B] = fast ? 0 : ranges * sizeof(svo_bvh_range),
        [JOBS] = (jobs < count + 1 ? jobs : count + 1) * sizeof(svo_bvh_job),
        [BRANCHES] = (count + 1) * sizeof(svo_bvh_branch),
        [CHUNK_BOXES] = chunks * SVO_BVH_CELLS * sizeof(cl_float8),
        [CHUNK_COUNTS] = chunks * SVO_BVH_CELLS * sizeof(cl_uint),
        [CHUNK_PLACES] = chunks * sizeof(cl_uint2),
        [CHUNK_RANGES] = chunks * sizeof(cl_uint),
        [FRAGMENTS] = fast ? (count + 1) * SVO_FRAGMENT_WORDS_30 * sizeof(cl_uint) : 0,
        [FRAGMENTS_2] = fast ? (count + 1) * SVO_FRAGMENT_WORDS_30 * sizeof(cl_uint) : 0,
        [NODES] = nodes_max(count) * 3 * sizeof(cl_uint),
        [COUNTS] = (nodes_max(count) / SVO_GROUP_ITEMS + 1) * sizeof(cl_uint),
    };
    SVO_I_TRY(make_works(m, bytes));
    SVO_I_TRY(make_shape(m, SVO_I_BVH_CHILDREN, "bvh_children", nodes_max(count) * sizeof(svo_bvh_children)));
    SVO_I_TRY(make_shape(m, SVO_I_BVH_ORDER, "bvh_order", (count + 1) * sizeof(cl_uint)));
    SVO_I_TRY(make_shape(m, SVO_I_BVH_ITEM_COUNTS, "bvh_item_counts", (count + 1) * sizeof(cl_uint)));
    SVO_I_TRY(keep_shape(m, SVO_I_BVH_PLACES, PLACES));
    SVO_I_TRY(keep_shape(m, SVO_I_BVH_LEAF_BOXES, ITEMS_A));
    return keep_shape(m, SVO_I_BVH_NODE_BOXES, ITEMS_B);
}

/* Groups beyond the ranges and chunks of a level return at once, but Intel's driver for CPUs reads what these would
   name before: so they name the first ones. */
static svo_status clear_levels(maker *m)
{
    const uint64_t ranges = ranges_max(m);
    const uint64_t chunks = chunks_max(m, ranges);
    SVO_I_TRY(svo_i_work_fill_zero(&m->work, m->buffers[RANGES_A], ranges * sizeof(svo_bvh_range)));
    SVO_I_TRY(svo_i_work_fill_zero(&m->work, m->buffers[RANGES_B], ranges * sizeof(svo_bvh_range)));
    SVO_I_TRY(svo_i_work_fill_zero(&m->work, m->buffers[CHUNK_RANGES], chunks * sizeof(cl_uint)));
    return svo_i_work_fill_zero(&m->work, m->buffers[CHUNK_PLACES], chunks * sizeof(cl_uint2));
}

/* The root, and the items with the bounds of their centers. */
static svo_status make_items(maker *m)
{
    const svo_i_bvh_mesh *mesh = m->mesh;
    const svo_bvh_params *params = &m->params;
    const svo_i_argument begin[] = {SVO_I_ARGUMENT(m->buffers[RANGES_A]), SVO_I_ARGUMENT(m->buffers[JOBS]),
                                    SVO_I_ARGUMENT(m->buffers[BRANCHES]), SVO_I_ARGUMENT(m->buffers[STATE]),
                                    SVO_I_ARGUMENT(*params)};
    const svo_i_argument items[] = {SVO_I_ARGUMENT(mesh->vertices),
                                    SVO_I_ARGUMENT(mesh->indices),
                                    SVO_I_ARGUMENT(mesh->triangle_ids),
                                    SVO_I_ARGUMENT(mesh->first_triangle),
                                    SVO_I_ARGUMENT(m->buffers[LISTED]),
                                    SVO_I_ARGUMENT(m->buffers[PLACES]),
                                    SVO_I_ARGUMENT(m->buffers[ITEMS_A]),
                                    SVO_I_ARGUMENT(m->buffers[RANGES_A]),
                                    SVO_I_ARGUMENT(*params),
                                    SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint))};
    SVO_I_TRY(run_one(m, "svo_k_bvh_begin", SVO_I_ARGUMENTS(begin)));
    return run_lanes(m, "svo_k_bvh_items", SVO_I_ARGUMENTS(items),
                     (mesh->triangle_count + params->chunk_items - 1) / params->chunk_items);
}

/* ---- the binary tree ---- */

/* Of a balanced binary tree: levels until so many items come in parts of so few. */
static uint32_t levels_until(uint64_t items, uint64_t part)
{
    uint32_t levels = 0;
    while (part << levels < items) {
        ++levels;
    }
    return levels;
}

/* Splits all ranges of a level, of which there are no more than that. */
static svo_status split_level(maker *m, uint64_t ranges)
{
    svo_bvh_params *params = &m->params;
    const bool in_b = params->level % 2 != 0;
    cl_mem *work = m->buffers;
    const cl_mem *from = &work[in_b ? ITEMS_B : ITEMS_A], *to = &work[in_b ? ITEMS_A : ITEMS_B];
    const cl_mem *of = &work[in_b ? RANGES_B : RANGES_A], *next = &work[in_b ? RANGES_A : RANGES_B];
    const svo_i_argument room = SVO_I_LOCAL(SVO_BVH_ROOM_BYTES);
    const svo_i_argument bin[] = {SVO_I_ARGUMENT(*of),
                                  SVO_I_ARGUMENT(work[CHUNK_RANGES]),
                                  SVO_I_ARGUMENT(*from),
                                  SVO_I_ARGUMENT(work[CHUNK_BOXES]),
                                  SVO_I_ARGUMENT(work[CHUNK_COUNTS]),
                                  SVO_I_ARGUMENT(work[STATE]),
                                  SVO_I_ARGUMENT(*params),
                                  room};
    const svo_i_argument cut[] = {SVO_I_ARGUMENT(*of),
                                  SVO_I_ARGUMENT(*next),
                                  SVO_I_ARGUMENT(work[JOBS]),
                                  SVO_I_ARGUMENT(work[BRANCHES]),
                                  SVO_I_ARGUMENT(work[CHUNK_BOXES]),
                                  SVO_I_ARGUMENT(work[CHUNK_COUNTS]),
                                  SVO_I_ARGUMENT(work[CHUNK_PLACES]),
                                  SVO_I_ARGUMENT(work[CHUNK_RANGES]),
                                  SVO_I_ARGUMENT(work[STATE]),
                                  SVO_I_ARGUMENT(*params),
                                  room};
    const svo_i_argument part[] = {SVO_I_ARGUMENT(*of),
                                   SVO_I_ARGUMENT(*next),
                                   SVO_I_ARGUMENT(*from),
                                   SVO_I_ARGUMENT(*to),
                                   SVO_I_ARGUMENT(work[CHUNK_PLACES]),
                                   SVO_I_ARGUMENT(work[STATE]),
                                   SVO_I_ARGUMENT(*params),
                                   SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint))};
    SVO_I_TRY(run_lanes(m, "svo_k_bvh_bin", SVO_I_ARGUMENTS(bin), chunks_max(m, ranges)));
    SVO_I_TRY(run_lanes(m, "svo_k_bvh_cut", SVO_I_ARGUMENTS(cut), ranges));
    SVO_I_TRY(run_lanes(m, "svo_k_bvh_part", SVO_I_ARGUMENTS(part), chunks_max(m, ranges)));
    ++params->level;
    return SVO_OK;
}

/* Splits large ranges, all of a level at once, until only jobs are left. */
static svo_status split_levels(maker *m)
{
    const uint32_t levels = levels_until(m->params.item_count, m->params.subtree_items) + SPARE_RANGE_LEVELS;
    const uint64_t most = ranges_max(m);
    uint64_t ranges = m->params.item_count > m->params.subtree_items ? 1 : 0;
    while (ranges > 0 && m->params.level < SVO_BVH_DEPTH_MAX) {
        for (uint32_t i = 0; i < levels && m->params.level < SVO_BVH_DEPTH_MAX; ++i) {
            SVO_I_TRY(split_level(m, ranges));
            ranges = 2 * ranges < most ? 2 * ranges : most;
        }
        SVO_I_TRY(read_state(m));
        ranges = m->state.range_count[m->params.level];
    }
    return SVO_OK;
}

/* Splits all items: large ranges level by level, small ones as jobs. */
static svo_status split_items(maker *m)
{
    cl_mem *work = m->buffers;
    m->state.job_count = m->params.item_count <= m->params.subtree_items ? 1 : 0;
    SVO_I_TRY(split_levels(m));
    const svo_i_argument subtrees[] = {SVO_I_ARGUMENT(work[JOBS]),
                                       SVO_I_ARGUMENT(work[ITEMS_A]),
                                       SVO_I_ARGUMENT(work[ITEMS_B]),
                                       SVO_I_ARGUMENT(work[BRANCHES]),
                                       SVO_I_ARGUMENT(m->out->shape[SVO_I_BVH_ORDER]),
                                       SVO_I_LOCAL(SVO_BVH_ROOM_BYTES)};
    return run_lanes(m, "svo_k_bvh_subtrees", SVO_I_ARGUMENTS(subtrees), m->state.job_count);
}

/* ---- the binary tree of SVO_BVH_FAST ---- */

/* One pass over a digit of the codes; it swaps the list and the spare buffer. */
static svo_status sort_pass(maker *m, uint32_t shift)
{
    cl_mem *work = m->buffers;
    const svo_sort_params params = {.fragment_count = m->params.item_count, .shift = shift, .bits = SVO_SORT_BITS};
    const uint64_t items = (uint64_t)SVO_SORT_BLOCKS * SVO_GROUP_ITEMS;
    const svo_i_argument digits = SVO_I_LOCAL(svo_i_sort_local_bytes(m->work.device));
    const svo_i_argument count[] = {SVO_I_ARGUMENT(work[FRAGMENTS]), SVO_I_ARGUMENT(work[LISTED]),
                                    SVO_I_ARGUMENT(params), digits};
    const svo_i_argument scatter[] = {SVO_I_ARGUMENT(work[FRAGMENTS]), SVO_I_ARGUMENT(work[FRAGMENTS_2]),
                                      SVO_I_ARGUMENT(work[PLACES]), SVO_I_ARGUMENT(params), digits};
    SVO_I_TRY(run(m, "svo_k_sort_count", SVO_I_ARGUMENTS(count), items));
    SVO_I_TRY(svo_i_work_scan(&m->work, work[LISTED], work[PLACES], SORT_CELLS));
    SVO_I_TRY(run(m, "svo_k_sort_scatter", SVO_I_ARGUMENTS(scatter), items));
    cl_mem sorted = work[FRAGMENTS_2];
    work[FRAGMENTS_2] = work[FRAGMENTS];
    work[FRAGMENTS] = sorted;
    return SVO_OK;
}

/* The items in the order of their codes, in the second buffer. */
static svo_status sort_items(maker *m)
{
    cl_mem *work = m->buffers;
    const cl_uint item_count = m->params.item_count;
    const svo_i_argument codes[] = {SVO_I_ARGUMENT(work[RANGES_A]), SVO_I_ARGUMENT(work[ITEMS_A]),
                                    SVO_I_ARGUMENT(work[FRAGMENTS]), SVO_I_ARGUMENT(item_count)};
    SVO_I_TRY(run(m, "svo_k_bvh_codes", SVO_I_ARGUMENTS(codes), item_count));
    for (uint32_t shift = 0; shift < CODE_BITS; shift += SVO_SORT_BITS) {
        SVO_I_TRY(sort_pass(m, shift));
    }
    const svo_i_argument gather[] = {SVO_I_ARGUMENT(work[FRAGMENTS]), SVO_I_ARGUMENT(work[ITEMS_A]),
                                     SVO_I_ARGUMENT(work[ITEMS_B]), SVO_I_ARGUMENT(m->out->shape[SVO_I_BVH_ORDER]),
                                     SVO_I_ARGUMENT(item_count)};
    return run(m, "svo_k_bvh_gather", SVO_I_ARGUMENTS(gather), item_count);
}

static svo_status split_sorted(maker *m)
{
    cl_mem *work = m->buffers;
    const cl_uint item_count = m->params.item_count;
    SVO_I_TRY(sort_items(m));
    const svo_i_argument top[] = {SVO_I_ARGUMENT(work[RANGES_A]), SVO_I_ARGUMENT(work[FRAGMENTS]),
                                  SVO_I_ARGUMENT(work[BRANCHES]), SVO_I_ARGUMENT(work[JOBS]),
                                  SVO_I_ARGUMENT(work[STATE]),    SVO_I_ARGUMENT(item_count)};
    SVO_I_TRY(run(m, "svo_k_bvh_top", SVO_I_ARGUMENTS(top), item_count / SVO_BVH_SWEEP_ITEMS + 1));
    SVO_I_TRY(read_state(m));
    const svo_i_argument sweep[] = {SVO_I_ARGUMENT(work[JOBS]), SVO_I_ARGUMENT(work[ITEMS_B]),
                                    SVO_I_ARGUMENT(work[BRANCHES]), SVO_I_LOCAL(SVO_BVH_SWEEP_BYTES)};
    return run_lanes(m, "svo_k_bvh_sweep", SVO_I_ARGUMENTS(sweep), m->state.job_count);
}

/* ---- nodes ---- */

/* Opens the nodes of a level, of which there are no more than that, and numbers those of the next. */
static svo_status open_level(maker *m, cl_uint level, uint64_t nodes)
{
    cl_mem *work = m->buffers;
    const cl_mem *shape = m->out->shape;
    const svo_i_argument scratch = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint));
    const svo_i_argument open[] = {SVO_I_ARGUMENT(work[NODES]),
                                   SVO_I_ARGUMENT(work[BRANCHES]),
                                   SVO_I_ARGUMENT(shape[SVO_I_BVH_CHILDREN]),
                                   SVO_I_ARGUMENT(work[COUNTS]),
                                   SVO_I_ARGUMENT(shape[SVO_I_BVH_ITEM_COUNTS]),
                                   SVO_I_ARGUMENT(work[STATE]),
                                   SVO_I_ARGUMENT(level),
                                   scratch};
    const svo_i_argument number[] = {SVO_I_ARGUMENT(work[NODES]),  SVO_I_ARGUMENT(shape[SVO_I_BVH_CHILDREN]),
                                     SVO_I_ARGUMENT(work[COUNTS]), SVO_I_ARGUMENT(work[STATE]),
                                     SVO_I_ARGUMENT(level),        scratch};
    SVO_I_TRY(run(m, "svo_k_bvh_open", SVO_I_ARGUMENTS(open), nodes));
    return run(m, "svo_k_bvh_number", SVO_I_ARGUMENTS(number), nodes);
}

/* Places the leaves; their units come with what is read next. */
static svo_status place_leaves(maker *m)
{
    const cl_uint item_count = m->params.item_count;
    const cl_uint has_doubles = m->mesh->doubles != NULL;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(m->out->shape[SVO_I_BVH_ITEM_COUNTS]),
                                        SVO_I_ARGUMENT(m->buffers[LISTED]), SVO_I_ARGUMENT(has_doubles),
                                        SVO_I_ARGUMENT(item_count)};
    if (item_count == 0) {
        return svo_i_work_fill_zero(&m->work, m->buffers[PLACES], sizeof(cl_uint));
    }
    SVO_I_TRY(run(m, "svo_k_bvh_leaf_units", SVO_I_ARGUMENTS(arguments), item_count));
    SVO_I_TRY(svo_i_work_scan(&m->work, m->buffers[LISTED], m->buffers[PLACES], item_count));
    return svo_i_work_read_later(&m->work, m->buffers[PLACES], (uint64_t)item_count * sizeof(cl_uint), &m->units,
                                 sizeof m->units);
}

/* Collapses the binary tree, and says where levels of nodes begin. */
static svo_status make_nodes(maker *m)
{
    svo_i_device_bvh *out = m->out;
    const uint64_t most = nodes_max(m->params.item_count);
    const uint32_t levels = levels_until(m->params.item_count, SVO_RAY_LEAF_TRIANGLES) / 3 + SPARE_NODE_LEVELS;
    const uint32_t *begins = m->state.node_begin;
    const svo_i_argument root[] = {SVO_I_ARGUMENT(m->buffers[BRANCHES]), SVO_I_ARGUMENT(m->buffers[NODES]),
                                   SVO_I_ARGUMENT(m->buffers[STATE]), SVO_I_ARGUMENT(m->params.item_count)};
    SVO_I_TRY(svo_i_work_fill_zero(&m->work, out->shape[SVO_I_BVH_ITEM_COUNTS],
                                   ((uint64_t)m->params.item_count + 1) * sizeof(cl_uint)));
    SVO_I_TRY(run_one(m, "svo_k_bvh_root", SVO_I_ARGUMENTS(root)));
    uint32_t level = 0;
    for (uint64_t nodes = 1; nodes > 0 && level < SVO_BVH_DEPTH_MAX; nodes = begins[level + 1] - begins[level]) {
        for (uint32_t i = 0; i < levels && level < SVO_BVH_DEPTH_MAX; ++i, ++level) {
            SVO_I_TRY(open_level(m, level, nodes));
            nodes = 8 * nodes < most ? 8 * nodes : most;
        }
        SVO_I_TRY(place_leaves(m));
        SVO_I_TRY(read_state(m));
    }
    do {
        ++out->level_count;
        out->level_begin[out->level_count] = begins[out->level_count];
    } while (begins[out->level_count + 1] > begins[out->level_count]);
    return SVO_OK;
}

/* ---- what rays read ---- */

/* Makes the nodes, and finds how large that is which rays read. */
static svo_status size_records(maker *m)
{
    svo_i_device_bvh *out = m->out;
    SVO_I_TRY(make_nodes(m));
    out->item_count = m->params.item_count;
    out->node_bytes = (uint64_t)out->level_begin[out->level_count] * sizeof(svo_ray_node);
    out->leaf_bytes =
        (uint64_t)m->units * 16 + (SVO_RAY_LEAF_HEAD_WORDS + SVO_RAY_LEAF_PADDING_WORDS) * sizeof(cl_uint);
    return SVO_OK;
}

/* Writes what rays read. */
static svo_status write_records(maker *m)
{
    svo_i_device_bvh *out = m->out;
    const svo_i_device_bvh *fitted = out;
    SVO_I_TRY(svo_i_work_result(&m->work, "ray_nodes", out->node_bytes, &out->nodes));
    SVO_I_TRY(svo_i_work_result(&m->work, "ray_leaves", out->leaf_bytes, &out->leaves));
    SVO_I_TRY(svo_i_bvh_tables_make(m->work.device, m->work.function, &fitted, 1, &out->tables));
    SVO_I_TRY(svo_i_bvh_fit(&m->work, m->mesh, out, &out->tables));
    return svo_i_work_wait(&m->work);
}

/* ---- all of it ---- */

void svo_i_bvh_forget_refit(svo_i_device_bvh *bvh)
{
    for (int i = 0; i < SVO_I_BVH_SHAPE_BUFFERS; ++i) {
        svo_i_buffer_release(&bvh->shape[i]);
    }
    svo_i_bvh_tables_free(&bvh->tables);
}

static svo_status begin(maker *m, svo_device *device, const char *function, cl_command_queue queue,
                        const svo_i_bvh_mesh *mesh)
{
    m->mesh = mesh;
    m->params.triangle_count = mesh->triangle_count;
    m->params.snap_bits = mesh->snap_bits;
    SVO_I_TRY(svo_i_work_begin(device, function, queue, &m->work));
    return svo_i_work_use(&m->work, &svo_i_program_bvh, svo_i_bvh_defines(m->work.device));
}

/* Waits for all commands and releases what the maker holds. */
static void end(maker *m)
{
    svo_i_work_end(&m->work);
}

static svo_status make(maker *m, const svo_i_bvh_options *options)
{
    SVO_I_TRY(make_first_buffers(m));
    SVO_I_TRY(find_extent(m));
    SVO_I_TRY(make_buffers(m));
    SVO_I_TRY(m->out->quality == SVO_BVH_FAST ? SVO_OK : clear_levels(m));
    SVO_I_TRY(make_items(m));
    SVO_I_TRY(m->out->quality == SVO_BVH_FAST ? split_sorted(m) : split_items(m));
    SVO_I_TRY(size_records(m));
    return options->no_records ? svo_i_work_wait(&m->work) : write_records(m);
}

svo_status svo_i_bvh_make(svo_device *device, const char *function, cl_command_queue queue, const svo_i_bvh_mesh *mesh,
                          const svo_i_bvh_options *options, svo_i_device_bvh *out)
{
    maker m = {.out = out, .params = {.halvings = options->halvings}};
    *out = (svo_i_device_bvh){.quality = options->quality, .first_triangle = mesh->first_triangle};
    m.params.chunk_items = options->chunk_items != 0 ? options->chunk_items : device->cpu_path ? 1024 : 512;
    m.params.subtree_items = options->quality == SVO_BVH_FAST ? SVO_BVH_SWEEP_ITEMS
                             : options->subtree_items != 0    ? options->subtree_items
                             : device->cpu_path               ? 2048
                                                              : 256;
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(begin(&m, device, function, queue, mesh));
    SVO_I_TRY_CLEANUP(make(&m, options));
    if (!options->can_refit) {
        svo_i_bvh_forget_refit(out);
    }

cleanup:
    end(&m);
    if (status != SVO_OK) {
        svo_i_bvh_release(out);
    }
    return status;
}

void svo_i_bvh_release(svo_i_device_bvh *bvh)
{
    svo_i_bvh_forget_refit(bvh);
    svo_i_buffer_release(&bvh->nodes);
    svo_i_buffer_release(&bvh->leaves);
}
