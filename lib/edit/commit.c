/* SPDX-License-Identifier: MIT */
/*
 * The tree of an edit, and the compact one. Where nothing is asked for that needs the stages of a build, the host
 * writes it from the nodes; else the voxels become a list, which is built.
 */
#include <inttypes.h>
#include <string.h>

#include "compact/compact.h"
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
static const char compact_name[] = "svo_edit_commit_compact";

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
    const svo_i_edit_store *store; /* NULL: none are found */
    svo_i_edit_ref node; /* on the level of the tree's depth */
    unsigned depth;
    svo_plan_options options;
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
static svo_status find_nodes(svo_device *device, const svo_edit *edit, const uint32_t low[3], cut *c)
{
    const uint32_t depth = c->depth;
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

static svo_status describe(svo_device *device, const cut *c, svo_tree_info *info)
{
    const svo_plan_options *options = &c->options;
    svo_i_voxel_grid grid;
    SVO_I_TRY(svo_i_voxels_grid(device, &c->list, c->depth, &grid));
    info->depth = c->depth;
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

/* Writes the tree's host arrays; payload depth-first, or in the order of nodes. *p: tells how far that is. */
static svo_status write(svo_device *device, const cut *c, bool depth_first, svo_tree *tree, progress *p)
{
    const svo_status status =
        tell(p, 0.0) ? svo_i_edit_write_tree(c->store, c->node, depth_first, tree, tell, p) : SVO_CANCELED;
    return status == SVO_OK ? SVO_OK : fail_write(device, status, p->fraction);
}

static svo_status end(svo_device *device, progress *p)
{
    return p->fraction == 1.0 || tell(p, 1.0) ? SVO_OK : fail_write(device, SVO_CANCELED, 1.0);
}

/* Writes and uploads the tree. Its host arrays are released, as a built tree has none. */
static svo_status write_and_upload(svo_device *device, const cut *c, cl_command_queue queue, svo_tree *tree,
                                   svo_build_report *report)
{
    progress p = {.call = c->options.progress, .user = c->options.progress_user};
    const double started_ms = svo_i_now_ms();
    SVO_I_TRY(write(device, c, false, tree, &p));
    const double written_ms = svo_i_now_ms();
    tree->downloaded = true;
    SVO_I_TRY(svo_tree_upload(tree, device, queue));
    svo_i_tree_forget(tree);
    svo_i_report_add(report, SVO_STAGE_FILTER, written_ms - started_ms, "wall");
    svo_i_report_add(report, SVO_STAGE_TRANSFER, svo_i_now_ms() - written_ms, "wall");
    report->fragments = tree->info.leaf_count;
    return end(device, &p);
}

static svo_status write_tree(svo_device *device, const cut *c, cl_command_queue queue, svo_tree **out,
                             svo_build_report *report)
{
    svo_status status = SVO_OK;
    svo_build_report made = {.frontend = "none", .builder = "edit", .share = "none", .renderer = ""};
    SVO_I_TRY(svo_i_report_check(device, name, report));
    svo_tree *tree = svo_i_tree_new(&device->memory);
    if (tree == NULL) {
        return fail_memory(device);
    }
    SVO_I_TRY_CLEANUP(describe(device, c, &tree->info));
    SVO_I_TRY_CLEANUP(write_and_upload(device, c, queue, tree, &made));
    *out = tree;
    tree = NULL;
cleanup:
    svo_i_report_write(&made, report);
    svo_tree_destroy(&tree);
    return status;
}

/* Without a tree on the device. */
static svo_status write_compact(svo_device *device, const cut *c, const svo_compact_options *compact,
                                cl_command_queue queue, svo_compact **out)
{
    svo_status status = SVO_OK;
    progress p = {.call = c->options.progress, .user = c->options.progress_user};
    svo_tree *tree = svo_i_tree_new(&device->memory);
    if (tree == NULL) {
        return fail_memory(device);
    }
    SVO_I_TRY_CLEANUP(describe(device, c, &tree->info));
    tree->info.need &= ~compact->leave_out;
    SVO_I_TRY_CLEANUP(write(device, c, true, tree, &p));
    SVO_I_TRY_CLEANUP(end(device, &p));
    SVO_I_TRY_CLEANUP(svo_i_compact_share(device, compact_name, tree, compact, queue, out));
cleanup:
    svo_tree_destroy(&tree);
    return status;
}

/* Finds the nodes that the tree can be written from; c->store stays NULL where that is not possible. */
static svo_status cut_nodes(const svo_edit *edit, svo_device *device, unsigned depth, const svo_plan_options *options,
                            cut *c)
{
    uint32_t low[3];
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(device), name, "options", options, &c->options,
                                SVO_I_STRUCT_SIZES(svo_plan_options, coverage)));
    const uint64_t count = svo_i_edit_voxels_of(&edit->store, edit->versions[edit->current], SVO_I_EDIT_ROOT_LEVEL);
    if (count == 0 || count > SVO_VOXELS_MAX || !is_plain(&c->options)) {
        return SVO_OK;
    }
    find_bounds(edit, low, c);
    SVO_I_TRY(svo_i_voxels_options(device, &c->list, edit->store.has_normals, &depth, &c->options));
    c->depth = depth;
    return depth >= LEVEL_MIN && c->options.payload_level <= depth ? find_nodes(device, edit, low, c) : SVO_OK;
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

/* Whether a commit can begin. out: where its result goes. */
static svo_status check(const svo_edit *edit, svo_device *device, const void *out, const char *function)
{
    return edit != NULL && device != NULL && out != NULL
               ? SVO_OK
               : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                   device == NULL ? "device"
                                   : edit == NULL ? "edit"
                                                  : "out");
}

