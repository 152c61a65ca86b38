/* SPDX-License-Identifier: MIT */
/*
 * Builds the tree by compute shaders from a fragment list that stays in OpenGL. svo_build makes the list and calls
 * svo_i_gl_make_tree, which runs the stages in the same order as the OpenCL builder and copies the arrays to OpenCL.
 */
#include "compute/build.h"

#include <stddef.h>
#include <string.h>

#include "commands/commands.h"
#include "compute/compute.h"
#include "compute/payload.h"
#include "compute/surface.h"
#include "compute/windows.h"
#include "core/message.h"
#include "plan/accounts.h"
#include "plan/estimate.h"
#include "stages/inputs.h"

/* ---- nodes ---- */

/*
 * Runs shaders/subdivide.comp and the mask scans of shaders/scan.comp for all levels, without reading anything back
 * between them. Only the device knows the size of a level, so the scans are launched indirectly. The host reads the
 * counts once, at the end.
 */

typedef struct subdivider {
    svo_i_gl_build *gl_build;
    GLuint masks, first_child;
    GLuint launches; /* groups of each level's scans, three words per level */
} subdivider;

/* Starts with a root without children: only the root's scans have work. */
static svo_status begin(subdivider *s)
{
    svo_i_gl_build *gl_build = s->gl_build;
    svo_build_state state;
    uint32_t launches[3 * SVO_LEVELS_MAX];
    memset(&state, 0, sizeof state);
    state.triangle_count = gl_build->build->commands.plan->triangle_count;
    for (unsigned level = 0; level < SVO_LEVELS_MAX; ++level) {
        state.level_begin[level] = level > 0 ? 1 : 0;
        launches[(size_t)3 * level] = level > 0 ? 0 : 1;
        launches[(size_t)3 * level + 1] = 1;
        launches[(size_t)3 * level + 2] = 1;
    }
    svo_i_compute_free(gl_build->compute, &gl_build->state);
    svo_i_compute *compute = gl_build->compute;
    SVO_I_TRY(svo_i_compute_upload(compute, "state", &state, sizeof state, &gl_build->state));
    SVO_I_TRY(svo_i_compute_upload(compute, "launches", launches, sizeof launches, &s->launches));
    if (gl_build->partials == 0) {
        const uint64_t bytes = SVO_SCAN_GROUPS * sizeof(GLuint);
        SVO_I_TRY(svo_i_compute_alloc(compute, "partials", bytes, &gl_build->partials));
    }
    svo_i_compute_fill_zero(compute, s->masks);
    return SVO_OK;
}

static svo_status mark_root(subdivider *s, svo_subdivide_params params)
{
    svo_i_gl_build *gl_build = s->gl_build;
    for (uint32_t i = 0; i < gl_build->build->list.chunk_count; ++i) {
        params.fragment_count = (cl_uint)gl_build->build->list.chunks[i].needed;
        const svo_i_launch launch = {.entry = SVO_I_ENTRY_MARK,
                                     .buffers = {svo_i_gl_chunk(gl_build, i), s->masks, gl_build->state},
                                     .params = &params,
                                     .items = params.fragment_count};
        SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &launch));
    }
    return SVO_OK;
}

/* The nodes of a level; all nodes that there is room for, where a launch can bind the first children of these.
   Otherwise the host asks. */
static svo_status find_level(const subdivider *s, uint32_t level, svo_i_window *out)
{
    svo_i_compute *compute = s->gl_build->compute;
    const uint64_t capacity = s->gl_build->build->inner_capacity;
    uint32_t begins[2] = {0, (uint32_t)capacity};
    if (capacity * 4 > svo_i_compute_range_max(compute)) {
        const size_t offset = offsetof(svo_build_state, level_begin) + level * sizeof begins[0];
        SVO_I_TRY(svo_i_compute_read_at(compute, s->gl_build->state, offset, begins, sizeof begins));
    }
    *out = (svo_i_window){.begin = begins[0], .end = begins[1]};
    return SVO_OK;
}

/* The first of the nodes of a level whose first children a launch can bind. */
static svo_i_window first_part(const subdivider *s, const svo_i_window *left)
{
    const uint64_t most = svo_i_compute_range_max(s->gl_build->compute) / 4;
    const uint32_t count = left->end - left->begin;
    return (svo_i_window){.begin = left->begin, .end = left->begin + (count < most ? count : (uint32_t)most)};
}

