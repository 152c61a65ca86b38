/* SPDX-License-Identifier: MIT */
/*
 * The plan's list of buffers: kept while a build allocates, and predicted before it, with expected counts in place of real
 * ones, in the order in which the builder asks for them, for a list of one chunk.
 */
#include <string.h>

#include "plan.h"
#include "svocl/tree.h"

void svo_i_plan_buffers_reset(svo_plan *plan)
{
    plan->buffer_count = 0;
    plan->live_bytes = 0;
    plan->peak_bytes = 0;
}

void svo_i_plan_buffer_add(svo_plan *plan, const char *name, uint64_t bytes)
{
    plan->live_bytes += bytes;
    plan->peak_bytes = plan->live_bytes > plan->peak_bytes ? plan->live_bytes : plan->peak_bytes;
    for (size_t i = 0; i < plan->buffer_count; ++i) {
        if (strcmp(plan->buffers[i].name, name) == 0) {
            plan->buffers[i].bytes += bytes;
            ++plan->buffers[i].count;
            return;
        }
    }
    if (plan->buffer_count < SVO_I_BUFFERS_MAX) {
        plan->buffers[plan->buffer_count++] = (svo_buffer_info){name, bytes, 1};
    }
}

void svo_i_plan_buffer_remove(svo_plan *plan, uint64_t bytes)
{
    plan->live_bytes -= bytes;
}

/* Nodes expected on the deepest inner level and on the one above. */
static uint64_t expected_parents(const svo_plan *plan)
{
    return svo_i_with_slack(svo_i_plan_expected(plan, plan->info.depth - 1));
}

static uint64_t expected_grandparents(const svo_plan *plan)
{
    return plan->info.depth > 1 ? svo_i_with_slack(svo_i_plan_expected(plan, plan->info.depth - 2)) : 1;
}

/* What is uploaded of the mesh itself, for the lists and for the payload. */
static void predict_geometry(svo_plan *plan, bool with_vertices)
{
    if (with_vertices) {
        svo_i_plan_buffer_add(plan, "vertices", (uint64_t)plan->vertex_count * 12);
    }
    svo_i_plan_buffer_add(plan, "indices", (uint64_t)plan->triangle_count * 12);
}

/* Where lists begin; the scratch is released when they are sorted. */
static void predict_ranges(svo_plan *plan, uint64_t leaves)
{
    svo_i_plan_buffer_add(plan, "list_begin", (leaves + 1) * 4);
    if (plan->options.builder != SVO_BUILDER_SORTED) {
        svo_i_plan_buffer_add(plan, "list_counts", leaves * 4);
    }
}

/* Lists and the geometry they point into, and the scratch that is released when they are sorted. */
static void predict_lists(svo_plan *plan, uint64_t fragments, uint64_t leaves)
{
    const uint64_t long_leaves = fragments / (SVO_SHORT_LIST_MAX + 1) + 1;
    const bool sorted = plan->options.builder == SVO_BUILDER_SORTED; /* lists come packed */
    predict_geometry(plan, true);
    svo_i_plan_buffer_add(plan, "triangle_ids", (uint64_t)plan->triangle_count * 4);
    predict_ranges(plan, leaves);
    svo_i_plan_buffer_add(plan, "list", fragments * 4);
    if (!sorted) {
        svo_i_plan_buffer_add(plan, "list_spare", fragments * 4);
        svo_i_plan_buffer_add(plan, "long_leaves", long_leaves * 4);
        svo_i_plan_buffer_remove(plan, (leaves + fragments + long_leaves) * 4);
    }
}

