/* SPDX-License-Identifier: MIT */
/* Smaller forms of a tree: their bytes, a file of one, and rays through each in the program's own kernel. */
#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "svocl/io.h"
#include "svocl/svocl.h"

#define DEPTH    7
#define EDGE     128 /* of the grid: a voxel is one unit wide */
#define HALF     64
#define TERRACES 16u
#define QUADS    5u /* of a terrace: four walls and a floor on top */
#define RAYS     4096u /* 64 x 64 */
#define FILE_OUT "pyramid.svo"

/* The same text for a tree and for every form of it; the compiler's options tell them apart. */
static const char kernel_source[] =
    "__kernel void look(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global svo_voxel_hit *hits)\n"
    "{\n"
    "    SVO_TREE_MAKE(tree);\n"
    "    const svo_ray ray = rays[get_global_id(0)];\n"
    "    svo_voxel_hit hit;\n"
    "    svo_trace_voxel(&tree, &ray, 0.0f, &hit);\n"
    "    hits[get_global_id(0)] = hit;\n"
    "}\n";

typedef struct work {
    svo_device *device;
    svo_device_info on;
    cl_command_queue queue;
    svo_tree *tree;
    cl_mem rays, hits; /* buffers for the kernel */
    svo_voxel_hit expected[RAYS]; /* those of the tree */
    svo_message message;
} work;

/* ---- mesh ---- */

/* Terraces, each four units narrower than the one below. All faces are at odd coordinates, so that the two layers of
   voxels that a closed coverage gives them are blocks of eight, which merge. */
static void make_pyramid(float *positions, uint32_t *indices)
{
    static const uint8_t quads[QUADS][4] = {{0, 1, 5, 4}, {1, 3, 7, 5}, {3, 2, 6, 7}, {2, 0, 4, 6}, {4, 5, 7, 6}};
    for (uint32_t k = 0; k < TERRACES * 8; ++k) {
        const int terrace = (int)(k / 8);
        float *position = positions + (size_t)3 * k;
        const int half = HALF - 3 - 4 * terrace + (terrace == TERRACES - 1 ? 2 : 0);
        position[0] = (float)((k & 1) != 0 ? half : -half);
        position[1] = (float)(4 * (terrace + ((k & 4) != 0 ? 1 : 0)) + 1);
        position[2] = (float)((k & 2) != 0 ? half : -half);
    }
    for (uint32_t k = 0; k < TERRACES * QUADS; ++k) {
        const uint8_t *quad = quads[k % QUADS];
        const uint32_t first = k / QUADS * 8;
        const uint32_t corners[6] = {first + quad[0], first + quad[1], first + quad[2],
                                     first + quad[0], first + quad[2], first + quad[3]};
        memcpy(indices + (size_t)6 * k, corners, sizeof corners);
    }
}

static bool build_pyramid(work *state)
{
    float positions[TERRACES * 8 * 3];
    uint32_t indices[TERRACES * QUADS * 6];
    make_pyramid(positions, indices);
    const svo_mesh mesh = {.struct_size = sizeof(svo_mesh),
                           .positions = positions,
                           .vertex_count = (size_t)TERRACES * 8,
                           .indices = indices,
                           .triangle_count = (size_t)TERRACES * QUADS * 2};
    const svo_plan_options options = {.struct_size = sizeof options,
                                      .need = SVO_NEED_NONE, /* nodes alone; payload has its own bytes */
                                      .coverage = SVO_COVERAGE_CLOSED,
                                      .origin = {-HALF, 0, -HALF},
                                      .edge = EDGE};
    svo_plan *plan = NULL;
    const bool done = svo_plan_create(state->device, &mesh, DEPTH, &options, &plan) == SVO_OK &&
                      svo_build(plan, NULL, state->queue, &state->tree, NULL) == SVO_OK;
    svo_plan_destroy(&plan);
    return done;
}

/* ---- rays ---- */

