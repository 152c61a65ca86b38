/* SPDX-License-Identifier: MIT */
/* Rays in your own kernel: a ring that casts a shadow on itself, drawn with letters. One work-item per pixel. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "svocl/svocl.h"

#define ROUND  96u /* corners around the ring, and around its tube */
#define TUBE   48u
#define WIDTH  72u
#define HEIGHT 30u

/* The program's kernel: svo_trace_closest finds what a pixel sees, svo_trace_any whether something blocks the light.
   The picture holds 0 for nothing, 1 for shadow, 2 and up for light. */
static const char kernel_source[] =
    "__kernel void draw(SVO_TREE_PARAMETERS, __global uchar *picture, uint width, uint height)\n"
    "{\n"
    "    SVO_TREE_MAKE(tree);\n"
    "    const uint x = get_global_id(0);\n"
    "    const uint y = get_global_id(1);\n"
    "    const float3 sun = normalize((float3)(0.9f, 0.3f, 0.25f));\n"
    "    const float right = ((float)x + 0.5f) / (float)width * 4.2f - 2.1f;\n"
    "    const float up = 1.75f - ((float)y + 0.5f) / (float)height * 3.5f;\n"
    "    const svo_ray ray = {{right, up + 4.0f, 4.0f - up}, {0.0f, -1.0f, -1.0f}, 0.0f, INFINITY};\n"
    "    svo_hit hit;\n"
    "    uchar shade = 0;\n"
    "    if (svo_trace_closest(&tree, &ray, &hit)) {\n"
    "        const float3 normal = (float3)(hit.normal[0], hit.normal[1], hit.normal[2]);\n"
    "        const float light = dot(normal, sun);\n"
    "        svo_ray shadow = {{0.0f, 0.0f, 0.0f}, {sun.x, sun.y, sun.z}, 0.01f, INFINITY};\n"
    "        svo_hit blocker;\n"
    "        for (int axis = 0; axis < 3; ++axis) {\n"
    "            shadow.origin[axis] = ray.origin[axis] + hit.t * ray.direction[axis];\n"
    "        }\n"
    "        shade = light <= 0.0f || svo_trace_any(&tree, &shadow, &blocker) ? 1 : 2 + (uchar)(light * 4.99f);\n"
    "    }\n"
    "    picture[y * width + x] = shade;\n"
    "}\n";

/* A ring around the z axis. */
static void make_ring(float *positions, uint32_t *indices)
{
    for (uint32_t i = 0; i < ROUND * TUBE; ++i) {
        const uint32_t slice = i / TUBE;
        const uint32_t side = i % TUBE;
        const double around = 6.283185307179586 * slice / ROUND;
        const double across = 6.283185307179586 * side / TUBE;
        const double radius = 1.3 + 0.45 * cos(across);
        float *position = positions + (size_t)3 * i;
        position[0] = (float)(radius * cos(around));
        position[1] = (float)(radius * sin(around));
        position[2] = (float)(0.45 * sin(across));
        const uint32_t b = slice * TUBE + (i + 1) % TUBE;
        const uint32_t c = (i + TUBE) % (ROUND * TUBE);
        const uint32_t d = (b + TUBE) % (ROUND * TUBE);
        const uint32_t corners[6] = {i, c, b, b, c, d};
        memcpy(indices + (size_t)6 * i, corners, sizeof corners);
    }
}

