/* SPDX-License-Identifier: MIT */
/* A built tree as the source of encoders, and full leaves merged by kernels/compact/minimize.cl. */
#include "compact/source.h"

#include <stdio.h>
#include <string.h>

#include "compact/programs.h"
#include "core/device.h"
#include "core/tree.h"
#include "shared/layout.h"
#include "svocl/plan.h"

/* ---- description ---- */

void svo_i_source_describe(const svo_tree_info *tree, const svo_compact_options *options, svo_compact_info *out)
{
    const uint32_t need = tree->need & SVO_I_PAYLOAD_NEEDS & ~options->leave_out;
    *out = (svo_compact_info){.struct_size = sizeof *out,
                              .form = options->form,
                              .depth = tree->depth,
                              .snap_bits = tree->snap_bits,
                              .coverage = tree->coverage,
                              .need = need,
                              .constant = tree->constant & need,
                              .weights = tree->weights,
                              .payload_level = tree->payload_level,
                              .origin = {tree->origin[0], tree->origin[1], tree->origin[2]},
                              .edge = tree->edge,
                              .scale = tree->scale,
                              .triangles = tree->triangles,
                              .refused_triangles = tree->refused_triangles,
                              .fragments = tree->fragments,
                              .is_exact = tree->is_exact};
    for (uint32_t level = 0; level < tree->depth; ++level) {
        out->level_inner[level] = tree->level_begin[level + 1] - tree->level_begin[level];
    }
    out->level_leaf[tree->depth] = (uint32_t)tree->leaf_count;
    if (options->form == SVO_FORM_IMPLIED) {
        out->directory_step_log2 = options->directory_step_log2;
    }
}

/* ---- arrays ---- */

/* An array of the tree on the device: its own, or a copy that the work owns. */
static svo_status find_array(svo_i_device_work *work, const svo_tree *tree, svo_tree_buffer buffer, cl_mem *out)
{
    const uint64_t bytes = svo_i_tree_element_count(&tree->info, buffer) * svo_i_tree_element_bytes(buffer);
    *out = tree->buffers[buffer];
    if (*out != NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_alloc(work, svo_name(SVO_NAME_TREE_BUFFER, buffer), bytes, out));
    return svo_i_work_write(work, *out, tree->host[buffer], bytes);
}

/* Leaf masks of a built tree: on level depth - 1 all children are leaves, above there are none. */
static svo_status make_leaf_masks(svo_i_device_work *work, svo_i_compact_source *source)
{
    const svo_compact_info *info = &source->info;
    const uint64_t inner_count = svo_i_source_level_begin(info, info->depth);
    const uint32_t begin = svo_i_source_level_begin(info, info->depth - 1);
    SVO_I_TRY(svo_i_work_alloc(work, "leaf_masks", inner_count, &source->leaf));
    SVO_I_TRY(svo_i_work_fill_zero(work, source->leaf, inner_count));
    return svo_i_work_copy(work, source->valid, begin, source->leaf, begin, inner_count - begin);
}

svo_status svo_i_source_of_tree(svo_i_device_work *work, const svo_tree *tree, const svo_compact_options *options,
                                svo_i_compact_source *source)
{
    *source = (svo_i_compact_source){.payload_begin = tree->info.level_begin[tree->info.payload_level]};
    svo_i_source_describe(&tree->info, options, &source->info);
    SVO_I_TRY(find_array(work, tree, SVO_TREE_CHILD_MASK, &source->valid));
    SVO_I_TRY(find_array(work, tree, SVO_TREE_FIRST_CHILD, &source->first_inner));
    source->first_payload = source->first_inner;
    for (int i = 0; i < SVO_I_PAYLOAD_COUNT; ++i) {
        const svo_compact_buffer buffer = (svo_compact_buffer)(SVO_I_PAYLOAD_FIRST + i);
        if ((source->info.need & svo_i_compact_need(buffer)) != 0) {
            SVO_I_TRY(find_array(work, tree, svo_i_compact_tree_buffer(buffer), &source->payload[i]));
        }
    }
    return make_leaf_masks(work, source);
}

/* ---- minimizing ---- */