/* Parallel rays from above, a little slanted; some pass beside the pyramid. */
static bool make_rays(work *state)
{
    const cl_context context = state->on.context;
    svo_ray *rays = calloc(RAYS, sizeof *rays);
    if (rays == NULL)
        return false;
    for (uint32_t i = 0; i < RAYS; ++i) {
        const uint32_t row = i / 64;
        rays[i] = (svo_ray){.origin = {2.3F * (float)(i % 64) - 100, 100, 2.3F * (float)row - 90},
                            .direction = {0.31F, -1, 0.17F},
                            .t_max = INFINITY};
    }
    state->rays = clCreateBuffer(context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, RAYS * sizeof *rays, rays, NULL);
    state->hits = clCreateBuffer(context, CL_MEM_WRITE_ONLY, sizeof state->expected, NULL, NULL);
    const bool done = state->rays != NULL && state->hits != NULL &&
                      svo_trace_voxels(svo_tree_target(state->tree), svo_in_host(rays), svo_in_host(state->expected),
                                       RAYS, 0, 0, &(svo_submit){.queue = state->queue}) == SVO_OK;
    free(rays);
    return done;
}

/* svocl's source comes before the program's. Forms differ in the options, so each has its own program. */
static cl_kernel make_kernel(const work *state, svo_compact *compact)
{
    const char *sources[2] = {svo_kernel_source(svo_compact_target(compact)), kernel_source};
    cl_program program = clCreateProgramWithSource(state->on.context, 2, sources, NULL, NULL);
    cl_kernel kernel = NULL;
    if (program != NULL && clBuildProgram(program, 1, &state->on.device,
                                          svo_kernel_options(svo_compact_target(compact)), NULL, NULL) == CL_SUCCESS)
        kernel = clCreateKernel(program, "look", NULL);
    if (program != NULL)
        clReleaseProgram(program);
    if (kernel != NULL &&
        (svo_kernel_set_arguments(svo_compact_target(compact), kernel, 0) != SVO_OK ||
         clSetKernelArg(kernel, SVO_COMPACT_ARGUMENTS, sizeof state->rays, &state->rays) != CL_SUCCESS ||
         clSetKernelArg(kernel, SVO_COMPACT_ARGUMENTS + 1, sizeof state->hits, &state->hits) != CL_SUCCESS)) {
        clReleaseKernel(kernel);
        kernel = NULL;
    }
    return kernel;
}

/* Places differ by form, and a merged leaf lies higher. t and the face are the tree's, bit for bit. */
static void compare(const work *state, const svo_voxel_hit *hits, unsigned *met, unsigned *different)
{
    for (uint32_t i = 0; i < RAYS; ++i) {
        const svo_voxel_hit *other = &state->expected[i];
        *met += isfinite(hits[i].t) ? 1 : 0;
        *different += hits[i].t != other->t || hits[i].face != other->face || hits[i].level > other->level;
    }
}

static bool trace(work *state, svo_compact *compact)
{
    const size_t count = RAYS;
    unsigned met = 0;
    unsigned different = 0;
    svo_voxel_hit *hits = calloc(RAYS, sizeof *hits);
    cl_kernel kernel = make_kernel(state, compact);
    const bool done =
        hits != NULL && kernel != NULL &&
        clEnqueueNDRangeKernel(state->queue, kernel, 1, NULL, &count, NULL, 0, NULL, NULL) == CL_SUCCESS &&
        clEnqueueReadBuffer(state->queue, state->hits, CL_TRUE, 0, RAYS * sizeof *hits, hits, 0, NULL, NULL) ==
            CL_SUCCESS;
    if (done) {
        compare(state, hits, &met, &different);
        printf("; %u rays of %u hit, %u of them not as in the tree\n", met, RAYS, different);
    }
    if (kernel != NULL)
        clReleaseKernel(kernel);
    free(hits);
    return done && different == 0;
}

/* ---- forms ---- */

