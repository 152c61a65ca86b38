/* SPDX-License-Identifier: MIT */
/*
 * Sums up the contributions of the fragments of each leaf. Then the sums go up level by level, and the color, normal
 * and fill of every node are written. Projected areas are written for the leaves alone.
 *
 * CPUs link the fragments of each leaf first. Usually the list has one chunk. Its contributions are summed directly
 * into the deepest inner level. A list of several chunks is linked and summed chunk by chunk, into sums of the leaves.
 * Elsewhere fragments are added to the sums of the leaves in the order that pack has found, or in any. Pairs that are
 * weighed already (kernels/moving) are summed into the deepest inner level everywhere.
 */
#include "stages/filter.h"

#include <string.h>

#include "shared/moving_layout.h"
#include "stages/inputs.h"
#include "stages/programs.h"

/* Rough times for the progress: of a fragment that is linked, one that is summed, and a node that is summed. */
#define LINK_NS   12.0
#define GATHER_NS 250.0
#define NODE_NS   40.0

/* The last arguments of the kernels that sum up kept pairs, which only those with projected areas have. */
#define KEPT_AREA_ARGUMENTS 3

/* The sums of one level. */
typedef struct level_sums {
    cl_mem weights, colors, normals;
} level_sums;

typedef struct filterer {
    svo_i_build *build;
    bool color, normal, fill, areas;
    bool levels; /* color, normal or fill: the sums go up */
    bool pairs; /* fragments are gathered one by one */
    bool leaf_sums; /* the leaves have sums, not only their parents */
    cl_mem heads;
    cl_mem area_sums; /* of the leaves */
    level_sums sums[2]; /* index: distance of the level from the leaves, modulo 2 */
    level_sums long_sums; /* of the long leaves of kept pairs, on GPUs */
    cl_kernel link, gather, filter;
    svo_filter_params params;
} filterer;

/* The most buffers of the stage alone: heads, area sums, and the sums of two levels. */
#define SCRATCH_MAX 8

typedef struct requests {
    svo_i_request all[SCRATCH_MAX];
    size_t count;
} requests;

static void ask(requests *r, bool wanted, const char *name, uint64_t bytes, cl_mem *out)
{
    if (wanted) {
        r->all[r->count++] = (svo_i_request){name, bytes, out};
    }
}

/* Asks for the sums of a level, if a level above reads them. */
static void ask_sums(const filterer *f, requests *r, level_sums *sums, uint32_t level, uint64_t nodes)
{
    const bool wanted = level >= f->params.payload_level;
    ask(r, wanted, "weights", nodes * 8, &sums->weights);
    ask(r, wanted && f->color, "color_sums", nodes * 32, &sums->colors);
    ask(r, wanted && f->normal, "normal_sums", nodes * 24, &sums->normals);
}

/* Asks for the sums of two adjacent levels. */
static void ask_all_sums(filterer *f, requests *r)
{
    const svo_tree_info *info = &f->build->tree->info;
    const uint64_t parents = info->inner_count - info->level_begin[info->depth - 1];
    if (f->leaf_sums) {
        ask_sums(f, r, &f->sums[0], info->depth, info->leaf_count);
    } else if (info->depth > 1) {
        const uint64_t grandparents = info->level_begin[info->depth - 1] - info->level_begin[info->depth - 2];
        ask_sums(f, r, &f->sums[0], info->depth - 2, grandparents);
    }
    ask_sums(f, r, &f->sums[1], info->depth - 1, parents);
}

static svo_status allocate_scratch(filterer *f)
{
    requests r = {.count = 0};
    const uint64_t leaves = f->build->tree->info.leaf_count;
    ask(&r, !f->pairs && f->build->kept == NULL, "heads", leaves * 4, &f->heads);
    if (f->levels) {
        ask_all_sums(f, &r);
    }
    ask(&r, f->areas && f->leaf_sums, "area_sums", leaves * 48, &f->area_sums);
    return svo_i_commands_alloc_all(&f->build->commands, r.all, r.count);
}

