/* SPDX-License-Identifier: MIT */
/*
 * svocl in a program that has OpenCL of its own: its context, its out-of-order queues, its events, its buffers. Two builds
 * are in flight at once, each on a queue and a thread of its own, from one mesh that the device has not finished yet.
 */
#include <inttypes.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>

#include "svocl/gl.h"
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

/* One build: what it needs, and what it leaves. */
typedef struct build_job {
    const own_opencl *opencl;
    cl_command_queue queue;
    unsigned depth;
    bool done;
    svo_tree_info info;
    uint8_t root_mask;
    char hash[SVO_HASH_TEXT_BYTES];
    svo_message message;
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

/* Reads the root's mask out of the tree's buffer by a command of the program's. */
static bool read_root(build_job *job, const svo_tree *tree)
{
    return clEnqueueReadBuffer(job->queue, svo_tree_get_buffer(tree, SVO_TREE_CHILD_MASK), CL_TRUE, 0, 1,
                               &job->root_mask, 0, NULL, NULL) == CL_SUCCESS;
}

/* A thread. Handles belong to one thread at a time, so each has its own; the OpenCL context is shared. */
static void *build(void *pointer)
{
    build_job *job = pointer;
    const own_opencl *own = job->opencl;
    svo_device *device = NULL;
    svo_gl_context *context = NULL;
    svo_gl *gl = NULL;
    svo_mesh_copy *mesh = NULL;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    job->done = svo_device_create(own->context, own->device, NULL, &device, &job->message) == SVO_OK &&
                svo_gl_context_create(SVO_GL_SURFACELESS, 0, &context, &job->message) == SVO_OK &&
                svo_mesh_read(&own->mesh, job->queue, 2, own->uploads, &mesh, &job->message) == SVO_OK &&
                svo_gl_create(device, context, NULL, &gl) == SVO_OK &&
                svo_plan_create(device, svo_mesh_copy_get(mesh), job->depth, NULL, &plan) == SVO_OK &&
                svo_build(plan, svo_gl_frontend(gl), job->queue, &tree, NULL) == SVO_OK &&
                svo_tree_download(tree, job->queue) == SVO_OK &&
                svo_tree_hash(tree, SVO_HASH_ALL, job->hash) == SVO_OK && read_root(job, tree);
    if (job->done)
        svo_tree_get_info(tree, &job->info);
    else if (device != NULL && svo_device_message(device)[0] != '\0')
        snprintf(job->message.text, sizeof job->message.text, "%s", svo_device_message(device));
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    svo_mesh_copy_destroy(&mesh);
    svo_gl_destroy(&gl);
    svo_gl_context_destroy(&context);
    svo_device_destroy(&device);
    return NULL;
}

int main(void)
{
    own_opencl own = {0};
    build_job jobs[2] = {{.opencl = &own}, {.opencl = &own}};
    pthread_t threads[2];
    int started = 0;
    bool done = open_opencl(&own);
    if (!done)
        fprintf(stderr, "no OpenCL device with out-of-order queues\n");
    for (; started < 2 && done; started += done) {
        jobs[started].queue = own.queues[started];
        jobs[started].depth = 6 + (unsigned)started;
        done = pthread_create(&threads[started], NULL, build, &jobs[started]) == 0;
    }
    for (int i = 0; i < started; ++i) {
        pthread_join(threads[i], NULL);
        done = done && jobs[i].done;
        if (jobs[i].done)
            printf("depth %u: %" PRIu64 " leaves, root mask %02x, hash %s\n", jobs[i].depth, jobs[i].info.leaf_count,
                   jobs[i].root_mask, jobs[i].hash);
        else
            fprintf(stderr, "%s\n", jobs[i].message.text);
    }
    close_opencl(&own);
    return done ? 0 : 1;
}
