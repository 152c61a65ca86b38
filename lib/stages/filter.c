/* SPDX-License-Identifier: MIT */
/*
 * Runs kernels/link.cl and kernels/filter.cl: the leaves' fragments are linked and their contributions summed up, then
 * sums travel up level by level and every node's color, normal and fill are written.
 *
 * A list of one chunk, the usual case, is gathered straight into the sums of the deepest inner level. Otherwise lists
 * are linked and gathered chunk by chunk, and the leaves need sums of their own in between.
 */
#include <string.h>

#include "build/build.h"

/* The sums of one level. */
typedef struct level_sums {
    cl_mem weights, colors, normals;
} level_sums;

typedef struct filterer {
    svo_i_build *build;
    const svo_i_surface *surface;
    bool color, normal, fill;
    cl_mem heads;
    level_sums sums[2]; /* of levels whose distance from the leaves is even, and odd */
    cl_kernel link, gather, filter;
    bool one_chunk;
    svo_filter_params params;
} filterer;

svo_filter_params svo_i_payload_params(const svo_i_build *build)
{
    const svo_tree_info *info = &build->tree->info;
    return (svo_filter_params){.depth = info->depth,
                               .leaf_begin = (cl_uint)info->inner_count,
                               .leaf_count = (cl_uint)info->leaf_count,
                               .voxel_log2 = build->plan->voxel_log2,
                               .weight_log2 = build->plan->weight_log2,
                               .payload_level = info->payload_level};
}

void svo_i_params_of_level(svo_filter_params *params, const svo_tree_info *info, uint32_t level)
{
    params->level = level;
    params->level_begin = info->level_begin[level];
    params->level_count = info->level_begin[level + 1] - info->level_begin[level];
    params->child_begin = info->level_begin[level + 1];
    params->fill_shift = params->weight_log2 + 2 * (info->depth - level - 1) - SVO_I_FILL_LOG2;
}

/* Sums of a level's nodes, if a level above will read them. */
static svo_status allocate_sums(filterer *f, level_sums *sums, uint32_t level, uint64_t nodes)
{
    if (level < f->params.payload_level) {
        return SVO_OK;
    }
    svo_status status = svo_i_build_alloc(f->build, "weights", nodes * 8, &sums->weights);
    if (status == SVO_OK && f->color) {
        status = svo_i_build_alloc(f->build, "color_sums", nodes * 32, &sums->colors);
    }
    if (status == SVO_OK && f->normal) {
        status = svo_i_build_alloc(f->build, "normal_sums", nodes * 24, &sums->normals);
    }
    return status;
}

static svo_status allocate(filterer *f)
{
    svo_i_build *build = f->build;
    const svo_tree_info *info = &build->tree->info;
    const uint64_t parents = info->inner_count - info->level_begin[info->depth - 1];
    const uint64_t nodes = info->node_count - info->level_begin[info->payload_level];
    svo_status status = svo_i_build_alloc(build, "heads", info->leaf_count * 4, &f->heads);
    if (status == SVO_OK) {
        const uint64_t above =
            info->depth > 1 ? info->level_begin[info->depth - 1] - info->level_begin[info->depth - 2] : 1;
        status = f->one_chunk && info->depth > 1 ? allocate_sums(f, &f->sums[0], info->depth - 2, above)
                 : f->one_chunk                  ? SVO_OK
                                                 : allocate_sums(f, &f->sums[0], info->depth, info->leaf_count);
    }
    if (status == SVO_OK) {
        status = allocate_sums(f, &f->sums[1], info->depth - 1, parents);
    }
    if (status == SVO_OK && f->color) {
        status = svo_i_build_alloc(build, "colors", nodes * 4, &build->tree->buffers[SVO_TREE_COLORS]);
    }
    if (status == SVO_OK && f->normal) {
        status = svo_i_build_alloc(build, "normals", nodes * 6, &build->tree->buffers[SVO_TREE_NORMALS]);
    }
    if (status == SVO_OK && f->fill) {
        status = svo_i_build_alloc(build, "fills", nodes * 2, &build->tree->buffers[SVO_TREE_FILLS]);
    }
    return status;
}

