/* SPDX-License-Identifier: MIT */
/*
 * The opacity of all nodes: of the leaves, then level by level. One value for a voxel, 27 samples for a brick, or six
 * opacities and covers for the faces, which are filtered where the extinctions lie at last; of a changed tree, beside
 * them. For an update what stays of the tree before is copied.
 */
#include "light/opacity.h"
#include "light/programs.h"

#include <math.h>

/* ---- what is kept ---- */

static svo_status copy_buffer(svo_i_device_work *work, const char *name, cl_mem from, uint64_t bytes, cl_mem *out)
{
    SVO_I_TRY(svo_i_work_result(work, name, bytes, out));
    return svo_i_work_copy(work, from, 0, *out, 0, bytes);
}

/* Begins to keep the nodes of a light's tree, in light->nodes. */
static svo_status begin_nodes(svo_i_device_work *work, svo_light *light)
{
    const svo_tree *tree = light->tree;
    const uint64_t count = tree->info.inner_count;
    light->nodes = svo_i_alloc_zeroed(&light->device->memory, 1, sizeof *light->nodes);
    if (light->nodes == NULL) {
        return svo_i_device_fail(light->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for kept nodes", work->function);
    }
    SVO_I_TRY(svo_i_kept_tree_read(work, tree, &light->nodes->tree));
    SVO_I_TRY(copy_buffer(work, "kept_masks", tree->buffers[SVO_TREE_CHILD_MASK], count, &light->nodes->masks));
    return copy_buffer(work, "kept_children", tree->buffers[SVO_TREE_FIRST_CHILD], count * sizeof(cl_uint),
                       &light->nodes->children);
}

/* ---- origins: kernels/light/origins.cl ---- */

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

/* The cells of the leaves that each box may have changed, for kernels/light/changed.clh: low x, y, z, high x, y, z, int
   each. The buffer belongs to the work. */
static svo_status upload_changes(svo_i_device_work *work, const svo_tree *tree, const svo_i_light_changes *changes,
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

static svo_status find_level_origins(svo_i_device_work *work, const svo_light *light, cl_mem boxes, cl_mem codes,
                                     uint32_t level)
{
    const svo_i_light_before *before = light->before;
    const svo_i_kept_nodes *old = before->light->nodes;
    svo_light_step params = svo_i_light_step(light, level);
    params.box_count = (cl_uint)before->changes.count;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(old->masks),
                                        SVO_I_ARGUMENT(old->children),
                                        SVO_I_ARGUMENT(boxes),
                                        SVO_I_ARGUMENT(codes),
                                        SVO_I_ARGUMENT(before->origins),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_origins", SVO_I_ARGUMENTS(arguments), params.count);
}

/* Finds where the nodes of a light's tree were in the tree before: light->before->origins, NULL where nothing is kept
   that fits. Needs light->nodes. */
static svo_status find_origins(svo_i_device_work *work, svo_light *light)
{
    svo_i_light_before *before = light->before;
    const uint64_t count = light->tree->info.inner_count;
    cl_mem boxes = NULL;
    cl_mem codes = NULL;
    if (before->light->nodes == NULL || !svo_i_kept_tree_is_same(&before->light->nodes->tree, &light->nodes->tree)) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_result(work, "light_origins", count * sizeof(cl_uint), &before->origins));
    SVO_I_TRY(svo_i_work_alloc(work, "light_origin_codes", count * sizeof(cl_ulong), &codes));
    SVO_I_TRY(upload_changes(work, light->tree, &before->changes, &boxes));
    for (uint32_t level = 0; level < light->params.depth; ++level) {
        SVO_I_TRY(find_level_origins(work, light, boxes, codes, level));
    }
    svo_i_work_free(work, &codes);
    svo_i_work_free(work, &boxes);
    return SVO_OK;
}

/* Those; NULL: all is made anew. */
static cl_mem origins_of(const svo_light *light)
{
    return light->before != NULL ? light->before->origins : NULL;
}

/* Copies what stays of the inner nodes' opacity, so many u16 each, where there are origins. */
static svo_status keep_nodes(svo_i_device_work *work, const svo_light *light, cl_mem from, cl_mem to, cl_uint elements)
{
    const cl_mem origins = origins_of(light);
    svo_light_step params = svo_i_light_step(light, 0);
    if (origins == NULL) {
        return SVO_OK;
    }
    params.count = (cl_uint)light->tree->info.inner_count;
    params.elements = elements;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(origins), SVO_I_ARGUMENT(from), SVO_I_ARGUMENT(to),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_keep", SVO_I_ARGUMENTS(arguments), params.count);
}

/* The same from the buffer of the light before to this one's. */
static svo_status keep_opacity(svo_i_device_work *work, const svo_light *light, cl_uint elements)
{
    const cl_mem from = origins_of(light) != NULL ? light->before->light->buffers[SVO_LIGHT_OPACITY] : NULL;
    return keep_nodes(work, light, from, light->buffers[SVO_LIGHT_OPACITY], elements);
}

/* ---- voxels: kernels/light/opacity.cl ---- */

/* The opacities of the leaves, u16 each, into a buffer from element first on. */
static svo_status make_leaves(svo_i_device_work *work, const svo_light *light, cl_mem opacities, cl_uint first)
{
    const cl_mem areas = svo_i_light_areas(light);
    svo_light_step params = svo_i_light_step(light, light->params.depth);
    params.first = first;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_COLORS]), SVO_I_ARGUMENT(areas),
                                        SVO_I_ARGUMENT(opacities), SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_leaves", SVO_I_ARGUMENTS(arguments), params.count);
}