/* Writes first_child of the level's nodes. */
static svo_status add_level(subdivider *s, const svo_subdivide_params *params)
{
    svo_i_window left = {0};
    SVO_I_TRY(find_level(s, params->level, &left));
    while (left.begin < left.end) {
        const svo_i_window part = first_part(s, &left);
        const svo_i_launch launch = {.entry = SVO_I_ENTRY_SCAN_MASKS_ADD,
                                     .buffers = {s->masks, s->gl_build->partials, s->first_child, s->gl_build->state},
                                     .ranges = {[2] = svo_i_range_of(part.begin, part.end, 4)},
                                     .params = params,
                                     .window_begin = part.begin,
                                     .window_count = part.end - part.begin,
                                     .indirect = s->launches,
                                     .indirect_word = 3 * params->level};
        SVO_I_TRY(svo_i_compute_launch(s->gl_build->compute, &launch));
        left.begin = part.end;
    }
    return SVO_OK;
}

/* Computes first_child of the level's nodes, and where the level after the next begins. */
static svo_status scan_level(subdivider *s, svo_subdivide_params params)
{
    svo_i_compute *compute = s->gl_build->compute;
    const GLuint partials = s->gl_build->partials;
    const GLuint state = s->gl_build->state;
    const svo_i_launch launches[] = {{.entry = SVO_I_ENTRY_SCAN_MASKS_REDUCE,
                                      .buffers = {s->masks, partials, state},
                                      .params = &params,
                                      .indirect = s->launches,
                                      .indirect_word = 3 * params.level},
                                     {.entry = SVO_I_ENTRY_SCAN_MASKS_PARTIALS,
                                      .buffers = {partials, state, s->launches},
                                      .params = &params,
                                      .items = SVO_GROUP_ITEMS}};
    for (unsigned i = 0; i < 2; ++i) {
        SVO_I_TRY(svo_i_compute_launch(compute, &launches[i]));
    }
    return add_level(s, &params);
}

static svo_status descend_part(subdivider *s, svo_subdivide_params params, const svo_i_window *part)
{
    svo_i_gl_build *gl_build = s->gl_build;
    for (uint32_t i = 0; i < gl_build->build->list.chunk_count; ++i) {
        params.fragment_count = (cl_uint)gl_build->build->list.chunks[i].needed;
        const svo_i_launch launch = {
            .entry = SVO_I_ENTRY_DESCEND,
            .buffers = {svo_i_gl_chunk(gl_build, i), gl_build->cursors[i], s->masks, s->first_child, gl_build->state},
            .ranges = {[3] = svo_i_range_of(part->begin, part->end, 4)},
            .params = &params,
            .window_begin = part->begin,
            .window_count = part->end - part->begin,
            .items = params.fragment_count};
        SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &launch));
    }
    return SVO_OK;
}

static svo_status descend(subdivider *s, svo_subdivide_params params)
{
    svo_i_window left = {0};
    SVO_I_TRY(find_level(s, params.level, &left));
    while (left.begin < left.end) {
        const svo_i_window part = first_part(s, &left);
        SVO_I_TRY(descend_part(s, params, &part));
        left.begin = part.end;
    }
    return SVO_OK;
}

static svo_status run_levels(subdivider *s)
{
    const svo_i_build *build = s->gl_build->build;
    svo_subdivide_params params = {.depth = build->commands.plan->info.depth,
                                   .inner_capacity = (cl_uint)build->inner_capacity};
    SVO_I_TRY(mark_root(s, params));
    for (params.level = 0; params.level < params.depth; ++params.level) {
        SVO_I_TRY(scan_level(s, params));
        SVO_I_TRY(descend(s, params));
    }
    return SVO_OK;
}

/* Creates masks, first children and level counts, and moves the cursors to the leaves. *fits is false when the inner
   nodes exceed the build's inner_capacity. */
