/* SPDX-License-Identifier: MIT */
/*
 * svo_compact_plan and svo_compact_create: options, checks, and the way from a tree to its compact form; and
 * svo_compact_expand: a compact tree becomes a built one again, by kernels/compact/expand.cl.
 */
#include "compact/compact.h"

#include <stdio.h>

#include "compact/form.h"
#include "compact/programs.h"
#include "core/device.h"
#include "core/memory.h"
#include "core/struct_size.h"
#include "core/tree.h"
#include "shared/layout.h"
#include "svocl/plan.h"

/* The default of directory_step_log2, below 0.40 bytes a leaf on measured scenes. */
#define DIRECTORY_LOG2 5u

/* With twice as many words every index of a word fits 32 bits. */
#define INNER_MAX 0x7fffffffu

/* The largest tolerances, with which any values are near enough. */
#define COLOR_TOLERANCE_MAX  255u
#define NORMAL_TOLERANCE_MAX 65534u
#define FILL_TOLERANCE_MAX   65535u

/* Node indices and their counts have 32 bits, and SVO_NO_NODE is none. */
#define NODES_MAX 0xfffffffeu

/* ---- plan ---- */

static svo_status check_tolerance(svo_device *device, const char *function, const char *name, uint32_t tolerance,
                                  uint32_t most)
{
    return tolerance <= most ? SVO_OK
                             : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.%s %u is above %u",
                                                 function, name, tolerance, most);
}

static svo_status check_tolerances(svo_device *device, const char *function, const svo_compact_options *options)
{
    for (int channel = 0; channel < 4; ++channel) {
        SVO_I_TRY(check_tolerance(device, function, "color_tolerance", options->color_tolerance[channel],
                                  COLOR_TOLERANCE_MAX));
    }
    SVO_I_TRY(check_tolerance(device, function, "normal_tolerance", options->normal_tolerance, NORMAL_TOLERANCE_MAX));
    return check_tolerance(device, function, "fill_tolerance", options->fill_tolerance, FILL_TOLERANCE_MAX);
}

svo_status svo_i_compact_options(svo_device *device, const char *function, const svo_compact_options *options,
                                 svo_compact_options *out)
{
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(device), function, "options", options, out,
                                SVO_I_STRUCT_SIZES(svo_compact_options, fill_tolerance)));
    if ((unsigned)out->form >= SVO_FORM_COUNT) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.form %d is not in 0 .. %d", function,
                                 (int)out->form, (int)SVO_FORM_COUNT - 1);
    }
    if (out->directory_step_log2 == 0) {
        out->directory_step_log2 = DIRECTORY_LOG2;
    }
    if (out->directory_step_log2 < SVO_I_DIRECTORY_LOG2_MIN || out->directory_step_log2 > SVO_I_DIRECTORY_LOG2_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: options.directory_step_log2 %u is not 0 and not in %u .. %u", function,
                                 out->directory_step_log2, SVO_I_DIRECTORY_LOG2_MIN, SVO_I_DIRECTORY_LOG2_MAX);
    }
    SVO_I_TRY(check_tolerances(device, function, out));
    if ((out->leave_out & ~(uint32_t)SVO_NEED_ALL) != 0) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.leave_out 0x%x has bits outside 0x%x",
                                 function, out->leave_out, (unsigned)SVO_NEED_ALL);
    }
    return SVO_OK;
}

static svo_status check_counts(svo_device *device, const char *function, const svo_tree *tree)
{
    return tree->info.inner_count <= INNER_MAX
               ? SVO_OK
               : svo_i_device_fail(device, SVO_UNSUPPORTED, "%s: %llu inner nodes are above %u", function,
                                   (unsigned long long)tree->info.inner_count, INNER_MAX);
}

/* The arrays whose size is not known before the nodes are looked at. */
static uint32_t find_bounds(const svo_compact_options *options, const svo_compact_info *planned)
{
    uint32_t bounds = 0;
    for (int i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        const bool has_nodes = i == SVO_COMPACT_NODES;
        const bool beside_words = i == SVO_COMPACT_BASES && planned->form == SVO_FORM_DESCRIPTOR;
        const bool by_words = (has_nodes || beside_words) && planned->far_count > 0;
        const bool by_subtrees = has_nodes && (planned->form == SVO_FORM_SHARED || planned->form == SVO_FORM_MIRRORED);
        const bool by_leaves = options->minimize != 0 && !svo_i_compact_is_constant(planned, (svo_compact_buffer)i);
        bounds |= planned->bytes[i] > 0 && (by_words || by_subtrees || by_leaves) ? 1u << i : 0;
    }
    return bounds;
}

