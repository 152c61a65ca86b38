/* SPDX-License-Identifier: MIT */
/*
 * Runs shaders/link.comp and shaders/filter.comp: the leaves' fragments are linked and their contributions summed up, then
 * sums travel up level by level and every node's colour, normal and fill are written. Lists of one chunk and of several go
 * as in lib/filter.c.
 */
#include "gl_build.h"

typedef struct filterer {
    svo_i_gl_build *gl_build;
    const svo_i_gl_surface *surface;
    GLuint heads;
    GLuint sums[2]; /* of levels whose distance from the leaves is even, and odd */
    bool one_chunk;
    svo_filter_params params;
} filterer;

static bool needs(const filterer *f, svo_need bit)
{
    return (f->gl_build->build->tree->info.need & (uint32_t)bit) != 0;
}

static svo_status allocate_payload(filterer *f)
{
    static const svo_need bits[] = {SVO_NEED_COLOR, SVO_NEED_NORMAL, SVO_NEED_FILL};
    static const svo_tree_buffer arrays[] = {SVO_TREE_COLORS, SVO_TREE_NORMALS, SVO_TREE_FILLS};
    static const unsigned node_bytes[] = {4, 6, 2};
    svo_status status = SVO_OK;
    for (unsigned i = 0; i < 3 && status == SVO_OK; ++i) {
        if (needs(f, bits[i])) {
            status = svo_i_compute_alloc_zero(f->gl_build->compute, svo_tree_buffer_name(arrays[i]),
                                              f->gl_build->build->tree->info.node_count * node_bytes[i],
                                              &f->gl_build->arrays[arrays[i]]);
        }
    }
    return status;
}

static svo_status allocate(filterer *f)
{
    svo_i_compute *compute = f->gl_build->compute;
    const svo_tree_info *info = &f->gl_build->build->tree->info;
    const uint64_t parents = info->inner_count - info->level_begin[info->depth - 1];
    const uint64_t above = info->depth > 1 ? info->level_begin[info->depth - 1] - info->level_begin[info->depth - 2] : 1;
    const uint64_t node_bytes =
        8u * (1u + (needs(f, SVO_NEED_COLOR) ? 4u : 0u) + (needs(f, SVO_NEED_NORMAL) ? 3u : 0u));
    svo_status status = svo_i_compute_alloc(compute, "heads", info->leaf_count * 4, &f->heads);
    if (status == SVO_OK) {
        status = svo_i_compute_alloc(compute, "sums", (f->one_chunk ? above : info->leaf_count) * node_bytes,
                                     &f->sums[0]);
    }
    return status == SVO_OK ? svo_i_compute_alloc(compute, "sums", parents * node_bytes, &f->sums[1]) : status;
}

static svo_status link_chunk(filterer *f, uint32_t chunk)
{
    svo_i_compute *compute = f->gl_build->compute;
    svo_i_compute_stage_begin(compute);
    svo_i_compute_fill_zero(compute, f->heads);
    const svo_status status =
        svo_i_compute_launch(compute, &(svo_i_launch){.entry = SVO_I_ENTRY_LINK,
                                                      .buffers = {f->gl_build->cursors[chunk], f->heads},
                                                      .params = &f->params,
                                                      .items = f->params.fragment_count});
    return status == SVO_OK ? svo_i_compute_stage_end(compute, f->gl_build->build, SVO_STAGE_LINK) : status;
}

/* Gathers a chunk: into the leaves' sums, or where it is the only one into those of the level above. */
static svo_status gather_chunk(filterer *f, uint32_t chunk)
{
    svo_i_gl_build *gl_build = f->gl_build;
    const svo_tree_info *info = &gl_build->build->tree->info;
    const svo_i_gl_surface *surface = f->surface;
    const GLuint *arrays = gl_build->arrays;
    svo_i_params_of_level(&f->params, info, info->depth - 1);
    const svo_i_launch launch = {
        .entry = f->one_chunk ? SVO_I_ENTRY_GATHER_LEVEL : SVO_I_ENTRY_GATHER,
        .buffers = {svo_i_gl_chunk(gl_build, chunk), gl_build->cursors[chunk], surface->vertices, surface->indices,
                    surface->records, surface->attributes, surface->materials, surface->texels, f->heads,
                    f->sums[f->one_chunk ? 1 : 0], arrays[SVO_TREE_CHILD_MASK], arrays[SVO_TREE_FIRST_CHILD],
                    arrays[SVO_TREE_COLORS], arrays[SVO_TREE_NORMALS], arrays[SVO_TREE_FILLS]},
        .params = &f->params,
        .vertex_count = gl_build->build->plan->vertex_count,
        .items = f->one_chunk ? f->params.level_count : f->params.leaf_count};
    svo_i_compute_stage_begin(gl_build->compute);
    const svo_status status = svo_i_compute_launch(gl_build->compute, &launch);
    return status == SVO_OK ? svo_i_compute_stage_end(gl_build->compute, gl_build->build, SVO_STAGE_FILTER) : status;
}

