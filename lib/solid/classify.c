/* SPDX-License-Identifier: MIT */
/*
 * The device's part of a solid. The tree's leaf lists say which triangles may cross a column inside a leaf (cross.cl);
 * chains along columns add the leaves' sums up (chain.cl), and every empty child takes the number of the next crossed
 * leaf (fill.cl). Scratch is 8 bytes per node, 44 per leaf and 2 per inner node.
 */
#include "solid/classify.h"

#include "core/program.h"
#include "shared/solid_layout.h"
#include "solid/programs.h"

/* Nodes of a launch, so that its counts fit 32 bits. */
#define PART_NODES (UINT32_C(1) << 28)

typedef enum scratch {
    SCRATCH_CODES = 0,
    SCRATCH_CROSSINGS,
    SCRATCH_LONG_LISTS,
    SCRATCH_NEXT,
    SCRATCH_FOLLOWS,
    SCRATCH_WINDINGS,
    SCRATCH_CARRIES,
    SCRATCH_COUNTERS,
    SCRATCH_INSIDE, /* the result */
    SCRATCH_COUNT
} scratch;

typedef struct classifier {
    svo_i_device_work *work;
    const svo_tree *tree;
    cl_mem buffers[SCRATCH_COUNT]; /* of the work */
    svo_solid_params params;
    svo_i_inside *out;
    svo_solid_info *info;
} classifier;

static svo_status clear_counters(classifier *c)
{
    return svo_i_work_fill_zero(c->work, c->buffers[SCRATCH_COUNTERS], SVO_SOLID_COUNTERS * sizeof(cl_uint));
}

static svo_status read_counters(classifier *c, cl_uint counters[SVO_SOLID_COUNTERS])
{
    return svo_i_work_read(c->work, c->buffers[SCRATCH_COUNTERS], 0, counters, SVO_SOLID_COUNTERS * sizeof counters[0]);
}

/* ---- steps ---- */

static svo_status allocate(classifier *c)
{
    static const char *const names[SCRATCH_COUNT] = {"solid_codes",   "solid_crossings", "solid_long_lists",
                                                     "solid_next",    "solid_follows",   "solid_windings",
                                                     "solid_carries", "solid_counters",  "solid_inside"};
    const svo_tree_info *tree = &c->tree->info;
    const uint64_t bytes[SCRATCH_COUNT] = {[SCRATCH_CODES] = tree->node_count * sizeof(cl_ulong),
                                           [SCRATCH_CROSSINGS] = tree->leaf_count * 3 * sizeof(cl_uint),
                                           [SCRATCH_LONG_LISTS] = tree->leaf_count * sizeof(cl_uint),
                                           [SCRATCH_NEXT] = tree->leaf_count * 3 * sizeof(cl_uint),
                                           [SCRATCH_FOLLOWS] = tree->leaf_count * sizeof(cl_uint),
                                           [SCRATCH_WINDINGS] = tree->leaf_count * 3 * sizeof(cl_uint),
                                           [SCRATCH_CARRIES] = tree->inner_count,
                                           [SCRATCH_COUNTERS] = SVO_SOLID_COUNTERS * sizeof(cl_uint),
                                           [SCRATCH_INSIDE] = tree->inner_count};
    for (scratch i = 0; i < SCRATCH_COUNT; ++i) {
        SVO_I_TRY(svo_i_work_alloc(c->work, names[i], bytes[i], &c->buffers[i]));
        c->info->scratch_bytes += bytes[i];
    }
    return SVO_OK;
}

/* Refuses a mesh of which the leaves do not hold all crossings. */
static svo_status check_triangles(classifier *c)
{
    const svo_tree *tree = c->tree;
    cl_uint counters[SVO_SOLID_COUNTERS] = {0};
    c->params.count = (cl_uint)tree->info.list_triangle_count;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_VERTICES]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_INDICES]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_COUNTERS]), SVO_I_ARGUMENT(c->params)};
    SVO_I_TRY(clear_counters(c));
    SVO_I_TRY(svo_i_work_launch(c->work, "svo_k_solid_outside", SVO_I_ARGUMENTS(arguments), c->params.count));
    SVO_I_TRY(read_counters(c, counters));
    if (counters[SVO_SOLID_OUTSIDE] > 0) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                 "%s: %u triangles reach outside the tree's grid; a solid needs all of the mesh inside",
                                 c->work->function, counters[SVO_SOLID_OUTSIDE]);
    }
    return SVO_OK;
}