svo_status svo_compact_plan(const svo_tree *tree, const svo_compact_options *options, svo_compact_info *info)
{
    static const char function[] = "svo_compact_plan";
    svo_compact_options asked;
    svo_compact_info planned;
    SVO_I_TRY(svo_i_tree_check(tree, function));
    SVO_I_TRY(svo_i_compact_options(tree->device, function, options, &asked));
    SVO_I_TRY(check_counts(tree->device, function, tree));
    svo_i_source_describe(&tree->info, &asked, &planned);
    svo_i_form_count(&planned);
    planned.bounds = find_bounds(&asked, &planned);
    return svo_i_struct_write(svo_i_device_message(tree->device), function, "info", &planned, info,
                              SVO_I_STRUCT_SIZES(svo_compact_info, bounds));
}

/* ---- creation ---- */

/* Refuses a tree that is on another device or nowhere. */
static svo_status check_place(svo_device *device, const svo_tree *tree, const char *function)
{
    if (tree->device != NULL && tree->device != device) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: the tree is on another device", function);
    }
    if (tree->buffers[SVO_TREE_CHILD_MASK] == NULL && tree->host[SVO_TREE_CHILD_MASK] == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: the tree is neither on the device nor on the host",
                                 function);
    }
    return SVO_OK;
}

static svo_status make_compact(svo_device *device, const svo_tree *tree, const svo_compact_options *asked,
                               cl_command_queue queue, svo_compact *compact)
{
    svo_i_compact_source source;
    svo_i_device_work work;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin(device, "svo_compact_create", queue, &work));
    SVO_I_TRY_CLEANUP(svo_i_source_of_tree(&work, tree, asked, &source));
    if (asked->minimize != 0) {
        SVO_I_TRY_CLEANUP(svo_i_minimize(&work, asked, &source));
    }
    compact->info = source.info;
    compact->device = device;
    SVO_I_TRY_CLEANUP(svo_i_form_make(&work, &source, compact));
    SVO_I_TRY_CLEANUP(svo_i_work_wait(&work));

cleanup:
    svo_i_work_end(&work);
    return status;
}

svo_status svo_compact_create(svo_device *device, const svo_tree *tree, const svo_compact_options *options,
                              cl_command_queue queue, svo_compact **out)
{
    static const char function[] = "svo_compact_create";
    svo_compact_options asked;
    svo_compact *compact = NULL;
    if (device == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (tree == NULL || out == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 tree == NULL ? "tree" : "out");
    }
    SVO_I_TRY(svo_i_compact_options(device, function, options, &asked));
    const char *undefined = svo_i_tree_undefined(tree);
    if (undefined != NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s", function, undefined);
    }
    SVO_I_TRY(check_place(device, tree, function));
    SVO_I_TRY(check_counts(device, function, tree));
    compact = svo_i_compact_new(&device->memory);
    if (compact == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a compact tree", function);
    }
    const svo_status status = make_compact(device, tree, &asked, queue, compact);
    if (status != SVO_OK) {
        svo_compact_destroy(&compact);
        return status;
    }
    *out = compact;
    return SVO_OK;
}

static svo_status share(svo_device *device, const char *function, const svo_tree *tree, cl_command_queue queue,
                        svo_compact *compact)
{
    svo_i_device_work work;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin(device, function, queue, &work));
    compact->device = device;
    SVO_I_TRY_CLEANUP(svo_i_form_share(&work, tree, compact));
    SVO_I_TRY_CLEANUP(svo_i_work_wait(&work));

cleanup:
    svo_i_work_end(&work);
    return status;
}

svo_status svo_i_compact_share(svo_device *device, const char *function, const svo_tree *tree,
                               const svo_compact_options *asked, cl_command_queue queue, svo_compact **out)
{
    SVO_I_TRY(check_counts(device, function, tree));
    svo_compact *compact = svo_i_compact_new(&device->memory);
    if (compact == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a compact tree", function);
    }
    svo_i_source_describe(&tree->info, asked, &compact->info);
    const svo_status status = share(device, function, tree, queue, compact);
    if (status != SVO_OK) {
        svo_compact_destroy(&compact);
        return status;
    }
    *out = compact;
    return SVO_OK;
}

