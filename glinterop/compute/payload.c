/* SPDX-License-Identifier: MIT */
/*
 * The payload of a tree by compute shaders: the surface, and shaders/material.comp, area.comp, link.comp and
 * filter.comp.
 */
#include "compute/payload.h"

#include "commands/commands.h"
#include "compute/compute.h"
#include "core/message.h"
#include "stages/inputs.h"
#include "stages/material.h"

/* ---- the surface ---- */

/*
 * Uploads the mesh's attributes to storage blocks, for the stages below;
 * shaders/attribute.glsl reads them. Uploads only what the plan has. All vertex attributes share one block, since a
 * shader may have few.
 */

/* The mesh's attributes in storage blocks. 0 for an attribute that the plan does not have. */
typedef struct gl_surface {
    GLuint vertices, indices, records, attributes, materials, texels;
} gl_surface;

/* Uploads an array if the plan has it. data: NULL allowed. */
static svo_status upload(svo_i_gl_build *gl_build, const char *name, const void *data, uint64_t bytes, GLuint *out)
{
    return data != NULL ? svo_i_compute_upload(gl_build->compute, name, data, bytes, out) : SVO_OK;
}

/* Appends an attribute at *end, and advances *end. */
static void put_attribute(svo_i_gl_build *gl_build, const void *data, uint64_t bytes, uint64_t *end)
{
    const svo_i_gl_functions *gl = gl_build->compute->gl;
    if (data != NULL && bytes > 0) {
        gl->BufferSubData(GL_COPY_READ_BUFFER, (GLintptr)*end, (GLsizeiptr)bytes, data);
        *end += bytes;
    }
}

/* Colors, then normals, then texture coordinates. */
static svo_status upload_attributes(svo_i_gl_build *gl_build, GLuint *out)
{
    const svo_plan *plan = gl_build->build->commands.plan;
    const uint64_t vertices = plan->vertex_count;
    const uint64_t bytes = vertices * ((plan->colors != NULL ? 4u : 0u) + (plan->normals != NULL ? 8u : 0u) +
                                       (plan->uvs != NULL ? 8u : 0u));
    if (bytes == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_compute_alloc(gl_build->compute, "vertex_attributes", bytes, out));
    uint64_t end = 0;
    gl_build->compute->gl->BindBuffer(GL_COPY_READ_BUFFER, *out);
    put_attribute(gl_build, plan->colors, vertices * 4, &end);
    put_attribute(gl_build, plan->normals, vertices * 8, &end);
    put_attribute(gl_build, plan->uvs, vertices * 8, &end);
    gl_build->compute->gl->BindBuffer(GL_COPY_READ_BUFFER, 0);
    return SVO_OK;
}

/* All vertices, then their remainders. */
static svo_status upload_vertices(svo_i_gl_build *gl_build, GLuint *out)
{
    const svo_plan *plan = gl_build->build->commands.plan;
    const uint64_t vertices = plan->vertex_count;
    uint64_t end = 0;
    SVO_I_TRY(svo_i_compute_alloc(gl_build->compute, "vertices", vertices * 20, out));
    gl_build->compute->gl->BindBuffer(GL_COPY_READ_BUFFER, *out);
    put_attribute(gl_build, plan->vertices, vertices * 12, &end);
    put_attribute(gl_build, plan->remainders, vertices * 8, &end);
    gl_build->compute->gl->BindBuffer(GL_COPY_READ_BUFFER, 0);
    return SVO_OK;
}

/* The arrays that locate a triangle in a voxel. Uniform weights alone do not need vertices. */
static svo_status upload_triangles(svo_i_gl_build *gl_build, gl_surface *out)
{
    const svo_plan *plan = gl_build->build->commands.plan;
    const uint64_t triangles = plan->triangle_count;
    if (plan->work.positions) {
        SVO_I_TRY(upload_vertices(gl_build, &out->vertices));
    }
    SVO_I_TRY(upload(gl_build, "indices", plan->indices, triangles * 12, &out->indices));
    return upload(gl_build, "records", plan->records, triangles * sizeof(svo_triangle_record), &out->records);
}

/* Call free_surface after a failure too. */
static svo_status upload_surface(svo_i_gl_build *gl_build, gl_surface *out)
{
    const svo_plan *plan = gl_build->build->commands.plan;
    svo_i_compute_stage_begin(gl_build->compute);
    const uint64_t material_bytes = plan->material_count * sizeof(svo_material_record);
    SVO_I_TRY(upload_triangles(gl_build, out));
    SVO_I_TRY(upload_attributes(gl_build, &out->attributes));
    SVO_I_TRY(upload(gl_build, "material_records", plan->materials, material_bytes, &out->materials));
    SVO_I_TRY(upload(gl_build, "texels", plan->texels, plan->texel_count * 4, &out->texels));
    return svo_i_compute_stage_end(gl_build->compute, gl_build->build, SVO_STAGE_TRANSFER);
}

