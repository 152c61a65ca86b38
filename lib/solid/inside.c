/* SPDX-License-Identifier: MIT */
/*
 * svo_i_inside_find. Of a closed mesh, empty cells that are connected by faces have the same winding number: one line
 * decides for each region (kernels/solid/regions.cl). Of others, and where regions are many, each cell takes three
 * lines: the tree's leaf lists say which triangles may cross a column inside a leaf (cross.cl); chains along columns
 * add the leaves' sums up (chain.cl), and every empty child takes the number of the next crossed leaf (fill.cl). Both
 * give the same for a closed mesh. By SVO_SOLID_GENERALIZED the host decides with the numbers along +z (winding.h).
 * Scratch of the first is 33 bytes per inner node, 24 per inner node above the deepest ones and a quarter per leaf,
 * that of the second 8 per node, 44 per leaf and 2 per inner node.
 */
#include "solid/inside.h"

#include "core/program.h"
#include "shared/solid_layout.h"
#include "solid/programs.h"
#include "solid/winding.h"
#include "svocl/nodes.h"
#include "svocl/plan.h"

/* Nodes of a launch, so that its counts fit 32 bits. */
#define PART_NODES (UINT32_C(1) << 28)

/* Inner nodes whose parts have names in a link (kernels/solid/regions.cl). */
#define LINKED_NODES_MAX (UINT64_C(1) << 28)

/* Regions that one line each decides: a line may meet many leaves, so there are few for each leaf. */
#define REGIONS_MIN        64
#define LEAVES_OF_A_REGION 16

typedef enum scratch {
    SCRATCH_COUNTERS = 0,
    SCRATCH_INSIDE, /* the results */
    SCRATCH_INSIDE_LEAF,
    /* of regions */
    SCRATCH_LINKS,
    SCRATCH_PARENTS,
    SCRATCH_ROOTS,
    /* of columns */
    SCRATCH_CODES,
    SCRATCH_CROSSINGS,
    SCRATCH_LONG_LISTS,
    SCRATCH_NEXT,
    SCRATCH_FOLLOWS,
    SCRATCH_WINDINGS,
    SCRATCH_CARRIES,
    SCRATCH_LINES,
    SCRATCH_COUNT
} scratch;

typedef struct classifier {
    svo_i_device_work *work;
    const svo_tree *tree;
    cl_mem buffers[SCRATCH_COUNT]; /* of the work */
    cl_mem positions; /* of the tree: the mesh as it was given; others that are not read if the snapped one decides */
    svo_decide_params grid; /* of these positions */
    svo_solid_params params;
    const svo_i_solid_progress *progress;
    svo_i_inside *out;
    svo_solid_info *info;
} classifier;

static svo_status allocate(classifier *c, scratch buffer, uint64_t bytes)
{
    static const char *const names[SCRATCH_COUNT] = {
        "solid_counters", "solid_inside",   "solid_inside_leaf", "solid_links",      "solid_parents",
        "solid_roots",    "solid_codes",    "solid_crossings",   "solid_long_lists", "solid_next",
        "solid_follows",  "solid_windings", "solid_carries",     "solid_lines"};
    c->info->scratch_bytes += bytes;
    return svo_i_work_alloc(c->work, names[buffer], bytes, &c->buffers[buffer]);
}

static void release(classifier *c, scratch first, scratch end)
{
    for (scratch i = first; i < end; ++i) {
        if (c->buffers[i] != NULL) {
            svo_i_work_free(c->work, &c->buffers[i]);
        }
    }
}

static svo_status clear_counters(classifier *c)
{
    return svo_i_work_fill_zero(c->work, c->buffers[SCRATCH_COUNTERS], SVO_SOLID_COUNTERS * sizeof(cl_uint));
}

static svo_status read_counters(classifier *c, cl_uint counters[SVO_SOLID_COUNTERS])
{
    return svo_i_work_read(c->work, c->buffers[SCRATCH_COUNTERS], 0, counters, SVO_SOLID_COUNTERS * sizeof counters[0]);
}

/* ---- the mesh ---- */