/* The kernels' arguments for payload, in their order. */
enum { COLORS, NORMALS, MATERIALS, FILLS, COMPARED_COUNT };

typedef struct minimizer {
    svo_i_device_work *work;
    svo_i_compact_source *source;
    uint32_t inner_count; /* before */
    svo_minimize_params params; /* what all launches have in common */
    cl_mem compared[COMPARED_COUNT]; /* payload that is held and not constant; NULL: none */
    cl_mem places; /* u32 per inner node: of its payload */
    cl_mem bounds[2]; /* of the level's nodes, and of those of the level below */
    cl_mem merged; /* u8 per inner node */
    cl_mem leaves; /* u8 per inner node */
    cl_mem kept, counts; /* u32 per inner node */
    cl_mem inner_sums, child_sums; /* exclusive sums of the two, with the totals */
    cl_mem origins; /* u32 per new payload; NULL: none is held */
    uint32_t inner_begin[SVO_LEVELS_MAX]; /* the new nodes: first inner node of each level, and their number */
    uint32_t child_begin[SVO_LEVELS_MAX]; /* the first node, leaves included, of the level below each, less one */
} minimizer;

/* The payload that is compared: its kernel argument, array, and define. */
typedef struct compared_payload {
    int argument;
    svo_compact_buffer buffer;
    const char *define;
} compared_payload;

static const compared_payload compared_payloads[COMPARED_COUNT] = {
    {COLORS, SVO_COMPACT_COLORS, " -DSVO_COLOR"},
    {NORMALS, SVO_COMPACT_NORMALS, " -DSVO_NORMAL"},
    {MATERIALS, SVO_COMPACT_MATERIALS, " -DSVO_MATERIAL"},
    {FILLS, SVO_COMPACT_FILLS, " -DSVO_FILL"},
};

/* Selects the payload that differs between nodes, and the kernels that compare it. Fills are replaced by a copy, since
   merged nodes store others. */
static svo_status prepare_payload(minimizer *m)
{
    svo_i_compact_source *source = m->source;
    char defines[SVO_I_PROGRAM_DEFINES_BYTES] = " -DSVO_SORT -DSVO_NO_TEST";
    for (int i = 0; i < COMPARED_COUNT; ++i) {
        const compared_payload *which = &compared_payloads[i];
        const cl_mem held = source->payload[which->buffer - SVO_I_PAYLOAD_FIRST];
        if (held != NULL && !svo_i_compact_is_constant(&source->info, which->buffer)) {
            m->compared[which->argument] = held;
            (void)strncat(defines, which->define, sizeof defines - strlen(defines) - 1);
        }
    }
    if (svo_i_compact_has_places(&source->info)) {
        (void)strncat(defines, " -DSVO_COMPARE", sizeof defines - strlen(defines) - 1);
    }
    if (m->compared[FILLS] != NULL) {
        const uint64_t bytes = source->info.payload_count * sizeof(cl_ushort);
        cl_mem copy = NULL;
        SVO_I_TRY(svo_i_work_alloc(m->work, "minimize_fills", bytes, &copy));
        SVO_I_TRY(svo_i_work_copy(m->work, m->compared[FILLS], 0, copy, 0, bytes));
        m->compared[FILLS] = copy;
        source->payload[SVO_COMPACT_FILLS - SVO_I_PAYLOAD_FIRST] = copy;
    }
    return svo_i_work_use(m->work, &svo_i_program_minimize, defines);
}

static svo_status allocate(minimizer *m)
{
    const uint64_t inner = m->inner_count;
    const bool compare = svo_i_compact_has_places(&m->source->info);
    uint64_t widest = 1;
    for (uint32_t level = 0; level < m->source->info.depth && compare; ++level) {
        widest = m->source->info.level_inner[level] > widest ? m->source->info.level_inner[level] : widest;
    }
    SVO_I_TRY(svo_i_work_alloc(m->work, "minimize_places", inner * 4, &m->places));
    SVO_I_TRY(svo_i_work_alloc(m->work, "minimize_bounds", widest * SVO_MINIMIZE_BOUNDS_BYTES, &m->bounds[0]));
    SVO_I_TRY(svo_i_work_alloc(m->work, "minimize_bounds", widest * SVO_MINIMIZE_BOUNDS_BYTES, &m->bounds[1]));
    SVO_I_TRY(svo_i_work_alloc(m->work, "minimize_merged", inner, &m->merged));
    return svo_i_work_alloc(m->work, "minimize_leaves", inner, &m->leaves);
}

