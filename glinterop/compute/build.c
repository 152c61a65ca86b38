/* SPDX-License-Identifier: MIT */
/*
 * Builds the tree by compute shaders from a fragment list that stays in OpenGL. svo_build makes the list and calls
 * svo_i_gl_make_tree, which runs the stages in the same order as the OpenCL builder and copies the arrays to OpenCL.
 */
#include "compute/build.h"

#include "commands/commands.h"
#include "compute/area.h"
#include "compute/buffer.h"
#include "compute/filter.h"
#include "compute/material.h"
#include "compute/pack.h"
#include "compute/subdivide.h"
#include "compute/surface.h"
#include "core/message.h"
#include "plan/accounts.h"
#include "plan/estimate.h"
#include "stages/inputs.h"
#include "stages/material.h"

static svo_status check_array(svo_i_compute *compute, const char *name, double bytes)
{
    const svo_i_gl_functions *gl = compute->gl;
    if (bytes <= (double)gl->limits.storage_block_bytes) {
        return SVO_OK;
    }
    return svo_i_device_fail(compute->device, SVO_UNSUPPORTED,
                             SVO_I_GL_BUILD ": %s need about %.0f bytes, above the storage block limit of %lld of %s",
                             name, bytes, (long long)gl->limits.storage_block_bytes, gl->renderer);
}

svo_status svo_i_gl_check_size(svo_i_compute *compute, const svo_plan *plan)
{
    const double fragments = plan->info.expected_fragments;
    SVO_I_TRY(check_array(compute, "triangle records", (double)plan->triangle_count * 16));
    if (plan->work.lists) {
        SVO_I_TRY(check_array(compute, "leaf lists", fragments * 4));
    }
    if ((plan->work.made & SVO_NEED_MATERIAL) != 0) {
        SVO_I_TRY(check_array(compute, "material entries", fragments * 8));
    }
    return check_array(compute, "texels", (double)plan->texel_count * 4);
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
    SVO_I_TRY(svo_i_compute_alloc(compute, "first_child_pool", inner_capacity * 4, first_child));
    return svo_i_gl_subdivide(gl_build, fits);
}

/* Creates masks and first children. Reruns once with room for the worst case when the estimate was too low. */
static svo_status make_nodes(svo_i_gl_build *gl_build)
{
    svo_i_build *build = gl_build->build;
    const svo_i_gl_functions *gl = gl_build->compute->gl;
    const uint64_t most = (uint64_t)gl->limits.storage_block_bytes / 4 - 1;
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

/* The materials of the nodes. Frees ranges of entries that nothing else needs. */
static svo_status make_materials(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface)
{
    svo_i_build *build = gl_build->build;
    const svo_i_work *work = &build->commands.plan->work;
    const bool has_leaves = build->tree->info.leaf_count > 0;
    const bool own_ranges = has_leaves && work->ranges && !work->lists;
    if (own_ranges) {
        SVO_I_TRY(svo_i_gl_pack(gl_build, false));
    }
    if ((work->made & SVO_NEED_MATERIAL) != 0) {
        /* A root without leaves needs no shader: OpenCL fills its payload. */
        SVO_I_TRY(has_leaves ? svo_i_gl_material(gl_build, surface) : svo_i_material(build));
    }
    if (own_ranges) {
        svo_i_compute_free(gl_build->compute, &gl_build->arrays[SVO_TREE_LIST_BEGIN]);
    }
    return SVO_OK;
}

/* The payload, from the mesh's attributes. */
static svo_status make_payload(svo_i_gl_build *gl_build)
{
    const uint32_t made = gl_build->build->commands.plan->work.made;
    svo_status status = SVO_OK;
    svo_i_gl_surface surface = {0};
    SVO_I_TRY_CLEANUP(svo_i_gl_surface_upload(gl_build, &surface));
    SVO_I_TRY_CLEANUP(make_materials(gl_build, &surface));
    if ((made & SVO_I_NEED_FILTER) != 0) {
        SVO_I_TRY_CLEANUP(svo_i_gl_filter(gl_build, &surface));
    }
    if ((made & SVO_NEED_PROJECTED_AREA) != 0) {
        SVO_I_TRY_CLEANUP(svo_i_gl_areas(gl_build, &surface));
    }
cleanup:
    svo_i_gl_surface_free(gl_build, &surface);
    return status;
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
    return svo_i_compute_to_cl(gl_build->compute, build, gl_build->arrays[array], svo_tree_buffer_name(array),
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
        SVO_I_TRY(svo_i_gl_pack(gl_build, true));
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