static svo_status allocate(filterer *f)
{
    svo_i_commands *commands = &f->build->commands;
    cl_mem *buffers = f->build->tree->buffers;
    const svo_tree_info *info = &f->build->tree->info;
    const uint64_t nodes = info->node_count - info->level_begin[info->payload_level];
    SVO_I_TRY(allocate_scratch(f));
    if (f->color) {
        SVO_I_TRY(svo_i_commands_alloc(commands, "colors", nodes * 4, &buffers[SVO_TREE_COLORS]));
    }
    if (f->normal) {
        SVO_I_TRY(svo_i_commands_alloc(commands, "normals", nodes * 6, &buffers[SVO_TREE_NORMALS]));
    }
    if (f->fill) {
        SVO_I_TRY(svo_i_commands_alloc(commands, "fills", nodes * 2, &buffers[SVO_TREE_FILLS]));
    }
    return f->areas ? svo_i_commands_alloc(commands, "areas", info->leaf_count * 12, &buffers[SVO_TREE_AREAS]) : SVO_OK;
}

static svo_status create_kernels(filterer *f)
{
    svo_i_commands *commands = &f->build->commands;
    cl_program program = svo_i_build_program(f->build, &svo_i_program_filter);
    const char *gather = f->pairs ? "svo_k_gather_pairs" : f->leaf_sums ? "svo_k_gather" : "svo_k_gather_level";
    if (f->build->kept == NULL) {
        SVO_I_TRY(f->pairs ? SVO_OK : svo_i_commands_kernel(commands, program, "svo_k_link", &f->link));
        SVO_I_TRY(svo_i_commands_kernel(commands, program, gather, &f->gather));
    }
    return f->levels ? svo_i_commands_kernel(commands, program, "svo_k_filter", &f->filter) : SVO_OK;
}

static void release(filterer *f)
{
    cl_kernel kernels[3] = {f->link, f->gather, f->filter};
    for (unsigned i = 0; i < 3; ++i) {
        if (kernels[i] != NULL) {
            clReleaseKernel(kernels[i]);
        }
    }
    cl_mem *buffers[] = {&f->heads,
                         &f->sums[0].weights,
                         &f->sums[0].colors,
                         &f->sums[0].normals,
                         &f->sums[1].weights,
                         &f->sums[1].colors,
                         &f->sums[1].normals,
                         &f->area_sums,
                         &f->long_sums.weights,
                         &f->long_sums.colors,
                         &f->long_sums.normals};
    for (unsigned i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        svo_i_commands_free(&f->build->commands, buffers[i]);
    }
}

/* Launches one work-item per node, or per that many nodes, in parts. One of the arguments is f->params. Work-items of
   many nodes are groups of their own, so that small trees keep all threads of a CPU busy. */
static svo_status launch_parts(filterer *f, cl_kernel kernel, const svo_i_argument *arguments, cl_uint argument_count,
                               uint64_t nodes, uint32_t per_item)
{
    const size_t group_items = per_item == 1 ? SVO_GROUP_ITEMS : 1;
    const uint64_t parts = svo_i_commands_parts(&f->build->commands, nodes);
    for (uint64_t part = 0; part < parts; ++part) {
        const uint64_t first = part * SVO_I_PART_ITEMS;
        const uint64_t count = part + 1 < parts ? SVO_I_PART_ITEMS : nodes - first;
        f->params.first_index = (cl_uint)first;
        SVO_I_TRY(svo_i_commands_launch_groups(&f->build->commands, kernel, arguments, argument_count,
                                               (count + per_item - 1) / per_item, group_items));
    }
    f->params.first_index = 0;
    return SVO_OK;
}

/* The most arguments of a gather kernel. */
#define GATHER_ARGUMENTS 22

/* Puts the arguments that the gather kernels have in common: the chunk's fragments, the surface, the sums. */
static cl_uint put_pairs(const filterer *f, uint32_t chunk, svo_i_argument *arguments)
{
    const svo_i_build *build = f->build;
    const svo_i_surface *surface = &build->surface;
    const level_sums *sums = &f->sums[f->leaf_sums ? 0 : 1];
    const svo_i_argument common[] = {SVO_I_ARGUMENT(build->list.chunks[chunk].buffer),
                                     SVO_I_ARGUMENT(build->cursors[chunk]),
                                     f->pairs ? SVO_I_ARGUMENT(build->order) : SVO_I_ARGUMENT(f->heads),
                                     SVO_I_ARGUMENT(surface->vertices),
                                     SVO_I_ARGUMENT(surface->remainders),
                                     SVO_I_ARGUMENT(surface->indices),
                                     SVO_I_ARGUMENT(surface->records),
                                     SVO_I_ARGUMENT(surface->colors),
                                     SVO_I_ARGUMENT(surface->normals),
                                     SVO_I_ARGUMENT(surface->uvs),
                                     SVO_I_ARGUMENT(surface->materials),
                                     SVO_I_ARGUMENT(surface->texels),
                                     SVO_I_ARGUMENT(sums->weights),
                                     SVO_I_ARGUMENT(sums->colors),
                                     SVO_I_ARGUMENT(sums->normals)};
    memcpy(arguments, common, sizeof common);
    return sizeof common / sizeof common[0];
}