/* The arguments of a level's launch. */
static svo_minimize_params params_of_level(const minimizer *m, uint32_t level)
{
    const svo_compact_info *info = &m->source->info;
    const uint32_t first_merged = svo_i_compact_has_places(info) ? info->payload_level : 0;
    svo_minimize_params params = m->params;
    params.first_node = svo_i_source_level_begin(info, level);
    params.node_count = info->level_inner[level];
    params.child_first = svo_i_source_level_begin(info, level + 1);
    params.merge = level > 0 && level >= first_merged ? 1 : 0;
    return params;
}

/* ---- the two passes ---- */

static svo_status merge_levels(minimizer *m)
{
    const svo_i_compact_source *source = m->source;
    SVO_I_TRY(svo_i_work_fill_zero(m->work, m->places, sizeof(cl_uint)));
    for (uint32_t level = 0; level < source->info.depth && svo_i_compact_has_places(&source->info); ++level) {
        const svo_minimize_params params = params_of_level(m, level);
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(source->valid),       SVO_I_ARGUMENT(source->leaf),
                                            SVO_I_ARGUMENT(source->first_inner), SVO_I_ARGUMENT(source->first_payload),
                                            SVO_I_ARGUMENT(m->places),           SVO_I_ARGUMENT(params)};
        SVO_I_TRY(svo_i_work_launch(m->work, "svo_k_minimize_places", SVO_I_ARGUMENTS(arguments), params.node_count));
    }
    for (uint32_t level = source->info.depth; level-- > 0;) {
        const svo_minimize_params params = params_of_level(m, level);
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(source->valid),
                                            SVO_I_ARGUMENT(source->leaf),
                                            SVO_I_ARGUMENT(source->first_inner),
                                            SVO_I_ARGUMENT(source->first_payload),
                                            SVO_I_ARGUMENT(m->places),
                                            SVO_I_ARGUMENT(m->compared[COLORS]),
                                            SVO_I_ARGUMENT(m->compared[NORMALS]),
                                            SVO_I_ARGUMENT(m->compared[MATERIALS]),
                                            SVO_I_ARGUMENT(m->compared[FILLS]),
                                            SVO_I_ARGUMENT(m->bounds[(level + 1) % 2]),
                                            SVO_I_ARGUMENT(m->bounds[level % 2]),
                                            SVO_I_ARGUMENT(m->merged),
                                            SVO_I_ARGUMENT(m->leaves),
                                            SVO_I_ARGUMENT(params)};
        SVO_I_TRY(svo_i_work_launch(m->work, "svo_k_minimize_merge", SVO_I_ARGUMENTS(arguments), params.node_count));
    }
    return SVO_OK;
}

/* Reads where the levels of what remains begin. */
static svo_status read_counts(minimizer *m)
{
    const svo_compact_info *info = &m->source->info;
    const svo_compact_params params = {.node_count = info->depth + 1};
    cl_uint before[SVO_LEVELS_MAX];
    cl_uint2 after[SVO_LEVELS_MAX];
    cl_mem level_begin = NULL;
    cl_mem levels = NULL;
    for (uint32_t level = 0; level <= info->depth; ++level) {
        before[level] = svo_i_source_level_begin(info, level);
    }
    SVO_I_TRY(svo_i_work_constants(m->work, "minimize_level_begin", before, params.node_count * sizeof before[0],
                                   &level_begin));
    SVO_I_TRY(svo_i_work_alloc(m->work, "minimize_levels", params.node_count * sizeof after[0], &levels));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(level_begin), SVO_I_ARGUMENT(m->inner_sums),
                                        SVO_I_ARGUMENT(m->child_sums), SVO_I_ARGUMENT(levels), SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_work_launch(m->work, "svo_k_minimize_levels", SVO_I_ARGUMENTS(arguments), params.node_count));
    SVO_I_TRY(svo_i_work_read(m->work, levels, 0, after, params.node_count * sizeof after[0]));
    for (uint32_t level = 0; level <= info->depth; ++level) {
        m->inner_begin[level] = after[level].s[0];
        m->child_begin[level] = after[level].s[1];
    }
    svo_i_work_free(m->work, &level_begin);
    svo_i_work_free(m->work, &levels);
    return SVO_OK;
}