static void free_surface(svo_i_gl_build *gl_build, gl_surface *surface)
{
    GLuint *buffers[] = {&surface->vertices,   &surface->indices,   &surface->records,
                         &surface->attributes, &surface->materials, &surface->texels};
    for (unsigned i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        svo_i_compute_free(gl_build->compute, buffers[i]);
    }
}

/* ---- materials ---- */

/* The entries of a level's nodes, and where those of each node begin. */
typedef struct level_entries {
    GLuint begins, counts, entries;
} level_entries;

typedef struct sorter {
    svo_i_gl_build *gl_build;
    const gl_surface *surface;
    GLuint list_begin, materials;
    level_entries levels[2]; /* of levels at an even and at an odd distance from the leaves */
    svo_filter_params params;
} sorter;

static svo_status allocate(sorter *s)
{
    svo_i_compute *compute = s->gl_build->compute;
    const svo_tree_info *info = &s->gl_build->build->tree->info;
    const uint64_t parents = info->inner_count - info->level_begin[info->depth - 1];
    const uint64_t grandparents =
        info->depth > 1 ? info->level_begin[info->depth - 1] - info->level_begin[info->depth - 2] : 1;
    const uint64_t fragments = s->gl_build->build->fragment_count;
    GLuint *materials = &s->gl_build->arrays[SVO_TREE_MATERIALS];
    SVO_I_TRY(svo_i_compute_alloc(compute, "entry_counts", info->leaf_count * 4, &s->levels[0].counts));
    SVO_I_TRY(svo_i_compute_alloc(compute, "entry_begins", grandparents * 4, &s->levels[0].begins));
    SVO_I_TRY(svo_i_compute_alloc(compute, "entry_counts", parents * 4, &s->levels[1].counts));
    SVO_I_TRY(svo_i_compute_alloc(compute, "entry_begins", parents * 4, &s->levels[1].begins));
    for (unsigned odd = 0; odd < 2; ++odd) {
        SVO_I_TRY(svo_i_compute_alloc(compute, "entries", fragments * 8, &s->levels[odd].entries));
    }
    SVO_I_TRY(svo_i_compute_alloc(compute, "materials", info->node_count * 2, materials));
    s->materials = *materials;
    return SVO_OK;
}

static void release(sorter *s)
{
    for (unsigned odd = 0; odd < 2; ++odd) {
        svo_i_compute_free(s->gl_build->compute, &s->levels[odd].counts);
        svo_i_compute_free(s->gl_build->compute, &s->levels[odd].begins);
        svo_i_compute_free(s->gl_build->compute, &s->levels[odd].entries);
    }
}

static svo_status scatter(sorter *s)
{
    svo_i_gl_build *gl_build = s->gl_build;
    const gl_surface *surface = s->surface;
    svo_i_compute_fill_zero(gl_build->compute, s->levels[0].counts);
    svo_i_compute_fill_zero(gl_build->compute, s->materials);
    for (uint32_t i = 0; i < gl_build->build->list.chunk_count; ++i) {
        s->params.fragment_count = (cl_uint)gl_build->build->list.chunks[i].needed;
        const svo_i_launch launch = {.entry = SVO_I_ENTRY_MATERIAL_SCATTER,
                                     .buffers = {svo_i_gl_chunk(gl_build, i), gl_build->cursors[i], surface->vertices,
                                                 surface->indices, surface->records, s->list_begin, s->levels[0].counts,
                                                 s->levels[0].entries},
                                     .params = &s->params,
                                     .vertex_count = gl_build->build->commands.plan->vertex_count,
                                     .items = s->params.fragment_count};
        SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &launch));
    }
    return SVO_OK;
}

static svo_status launch_leaves(sorter *s, svo_i_entry entry, const svo_filter_params *params, uint64_t items)
{
    const svo_i_launch launch = {
        .entry = entry,
        .buffers = {s->list_begin, s->levels[0].counts, s->levels[0].entries, s->levels[1].entries, s->materials},
        .params = params,
        .items = items};
    return svo_i_compute_launch(s->gl_build->compute, &launch);
}