static svo_status subdivide(svo_i_gl_build *gl_build, bool *fits)
{
    subdivider s = {.gl_build = gl_build,
                    .masks = gl_build->arrays[SVO_TREE_CHILD_MASK],
                    .first_child = gl_build->arrays[SVO_TREE_FIRST_CHILD]};
    svo_build_state state;
    svo_status status = SVO_OK;
    svo_i_compute_stage_begin(gl_build->compute);
    SVO_I_TRY_CLEANUP(begin(&s));
    SVO_I_TRY_CLEANUP(run_levels(&s));
    SVO_I_TRY_CLEANUP(svo_i_compute_stage_end(gl_build->compute, gl_build->build, SVO_STAGE_SUBDIVIDE));
    SVO_I_TRY_CLEANUP(svo_i_compute_read(gl_build->compute, gl_build->state, &state, sizeof state));
    SVO_I_TRY_CLEANUP(svo_i_build_take_state(gl_build->build, &state, fits));
cleanup:
    svo_i_compute_free(gl_build->compute, &s.launches);
    return status;
}

/* ---- lists of leaves ---- */

/*
 * Runs shaders/pack.comp and the list scans of shaders/scan.comp: computes where each leaf's range of entries begins
 * and, for requests that read them, the sorted lists of the leaves.
 */

typedef struct packer {
    svo_i_gl_build *gl_build;
    GLuint counts, spare, long_leaves;
    GLuint launches; /* groups that sort long lists */
    svo_filter_params params;
} packer;

static svo_status allocate_lists(packer *p)
{
    svo_i_gl_build *gl_build = p->gl_build;
    const uint64_t fragments = gl_build->build->fragment_count;
    gl_build->build->tree->info.list_count = fragments;
    const uint64_t long_leaves = fragments / (SVO_SHORT_LIST_MAX + 1) + 1;
    svo_i_compute *compute = gl_build->compute;
    SVO_I_TRY(svo_i_compute_alloc_array(compute, "list", fragments * 4, &gl_build->arrays[SVO_TREE_LIST]));
    SVO_I_TRY(svo_i_compute_alloc_array(compute, "list_spare", fragments * 4, &p->spare));
    SVO_I_TRY(svo_i_compute_alloc(compute, "long_leaves", long_leaves * 4, &p->long_leaves));
    return svo_i_compute_alloc(compute, "launches", 12, &p->launches);
}

/* Adds the fragments of leaves of a window to their lengths. */
static svo_status count_window(packer *p, uint32_t begin, uint32_t count)
{
    svo_i_gl_build *gl_build = p->gl_build;
    for (uint32_t i = 0; i < gl_build->build->list.chunk_count; ++i) {
        p->params.fragment_count = (cl_uint)gl_build->build->list.chunks[i].needed;
        const svo_i_launch launch = {.entry = SVO_I_ENTRY_COUNT,
                                     .buffers = {gl_build->cursors[i], p->counts},
                                     .ranges = {[1] = svo_i_range_of(begin, (uint64_t)begin + count, 4)},
                                     .params = &p->params,
                                     .window_begin = begin,
                                     .window_count = count,
                                     .items = p->params.fragment_count};
        SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &launch));
    }
    return SVO_OK;
}

static svo_status count_lists(packer *p)
{
    svo_i_compute *compute = p->gl_build->compute;
    const uint64_t most = svo_i_compute_range_max(compute) / 4;
    const uint32_t leaves = p->params.leaf_count;
    SVO_I_TRY(svo_i_compute_alloc_array_zero(compute, "list_counts", leaves * UINT64_C(4), &p->counts));
    uint32_t size = 0;
    for (uint32_t begin = 0; begin < leaves; begin += size) {
        size = leaves - begin < most ? leaves - begin : (uint32_t)most;
        SVO_I_TRY(count_window(p, begin, size));
    }
    return SVO_OK;
}

