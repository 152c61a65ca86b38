/* SPDX-License-Identifier: MIT */
/*
 * The last step of loading a file: whether its arrays make a tree or a compact tree, such as a build makes them. Then
 * kernels that follow their links stay inside the arrays.
 */
#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "core/compact.h"
#include "core/message.h"
#include "core/tree.h"
#include "io/file_format.h"
#include "shared/descriptor.h"
#include "shared/nodes.clh"
#include "shared/snap.clh"
#include "svocl/plan.h"

/* ---- built trees ---- */

#define SNAPPED_MAX (1 << 29) /* coordinates of accepted triangles lie below this (lib/plan/grid.c) */

typedef struct tree_check {
    const svo_tree_info *info;
    svo_snap snap; /* of its grid */
    svo_tree_arrays arrays;
    const char *name;
    svo_message *message;
} tree_check;

/*
 * Nodes are in breadth-first order without gaps: a node's children begin where those of the node before it end. So
 * first_child is a running sum over the whole tree, and at the end of a level it equals the header's level_begin.
 */
static svo_status check_nodes(const tree_check *job)
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

static svo_status check_leaf(const tree_check *job, uint64_t leaf)
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

static svo_status check_lists(const tree_check *job)
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
static svo_status check_position(const tree_check *job, uint64_t at)
{
    const svo_tree_info *info = job->info;
    const int32_t snapped = job->arrays.vertices[at];
    const double position =
        job->arrays.positions != NULL ? (double)job->arrays.positions[at] : job->arrays.positions_double[at];
    const bool is_same = info->is_exact != 0
                             ? svo_snap_coordinate(&job->snap, position, info->origin[at % 3]) == snapped
                             : rint((position - info->origin[at % 3]) * info->scale) == snapped;
    return is_same ? SVO_OK
                   : svo_i_fail(job->message, SVO_FILE_DAMAGED,
                                "%s: vertex %" PRIu64 ": position %g does not round to the coordinate %" PRId32,
                                job->name, at / 3, position, snapped);
}

/* Only vertices that a triangle uses must be in range; no hit depends on the others. */
static svo_status check_corner(const tree_check *job, uint64_t corner)
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
        if (job->info->positions != SVO_POSITIONS_ROUNDED) {
            SVO_I_TRY(check_position(job, 3 * (uint64_t)vertex + axis));
        }
    }
    return SVO_OK;
}

static svo_status check_geometry(const tree_check *job)
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
    tree_check job = {.info = &tree->info,
                      .snap = svo_make_snap(tree->info.scale, tree->info.edge, (int32_t)tree->info.snap_bits),
                      .name = name,
                      .message = message};
    job.arrays = (svo_tree_arrays)SVO_TREE_ARRAYS_INIT;
    (void)svo_tree_get_arrays(tree, &job.arrays);
    SVO_I_TRY(check_nodes(&job));
    if ((job.info->need & SVO_NEED_RAYS) == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(check_lists(&job));
    return check_geometry(&job);
}

/* ---- compact trees ---- */

/* Nodes are read in their order, and each must be where the order has it. */
typedef struct compact_check {
    const svo_compact_info *info;
    const char *name;
    svo_message *message;
    const uint32_t *words;
    const uint32_t *bases; /* NULL: none */
    uint8_t *levels; /* of a word's node, plus 1; 0: a far word. NULL without bases */
    uint64_t next; /* the next word whose place is not taken */
    uint64_t far_count;
    uint64_t inner[SVO_LEVELS_MAX], leaf[SVO_LEVELS_MAX]; /* counted */
} compact_check;

static svo_status damaged(const compact_check *c, uint64_t at, const char *what)
{
    return svo_i_fail(c->message, SVO_FILE_DAMAGED, "%s: node %" PRIu64 ": %s", c->name, at, what);
}

/* The counted levels are those of the header. */
static svo_status check_levels(const compact_check *c)
{
    for (uint32_t level = 0; level <= c->info->depth; ++level) {
        if (c->inner[level] != c->info->level_inner[level] || c->leaf[level] != c->info->level_leaf[level]) {
            return svo_i_fail(c->message, SVO_FILE_DAMAGED,
                              "%s: level %" PRIu32 " has %" PRIu64 " inner nodes and %" PRIu64 " leaves, %" PRIu32
                              " and %" PRIu32 " expected",
                              c->name, level, c->inner[level], c->leaf[level], c->info->level_inner[level],
                              c->info->level_leaf[level]);
        }
    }
    return SVO_OK;
}

/* ---- compact trees: descriptors ---- */