/* The codes of all nodes. */
static svo_status place(classifier *c)
{
    const svo_tree *tree = c->tree;
    for (uint32_t level = 0; level < tree->info.depth; ++level) {
        c->params.first = tree->info.level_begin[level];
        c->params.count = tree->info.level_begin[level + 1] - c->params.first;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                            SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                            SVO_I_ARGUMENT(c->buffers[SCRATCH_CODES]), SVO_I_ARGUMENT(c->params)};
        SVO_I_TRY(svo_i_work_launch(c->work, "svo_k_solid_place", SVO_I_ARGUMENTS(arguments), c->params.count));
    }
    return SVO_OK;
}

/* The sums of all leaves, and what they imply for the nodes above. */
static svo_status cross(classifier *c)
{
    const svo_tree *tree = c->tree;
    cl_uint counters[SVO_SOLID_COUNTERS] = {0};
    c->params.count = c->params.leaf_count;
    svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_VERTICES]),
                                  SVO_I_ARGUMENT(tree->buffers[SVO_TREE_INDICES]),
                                  SVO_I_ARGUMENT(tree->buffers[SVO_TREE_LIST_BEGIN]),
                                  SVO_I_ARGUMENT(tree->buffers[SVO_TREE_LIST]),
                                  SVO_I_ARGUMENT(c->buffers[SCRATCH_CODES]),
                                  SVO_I_ARGUMENT(c->buffers[SCRATCH_CROSSINGS]),
                                  SVO_I_ARGUMENT(c->buffers[SCRATCH_LONG_LISTS]),
                                  SVO_I_ARGUMENT(c->buffers[SCRATCH_COUNTERS]),
                                  SVO_I_ARGUMENT(c->params)};
    SVO_I_TRY(svo_i_work_launch(c->work, "svo_k_solid_cross", SVO_I_ARGUMENTS(arguments), c->params.count));
    SVO_I_TRY(read_counters(c, counters));
    arguments[7] = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint));
    SVO_I_TRY(svo_i_work_launch(c->work, "svo_k_solid_cross_long", SVO_I_ARGUMENTS(arguments),
                                (uint64_t)counters[SVO_SOLID_LONG_LISTS] * SVO_GROUP_ITEMS));
    for (uint32_t level = tree->info.depth; level-- > 0;) {
        c->params.first = tree->info.level_begin[level];
        c->params.count = tree->info.level_begin[level + 1] - c->params.first;
        const svo_i_argument upwards[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                          SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                          SVO_I_ARGUMENT(c->buffers[SCRATCH_CROSSINGS]),
                                          SVO_I_ARGUMENT(c->buffers[SCRATCH_CARRIES]), SVO_I_ARGUMENT(c->params)};
        SVO_I_TRY(svo_i_work_launch(c->work, "svo_k_solid_carry", SVO_I_ARGUMENTS(upwards), c->params.count));
    }
    return SVO_OK;
}

/* The winding numbers in front of the leaves; counts the columns that are not closed. */
static svo_status chain(classifier *c)
{
    const svo_tree *tree = c->tree;
    cl_uint counters[SVO_SOLID_COUNTERS] = {0};
    c->params.count = c->params.leaf_count;
    const svo_i_argument links[] = {
        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]), SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
        SVO_I_ARGUMENT(c->buffers[SCRATCH_CODES]),          SVO_I_ARGUMENT(c->buffers[SCRATCH_CARRIES]),
        SVO_I_ARGUMENT(c->buffers[SCRATCH_CROSSINGS]),      SVO_I_ARGUMENT(c->buffers[SCRATCH_NEXT]),
        SVO_I_ARGUMENT(c->buffers[SCRATCH_FOLLOWS]),        SVO_I_ARGUMENT(c->params)};
    const svo_i_argument sums[] = {
        SVO_I_ARGUMENT(c->buffers[SCRATCH_CROSSINGS]), SVO_I_ARGUMENT(c->buffers[SCRATCH_NEXT]),
        SVO_I_ARGUMENT(c->buffers[SCRATCH_FOLLOWS]),   SVO_I_ARGUMENT(c->buffers[SCRATCH_WINDINGS]),
        SVO_I_ARGUMENT(c->buffers[SCRATCH_COUNTERS]),  SVO_I_ARGUMENT(c->params)};
    SVO_I_TRY(svo_i_work_fill_zero(c->work, c->buffers[SCRATCH_FOLLOWS], tree->info.leaf_count * sizeof(cl_uint)));
    SVO_I_TRY(svo_i_work_launch(c->work, "svo_k_solid_chain", SVO_I_ARGUMENTS(links), c->params.count));
    SVO_I_TRY(svo_i_work_launch(c->work, "svo_k_solid_sum", SVO_I_ARGUMENTS(sums), c->params.count));
    SVO_I_TRY(read_counters(c, counters));
    for (int axis = 0; axis < 3; ++axis) {
        c->info->open_columns[axis] = counters[SVO_SOLID_OPEN_X + axis];
    }
    return SVO_OK;
}

