/* SPDX-License-Identifier: MIT */
/*
 * The tree of an edit. Where nothing is asked for that needs the stages of a build, the host writes it from the nodes;
 * else the voxels become a list, which is built.
 */
#include <inttypes.h>
#include <string.h>

#include "core/device.h"
#include "core/struct_size.h"
#include "core/voxel_list.h"
#include "edit/combine.h"
#include "edit/handle.h"
#include "edit/tree.h"
#include "pipeline/run.h"
#include "voxels/build.h"

#define LEVEL_MIN SVO_I_EDIT_BLOCK_LEVEL /* of a tree that is written from nodes */

static const char name[] = "svo_edit_commit";

/* Whether a build would do nothing else than what the host does here. */
static bool is_plain(const svo_plan_options *options)
{
    return options->part_header == NULL && options->updatable == 0 && options->drop_alpha == 0.0 &&
           options->max_area == 0.0 && options->weight_log2 == 0 && options->chunk_bytes == 0 &&
           options->fragment_capacity == 0 && options->worst_case_nodes == 0 && options->place == SVO_PLACE_DEFAULT &&
           (uint32_t)options->builder <= SVO_BUILDER_SORTED && (uint32_t)options->weights <= SVO_WEIGHTS_CENTER &&
           options->payload_level <= SVO_DEPTH_MAX;
}

/* ---- from nodes ---- */

/* Where the voxels are, and the cube of nodes that begins at their least corner. */
typedef struct cut {
    svo_voxels_info list; /* what a plan reads of it */
    svo_i_edit_store moved; /* the nodes, where they do not lie at the corner of cubes; owned */
    const svo_i_edit_store *store;
    svo_i_edit_ref node; /* on the level of the tree's depth */
} cut;

/* The bounds, in coordinates. The edit has voxels. */
static void find_bounds(const svo_edit *edit, uint32_t low[3], cut *c)
{
    uint32_t high[3];
    svo_i_edit_bounds(&edit->store, edit->versions[edit->current], 0, low, high);
    c->list = edit->frame->info;
    for (int axis = 0; axis < 3; ++axis) {
        c->list.low[axis] = (int32_t)(edit->corner[axis] + low[axis]);
        c->list.high[axis] = (int32_t)(edit->corner[axis] + high[axis]);
    }
    const uint32_t bits = svo_i_voxel_bits(c->list.low, c->list.high);
    c->list.depth = bits < 1 ? 1 : bits > SVO_DEPTH_MAX ? 0 : bits;
}

static svo_status fail_memory(svo_device *device)
{
    return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the tree", name);
}

/* Finds the nodes of a tree of that depth. Where the least corner has moved since the edit began, they are moved to a
   store of their own, which costs what the voxels cost. */
static svo_status find_nodes(svo_device *device, const svo_edit *edit, const uint32_t low[3], uint32_t depth, cut *c)
{
    const svo_i_edit_ref root = edit->versions[edit->current];
    if (svo_i_edit_is_aligned(low, depth)) {
        c->store = &edit->store;
        c->node = svo_i_edit_find_cube(&edit->store, root, low, depth);
        return SVO_OK;
    }
    static const uint32_t corner[3] = {0, 0, 0};
    const int64_t offset[3] = {-(int64_t)low[0], -(int64_t)low[1], -(int64_t)low[2]};
    svo_i_edit_ref moved = SVO_I_EDIT_EMPTY;
    c->moved = (svo_i_edit_store){
        .memory = edit->store.memory, .has_normals = edit->store.has_normals, .max_bytes = UINT64_MAX};
    svo_i_edit_run run = {.store = &c->moved, .share = 1.0};
    if (!svo_i_edit_move(&run, &edit->store, root, offset, &moved)) {
        return fail_memory(device);
    }
    c->store = &c->moved;
    c->node = svo_i_edit_find_cube(&c->moved, moved, corner, depth);
    return SVO_OK;
}

/* ---- the tree ---- */

/* The options' callback. */
typedef struct progress {
    svo_progress_callback call;
    void *user;
    double fraction;
} progress;

static bool tell(void *user, double fraction)
{
    progress *p = user;
    p->fraction = fraction;
    return p->call == NULL || p->call(p->user, SVO_STAGE_FILTER, fraction) == 0;
}

static svo_status describe(svo_device *device, const cut *c, uint32_t depth, const svo_plan_options *options,
                           svo_tree_info *info)
{
    svo_i_voxel_grid grid;
    SVO_I_TRY(svo_i_voxels_grid(device, &c->list, depth, &grid));
    info->depth = depth;
    info->snap_bits = grid.snap_bits;
    info->need = options->need & ~(uint32_t)SVO_NEED_NONE;
    info->weights = options->weights;
    info->payload_level = options->payload_level;
    memcpy(info->origin, grid.origin, sizeof info->origin);
    info->edge = grid.edge;
    info->scale = grid.scale;
    info->is_exact = 1;
    return SVO_OK;
}

