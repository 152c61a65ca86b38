/* SPDX-License-Identifier: MIT */
/* svo_compact_expand: a compact tree becomes a built one again, by kernels/compact/expand.cl. */
#include <stdio.h>

#include "compact/form.h"
#include "core/device.h"
#include "core/memory.h"
#include "core/tree.h"
#include "shared/layout.h"
#include "svocl/plan.h"

/* Node indices and their counts have 32 bits, and SVO_NO_NODE is none. */
#define NODES_MAX 0xfffffffeu

typedef struct expansion {
    svo_i_device_work work;
    const svo_compact *compact;
    svo_tree *tree;
    uint32_t level;
    cl_mem nodes; /* svo_expanded of the level's nodes; scratch */
    cl_mem below; /* those of the next level */
} expansion;

/* ---- counts ---- */

/* Nodes on a level: those that are stored, and those inside the leaves above. False above NODES_MAX. */
static bool count_level(const svo_compact_info *info, uint32_t level, uint64_t *out)
{
    uint64_t count = (uint64_t)info->level_inner[level] + info->level_leaf[level];
    for (uint32_t above = 0; above < level; ++above) {
        const uint32_t shift = 3 * (level - above);
        if (info->level_leaf[above] > 0 && (shift >= 32 || (uint64_t)info->level_leaf[above] << shift > NODES_MAX)) {
            return false;
        }
        count += (uint64_t)info->level_leaf[above] << shift;
    }
    *out = count;
    return count <= NODES_MAX;
}

static svo_status describe(svo_device *device, const svo_compact_info *info, svo_tree_info *out)
{
    uint64_t count = 0;
    *out = (svo_tree_info){.struct_size = sizeof *out,
                           .depth = info->depth,
                           .snap_bits = info->snap_bits,
                           .coverage = info->coverage,
                           .need = info->need,
                           .constant = info->constant,
                           .weights = info->weights,
                           .payload_level = info->payload_level,
                           .origin = {info->origin[0], info->origin[1], info->origin[2]},
                           .edge = info->edge,
                           .scale = info->scale,
                           .snap_error = info->snap_error,
                           .triangles = info->triangles,
                           .refused_triangles = info->refused_triangles,
                           .fragments = info->fragments};
    for (uint32_t level = 0; level <= info->depth; ++level) {
        if (!count_level(info, level, &count) || out->node_count + count > NODES_MAX) {
            return svo_i_device_fail(device, SVO_UNSUPPORTED, "svo_compact_expand: the tree has more than %u nodes",
                                     NODES_MAX);
        }
        out->inner_count = out->node_count;
        out->node_count += count;
        out->leaf_count = count;
        out->level_begin[level + 1] = (uint32_t)out->node_count;
    }
    return SVO_OK;
}

static uint32_t level_count(const svo_tree_info *info, uint32_t level)
{
    return info->level_begin[level + 1] - info->level_begin[level];
}

/* A compact tree of a few bytes may unfold to any size, and devices that are processors have the host's memory. */
static svo_status check_memory(svo_device *device, const svo_tree_info *info)
{
    uint64_t bytes = 0;
    const uint64_t there_bytes = svo_i_host_memory_bytes();
    for (svo_tree_buffer i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        bytes += svo_i_tree_holds(info, i) ? svo_i_tree_element_count(info, i) * svo_i_tree_element_bytes(i) : 0;
    }
    return bytes <= there_bytes
               ? SVO_OK
               : svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY,
                                   "svo_compact_expand: the tree's %llu nodes need %s, above the %s that are there",
                                   (unsigned long long)info->node_count, svo_i_bytes(bytes).text,
                                   svo_i_bytes(there_bytes).text);
}

/* ---- levels ---- */

static bool has_places_on(const svo_compact_info *info, uint32_t level)
{
    return level >= info->payload_level && svo_i_compact_has_places(info);
}