/* Sums a chunk's linked contributions: into the leaves, or into the level above if it is the only chunk. */
static svo_status gather_lists(filterer *f, uint32_t chunk)
{
    svo_i_build *build = f->build;
    svo_tree *tree = build->tree;
    svo_i_argument arguments[GATHER_ARGUMENTS + 1];
    cl_uint count = put_pairs(f, chunk, arguments);
    if (!f->leaf_sums) {
        arguments[count++] = SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]);
        arguments[count++] = SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]);
        arguments[count++] = SVO_I_ARGUMENT(tree->buffers[SVO_TREE_COLORS]);
        arguments[count++] = SVO_I_ARGUMENT(tree->buffers[SVO_TREE_NORMALS]);
        arguments[count++] = SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FILLS]);
    }
    arguments[count++] = SVO_I_ARGUMENT(build->state);
    arguments[count++] = SVO_I_ARGUMENT(f->params);
    if (f->areas) {
        arguments[count++] =
            f->leaf_sums ? SVO_I_ARGUMENT(f->area_sums) : SVO_I_ARGUMENT(tree->buffers[SVO_TREE_AREAS]);
    }
    const uint64_t nodes = f->leaf_sums ? f->params.leaf_count : f->params.level_count;
    const double item_fragments =
        (double)build->list.chunks[chunk].needed * SVO_GATHER_NODES / (double)(nodes > 0 ? nodes : 1);
    svo_i_commands_stage(&build->commands, SVO_STAGE_FILTER, GATHER_NS * item_fragments);
    return launch_parts(f, f->gather, arguments, count, nodes, SVO_GATHER_NODES);
}

/* Adds a chunk's contributions to the leaves, one by one. */
static svo_status gather_pairs(filterer *f, uint32_t chunk)
{
    svo_i_build *build = f->build;
    svo_i_argument arguments[GATHER_ARGUMENTS];
    const uint32_t words = 1u + (f->color ? 4u : 0u) + (f->normal ? 3u : 0u) + (f->areas ? 6u : 0u);
    cl_uint count = put_pairs(f, chunk, arguments);
    arguments[count++] = SVO_I_ARGUMENT(f->area_sums);
    arguments[count++] = SVO_I_ARGUMENT(build->state);
    arguments[count++] = SVO_I_ARGUMENT(f->params);
    arguments[count++] = SVO_I_LOCAL(sizeof(cl_ulong) * words * SVO_GROUP_ITEMS);
    arguments[count++] = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint));
    svo_i_commands_stage(&build->commands, SVO_STAGE_FILTER, GATHER_NS);
    return launch_parts(f, f->gather, arguments, count, f->params.fragment_count, 1);
}

/* Sums a chunk's contributions. */
static svo_status gather_chunk(filterer *f, uint32_t chunk)
{
    svo_i_stage_begin(&f->build->commands);
    svo_i_params_of_level(&f->params, &f->build->tree->info, f->build->tree->info.depth - 1);
    SVO_I_TRY(f->pairs ? gather_pairs(f, chunk) : gather_lists(f, chunk));
    return svo_i_stage_end(&f->build->commands, SVO_STAGE_FILTER);
}

/* Zeroes the sums of all leaves, to which the fragments of several chunks are added. */
static svo_status clear_all_sums(filterer *f)
{
    const struct {
        cl_mem sums;
        uint32_t leaf_bytes;
    } all[] = {{f->sums[0].weights, 8}, {f->sums[0].colors, 32}, {f->sums[0].normals, 24}, {f->area_sums, 48}};
    for (unsigned i = 0; i < sizeof all / sizeof all[0]; ++i) {
        if (all[i].sums != NULL) {
            SVO_I_TRY(svo_i_commands_fill_zero(&f->build->commands, all[i].sums,
                                               (uint64_t)f->params.leaf_count * all[i].leaf_bytes));
        }
    }
    return SVO_OK;
}

