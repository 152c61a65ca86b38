/* SPDX-License-Identifier: MIT */
/* The last step of loading a .svo file: node links, lists and indices must be such as a build makes them. */
#include "io/file_check.h"

#include <inttypes.h>
#include <math.h>

#include "core/message.h"
#include "core/tree.h"
#include "shared/nodes.clh"
#include "svocl/plan.h"

#define SNAPPED_MAX (1 << 29) /* coordinates of accepted triangles lie below this (lib/plan/grid.c) */

typedef struct check {
    const svo_tree_info *info;
    svo_tree_arrays arrays;
    const char *name;
    svo_message *message;
} check;

/*
 * Nodes are in breadth-first order without gaps: a node's children begin where those of the node before it end. So
 * first_child is a running sum over the whole tree, and at the end of a level it equals the header's level_begin.
 */
static svo_status check_nodes(const check *job)
{
    const svo_tree_info *info = job->info;
    const bool empty = info->leaf_count == 0;
    uint64_t next_child = 1;
    for (uint32_t level = 0; level < info->depth; ++level) {
        for (uint64_t node = info->level_begin[level]; node < info->level_begin[level + 1]; ++node) {
            const uint8_t mask = job->arrays.child_mask[node];
            if (mask == 0 && !(empty && node == 0)) {
                return svo_i_fail(job->message, SVO_FILE_DAMAGED, "%s: node %" PRIu64 " of level %" PRIu32 " is empty",
                                  job->name, node, level);
            }
            if (job->arrays.first_child[node] != next_child) {
                return svo_i_fail(job->message, SVO_FILE_DAMAGED,
                                  "%s: node %" PRIu64 ": first_child is %" PRIu32 ", %" PRIu64 " expected", job->name,
                                  node, job->arrays.first_child[node], next_child);
            }
            next_child += svo_count_bits(mask);
        }
        if (next_child != info->level_begin[level + 2]) {
            return svo_i_fail(job->message, SVO_FILE_DAMAGED,
                              "%s: level %" PRIu32 " ends at node %" PRIu32 ", the masks above say %" PRIu64, job->name,
                              level + 1, info->level_begin[level + 2], next_child);
        }
    }
    return SVO_OK;
}

static svo_status check_leaf(const check *job, uint64_t leaf)
{
    const uint32_t begin = job->arrays.list_begin[leaf];
    const uint32_t end = job->arrays.list_begin[leaf + 1];
    if (end < begin || end > job->info->list_count) {
        return svo_i_fail(job->message, SVO_FILE_DAMAGED,
                          "%s: leaf %" PRIu64 ": its list is %" PRIu32 " .. %" PRIu32 " of %" PRIu64, job->name, leaf,
                          begin, end, job->info->list_count);
    }
    for (uint64_t i = begin; i < end; ++i) {
        const uint32_t triangle = job->arrays.list[i];
        if (triangle >= job->info->list_triangle_count || (i > begin && triangle <= job->arrays.list[i - 1])) {
            return svo_i_fail(job->message, SVO_FILE_DAMAGED,
                              "%s: leaf %" PRIu64 ": list entry %" PRIu64 " is triangle %" PRIu32
                              ", not ascending below %" PRIu64,
                              job->name, leaf, i, triangle, job->info->list_triangle_count);
        }
    }
    return SVO_OK;
}

static svo_status check_lists(const check *job)
{
    const uint32_t *list_begin = job->arrays.list_begin;
    const uint64_t leaf_count = job->info->leaf_count;
    if (list_begin[0] != 0 || list_begin[leaf_count] != job->info->list_count) {
        return svo_i_fail(job->message, SVO_FILE_DAMAGED,
                          "%s: the lists are %" PRIu32 " .. %" PRIu32 ", 0 .. %" PRIu64 " expected", job->name,
                          list_begin[0], list_begin[leaf_count], job->info->list_count);
    }
    for (uint64_t leaf = 0; leaf < leaf_count; ++leaf) {
        SVO_I_TRY(check_leaf(job, leaf));
    }
    return SVO_OK;
}

/* The mesh's own coordinate must be one that the build snapped to that of the vertex. at: in both arrays. */
static svo_status check_position(const check *job, uint64_t at)
{
    const svo_tree_info *info = job->info;
    const int32_t snapped = job->arrays.vertices[at];
    const double position =
        job->arrays.positions != NULL ? (double)job->arrays.positions[at] : job->arrays.positions_double[at];
    return rint((position - info->origin[at % 3]) * info->scale) == snapped
               ? SVO_OK
               : svo_i_fail(job->message, SVO_FILE_DAMAGED,
                            "%s: vertex %" PRIu64 ": position %g is not that of the snapped coordinate %" PRId32,
                            job->name, at / 3, position, snapped);
}

/* Only vertices that a triangle uses must be in range; no hit depends on the others. */
static svo_status check_corner(const check *job, uint64_t corner)
{
    const uint32_t vertex = job->arrays.indices[corner];
    if (vertex >= job->info->vertex_count) {
        return svo_i_fail(job->message, SVO_FILE_DAMAGED,
                          "%s: triangle %" PRIu64 ": index %" PRIu32 " is not below %" PRIu64, job->name, corner / 3,
                          vertex, job->info->vertex_count);
    }
    for (uint64_t axis = 0; axis < 3; ++axis) {
        const int32_t coordinate = job->arrays.vertices[3 * (uint64_t)vertex + axis];
        if (coordinate <= -SNAPPED_MAX || coordinate >= SNAPPED_MAX) {
            return svo_i_fail(job->message, SVO_FILE_DAMAGED,
                              "%s: vertex %" PRIu32 ": coordinate %" PRId32 " is not within 2^29", job->name, vertex,
                              coordinate);
        }
        if (job->info->positions != SVO_POSITIONS_SNAPPED) {
            SVO_I_TRY(check_position(job, 3 * (uint64_t)vertex + axis));
        }
    }
    return SVO_OK;
}

static svo_status check_geometry(const check *job)
{
    const svo_tree_info *info = job->info;
    for (uint64_t corner = 0; corner < 3 * info->list_triangle_count; ++corner) {
        SVO_I_TRY(check_corner(job, corner));
    }
    for (uint64_t i = 0; i < info->list_triangle_count; ++i) {
        const uint32_t id = job->arrays.triangle_ids[i];
        if (id >= info->triangles || (i > 0 && id <= job->arrays.triangle_ids[i - 1])) {
            return svo_i_fail(job->message, SVO_FILE_DAMAGED,
                              "%s: triangle_ids[%" PRIu64 "] is %" PRIu32 ", not ascending below %" PRIu64, job->name,
                              i, id, info->triangles);
        }
    }
    return SVO_OK;
}

svo_status svo_i_file_check_structure(const svo_tree *tree, const char *name, svo_message *message)
{
    check job = {.info = &tree->info, .name = name, .message = message};
    job.arrays = (svo_tree_arrays)SVO_TREE_ARRAYS_INIT;
    (void)svo_tree_get_arrays(tree, &job.arrays);
    SVO_I_TRY(check_nodes(&job));
    if ((job.info->need & SVO_NEED_RAYS) == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(check_lists(&job));
    return check_geometry(&job);
}
