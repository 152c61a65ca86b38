/* SPDX-License-Identifier: MIT */
/* From triangles to an octree: a cube in memory, on the default OpenCL device. */
#include <inttypes.h>
#include <stdio.h>

#include "svocl/svocl.h"

static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
static const uint32_t indices[] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                   2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

int main(void)
{
    svo_mesh cube = SVO_MESH_INIT;
    cube.positions = positions;
    cube.vertex_count = 8;
    cube.indices = indices;
    cube.triangle_count = 12;

    svo_message message = {""};
    svo_device *device = NULL;
    if (svo_device_create_default(NULL, &device, &message) != SVO_OK) {
        fprintf(stderr, "%s\n", message.text);
        return 1;
    }
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    svo_tree_info info = SVO_TREE_INFO_INIT;
    char hash[SVO_HASH_TEXT_BYTES] = "";
    const int built = svo_plan_create(device, &cube, 7, NULL, &plan) == SVO_OK && /* 2^7 = 128 voxels per axis */
                      svo_build(plan, NULL, NULL, &tree, NULL) == SVO_OK && svo_tree_get_info(tree, &info) == SVO_OK &&
                      svo_tree_download(tree, NULL) == SVO_OK && svo_tree_hash(tree, SVO_HASH_ALL, hash) == SVO_OK;
    if (built)
        printf("%" PRIu64 " leaves, %" PRIu64 " nodes, hash %s\n", info.leaf_count, info.node_count, hash);
    else
        fprintf(stderr, "%s\n", svo_device_message(device));
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    svo_device_destroy(&device);
    return built ? 0 : 1;
}