static svo_status create_kernels(filterer *f)
{
    svo_status status = svo_i_build_kernel(f->build, "svo_k_link", &f->link);
    if (status == SVO_OK) {
        status = svo_i_build_kernel(f->build, f->one_chunk ? "svo_k_gather_level" : "svo_k_gather", &f->gather);
    }
    return status == SVO_OK ? svo_i_build_kernel(f->build, "svo_k_filter", &f->filter) : status;
}

static void release(filterer *f)
{
    cl_kernel kernels[3] = {f->link, f->gather, f->filter};
    for (unsigned i = 0; i < 3; ++i) {
        if (kernels[i] != NULL) {
            clReleaseKernel(kernels[i]);
        }
    }
    cl_mem *buffers[] = {&f->heads,           &f->sums[0].weights, &f->sums[0].colors, &f->sums[0].normals,
                         &f->sums[1].weights, &f->sums[1].colors,  &f->sums[1].normals};
    for (unsigned i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        svo_i_build_free(f->build, buffers[i]);
    }
}

static svo_status link_chunk(filterer *f, uint32_t chunk)
{
    svo_i_build_stage_begin(f->build);
    svo_status status = svo_i_build_fill_zero(f->build, f->heads, f->params.leaf_count * UINT64_C(4));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(f->build->cursors[chunk]), SVO_I_ARGUMENT(f->heads),
                                        SVO_I_ARGUMENT(f->build->state), SVO_I_ARGUMENT(f->params)};
    if (status == SVO_OK) {
        status = svo_i_build_launch(f->build, f->link, arguments, 4, f->params.fragment_count);
    }
    return status == SVO_OK ? svo_i_build_stage_end(f->build, SVO_STAGE_LINK) : status;
}

/* Gathers a chunk: into the leaves' sums, or where it is the only one into those of the level above. */
static svo_status gather_chunk(filterer *f, uint32_t chunk)
{
    svo_i_build *build = f->build;
    svo_tree *tree = build->tree;
    const level_sums *sums = &f->sums[f->one_chunk ? 1 : 0];
    const svo_i_argument common[] = {
        SVO_I_ARGUMENT(build->list.chunks[chunk].buffer),
        SVO_I_ARGUMENT(build->cursors[chunk]),
        SVO_I_ARGUMENT(f->heads),
        SVO_I_ARGUMENT(f->surface->vertices),
        SVO_I_ARGUMENT(f->surface->indices),
        SVO_I_ARGUMENT(f->surface->records),
        SVO_I_ARGUMENT(f->surface->colors),
        SVO_I_ARGUMENT(f->surface->normals),
        SVO_I_ARGUMENT(f->surface->uvs),
        SVO_I_ARGUMENT(f->surface->materials),
        SVO_I_ARGUMENT(f->surface->texels),
        SVO_I_ARGUMENT(sums->weights),
        SVO_I_ARGUMENT(sums->colors),
        SVO_I_ARGUMENT(sums->normals),
    };
    enum { COMMON = sizeof common / sizeof common[0] };
    svo_i_argument arguments[COMMON + 7];
    cl_uint count = COMMON;
    memcpy(arguments, common, sizeof common);
    svo_i_params_of_level(&f->params, &tree->info, tree->info.depth - 1);
    if (f->one_chunk) {
        arguments[count++] = SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]);
        arguments[count++] = SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]);
        arguments[count++] = SVO_I_ARGUMENT(tree->buffers[SVO_TREE_COLORS]);
        arguments[count++] = SVO_I_ARGUMENT(tree->buffers[SVO_TREE_NORMALS]);
        arguments[count++] = SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FILLS]);
    }
    arguments[count++] = SVO_I_ARGUMENT(build->state);
    arguments[count++] = SVO_I_ARGUMENT(f->params);
    svo_i_build_stage_begin(build);
    const svo_status status = svo_i_build_launch(build, f->gather, arguments, count,
                                                 f->one_chunk ? f->params.level_count : f->params.leaf_count);
    return status == SVO_OK ? svo_i_build_stage_end(build, SVO_STAGE_FILTER) : status;
}

