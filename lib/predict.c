/* SPDX-License-Identifier: MIT */
/*
 * The plan's list of buffers: kept while a build allocates, and predicted before it, with expected counts in place of real
 * ones, in the order in which the builder asks for them, for a list of one chunk.
 */
#include <string.h>

#include "plan.h"
#include "rays.h"
#include "tree.h"

void svo_i_plan_buffers_reset(svo_plan *plan)
{
    plan->buffer_count = 0;
    plan->live_bytes = 0;
    plan->peak_bytes = 0;
}

/* What the bytes of a buffer follow from, and whether it stays. */
typedef enum basis { OF_MESH, OF_FRAGMENTS, OF_LEAVES, OF_NODES } basis;

static const struct buffer_kind {
    const char *name;
    basis follows;
    bool stays; /* in the tree */
} kinds[] = {
    {"mesh_vertices", OF_MESH, false},
    {"mesh_indices", OF_MESH, false},
    {"mesh_items", OF_MESH, false},
    {"mesh_tiles", OF_MESH, false},
    {"counters", OF_MESH, false},
    {"fragments", OF_FRAGMENTS, false},
    {"cursors", OF_FRAGMENTS, false},
    {"state", OF_MESH, false},
    {"partials", OF_MESH, false},
    {"child_mask_pool", OF_NODES, false},
    {"first_child_pool", OF_NODES, false},
    {"child_mask", OF_NODES, true},
    {"first_child", OF_NODES, true},
    {"sorted", OF_FRAGMENTS, false},
    {"sort_counts", OF_MESH, false},
    {"level_counts", OF_MESH, false},
    {"begin_flags", OF_FRAGMENTS, false},
    {"level_codes", OF_NODES, false},
    {"vertices", OF_MESH, true},
    {"indices", OF_MESH, true},
    {"triangle_ids", OF_MESH, true},
    {"list_begin", OF_LEAVES, true},
    {"list_counts", OF_LEAVES, false},
    {"list", OF_FRAGMENTS, true},
    {"list_spare", OF_FRAGMENTS, false},
    {"long_leaves", OF_FRAGMENTS, false},
    {"records", OF_MESH, false},
    {"vertex_colors", OF_MESH, false},
    {"vertex_normals", OF_MESH, false},
    {"uvs", OF_MESH, false},
    {"material_records", OF_MESH, false},
    {"texels", OF_MESH, false},
    {"entry_counts", OF_NODES, false},
    {"entry_begins", OF_NODES, false},
    {"entries", OF_FRAGMENTS, false},
    {"heads", OF_LEAVES, false},
    {"weights", OF_NODES, false},
    {"color_sums", OF_NODES, false},
    {"normal_sums", OF_NODES, false},
    {"colors", OF_NODES, true},
    {"normals", OF_NODES, true},
    {"materials", OF_NODES, true},
    {"fills", OF_NODES, true},
};

static const struct buffer_kind *kind_of(const char *name)
{
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i) {
        if (strcmp(kinds[i].name, name) == 0) {
            return &kinds[i];
        }
    }
    return NULL;
}

/* Vertices and indices stay where lists do; payload that is the same everywhere is one value. */
static bool stays(const svo_plan *plan, const struct buffer_kind *kind)
{
    const bool geometry = kind->follows == OF_MESH;
    return kind->stays && (!geometry || plan->work.lists);
}

