/* SPDX-License-Identifier: MIT */
/* Makes the grid of two levels from a tree on the host, and launches the kernel. */
#include "bench/grid_rays.h"

#include <stdlib.h>
#include <string.h>

#include "reference/oracle.h"
#include "support/info_of.h"
#include "support/input.h"
#include "svocl/nodes.h"

#define BRICK_LOG2  3u /* cells per axis of a brick, unless the tree has fewer */
#define GROUP_ITEMS 64u
#define BRICKS_MAX  (UINT64_C(1) << 22) /* the kernel's indices of cells have 32 bits */

extern const char grid_rays_source[];

struct grid_rays {
    const session *opened;
    svo_tree_info info;
    uint32_t grid_log2, brick_log2;
    uint64_t cell_bytes, brick_bytes;
    cl_program program;
    cl_kernel kernel;
    cl_mem bricks, cells;
};

/* What is uploaded. */
typedef struct grid_levels {
    uint32_t *bricks; /* by x, then y, then z */
    uint32_t *cells; /* by brick, then Morton code; one more at the end */
    uint64_t brick_count;
} grid_levels;

/* Leaves are in Morton order, so each brick's are side by side. */
static uint64_t count_bricks(const uint64_t *codes, uint64_t leaf_count, uint32_t shift)
{
    uint64_t count = 0;
    for (uint64_t i = 0; i < leaf_count; ++i) {
        count += i == 0 || codes[i] >> shift != codes[i - 1] >> shift;
    }
    return count;
}

/* A cell without a leaf begins where the next one does. */
static void fill_levels(const grid_rays *grid, const uint64_t *codes, const uint32_t *list_begin, grid_levels *levels)
{
    const uint32_t shift = 3 * grid->brick_log2;
    const uint64_t inside = (UINT64_C(1) << shift) - 1;
    const uint64_t leaf_count = grid->info.leaf_count;
    uint64_t brick = 0;
    uint64_t next = 0; /* the first cell that has no number yet */
    for (uint64_t i = 0; i < leaf_count; ++i) {
        brick += i > 0 && codes[i] >> shift != codes[i - 1] >> shift;
        const uint64_t place = (brick << shift) + (codes[i] & inside);
        for (; next <= place; ++next) {
            levels->cells[next] = list_begin[i];
        }
        uint32_t at[3];
        svo_code_to_cell(codes[i] >> shift, at);
        const size_t row = ((size_t)at[2] << grid->grid_log2) + at[1];
        levels->bricks[(row << grid->grid_log2) + at[0]] = (uint32_t)brick;
    }
    for (; next <= levels->brick_count << shift; ++next) {
        levels->cells[next] = list_begin[leaf_count];
    }
}

static bool make_levels(grid_rays *grid, const svo_tree_arrays *arrays, grid_levels *levels)
{
    const svo_tree_info *info = &grid->info;
    uint64_t *codes = malloc((size_t)info->leaf_count * sizeof *codes + 1);
    bool worked =
        codes != NULL && oracle_leaf_codes(arrays->child_mask, info->inner_count, info->depth, info->leaf_count, codes);
    if (worked) {
        levels->brick_count = count_bricks(codes, info->leaf_count, 3 * grid->brick_log2);
        worked = levels->brick_count <= BRICKS_MAX;
    }
    if (worked) {
        grid->brick_bytes = sizeof *levels->bricks << 3 * grid->grid_log2;
        grid->cell_bytes = ((levels->brick_count << 3 * grid->brick_log2) + 1) * sizeof *levels->cells;
        levels->bricks = malloc((size_t)grid->brick_bytes);
        levels->cells = malloc((size_t)grid->cell_bytes);
        worked = levels->bricks != NULL && levels->cells != NULL;
    }
    if (worked) {
        memset(levels->bricks, 0xff, (size_t)grid->brick_bytes); /* NO_BRICK of the kernel */
        fill_levels(grid, codes, arrays->list_begin, levels);
    }
    free(codes);
    return worked;
}

static cl_mem upload(const grid_rays *grid, void *numbers, uint64_t bytes)
{
    return clCreateBuffer(info_of_device(grid->opened->device).context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR,
                          (size_t)bytes, numbers, NULL);
}

static bool make_buffers(grid_rays *grid, const svo_tree *tree)
{
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    grid_levels levels = {NULL, NULL, 0};
    (void)svo_tree_get_arrays(tree, &arrays);
    if (make_levels(grid, &arrays, &levels)) {
        grid->bricks = upload(grid, levels.bricks, grid->brick_bytes);
        grid->cells = upload(grid, levels.cells, grid->cell_bytes);
    }
    free(levels.bricks);
    free(levels.cells);
    return grid->bricks != NULL && grid->cells != NULL;
}

