/* SPDX-License-Identifier: MIT */
/*
 * Runs shaders/link.comp and shaders/filter.comp: the leaves' fragments are linked and their contributions summed up,
 * then sums travel up level by level and every node's color, normal and fill are written.
 *
 * A list of one chunk, the usual case, is linked and gathered straight into the sums of the deepest inner level.
 * Several chunks, and voxels of more triangles than an invocation may turn loops for (shaders/compute.glsl), are added
 * up in sums of the leaves, fragment by fragment.
 */
#include "compute/filter.h"

#include "commands/timing.h"
#include "compute/buffer.h"
#include "stages/payload_params.h"

typedef struct filterer {
    svo_i_gl_build *gl_build;
    const svo_i_gl_surface *surface;
    GLuint heads, links;
    GLuint sums[2]; /* of levels whose distance from the leaves is even, and odd */
    uint64_t node_bytes; /* of a node's sums */
    svo_filter_params params;
} filterer;

static bool needs(const filterer *f, svo_need bit)
{
    return (f->gl_build->build->commands.plan->work.made & (uint32_t)bit) != 0;
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

/* Of the parents of leaves, and of their parents. */
static svo_status allocate_sums(filterer *f)
{
    const svo_tree_info *info = &f->gl_build->build->tree->info;
    const uint64_t parents = info->inner_count - info->level_begin[info->depth - 1];
    const uint64_t above =
        info->depth > 1 ? info->level_begin[info->depth - 1] - info->level_begin[info->depth - 2] : 1;
    const svo_status status = svo_i_compute_alloc(f->gl_build->compute, "sums", above * f->node_bytes, &f->sums[0]);
    return status == SVO_OK ? svo_i_compute_alloc(f->gl_build->compute, "sums", parents * f->node_bytes, &f->sums[1])
                            : status;
}

/* The lists of the one chunk's leaves. */
static svo_status link_leaves(filterer *f)
{
    svo_i_compute *compute = f->gl_build->compute;
    f->params.fragment_count = (cl_uint)f->gl_build->build->fragment_count;
    svo_i_compute_stage_begin(compute);
    svo_status status = svo_i_compute_alloc_zero(compute, "heads", f->params.leaf_count * UINT64_C(4), &f->heads);
    if (status == SVO_OK) {
        status = svo_i_compute_alloc(compute, "links", f->params.fragment_count * UINT64_C(4), &f->links);
    }
    if (status == SVO_OK) {
        status = svo_i_compute_launch(compute, &(svo_i_launch){.entry = SVO_I_ENTRY_LINK,
                                                               .buffers = {f->gl_build->cursors[0], f->heads, f->links},
                                                               .params = &f->params,
                                                               .items = f->params.fragment_count});
    }
    return status == SVO_OK ? svo_i_compute_stage_end(compute, f->gl_build->build, SVO_STAGE_LINK) : status;
}

/* What a chunk's fragments contribute: into sums, item by item, by links or cursors. */
static svo_status gather(filterer *f, svo_i_entry entry, uint32_t chunk, GLuint links, GLuint sums, uint64_t items)
{
    svo_i_gl_build *gl_build = f->gl_build;
    const svo_i_gl_surface *surface = f->surface;
    const GLuint *arrays = gl_build->arrays;
    const svo_i_launch launch = {.entry = entry,
                                 .buffers = {svo_i_gl_chunk(gl_build, chunk), links, surface->vertices,
                                             surface->indices, surface->records, surface->attributes,
                                             surface->materials, surface->texels, f->heads, sums,
                                             arrays[SVO_TREE_CHILD_MASK], arrays[SVO_TREE_FIRST_CHILD],
                                             arrays[SVO_TREE_COLORS], arrays[SVO_TREE_NORMALS], arrays[SVO_TREE_FILLS]},
                                 .params = &f->params,
                                 .vertex_count = gl_build->build->commands.plan->vertex_count,
                                 .items = items};
    return svo_i_compute_launch(gl_build->compute, &launch);
}

/* The leaves' payload and the sums of the level above them, by walking the lists. *walked is false where a list is too
   long for that on this context; nothing then is as it should be. */
static svo_status walk_leaves(filterer *f, bool *walked)
{
    const svo_tree_info *info = &f->gl_build->build->tree->info;
    svo_i_compute *compute = f->gl_build->compute;
    bool exhausted = false;
    svo_i_params_of_level(&f->params, info, info->depth - 1);
    svo_i_compute_stage_begin(compute);
    svo_status status = gather(f, SVO_I_ENTRY_GATHER_LEVEL, 0, f->links, f->sums[1], f->params.level_count);
    if (status == SVO_OK) {
        status = svo_i_compute_stage_end(compute, f->gl_build->build, SVO_STAGE_FILTER);
    }
    if (status == SVO_OK) {
        status = svo_i_compute_exhausted(compute, &exhausted);
    }
    *walked = !exhausted;
    return status;
}

/* Compiled now, not in the stage that launches it: it is rarely needed. */
static svo_status compile_gather(filterer *f)
{
    svo_i_compute_program *program = NULL;
    const double start_ms = svo_i_now_ms();
    const svo_status status = svo_i_compute_program_get(f->gl_build->compute, SVO_I_ENTRY_GATHER, &program);
    svo_i_report_add(f->gl_build->build->commands.report, SVO_STAGE_COMPILE, svo_i_now_ms() - start_ms, "wall");
    return status;
}

/* The leaves' sums, fragment by fragment: of any number of chunks, and of voxels with any number of triangles. */
static svo_status add_leaves(filterer *f)
{
    svo_i_gl_build *gl_build = f->gl_build;
    const svo_i_fragment_list *list = &gl_build->build->list;
    svo_i_compute_free(gl_build->compute, &f->sums[0]);
    svo_status status = compile_gather(f);
    svo_i_compute_stage_begin(gl_build->compute);
    if (status == SVO_OK) {
        status = svo_i_compute_alloc_zero(gl_build->compute, "sums", f->params.leaf_count * f->node_bytes, &f->sums[0]);
    }
    for (uint32_t i = 0; i < list->chunk_count && status == SVO_OK; ++i) {
        f->params.fragment_count = (cl_uint)list->chunks[i].needed;
        status = gather(f, SVO_I_ENTRY_GATHER, i, gl_build->cursors[i], f->sums[0], f->params.fragment_count);
    }
    return status == SVO_OK ? svo_i_compute_stage_end(gl_build->compute, gl_build->build, SVO_STAGE_FILTER) : status;
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

/* From the level above end up to the root. */
static svo_status filter_levels(filterer *f, uint32_t end)
{
    svo_i_compute_stage_begin(f->gl_build->compute);
    svo_status status = SVO_OK;
    for (uint32_t level = end; level-- > 0 && status == SVO_OK;) {
        status = filter_level(f, level);
    }
    return status == SVO_OK ? svo_i_compute_stage_end(f->gl_build->compute, f->gl_build->build, SVO_STAGE_FILTER)
                            : status;
}

/* Takes back what a walk that failed has written by atomicOr. */
static void clear_payload(filterer *f)
{
    static const svo_tree_buffer arrays[] = {SVO_TREE_NORMALS, SVO_TREE_FILLS};
    for (unsigned i = 0; i < 2; ++i) {
        if (f->gl_build->arrays[arrays[i]] != 0) {
            svo_i_compute_fill_zero(f->gl_build->compute, f->gl_build->arrays[arrays[i]]);
        }
    }
}

/* The levels above the leaves' sums; or above those of their parents. */
static svo_status run_levels(filterer *f)
{
    const uint32_t depth = f->gl_build->build->tree->info.depth;
    bool walked = false;
    svo_status status = SVO_OK;
    if (f->gl_build->build->list.chunk_count == 1) {
        status = link_leaves(f);
        if (status == SVO_OK) {
            status = walk_leaves(f, &walked);
        }
        if (status == SVO_OK && walked) {
            return filter_levels(f, depth - 1);
        }
        clear_payload(f);
    }
    if (status == SVO_OK) {
        status = add_leaves(f);
    }
    return status == SVO_OK ? filter_levels(f, depth) : status;
}

static svo_status run(filterer *f)
{
    svo_status status = allocate_payload(f);
    if (status != SVO_OK || f->params.leaf_count == 0) { /* without leaves, a root whose payload is zero */
        return status;
    }
    status = allocate_sums(f);
    return status == SVO_OK ? run_levels(f) : status;
}

svo_status svo_i_gl_filter(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface)
{
    filterer f = {.gl_build = gl_build, .surface = surface, .params = svo_i_payload_params(gl_build->build)};
    f.node_bytes = UINT64_C(8) * (1u + (needs(&f, SVO_NEED_COLOR) ? 4u : 0u) + (needs(&f, SVO_NEED_NORMAL) ? 3u : 0u));
    const svo_status status = run(&f);
    svo_i_compute_free(gl_build->compute, &f.heads);
    svo_i_compute_free(gl_build->compute, &f.links);
    svo_i_compute_free(gl_build->compute, &f.sums[0]);
    svo_i_compute_free(gl_build->compute, &f.sums[1]);
    return status;
}