/* The attributes this mesh has and this request reads. */
static void predict_surface(svo_plan *plan)
{
    const uint64_t vertices = plan->vertex_count;
    if ((plan->info.need & SVO_NEED_RAYS) == 0) {
        predict_geometry(plan, plan->options.weights != SVO_WEIGHTS_UNIFORM);
    }
    svo_i_plan_buffer_add(plan, "records", (uint64_t)plan->triangle_count * sizeof(svo_triangle_record));
    if (plan->colors != NULL) {
        svo_i_plan_buffer_add(plan, "vertex_colors", vertices * 4);
    }
    if (plan->normals != NULL) {
        svo_i_plan_buffer_add(plan, "vertex_normals", vertices * 8);
    }
    if (plan->uvs != NULL) {
        svo_i_plan_buffer_add(plan, "uvs", vertices * 8);
    }
    if (plan->materials != NULL) {
        svo_i_plan_buffer_add(plan, "material_records", plan->material_count * sizeof(svo_material_record));
    }
    if (plan->texels != NULL) {
        svo_i_plan_buffer_add(plan, "texels", plan->texel_count * 4);
    }
}

/* The materials and, where they differ, the entries they are chosen from, which are released when they are. */
static void predict_materials(svo_plan *plan, uint64_t nodes, uint64_t fragments, uint64_t leaves)
{
    const bool own_ranges = (plan->info.need & SVO_NEED_RAYS) == 0;
    const uint64_t levels[2] = {expected_grandparents(plan), expected_parents(plan)};
    if (svo_i_plan_sorts_materials(plan) && own_ranges) {
        predict_ranges(plan, leaves);
        svo_i_plan_buffer_remove(plan, plan->options.builder == SVO_BUILDER_SORTED ? 0 : leaves * 4);
    }
    svo_i_plan_buffer_add(plan, "materials", nodes * 2);
    if (svo_i_plan_sorts_materials(plan)) {
        svo_i_plan_buffer_add(plan, "entry_counts", leaves * 4);
        svo_i_plan_buffer_add(plan, "entry_begins", levels[0] * 4);
        svo_i_plan_buffer_add(plan, "entry_counts", levels[1] * 4);
        svo_i_plan_buffer_add(plan, "entry_begins", levels[1] * 4);
        svo_i_plan_buffer_add(plan, "entries", fragments * 8);
        svo_i_plan_buffer_add(plan, "entries", fragments * 8);
        svo_i_plan_buffer_remove(plan, (leaves + levels[0] + 2 * levels[1]) * 4 + fragments * 16);
        svo_i_plan_buffer_remove(plan, own_ranges ? (leaves + 1) * 4 : 0);
    }
}

/* The sums of the nodes of one level. */
static void predict_sums(svo_plan *plan, uint64_t nodes)
{
    svo_i_plan_buffer_add(plan, "weights", nodes * 8);
    if ((plan->info.need & SVO_NEED_COLOR) != 0) {
        svo_i_plan_buffer_add(plan, "color_sums", nodes * 32);
    }
    if ((plan->info.need & SVO_NEED_NORMAL) != 0) {
        svo_i_plan_buffer_add(plan, "normal_sums", nodes * 24);
    }
}

/* What the filter needs: list heads, the sums of two levels, and the payload itself. */
static void predict_filter(svo_plan *plan, uint64_t nodes, uint64_t leaves)
{
    svo_i_plan_buffer_add(plan, "heads", leaves * 4);
    predict_sums(plan, expected_grandparents(plan));
    predict_sums(plan, expected_parents(plan));
    if ((plan->info.need & SVO_NEED_COLOR) != 0) {
        svo_i_plan_buffer_add(plan, "colors", nodes * 4);
    }
    if ((plan->info.need & SVO_NEED_NORMAL) != 0) {
        svo_i_plan_buffer_add(plan, "normals", nodes * 6);
    }
    if ((plan->info.need & SVO_NEED_FILL) != 0) {
        svo_i_plan_buffer_add(plan, "fills", nodes * 2);
    }
}

static void predict_payload(svo_plan *plan, uint64_t nodes, uint64_t fragments, uint64_t leaves)
{
    if (svo_i_plan_reads_surface(plan)) {
        predict_surface(plan);
    }
    if ((plan->info.need & SVO_NEED_MATERIAL) != 0) {
        predict_materials(plan, nodes, fragments, leaves);
    }
    if ((plan->info.need & SVO_I_NEED_FILTER) != 0) {
        predict_filter(plan, nodes, leaves);
    }
}