/* A level above the leaves. */
static svo_status filter_voxels(svo_i_device_work *work, const svo_light *light, uint32_t level)
{
    const cl_mem origins = origins_of(light);
    const svo_light_step params = svo_i_light_step(light, level);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(origins), SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_voxels", SVO_I_ARGUMENTS(arguments), params.count);
}

static svo_status make_voxels(svo_i_device_work *work, svo_light *light)
{
    const cl_uint leaf_begin = (cl_uint)light->tree->info.inner_count;
    double start = svo_i_now_ms();
    SVO_I_TRY(svo_i_light_buffer(work, light, SVO_LIGHT_OPACITY));
    SVO_I_TRY(keep_opacity(work, light, 1));
    SVO_I_TRY(make_leaves(work, light, light->buffers[SVO_LIGHT_OPACITY], leaf_begin));
    SVO_I_TRY(svo_i_light_took(work, light, SVO_LIGHT_STAGE_OPACITY, start));
    start = svo_i_now_ms();
    for (uint32_t level = light->params.depth; level-- > 0;) {
        SVO_I_TRY(filter_voxels(work, light, level));
    }
    return svo_i_light_took(work, light, SVO_LIGHT_STAGE_OPACITY_FILTER, start);
}

/* ---- bricks: kernels/light/bricks.cl ---- */

svo_status svo_i_light_place(svo_i_device_work *work, const svo_light *light, cl_mem codes)
{
    for (uint32_t level = 0; level < light->params.depth; ++level) {
        const svo_light_step params = svo_i_light_step(light, level);
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_CHILD_MASK]),
                                            SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                            SVO_I_ARGUMENT(codes), SVO_I_ARGUMENT(params)};
        SVO_I_TRY(svo_i_work_launch(work, "svo_k_light_place", SVO_I_ARGUMENTS(arguments), params.count));
    }
    return SVO_OK;
}

/* The bricks of the nodes above the leaves. */
static svo_status make_deepest_bricks(svo_i_device_work *work, const svo_light *light, cl_mem codes, cl_mem leaves)
{
    const cl_mem origins = origins_of(light);
    const svo_light_step params = svo_i_light_step(light, light->params.depth - 1);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(codes),
                                        SVO_I_ARGUMENT(leaves),
                                        SVO_I_ARGUMENT(origins),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(params),
                                        SVO_I_BRICK_ROOM};
    return svo_i_light_launch_bricks(work, "svo_k_light_brick_leaves", SVO_I_ARGUMENTS(arguments), params.count);
}