static svo_status keep_levels(minimizer *m)
{
    const svo_i_compact_source *source = m->source;
    const uint64_t bytes = m->inner_count * UINT64_C(4);
    const cl_uint keep = 1;
    svo_i_work_free(m->work, &m->bounds[0]);
    svo_i_work_free(m->work, &m->bounds[1]);
    svo_i_work_free(m->work, &m->places);
    SVO_I_TRY(svo_i_work_alloc(m->work, "minimize_kept", bytes, &m->kept));
    SVO_I_TRY(svo_i_work_alloc(m->work, "minimize_counts", bytes, &m->counts));
    SVO_I_TRY(svo_i_work_alloc(m->work, "minimize_inner_sums", bytes + 4, &m->inner_sums));
    SVO_I_TRY(svo_i_work_alloc(m->work, "minimize_child_sums", bytes + 4, &m->child_sums));
    SVO_I_TRY(svo_i_work_write(m->work, m->kept, &keep, sizeof keep));
    for (uint32_t level = 0; level < source->info.depth; ++level) {
        const svo_minimize_params params = params_of_level(m, level);
        const svo_i_argument arguments[] = {
            SVO_I_ARGUMENT(source->valid), SVO_I_ARGUMENT(source->leaf), SVO_I_ARGUMENT(source->first_inner),
            SVO_I_ARGUMENT(m->merged),     SVO_I_ARGUMENT(m->kept),      SVO_I_ARGUMENT(m->counts),
            SVO_I_ARGUMENT(params)};
        SVO_I_TRY(svo_i_work_launch(m->work, "svo_k_minimize_keep", SVO_I_ARGUMENTS(arguments), params.node_count));
    }
    SVO_I_TRY(svo_i_work_scan(m->work, m->kept, m->inner_sums, m->inner_count));
    SVO_I_TRY(svo_i_work_scan(m->work, m->counts, m->child_sums, m->inner_count));
    return read_counts(m);
}

/* ---- what remains ---- */

/* Replaces the payload arrays by those of the nodes that remain. */
static svo_status gather_payload(minimizer *m, uint64_t payload_count)
{
    svo_i_compact_source *source = m->source;
    svo_compact_params params = {.node_count = (cl_uint)payload_count};
    for (int i = 0; i < COMPARED_COUNT; ++i) {
        const compared_payload *which = &compared_payloads[i];
        cl_mem *held = &source->payload[which->buffer - SVO_I_PAYLOAD_FIRST];
        cl_mem gathered = NULL;
        if (m->compared[which->argument] == NULL) {
            continue;
        }
        const size_t element_bytes = svo_i_compact_element_bytes(&source->info, which->buffer);
        params.element_halves = (cl_uint)element_bytes / 2;
        SVO_I_TRY(svo_i_work_alloc(m->work, "minimize_payload", payload_count * element_bytes, &gathered));
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(m->origins), SVO_I_ARGUMENT(*held), SVO_I_ARGUMENT(gathered),
                                            SVO_I_ARGUMENT(params)};
        SVO_I_TRY(svo_i_work_launch(m->work, "svo_k_compact_gather", SVO_I_ARGUMENTS(arguments), payload_count));
        svo_i_work_free(m->work, held); /* the copy of the fills; other arrays are not the work's */
        *held = gathered;
    }
    return SVO_OK;
}

