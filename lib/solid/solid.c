/* SPDX-License-Identifier: MIT */
/*
 * svo_solid_create: options and checks; which empty children of a tree's inner nodes are inside the mesh; the tree with
 * these interior leaves, as the encoder of the descriptor form reads it.
 *
 * The tree's leaf lists say which triangles may cross a column inside a leaf (kernels/solid/cross.cl); chains along
 * columns add the leaves' sums up (chain.cl), and every empty child takes the number of the next crossed leaf
 * (fill.cl). Scratch is 8 bytes per node, 44 per leaf and 2 per inner node.
 */
#include "svocl/solid.h"

#include <string.h>

#include "compact/form.h"
#include "compact/programs.h"
#include "core/program.h"
#include "core/struct_size.h"
#include "core/tree.h"
#include "shared/solid_layout.h"
#include "solid/programs.h"
#include "svocl/plan.h"

static const char function[] = "svo_solid_create";

/* Words of the form and places of payload have 32 bits. */
#define INNER_MAX UINT64_C(0x7fffffff)
#define NODES_MAX UINT64_C(0xfffffffe)

/* Materials have 16 bits, and a mesh has 65535 at most. */
#define MATERIAL_MAX 65534

/* Nodes of a launch, so that its counts fit 32 bits. */
#define PART_NODES (UINT32_C(1) << 28)

/* ---- checks ---- */

static svo_status read_options(const svo_tree *tree, const svo_solid_options *options, svo_solid_options *out)
{
    static const uint8_t none[4] = {0, 0, 0, 0};
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(tree->device), function, "options", options, out,
                                SVO_I_STRUCT_SIZES(svo_solid_options, material)));
    if ((unsigned)out->rule > SVO_SOLID_PARITY) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: options.rule %d is not in 0 .. %d", function,
                                 (int)out->rule, (int)SVO_SOLID_PARITY);
    }
    if (out->material > MATERIAL_MAX) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: options.material %d is above %d", function,
                                 out->material, MATERIAL_MAX);
    }
    if (memcmp(out->color, none, sizeof none) == 0) {
        memset(out->color, 255, sizeof out->color);
    }
    return SVO_OK;
}

/* Why a tree does not say what is inside, for a message; NULL: it does. */
static const char *find_lack(const svo_tree *tree)
{
    if (tree->info.coverage == SVO_COVERAGE_THIN) {
        return "the tree's coverage is thin: the surface passes through cells that it leaves empty, so parts of a cell "
               "may lie on both sides";
    }
    if ((tree->info.need & SVO_NEED_RAYS) == 0) {
        return "the tree holds no leaf lists; build it with SVO_NEED_RAYS";
    }
    if (tree->info.payload_level > 0 && (tree->info.need & SVO_I_PAYLOAD_NEEDS) != 0) {
        return "the tree's payload does not begin at level 0, and interior leaves may lie on any level";
    }
    return NULL;
}

/* Refuses more nodes than the form can name. count: of the nodes; kind: "inner " or "". */
static svo_status check_count(const svo_tree *tree, uint64_t count, const char *kind, uint64_t most)
{
    return count <= most ? SVO_OK
                         : svo_i_device_fail(tree->device, SVO_UNSUPPORTED, "%s: %llu %snodes are above %llu", function,
                                             (unsigned long long)count, kind, (unsigned long long)most);
}

static svo_status check_tree(const svo_tree *tree)
{
    const svo_tree_info *info = &tree->info;
    SVO_I_TRY(svo_i_tree_check(tree, function));
    if (tree->device == NULL) {
        return SVO_NOT_ON_DEVICE;
    }
    const char *lack = find_lack(tree);
    if (lack != NULL) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: %s", function, lack);
    }
    const uint64_t usable = info->triangles - info->refused_triangles;
    if (usable > info->list_triangle_count) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                 "%s: %llu triangles lie outside the tree's grid; a solid needs all of the mesh inside",
                                 function, (unsigned long long)(usable - info->list_triangle_count));
    }
    return check_count(tree, info->inner_count, "inner ", INNER_MAX);
}

/* ---- what is inside ---- */

/* What the device found. */
typedef struct inside_leaves {
    cl_mem mask; /* scratch of the work: a byte per inner node, bit o for an empty child in octant o that is inside */
    uint64_t count; /* of those children */
    uint64_t level_count[SVO_LEVELS_MAX]; /* the same by their level */
} inside_leaves;

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
    cl_mem positions; /* of the tree: the mesh as it was given; others that are not read if the snapped one decides */
    svo_decide_params grid; /* of these positions */
    svo_solid_params params;
    inside_leaves *out;
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