static svo_status expand_nodes(expansion *e)
{
    const svo_tree_info *info = &e->tree->info;
    cl_mem *const from = (cl_mem *)e->compact->buffers;
    const uint32_t count = level_count(info, e->level);
    const bool last = e->level + 1 == info->depth;
    const svo_compact_params params = {.first_node = info->level_begin[e->level],
                                       .node_count = count,
                                       .child_begin = info->level_begin[e->level + 1],
                                       .keep_below = !last || svo_i_compact_has_places(&e->compact->info)};
    const uint64_t below = params.keep_below != 0 ? level_count(info, e->level + 1) : 0;
    cl_mem counts = NULL;
    cl_mem sums = NULL;
    SVO_I_TRY(svo_i_work_alloc(&e->work, "child_counts", count * UINT64_C(4), &counts));
    SVO_I_TRY(svo_i_work_alloc(&e->work, "child_sums", (count + UINT64_C(1)) * 4, &sums));
    SVO_I_TRY(
        svo_i_work_alloc(&e->work, "expanded", below * svo_i_form_expanded_bytes(e->compact->info.form), &e->below));
    const svo_i_argument masks[] = {SVO_I_ARGUMENT(from[SVO_COMPACT_NODES]),
                                    SVO_I_ARGUMENT(from[SVO_COMPACT_LINKS]),
                                    SVO_I_ARGUMENT(from[SVO_COMPACT_BASES]),
                                    SVO_I_ARGUMENT(e->nodes),
                                    SVO_I_ARGUMENT(e->tree->buffers[SVO_TREE_CHILD_MASK]),
                                    SVO_I_ARGUMENT(counts),
                                    SVO_I_ARGUMENT(params)};
    const svo_i_argument children[] = {SVO_I_ARGUMENT(from[SVO_COMPACT_NODES]),
                                       SVO_I_ARGUMENT(from[SVO_COMPACT_LINKS]),
                                       SVO_I_ARGUMENT(from[SVO_COMPACT_BASES]),
                                       SVO_I_ARGUMENT(e->nodes),
                                       SVO_I_ARGUMENT(e->tree->buffers[SVO_TREE_CHILD_MASK]),
                                       SVO_I_ARGUMENT(sums),
                                       SVO_I_ARGUMENT(e->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                       SVO_I_ARGUMENT(e->below),
                                       SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_work_launch(&e->work, "svo_k_expand_masks", SVO_I_ARGUMENTS(masks), count));
    SVO_I_TRY(svo_i_work_scan(&e->work, counts, sums, count));
    SVO_I_TRY(svo_i_work_launch(&e->work, "svo_k_expand_children", SVO_I_ARGUMENTS(children), count));
    svo_i_work_free(&e->work, &counts);
    svo_i_work_free(&e->work, &sums);
    return SVO_OK;
}

/* The payload of the level's nodes. */
static svo_status expand_payload(expansion *e)
{
    const svo_compact_info *info = &e->compact->info;
    svo_compact_params params = {.node_count = level_count(&e->tree->info, e->level)};
    for (int i = SVO_I_PAYLOAD_FIRST; i < SVO_COMPACT_BUFFER_COUNT && has_places_on(info, e->level); ++i) {
        const svo_compact_buffer buffer = (svo_compact_buffer)i;
        if (info->bytes[i] > 0 && !svo_i_compact_is_constant(info, buffer)) {
            params.payload_begin = e->tree->info.level_begin[e->level] - e->tree->info.level_begin[info->payload_level];
            params.element_halves = (cl_uint)(svo_i_compact_element_bytes(info, buffer) / 2);
            const svo_i_argument arguments[] = {SVO_I_ARGUMENT(e->nodes), SVO_I_ARGUMENT(e->compact->buffers[i]),
                                                SVO_I_ARGUMENT(e->tree->buffers[svo_i_compact_tree_buffer(buffer)]),
                                                SVO_I_ARGUMENT(params)};
            SVO_I_TRY(
                svo_i_work_launch(&e->work, "svo_k_expand_payload", SVO_I_ARGUMENTS(arguments), params.node_count));
        }
    }
    return SVO_OK;
}

/* ---- the tree ---- */

/* All buffers; payload that is constant is copied. */
static svo_status make_buffers(expansion *e)
{
    svo_tree *tree = e->tree;
    for (svo_tree_buffer i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        const uint64_t bytes = svo_i_tree_element_count(&tree->info, i) * svo_i_tree_element_bytes(i);
        if (svo_i_tree_holds(&tree->info, i)) {
            SVO_I_TRY(svo_i_work_result(&e->work, svo_tree_buffer_name(i), bytes, &tree->buffers[i]));
        }
    }
    for (int i = SVO_I_PAYLOAD_FIRST; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        const svo_compact_buffer buffer = (svo_compact_buffer)i;
        if (e->compact->info.bytes[i] > 0 && svo_i_compact_is_constant(&e->compact->info, buffer)) {
            SVO_I_TRY(svo_i_work_copy(&e->work, e->compact->buffers[i], 0,
                                      tree->buffers[svo_i_compact_tree_buffer(buffer)], 0, e->compact->info.bytes[i]));
        }
    }
    return SVO_OK;
}

static svo_status expand(expansion *e)
{
    char defines[128];
    const size_t node_bytes = svo_i_form_expanded_bytes(e->compact->info.form);
    (void)snprintf(defines, sizeof defines, " -DSVO_SORT%s", svo_i_form_defines(&e->compact->info));
    SVO_I_TRY(svo_i_work_use(&e->work, SVO_I_PROGRAM_EXPAND, defines));
    SVO_I_TRY(make_buffers(e));
    SVO_I_TRY(svo_i_work_alloc(&e->work, "expanded", node_bytes, &e->nodes));
    SVO_I_TRY(svo_i_work_fill_zero(&e->work, e->nodes, node_bytes));
    for (e->level = 0; e->level < e->tree->info.depth; ++e->level) {
        SVO_I_TRY(expand_payload(e));
        SVO_I_TRY(expand_nodes(e));
        svo_i_work_free(&e->work, &e->nodes);
        e->nodes = e->below;
    }
    SVO_I_TRY(expand_payload(e));
    return svo_i_work_wait(&e->work);
}

static svo_status check(const svo_compact *compact, const svo_tree *const *out)
{
    static const char function[] = "svo_compact_expand";
    if (compact->device == NULL) {
        return SVO_NOT_ON_DEVICE;
    }
    return out != NULL ? SVO_OK : svo_i_device_fail(compact->device, SVO_INVALID_ARGUMENT, "%s: out is NULL", function);
}

svo_status svo_compact_expand(svo_compact *compact, cl_command_queue queue, svo_tree **out)
{
    static const char function[] = "svo_compact_expand";
    expansion e = {.compact = compact};
    svo_status status = SVO_OK;
    if (compact == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(check(compact, (const svo_tree *const *)out));
    SVO_I_TRY(svo_i_work_begin(compact->device, function, queue, &e.work));
    e.tree = svo_i_tree_new(&compact->device->memory);
    if (e.tree == NULL) {
        status = svo_i_device_fail(compact->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a tree", function);
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(describe(compact->device, &compact->info, &e.tree->info));
    SVO_I_TRY_CLEANUP(check_memory(compact->device, &e.tree->info));
    e.tree->device = compact->device;
    SVO_I_TRY_CLEANUP(expand(&e));
    *out = e.tree;
    e.tree = NULL;

cleanup:
    svo_i_work_end(&e.work);
    svo_tree_destroy(&e.tree);
    return status;
}
