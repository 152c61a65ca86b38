/* SPDX-License-Identifier: MIT */
/*
 * svo_sdf_create: options and checks; the signs, which are those of solids (solid/inside.h), and the distances
 * (distances.h). And what callers ask of a field.
 */
#include "svocl/sdf.h"

#include <math.h>

#include "core/struct_size.h"
#include "sdf/distances.h"
#include "solid/inside.h"

/* The exponents of two between which voxels' widths are, so that distances are floats and their squares doubles. */
#define WIDTH_LOG2_MAX 100

/* The default of batch_bytes. */
#define BATCH_BYTES (UINT64_C(192) << 20)

/* Voxels: the widest grid. */
#define BAND_MAX 65536.0F

/* Bytes of scratch that signs take (lib/solid/inside.c). */
#define SIGN_NODE_BYTES 41
#define SIGN_LEAF_BYTES 46

/* ---- checks ---- */

static svo_status read_options(const svo_tree *tree, const char *function, const svo_sdf_options *options,
                               svo_sdf_options *out)
{
    svo_device *device = tree->device;
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(device), function, "options", options, out,
                                SVO_I_STRUCT_SIZES(svo_sdf_options, batch_bytes)));
    if ((unsigned)out->rule > SVO_SOLID_PARITY) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.rule %d is not in 0 .. %d", function,
                                 (int)out->rule, (int)SVO_SOLID_PARITY);
    }
    if (!(out->band >= 0.0F && out->band <= BAND_MAX)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.band %g is not in 0 .. %g", function,
                                 (double)out->band, (double)BAND_MAX);
    }
    out->batch_bytes = out->batch_bytes == 0 ? BATCH_BYTES : out->batch_bytes;
    return SVO_OK;
}

static svo_status check_tree(const svo_tree *tree, const char *function)
{
    SVO_I_TRY(svo_i_tree_check(tree, function));
    if (tree->device == NULL) {
        return SVO_NOT_ON_DEVICE;
    }
    SVO_I_TRY(svo_i_inside_check(tree, function, "a distance field"));
    if (tree->info.leaf_count == 0) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                 "%s: the tree has 0 leaves; a distance needs at least 1", function);
    }
    int exponent = 0;
    (void)frexp(tree->info.edge, &exponent);
    exponent -= (int)tree->info.depth;
    if (exponent < -WIDTH_LOG2_MAX || exponent > WIDTH_LOG2_MAX) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: voxels %g wide are not in 2^-%d .. 2^%d",
                                 function, ldexp(tree->info.edge, -(int)tree->info.depth), WIDTH_LOG2_MAX,
                                 WIDTH_LOG2_MAX);
    }
    return tree->device->has_fp64
               ? SVO_OK
               : svo_i_device_fail(tree->device, SVO_UNSUPPORTED, "%s: the device has no doubles", function);
}

/* ---- plan ---- */

svo_status svo_sdf_plan(const svo_tree *tree, const svo_sdf_options *options, svo_sdf_plan_info *info)
{
    static const char function[] = "svo_sdf_plan";
    svo_sdf_options asked;
    SVO_I_TRY(check_tree(tree, function));
    SVO_I_TRY(read_options(tree, function, options, &asked));
    const svo_tree_info *held = &tree->info;
    const uint64_t all = UINT64_C(1) << 3 * held->depth;
    const double expected = 2.0 * (double)asked.band * (double)held->leaf_count;
    svo_sdf_plan_info planned = {.voxel_count = all};
    if (asked.band > 0.0F && expected < (double)all) {
        planned.voxel_count = (uint64_t)expected;
    }
    planned.result_bytes =
        planned.voxel_count * (SVO_I_SDF_DISTANCE_BYTES + (asked.band > 0.0F ? SVO_I_SDF_CODE_BYTES : 0));
    planned.scratch_bytes = 2 * asked.batch_bytes;
    if (asked.is_unsigned == 0) {
        planned.scratch_bytes += held->node_count * SIGN_NODE_BYTES + held->leaf_count * SIGN_LEAF_BYTES;
    }
    return svo_i_struct_write(svo_i_device_message(tree->device), function, "info", &planned, info,
                              SVO_I_STRUCT_SIZES(svo_sdf_plan_info, scratch_bytes));
}

/* ---- creation ---- */

static void describe(const svo_tree *tree, const svo_sdf_options *asked, svo_sdf_info *out)
{
    *out = (svo_sdf_info){.depth = tree->info.depth,
                          .band = asked->band,
                          .is_unsigned = asked->is_unsigned != 0,
                          .rule = (uint32_t)asked->rule,
                          .edge = tree->info.edge,
                          .spacing = ldexp(tree->info.edge, -(int)tree->info.depth)};
    for (int axis = 0; axis < 3; ++axis) {
        out->origin[axis] = tree->info.origin[axis];
        out->first[axis] = tree->info.origin[axis] + 0.5 * out->spacing;
    }
}

/* Which voxels are inside. */
static svo_status find_signs(svo_i_device_work *work, const svo_tree *tree, svo_sdf_info *info, svo_i_sdf_signs *out)
{
    svo_i_inside inside;
    svo_solid_info solid = SVO_SOLID_INFO_INIT;
    *out = (svo_i_sdf_signs){.cells = NULL};
    if (info->is_unsigned != 0) {
        return svo_i_inside_check_mesh(work, tree);
    }
    SVO_I_TRY(svo_i_inside_find(work, tree, (svo_solid_rule)info->rule, true, NULL, &inside, &solid));
    *out = (svo_i_sdf_signs){.cells = inside.mask, .leaves = inside.leaves};
    for (int axis = 0; axis < 3; ++axis) {
        info->open_columns[axis] = solid.open_columns[axis];
    }
    return SVO_OK;
}