/* ---- expansion ---- */

typedef struct expansion {
    svo_i_device_work work;
    const svo_compact *compact;
    svo_tree *tree;
    cl_mem payload[SVO_I_PAYLOAD_COUNT]; /* not packed: of the compact tree, or scratch */
    uint32_t level;
    cl_mem nodes; /* svo_expanded of the level's nodes; scratch */
    cl_mem below; /* those of the next level */
} expansion;

/* Bytes of svo_expanded in kernels/compact/expand.cl. */
static size_t expanded_bytes(svo_form form)
{
    const size_t node_words = form == SVO_FORM_SHARED || form == SVO_FORM_MIRRORED ? 3 : 1;
    return (node_words + 2) * sizeof(cl_uint);
}

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
                           .triangles = info->triangles,
                           .refused_triangles = info->refused_triangles,
                           .fragments = info->fragments,
                           .is_exact = info->is_exact};
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
    SVO_I_TRY(svo_i_work_alloc(&e->work, "expanded", below * expanded_bytes(e->compact->info.form), &e->below));
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
            const svo_i_argument arguments[] = {
                SVO_I_ARGUMENT(e->nodes), SVO_I_ARGUMENT(e->payload[i - SVO_I_PAYLOAD_FIRST]),
                SVO_I_ARGUMENT(e->tree->buffers[svo_i_compact_tree_buffer(buffer)]), SVO_I_ARGUMENT(params)};
            SVO_I_TRY(
                svo_i_work_launch(&e->work, "svo_k_expand_payload", SVO_I_ARGUMENTS(arguments), params.node_count));
        }
    }
    return SVO_OK;
}

/* All buffers; payload that is constant is copied. */
static svo_status make_buffers(expansion *e)
{
    svo_tree *tree = e->tree;
    for (svo_tree_buffer i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        const uint64_t bytes = svo_i_tree_element_count(&tree->info, i) * svo_i_tree_element_bytes(i);
        if (svo_i_tree_holds(&tree->info, i)) {
            SVO_I_TRY(svo_i_work_result(&e->work, svo_name(SVO_NAME_TREE_BUFFER, i), bytes, &tree->buffers[i]));
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

/* Packed arrays as they were before, in scratch buffers. */
static svo_status unpack(expansion *e)
{
    const svo_compact_info *info = &e->compact->info;
    svo_compact_params params = {.node_count = (cl_uint)info->payload_count};
    for (int k = 0; k < SVO_I_PAYLOAD_COUNT; ++k) {
        const svo_compact_buffer buffer = (svo_compact_buffer)(SVO_I_PAYLOAD_FIRST + k);
        cl_mem packed = e->compact->buffers[buffer];
        e->payload[k] = packed;
        if (svo_i_compact_is_packed(info, buffer)) {
            const size_t bytes = svo_i_compact_element_bytes(info, buffer);
            params.element_halves = (cl_uint)(bytes / 2);
            SVO_I_TRY(svo_i_work_alloc(&e->work, "unpacked", info->payload_count * bytes, &e->payload[k]));
            const svo_i_argument arguments[] = {SVO_I_ARGUMENT(packed), SVO_I_ARGUMENT(e->payload[k]),
                                                SVO_I_ARGUMENT(params)};
            SVO_I_TRY(svo_i_work_launch(&e->work, "svo_k_unpack", SVO_I_ARGUMENTS(arguments), info->payload_count));
        }
    }
    return SVO_OK;
}

static svo_status expand(expansion *e)
{
    char defines[128];
    const size_t node_bytes = expanded_bytes(e->compact->info.form);
    (void)snprintf(defines, sizeof defines, " -DSVO_SORT%s%s", svo_i_form_defines(&e->compact->info),
                   e->compact->info.packed != 0 ? " -DSVO_PACKED" : "");
    SVO_I_TRY(svo_i_work_use(&e->work, &svo_i_program_expand, defines));
    SVO_I_TRY(make_buffers(e));
    SVO_I_TRY(unpack(e));
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