/* Zeroes those of the leaves that two work-groups add to; the others' are written. */
static svo_status clear_shared_sums(filterer *f)
{
    svo_i_build *build = f->build;
    f->params.fragment_count = (cl_uint)build->list.chunks[0].needed;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(build->cursors[0]),  SVO_I_ARGUMENT(build->order),
                                        SVO_I_ARGUMENT(f->sums[0].weights), SVO_I_ARGUMENT(f->sums[0].colors),
                                        SVO_I_ARGUMENT(f->sums[0].normals), SVO_I_ARGUMENT(f->area_sums),
                                        SVO_I_ARGUMENT(build->state),       SVO_I_ARGUMENT(f->params)};
    return svo_i_commands_run(&build->commands, svo_i_build_program(build, &svo_i_program_filter), "svo_k_clear_shared",
                              SVO_I_ARGUMENTS(arguments), f->params.fragment_count / SVO_GROUP_ITEMS);
}

/* Fragments that are gathered one by one are added to zero. */
static svo_status clear_sums(filterer *f)
{
    svo_i_stage_begin(&f->build->commands);
    SVO_I_TRY(f->params.grouped != 0 ? clear_shared_sums(f) : clear_all_sums(f));
    return svo_i_stage_end(&f->build->commands, SVO_STAGE_FILTER);
}

/* Sums up the leaves of many kept pairs, for which a work-item would take too long. */
static svo_status gather_long(filterer *f)
{
    svo_i_build *build = f->build;
    const svo_i_kept *kept = build->kept;
    const level_sums *sums = &f->long_sums;
    const uint64_t groups = (build->fragment_count + SVO_KEPT_LONG - 1) / SVO_KEPT_LONG;
    requests r = {.count = 0};
    ask_sums(f, &r, &f->long_sums, build->tree->info.depth, groups);
    SVO_I_TRY(svo_i_commands_alloc_all(&build->commands, r.all, r.count));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(kept->values),
                                        SVO_I_ARGUMENT(build->tree->buffers[SVO_TREE_LIST_BEGIN]),
                                        SVO_I_ARGUMENT(sums->weights),
                                        SVO_I_ARGUMENT(sums->colors),
                                        SVO_I_ARGUMENT(sums->normals),
                                        SVO_I_ARGUMENT(build->state),
                                        SVO_I_ARGUMENT(f->params),
                                        SVO_I_LOCAL(sizeof(cl_ulong) * SVO_GROUP_ITEMS),
                                        SVO_I_ARGUMENT(kept->areas),
                                        SVO_I_ARGUMENT(kept->edges),
                                        SVO_I_ARGUMENT(build->tree->buffers[SVO_TREE_AREAS])};
    const cl_uint count = (cl_uint)(sizeof arguments / sizeof arguments[0]) - (f->areas ? 0 : KEPT_AREA_ARGUMENTS);
    return svo_i_commands_run(&build->commands, kept->program, "svo_k_moving_long", arguments, count,
                              groups * SVO_GROUP_ITEMS);
}

/* Sums pairs that are weighed already, into the level above the leaves. */
static svo_status gather_kept(filterer *f)
{
    svo_i_build *build = f->build;
    const svo_i_kept *kept = build->kept;
    const level_sums *sums = &f->sums[1];
    const cl_mem *tree = build->tree->buffers;
    svo_i_params_of_level(&f->params, &build->tree->info, build->tree->info.depth - 1);
    f->params.fragment_count = (cl_uint)build->fragment_count;
    svo_i_stage_begin(&build->commands);
    SVO_I_TRY(build->commands.device->cpu_path ? SVO_OK : gather_long(f));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(kept->values),
                                        SVO_I_ARGUMENT(tree[SVO_TREE_LIST_BEGIN]),
                                        SVO_I_ARGUMENT(f->long_sums.weights),
                                        SVO_I_ARGUMENT(f->long_sums.colors),
                                        SVO_I_ARGUMENT(f->long_sums.normals),
                                        SVO_I_ARGUMENT(sums->weights),
                                        SVO_I_ARGUMENT(sums->colors),
                                        SVO_I_ARGUMENT(sums->normals),
                                        SVO_I_ARGUMENT(tree[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(tree[SVO_TREE_COLORS]),
                                        SVO_I_ARGUMENT(tree[SVO_TREE_NORMALS]),
                                        SVO_I_ARGUMENT(tree[SVO_TREE_FILLS]),
                                        SVO_I_ARGUMENT(build->state),
                                        SVO_I_ARGUMENT(f->params),
                                        SVO_I_ARGUMENT(kept->areas),
                                        SVO_I_ARGUMENT(kept->edges),
                                        SVO_I_ARGUMENT(tree[SVO_TREE_AREAS])};
    const cl_uint count = (cl_uint)(sizeof arguments / sizeof arguments[0]) - (f->areas ? 0 : KEPT_AREA_ARGUMENTS);
    SVO_I_TRY(svo_i_commands_run(&build->commands, kept->program, "svo_k_moving_gather", arguments, count,
                                 f->params.level_count));
    return svo_i_stage_end(&build->commands, SVO_STAGE_FILTER);
}

/* Links the fragments of each leaf of a chunk into a list, by atomic exchange (kernels/stages/link.cl). heads receives
   the first fragment of each leaf; the cursors become the links. */
static svo_status link_chunk(svo_i_build *build, cl_kernel kernel, uint32_t chunk, cl_mem heads,
                             svo_filter_params params)
{
    svo_i_commands *commands = &build->commands;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(build->cursors[chunk]), SVO_I_ARGUMENT(heads),
                                        SVO_I_ARGUMENT(build->state), SVO_I_ARGUMENT(params)};
    svo_i_stage_begin(commands);
    SVO_I_TRY(svo_i_commands_fill_zero(commands, heads, params.leaf_count * UINT64_C(4)));
    SVO_I_TRY(svo_i_commands_launch(commands, kernel, SVO_I_ARGUMENTS(arguments), params.fragment_count));
    return svo_i_stage_end(commands, SVO_STAGE_LINK);
}