/* Decides the empty children of some nodes of a level, c->params.first and count, and adds to the counts. */
static svo_status fill_part(classifier *c)
{
    const svo_tree *tree = c->tree;
    cl_uint counters[SVO_SOLID_COUNTERS] = {0};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_CODES]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_CARRIES]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_CROSSINGS]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_WINDINGS]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_INSIDE]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_COUNTERS]),
                                        SVO_I_ARGUMENT(c->params)};
    const unsigned cell_log2 = 3 * (c->params.depth - c->params.level - 1); /* voxels of a child */
    SVO_I_TRY(clear_counters(c));
    SVO_I_TRY(svo_i_work_launch(c->work, "svo_k_solid_fill", SVO_I_ARGUMENTS(arguments), c->params.count));
    SVO_I_TRY(read_counters(c, counters));
    c->info->tests += counters[SVO_SOLID_TESTS];
    c->out->level_count[c->params.level + 1] += counters[SVO_SOLID_INSIDE];
    c->out->count += counters[SVO_SOLID_INSIDE];
    c->info->inside_leaves += counters[SVO_SOLID_INSIDE];
    c->info->inside_voxels += (uint64_t)counters[SVO_SOLID_INSIDE] << cell_log2;
    c->info->ambiguous_cells += counters[SVO_SOLID_AMBIGUOUS];
    c->info->ambiguous_voxels += (uint64_t)counters[SVO_SOLID_AMBIGUOUS] << cell_log2;
    return SVO_OK;
}

static svo_status fill(classifier *c)
{
    const svo_tree_info *tree = &c->tree->info;
    for (uint32_t level = 0; level < tree->depth; ++level) {
        const uint32_t end = tree->level_begin[level + 1];
        c->params.level = level;
        for (uint32_t first = tree->level_begin[level]; first < end; first += c->params.count) {
            c->params.first = first;
            c->params.count = end - first < PART_NODES ? end - first : PART_NODES;
            SVO_I_TRY(fill_part(c));
        }
    }
    return SVO_OK;
}

svo_status svo_i_solid_classify(svo_i_device_work *work, const svo_tree *tree, svo_solid_rule rule, svo_i_inside *out,
                                svo_solid_info *info)
{
    classifier c = {.work = work, .tree = tree, .out = out, .info = info};
    *out = (svo_i_inside){.mask = NULL};
    c.params = (svo_solid_params){.depth = tree->info.depth,
                                  .voxel_log2 = tree->info.snap_bits - tree->info.depth,
                                  .leaf_begin = (cl_uint)tree->info.inner_count,
                                  .leaf_count = (cl_uint)tree->info.leaf_count,
                                  .parity = rule == SVO_SOLID_PARITY};
    info->surface_voxels = tree->info.leaf_count;
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_solid, ""));
    SVO_I_TRY(allocate(&c));
    SVO_I_TRY(check_triangles(&c));
    SVO_I_TRY(place(&c));
    SVO_I_TRY(cross(&c));
    SVO_I_TRY(chain(&c));
    SVO_I_TRY(fill(&c));
    out->mask = c.buffers[SCRATCH_INSIDE];
    for (scratch i = 0; i < SCRATCH_INSIDE; ++i) {
        svo_i_work_free(work, &c.buffers[i]);
    }
    return SVO_OK;
}