/* A level above. */
static svo_status filter_bricks(svo_i_device_work *work, const svo_light *light, cl_mem codes, uint32_t level)
{
    const cl_mem origins = origins_of(light);
    const svo_light_step params = svo_i_light_step(light, level);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(codes),
                                        SVO_I_ARGUMENT(origins),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(params),
                                        SVO_I_BRICK_ROOM};
    return svo_i_light_launch_bricks(work, "svo_k_light_brick_level", SVO_I_ARGUMENTS(arguments), params.count);
}

static svo_status make_bricks(svo_i_device_work *work, svo_light *light)
{
    const svo_tree_info *tree = &light->tree->info;
    cl_mem codes = NULL;
    cl_mem leaves = NULL;
    double start = svo_i_now_ms();
    SVO_I_TRY(svo_i_light_buffer(work, light, SVO_LIGHT_OPACITY));
    SVO_I_TRY(svo_i_work_alloc(work, "light_codes", tree->inner_count * sizeof(cl_ulong), &codes));
    SVO_I_TRY(svo_i_work_alloc(work, "light_leaves", tree->leaf_count * sizeof(cl_ushort), &leaves));
    SVO_I_TRY(keep_opacity(work, light, SVO_BRICK_SAMPLES));
    SVO_I_TRY(svo_i_light_place(work, light, codes));
    SVO_I_TRY(make_leaves(work, light, leaves, 0));
    SVO_I_TRY(make_deepest_bricks(work, light, codes, leaves));
    SVO_I_TRY(svo_i_light_took(work, light, SVO_LIGHT_STAGE_OPACITY, start));
    start = svo_i_now_ms();
    for (uint32_t level = tree->depth - 1; level-- > 0;) {
        SVO_I_TRY(filter_bricks(work, light, codes, level));
    }
    return svo_i_light_took(work, light, SVO_LIGHT_STAGE_OPACITY_FILTER, start);
}

/* ---- faces, from nothing: kernels/light/faces.cl ---- */

static svo_status make_face_leaves(svo_i_device_work *work, const svo_light *light)
{
    const cl_mem areas = svo_i_light_areas(light);
    const svo_light_step params = svo_i_light_step(light, light->params.depth);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_COLORS]), SVO_I_ARGUMENT(areas),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_COVER]), SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_face_leaves", SVO_I_ARGUMENTS(arguments), params.count);
}

/* A level above the leaves. */
static svo_status filter_faces(svo_i_device_work *work, const svo_light *light, uint32_t level)
{
    const svo_light_step params = svo_i_light_step(light, level);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_COVER]), SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_face_level", SVO_I_ARGUMENTS(arguments), params.count);
}

static svo_status take_logarithms(svo_i_device_work *work, const svo_light *light)
{
    svo_light_step params = svo_i_light_step(light, 0);
    params.count = (cl_uint)light->tree->info.node_count;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]), SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_face_extinctions", SVO_I_ARGUMENTS(arguments),
                             6 * light->tree->info.node_count);
}

/* The opacities of inner nodes, for the next update. */
static svo_status keep_opacities(svo_i_device_work *work, const svo_light *light)
{
    const uint64_t bytes = light->tree->info.inner_count * 6 * sizeof(cl_ushort);
    return light->nodes != NULL
               ? svo_i_work_copy(work, light->buffers[SVO_LIGHT_OPACITY], 0, light->nodes->opacities, 0, bytes)
               : SVO_OK;
}

static svo_status filter_all_faces(svo_i_device_work *work, const svo_light *light)
{
    for (uint32_t level = light->params.depth; level-- > 0;) {
        SVO_I_TRY(filter_faces(work, light, level));
    }
    SVO_I_TRY(keep_opacities(work, light));
    return take_logarithms(work, light);
}