/* The new arrays of nodes, and payload_count origins. */
static svo_status gather_nodes(minimizer *m, uint64_t payload_count)
{
    svo_i_compact_source *source = m->source;
    const uint64_t inner = m->inner_begin[source->info.depth];
    cl_mem arrays[4] = {NULL, NULL, NULL, NULL};
    svo_minimize_params params = m->params;
    params.node_count = m->inner_count;
    SVO_I_TRY(svo_i_work_alloc(m->work, "minimize_valid", inner, &arrays[0]));
    SVO_I_TRY(svo_i_work_alloc(m->work, "minimize_leaf", inner, &arrays[1]));
    SVO_I_TRY(svo_i_work_alloc(m->work, "minimize_first_inner", inner * 4, &arrays[2]));
    SVO_I_TRY(svo_i_work_alloc(m->work, "minimize_first_payload", inner * 4, &arrays[3]));
    if (payload_count > 0) {
        SVO_I_TRY(svo_i_work_alloc(m->work, "minimize_origins", payload_count * 4, &m->origins));
        SVO_I_TRY(svo_i_work_fill_zero(m->work, m->origins, sizeof(cl_uint))); /* the root's, if it has any */
    }
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(source->valid),
                                        SVO_I_ARGUMENT(m->leaves),
                                        SVO_I_ARGUMENT(source->first_inner),
                                        SVO_I_ARGUMENT(source->first_payload),
                                        SVO_I_ARGUMENT(m->kept),
                                        SVO_I_ARGUMENT(m->inner_sums),
                                        SVO_I_ARGUMENT(m->child_sums),
                                        SVO_I_ARGUMENT(arrays[0]),
                                        SVO_I_ARGUMENT(arrays[1]),
                                        SVO_I_ARGUMENT(arrays[2]),
                                        SVO_I_ARGUMENT(arrays[3]),
                                        SVO_I_ARGUMENT(m->origins),
                                        SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_work_launch(m->work, "svo_k_minimize_nodes", SVO_I_ARGUMENTS(arguments), m->inner_count));
    source->valid = arrays[0];
    source->leaf = arrays[1];
    source->first_inner = arrays[2];
    source->first_payload = arrays[3];
    source->payload_begin = m->params.new_payload_begin;
    return SVO_OK;
}

/* The counts of the levels' inner nodes and leaves. */
static void set_counts(minimizer *m)
{
    svo_compact_info *info = &m->source->info;
    for (uint32_t level = 0; level < info->depth; ++level) {
        info->level_inner[level] = m->inner_begin[level + 1] - m->inner_begin[level];
    }
    for (uint32_t level = 0; level < info->depth; ++level) {
        const uint32_t below = level + 1 < info->depth ? info->level_inner[level + 1] : 0;
        info->level_leaf[level + 1] = m->child_begin[level + 1] - m->child_begin[level] - below;
    }
    info->minimized = 1;
    svo_i_compact_count(info);
}

svo_status svo_i_minimize(svo_i_device_work *work, const svo_compact_options *options, svo_i_compact_source *source)
{
    const svo_compact_info *info = &source->info;
    const bool has_places = svo_i_compact_has_places(info);
    svo_i_compact_count(&source->info);
    minimizer m = {.work = work, .source = source, .inner_count = (uint32_t)info->inner_count};
    m.params =
        (svo_minimize_params){.payload_begin = source->payload_begin,
                              .color_tolerance = options->color_tolerance[0] | options->color_tolerance[1] << 8 |
                                                 options->color_tolerance[2] << 16 | options->color_tolerance[3] << 24,
                              .normal_tolerance = options->normal_tolerance,
                              .fill_tolerance = options->fill_tolerance};
    SVO_I_TRY(prepare_payload(&m));
    SVO_I_TRY(allocate(&m));
    SVO_I_TRY(merge_levels(&m));
    SVO_I_TRY(keep_levels(&m));
    m.params.new_payload_begin = info->payload_level > 0 ? m.child_begin[info->payload_level - 1] + 1 : 0;
    const uint64_t payload_count =
        has_places ? UINT64_C(1) + m.child_begin[info->depth] - m.params.new_payload_begin : 0;
    SVO_I_TRY(gather_nodes(&m, payload_count));
    svo_i_work_free(work, &m.kept);
    svo_i_work_free(work, &m.counts);
    svo_i_work_free(work, &m.inner_sums);
    svo_i_work_free(work, &m.child_sums);
    svo_i_work_free(work, &m.merged);
    svo_i_work_free(work, &m.leaves);
    if (has_places) {
        SVO_I_TRY(gather_payload(&m, payload_count));
        svo_i_work_free(work, &m.origins);
    }
    set_counts(&m);
    return SVO_OK;
}
