/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: arbitrary bytes as a point cloud. Either they are refused with a one-line message, which names the byte
 * where the file is damaged, or the list is well formed: a voxel for each count, all points of the info in them, and
 * the same list again when memory is scarce.
 */
#include <string.h>

#include "fuzz.h"
#include "svocl/points.h"

#define NAME       "input"
#define VOXELS_MAX 20000u

static void check_refusal(svo_status status, const svo_voxels *voxels, const svo_message *message)
{
    REQUIRE(status == SVO_FILE_DAMAGED || status == SVO_OUT_OF_HOST_MEMORY || status == SVO_INVALID_ARGUMENT ||
            status == SVO_UNSUPPORTED);
    REQUIRE(voxels == NULL);
    REQUIRE(strncmp(message->text, NAME ": ", strlen(NAME ": ")) == 0);
    REQUIRE(strchr(message->text, '\n') == NULL);
    REQUIRE(status != SVO_FILE_DAMAGED || strstr(message->text, "byte") != NULL);
}

static void check_list(const svo_voxels *voxels, const svo_points_info *info)
{
    svo_voxels_info list = SVO_VOXELS_INFO_INIT;
    uint64_t sum = 0;
    uint64_t most = 0;
    REQUIRE(svo_voxels_get_info(voxels, &list) == SVO_OK);
    REQUIRE(list.voxel_count == info->voxel_count && list.voxel_count <= VOXELS_MAX);
    for (uint64_t i = 0; i < list.voxel_count; ++i) {
        const uint64_t count = svo_voxels_get_counts(voxels)[i];
        REQUIRE(count > 0 && svo_voxels_get(voxels)[i].rgba[3] == 255);
        sum += count;
        most = count > most ? count : most;
    }
    REQUIRE(sum == info->taken_count && most == info->count_max);
    REQUIRE(info->taken_count + info->outside_count + info->not_finite_count + info->withheld_count ==
            info->point_count);
}

/* What is read with little memory is the same, or memory does not suffice. */
static void check_again(svo_source source, svo_points_options options, const svo_voxels *voxels)
{
    svo_voxels *again = NULL;
    svo_voxels_info one = SVO_VOXELS_INFO_INIT;
    svo_voxels_info other = SVO_VOXELS_INFO_INIT;
    options.memory_bytes = SVO_POINTS_MEMORY_MIN;
    const svo_status status = svo_points_load(source, &options, &again, NULL, NULL);
    REQUIRE(status == SVO_OK || status == SVO_OUT_OF_HOST_MEMORY);
    if (status == SVO_OK) {
        REQUIRE(svo_voxels_get_info(voxels, &one) == SVO_OK && svo_voxels_get_info(again, &other) == SVO_OK);
        REQUIRE(one.voxel_count == other.voxel_count && one.depth == other.depth &&
                one.material_count == other.material_count && one.voxel_edge == other.voxel_edge &&
                one.origin[0] == other.origin[0] && one.origin[1] == other.origin[1] &&
                one.origin[2] == other.origin[2] && memcmp(one.low, other.low, sizeof one.low) == 0);
        REQUIRE(memcmp(svo_voxels_get(voxels), svo_voxels_get(again), one.voxel_count * sizeof(svo_voxel)) == 0);
    }
    svo_voxels_destroy(&again);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t byte_count)
{
    static const uint8_t nothing;
    svo_voxels *voxels = NULL;
    svo_points_info info = SVO_POINTS_INFO_INIT;
    svo_message message = {""};
    const svo_source source = svo_from_memory(data != NULL ? data : &nothing, byte_count, NAME);
    const svo_points_options options = {.struct_size = sizeof options,
                                        .voxels_max = VOXELS_MAX,
                                        .depth = (uint32_t)(byte_count % 17),
                                        .voxel_edge = byte_count % 3 == 1 ? 0.5 : 0.0,
                                        .edge = byte_count % 3 == 2 ? 8.0 : 0.0,
                                        .counts = (uint32_t)(byte_count % 2)};
    const svo_voxel_format format = svo_points_format(source);
    const svo_status status = svo_points_load(source, &options, &voxels, &info, &message);
    if (status != SVO_OK) {
        check_refusal(status, voxels, &message);
    } else {
        REQUIRE(format == (svo_voxel_format)info.format || info.format == SVO_VOXEL_FORMAT_PLY);
        check_list(voxels, &info);
        check_again(source, options, voxels);
    }
    svo_voxels_destroy(&voxels);
    return 0;
}