/* The mesh whose crossings count. */
static void set_mesh(classifier *c)
{
    const svo_tree *tree = c->tree;
    c->positions = tree->buffers[SVO_TREE_VERTICES];
    c->params.positions = SVO_SOLID_SNAPPED;
    if (tree->info.is_exact == 0 || tree->info.positions == SVO_POSITIONS_ROUNDED) {
        return;
    }
    c->params.rounded_to_odd = 1;
    c->grid = svo_i_grid_params(&tree->part.header, tree->part.level, tree->part.code, tree->info.depth,
                                tree->info.origin, tree->info.edge);
    c->grid.is_double = tree->info.positions == SVO_POSITIONS_DOUBLE;
    c->params.positions = c->grid.is_double ? SVO_SOLID_DOUBLES : SVO_SOLID_FLOATS;
    c->positions = tree->buffers[c->grid.is_double ? SVO_TREE_POSITIONS_DOUBLE : SVO_TREE_POSITIONS];
}

/* Refuses a mesh of which the leaves do not hold all crossings, and tells whether it is closed. */
static svo_status read_mesh(classifier *c, bool *closed)
{
    const svo_tree *tree = c->tree;
    cl_uint counters[SVO_SOLID_COUNTERS] = {0};
    c->params.count = (cl_uint)tree->info.list_triangle_count;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_VERTICES]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_INDICES]),
                                        SVO_I_ARGUMENT(c->positions),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_COUNTERS]),
                                        SVO_I_ARGUMENT(c->params),
                                        SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint))};
    SVO_I_TRY(clear_counters(c));
    SVO_I_TRY(svo_i_work_launch(c->work, "svo_k_solid_closed", SVO_I_ARGUMENTS(arguments), c->params.count));
    SVO_I_TRY(read_counters(c, counters));
    if (counters[SVO_SOLID_OUTSIDE] > 0) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                 "%s: %u triangles reach outside the tree's grid; all of the mesh is needed inside",
                                 c->work->function, counters[SVO_SOLID_OUTSIDE]);
    }
    const cl_uint *edges = counters + SVO_SOLID_EDGES;
    *closed = (edges[0] | edges[1] | edges[2] | edges[3]) == 0;
    return SVO_OK;
}

/* ---- levels ---- */

/* The inner nodes of a level, for the next launches. */
static void select_level(classifier *c, uint32_t level)
{
    const uint32_t *begin = c->tree->info.level_begin;
    c->params.level = level;
    c->params.first = begin[level];
    c->params.count = begin[level + 1] - begin[level];
}

/* A kernel that decides the empty children of nodes. arguments: with c->params. */
typedef struct decision {
    const char *kernel;
    const svo_i_argument *arguments;
    cl_uint argument_count;
} decision;

/* Decides for c->params.first and count, and adds to the counts. */
static svo_status decide_part(classifier *c, const decision *by)
{
    cl_uint counters[SVO_SOLID_COUNTERS] = {0};
    const unsigned cell_log2 = 3 * (c->params.depth - c->params.level - 1); /* voxels of a child */
    SVO_I_TRY(clear_counters(c));
    SVO_I_TRY(svo_i_work_launch(c->work, by->kernel, by->arguments, by->argument_count, c->params.count));
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

static svo_status decide_all(classifier *c, const decision *by)
{
    for (uint32_t level = 0; level < c->tree->info.depth; ++level) {
        select_level(c, level);
        const uint32_t end = c->params.first + c->params.count;
        while (c->params.first < end) {
            c->params.count = end - c->params.first < PART_NODES ? end - c->params.first : PART_NODES;
            SVO_I_TRY(decide_part(c, by));
            c->params.first += c->params.count;
        }
    }
    return SVO_OK;
}

/* ---- regions ---- */

/* Joins empty cells to regions and lists these, up to c->params.region_max. */
static svo_status find_regions(classifier *c, cl_uint *count)
{
    const svo_tree *tree = c->tree;
    const svo_tree_info *info = &tree->info;
    cl_uint counters[SVO_SOLID_COUNTERS] = {0};
    const svo_i_argument joins[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                    SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                    SVO_I_ARGUMENT(c->buffers[SCRATCH_LINKS]),
                                    SVO_I_ARGUMENT(c->buffers[SCRATCH_PARENTS]), SVO_I_ARGUMENT(c->params)};
    const svo_i_argument roots[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                    SVO_I_ARGUMENT(c->buffers[SCRATCH_PARENTS]),
                                    SVO_I_ARGUMENT(c->buffers[SCRATCH_ROOTS]),
                                    SVO_I_ARGUMENT(c->buffers[SCRATCH_COUNTERS]), SVO_I_ARGUMENT(c->params)};
    SVO_I_TRY(clear_counters(c));
    SVO_I_TRY(svo_i_work_fill_zero(c->work, c->buffers[SCRATCH_PARENTS], info->inner_count * 8 * sizeof(cl_uint)));
    for (uint32_t level = 0; level + 1 < info->depth; ++level) {
        select_level(c, level);
        SVO_I_TRY(svo_i_work_launch(c->work, "svo_k_solid_join", SVO_I_ARGUMENTS(joins), c->params.count));
    }
    c->params.count = (cl_uint)info->inner_count;
    SVO_I_TRY(svo_i_work_launch(c->work, "svo_k_solid_roots", SVO_I_ARGUMENTS(roots), c->params.count));
    SVO_I_TRY(read_counters(c, counters));
    *count = counters[SVO_SOLID_REGIONS];
    return SVO_OK;
}

static svo_status probe_regions(classifier *c, cl_uint count)
{
    const svo_tree *tree = c->tree;
    c->params.count = count;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_VERTICES]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_INDICES]),
                                        SVO_I_ARGUMENT(c->positions),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_LIST_BEGIN]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_LIST]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_ROOTS]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_PARENTS]),
                                        SVO_I_ARGUMENT(c->grid),
                                        SVO_I_ARGUMENT(c->params)};
    return svo_i_work_launch(c->work, "svo_k_solid_probe", SVO_I_ARGUMENTS(arguments), count);
}