/* Sorts leaves of any length in an even number of passes, so that the result ends in the first array. */
static svo_status sort_long_leaves(sorter *s)
{
    const uint64_t fragments = s->gl_build->build->fragment_count;
    svo_filter_params params = s->params;
    params.fragment_count = (cl_uint)fragments;
    SVO_I_TRY(scatter(s));
    for (params.level = 0; fragments >> params.level != 0 || params.level % 2 != 0; ++params.level) {
        SVO_I_TRY(launch_leaves(s, SVO_I_ENTRY_MATERIAL_PASS, &params, fragments));
    }
    params.digit_passes = 1;
    return launch_leaves(s, SVO_I_ENTRY_MATERIAL_LEAVES, &params, params.leaf_count);
}

/* One invocation sorts a leaf, unless a leaf has more triangles than it is given (shaders/compute.glsl). */
static svo_status sort_leaves(sorter *s)
{
    bool exhausted = false;
    SVO_I_TRY(launch_leaves(s, SVO_I_ENTRY_MATERIAL_LEAVES, &s->params, s->params.leaf_count));
    SVO_I_TRY(svo_i_compute_exhausted(s->gl_build->compute, &exhausted));
    return exhausted ? sort_long_leaves(s) : SVO_OK;
}

static svo_status merge_level(sorter *s, uint32_t level)
{
    svo_i_gl_build *gl_build = s->gl_build;
    const svo_tree_info *info = &gl_build->build->tree->info;
    const unsigned odd = (info->depth - level) % 2;
    const level_entries *children = &s->levels[1 - odd];
    const level_entries *nodes = &s->levels[odd];
    const GLuint child_begins = level + 1 == info->depth ? s->list_begin : children->begins;
    svo_i_params_of_level(&s->params, info, level);
    const svo_i_launch launch = {
        .entry = SVO_I_ENTRY_MATERIAL_MERGE,
        .buffers = {gl_build->arrays[SVO_TREE_CHILD_MASK], gl_build->arrays[SVO_TREE_FIRST_CHILD], child_begins,
                    children->counts, children->entries, nodes->begins, nodes->counts, nodes->entries, s->materials},
        .params = &s->params,
        .items = s->params.level_count};
    return svo_i_compute_launch(gl_build->compute, &launch);
}

static svo_status sort_materials(sorter *s)
{
    SVO_I_TRY(allocate(s));
    SVO_I_TRY(scatter(s));
    SVO_I_TRY(sort_leaves(s));
    for (uint32_t level = s->gl_build->build->tree->info.depth; level-- > 0;) {
        SVO_I_TRY(merge_level(s, level));
    }
    return SVO_OK;
}

/* Needs list_begin, at least one leaf, and materials that are not constant. */
static svo_status make_materials(svo_i_gl_build *gl_build, const gl_surface *surface)
{
    sorter s = {.gl_build = gl_build,
                .surface = surface,
                .list_begin = gl_build->arrays[SVO_TREE_LIST_BEGIN],
                .params = svo_i_payload_params(gl_build->build)};
    svo_status status = SVO_OK;
    svo_i_compute_stage_begin(gl_build->compute);
    SVO_I_TRY_CLEANUP(sort_materials(&s));
    SVO_I_TRY_CLEANUP(svo_i_compute_stage_end(gl_build->compute, gl_build->build, SVO_STAGE_FILTER));
    SVO_I_TRY_CLEANUP(svo_i_gl_check_loops(gl_build, "sorting its materials"));
cleanup:
    release(&s);
    return status;
}

/* ---- projected areas ---- */

/*
 * Runs shaders/area.comp: every fragment adds its areas to the sums of its leaf, for any number of chunks and of
 * triangles per voxel.
 */

/* Adds the areas of all fragments to the leaves' sums. */
static svo_status add_fragments(svo_i_gl_build *gl_build, const gl_surface *surface, svo_filter_params params,
                                GLuint sums)
{
    const svo_i_fragment_list *list = &gl_build->build->list;
    for (uint32_t i = 0; i < list->chunk_count; ++i) {
        params.fragment_count = (cl_uint)list->chunks[i].needed;
        const svo_i_launch launch = {.entry = SVO_I_ENTRY_AREA,
                                     .buffers = {[0] = svo_i_gl_chunk(gl_build, i),
                                                 [1] = gl_build->cursors[i],
                                                 [2] = surface->vertices,
                                                 [3] = surface->indices,
                                                 [4] = surface->records,
                                                 [9] = sums},
                                     .params = &params,
                                     .vertex_count = gl_build->build->commands.plan->vertex_count,
                                     .items = params.fragment_count};
        SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &launch));
    }
    return SVO_OK;
}