static svo_status make(const svo_tree *tree, const svo_sdf_options *asked, cl_command_queue queue, const char *function,
                       svo_sdf *sdf)
{
    svo_i_device_work work;
    svo_i_sdf_signs signs;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin(tree->device, function, queue, &work));
    SVO_I_TRY_CLEANUP(find_signs(&work, tree, &sdf->info, &signs));
    SVO_I_TRY_CLEANUP(svo_i_sdf_find(&work, tree, &signs, asked->batch_bytes, sdf));
    SVO_I_TRY_CLEANUP(svo_i_work_wait(&work));
    sdf->info.scratch_bytes = work.peak_bytes;
    sdf->info.bytes =
        sdf->info.voxel_count * (SVO_I_SDF_DISTANCE_BYTES + (sdf->info.band > 0.0F ? SVO_I_SDF_CODE_BYTES : 0));

cleanup:
    svo_i_work_end(&work);
    return status;
}

svo_status svo_sdf_create(const svo_tree *tree, const svo_sdf_options *options, cl_command_queue queue, svo_sdf **out)
{
    static const char function[] = "svo_sdf_create";
    svo_sdf_options asked;
    SVO_I_TRY(check_tree(tree, function));
    if (out == NULL) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: out is NULL", function);
    }
    SVO_I_TRY(read_options(tree, function, options, &asked));
    svo_sdf *sdf = svo_i_alloc_zeroed(&tree->device->memory, 1, sizeof *sdf);
    if (sdf == NULL) {
        return svo_i_device_fail(tree->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a field", function);
    }
    sdf->device = tree->device;
    sdf->memory = tree->device->memory;
    describe(tree, &asked, &sdf->info);
    const svo_status status = make(tree, &asked, queue, function, sdf);
    if (status != SVO_OK) {
        svo_sdf_destroy(&sdf);
        return status;
    }
    *out = sdf;
    return SVO_OK;
}

void svo_sdf_destroy(svo_sdf **sdf)
{
    if (sdf == NULL || *sdf == NULL) {
        return;
    }
    for (int i = 0; i < SVO_SDF_BUFFER_COUNT; ++i) {
        svo_i_buffer_release(&(*sdf)->buffers[i]);
        svo_i_free((*sdf)->host[i]);
    }
    svo_i_free(*sdf);
    *sdf = NULL;
}

/* ---- what callers ask ---- */

svo_status svo_sdf_get_info(const svo_sdf *sdf, svo_sdf_info *info)
{
    return sdf == NULL ? SVO_INVALID_ARGUMENT
                       : svo_i_struct_write(svo_i_device_message(sdf->device), "svo_sdf_get_info", "info", &sdf->info,
                                            info, SVO_I_STRUCT_SIZES(svo_sdf_info, scratch_bytes));
}

cl_mem svo_sdf_get_buffer(const svo_sdf *sdf, svo_sdf_buffer buffer)
{
    return (unsigned)buffer < SVO_SDF_BUFFER_COUNT ? sdf->buffers[buffer] : NULL;
}

/* Reads an array into new memory. *out stays NULL for one that is not held. */
static svo_status download_array(const svo_sdf *sdf, cl_command_queue queue, svo_sdf_buffer buffer, void **out)
{
    static const char function[] = "svo_sdf_download";
    const uint64_t bytes =
        sdf->info.voxel_count * (buffer == SVO_SDF_CODES ? SVO_I_SDF_CODE_BYTES : SVO_I_SDF_DISTANCE_BYTES);
    if (sdf->buffers[buffer] == NULL || bytes == 0) {
        return SVO_OK;
    }
    *out = bytes <= SIZE_MAX ? svo_i_alloc(&sdf->memory, (size_t)bytes) : NULL;
    if (*out == NULL) {
        return svo_i_device_fail(sdf->device, SVO_OUT_OF_HOST_MEMORY, "%s: %s needs %llu bytes", function,
                                 buffer == SVO_SDF_CODES ? "codes" : "distances", (unsigned long long)bytes);
    }
    const cl_int error =
        clEnqueueReadBuffer(queue, sdf->buffers[buffer], CL_TRUE, 0, (size_t)bytes, *out, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(sdf->device, function, "clEnqueueReadBuffer", error);
}

svo_status svo_sdf_download(svo_sdf *sdf, cl_command_queue queue)
{
    void *host[SVO_SDF_BUFFER_COUNT] = {NULL};
    svo_status status = SVO_OK;
    if (sdf == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (sdf->downloaded) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_device_queue(sdf->device, "svo_sdf_download", queue, &queue));
    for (int i = 0; i < SVO_SDF_BUFFER_COUNT; ++i) {
        SVO_I_TRY_CLEANUP(download_array(sdf, queue, (svo_sdf_buffer)i, &host[i]));
    }
    for (int i = 0; i < SVO_SDF_BUFFER_COUNT; ++i) {
        sdf->host[i] = host[i];
        host[i] = NULL;
    }
    sdf->downloaded = true;

cleanup:
    for (int i = 0; i < SVO_SDF_BUFFER_COUNT; ++i) {
        svo_i_free(host[i]);
    }
    return status;
}

svo_status svo_sdf_get_arrays(const svo_sdf *sdf, svo_sdf_arrays *arrays)
{
    if (sdf == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_sdf_arrays held = {.distances = sdf->host[SVO_SDF_DISTANCES], .codes = sdf->host[SVO_SDF_CODES]};
    return svo_i_struct_write(svo_i_device_message(sdf->device), "svo_sdf_get_arrays", "arrays", &held, arrays,
                              SVO_I_STRUCT_SIZES(svo_sdf_arrays, codes));
}
