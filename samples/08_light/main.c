/* SPDX-License-Identifier: MIT */
/* Rays and cones in your own kernel: a ring from above and its soft shadow, drawn with letters. One work-item per
   letter. */
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

#define OWN_ARGUMENTS (SVO_TREE_ARGUMENTS + SVO_LIGHT_ARGUMENTS) /* the first of the kernel's own */

/* The program's kernel: a ray looks down. Where it meets the ring: 8. Else what passes a cone from the ground to a sun
   10 degrees wide, from 0, nothing, to 7. */
static const char kernel_source[] =
    "__kernel void shade(SVO_TREE_PARAMETERS, SVO_LIGHT_PARAMETERS, __global uchar *picture, uint width, uint height)\n"
    "{\n"
    "    SVO_TREE_MAKE(tree);\n"
    "    SVO_LIGHT_MAKE(light);\n"
    "    const uint x = get_global_id(0);\n"
    "    const uint y = get_global_id(1);\n"
    "    svo_cone cone;\n"
    "    cone.origin.x = ((float)x + 0.5f) / (float)width * 4.8f - 2.4f;\n"
    "    cone.origin.y = 2.0f - ((float)y + 0.5f) / (float)height * 4.0f;\n"
    "    cone.origin.z = -1.4f;\n"
    "    cone.direction = normalize((float3)(-0.3f, 0.2f, 1.0f));\n"
    "    cone.normal = (float3)(0.0f);\n" /* the ground is not part of the tree */
    "    cone.tangent = 0.0875f;\n" /* of half the angle */
    "    cone.start = cone.range = cone.falloff = 0.0f;\n"
    "    cone.step = 0.5f;\n"
    "    const svo_ray down = {{cone.origin.x, cone.origin.y, 2.0f}, {0.0f, 0.0f, -1.0f}, 0.0f, 3.4f};\n"
    "    svo_hit hit;\n"
    "    const bool ring = svo_trace_closest(&tree, &down, &hit);\n"
    "    picture[y * width + x] = ring ? 8 : (uchar)(svo_trace_cone(&light, &cone).pass * 7.99f);\n"
    "}\n";

/* A ring that leans. */
static void make_ring(float *positions, uint32_t *indices)
{
    for (uint32_t i = 0; i < ROUND * TUBE; ++i) {
        const uint32_t slice = i / TUBE;
        const double around = 6.283185307179586 * slice / ROUND;
        const double across = 6.283185307179586 * (i % TUBE) / TUBE;
        const double radius = 1.2 + 0.3 * cos(across);
        float *position = positions + (size_t)3 * i;
        position[0] = (float)(radius * cos(around));
        position[1] = (float)(radius * sin(around));
        position[2] = (float)(0.3 * sin(across) + 0.6 * cos(around));
        const uint32_t b = slice * TUBE + (i + 1) % TUBE;
        const uint32_t c = (i + TUBE) % (ROUND * TUBE);
        const uint32_t d = (b + TUBE) % (ROUND * TUBE);
        const uint32_t corners[6] = {i, c, b, b, c, d};
        memcpy(indices + (size_t)6 * i, corners, sizeof corners);
    }
}

/* svocl's sources come before the program's. The arguments come in the order of the kernel's parameters. */
static cl_kernel make_kernel(const svo_device_info *on, svo_tree *tree, svo_light *light, cl_mem picture)
{
    const char *sources[3] = {svo_kernel_source(svo_tree_target(tree)), svo_kernel_source(svo_light_target(light)),
                              kernel_source};
    const cl_uint width = WIDTH;
    const cl_uint height = HEIGHT;
    cl_program program = clCreateProgramWithSource(on->context, 3, sources, NULL, NULL);
    cl_kernel kernel = NULL;
    if (program != NULL &&
        clBuildProgram(program, 1, &on->device, svo_kernel_options(svo_light_target(light)), NULL, NULL) == CL_SUCCESS)
        kernel = clCreateKernel(program, "shade", NULL);
    if (kernel != NULL &&
        (svo_kernel_set_arguments(svo_tree_target(tree), kernel, 0) != SVO_OK ||
         svo_kernel_set_arguments(svo_light_target(light), kernel, SVO_TREE_ARGUMENTS) != SVO_OK ||
         clSetKernelArg(kernel, OWN_ARGUMENTS, sizeof picture, (const void *)&picture) != CL_SUCCESS ||
         clSetKernelArg(kernel, OWN_ARGUMENTS + 1, sizeof width, &width) != CL_SUCCESS ||
         clSetKernelArg(kernel, OWN_ARGUMENTS + 2, sizeof height, &height) != CL_SUCCESS)) {
        clReleaseKernel(kernel);
        kernel = NULL;
    }
    if (program != NULL)
        clReleaseProgram(program);
    return kernel;
}

static void print_picture(const unsigned char *picture)
{
    unsigned ring = 0;
    unsigned shaded = 0;
    unsigned half = 0;
    for (unsigned y = 0; y < HEIGHT; ++y) {
        for (unsigned x = 0; x < WIDTH; ++x) {
            const unsigned char shade = picture[y * WIDTH + x];
            putchar("#*+=-:. @"[shade]);
            ring += shade == 8;
            shaded += shade == 0;
            half += shade > 0 && shade < 7;
        }
        putchar('\n');
    }
    printf("%u letters of the ring, %u in its shadow, %u in its soft edge\n", ring, shaded, half);
}

static bool draw(const svo_device_info *on, svo_tree *tree, svo_light *light, cl_command_queue queue)
{
    unsigned char pixels[WIDTH * HEIGHT];
    const size_t size[2] = {WIDTH, HEIGHT};
    const size_t group[2] = {WIDTH, 1};
    cl_mem picture = clCreateBuffer(on->context, CL_MEM_WRITE_ONLY, sizeof pixels, NULL, NULL);
    cl_kernel kernel = picture != NULL ? make_kernel(on, tree, light, picture) : NULL;
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
    const svo_plan_options options = {.struct_size = sizeof options,
                                      .need = SVO_NEED_NORMAL | SVO_NEED_RAYS | SVO_NEED_PROJECTED_AREA};
    svo_message message = {"an OpenCL call of the program failed"};
    svo_device *device = NULL;
    svo_device_info on = SVO_DEVICE_INFO_INIT;
    cl_command_queue queue = NULL;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    svo_light *light = NULL;

    make_ring(positions, indices);
    bool done =
        svo_device_create_default(NULL, &device, &message) == SVO_OK && svo_device_get_info(device, &on) == SVO_OK;
    if (done)
        queue = clCreateCommandQueue(on.context, on.device, 0, NULL);
    done = queue != NULL && svo_plan_create(device, &ring, 6, &options, &plan) == SVO_OK &&
           svo_build(plan, NULL, queue, &tree, NULL) == SVO_OK &&
           svo_light_create(tree, NULL, queue, &light) == SVO_OK && draw(&on, tree, light, queue);
    if (!done)
        fprintf(stderr, "%s\n",
                device != NULL && svo_device_message(device)[0] != '\0' ? svo_device_message(device) : message.text);

    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    if (queue != NULL)
        clReleaseCommandQueue(queue);
    svo_device_destroy(&device);
    return done ? 0 : 1;
}
