/* SPDX-License-Identifier: MIT */
/*
 * An edit's nodes on a device, for pictures without a tree. Nodes never change, so after a step only those that it
 * wrote go there; all do after a collection, which moves them, and where the buffer gets too small.
 *
 * Nodes of the edit begin at multiples of their width from its corner on. The grid of the pictures begins at a multiple
 * of an eighth of its own width: the few nodes above that are made anew where they have to be, the others are shared.
 */
#include <string.h>

#include "core/device.h"
#include "core/staging.h"
#include "core/struct_size.h"
#include "core/voxel_list.h"
#include "edit/combine.h"
#include "edit/handle.h"
#include "edit/tree.h"
#include "rays/camera.h"
#include "rays/picture.h"
#include "rays/target.h"
#include "voxels/build.h"

#define UNIT_BYTES  8u
#define UNITS_MAX   0x80000000u /* places count words in 32 bits */
#define DEPTH_MIN   SVO_I_EDIT_BLOCK_LEVEL
#define GRAIN_LOG2  3u /* the grid begins at multiples of 2^-3 of its width */
#define SPARE_PARTS 4u /* the buffer has a quarter and a segment more than is needed */

struct svo_edit_mirror {
    svo_device *device;
    svo_edit *edit;
    cl_mem units; /* the store's, from 0 on; unit 0 has the root's alpha. NULL: none yet */
    cl_mem root; /* its unit and level */
    uint64_t unit_room; /* of the buffer */
    uint32_t unit_count; /* that are there */
    uint64_t collections; /* of the edit when they went there */
    svo_i_edit_ref version; /* the edit's root then */
    bool is_current; /* the last update succeeded */
    svo_voxels_info list; /* the grid's corner as low, and its depth */
    svo_i_voxel_grid grid;
    svo_i_edit_ref node; /* what root says */
    svo_edit_mirror_info info;
};

static const char create_name[] = "svo_edit_mirror_create";
static const char update_name[] = "svo_edit_mirror_update";

/* ---- the grid ---- */

/* Whether the voxels fit a grid of that depth, and where it then begins. */
static bool fits(const svo_edit_mirror *mirror, svo_i_edit_ref root, uint32_t depth, uint32_t base[3])
{
    const uint32_t grain_log2 = depth > DEPTH_MIN + GRAIN_LOG2 ? depth - GRAIN_LOG2 : DEPTH_MIN;
    uint32_t low[3];
    uint32_t high[3];
    svo_i_edit_bounds(&mirror->edit->store, root, grain_log2, low, high); /* they are multiples of it, as the grid's */
    for (int axis = 0; axis < 3; ++axis) {
        if (high[axis] - low[axis] > 1u << depth) {
            return false;
        }
    }
    memcpy(base, low, sizeof low);
    return true;
}

/* The least grid: base is its least cell. The edit has voxels. From the largest one down, since coarse bounds of few
   cubes are found soon. */
static svo_status find_grid(svo_edit_mirror *mirror, svo_i_edit_ref root, uint32_t base[3], uint32_t *depth)
{
    uint32_t low[3];
    uint32_t high[3];
    uint32_t found = SVO_DEPTH_MAX + 1;
    while (found > DEPTH_MIN && fits(mirror, root, found - 1, base)) {
        --found;
    }
    *depth = found;
    if (found <= SVO_DEPTH_MAX) {
        return SVO_OK;
    }
    svo_i_edit_bounds(&mirror->edit->store, root, 0, low, high);
    return svo_i_device_fail(mirror->device, SVO_UNSUPPORTED,
                             "%s: the voxels span %u x %u x %u, more than about 2^%d along an axis", update_name,
                             high[0] - low[0], high[1] - low[1], high[2] - low[2], SVO_DEPTH_MAX);
}

/* The node of the grid's cube. Where it is none of the edit's, nodes above its eighths are written. */
static svo_status find_node(svo_edit_mirror *mirror, svo_i_edit_ref root, const uint32_t base[3], uint32_t depth,
                            svo_i_edit_ref *node)
{
    static const uint32_t corner[3] = {0, 0, 0};
    svo_i_edit_store *store = &mirror->edit->store;
    const int64_t offset[3] = {-(int64_t)base[0], -(int64_t)base[1], -(int64_t)base[2]};
    if (svo_i_edit_is_aligned(base, depth)) {
        *node = svo_i_edit_find_cube(store, root, base, depth);
        return SVO_OK;
    }
    svo_i_edit_run run = {.store = store, .share = 1.0};
    const uint32_t top = store->top;
    if (!svo_i_edit_move(&run, store, root, offset, node)) {
        svo_i_edit_store_rewind(store, top);
        return svo_i_device_fail(mirror->device, store->failure, "%s: no memory for the nodes above the edit's",
                                 update_name);
    }
    *node = svo_i_edit_find_cube(store, *node, corner, depth);
    return SVO_OK;
}