static svo_status scatter(packer *p, const svo_i_window *window)
{
    svo_i_gl_build *gl_build = p->gl_build;
    for (uint32_t i = 0; i < gl_build->build->list.chunk_count; ++i) {
        p->params.fragment_count = (cl_uint)gl_build->build->list.chunks[i].needed;
        const svo_i_launch launch = {.entry = SVO_I_ENTRY_SCATTER,
                                     .buffers = {svo_i_gl_chunk(gl_build, i), gl_build->cursors[i], p->counts,
                                                 gl_build->arrays[SVO_TREE_LIST_BEGIN],
                                                 gl_build->arrays[SVO_TREE_LIST]},
                                     .ranges = {[2] = svo_i_range_of(window->begin, window->end, 4),
                                                [3] = svo_i_range_of(window->begin, window->end, 4),
                                                [4] = svo_i_range_of(window->first, window->last, 4)},
                                     .params = &p->params,
                                     .window_begin = window->begin,
                                     .window_count = window->end - window->begin,
                                     .items = p->params.fragment_count};
        SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &launch));
    }
    return SVO_OK;
}

/* No long leaves yet. */
static void clear_long_leaves(packer *p)
{
    static const uint32_t no_groups[3] = {0, 1, 1};
    static const uint32_t none = 0;
    svo_i_compute *compute = p->gl_build->compute;
    svo_i_compute_write_at(compute, p->launches, 0, no_groups, sizeof no_groups);
    svo_i_compute_write_at(compute, p->gl_build->state, offsetof(svo_build_state, long_lists), &none, sizeof none);
}

static svo_status sort_lists(packer *p, const svo_i_window *window)
{
    svo_i_gl_build *gl_build = p->gl_build;
    const GLuint list_begin = gl_build->arrays[SVO_TREE_LIST_BEGIN];
    const GLuint list = gl_build->arrays[SVO_TREE_LIST];
    const svo_i_range begins = svo_i_range_of(window->begin, window->end + UINT64_C(1), 4);
    const svo_i_range entries = svo_i_range_of(window->first, window->last, 4);
    const svo_i_launch sort_short = {.entry = SVO_I_ENTRY_SORT_SHORT,
                                     .buffers = {list_begin, list, p->long_leaves, gl_build->state, p->launches},
                                     .ranges = {begins, entries},
                                     .params = &p->params,
                                     .window_begin = window->begin,
                                     .window_count = window->end - window->begin,
                                     .items = window->end - window->begin};
    clear_long_leaves(p);
    SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &sort_short));
    svo_filter_params pass = p->params; /* level: which digit */
    const svo_i_launch sort_long = {.entry = SVO_I_ENTRY_SORT_LONG,
                                    .buffers = {list_begin, list, p->spare, p->long_leaves, gl_build->state},
                                    .ranges = {begins, entries, entries},
                                    .params = &pass,
                                    .indirect = p->launches};
    for (pass.level = 0; pass.level < pass.digit_passes; ++pass.level) {
        SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &sort_long));
    }
    return SVO_OK;
}

static svo_status make_ranges(packer *p)
{
    const uint64_t bytes = (p->params.leaf_count + UINT64_C(1)) * 4;
    GLuint *list_begin = &p->gl_build->arrays[SVO_TREE_LIST_BEGIN];
    SVO_I_TRY(svo_i_compute_alloc_array(p->gl_build->compute, "list_begin", bytes, list_begin));
    SVO_I_TRY(count_lists(p));
    return svo_i_gl_scan(p->gl_build, p->counts, *list_begin, p->params.leaf_count);
}

static svo_status make_lists(packer *p)
{
    svo_i_gl_build *gl_build = p->gl_build;
    const svo_i_offsets offsets = svo_i_gl_list_offsets(gl_build);
    const uint64_t most = svo_i_compute_range_max(gl_build->compute) / 4;
    SVO_I_TRY(allocate_lists(p));
    for (svo_i_window window = {0}; window.end < offsets.count;) {
        SVO_I_TRY(svo_i_gl_window(gl_build, &offsets, window.end, most - 1, most, "triangles", &window));
        SVO_I_TRY(scatter(p, &window));
        SVO_I_TRY(sort_lists(p, &window));
    }
    return SVO_OK;
}