static svo_status gather_leaves(filterer *f)
{
    if (f->build->kept != NULL) {
        return gather_kept(f);
    }
    f->params.first_chunk = 1;
    f->params.grouped = f->build->list.chunk_count == 1 ? 1 : 0;
    SVO_I_TRY(f->pairs ? clear_sums(f) : SVO_OK);
    for (uint32_t i = 0; i < f->build->list.chunk_count; ++i) {
        f->params.fragment_count = (cl_uint)f->build->list.chunks[i].needed;
        if (!f->pairs) {
            svo_i_commands_stage(&f->build->commands, SVO_STAGE_LINK, LINK_NS);
            SVO_I_TRY(link_chunk(f->build, f->link, i, f->heads, f->params));
        }
        SVO_I_TRY(gather_chunk(f, i));
        f->params.first_chunk = 0;
    }
    return SVO_OK;
}

/* Writes the leaves' areas from their sums. */
static svo_status round_areas(filterer *f)
{
    svo_i_commands *commands = &f->build->commands;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(f->area_sums),
                                        SVO_I_ARGUMENT(f->build->tree->buffers[SVO_TREE_AREAS]),
                                        SVO_I_ARGUMENT(f->build->state), SVO_I_ARGUMENT(f->params)};
    svo_i_stage_begin(commands);
    svo_i_commands_stage(commands, SVO_STAGE_FILTER, NODE_NS);
    SVO_I_TRY(svo_i_commands_run(commands, svo_i_build_program(f->build, &svo_i_program_filter), "svo_k_round_areas",
                                 SVO_I_ARGUMENTS(arguments), f->params.leaf_count));
    return svo_i_stage_end(commands, SVO_STAGE_FILTER);
}

/* Adds up the children's sums for the nodes of one level, or of it and all levels above. */
static svo_status filter_level(filterer *f, const level_sums *children, const level_sums *nodes, bool is_top)
{
    svo_tree *tree = f->build->tree;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(children->weights),
                                        SVO_I_ARGUMENT(children->colors),
                                        SVO_I_ARGUMENT(children->normals),
                                        SVO_I_ARGUMENT(nodes->weights),
                                        SVO_I_ARGUMENT(nodes->colors),
                                        SVO_I_ARGUMENT(nodes->normals),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_COLORS]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_NORMALS]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FILLS]),
                                        SVO_I_ARGUMENT(f->build->state),
                                        SVO_I_ARGUMENT(f->params)};
    return is_top ? svo_i_commands_run(&f->build->commands, svo_i_build_program(f->build, &svo_i_program_filter),
                                       "svo_k_filter_top", SVO_I_ARGUMENTS(arguments), SVO_GROUP_ITEMS)
                  : launch_parts(f, f->filter, SVO_I_ARGUMENTS(arguments), f->params.level_count, 1);
}

