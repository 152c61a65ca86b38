/* SPDX-License-Identifier: MIT */
#include "light/changes.h"

#include <math.h>

/* The cell of a coordinate; one far outside the grid stays outside. */
static cl_int cell_of(const svo_grid *grid, int axis, double coordinate)
{
    const double cells = (double)(UINT32_C(1) << grid->depth);
    const double cell = floor((coordinate - grid->origin[axis]) / svo_grid_cell_edge(grid, grid->depth));
    return (cl_int)fmin(fmax(cell, -2), cells + 1);
}

/* One cell wider: triangles are snapped, and closed leaves have those that touch them. */
static void find_cells(const svo_grid *grid, const svo_box *box, cl_int *cells)
{
    for (int axis = 0; axis < 3; ++axis) {
        cells[axis] = cell_of(grid, axis, box->low[axis]) - 1;
        cells[3 + axis] = cell_of(grid, axis, box->high[axis]) + 1;
    }
}

svo_status svo_i_changes_upload(svo_i_device_work *work, const svo_tree *tree, const svo_i_light_changes *changes,
                                cl_mem *cells)
{
    const size_t bytes = changes->count * 6 * sizeof(cl_int);
    svo_grid grid = {.depth = 0};
    SVO_I_TRY(svo_tree_get_grid(tree, &grid));
    cl_int *found = svo_i_alloc(&work->device->memory, bytes + 1);
    if (found == NULL) {
        return svo_i_device_fail(work->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu boxes", work->function,
                                 changes->count);
    }
    for (size_t i = 0; i < changes->count; ++i) {
        find_cells(&grid, &changes->boxes[i], found + 6 * i);
    }
    svo_status status = svo_i_work_alloc(work, "changed_cells", bytes, cells);
    if (status == SVO_OK) {
        status = svo_i_work_write(work, *cells, found, bytes);
    }
    svo_i_free(found);
    return status;
}
