/* SPDX-License-Identifier: MIT */
/*
 * Between the classified cells and the encoder of the descriptor form. Inner nodes keep their indices; what changes is
 * the masks, and the payload, into which that of the interior leaves is inserted.
 */
#include "solid/source.h"

#include <string.h>

#include "compact/programs.h"
#include "shared/solid_layout.h"
#include "solid/programs.h"

/* The most bytes of a payload element. */
#define ELEMENT_BYTES_MAX 6

/* The element of interior leaves. */
static void fill_element(const svo_solid_options *options, svo_compact_buffer buffer, uint8_t element[8])
{
    memset(element, 0, 8);
    if (buffer == SVO_COMPACT_COLORS) {
        memcpy(element, options->color, sizeof options->color);
    } else if (buffer == SVO_COMPACT_MATERIALS) {
        memcpy(element, &options->material, sizeof options->material);
    }
}

/* valid, leaf and the places of the children's payload. */
static svo_status make_masks(svo_i_device_work *work, const svo_tree *tree, const svo_i_inside *inside,
                             svo_i_compact_source *out)
{
    const svo_tree_info *info = &tree->info;
    const svo_solid_params params = {.first = info->level_begin[info->depth - 1], .count = (cl_uint)info->inner_count};
    const uint64_t count = info->inner_count;
    cl_mem counts = NULL;
    cl_mem sums = NULL;
    SVO_I_TRY(svo_i_work_alloc(work, "solid_valid", count, &out->valid));
    SVO_I_TRY(svo_i_work_alloc(work, "solid_leaf", count, &out->leaf));
    SVO_I_TRY(svo_i_work_alloc(work, "solid_first", count * sizeof(cl_uint), &out->first_payload));
    SVO_I_TRY(svo_i_work_alloc(work, "solid_counts", (count + 1) * sizeof(cl_uint), &counts));
    SVO_I_TRY(svo_i_work_alloc(work, "solid_sums", (count + 2) * sizeof(cl_uint), &sums));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(inside->mask),
                                        SVO_I_ARGUMENT(out->valid),
                                        SVO_I_ARGUMENT(out->leaf),
                                        SVO_I_ARGUMENT(counts),
                                        SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_solid_masks", SVO_I_ARGUMENTS(arguments), count));
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_compact, " -DSVO_SORT"));
    SVO_I_TRY(svo_i_work_scan(work, counts, sums, count + 1));
    SVO_I_TRY(svo_i_work_copy(work, sums, sizeof(cl_uint), out->first_payload, 0, count * sizeof(cl_uint)));
    svo_i_work_free(work, &counts);
    svo_i_work_free(work, &sums);
    return svo_i_work_use(work, &svo_i_program_solid, "");
}

/* Whether the tree's payload is the same in every node and that of the interior leaves too. */
static svo_status check_constant(svo_i_device_work *work, const svo_tree *tree, svo_compact_buffer buffer,
                                 const uint8_t element[8], bool *constant)
{
    const svo_tree_buffer of_tree = svo_i_compact_tree_buffer(buffer);
    const size_t bytes = svo_i_tree_element_bytes(of_tree);
    uint8_t held[ELEMENT_BYTES_MAX] = {0};
    *constant = svo_i_tree_is_constant(&tree->info, of_tree);
    if (!*constant) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_read(work, tree->buffers[of_tree], 0, held, bytes));
    *constant = memcmp(held, element, bytes) == 0;
    return SVO_OK;
}

/* The payload with that of the interior leaves; the tree's own where it is the same everywhere. */
static svo_status make_payload(svo_i_device_work *work, const svo_tree *tree, const svo_i_inside *inside,
                               const svo_solid_options *options, svo_compact_buffer buffer, svo_i_compact_source *out)
{
    const svo_tree_buffer of_tree = svo_i_compact_tree_buffer(buffer);
    const size_t bytes = svo_i_tree_element_bytes(of_tree);
    const uint64_t nodes = tree->info.node_count + inside->count;
    cl_mem *to = &out->payload[buffer - SVO_I_PAYLOAD_FIRST];
    uint8_t element[8];
    bool constant = false;
    fill_element(options, buffer, element);
    SVO_I_TRY(check_constant(work, tree, buffer, element, &constant));
    *to = tree->buffers[of_tree];
    if (constant) {
        return SVO_OK;
    }
    svo_solid_params params = {.count = (cl_uint)tree->info.inner_count,
                               .element_halves = (cl_uint)(bytes / 2),
                               .repeats = svo_i_tree_is_constant(&tree->info, of_tree)};
    memcpy(params.value, element, sizeof params.value);
    out->info.constant &= ~svo_i_compact_need(buffer);
    SVO_I_TRY(svo_i_work_alloc(work, svo_compact_buffer_name(buffer), nodes * bytes, to));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(inside->mask),
                                        SVO_I_ARGUMENT(out->first_payload),
                                        SVO_I_ARGUMENT(tree->buffers[of_tree]),
                                        SVO_I_ARGUMENT(*to),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_solid_payload", SVO_I_ARGUMENTS(arguments), params.count);
}

svo_status svo_i_solid_source(svo_i_device_work *work, const svo_tree *tree, const svo_i_inside *inside,
                              const svo_solid_options *options, svo_i_compact_source *out)
{
    const svo_compact_options form = {.struct_size = sizeof form, .form = SVO_FORM_DESCRIPTOR};
    if (inside->count == 0) {
        return svo_i_source_of_tree(work, tree, &form, out);
    }
    *out = (svo_i_compact_source){.first_inner = tree->buffers[SVO_TREE_FIRST_CHILD]};
    svo_i_source_describe(&tree->info, &form, &out->info);
    for (uint32_t level = 1; level <= tree->info.depth; ++level) {
        out->info.level_leaf[level] += (uint32_t)inside->level_count[level];
        out->info.minimized |= level < tree->info.depth && inside->level_count[level] > 0;
    }
    SVO_I_TRY(make_masks(work, tree, inside, out));
    for (int i = SVO_I_PAYLOAD_FIRST; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        if ((out->info.need & svo_i_compact_need((svo_compact_buffer)i)) != 0) {
            SVO_I_TRY(make_payload(work, tree, inside, options, (svo_compact_buffer)i, out));
        }
    }
    return SVO_OK;
}