/* The masks of a word. *inner: its inner children. */
static svo_status check_masks(compact_check *c, uint64_t place, uint32_t level, uint32_t *inner)
{
    const uint32_t valid = c->words[place] & 255;
    const uint32_t leaf = c->words[place] >> SVO_WORD_LEAF_SHIFT & 255;
    if (valid == 0 && (level > 0 || c->info->leaf_count > 0)) {
        return damaged(c, place, "it has no child");
    }
    if ((leaf & ~valid) != 0) {
        return damaged(c, place, "a leaf is not among its children");
    }
    if (level + 1 == c->info->depth && leaf != valid) {
        return damaged(c, place, "a child below the deepest level is not a leaf");
    }
    c->leaf[level + 1] += svo_count_bits(leaf);
    *inner = svo_count_bits(valid & ~leaf);
    return SVO_OK;
}

/* Takes the next words. */
static svo_status take(compact_check *c, uint64_t place, uint32_t count)
{
    if (count > c->info->stored_count - c->next) {
        return damaged(c, place, "its children or a far word lie beyond the end");
    }
    c->next += count;
    return SVO_OK;
}

/* The far words of a group, in the order of its members. */
static svo_status check_far_words(compact_check *c, uint64_t group, uint32_t count)
{
    for (uint64_t place = group; place < group + count; ++place) {
        if ((c->words[place] & SVO_WORD_FAR) != 0) {
            if (place + (c->words[place] >> SVO_WORD_DISTANCE_SHIFT) != c->next) {
                return damaged(c, place, "its far word is not behind its group");
            }
            ++c->far_count;
            SVO_I_TRY(take(c, place, 1));
        }
    }
    return SVO_OK;
}

/* The distance of a node whose children begin at c->next. */
static svo_status check_distance(const compact_check *c, uint64_t place)
{
    const uint32_t field = c->words[place] >> SVO_WORD_DISTANCE_SHIFT;
    const bool far = (c->words[place] & SVO_WORD_FAR) != 0;
    const uint64_t distance = far ? c->words[place + field] : field;
    if (place + distance != c->next) {
        return damaged(c, place, "its distance does not lead to its children");
    }
    return far == (distance > SVO_WORD_DISTANCE_MAX) ? SVO_OK
                                                     : damaged(c, place, "it has a far word that it does not need");
}

/* A node and all below it; no deeper than the tree. */
static svo_status check_node(compact_check *c, uint64_t place, uint32_t level)
{
    uint32_t count = 0;
    SVO_I_TRY(check_masks(c, place, level, &count));
    ++c->inner[level];
    if (c->levels != NULL) {
        c->levels[place] = (uint8_t)(level + 1);
    }
    if (count == 0) {
        return c->words[place] >> 16 == 0 ? SVO_OK : damaged(c, place, "it has a distance but no inner child");
    }
    SVO_I_TRY(check_distance(c, place));
    const uint64_t group = c->next;
    SVO_I_TRY(take(c, place, count));
    SVO_I_TRY(check_far_words(c, group, count));
    for (uint64_t member = group; member < group + count; ++member) {
        SVO_I_TRY(check_node(c, member, level + 1));
    }
    return SVO_OK;
}

static svo_status check_bases(const compact_check *c)
{
    uint64_t next = c->info->payload_level == 0 ? 1 : 0;
    for (uint64_t place = 0; place < c->info->stored_count; ++place) {
        const uint32_t level = c->levels[place];
        const bool has_payload = level > 0 && level >= c->info->payload_level;
        const uint64_t expected = level == 0 ? 0 : has_payload ? next : SVO_NO_NODE;
        if (c->bases[place] != expected) {
            return svo_i_fail(c->message, SVO_FILE_DAMAGED,
                              "%s: node %" PRIu64 ": its base is %" PRIu32 ", %" PRIu64 " expected", c->name, place,
                              c->bases[place], expected);
        }
        next += has_payload ? svo_count_bits(c->words[place] & 255) : 0;
    }
    return SVO_OK;
}

static svo_status check_words(compact_check *c)
{
    if ((c->words[0] & SVO_WORD_FAR) != 0) {
        return damaged(c, 0, "the root has a far word");
    }
    c->next = 1;
    SVO_I_TRY(check_node(c, 0, 0));
    if (c->next != c->info->stored_count || c->far_count != c->info->far_count) {
        return svo_i_fail(c->message, SVO_FILE_DAMAGED,
                          "%s: %" PRIu64 " words, %" PRIu64 " of them far, %" PRIu64 " and %" PRIu64 " expected",
                          c->name, c->next, c->far_count, c->info->stored_count, c->info->far_count);
    }
    SVO_I_TRY(check_levels(c));
    return c->bases != NULL ? check_bases(c) : SVO_OK;
}

