/* SPDX-License-Identifier: MIT */
/* The shortest way from triangles to an octree: a cube in memory, the default OpenCL device, an off-screen GL
   context. */
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>

#include "svocl/gl.h"
#include "svocl/svocl.h"

static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
static const uint32_t indices[] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                   2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

int main(void)
{
    const svo_mesh cube = {.struct_size = sizeof(svo_mesh),
                           .positions = positions,
                           .vertex_count = 8,
                           .indices = indices,
                           .triangle_count = 12};
    const unsigned depth = 7; /* 128 voxels per axis */
    svo_message message = {""};
    svo_device *device = NULL;
    svo_gl_context *context = NULL;
    svo_gl *gl = NULL;
    cl_command_queue queue = NULL;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    char hash[SVO_HASH_TEXT_BYTES] = "";

    bool done = svo_device_create_default(NULL, &device, &message) == SVO_OK &&
                svo_gl_context_create(SVO_GL_SURFACELESS, 0, &context, &message) == SVO_OK &&
                svo_gl_create(device, context, NULL, &gl) == SVO_OK;
    if (done) /* svo_build refuses a NULL queue with a message */
        queue = clCreateCommandQueue(svo_device_cl_context(device), svo_device_cl_device(device), 0, NULL);
    done = done && svo_plan_create(device, &cube, depth, NULL, &plan) == SVO_OK &&
           svo_build(plan, svo_gl_frontend(gl), queue, &tree, NULL) == SVO_OK &&
           svo_tree_download(tree, queue) == SVO_OK && svo_tree_hash(tree, SVO_HASH_ALL, hash) == SVO_OK;

    if (done) {
        svo_tree_info info;
        svo_tree_get_info(tree, &info);
        printf("%" PRIu64 " leaves, %" PRIu64 " nodes, hash %s\n", info.leaf_count, info.node_count, hash);
    } else {
        fprintf(stderr, "%s\n", message.text[0] != '\0' ? message.text : svo_device_message(device));
    }

    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    if (queue != NULL)
        clReleaseCommandQueue(queue);
    svo_gl_destroy(&gl);
    svo_gl_context_destroy(&context);
    svo_device_destroy(&device);
    return done ? 0 : 1;
}