static svo_certainty certainty_of(const svo_plan *plan, const struct buffer_kind *kind, uint64_t bytes)
{
    const bool one_value = kind->stays && kind->follows == OF_NODES && bytes <= 6;
    if (kind->follows == OF_MESH || one_value || plan->built) {
        return SVO_BYTES_EXACT;
    }
    if (!plan->counted || kind->follows == OF_NODES) {
        return SVO_BYTES_ESTIMATE;
    }
    return kind->follows == OF_FRAGMENTS ? SVO_BYTES_EXACT : SVO_BYTES_BOUND;
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
    const struct buffer_kind *kind = kind_of(name);
    if (plan->buffer_count < SVO_I_BUFFERS_MAX) {
        svo_buffer_info *buffer = &plan->buffers[plan->buffer_count++];
        *buffer = (svo_buffer_info){.name = name, .bytes = bytes, .count = 1};
        buffer->certainty = kind != NULL ? certainty_of(plan, kind, bytes) : SVO_BYTES_ESTIMATE;
        buffer->stays = kind != NULL && stays(plan, kind);
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
    if (!plan->work.sorted) {
        svo_i_plan_buffer_add(plan, "list_counts", leaves * 4);
    }
}

/* What rays read: a node for every second level, from the leaves' grandparents up. */
static uint64_t expected_ray_nodes(const svo_plan *plan)
{
    uint64_t nodes = 1;
    for (uint32_t level = plan->info.depth; level >= 2; level -= 2) {
        nodes += svo_i_with_slack(svo_i_plan_expected(plan, level - 2));
    }
    return nodes;
}

/* Lists and the geometry they point into, and the scratch that is released when they are sorted. */
static void predict_lists(svo_plan *plan, uint64_t fragments, uint64_t leaves)
{
    const uint64_t long_leaves = fragments / (SVO_SHORT_LIST_MAX + 1) + 1;
    predict_geometry(plan, true);
    svo_i_plan_buffer_add(plan, "triangle_ids", (uint64_t)plan->triangle_count * 4);
    predict_ranges(plan, leaves);
    svo_i_plan_buffer_add(plan, "list", fragments * 4);
    if (!plan->work.sorted) { /* else lists come packed */
        svo_i_plan_buffer_add(plan, "list_spare", fragments * 4);
        svo_i_plan_buffer_add(plan, "long_leaves", long_leaves * 4);
        svo_i_plan_buffer_remove(plan, (leaves + fragments + long_leaves) * 4);
    }
}

/* The attributes this mesh has and this request reads. */
static void predict_surface(svo_plan *plan)
{
    const uint64_t vertices = plan->vertex_count;
    if (!plan->work.lists) {
        predict_geometry(plan, plan->work.places);
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
    const bool own_ranges = !plan->work.lists;
    const uint64_t levels[2] = {expected_grandparents(plan), expected_parents(plan)};
    if (own_ranges) {
        predict_ranges(plan, leaves);
        svo_i_plan_buffer_remove(plan, plan->work.sorted ? 0 : leaves * 4);
    }
    svo_i_plan_buffer_add(plan, "materials", nodes * 2);
    svo_i_plan_buffer_add(plan, "entry_counts", leaves * 4);
    svo_i_plan_buffer_add(plan, "entry_begins", levels[0] * 4);
    svo_i_plan_buffer_add(plan, "entry_counts", levels[1] * 4);
    svo_i_plan_buffer_add(plan, "entry_begins", levels[1] * 4);
    svo_i_plan_buffer_add(plan, "entries", fragments * 8);
    svo_i_plan_buffer_add(plan, "entries", fragments * 8);
    svo_i_plan_buffer_remove(plan, (leaves + levels[0] + 2 * levels[1]) * 4 + fragments * 16);
    svo_i_plan_buffer_remove(plan, own_ranges ? (leaves + 1) * 4 : 0);
}

/* The sums of the nodes of one level. */
static void predict_sums(svo_plan *plan, uint64_t nodes)
{
    svo_i_plan_buffer_add(plan, "weights", nodes * 8);
    if ((plan->work.made & SVO_NEED_COLOR) != 0) {
        svo_i_plan_buffer_add(plan, "color_sums", nodes * 32);
    }
    if ((plan->work.made & SVO_NEED_NORMAL) != 0) {
        svo_i_plan_buffer_add(plan, "normal_sums", nodes * 24);
    }
}

/* What the filter needs: list heads, the sums of two levels, and the payload itself. */
static void predict_filter(svo_plan *plan, uint64_t nodes, uint64_t leaves)
{
    svo_i_plan_buffer_add(plan, "heads", leaves * 4);
    predict_sums(plan, expected_grandparents(plan));
    predict_sums(plan, expected_parents(plan));
    if ((plan->work.made & SVO_NEED_COLOR) != 0) {
        svo_i_plan_buffer_add(plan, "colors", nodes * 4);
    }
    if ((plan->work.made & SVO_NEED_NORMAL) != 0) {
        svo_i_plan_buffer_add(plan, "normals", nodes * 6);
    }
    if ((plan->work.made & SVO_NEED_FILL) != 0) {
        svo_i_plan_buffer_add(plan, "fills", nodes * 2);
    }
}

static void predict_payload(svo_plan *plan, uint64_t nodes, uint64_t fragments, uint64_t leaves)
{
    if (plan->work.surface) {
        predict_surface(plan);
    }
    if ((plan->work.made & SVO_NEED_MATERIAL) != 0) {
        predict_materials(plan, nodes, fragments, leaves);
    }
    if (plan->work.filter) {
        predict_filter(plan, nodes, leaves);
    }
}

/* Payload that is the same in every node. */
static void predict_constants(svo_plan *plan)
{
    static const svo_need bits[] = {SVO_NEED_COLOR, SVO_NEED_NORMAL, SVO_NEED_MATERIAL};
    static const svo_tree_buffer arrays[] = {SVO_TREE_COLORS, SVO_TREE_NORMALS, SVO_TREE_MATERIALS};
    for (unsigned i = 0; i < 3; ++i) {
        if ((plan->work.constant & (uint32_t)bits[i]) != 0) {
            svo_i_plan_buffer_add(plan, svo_tree_buffer_name(arrays[i]), svo_i_tree_element_bytes(arrays[i]));
        }
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
    const uint64_t code_bytes = plan->work.long_codes ? 8 : 4;
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
    svo_i_plan_buffer_add(plan, "state", sizeof(svo_build_state));
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
    if (plan->work.sorted) {
        predict_sorted_nodes(plan, fragments, inner, leaves);
    } else {
        predict_nodes(plan, fragments, inner);
    }
    if (plan->work.lists) {
        predict_lists(plan, fragments, leaves);
    }
    predict_payload(plan, inner + leaves, fragments, leaves);
    predict_constants(plan);
    if (plan->work.lists) {
        svo_i_plan_buffer_add(plan, "ray_triangles", fragments * SVO_I_RAY_TRIANGLE_BYTES);
        svo_i_plan_buffer_add(plan, "ray_nodes", expected_ray_nodes(plan) * SVO_I_RAY_NODE_BYTES);
    }
}