/* Creates list_begin, and list if with_lists. */
static svo_status pack(svo_i_gl_build *gl_build, bool with_lists)
{
    packer p = {.gl_build = gl_build, .params = svo_i_payload_params(gl_build->build)};
    p.params.digit_passes = svo_i_digit_passes(gl_build->build->commands.plan->triangle_count);
    GLuint *scratch[] = {&p.counts, &p.spare, &p.long_leaves, &p.launches};
    svo_status status = SVO_OK;
    svo_i_compute_stage_begin(gl_build->compute);
    SVO_I_TRY_CLEANUP(make_ranges(&p));
    if (with_lists) {
        SVO_I_TRY_CLEANUP(make_lists(&p));
    }
    SVO_I_TRY_CLEANUP(svo_i_compute_stage_end(gl_build->compute, gl_build->build, SVO_STAGE_PACK));
    if (with_lists) {
        SVO_I_TRY_CLEANUP(svo_i_gl_check_loops(gl_build, "sorting them"));
    }
cleanup:
    for (unsigned i = 0; i < sizeof scratch / sizeof scratch[0]; ++i) {
        svo_i_compute_free(gl_build->compute, scratch[i]);
    }
    return status;
}

/* ---- the build ---- */

svo_status svo_i_gl_check_size(svo_i_compute *compute, const svo_plan *plan)
{
    const uint64_t most = svo_i_gl_texels_max(compute);
    if (plan->texel_count <= most) {
        return SVO_OK;
    }
    return svo_i_device_fail(
        compute->device, SVO_UNSUPPORTED, SVO_I_GL_BUILD ": %llu texels are above the %llu of %u storage blocks of %s",
        (unsigned long long)plan->texel_count, (unsigned long long)most, SVO_I_TEXEL_BLOCKS, compute->gl->renderer);
}

static svo_status alloc_cursors(svo_i_gl_build *gl_build)
{
    const svo_i_fragment_list *list = &gl_build->build->list;
    gl_build->cursors = svo_i_alloc_zeroed(&gl_build->build->commands.device->memory, list->chunk_count + 1u,
                                           sizeof *gl_build->cursors);
    if (gl_build->cursors == NULL) {
        return svo_i_device_fail(gl_build->build->commands.device, SVO_OUT_OF_HOST_MEMORY,
                                 SVO_I_GL_BUILD ": no memory for %u chunks", list->chunk_count);
    }
    for (uint32_t i = 0; i < list->chunk_count; ++i) {
        const uint64_t bytes = list->chunks[i].needed * 4;
        SVO_I_TRY(svo_i_compute_alloc(gl_build->compute, "cursors", bytes, &gl_build->cursors[i]));
    }
    return SVO_OK;
}

/* One attempt with room for inner_capacity inner nodes. */
static svo_status try_nodes(svo_i_gl_build *gl_build, uint64_t inner_capacity, bool *fits)
{
    svo_i_compute *compute = gl_build->compute;
    GLuint *masks = &gl_build->arrays[SVO_TREE_CHILD_MASK];
    GLuint *first_child = &gl_build->arrays[SVO_TREE_FIRST_CHILD];
    gl_build->build->inner_capacity = inner_capacity;
    svo_i_compute_free(compute, masks);
    svo_i_compute_free(compute, first_child);
    SVO_I_TRY(svo_i_compute_alloc(compute, "child_mask_pool", inner_capacity, masks));
    SVO_I_TRY(svo_i_compute_alloc_array(compute, "first_child_pool", inner_capacity * 4, first_child));
    return subdivide(gl_build, fits);
}

/* Creates masks and first children. Reruns once with room for the worst case when the estimate was too low. */
static svo_status make_nodes(svo_i_gl_build *gl_build)
{
    svo_i_build *build = gl_build->build;
    const svo_i_gl_functions *gl = gl_build->compute->gl;
    const uint64_t most = svo_i_compute_range_max(gl_build->compute); /* a byte each */
    bool fits = false;
    uint64_t wanted = 0;
    for (unsigned attempt = 0; attempt < 2 && !fits; ++attempt) {
        wanted = svo_i_plan_inner_nodes(build->commands.plan, build->fragment_count, attempt > 0);
        SVO_I_TRY(try_nodes(gl_build, wanted < most ? wanted : most, &fits));
        build->commands.report->reruns += fits ? 0 : 1;
    }
    if (!fits && wanted > most) {
        return svo_i_device_fail(build->commands.device, SVO_UNSUPPORTED,
                                 SVO_I_GL_BUILD
                                 ": the tree has more inner nodes than the %llu of a storage block of %lld bytes of %s",
                                 (unsigned long long)most, (long long)gl->limits.storage_block_bytes, gl->renderer);
    }
    if (!fits) {
        return svo_i_device_fail(build->commands.device, SVO_INTERNAL,
                                 SVO_I_GL_BUILD ": %llu fragments made more than %llu nodes",
                                 (unsigned long long)build->fragment_count, (unsigned long long)wanted);
    }
    return SVO_OK;
}