static void print_bytes(const char *name, uint64_t leaves, uint64_t voxels, uint64_t bytes)
{
    printf("%-22s %6" PRIu64 " leaves for %" PRIu64 " voxels, %6" PRIu64 " bytes, %.3f a voxel", name, leaves, voxels,
           bytes, (double)bytes / (double)voxels);
}

static bool print_tree(const work *state)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    if (svo_tree_get_info(state->tree, &info) != SVO_OK)
        return false;
    /* A child mask and the index of the first child for each inner node. */
    print_bytes("built", info.leaf_count, info.leaf_count, 5 * info.inner_count);
    putchar('\n');
    return true;
}

static bool show(work *state, svo_compact *compact, const char *name)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    if (svo_compact_get_info(compact, &info) != SVO_OK)
        return false;
    print_bytes(name, info.leaf_count, info.voxel_count, info.total_bytes);
    return trace(state, compact);
}

static bool show_form(work *state, svo_form form, bool minimize)
{
    const svo_compact_options options = {.struct_size = sizeof options, .form = form, .minimize = minimize};
    char name[32];
    svo_compact *compact = NULL;
    snprintf(name, sizeof name, "%s%s", svo_name(SVO_NAME_FORM, form), minimize ? ", merged" : "");
    const bool done = svo_compact_create(state->device, state->tree, &options, state->queue, &compact) == SVO_OK &&
                      show(state, compact, name);
    svo_compact_destroy(&compact);
    return done;
}

/* Writes the form of shared subtrees to a file; what is read has the same hash and goes to the device again. */
static bool show_file(work *state)
{
    const svo_compact_options options = {.struct_size = sizeof options, .form = SVO_FORM_SHARED};
    char written[SVO_HASH_TEXT_BYTES];
    char read[SVO_HASH_TEXT_BYTES];
    svo_compact *compact = NULL;
    svo_compact *loaded = NULL;
    bool done = svo_compact_create(state->device, state->tree, &options, state->queue, &compact) == SVO_OK &&
                svo_compact_download(compact, state->queue) == SVO_OK && svo_compact_hash(compact, written) == SVO_OK &&
                svo_compact_save(compact, svo_to_path(FILE_OUT), NULL, &state->message) == SVO_OK;
    done = done && svo_compact_load(svo_from_path(FILE_OUT), NULL, &loaded, &state->message) == SVO_OK &&
           svo_compact_hash(loaded, read) == SVO_OK && strcmp(written, read) == 0 &&
           svo_compact_upload(loaded, state->device, state->queue) == SVO_OK && show(state, loaded, FILE_OUT);
    svo_compact_destroy(&loaded);
    svo_compact_destroy(&compact);
    return done;
}

static bool run(work *state)
{
    state->queue = clCreateCommandQueue(state->on.context, state->on.device, 0, NULL);
    bool done = state->queue != NULL && build_pyramid(state) && make_rays(state) && print_tree(state);
    for (int form = 0; form < SVO_FORM_COUNT && done; ++form) {
        done = show_form(state, (svo_form)form, false);
    }
    return done && show_form(state, SVO_FORM_DESCRIPTOR, true) && show_file(state);
}

int main(void)
{
    static work state = {.on = SVO_DEVICE_INFO_INIT};
    const bool done = svo_device_create_default(NULL, &state.device, &state.message) == SVO_OK &&
                      svo_device_get_info(state.device, &state.on) == SVO_OK && run(&state);
    if (!done) {
        const char *text = state.message.text;
        if (text[0] == '\0' && state.device != NULL)
            text = svo_device_message(state.device);
        fprintf(stderr, "%s\n", text[0] != '\0' ? text : "an OpenCL call of the program failed, or hits differ");
    }
    if (state.hits != NULL)
        clReleaseMemObject(state.hits);
    if (state.rays != NULL)
        clReleaseMemObject(state.rays);
    svo_tree_destroy(&state.tree);
    if (state.queue != NULL)
        clReleaseCommandQueue(state.queue);
    svo_device_destroy(&state.device);
    return done ? 0 : 1;
}