static svo_status fail_write(svo_device *device, svo_status why, double fraction)
{
    switch (why) {
    case SVO_CANCELED:
        return svo_i_device_fail(device, why, "%s: the progress callback stopped the call at %.0f %%", name,
                                 fraction * 100.0);
    case SVO_CAPACITY_EXCEEDED:
        return svo_i_device_fail(device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "%s: the tree has more than 2^32 - 2 nodes; lower the depth", name);
    default:
        return fail_memory(device);
    }
}

/* Writes and uploads the tree. Its host arrays are released, as a built tree has none. */
static svo_status write(svo_device *device, const cut *c, const svo_plan_options *options, cl_command_queue queue,
                        svo_tree *tree, svo_build_report *report)
{
    progress p = {.call = options->progress, .user = options->progress_user};
    const double started_ms = svo_i_now_ms();
    const svo_status status = tell(&p, 0.0) ? svo_i_edit_write_tree(c->store, c->node, tree, tell, &p) : SVO_CANCELED;
    if (status != SVO_OK) {
        return fail_write(device, status, p.fraction);
    }
    const double written_ms = svo_i_now_ms();
    tree->downloaded = true;
    SVO_I_TRY(svo_tree_upload(tree, device, queue));
    svo_i_tree_forget(tree);
    svo_i_report_add(report, SVO_STAGE_FILTER, written_ms - started_ms, "wall");
    svo_i_report_add(report, SVO_STAGE_TRANSFER, svo_i_now_ms() - written_ms, "wall");
    report->fragments = tree->info.leaf_count;
    return p.fraction == 1.0 || tell(&p, 1.0) ? SVO_OK : fail_write(device, SVO_CANCELED, 1.0);
}

static svo_status write_tree(svo_device *device, const cut *c, uint32_t depth, const svo_plan_options *options,
                             cl_command_queue queue, svo_tree **out, svo_build_report *report)
{
    svo_status status = SVO_OK;
    svo_build_report made = {.frontend = "none", .builder = "edit", .share = "none", .renderer = ""};
    SVO_I_TRY(svo_i_report_check(device, name, report));
    svo_tree *tree = svo_i_tree_new(&device->memory);
    if (tree == NULL) {
        return fail_memory(device);
    }
    SVO_I_TRY_CLEANUP(describe(device, c, depth, options, &tree->info));
    SVO_I_TRY_CLEANUP(write(device, c, options, queue, tree, &made));
    *out = tree;
    tree = NULL;
cleanup:
    svo_i_report_write(&made, report);
    svo_tree_destroy(&tree);
    return status;
}

/* Writes the tree from the nodes if that is possible; *done says so. */
static svo_status commit_nodes(const svo_edit *edit, svo_device *device, unsigned depth,
                               const svo_plan_options *options, cl_command_queue queue, svo_tree **out,
                               svo_build_report *report, bool *done)
{
    cut c = {.store = NULL};
    uint32_t low[3];
    svo_plan_options asked;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(device), name, "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_plan_options, coverage)));
    const uint64_t count = svo_i_edit_voxels_of(&edit->store, edit->versions[edit->current], SVO_I_EDIT_ROOT_LEVEL);
    if (count == 0 || count > SVO_VOXELS_MAX || !is_plain(&asked)) {
        return SVO_OK;
    }
    find_bounds(edit, low, &c);
    SVO_I_TRY(svo_i_voxels_options(device, &c.list, edit->store.has_normals, &depth, &asked));
    *done = depth >= LEVEL_MIN && asked.payload_level <= depth;
    if (!*done) {
        return SVO_OK;
    }
    SVO_I_TRY_CLEANUP(find_nodes(device, edit, low, depth, &c));
    SVO_I_TRY_CLEANUP(write_tree(device, &c, depth, &asked, queue, out, report));
cleanup:
    svo_i_edit_store_release(&c.moved);
    return status;
}

/* ---- from the list ---- */

static svo_status commit_list(const svo_edit *edit, svo_device *device, unsigned depth, const svo_plan_options *options,
                              cl_command_queue queue, svo_tree **out, svo_build_report *report)
{
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    svo_status status = svo_edit_get_voxels(edit, &voxels, &message);
    if (status != SVO_OK) {
        return svo_i_device_fail(device, status, "%s", message.text);
    }
    status = svo_voxels_build(device, voxels, depth, options, queue, out, report);
    svo_voxels_destroy(&voxels);
    return status;
}

svo_status svo_edit_commit(const svo_edit *edit, svo_device *device, unsigned depth, const svo_plan_options *options,
                           cl_command_queue queue, svo_tree **out, svo_build_report *report)
{
    bool done = false;
    if (edit == NULL || device == NULL || out == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", name,
                                 device == NULL ? "device"
                                 : edit == NULL ? "edit"
                                                : "out");
    }
    svo_status status = commit_nodes(edit, device, depth, options, queue, out, report, &done);
    if (status == SVO_OK && !done) {
        status = commit_list(edit, device, depth, options, queue, out, report);
    }
    if (status != SVO_OK) {
        svo_i_message_rename(svo_i_device_message(device), name);
    }
    return status;
}