/* The payload. Where materials alone need the ranges of entries, it frees them. */
static svo_status make_payload(svo_i_gl_build *gl_build)
{
    const svo_i_work *work = &gl_build->build->commands.plan->work;
    if (gl_build->build->tree->info.leaf_count > 0 && work->ranges && !work->lists) {
        SVO_I_TRY(pack(gl_build, false));
    }
    return svo_i_gl_payload(gl_build);
}

/* Shaders create payload for all levels, also for those above the plan's payload_level. */
static bool is_payload(svo_tree_buffer buffer)
{
    return buffer == SVO_TREE_COLORS || buffer == SVO_TREE_NORMALS || buffer == SVO_TREE_MATERIALS ||
           buffer == SVO_TREE_FILLS;
}

static svo_status copy_array(svo_i_gl_build *gl_build, svo_tree_buffer array)
{
    svo_i_build *build = gl_build->build;
    const svo_tree_info *info = &build->tree->info;
    const uint64_t element_bytes = svo_i_tree_element_bytes(array);
    const uint64_t skipped = is_payload(array) ? info->level_begin[info->payload_level] : 0;
    return svo_i_compute_to_cl(gl_build->compute, build, gl_build->arrays[array], svo_name(SVO_NAME_TREE_BUFFER, array),
                               skipped * element_bytes, svo_i_tree_element_count(info, array) * element_bytes,
                               &build->tree->buffers[array]);
}

/* Copies the tree's arrays to OpenCL, without unused capacity. */
static svo_status copy_arrays(svo_i_gl_build *gl_build)
{
    const double start_ms = svo_i_now_ms();
    for (svo_tree_buffer i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        if (gl_build->arrays[i] != 0) {
            SVO_I_TRY(copy_array(gl_build, i));
            svo_i_compute_free(gl_build->compute, &gl_build->arrays[i]);
        }
    }
    svo_i_report_add(gl_build->build->commands.report, SVO_STAGE_TRANSFER, svo_i_now_ms() - start_ms, "wall");
    return SVO_OK;
}

static svo_status run_stages(svo_i_gl_build *gl_build)
{
    svo_i_build *build = gl_build->build;
    const svo_i_work *work = &build->commands.plan->work;
    SVO_I_TRY(alloc_cursors(gl_build));
    SVO_I_TRY(make_nodes(gl_build));
    SVO_I_TRY(svo_i_progress_reach(build->commands.plan, SVO_STAGE_SUBDIVIDE, 1.0));
    if (work->lists) {
        SVO_I_TRY(svo_i_geometry_upload(build));
        SVO_I_TRY(pack(gl_build, true));
        SVO_I_TRY(svo_i_progress_reach(build->commands.plan, SVO_STAGE_PACK, 1.0));
    }
    if (work->surface) {
        SVO_I_TRY(make_payload(gl_build));
        SVO_I_TRY(svo_i_progress_reach(build->commands.plan, SVO_STAGE_FILTER, 1.0));
    }
    return copy_arrays(gl_build);
}

svo_status svo_i_gl_make_tree(svo_i_compute *compute, svo_i_build *build)
{
    svo_i_gl_build gl_build = {.build = build, .compute = compute};
    svo_i_gl_clear_errors(compute->gl);
    svo_i_compute_fill_zero(compute, compute->exhausted); /* a build that failed may have left its mark */
    const svo_status status = run_stages(&gl_build);
    for (uint32_t i = 0; gl_build.cursors != NULL && i < build->list.chunk_count; ++i) {
        svo_i_compute_free(compute, &gl_build.cursors[i]);
    }
    svo_i_free(gl_build.cursors);
    svo_i_compute_free(compute, &gl_build.state);
    svo_i_compute_free(compute, &gl_build.partials);
    for (svo_tree_buffer i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        svo_i_compute_free(compute, &gl_build.arrays[i]);
    }
    return status;
}