/* Decides a closed mesh. *decided: whether the regions were few enough. */
static svo_status decide_regions(classifier *c, bool *decided)
{
    const svo_tree_info *info = &c->tree->info;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(c->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_PARENTS]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_INSIDE]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_COUNTERS]), SVO_I_ARGUMENT(c->params)};
    const decision spread = {"svo_k_solid_spread", SVO_I_ARGUMENTS(arguments)};
    cl_uint count = 0;
    c->params.region_max = REGIONS_MIN + c->params.leaf_count / LEAVES_OF_A_REGION;
    SVO_I_TRY(allocate(c, SCRATCH_LINKS, (uint64_t)info->level_begin[info->depth - 1] * 6 * sizeof(cl_uint)));
    SVO_I_TRY(allocate(c, SCRATCH_PARENTS, info->inner_count * 8 * sizeof(cl_uint)));
    SVO_I_TRY(allocate(c, SCRATCH_ROOTS, (uint64_t)c->params.region_max * sizeof(cl_uint)));
    SVO_I_TRY(find_regions(c, &count));
    *decided = count <= c->params.region_max;
    if (*decided) {
        c->info->regions = count;
        SVO_I_TRY(probe_regions(c, count));
        SVO_I_TRY(decide_all(c, &spread));
    }
    release(c, SCRATCH_LINKS, SCRATCH_CODES);
    return SVO_OK;
}

/* ---- columns ---- */

static svo_status allocate_columns(classifier *c)
{
    const svo_tree_info *tree = &c->tree->info;
    SVO_I_TRY(allocate(c, SCRATCH_CODES, tree->node_count * sizeof(cl_ulong)));
    SVO_I_TRY(allocate(c, SCRATCH_CROSSINGS, tree->leaf_count * 3 * sizeof(cl_uint)));
    SVO_I_TRY(allocate(c, SCRATCH_LONG_LISTS, tree->leaf_count * sizeof(cl_uint)));
    SVO_I_TRY(allocate(c, SCRATCH_NEXT, tree->leaf_count * 3 * sizeof(cl_uint)));
    SVO_I_TRY(allocate(c, SCRATCH_FOLLOWS, tree->leaf_count * sizeof(cl_uint)));
    SVO_I_TRY(allocate(c, SCRATCH_WINDINGS, tree->leaf_count * 3 * sizeof(cl_uint)));
    return allocate(c, SCRATCH_CARRIES, tree->inner_count);
}