static svo_status gather_leaves(filterer *f)
{
    svo_status status = SVO_OK;
    f->params.first_chunk = 1;
    for (uint32_t i = 0; i < f->build->list.chunk_count && status == SVO_OK; ++i) {
        f->params.fragment_count = (cl_uint)f->build->list.chunks[i].needed;
        status = link_chunk(f, i);
        if (status == SVO_OK) {
            status = gather_chunk(f, i);
        }
        f->params.first_chunk = 0;
    }
    return status;
}

/* The nodes of one level take up their children's sums. */
static svo_status filter_level(filterer *f, const level_sums *children, const level_sums *nodes)
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
    return svo_i_build_launch(f->build, f->filter, arguments, 13, f->params.level_count);
}

static svo_status filter_levels(filterer *f)
{
    const uint32_t depth = f->build->tree->info.depth;
    const uint32_t first = f->params.payload_level;
    const uint32_t last_level = first > 0 ? first - 1 : 0; /* its nodes write the payload of their children */
    svo_i_build_stage_begin(f->build);
    svo_status status = SVO_OK;
    for (uint32_t level = f->one_chunk ? depth - 1 : depth; level-- > last_level && status == SVO_OK;) {
        const unsigned odd = (depth - level) % 2;
        svo_i_params_of_level(&f->params, &f->build->tree->info, level);
        status = filter_level(f, &f->sums[1 - odd], &f->sums[odd]);
    }
    return status == SVO_OK ? svo_i_build_stage_end(f->build, SVO_STAGE_FILTER) : status;
}

/* A tree without leaves: a root whose payload is zero. */
static svo_status clear_payload(filterer *f)
{
    svo_i_build *build = f->build;
    svo_status status = SVO_OK;
    if (f->params.payload_level > 0) { /* the root has none */
        return status;
    }
    if (f->color) {
        status = svo_i_build_fill_zero(build, build->tree->buffers[SVO_TREE_COLORS], 4);
    }
    if (status == SVO_OK && f->normal) {
        status = svo_i_build_fill_zero(build, build->tree->buffers[SVO_TREE_NORMALS], 6);
    }
    if (status == SVO_OK && f->fill) {
        status = svo_i_build_fill_zero(build, build->tree->buffers[SVO_TREE_FILLS], 2);
    }
    return status;
}

static svo_status run(filterer *f)
{
    svo_status status = allocate(f);
    const bool empty = f->build->tree->info.leaf_count == 0;
    if (status == SVO_OK && (empty || f->build->mode == SVO_I_BUILD_ENQUEUES)) { /* that may turn out to be empty */
        status = clear_payload(f);
    }
    if (status != SVO_OK || empty) {
        return status;
    }
    status = create_kernels(f);
    if (status == SVO_OK) {
        status = gather_leaves(f);
    }
    return status == SVO_OK ? filter_levels(f) : status;
}

svo_status svo_i_filter(svo_i_build *build, const svo_i_surface *surface)
{
    const uint32_t made = build->plan->work.made;
    filterer f = {.build = build,
                  .surface = surface,
                  .color = (made & SVO_NEED_COLOR) != 0,
                  .normal = (made & SVO_NEED_NORMAL) != 0,
                  .fill = (made & SVO_NEED_FILL) != 0,
                  .one_chunk = build->list.chunk_count == 1,
                  .params = svo_i_payload_params(build)};
    const svo_status status = run(&f);
    release(&f);
    return status;
}