/* svocl's source comes before the program's, and the tree's arguments come before the kernel's own. */
static cl_kernel make_kernel(const svo_device_info *on, svo_tree *tree, cl_mem picture)
{
    const char *sources[2] = {svo_kernel_source(svo_tree_target(tree)), kernel_source};
    const cl_uint width = WIDTH;
    const cl_uint height = HEIGHT;
    cl_program program = clCreateProgramWithSource(on->context, 2, sources, NULL, NULL);
    cl_kernel kernel = NULL;
    if (program != NULL &&
        clBuildProgram(program, 1, &on->device, svo_kernel_options(svo_tree_target(tree)), NULL, NULL) == CL_SUCCESS)
        kernel = clCreateKernel(program, "draw", NULL);
    if (kernel != NULL &&
        (svo_kernel_set_arguments(svo_tree_target(tree), kernel, 0) != SVO_OK ||
         clSetKernelArg(kernel, SVO_TREE_ARGUMENTS, sizeof picture, (const void *)&picture) != CL_SUCCESS ||
         clSetKernelArg(kernel, SVO_TREE_ARGUMENTS + 1, sizeof width, &width) != CL_SUCCESS ||
         clSetKernelArg(kernel, SVO_TREE_ARGUMENTS + 2, sizeof height, &height) != CL_SUCCESS)) {
        clReleaseKernel(kernel);
        kernel = NULL;
    }
    if (program != NULL)
        clReleaseProgram(program);
    return kernel;
}

static void print_picture(const unsigned char *picture)
{
    unsigned seen = 0;
    unsigned dark = 0;
    for (unsigned y = 0; y < HEIGHT; ++y) {
        for (unsigned x = 0; x < WIDTH; ++x) {
            const unsigned char shade = picture[y * WIDTH + x];
            putchar(" .:-=+*#"[shade & 7]);
            seen += shade > 0;
            dark += shade == 1;
        }
        putchar('\n');
    }
    printf("%u pixels see the ring, %u of them in its own shadow\n", seen, dark);
}

static bool draw(const svo_device_info *on, svo_tree *tree, cl_command_queue queue)
{
    unsigned char pixels[WIDTH * HEIGHT];
    const size_t size[2] = {WIDTH, HEIGHT};
    const size_t group[2] = {WIDTH, 1};
    cl_mem picture = clCreateBuffer(on->context, CL_MEM_WRITE_ONLY, sizeof pixels, NULL, NULL);
    cl_kernel kernel = picture != NULL ? make_kernel(on, tree, picture) : NULL;
    const bool drawn =
        kernel != NULL && clEnqueueNDRangeKernel(queue, kernel, 2, NULL, size, group, 0, NULL, NULL) == CL_SUCCESS &&
        clEnqueueReadBuffer(queue, picture, CL_TRUE, 0, sizeof pixels, pixels, 0, NULL, NULL) == CL_SUCCESS;
    if (drawn)
        print_picture(pixels);
    if (kernel != NULL)
        clReleaseKernel(kernel);
    if (picture != NULL)
        clReleaseMemObject(picture);
    return drawn;
}

int main(void)
{
    static float positions[ROUND * TUBE * 3];
    static uint32_t indices[ROUND * TUBE * 6];
    const svo_mesh ring = {.struct_size = sizeof(svo_mesh),
                           .positions = positions,
                           .vertex_count = (size_t)ROUND * TUBE,
                           .indices = indices,
                           .triangle_count = (size_t)ROUND * TUBE * 2};
    const svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_RAYS};
    svo_message message = {"an OpenCL call of the program failed"};
    svo_device *device = NULL;
    svo_device_info on = SVO_DEVICE_INFO_INIT;
    cl_command_queue queue = NULL;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;

    make_ring(positions, indices);
    bool done =
        svo_device_create_default(NULL, &device, &message) == SVO_OK && svo_device_get_info(device, &on) == SVO_OK;
    if (done)
        queue = clCreateCommandQueue(on.context, on.device, 0, NULL);
    done = queue != NULL && svo_plan_create(device, &ring, 6, &options, &plan) == SVO_OK &&
           svo_build(plan, NULL, queue, &tree, NULL) == SVO_OK && draw(&on, tree, queue);
    if (!done)
        fprintf(stderr, "%s\n",
                device != NULL && svo_device_message(device)[0] != '\0' ? svo_device_message(device) : message.text);

    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    if (queue != NULL)
        clReleaseCommandQueue(queue);
    svo_device_destroy(&device);
    return done ? 0 : 1;
}