static svo_status filter_levels(filterer *f)
{
    const uint32_t depth = f->build->tree->info.depth;
    const uint32_t first = f->params.payload_level;
    const uint32_t last_level = first > 0 ? first - 1 : 0; /* inner nodes write the payload of their children too */
    svo_i_stage_begin(&f->build->commands);
    svo_i_commands_stage(&f->build->commands, SVO_STAGE_FILTER, NODE_NS);
    bool is_top = false;
    for (uint32_t level = f->leaf_sums ? depth : depth - 1; level-- > last_level && !is_top;) {
        const unsigned odd = (depth - level) % 2;
        is_top = level <= SVO_TOP_LEVEL;
        svo_i_params_of_level(&f->params, &f->build->tree->info, level);
        SVO_I_TRY(filter_level(f, &f->sums[1 - odd], &f->sums[odd], is_top));
    }
    return svo_i_stage_end(&f->build->commands, SVO_STAGE_FILTER);
}

/* Zeroes the root's payload, for a tree without leaves. */
static svo_status clear_payload(filterer *f)
{
    svo_i_build *build = f->build;
    if (f->params.payload_level > 0) { /* the root has no payload */
        return SVO_OK;
    }
    if (f->color) {
        SVO_I_TRY(svo_i_commands_fill_zero(&build->commands, build->tree->buffers[SVO_TREE_COLORS], 4));
    }
    if (f->normal) {
        SVO_I_TRY(svo_i_commands_fill_zero(&build->commands, build->tree->buffers[SVO_TREE_NORMALS], 6));
    }
    if (f->fill) {
        SVO_I_TRY(svo_i_commands_fill_zero(&build->commands, build->tree->buffers[SVO_TREE_FILLS], 2));
    }
    return SVO_OK;
}

/* Keeps the root's sums of a part, from which the levels above it are made. */
static svo_status keep_root(filterer *f)
{
    svo_i_commands *commands = &f->build->commands;
    svo_i_node_sums *root = &f->build->tree->part.root;
    const level_sums *sums = &f->sums[f->build->tree->info.depth % 2];
    SVO_I_TRY(svo_i_commands_read(commands, sums->weights, &root->weight, sizeof root->weight));
    if (f->color) {
        SVO_I_TRY(svo_i_commands_read(commands, sums->colors, root->color, sizeof root->color));
    }
    return f->normal ? svo_i_commands_read(commands, sums->normals, root->normal, sizeof root->normal) : SVO_OK;
}

static svo_status run(filterer *f)
{
    const bool is_empty = f->build->tree->info.leaf_count == 0;
    SVO_I_TRY(allocate(f));
    if (is_empty || f->build->commands.mode == SVO_I_MODE_ENQUEUE) { /* an enqueued tree may turn out empty */
        SVO_I_TRY(clear_payload(f));
    }
    if (is_empty) {
        return SVO_OK;
    }
    SVO_I_TRY(create_kernels(f));
    SVO_I_TRY(gather_leaves(f));
    if (f->areas && f->leaf_sums) {
        SVO_I_TRY(round_areas(f));
    }
    if (!f->levels) {
        return SVO_OK;
    }
    SVO_I_TRY(filter_levels(f));
    return svo_i_part_sums_root(f->build->commands.plan) ? keep_root(f) : SVO_OK;
}

/* Releases the order of leaves, and their ranges if nothing else needs them. */
static void free_order(svo_i_build *build)
{
    const svo_i_work *work = &build->commands.plan->work;
    svo_i_commands_free(&build->commands, &build->order);
    if (work->order && !work->lists) {
        svo_i_commands_free(&build->commands, &build->tree->buffers[SVO_TREE_LIST_BEGIN]);
    }
}

svo_status svo_i_filter(svo_i_build *build)
{
    const svo_i_work *work = &build->commands.plan->work;
    const uint32_t made = work->made;
    filterer f = {.build = build,
                  .color = (made & SVO_NEED_COLOR) != 0,
                  .normal = (made & SVO_NEED_NORMAL) != 0,
                  .fill = (made & SVO_NEED_FILL) != 0,
                  .areas = (made & SVO_NEED_PROJECTED_AREA) != 0,
                  .levels = (made & SVO_I_NEED_FILTER) != 0,
                  .pairs = build->kept == NULL && !work->pair_lanes,
                  .leaf_sums = build->kept == NULL && (!work->pair_lanes || build->list.chunk_count > 1),
                  .params = svo_i_payload_params(build)};
    const svo_status status = run(&f);
    release(&f);
    free_order(build);
    return status;
}
