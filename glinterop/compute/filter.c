/* SPDX-License-Identifier: MIT */
/*
 * Runs shaders/link.comp and shaders/filter.comp: links the leaves' fragments and sums up their contributions, then
 * sums up children level by level and writes every node's color, normal and fill.
 *
 * A list of one chunk, the usual case, is linked and gathered straight into the sums of the deepest inner level. With
 * several chunks, or a voxel with more triangles than an invocation is given (shaders/compute.glsl), every
 * fragment is added to the sums of its leaf instead.
 */
#include "compute/filter.h"

#include "commands/commands.h"
#include "compute/buffer.h"
#include "core/message.h"
#include "stages/inputs.h"

typedef struct filterer {
    svo_i_gl_build *gl_build;
    const svo_i_gl_surface *surface;
    GLuint heads, links;
    GLuint sums[2]; /* of levels at an even and at an odd distance from the leaves */
    uint64_t node_bytes; /* bytes of a node's sums */
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
    const uint64_t nodes = f->gl_build->build->tree->info.node_count;
    for (unsigned i = 0; i < 3; ++i) {
        if (needs(f, bits[i])) {
            SVO_I_TRY(svo_i_compute_alloc_zero(f->gl_build->compute, svo_tree_buffer_name(arrays[i]),
                                               nodes * node_bytes[i], &f->gl_build->arrays[arrays[i]]));
        }
    }
    return SVO_OK;
}

/* Sums for the parents of leaves and for their parents. */
static svo_status allocate_sums(filterer *f)
{
    const svo_tree_info *info = &f->gl_build->build->tree->info;
    const uint64_t parents = info->inner_count - info->level_begin[info->depth - 1];
    const uint64_t above =
        info->depth > 1 ? info->level_begin[info->depth - 1] - info->level_begin[info->depth - 2] : 1;
    SVO_I_TRY(svo_i_compute_alloc(f->gl_build->compute, "sums", above * f->node_bytes, &f->sums[0]));
    return svo_i_compute_alloc(f->gl_build->compute, "sums", parents * f->node_bytes, &f->sums[1]);
}

/* Links the fragments of each leaf of the only chunk. */
static svo_status link_leaves(filterer *f)
{
    svo_i_compute *compute = f->gl_build->compute;
    f->params.fragment_count = (cl_uint)f->gl_build->build->fragment_count;
    svo_i_compute_stage_begin(compute);
    SVO_I_TRY(svo_i_compute_alloc_zero(compute, "heads", f->params.leaf_count * UINT64_C(4), &f->heads));
    SVO_I_TRY(svo_i_compute_alloc(compute, "links", f->params.fragment_count * UINT64_C(4), &f->links));
    const svo_i_launch launch = {.entry = SVO_I_ENTRY_LINK,
                                 .buffers = {f->gl_build->cursors[0], f->heads, f->links},
                                 .params = &f->params,
                                 .items = f->params.fragment_count};
    SVO_I_TRY(svo_i_compute_launch(compute, &launch));
    return svo_i_compute_stage_end(compute, f->gl_build->build, SVO_STAGE_LINK);
}

/* Adds the contributions of a chunk's fragments to sums, item by item. links: links or cursors, by entry point. */
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

/* Computes the leaves' payload and the sums of their parents by walking the linked lists. *walked is false when a list
   is too long for this context; the results are then invalid. */
static svo_status walk_leaves(filterer *f, bool *walked)
{
    const svo_tree_info *info = &f->gl_build->build->tree->info;
    svo_i_compute *compute = f->gl_build->compute;
    bool exhausted = false;
    svo_i_params_of_level(&f->params, info, info->depth - 1);
    svo_i_compute_stage_begin(compute);
    SVO_I_TRY(gather(f, SVO_I_ENTRY_GATHER_LEVEL, 0, f->links, f->sums[1], f->params.level_count));
    SVO_I_TRY(svo_i_compute_stage_end(compute, f->gl_build->build, SVO_STAGE_FILTER));
    SVO_I_TRY(svo_i_compute_exhausted(compute, &exhausted));
    *walked = !exhausted;
    return SVO_OK;
}