/* The codes of all nodes. */
static svo_status place(classifier *c)
{
    const svo_tree *tree = c->tree;
    for (uint32_t level = 0; level < tree->info.depth; ++level) {
        select_level(c, level);
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
                                  SVO_I_ARGUMENT(c->positions),
                                  SVO_I_ARGUMENT(tree->buffers[SVO_TREE_LIST_BEGIN]),
                                  SVO_I_ARGUMENT(tree->buffers[SVO_TREE_LIST]),
                                  SVO_I_ARGUMENT(c->buffers[SCRATCH_CODES]),
                                  SVO_I_ARGUMENT(c->buffers[SCRATCH_CROSSINGS]),
                                  SVO_I_ARGUMENT(c->buffers[SCRATCH_LONG_LISTS]),
                                  SVO_I_ARGUMENT(c->buffers[SCRATCH_COUNTERS]),
                                  SVO_I_ARGUMENT(c->grid),
                                  SVO_I_ARGUMENT(c->params)};
    SVO_I_TRY(svo_i_work_launch(c->work, "svo_k_solid_cross", SVO_I_ARGUMENTS(arguments), c->params.count));
    SVO_I_TRY(read_counters(c, counters));
    arguments[8] = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint));
    SVO_I_TRY(svo_i_work_launch(c->work, "svo_k_solid_cross_long", SVO_I_ARGUMENTS(arguments),
                                (uint64_t)counters[SVO_SOLID_LONG_LISTS] * SVO_GROUP_ITEMS));
    for (uint32_t level = tree->info.depth; level-- > 0;) {
        select_level(c, level);
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

/* Sums up all crossings along the columns. */
static svo_status sum_columns(classifier *c)
{
    SVO_I_TRY(allocate_columns(c));
    SVO_I_TRY(place(c));
    SVO_I_TRY(cross(c));
    return chain(c);
}

static svo_status decide_columns(classifier *c)
{
    const svo_tree *tree = c->tree;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_CODES]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_CARRIES]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_CROSSINGS]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_WINDINGS]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_INSIDE]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_COUNTERS]),
                                        SVO_I_ARGUMENT(c->params)};
    const decision fill = {"svo_k_solid_fill", SVO_I_ARGUMENTS(arguments)};
    return decide_all(c, &fill);
}

/* ---- generalized winding numbers ---- */

/* Nodes whose numbers the host takes at a time. */
#define HOST_NODES (UINT32_C(1) << 18)

/* Nodes between two calls of who is told the progress. */
#define TOLD_NODES 1024

/* What the host decides with. */
typedef struct host_part {
    svo_i_winding winding;
    cl_uint *lines; /* 8 per node */
    cl_ulong *codes;
    cl_uchar *masks; /* of all nodes: their children, then those inside */
    uint64_t tests, inside, ambiguous; /* of a part */
} host_part;

/* Puts those of a node's empty children that are inside in the place of its children, and counts. */
static void decide_node(const classifier *c, host_part *host, size_t item)
{
    const unsigned child_log2 = c->params.depth - c->params.level - 1;
    cl_uchar *mask = &host->masks[c->params.first + item];
    unsigned inside = 0;
    if (*mask != 255) {
        svo_i_winding_enter(&host->winding, c->params.level, host->codes[item]);
    }
    for (unsigned octant = 0; octant < 8; ++octant) {
        uint32_t voxel[3];
        if ((*mask >> octant & 1) != 0) {
            continue;
        }
        svo_code_to_cell((uint64_t)host->codes[item] << 3 | octant, voxel);
        for (size_t k = 0; k < 3; ++k) {
            voxel[k] = (voxel[k] << child_log2) + (1u << child_log2 >> 1);
        }
        const svo_i_winding_side side =
            svo_i_winding_at(&host->winding, voxel, (int32_t)host->lines[8 * item + octant]);
        inside |= (side == SVO_I_WINDING_ABOVE ? 1u : 0u) << octant;
        ++host->tests;
        host->inside += side == SVO_I_WINDING_ABOVE;
        host->ambiguous += side == SVO_I_WINDING_AMBIGUOUS;
    }
    *mask = (cl_uchar)inside;
}

/* Tells how many nodes the host has decided, at times. */
static svo_status tell_nodes(const classifier *c, size_t item)
{
    const double part = (double)(c->params.first + item) / (double)c->tree->info.inner_count;
    return item % TOLD_NODES != 0 || c->progress == NULL
               ? SVO_OK
               : svo_i_solid_tell(c->progress, c->tree->device,
                                  SVO_I_INSIDE_BEGIN + (SVO_I_INSIDE_END - SVO_I_INSIDE_BEGIN) * part);
}

