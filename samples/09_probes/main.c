/* SPDX-License-Identifier: MIT */
/* Rays through light field probes in your own kernel: a room with a block in it, drawn with letters. */
#include <stdbool.h>
#include <stdio.h>

#include "svocl/svocl.h"

#define WIDTH  72u
#define HEIGHT 30u

/* The program's kernel: how far the surfaces are that probes saw. One work-item per letter. */
static const char kernel_source[] =
    "__kernel void look(SVO_PROBES_PARAMETERS, __global uchar *picture, uint width, uint height)\n"
    "{\n"
    "    SVO_PROBES_MAKE(probes);\n"
    "    const uint x = get_global_id(0);\n"
    "    const uint y = get_global_id(1);\n"
    "    svo_probe_hit hit;\n"
    "    svo_ray ray;\n"
    "    ray.origin[0] = 4.5f;\n"
    "    ray.origin[1] = 5.5f;\n"
    "    ray.origin[2] = 0.25f;\n"
    "    ray.direction[0] = ((float)x + 0.5f) / (float)width * 2.0f - 1.0f;\n"
    "    ray.direction[1] = 0.7f - ((float)y + 0.5f) / (float)height * 1.9f;\n"
    "    ray.direction[2] = 1.0f;\n"
    "    ray.t_min = 0.0f;\n"
    "    ray.t_max = INFINITY;\n"
    "    const uint state = svo_trace_probes(&probes, &ray, 1.0f, &hit);\n"
    "    picture[y * width + x] = state == SVO_PROBE_HIT ? (uchar)min(hit.t / 8.0f * 9.0f, 8.0f)\n"
    "                                                    : state == SVO_PROBE_MISS ? 9 : 10;\n"
    "}\n";

/* Twelve triangles that face outwards, or inwards: probes must not see walls from behind. */
static void make_box(const float corners[2][3], bool inwards, float *positions, uint32_t *indices)
{
    static const uint32_t faces[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                       2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    for (uint32_t i = 0; i < 8; ++i)
        for (uint32_t axis = 0; axis < 3; ++axis)
            positions[3 * i + axis] = corners[i >> axis & 1][axis];
    for (uint32_t i = 0; i < 36; ++i)
        indices[i] = faces[inwards ? 35 - i : i];
}

/* svocl's source comes before the program's, and the probes' arguments come before the kernel's own. */
static cl_kernel make_kernel(const svo_device_info *on, svo_probes *probes, cl_mem picture)
{
    const char *sources[2] = {svo_kernel_source(svo_probes_target(probes)), kernel_source};
    const cl_uint width = WIDTH;
    const cl_uint height = HEIGHT;
    cl_program program = clCreateProgramWithSource(on->context, 2, sources, NULL, NULL);
    cl_kernel kernel = NULL;
    if (program != NULL && clBuildProgram(program, 1, &on->device, svo_kernel_options(svo_probes_target(probes)), NULL,
                                          NULL) == CL_SUCCESS)
        kernel = clCreateKernel(program, "look", NULL);
    if (kernel != NULL &&
        (svo_kernel_set_arguments(svo_probes_target(probes), kernel, 0) != SVO_OK ||
         clSetKernelArg(kernel, SVO_PROBES_ARGUMENTS, sizeof picture, (const void *)&picture) != CL_SUCCESS ||
         clSetKernelArg(kernel, SVO_PROBES_ARGUMENTS + 1, sizeof width, &width) != CL_SUCCESS ||
         clSetKernelArg(kernel, SVO_PROBES_ARGUMENTS + 2, sizeof height, &height) != CL_SUCCESS)) {
        clReleaseKernel(kernel);
        kernel = NULL;
    }
    if (program != NULL)
        clReleaseProgram(program);
    return kernel;
}

static void print_picture(const unsigned char *picture)
{
    unsigned counts[3] = {0};
    for (unsigned y = 0; y < HEIGHT; ++y) {
        for (unsigned x = 0; x < WIDTH; ++x) {
            const unsigned char depth = picture[y * WIDTH + x];
            putchar("@%#*+=-:. ?"[depth < 11 ? depth : 10]);
            ++counts[depth < 7 ? 0 : depth < 10 ? 1 : 2];
        }
        putchar('\n');
    }
    printf("%u letters in front, %u behind, %u unknown\n", counts[0], counts[1], counts[2]);
}

static bool draw(const svo_device_info *on, svo_probes *probes, cl_command_queue queue)
{
    unsigned char pixels[WIDTH * HEIGHT];
    const size_t size[2] = {WIDTH, HEIGHT};
    const size_t group[2] = {WIDTH, 1};
    cl_mem picture = clCreateBuffer(on->context, CL_MEM_WRITE_ONLY, sizeof pixels, NULL, NULL);
    cl_kernel kernel = picture != NULL ? make_kernel(on, probes, picture) : NULL;
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
    static float positions[48];
    static uint32_t indices[72];
    const svo_mesh room = {.struct_size = sizeof(svo_mesh),
                           .positions = positions,
                           .vertex_count = 16,
                           .indices = indices,
                           .triangle_count = 24};
    const svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_RAYS};
    svo_probe_options grid = {.struct_size = sizeof grid, .counts = {3, 3, 3}, .resolution = 256};
    svo_message message = {"an OpenCL call of the program failed"};
    svo_device *device = NULL;
    svo_device_info on = SVO_DEVICE_INFO_INIT;
    cl_command_queue queue = NULL;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    svo_probes *probes = NULL;

    make_box((const float[2][3]){{0, 0, 0}, {8, 8, 8}}, true, positions, indices);
    make_box((const float[2][3]){{2.5F, 0, 4}, {5, 3.5F, 5.5F}}, false, positions + 24, indices + 36);
    for (int i = 36; i < 72; ++i) /* the block's corners stand behind the room's */
        indices[i] += 8;
    bool done =
        svo_device_create_default(NULL, &device, &message) == SVO_OK && svo_device_get_info(device, &on) == SVO_OK;
    if (done)
        queue = clCreateCommandQueue(on.context, on.device, 0, NULL);
    done = queue != NULL && svo_plan_create(device, &room, 6, &options, &plan) == SVO_OK &&
           svo_build(plan, NULL, queue, &tree, NULL) == SVO_OK;
    grid.tree = tree;
    done = done && svo_probes_create(&grid, queue, &probes) == SVO_OK && draw(&on, probes, queue);
    if (!done)
        fprintf(stderr, "%s\n",
                device != NULL && svo_device_message(device)[0] != '\0' ? svo_device_message(device) : message.text);

    svo_probes_destroy(&probes);
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    if (queue != NULL)
        clReleaseCommandQueue(queue);
    svo_device_destroy(&device);
    return done ? 0 : 1;
}
