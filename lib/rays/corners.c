/* SPDX-License-Identifier: MIT */
/*
 * Where the leaves' corners come from: the mesh's floats as they are, if double can tell apart what the float stage of
 * rays computes of them; else floats in grid units, and with fp64 doubles in world units, which kernels/bvh/corners.cl
 * makes. Without fp64 the host makes the floats.
 */
#include "rays/corners.h"

#include <math.h>

#include "rays/programs.h"
#include "shared/layout.h"
#include "stages/sort.h"

/* Widths of grids, world units, in which the products of the float stage are within the range of floats. */
#define WORLD_WIDTH_MIN 0x1p-40
#define WORLD_WIDTH_MAX 0x1p50

static bool is_in_world(const svo_tree *tree)
{
    const double width = ldexp(1.0, (int)tree->info.snap_bits) / tree->info.scale;
    return tree->device->has_fp64 && tree->info.positions == SVO_POSITIONS_FLOAT && width >= WORLD_WIDTH_MIN &&
           width <= WORLD_WIDTH_MAX;
}

/* The buffer of the tree that has its mesh's vertices. */
static svo_tree_buffer source_of(const svo_tree *tree)
{
    return tree->info.positions == SVO_POSITIONS_FLOAT    ? SVO_TREE_POSITIONS
           : tree->info.positions == SVO_POSITIONS_DOUBLE ? SVO_TREE_POSITIONS_DOUBLE
                                                          : SVO_TREE_VERTICES;
}

/* ---- with fp64 ---- */

static svo_status make_on_device(const svo_tree *tree, svo_i_device_work *work, svo_i_corners *out)
{
    const svo_tree_info *info = &tree->info;
    const cl_double4 grid = {{info->origin[0], info->origin[1], info->origin[2], info->scale}};
    const cl_uint positions = info->positions;
    const cl_uint count = (cl_uint)(info->vertex_count * 3);
    SVO_I_TRY(svo_i_work_result(work, "ray_corners", count * sizeof(cl_float), &out->made[0]));
    SVO_I_TRY(svo_i_work_result(work, "ray_corners_double", count * sizeof(cl_double), &out->made[1]));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[source_of(tree)]),
                                        SVO_I_ARGUMENT(out->made[0]),
                                        SVO_I_ARGUMENT(out->made[1]),
                                        SVO_I_ARGUMENT(grid),
                                        SVO_I_ARGUMENT(positions),
                                        SVO_I_ARGUMENT(count)};
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_bvh, svo_i_sort_defines(work->device)));
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_bvh_corners", SVO_I_ARGUMENTS(arguments), count));
    return svo_i_work_wait(work);
}

/* ---- without fp64 ---- */

static double world_coordinate(const svo_tree_info *info, const void *source, size_t at)
{
    return info->positions == SVO_POSITIONS_FLOAT ? (double)((const float *)source)[at]
           : info->positions == SVO_POSITIONS_DOUBLE
               ? ((const double *)source)[at]
               : info->origin[at % 3] + ((const int32_t *)source)[at] / info->scale;
}

static svo_status make_on_host(const svo_tree *tree, svo_i_device_work *work, svo_i_corners *out)
{
    const svo_tree_info *info = &tree->info;
    const svo_tree_buffer buffer = source_of(tree);
    const size_t count = (size_t)info->vertex_count * 3;
    const size_t bytes = (size_t)info->vertex_count * svo_i_tree_element_bytes(buffer);
    void *source = svo_i_alloc(&tree->memory, bytes + 1);
    float *floats = svo_i_alloc(&tree->memory, count * sizeof *floats + 1);
    svo_status status = SVO_OK;
    if (source == NULL || floats == NULL) {
        status = svo_i_device_fail(tree->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu corners",
                                   work->function, count / 3);
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(svo_i_work_read(work, tree->buffers[buffer], 0, source, bytes));
    for (size_t i = 0; i < count; ++i) {
        floats[i] = (float)((world_coordinate(info, source, i) - info->origin[i % 3]) * info->scale);
    }
    SVO_I_TRY_CLEANUP(svo_i_work_result(work, "ray_corners", count * sizeof *floats, &out->made[0]));
    SVO_I_TRY_CLEANUP(svo_i_work_write(work, out->made[0], floats, count * sizeof *floats));

cleanup:
    svo_i_free(source);
    svo_i_free(floats);
    return status;
}

/* ---- either ---- */

svo_status svo_i_corners_find(const svo_tree *tree, const char *function, cl_command_queue queue, svo_i_corners *out)
{
    svo_i_device_work work;
    *out = (svo_i_corners){.in_world = is_in_world(tree)};
    if (out->in_world) {
        out->floats = tree->buffers[SVO_TREE_POSITIONS];
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_begin(tree->device, function, queue, &work));
    const svo_status status =
        tree->device->has_fp64 ? make_on_device(tree, &work, out) : make_on_host(tree, &work, out);
    svo_i_work_end(&work);
    if (status != SVO_OK) {
        svo_i_corners_release(out);
    }
    out->floats = out->made[0];
    out->doubles = out->made[1];
    return status;
}

void svo_i_corners_release(svo_i_corners *corners)
{
    for (int i = 0; i < 2; ++i) {
        if (corners->made[i] != NULL) {
            clReleaseMemObject(corners->made[i]);
        }
    }
    *corners = (svo_i_corners){.floats = NULL};
}