svo_status svo_edit_commit(const svo_edit *edit, svo_device *device, unsigned depth, const svo_plan_options *options,
                           cl_command_queue queue, svo_tree **out, svo_build_report *report)
{
    cut c = {.store = NULL};
    SVO_I_TRY(check(edit, device, (const void *)out, name));
    svo_status status = cut_nodes(edit, device, depth, options, &c);
    if (status == SVO_OK) {
        status = c.store != NULL ? write_tree(device, &c, queue, out, report)
                                 : commit_list(edit, device, depth, options, queue, out, report);
    }
    svo_i_edit_store_release(&c.moved);
    if (status != SVO_OK) {
        svo_i_message_rename(svo_i_device_message(device), name);
    }
    return status;
}

/* ---- compact trees ---- */

static svo_status commit_tree(const svo_edit *edit, svo_device *device, unsigned depth, const svo_plan_options *options,
                              const svo_compact_options *compact, cl_command_queue queue, svo_compact **out)
{
    svo_tree *tree = NULL;
    SVO_I_TRY(svo_edit_commit(edit, device, depth, options, queue, &tree, NULL));
    const svo_status status = svo_compact_create(device, tree, compact, queue, out);
    svo_tree_destroy(&tree);
    return status;
}

svo_status svo_edit_commit_compact(const svo_edit *edit, svo_device *device, unsigned depth,
                                   const svo_plan_options *options, const svo_compact_options *compact,
                                   cl_command_queue queue, svo_compact **out)
{
    cut c = {.store = NULL};
    svo_compact_options asked;
    SVO_I_TRY(check(edit, device, (const void *)out, compact_name));
    SVO_I_TRY(svo_i_compact_options(device, compact_name, compact, &asked));
    svo_status status = SVO_OK;
    if (asked.form == SVO_FORM_SHARED && asked.minimize == 0) {
        status = cut_nodes(edit, device, depth, options, &c);
    }
    if (status == SVO_OK) {
        status = c.store != NULL ? write_compact(device, &c, &asked, queue, out)
                                 : commit_tree(edit, device, depth, options, &asked, queue, out);
    }
    svo_i_edit_store_release(&c.moved);
    if (status != SVO_OK) {
        svo_i_message_rename(svo_i_device_message(device), compact_name);
    }
    return status;
}