/* Decides for c->params.first and count, and adds to the counts. */
static svo_status decide_host_part(classifier *c, host_part *host)
{
    const svo_tree *tree = c->tree;
    const cl_uint count = c->params.count;
    const unsigned cell_log2 = 3 * (c->params.depth - c->params.level - 1);
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]), SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
        SVO_I_ARGUMENT(c->buffers[SCRATCH_CODES]),          SVO_I_ARGUMENT(c->buffers[SCRATCH_CARRIES]),
        SVO_I_ARGUMENT(c->buffers[SCRATCH_CROSSINGS]),      SVO_I_ARGUMENT(c->buffers[SCRATCH_WINDINGS]),
        SVO_I_ARGUMENT(c->buffers[SCRATCH_LINES]),          SVO_I_ARGUMENT(c->params)};
    host->tests = 0;
    host->inside = 0;
    host->ambiguous = 0;
    SVO_I_TRY(svo_i_work_launch(c->work, "svo_k_solid_lines", SVO_I_ARGUMENTS(arguments), count));
    SVO_I_TRY(svo_i_work_read(c->work, c->buffers[SCRATCH_CODES], (uint64_t)c->params.first * sizeof(cl_ulong),
                              host->codes, count * sizeof(cl_ulong)));
    SVO_I_TRY(svo_i_work_read(c->work, c->buffers[SCRATCH_LINES], 0, host->lines, 8 * (size_t)count * sizeof(cl_uint)));
    for (size_t i = 0; i < count; ++i) {
        SVO_I_TRY(tell_nodes(c, i));
        decide_node(c, host, i);
    }
    c->info->tests += host->tests;
    c->out->level_count[c->params.level + 1] += host->inside;
    c->out->count += host->inside;
    c->info->inside_leaves += host->inside;
    c->info->inside_voxels += host->inside << cell_log2;
    c->info->ambiguous_cells += host->ambiguous;
    c->info->ambiguous_voxels += host->ambiguous << cell_log2;
    return SVO_OK;
}

static svo_status decide_all_on_host(classifier *c, host_part *host)
{
    const size_t nodes = (size_t)c->tree->info.inner_count;
    SVO_I_TRY(svo_i_work_read(c->work, c->tree->buffers[SVO_TREE_CHILD_MASK], 0, host->masks, nodes));
    for (uint32_t level = 0; level < c->tree->info.depth; ++level) {
        select_level(c, level);
        const uint32_t end = c->params.first + c->params.count;
        while (c->params.first < end) {
            c->params.count = end - c->params.first < HOST_NODES ? end - c->params.first : HOST_NODES;
            SVO_I_TRY(decide_host_part(c, host));
            c->params.first += c->params.count;
        }
    }
    return svo_i_work_write(c->work, c->buffers[SCRATCH_INSIDE], host->masks, nodes);
}

static svo_status decide_generalized(classifier *c)
{
    const svo_i_memory *memory = &c->tree->device->memory;
    const uint64_t inner = c->tree->info.inner_count;
    const size_t most = inner < HOST_NODES ? (size_t)inner : HOST_NODES;
    host_part host = {.lines = svo_i_alloc(memory, 8 * most * sizeof(cl_uint)),
                      .codes = svo_i_alloc(memory, most * sizeof(cl_ulong)),
                      .masks = svo_i_alloc(memory, (size_t)inner)};
    svo_status status = SVO_OUT_OF_HOST_MEMORY;
    if (host.lines != NULL && host.codes != NULL && host.masks != NULL) {
        status = allocate(c, SCRATCH_LINES, 8 * most * sizeof(cl_uint));
        status = status != SVO_OK ? status
                                  : svo_i_winding_of_tree(c->work, c->tree, c->positions, c->params.positions, &c->grid,
                                                          &host.winding);
        c->info->boundary_edges = host.winding.clusters.boundary.edge_count;
        status = status != SVO_OK ? status : decide_all_on_host(c, &host);
        svo_i_winding_release(&host.winding);
    }
    svo_i_free(host.lines);
    svo_i_free(host.codes);
    svo_i_free(host.masks);
    return status != SVO_OUT_OF_HOST_MEMORY
               ? status
               : svo_i_device_fail(c->tree->device, status, "%s: no memory for generalized winding numbers",
                                   c->work->function);
}

/* Decides the centers of leaves. */
static svo_status decide_leaves(classifier *c)
{
    const svo_tree *tree = c->tree;
    SVO_I_TRY(allocate(c, SCRATCH_INSIDE_LEAF, tree->info.leaf_count));
    c->params.count = c->params.leaf_count;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_VERTICES]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_INDICES]),
                                        SVO_I_ARGUMENT(c->positions),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_LIST_BEGIN]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_LIST]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_CODES]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_CARRIES]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_CROSSINGS]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_WINDINGS]),
                                        SVO_I_ARGUMENT(c->buffers[SCRATCH_INSIDE_LEAF]),
                                        SVO_I_ARGUMENT(c->grid),
                                        SVO_I_ARGUMENT(c->params)};
    return svo_i_work_launch(c->work, "svo_k_solid_centers", SVO_I_ARGUMENTS(arguments), c->params.count);
}