static svo_status describe(svo_edit_mirror *mirror, const uint32_t base[3], uint32_t depth)
{
    mirror->list = mirror->edit->frame->info;
    mirror->list.depth = depth;
    for (int axis = 0; axis < 3; ++axis) {
        mirror->list.low[axis] = (int32_t)(mirror->edit->corner[axis] + base[axis]);
    }
    return svo_i_voxels_grid(mirror->device, &mirror->list, depth, &mirror->grid);
}

/* ---- its nodes ---- */

/* A buffer with room for all units, which then are to be written. */
static svo_status make_room(svo_edit_mirror *mirror, uint64_t unit_count)
{
    if (unit_count <= mirror->unit_room && mirror->units != NULL) {
        return SVO_OK;
    }
    if (unit_count >= UNITS_MAX) {
        return svo_i_device_fail(mirror->device, SVO_UNSUPPORTED, "%s: %llu units of nodes are above 2^31 - 1",
                                 update_name, (unsigned long long)unit_count);
    }
    const uint64_t room = unit_count + unit_count / SPARE_PARTS + (1u << SVO_I_EDIT_SEGMENT_LOG2);
    svo_i_buffer_release(&mirror->units);
    mirror->unit_room = 0;
    mirror->unit_count = 0;
    SVO_I_TRY(svo_i_device_buffer(mirror->device, update_name, "edited nodes", CL_MEM_READ_ONLY,
                                  (size_t)room * UNIT_BYTES, &mirror->units));
    mirror->unit_room = room;
    return SVO_OK;
}

/* Writes the units that the device does not have, segment by segment. */
static svo_status write_units(svo_edit_mirror *mirror, cl_command_queue queue)
{
    const svo_i_edit_store *store = &mirror->edit->store;
    const uint32_t segment_units = 1u << SVO_I_EDIT_SEGMENT_LOG2;
    uint64_t begin = mirror->unit_count > 0 ? mirror->unit_count : 1; /* unit 0 is no node */
    while (begin < store->top) {
        const uint32_t first = (uint32_t)begin & (segment_units - 1u);
        const uint64_t left = store->top - begin;
        const uint64_t count = left < segment_units - first ? left : segment_units - first;
        const unsigned char *units = svo_i_edit_store_units(store, (uint32_t)begin >> SVO_I_EDIT_SEGMENT_LOG2);
        SVO_I_TRY(svo_i_device_write(mirror->device, update_name, queue, mirror->units, (size_t)begin * UNIT_BYTES,
                                     units + (size_t)first * UNIT_BYTES, (size_t)count * UNIT_BYTES));
        mirror->info.written_bytes += count * UNIT_BYTES;
        begin += count;
    }
    mirror->unit_count = store->top;
    return SVO_OK;
}

/* The root, and in unit 0 its alpha, by which kernels know whether all shows. */
static svo_status write_root(svo_edit_mirror *mirror, cl_command_queue queue, svo_i_edit_ref node, uint32_t depth)
{
    const uint32_t color =
        node != SVO_I_EDIT_EMPTY ? svo_i_edit_payload_of(&mirror->edit->store, node).color : UINT32_MAX;
    const uint32_t first[2] = {color & 0xff000000u, 0};
    const uint32_t root[2] = {node, depth};
    SVO_I_TRY(svo_i_device_write(mirror->device, update_name, queue, mirror->units, 0, first, sizeof first));
    return svo_i_device_write(mirror->device, update_name, queue, mirror->root, 0, root, sizeof root);
}

svo_status svo_edit_mirror_update(svo_edit_mirror *mirror, cl_command_queue queue)
{
    uint32_t base[3] = {0, 0, 0};
    uint32_t depth = DEPTH_MIN;
    svo_i_edit_ref node = SVO_I_EDIT_EMPTY;
    if (mirror == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_edit *edit = mirror->edit;
    const svo_i_edit_ref root = edit->versions[edit->current];
    SVO_I_TRY(svo_i_device_queue(mirror->device, update_name, queue, &queue));
    mirror->info.written_bytes = 0;
    if (mirror->is_current && mirror->version == root && mirror->collections == edit->info.collections) {
        return SVO_OK; /* else nodes above the edit's would be written once more */
    }
    mirror->is_current = false;
    if (root != SVO_I_EDIT_EMPTY) {
        SVO_I_TRY(find_grid(mirror, root, base, &depth));
        SVO_I_TRY(find_node(mirror, root, base, depth, &node));
    }
    SVO_I_TRY(describe(mirror, base, depth));
    if (mirror->collections != edit->info.collections || mirror->unit_count > edit->store.top) {
        mirror->unit_count = 0;
    }
    mirror->collections = edit->info.collections;
    SVO_I_TRY(make_room(mirror, edit->store.top > 0 ? edit->store.top : 1));
    SVO_I_TRY(write_units(mirror, queue));
    SVO_I_TRY(write_root(mirror, queue, node, depth));
    mirror->info.device_bytes = mirror->unit_room * UNIT_BYTES;
    mirror->info.depth = depth;
    mirror->node = node;
    mirror->version = root;
    mirror->is_current = true;
    return SVO_OK;
}

/* ---- create ---- */

svo_status svo_edit_mirror_create(svo_device *device, svo_edit *edit, cl_command_queue queue, svo_edit_mirror **out)
{
    if (device == NULL || edit == NULL || out == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", create_name,
                                 device == NULL ? "device"
                                 : edit == NULL ? "edit"
                                                : "out");
    }
    svo_edit_mirror *made = svo_i_alloc_zeroed(&device->memory, 1, sizeof *made);
    if (made == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the handle", create_name);
    }
    made->device = device;
    made->edit = edit;
    made->info.struct_size = sizeof made->info;
    svo_status status = svo_i_device_buffer(device, create_name, "root of an edit", CL_MEM_READ_ONLY,
                                            2 * sizeof(uint32_t), &made->root);
    if (status == SVO_OK) {
        status = svo_edit_mirror_update(made, queue);
    }
    if (status != SVO_OK) {
        svo_edit_mirror_destroy(&made);
        svo_i_message_rename(svo_i_device_message(device), create_name);
        return status;
    }
    *out = made;
    return SVO_OK;
}

