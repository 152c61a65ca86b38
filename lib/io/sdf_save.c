/* SPDX-License-Identifier: MIT */
/* svo_sdf_save: a field as a list of voxels with distances in place of colors, for the writers of .nvdb and .vdb. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "io/voxels_formats.h"
#include "svocl/nodes.h"

#define DEPTH_MAX 12 /* one node below the root */

static void put_voxel(const svo_sdf_info *info, const svo_sdf_arrays *arrays, uint64_t index, svo_voxel *voxel)
{
    const uint32_t mask = (UINT32_C(1) << info->depth) - 1;
    uint32_t cell[3] = {(uint32_t)index & mask, (uint32_t)(index >> info->depth) & mask,
                        (uint32_t)(index >> 2 * info->depth)};
    float distance = arrays->distances[index];
    if (arrays->codes != NULL) {
        svo_code_to_cell(arrays->codes[index], cell);
    }
    if (distance == 0.0F && signbit(distance)) {
        distance = -FLT_MIN;
    }
    *voxel = (svo_voxel){.x = (int32_t)cell[0], .y = (int32_t)cell[1], .z = (int32_t)cell[2]};
    memcpy(voxel->rgba, &distance, sizeof voxel->rgba);
}

/* The distance of what is not in the field: the band's width, or the greatest. */
static float find_background(const svo_sdf_info *info, const svo_sdf_arrays *arrays)
{
    float greatest = info->band > 0.0F ? (float)((double)info->band * info->spacing) : FLT_MIN;
    for (uint64_t i = 0; i < info->voxel_count && info->band == 0.0F; ++i) {
        greatest = fmaxf(greatest, fabsf(arrays->distances[i]));
    }
    return greatest;
}

static svo_status make_list(const char *function, const svo_sdf_info *info, const svo_sdf_arrays *arrays,
                            svo_voxels **out, svo_message *message)
{
    svo_voxels_source source = {.struct_size = sizeof source,
                                .voxel_count = info->voxel_count,
                                .origin = {info->origin[0], info->origin[1], info->origin[2]},
                                .voxel_edge = info->spacing};
    if (info->voxel_count > SVO_VOXELS_MAX) {
        return svo_i_fail(message, SVO_UNSUPPORTED, "%s: %llu voxels are above %u", function,
                          (unsigned long long)info->voxel_count, SVO_VOXELS_MAX);
    }
    svo_voxel *voxels = svo_i_alloc_zeroed(NULL, (size_t)info->voxel_count + 1, sizeof *voxels);
    if (voxels == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %llu voxels", function,
                          (unsigned long long)info->voxel_count);
    }
    for (uint64_t i = 0; i < info->voxel_count; ++i) {
        put_voxel(info, arrays, i, &voxels[i]);
    }
    source.voxels = voxels;
    const svo_status status = svo_voxels_create(&source, out, message);
    svo_i_free(voxels);
    return status;
}

static svo_status save(const char *function, const svo_sdf *sdf, svo_sink sink, svo_voxel_format format,
                       svo_message *message)
{
    svo_sdf_info info = SVO_SDF_INFO_INIT;
    svo_sdf_arrays arrays = SVO_SDF_ARRAYS_INIT;
    svo_voxels *list = NULL;
    if (sdf == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: sdf is NULL", function);
    }
    (void)svo_sdf_get_info(sdf, &info);
    (void)svo_sdf_get_arrays(sdf, &arrays);
    if (arrays.distances == NULL && info.voxel_count > 0) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                          "%s: the field has no host arrays; call svo_sdf_download first", function);
    }
    if (info.depth > DEPTH_MAX) {
        return svo_i_fail(message, SVO_UNSUPPORTED, "%s: depth %u is above %d for .nvdb and .vdb", function, info.depth,
                          DEPTH_MAX);
    }
    voxel_writer writer = {.background = find_background(&info, &arrays)};
    SVO_I_TRY(make_list(function, &info, &arrays, &list, message));
    const svo_status status = svo_i_voxels_save_by(function, list, sink, format, &writer, NULL, message);
    svo_voxels_destroy(&list);
    return status;
}

svo_status svo_sdf_save(const svo_sdf *sdf, svo_sink sink, svo_message *message)
{
    return save("svo_sdf_save", sdf, sink, SVO_VOXEL_FORMAT_NVDB, message);
}

svo_status svo_sdf_save_as(const svo_sdf *sdf, svo_sink sink, svo_voxel_format format, svo_message *message)
{
    static const char function[] = "svo_sdf_save_as";
    if (format == SVO_VOXEL_FORMAT_AUTO) {
        format = svo_voxel_format_of_path(sink.path);
    }
    if (format != SVO_VOXEL_FORMAT_NVDB && format != SVO_VOXEL_FORMAT_VDB) {
        return sink.path != NULL ? svo_i_fail(message, SVO_INVALID_ARGUMENT,
                                              "%s: the suffix of '%s' is neither nvdb nor vdb, and format is %d",
                                              function, sink.path, (int)format)
                                 : svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: format %d is neither %d nor %d",
                                              function, (int)format, SVO_VOXEL_FORMAT_NVDB, SVO_VOXEL_FORMAT_VDB);
    }
    return save(function, sdf, sink, format, message);
}