/* The mesh whose crossings count. */
static void set_mesh(classifier *c)
{
    const svo_tree *tree = c->tree;
    c->positions = tree->buffers[SVO_TREE_VERTICES];
    if (tree->info.is_exact == 0 || tree->info.positions == SVO_POSITIONS_ROUNDED) {
        return;
    }
    c->params.rounded_to_odd = 1;
    c->grid = svo_i_grid_params(&tree->part.header, tree->part.level, tree->part.code, tree->info.depth,
                                tree->info.origin, tree->info.edge);
    c->grid.is_double = tree->info.positions == SVO_POSITIONS_DOUBLE;
    c->positions = tree->buffers[c->grid.is_double ? SVO_TREE_POSITIONS_DOUBLE : SVO_TREE_POSITIONS];
}

/* Decides all empty children and waits for the counts. info: receives all fields but struct_size. */
static svo_status classify(svo_i_device_work *work, const svo_tree *tree, svo_solid_rule rule, inside_leaves *out,
                           svo_solid_info *info)
{
    classifier c = {.work = work, .tree = tree, .out = out, .info = info};
    *out = (inside_leaves){.mask = NULL};
    c.params = (svo_solid_params){.depth = tree->info.depth,
                                  .voxel_log2 = tree->info.snap_bits - tree->info.depth,
                                  .leaf_begin = (cl_uint)tree->info.inner_count,
                                  .leaf_count = (cl_uint)tree->info.leaf_count,
                                  .parity = rule == SVO_SOLID_PARITY};
    set_mesh(&c);
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

/* ---- interior leaves ---- */

/* The most bytes of a payload element. */
#define ELEMENT_BYTES_MAX 6

/* The element of interior leaves. */

static void fill_element(const svo_solid_options *options, svo_compact_buffer buffer, uint8_t element[8])
{
    memset(element, 0, 8);
    if (buffer == SVO_COMPACT_COLORS) {
        memcpy(element, options->color, sizeof options->color);
    } else if (buffer == SVO_COMPACT_MATERIALS) {
        memcpy(element, &options->material, sizeof options->material);
    }
}

/* valid, leaf and the places of the children's payload. */
static svo_status make_masks(svo_i_device_work *work, const svo_tree *tree, const inside_leaves *inside,
                             svo_i_compact_source *out)
{
    const svo_tree_info *info = &tree->info;
    const svo_solid_params params = {.first = info->level_begin[info->depth - 1], .count = (cl_uint)info->inner_count};
    const uint64_t count = info->inner_count;
    cl_mem counts = NULL;
    cl_mem sums = NULL;
    SVO_I_TRY(svo_i_work_alloc(work, "solid_valid", count, &out->valid));
    SVO_I_TRY(svo_i_work_alloc(work, "solid_leaf", count, &out->leaf));
    SVO_I_TRY(svo_i_work_alloc(work, "solid_first", count * sizeof(cl_uint), &out->first_payload));
    SVO_I_TRY(svo_i_work_alloc(work, "solid_counts", (count + 1) * sizeof(cl_uint), &counts));
    SVO_I_TRY(svo_i_work_alloc(work, "solid_sums", (count + 2) * sizeof(cl_uint), &sums));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(inside->mask),
                                        SVO_I_ARGUMENT(out->valid),
                                        SVO_I_ARGUMENT(out->leaf),
                                        SVO_I_ARGUMENT(counts),
                                        SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_solid_masks", SVO_I_ARGUMENTS(arguments), count));
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_compact, " -DSVO_SORT"));
    SVO_I_TRY(svo_i_work_scan(work, counts, sums, count + 1));
    SVO_I_TRY(svo_i_work_copy(work, sums, sizeof(cl_uint), out->first_payload, 0, count * sizeof(cl_uint)));
    svo_i_work_free(work, &counts);
    svo_i_work_free(work, &sums);
    return svo_i_work_use(work, &svo_i_program_solid, "");
}

/* Whether the tree's payload is the same in every node and that of the interior leaves too. */
static svo_status check_constant(svo_i_device_work *work, const svo_tree *tree, svo_compact_buffer buffer,
                                 const uint8_t element[8], bool *constant)
{
    const svo_tree_buffer of_tree = svo_i_compact_tree_buffer(buffer);
    const size_t bytes = svo_i_tree_element_bytes(of_tree);
    uint8_t held[ELEMENT_BYTES_MAX] = {0};
    *constant = svo_i_tree_is_constant(&tree->info, of_tree);
    if (!*constant) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_read(work, tree->buffers[of_tree], 0, held, bytes));
    *constant = memcmp(held, element, bytes) == 0;
    return SVO_OK;
}