/* ---- the entrance ---- */

/* Why a tree's lists do not hold all of the mesh, for a message; NULL: they do. */
static const char *find_lack(const svo_tree *tree)
{
    if (tree->info.coverage == SVO_COVERAGE_THIN) {
        return "the tree's coverage is thin: the surface passes through cells that it leaves empty, so parts of a cell "
               "may lie on both sides";
    }
    return (tree->info.need & SVO_NEED_RAYS) == 0 ? "the tree holds no leaf lists; build it with SVO_NEED_RAYS" : NULL;
}

svo_status svo_i_inside_check(const svo_tree *tree, const char *function, const char *what)
{
    const svo_tree_info *info = &tree->info;
    const char *lack = find_lack(tree);
    if (lack != NULL) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: %s", function, lack);
    }
    const uint64_t usable = info->triangles - info->refused_triangles;
    if (usable > info->list_triangle_count) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                 "%s: %llu triangles lie outside the tree's grid; %s needs all of the mesh inside",
                                 function, (unsigned long long)(usable - info->list_triangle_count), what);
    }
    return SVO_OK;
}

/* Begins a classifier, and tells whether the mesh is closed. */
static svo_status begin(classifier *c, svo_solid_rule rule, bool *closed)
{
    const svo_tree_info *info = &c->tree->info;
    c->params = (svo_solid_params){.depth = info->depth,
                                   .voxel_log2 = info->snap_bits - info->depth,
                                   .leaf_begin = (cl_uint)info->inner_count,
                                   .leaf_count = (cl_uint)info->leaf_count,
                                   .rule = (cl_uint)rule};
    set_mesh(c);
    SVO_I_TRY(svo_i_work_use(c->work, &svo_i_program_solid, ""));
    SVO_I_TRY(allocate(c, SCRATCH_COUNTERS, SVO_SOLID_COUNTERS * sizeof(cl_uint)));
    return read_mesh(c, closed);
}

svo_status svo_i_inside_check_mesh(svo_i_device_work *work, const svo_tree *tree)
{
    svo_solid_info info;
    classifier c = {.work = work, .tree = tree, .info = &info};
    bool closed = false;
    info.scratch_bytes = 0;
    SVO_I_TRY(begin(&c, SVO_SOLID_WINDING, &closed));
    release(&c, SCRATCH_COUNTERS, SCRATCH_INSIDE);
    return SVO_OK;
}

svo_status svo_i_solid_tell(const svo_i_solid_progress *progress, svo_device *device, double fraction)
{
    return progress->callback == NULL || progress->callback(progress->user, fraction) == 0
               ? SVO_OK
               : svo_i_device_fail(device, SVO_CANCELED,
                                   "svo_solid_create: the progress callback stopped the call at %.0f %%",
                                   100.0 * fraction);
}

svo_status svo_i_inside_find(svo_i_device_work *work, const svo_tree *tree, svo_solid_rule rule, bool with_leaves,
                             const svo_i_solid_progress *progress, svo_i_inside *out, svo_solid_info *info)
{
    classifier c = {.work = work, .tree = tree, .progress = progress, .out = out, .info = info};
    bool closed = false;
    bool decided = false;
    *out = (svo_i_inside){.mask = NULL};
    info->surface_voxels = tree->info.leaf_count;
    SVO_I_TRY(begin(&c, rule, &closed));
    SVO_I_TRY(allocate(&c, SCRATCH_INSIDE, tree->info.inner_count));
    if (closed && tree->info.inner_count < LINKED_NODES_MAX) {
        SVO_I_TRY(decide_regions(&c, &decided));
    }
    c.params.axes = decided ? 1 : 7;
    if (!decided || with_leaves) {
        SVO_I_TRY(sum_columns(&c));
    }
    if (!decided) {
        SVO_I_TRY(rule == SVO_SOLID_GENERALIZED && !closed ? decide_generalized(&c) : decide_columns(&c));
    }
    if (with_leaves) {
        SVO_I_TRY(decide_leaves(&c));
    }
    release(&c, SCRATCH_CODES, SCRATCH_COUNT);
    out->mask = c.buffers[SCRATCH_INSIDE];
    out->leaves = c.buffers[SCRATCH_INSIDE_LEAF];
    release(&c, SCRATCH_COUNTERS, SCRATCH_INSIDE);
    return SVO_OK;
}