void svo_edit_mirror_destroy(svo_edit_mirror **mirror)
{
    if (mirror == NULL || *mirror == NULL) {
        return;
    }
    svo_i_buffer_release(&(*mirror)->units);
    svo_i_buffer_release(&(*mirror)->root);
    svo_i_free(*mirror);
    *mirror = NULL;
}

svo_status svo_edit_mirror_get_info(const svo_edit_mirror *mirror, svo_edit_mirror_info *info)
{
    return mirror == NULL ? SVO_INVALID_ARGUMENT
                          : svo_i_struct_write(NULL, "svo_edit_mirror_get_info", "info", &mirror->info, info,
                                               SVO_I_STRUCT_SIZES(svo_edit_mirror_info, depth));
}

/* ---- pictures ---- */

static svo_grid grid_of(const svo_edit_mirror *mirror)
{
    const svo_i_voxel_grid *grid = &mirror->grid;
    return (svo_grid){.depth = mirror->list.depth,
                      .snap_bits = grid->snap_bits,
                      .origin = {grid->origin[0], grid->origin[1], grid->origin[2]},
                      .scale = grid->scale,
                      .edge = grid->edge};
}

static svo_status render(void *of, const svo_render_options *options, const svo_array *pixels, const svo_submit *submit)
{
    static const char function[] = "svo_render";
    static const svo_i_picture_kind kind = {
        .name = "edit", .views = 1u << SVO_VIEW_SHADED, .view_names = "SVO_VIEW_SHADED"};
    svo_edit_mirror *mirror = of;
    svo_render_options asked;
    SVO_I_TRY(svo_i_picture_options(mirror->device, function, &kind, options, &asked));
    const svo_i_picture_source source = {.device = mirror->device,
                                         .function = function,
                                         .grid = grid_of(mirror),
                                         .form_defines = " -DSVO_READ_EDIT",
                                         .nodes = {mirror->units, mirror->root, NULL},
                                         .node_arguments = 3,
                                         .colors = mirror->units};
    return svo_i_picture_draw(&source, &asked, pixels, submit);
}

/* An svo_i_framed.open. A block counts as full. */
static uint32_t open_node(const void *subject, uint32_t node, uint32_t level, uint32_t child[8])
{
    const svo_edit_mirror *mirror = subject;
    const svo_i_edit_store *store = &mirror->edit->store;
    const svo_i_edit_ref ref = level == 0 ? mirror->node : node;
    uint32_t mask = 0;
    if (svo_i_edit_kind_of(store, ref) != SVO_I_EDIT_INNER) {
        return 0;
    }
    svo_i_edit_children_of(store, ref, child);
    for (uint32_t octant = 0; octant < 8; ++octant) {
        mask |= child[octant] != SVO_I_EDIT_EMPTY ? 1u << octant : 0u;
    }
    return mask;
}

static svo_status fit_camera(const void *of, float aspect, svo_camera *camera)
{
    const svo_edit_mirror *mirror = of;
    const bool is_known = mirror->node != SVO_I_EDIT_EMPTY && mirror->collections == mirror->edit->info.collections;
    const svo_i_framed framed = {.subject = mirror,
                                 .open = is_known ? open_node : NULL,
                                 .depth = mirror->list.depth,
                                 .origin = {mirror->grid.origin[0], mirror->grid.origin[1], mirror->grid.origin[2]},
                                 .edge = mirror->grid.edge};
    const svo_i_fitted fitted = {&framed, svo_i_framed_reach};
    return svo_i_camera_fit(&fitted, aspect, camera) ? SVO_OK : SVO_INVALID_ARGUMENT;
}

static svo_device *device_of(const void *of)
{
    return ((const svo_edit_mirror *)of)->device;
}

static const struct svo_target_class mirror_class = {
    .name = "edit", .device = device_of, .render = render, .fit_camera = fit_camera};

svo_target svo_edit_mirror_target(svo_edit_mirror *mirror)
{
    return (svo_target){&mirror_class, mirror};
}