static svo_status sum_areas(svo_i_gl_build *gl_build, const gl_surface *surface, GLuint *sums)
{
    svo_i_compute *compute = gl_build->compute;
    GLuint *areas = &gl_build->arrays[SVO_TREE_AREAS];
    const svo_filter_params params = svo_i_payload_params(gl_build->build);
    const uint64_t leaves = params.leaf_count;
    svo_i_compute_stage_begin(compute);
    SVO_I_TRY(svo_i_compute_alloc(compute, "areas", leaves * 12, areas));
    SVO_I_TRY(svo_i_compute_alloc_zero(compute, "area_sums", leaves * 48, sums));
    SVO_I_TRY(add_fragments(gl_build, surface, params, *sums));
    const svo_i_launch round = {
        .entry = SVO_I_ENTRY_ROUND_AREAS, .buffers = {[9] = *sums, [10] = *areas}, .params = &params, .items = leaves};
    SVO_I_TRY(svo_i_compute_launch(compute, &round));
    return svo_i_compute_stage_end(compute, gl_build->build, SVO_STAGE_FILTER);
}

static svo_status make_areas(svo_i_gl_build *gl_build, const gl_surface *surface)
{
    GLuint sums = 0;
    const svo_status status = sum_areas(gl_build, surface, &sums);
    svo_i_compute_free(gl_build->compute, &sums);
    return status;
}

/* ---- colors, normals and fills ---- */

/*
 * Links the leaves' fragments and sums up their contributions, then sums up children level by level and writes every
 * node's color, normal and fill.
 *
 * A list of one chunk, the usual case, is linked and gathered straight into the sums of the deepest inner level. With
 * several chunks, or a voxel with more triangles than an invocation is given (shaders/compute.glsl), every fragment is
 * added to the sums of its leaf instead.
 */

typedef struct filterer {
    svo_i_gl_build *gl_build;
    const gl_surface *surface;
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
            SVO_I_TRY(svo_i_compute_alloc_zero(f->gl_build->compute, svo_name(SVO_NAME_TREE_BUFFER, arrays[i]),
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
    const gl_surface *surface = f->surface;
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

static svo_status sum_colors(filterer *f)
{
    SVO_I_TRY(allocate_payload(f));
    if (f->params.leaf_count == 0) {
        return SVO_OK; /* a root without leaves, whose payload is zero */
    }
    SVO_I_TRY(allocate_sums(f));
    return run_levels(f);
}

static svo_status make_colors(svo_i_gl_build *gl_build, const gl_surface *surface)
{
    filterer f = {.gl_build = gl_build, .surface = surface, .params = svo_i_payload_params(gl_build->build)};
    f.node_bytes = UINT64_C(8) * (1u + (needs(&f, SVO_NEED_COLOR) ? 4u : 0u) + (needs(&f, SVO_NEED_NORMAL) ? 3u : 0u));
    const svo_status status = sum_colors(&f);
    svo_i_compute_free(gl_build->compute, &f.heads);
    svo_i_compute_free(gl_build->compute, &f.links);
    svo_i_compute_free(gl_build->compute, &f.sums[0]);
    svo_i_compute_free(gl_build->compute, &f.sums[1]);
    return status;
}

/* ---- all of it ---- */

/* The materials of the nodes. Frees ranges of entries that nothing else needs. */
static svo_status fill_materials(svo_i_gl_build *gl_build, const gl_surface *surface)
{
    svo_i_build *build = gl_build->build;
    const svo_i_work *work = &build->commands.plan->work;
    if ((work->made & SVO_NEED_MATERIAL) != 0) {
        /* A root without leaves needs no shader: OpenCL fills its payload. */
        SVO_I_TRY(build->tree->info.leaf_count > 0 ? make_materials(gl_build, surface) : svo_i_material(build));
    }
    if (!work->lists) {
        svo_i_compute_free(gl_build->compute, &gl_build->arrays[SVO_TREE_LIST_BEGIN]);
    }
    return SVO_OK;
}

svo_status svo_i_gl_payload(svo_i_gl_build *gl_build)
{
    const uint32_t made = gl_build->build->commands.plan->work.made;
    svo_status status = SVO_OK;
    gl_surface surface = {0};
    SVO_I_TRY_CLEANUP(upload_surface(gl_build, &surface));
    SVO_I_TRY_CLEANUP(fill_materials(gl_build, &surface));
    if ((made & SVO_I_NEED_FILTER) != 0) {
        SVO_I_TRY_CLEANUP(make_colors(gl_build, &surface));
    }
    if ((made & SVO_NEED_PROJECTED_AREA) != 0) {
        SVO_I_TRY_CLEANUP(make_areas(gl_build, &surface));
    }
cleanup:
    free_surface(gl_build, &surface);
    return status;
}