/* ---- faces of a changed tree ---- */

static svo_status make_face_leaves_again(svo_i_device_work *work, const svo_light *light)
{
    const cl_mem areas = svo_i_light_areas(light);
    const cl_mem origins = origins_of(light);
    const svo_light *old = light->before->light;
    const svo_light_step params = svo_i_light_step(light, light->params.depth - 1);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(origins),
                                        SVO_I_ARGUMENT(old->nodes->children),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_COLORS]),
                                        SVO_I_ARGUMENT(areas),
                                        SVO_I_ARGUMENT(old->buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(old->buffers[SVO_LIGHT_COVER]),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_COVER]),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_face_leaves_again", SVO_I_ARGUMENTS(arguments), params.count);
}

static svo_status filter_faces_again(svo_i_device_work *work, const svo_light *light, uint32_t level)
{
    const cl_mem areas = svo_i_light_areas(light);
    const cl_mem origins = origins_of(light);
    const svo_light_step params = svo_i_light_step(light, level);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(origins),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_COLORS]),
                                        SVO_I_ARGUMENT(areas),
                                        SVO_I_ARGUMENT(light->nodes->opacities),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_COVER]),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_face_level_again", SVO_I_ARGUMENTS(arguments), params.count);
}

static svo_status filter_all_faces_again(svo_i_device_work *work, const svo_light *light)
{
    const svo_light *old = light->before->light;
    SVO_I_TRY(keep_opacity(work, light, 6));
    SVO_I_TRY(keep_nodes(work, light, old->buffers[SVO_LIGHT_COVER], light->buffers[SVO_LIGHT_COVER], 6));
    SVO_I_TRY(keep_nodes(work, light, old->nodes->opacities, light->nodes->opacities, 6));
    for (uint32_t level = light->params.depth; level-- > 0;) {
        SVO_I_TRY(filter_faces_again(work, light, level));
    }
    return SVO_OK;
}

static svo_status make_face_buffers(svo_i_device_work *work, svo_light *light)
{
    const uint64_t bytes = light->tree->info.inner_count * 6 * sizeof(cl_ushort);
    SVO_I_TRY(svo_i_light_buffer(work, light, SVO_LIGHT_OPACITY));
    SVO_I_TRY(svo_i_light_buffer(work, light, SVO_LIGHT_COVER));
    return light->nodes != NULL ? svo_i_work_result(work, "kept_opacities", bytes, &light->nodes->opacities) : SVO_OK;
}

static svo_status make_faces(svo_i_device_work *work, svo_light *light)
{
    const bool again = origins_of(light) != NULL;
    double start = svo_i_now_ms();
    SVO_I_TRY(make_face_buffers(work, light));
    SVO_I_TRY(again ? make_face_leaves_again(work, light) : make_face_leaves(work, light));
    SVO_I_TRY(svo_i_light_took(work, light, SVO_LIGHT_STAGE_OPACITY, start));
    start = svo_i_now_ms();
    SVO_I_TRY(again ? filter_all_faces_again(work, light) : filter_all_faces(work, light));
    return svo_i_light_took(work, light, SVO_LIGHT_STAGE_OPACITY_FILTER, start);
}

/* ---- all forms ---- */

svo_status svo_i_light_opacity(svo_i_device_work *work, svo_light *light)
{
    if (light->before != NULL && light->before->light->setup.asked.updatable != 0) {
        SVO_I_TRY(begin_nodes(work, light));
        SVO_I_TRY(svo_i_work_use(work, &svo_i_program_light, svo_i_light_defines(light)));
        SVO_I_TRY(find_origins(work, light));
    }
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_light, svo_i_light_defines(light)));
    switch (light->info.form) {
    case SVO_LIGHT_BRICKS:
        return make_bricks(work, light);
    case SVO_LIGHT_VOXELS:
        return make_voxels(work, light);
    default:
        return make_faces(work, light);
    }
}
