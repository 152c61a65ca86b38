/* SPDX-License-Identifier: MIT */
/*
 * svocl in a program with its own OpenCL: context, out-of-order queues, events and buffers. Two builds of one mesh are
 * in flight at once, each on its own queue. A command of the program waits for each.
 */
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>

#include "svocl/svocl.h"

static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
static const uint32_t indices[] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                   2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

/* The program's own OpenCL, with a mesh in its buffers and the events of the commands that write it. */
typedef struct own_opencl {
    cl_device_id device;
    cl_context context;
    cl_command_queue queues[2];
    svo_mesh_buffers mesh;
    cl_event uploads[2];
} own_opencl;

/* One build: the memory it needs, and its results. */
typedef struct build_job {
    unsigned depth;
    svo_plan *plan;
    svo_workspace *workspace;
    svo_tree *tree;
    cl_event built, read;
    uint8_t root_mask;
} build_job;

static cl_mem upload(own_opencl *own, const void *data, size_t bytes, cl_event *event)
{
    cl_mem memory = clCreateBuffer(own->context, CL_MEM_READ_WRITE, bytes, NULL, NULL);
    if (memory != NULL)
        clEnqueueWriteBuffer(own->queues[0], memory, CL_FALSE, 0, bytes, data, 0, NULL, event);
    return memory;
}

static bool open_opencl(own_opencl *own)
{
    cl_platform_id platform = NULL;
    if (clGetPlatformIDs(1, &platform, NULL) != CL_SUCCESS ||
        clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &own->device, NULL) != CL_SUCCESS)
        return false;
    own->context = clCreateContext(NULL, 1, &own->device, NULL, NULL, NULL);
    if (own->context == NULL)
        return false;
    for (int i = 0; i < 2; ++i) {
        own->queues[i] = clCreateCommandQueue(own->context, own->device, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, NULL);
        if (own->queues[i] == NULL)
            return false;
    }
    own->mesh = (svo_mesh_buffers){.struct_size = sizeof own->mesh, .vertex_count = 8, .triangle_count = 12};
    own->mesh.positions.memory = upload(own, positions, sizeof positions, &own->uploads[0]);
    own->mesh.indices.memory = upload(own, indices, sizeof indices, &own->uploads[1]);
    clFlush(own->queues[0]);
    return own->uploads[0] != NULL && own->uploads[1] != NULL;
}

static void close_opencl(own_opencl *own)
{
    for (int i = 0; i < 2; ++i) {
        if (own->uploads[i] != NULL)
            clReleaseEvent(own->uploads[i]);
        if (own->queues[i] != NULL)
            clReleaseCommandQueue(own->queues[i]);
    }
    if (own->mesh.positions.memory != NULL)
        clReleaseMemObject(own->mesh.positions.memory);
    if (own->mesh.indices.memory != NULL)
        clReleaseMemObject(own->mesh.indices.memory);
    if (own->context != NULL)
        clReleaseContext(own->context);
}

/* Memory for a build of the mesh, and a tree with room for it. */
static bool prepare(svo_device *device, svo_frontend *frontend, const svo_mesh *mesh, cl_command_queue queue,
                    build_job *job)
{
    return svo_plan_create(device, mesh, job->depth, NULL, &job->plan) == SVO_OK &&
           svo_workspace_create(job->plan, frontend, queue, NULL, &job->workspace) == SVO_OK &&
           svo_workspace_make_tree(job->workspace, &job->tree) == SVO_OK;
}

/* Enqueues the build and, after it, a read of the root's mask from the tree's buffer. Waits for nothing. */
static bool start(cl_command_queue queue, build_job *job)
{
    return svo_build_enqueue(job->workspace, job->tree, &(svo_submit){.queue = queue, .event = &job->built}) ==
               SVO_OK &&
           clEnqueueReadBuffer(queue, svo_tree_get_buffer(job->tree, SVO_TREE_CHILD_MASK), CL_FALSE, 0, 1,
                               &job->root_mask, 1, &job->built, &job->read) == CL_SUCCESS &&
           clFlush(queue) == CL_SUCCESS;
}

/* Waits for both and prints the result. */
static bool finish(cl_command_queue queue, build_job *job)
{
    const int trim = 1; /* to buffers as large as the tree */
    svo_tree_info info = SVO_TREE_INFO_INIT;
    char hash[SVO_HASH_TEXT_BYTES];
    if (clWaitForEvents(1, &job->read) != CL_SUCCESS || svo_tree_finish(job->tree, queue, trim, NULL) != SVO_OK ||
        svo_tree_download(job->tree, queue) != SVO_OK || svo_tree_hash(job->tree, SVO_HASH_ALL, hash) != SVO_OK)
        return false;
    svo_tree_get_info(job->tree, &info);
    printf("depth %u: %" PRIu64 " leaves, root mask %02x, hash %s\n", job->depth, info.leaf_count, job->root_mask,
           hash);
    return true;
}

static void release(build_job *job)
{
    if (job->built != NULL)
        clReleaseEvent(job->built);
    if (job->read != NULL)
        clReleaseEvent(job->read);
    svo_tree_destroy(&job->tree);
    svo_workspace_destroy(&job->workspace);
    svo_plan_destroy(&job->plan);
}

int main(void)
{
    own_opencl own = {0};
    build_job jobs[2] = {{.depth = 6}, {.depth = 7}};
    svo_message message = {"no OpenCL device with out-of-order queues"};
    svo_device *device = NULL;
    svo_frontend *frontend = NULL;
    svo_mesh_copy *mesh = NULL;

    bool done = open_opencl(&own) && svo_device_create(own.context, own.device, NULL, &device, &message) == SVO_OK &&
                svo_mesh_read(&own.mesh, own.queues[0], 2, own.uploads, &mesh, &message) == SVO_OK &&
                svo_frontend_create_cl(device, &frontend) == SVO_OK;
    for (int i = 0; i < 2 && done; ++i)
        done = prepare(device, frontend, svo_mesh_copy_get(mesh), own.queues[i], &jobs[i]);
    for (int i = 0; i < 2 && done; ++i)
        done = start(own.queues[i], &jobs[i]);
    for (int i = 0; i < 2 && done; ++i)
        done = finish(own.queues[i], &jobs[i]);
    if (!done)
        fprintf(stderr, "%s\n",
                device != NULL && svo_device_message(device)[0] != '\0' ? svo_device_message(device) : message.text);

    for (int i = 0; i < 2; ++i)
        release(&jobs[i]);
    svo_mesh_copy_destroy(&mesh);
    svo_frontend_destroy(&frontend);
    svo_device_destroy(&device);
    close_opencl(&own);
    return done ? 0 : 1;
}
