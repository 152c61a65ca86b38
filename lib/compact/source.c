/* SPDX-License-Identifier: MIT */
/* A built tree as the source of encoders. */
#include "compact/source.h"

#include "core/tree.h"
#include "svocl/plan.h"

/* ---- description ---- */

uint32_t svo_i_source_level_begin(const svo_compact_info *info, uint32_t level)
{
    uint32_t begin = 0;
    for (uint32_t above = 0; above < level; ++above) {
        begin += info->level_inner[above];
    }
    return begin;
}

uint32_t svo_i_source_payload_parents(const svo_compact_info *info)
{
    return info->payload_level > 0 ? svo_i_source_level_begin(info, info->payload_level - 1) : 0;
}

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
                              .snap_error = tree->snap_error,
                              .triangles = tree->triangles,
                              .refused_triangles = tree->refused_triangles,
                              .fragments = tree->fragments};
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
    SVO_I_TRY(svo_i_work_alloc(work, svo_tree_buffer_name(buffer), bytes, out));
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