static svo_status gather_leaves(filterer *f)
{
    const svo_i_fragment_list *list = &f->gl_build->build->list;
    svo_status status = SVO_OK;
    f->params.first_chunk = 1;
    for (uint32_t i = 0; i < list->chunk_count && status == SVO_OK; ++i) {
        f->params.fragment_count = (cl_uint)list->chunks[i].needed;
        status = link_chunk(f, i);
        if (status == SVO_OK) {
            status = gather_chunk(f, i);
        }
        f->params.first_chunk = 0;
    }
    return status;
}

/* The nodes of one level take up their children's sums. */
static svo_status filter_level(filterer *f, uint32_t level)
{
    svo_i_gl_build *gl_build = f->gl_build;
    const GLuint *arrays = gl_build->arrays;
    const unsigned odd = (gl_build->build->tree->info.depth - level) % 2;
    svo_i_params_of_level(&f->params, &gl_build->build->tree->info, level);
    return svo_i_compute_launch(gl_build->compute,
                                &(svo_i_launch){.entry = SVO_I_ENTRY_FILTER,
                                                .buffers = {arrays[SVO_TREE_CHILD_MASK], arrays[SVO_TREE_FIRST_CHILD],
                                                            f->sums[1 - odd], f->sums[odd], arrays[SVO_TREE_COLORS],
                                                            arrays[SVO_TREE_NORMALS], arrays[SVO_TREE_FILLS]},
                                                .params = &f->params,
                                                .items = f->params.level_count});
}

static svo_status filter_levels(filterer *f)
{
    const uint32_t depth = f->gl_build->build->tree->info.depth;
    svo_i_compute_stage_begin(f->gl_build->compute);
    svo_status status = SVO_OK;
    for (uint32_t level = f->one_chunk ? depth - 1 : depth; level-- > 0 && status == SVO_OK;) {
        status = filter_level(f, level);
    }
    return status == SVO_OK ? svo_i_compute_stage_end(f->gl_build->compute, f->gl_build->build, SVO_STAGE_FILTER)
                            : status;
}

/* Compiled now, not in the stage that launches it: how many chunks there are was not known before. */
static svo_status compile_gather(filterer *f)
{
    svo_i_compute_program *program = NULL;
    const double start_ms = svo_i_now_ms();
    const svo_status status = f->one_chunk ? SVO_OK : svo_i_compute_program_get(f->gl_build->compute, SVO_I_ENTRY_GATHER, &program);
    svo_i_report_add(f->gl_build->build->report, SVO_STAGE_COMPILE, svo_i_now_ms() - start_ms, "wall");
    return status;
}

static svo_status run(filterer *f)
{
    svo_status status = allocate_payload(f);
    if (status != SVO_OK || f->params.leaf_count == 0) { /* without leaves, a root whose payload is zero */
        return status;
    }
    status = allocate(f);
    if (status == SVO_OK) {
        status = compile_gather(f);
    }
    if (status == SVO_OK) {
        status = gather_leaves(f);
    }
    return status == SVO_OK ? filter_levels(f) : status;
}

svo_status svo_i_gl_filter(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface)
{
    filterer f = {.gl_build = gl_build,
                  .surface = surface,
                  .one_chunk = gl_build->build->list.chunk_count == 1,
                  .params = svo_i_payload_params(gl_build->build)};
    const svo_status status = run(&f);
    svo_i_compute_free(gl_build->compute, &f.heads);
    svo_i_compute_free(gl_build->compute, &f.sums[0]);
    svo_i_compute_free(gl_build->compute, &f.sums[1]);
    return status;
}