/* Nodes from the root down: into pools first, and from there to buffers of their size, one after the other. */
static void predict_nodes(svo_plan *plan, uint64_t fragments, uint64_t inner)
{
    svo_i_plan_buffer_add(plan, "cursors", fragments * 4);
    svo_i_plan_buffer_add(plan, "child_mask_pool", (inner + 3) / 4 * 4);
    svo_i_plan_buffer_add(plan, "first_child_pool", inner * 4);
    svo_i_plan_buffer_add(plan, "state", sizeof(svo_build_state));
    svo_i_plan_buffer_add(plan, "partials", SVO_SCAN_GROUPS * sizeof(uint32_t));
    svo_i_plan_buffer_add(plan, "child_mask", inner);
    svo_i_plan_buffer_remove(plan, (inner + 3) / 4 * 4);
    svo_i_plan_buffer_add(plan, "first_child", inner * 4);
    svo_i_plan_buffer_remove(plan, inner * 4);
}

/* The list in one buffer and a spare one, nodes of their size, and the scratch that is released when they are made. */
static void predict_sorted_nodes(svo_plan *plan, uint64_t fragments, uint64_t inner, uint64_t leaves)
{
    const uint64_t list_bytes = fragments * svo_i_plan_fragment_bytes(plan);
    const uint64_t code_bytes = plan->info.depth > SVO_CODE30_DEPTH_MAX ? 8 : 4;
    const uint64_t cells = (uint64_t)SVO_SORT_DIGITS * SVO_SORT_BLOCKS;
    const uint64_t codes = leaves + expected_parents(plan);
    svo_i_plan_buffer_add(plan, "partials", SVO_SCAN_GROUPS * sizeof(uint32_t));
    svo_i_plan_buffer_add(plan, "sorted", list_bytes);
    svo_i_plan_buffer_remove(plan, list_bytes); /* of the front end's list */
    svo_i_plan_buffer_add(plan, "sorted", list_bytes);
    svo_i_plan_buffer_add(plan, "cursors", fragments * 4);
    svo_i_plan_buffer_add(plan, "sort_counts", cells * 4);
    svo_i_plan_buffer_add(plan, "sort_counts", (cells + 1) * 4);
    svo_i_plan_buffer_add(plan, "level_counts", SVO_LEVELS_MAX * sizeof(uint32_t));
    svo_i_plan_buffer_add(plan, "child_mask", inner);
    svo_i_plan_buffer_add(plan, "first_child", inner * 4);
    svo_i_plan_buffer_add(plan, "begin_flags", fragments * 4);
    svo_i_plan_buffer_add(plan, "begin_flags", (fragments + 1) * 4);
    svo_i_plan_buffer_add(plan, "level_codes", leaves * code_bytes);
    svo_i_plan_buffer_add(plan, "level_codes", expected_parents(plan) * code_bytes);
    svo_i_plan_buffer_remove(plan, list_bytes + (2 * cells + 1 + SVO_LEVELS_MAX + 2 * fragments + 1) * 4 +
                                       codes * code_bytes);
}

void svo_i_plan_predict(svo_plan *plan)
{
    const double expected = svo_i_plan_expected(plan, plan->info.depth);
    const uint64_t fragments =
        plan->options.fragment_capacity != 0 ? plan->options.fragment_capacity : svo_i_with_slack(expected);
    const uint64_t inner = svo_i_plan_inner_nodes(plan, fragments, false);
    const uint64_t leaves = fragments;
    svo_i_plan_buffers_reset(plan);
    svo_i_plan_buffer_add(plan, "fragments", fragments * svo_i_plan_fragment_bytes(plan));
    if (plan->options.builder == SVO_BUILDER_SORTED) {
        predict_sorted_nodes(plan, fragments, inner, leaves);
    } else {
        predict_nodes(plan, fragments, inner);
    }
    if ((plan->info.need & SVO_NEED_RAYS) != 0) {
        predict_lists(plan, fragments, leaves);
    }
    if ((plan->info.need & SVO_I_NEED_PAYLOAD) != 0) {
        predict_payload(plan, inner + leaves, fragments, leaves);
    }
}