/* The payload with that of the interior leaves; the tree's own where it is the same everywhere. */
static svo_status make_payload(svo_i_device_work *work, const svo_tree *tree, const inside_leaves *inside,
                               const svo_solid_options *options, svo_compact_buffer buffer, svo_i_compact_source *out)
{
    const svo_tree_buffer of_tree = svo_i_compact_tree_buffer(buffer);
    const size_t bytes = svo_i_tree_element_bytes(of_tree);
    const uint64_t nodes = tree->info.node_count + inside->count;
    cl_mem *to = &out->payload[buffer - SVO_I_PAYLOAD_FIRST];
    uint8_t element[8];
    bool constant = false;
    fill_element(options, buffer, element);
    SVO_I_TRY(check_constant(work, tree, buffer, element, &constant));
    *to = tree->buffers[of_tree];
    if (constant) {
        return SVO_OK;
    }
    svo_solid_params params = {.count = (cl_uint)tree->info.inner_count,
                               .element_halves = (cl_uint)(bytes / 2),
                               .repeats = svo_i_tree_is_constant(&tree->info, of_tree)};
    memcpy(params.value, element, sizeof params.value);
    out->info.constant &= ~svo_i_compact_need(buffer);
    SVO_I_TRY(svo_i_work_alloc(work, svo_name(SVO_NAME_COMPACT_BUFFER, buffer), nodes * bytes, to));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(inside->mask),
                                        SVO_I_ARGUMENT(out->first_payload),
                                        SVO_I_ARGUMENT(tree->buffers[of_tree]),
                                        SVO_I_ARGUMENT(*to),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_solid_payload", SVO_I_ARGUMENTS(arguments), params.count);
}

/* Adds the interior leaves to a tree. The tree and the work own its arrays, which must outlive the work. options: read
   and complete. */
static svo_status make_source(svo_i_device_work *work, const svo_tree *tree, const inside_leaves *inside,
                              const svo_solid_options *options, svo_i_compact_source *out)
{
    const svo_compact_options form = {.struct_size = sizeof form, .form = SVO_FORM_DESCRIPTOR};
    if (inside->count == 0) {
        return svo_i_source_of_tree(work, tree, &form, out);
    }
    *out = (svo_i_compact_source){.first_inner = tree->buffers[SVO_TREE_FIRST_CHILD]};
    svo_i_source_describe(&tree->info, &form, &out->info);
    for (uint32_t level = 1; level <= tree->info.depth; ++level) {
        out->info.level_leaf[level] += (uint32_t)inside->level_count[level];
        out->info.minimized |= level < tree->info.depth && inside->level_count[level] > 0;
    }
    SVO_I_TRY(make_masks(work, tree, inside, out));
    for (int i = SVO_I_PAYLOAD_FIRST; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        if ((out->info.need & svo_i_compact_need((svo_compact_buffer)i)) != 0) {
            SVO_I_TRY(make_payload(work, tree, inside, options, (svo_compact_buffer)i, out));
        }
    }
    return SVO_OK;
}

/* ---- the solid ---- */

static svo_status encode(svo_i_device_work *work, const svo_tree *tree, const inside_leaves *inside,
                         const svo_solid_options *options, svo_compact *compact)
{
    svo_i_compact_source source;
    SVO_I_TRY(check_count(tree, tree->info.node_count + inside->count, "", NODES_MAX));
    SVO_I_TRY(make_source(work, tree, inside, options, &source));
    compact->info = source.info;
    compact->device = tree->device;
    return svo_i_form_make(work, &source, compact);
}

static svo_status make(const svo_tree *tree, const svo_solid_options *options, cl_command_queue queue,
                       svo_compact *compact, svo_solid_info *info)
{
    svo_i_device_work work;
    inside_leaves inside;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin(tree->device, function, queue, &work));
    SVO_I_TRY_CLEANUP(classify(&work, tree, options->rule, &inside, info));
    SVO_I_TRY_CLEANUP(encode(&work, tree, &inside, options, compact));
    SVO_I_TRY_CLEANUP(svo_i_work_wait(&work));

cleanup:
    svo_i_work_end(&work);
    return status;
}

svo_status svo_solid_create(const svo_tree *tree, const svo_solid_options *options, cl_command_queue queue,
                            svo_compact **out, svo_solid_info *info)
{
    const svo_i_struct_sizes sizes = SVO_I_STRUCT_SIZES(svo_solid_info, scratch_bytes);
    svo_solid_options asked;
    svo_solid_info found = SVO_SOLID_INFO_INIT;
    if (tree == NULL || out == NULL) {
        return svo_i_device_fail(tree != NULL ? tree->device : NULL, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 tree == NULL ? "tree" : "out");
    }
    SVO_I_TRY(check_tree(tree));
    SVO_I_TRY(read_options(tree, options, &asked));
    if (info != NULL) {
        SVO_I_TRY(svo_i_struct_check(svo_i_device_message(tree->device), function, "info", info, sizes));
    }
    svo_compact *compact = svo_i_compact_new(&tree->device->memory);
    if (compact == NULL) {
        return svo_i_device_fail(tree->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a compact tree", function);
    }
    const svo_status status = make(tree, &asked, queue, compact, &found);
    if (status != SVO_OK) {
        svo_compact_destroy(&compact);
        return status;
    }
    *out = compact;
    return info != NULL ? svo_i_struct_write(svo_i_device_message(tree->device), function, "info", &found, info, sizes)
                        : SVO_OK;
}