/* Compiles before the stage that launches it. Rarely needed, so not compiled by prepare. */
static svo_status compile_gather(filterer *f)
{
    svo_i_compute_program *program = NULL;
    const double start_ms = svo_i_now_ms();
    const svo_status status = svo_i_compute_program_get(f->gl_build->compute, SVO_I_ENTRY_GATHER, &program);
    svo_i_report_add(f->gl_build->build->commands.report, SVO_STAGE_COMPILE, svo_i_now_ms() - start_ms, "wall");
    return status;
}

/* Adds every fragment to its leaf's sums: for any number of chunks, and of triangles per voxel. */
static svo_status add_leaves(filterer *f)
{
    svo_i_gl_build *gl_build = f->gl_build;
    const svo_i_fragment_list *list = &gl_build->build->list;
    svo_i_compute_free(gl_build->compute, &f->sums[0]);
    const uint64_t bytes = f->params.leaf_count * f->node_bytes;
    SVO_I_TRY(compile_gather(f));
    svo_i_compute_stage_begin(gl_build->compute);
    SVO_I_TRY(svo_i_compute_alloc_zero(gl_build->compute, "sums", bytes, &f->sums[0]));
    for (uint32_t i = 0; i < list->chunk_count; ++i) {
        f->params.fragment_count = (cl_uint)list->chunks[i].needed;
        SVO_I_TRY(gather(f, SVO_I_ENTRY_GATHER, i, gl_build->cursors[i], f->sums[0], f->params.fragment_count));
    }
    return svo_i_compute_stage_end(gl_build->compute, gl_build->build, SVO_STAGE_FILTER);
}

/* Sums up the children of each node of a level, and writes the nodes' payload. */
static svo_status filter_level(filterer *f, uint32_t level)
{
    svo_i_gl_build *gl_build = f->gl_build;
    const GLuint *arrays = gl_build->arrays;
    const unsigned odd = (gl_build->build->tree->info.depth - level) % 2;
    svo_i_params_of_level(&f->params, &gl_build->build->tree->info, level);
    const svo_i_launch launch = {.entry = SVO_I_ENTRY_FILTER,
                                 .buffers = {arrays[SVO_TREE_CHILD_MASK], arrays[SVO_TREE_FIRST_CHILD],
                                             f->sums[1 - odd], f->sums[odd], arrays[SVO_TREE_COLORS],
                                             arrays[SVO_TREE_NORMALS], arrays[SVO_TREE_FILLS]},
                                 .params = &f->params,
                                 .items = f->params.level_count};
    return svo_i_compute_launch(gl_build->compute, &launch);
}

/* Filters the levels above end, up to the root. */
static svo_status filter_levels(filterer *f, uint32_t end)
{
    svo_i_compute_stage_begin(f->gl_build->compute);
    for (uint32_t level = end; level-- > 0;) {
        SVO_I_TRY(filter_level(f, level));
    }
    return svo_i_compute_stage_end(f->gl_build->compute, f->gl_build->build, SVO_STAGE_FILTER);
}

/* Clears what a failed walk has written by atomicOr. */
static void clear_payload(filterer *f)
{
    static const svo_tree_buffer arrays[] = {SVO_TREE_NORMALS, SVO_TREE_FILLS};
    for (unsigned i = 0; i < 2; ++i) {
        if (f->gl_build->arrays[arrays[i]] != 0) {
            svo_i_compute_fill_zero(f->gl_build->compute, f->gl_build->arrays[arrays[i]]);
        }
    }
}

/* Filters all levels above the deepest sums: those of the leaves' parents, or of the leaves. */
static svo_status run_levels(filterer *f)
{
    const uint32_t depth = f->gl_build->build->tree->info.depth;
    bool walked = false;
    if (f->gl_build->build->list.chunk_count == 1) {
        SVO_I_TRY(link_leaves(f));
        SVO_I_TRY(walk_leaves(f, &walked));
        if (walked) {
            return filter_levels(f, depth - 1);
        }
        clear_payload(f);
    }
    SVO_I_TRY(add_leaves(f));
    return filter_levels(f, depth);
}

static svo_status run(filterer *f)
{
    SVO_I_TRY(allocate_payload(f));
    if (f->params.leaf_count == 0) {
        return SVO_OK; /* a root without leaves, whose payload is zero */
    }
    SVO_I_TRY(allocate_sums(f));
    return run_levels(f);
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