static bool compile(grid_rays *grid)
{
    const char *source = grid_rays_source;
    const svo_device_info on = info_of_device(grid->opened->device);
    grid->program = clCreateProgramWithSource(on.context, 1, &source, NULL, NULL);
    if (grid->program == NULL || clBuildProgram(grid->program, 1, &on.device, NULL, NULL, NULL) != CL_SUCCESS) {
        return false;
    }
    grid->kernel = clCreateKernel(grid->program, "trace_grid", NULL);
    return grid->kernel != NULL;
}

static bool set_arguments(grid_rays *grid, const svo_tree *tree)
{
    const svo_tree_info *info = &grid->info;
    const cl_mem buffers[5] = {grid->bricks, grid->cells, svo_tree_get_buffer(tree, SVO_TREE_LIST),
                               svo_tree_get_buffer(tree, SVO_TREE_VERTICES),
                               svo_tree_get_buffer(tree, SVO_TREE_INDICES)};
    const cl_float4 world = {
        {(float)info->origin[0], (float)info->origin[1], (float)info->origin[2], (float)info->scale}};
    const cl_uint4 logs = {{grid->grid_log2, grid->brick_log2, info->snap_bits - info->depth, 0}};
    bool worked = true;
    for (cl_uint i = 0; i < 5 && worked; ++i) {
        worked = clSetKernelArg(grid->kernel, i, sizeof buffers[i], (const void *)&buffers[i]) == CL_SUCCESS;
    }
    return worked && clSetKernelArg(grid->kernel, 7, sizeof world, &world) == CL_SUCCESS &&
           clSetKernelArg(grid->kernel, 8, sizeof logs, &logs) == CL_SUCCESS;
}

grid_rays *grid_rays_create(const session *opened, const svo_tree *tree)
{
    grid_rays *made = calloc(1, sizeof *made);
    if (made == NULL) {
        return NULL;
    }
    made->opened = opened;
    made->info.struct_size = sizeof made->info;
    (void)svo_tree_get_info(tree, &made->info);
    made->brick_log2 = made->info.depth < BRICK_LOG2 ? made->info.depth : BRICK_LOG2;
    made->grid_log2 = made->info.depth - made->brick_log2;
    if (made->info.depth > GRID_RAYS_DEPTH_MAX || !make_buffers(made, tree) || !compile(made) ||
        !set_arguments(made, tree)) {
        grid_rays_destroy(&made);
    }
    return made;
}

void grid_rays_destroy(grid_rays **grid)
{
    grid_rays *old = *grid;
    if (old == NULL) {
        return;
    }
    if (old->bricks != NULL) {
        clReleaseMemObject(old->bricks);
    }
    if (old->cells != NULL) {
        clReleaseMemObject(old->cells);
    }
    if (old->kernel != NULL) {
        clReleaseKernel(old->kernel);
    }
    if (old->program != NULL) {
        clReleaseProgram(old->program);
    }
    free(old);
    *grid = NULL;
}

uint64_t grid_rays_cell_bytes(const grid_rays *grid)
{
    return grid->brick_bytes + grid->cell_bytes;
}

uint64_t grid_rays_bytes(const grid_rays *grid)
{
    const svo_tree_info *info = &grid->info;
    const uint64_t numbers = info->list_count + 3 * info->vertex_count + 3 * info->list_triangle_count;
    return grid_rays_cell_bytes(grid) + numbers * sizeof(uint32_t);
}

double grid_rays_trace(const grid_rays *grid, cl_mem rays, cl_mem hits, size_t ray_count)
{
    cl_command_queue queue = grid->opened->queue;
    const cl_uint count = (cl_uint)ray_count;
    const size_t group = GROUP_ITEMS;
    const size_t size = (ray_count + group - 1) / group * group;
    const double start_ms = input_now_ms();
    const bool worked =
        clSetKernelArg(grid->kernel, 5, sizeof rays, (const void *)&rays) == CL_SUCCESS &&
        clSetKernelArg(grid->kernel, 6, sizeof hits, (const void *)&hits) == CL_SUCCESS &&
        clSetKernelArg(grid->kernel, 9, sizeof count, &count) == CL_SUCCESS &&
        clEnqueueNDRangeKernel(queue, grid->kernel, 1, NULL, &size, &group, 0, NULL, NULL) == CL_SUCCESS &&
        clFinish(queue) == CL_SUCCESS;
    return worked ? input_now_ms() - start_ms : -1.0;
}