static svo_status check_descriptor(compact_check *c, const svo_compact *compact)
{
    c->words = compact->host[SVO_COMPACT_NODES];
    c->bases = compact->host[SVO_COMPACT_BASES];
    if (c->bases != NULL) {
        c->levels = svo_i_alloc_zeroed(&compact->memory, (size_t)c->info->stored_count, 1);
        if (c->levels == NULL) {
            return svo_i_fail(c->message, SVO_OUT_OF_HOST_MEMORY, "%s: checking needs %" PRIu64 " bytes", c->name,
                              c->info->stored_count);
        }
    }
    const svo_status status = check_words(c);
    svo_i_free(c->levels);
    return status;
}

/* ---- compact trees: implied ---- */

/* Masks, breadth-first, and the directory; *end: the node after the last. */
static svo_status check_implied_nodes(compact_check *c, const uint8_t *masks, const uint32_t *directory, uint64_t *end)
{
    const uint64_t step_mask = (UINT64_C(1) << c->info->directory_step_log2) - 1;
    uint64_t level_end = 1;
    uint32_t level = 0;
    *end = 1;
    for (uint64_t node = 0; node < c->info->stored_count; ++node) {
        if (node == level_end) {
            ++level;
            level_end = *end;
        }
        if (level == c->info->depth || node == level_end) {
            return damaged(c, node, "it is below the deepest level, or its level is empty");
        }
        if ((node & step_mask) == 0 && directory[node >> c->info->directory_step_log2] != *end) {
            return damaged(c, node, "its first child is not as the directory says");
        }
        const bool is_leaf = masks[node] == 0 && node > 0;
        c->leaf[level] += is_leaf ? 1 : 0;
        c->inner[level] += is_leaf ? 0 : 1;
        *end += svo_count_bits(masks[node]);
    }
    /* What is below the last level that has masks are voxels. */
    c->leaf[c->info->depth] = *end - c->info->stored_count;
    return level + 1 == c->info->depth || *end == c->info->stored_count
               ? SVO_OK
               : damaged(c, c->info->stored_count, "its mask is missing");
}

static svo_status check_implied(compact_check *c, const svo_compact *compact)
{
    const uint8_t *masks = compact->host[SVO_COMPACT_NODES];
    const uint32_t *bases = compact->host[SVO_COMPACT_BASES];
    uint64_t end = 0;
    uint64_t begin = 0;
    if (masks[0] == 0 && c->info->leaf_count > 0) {
        return damaged(c, 0, "it has no child");
    }
    SVO_I_TRY(check_implied_nodes(c, masks, compact->host[SVO_COMPACT_LINKS], &end));
    SVO_I_TRY(check_levels(c));
    for (uint64_t i = c->info->stored_count; i < c->info->bytes[SVO_COMPACT_NODES]; ++i) {
        if (masks[i] != 0) {
            return damaged(c, i, "a byte after the last node is not 0");
        }
    }
    for (uint32_t level = 0; level < c->info->payload_level; ++level) {
        begin += (uint64_t)c->info->level_inner[level] + c->info->level_leaf[level];
    }
    return bases == NULL || bases[0] == begin ? SVO_OK : damaged(c, bases[0], "payload does not begin at this node");
}

/* ---- compact trees: shared, mirrored ---- */

static svo_status check_shared(compact_check *c, const svo_compact *compact)
{
    svo_i_record_counts counts;
    SVO_I_TRY(svo_i_records_check(compact, c->name, &counts, c->message));
    if (counts.records != c->info->shared_count) {
        return svo_i_fail(c->message, SVO_FILE_DAMAGED, "%s: %" PRIu64 " records, %" PRIu64 " expected", c->name,
                          counts.records, c->info->shared_count);
    }
    memcpy(c->inner, counts.inner, sizeof c->inner);
    memcpy(c->leaf, counts.leaf, sizeof c->leaf);
    return check_levels(c);
}

svo_status svo_i_compact_check(const svo_compact *compact, const char *name, svo_message *message)
{
    compact_check c = {.info = &compact->info, .name = name, .message = message};
    switch (compact->info.form) {
    case SVO_FORM_IMPLIED:
        return check_implied(&c, compact);
    case SVO_FORM_SHARED:
    case SVO_FORM_MIRRORED:
        return check_shared(&c, compact);
    default:
        return check_descriptor(&c, compact);
    }
}
