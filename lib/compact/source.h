/* SPDX-License-Identifier: MIT */
/*
 * What encoders read: inner nodes breadth-first and their children, on a device. A built tree is such a source as it
 * is; minimizing and filling solids make others, where leaves lie above level depth.
 *
 * Inner node i has the children valid[i], of which leaf[i] end there. Its first inner child is first_inner[i], an index
 * of an inner node; the children's payload lies side by side from first_payload[i] - payload_begin on, in ascending
 * octant.
 */
#ifndef SVO_LIB_COMPACT_SOURCE_H
#define SVO_LIB_COMPACT_SOURCE_H

#include "core/compact.h"
#include "core/work.h"

typedef struct svo_i_compact_source {
    svo_compact_info info; /* all of the tree; form and directory_step_log2 as asked for; the levels' counts */
    cl_mem valid; /* u8 per inner node */
    cl_mem leaf; /* u8 per inner node */
    cl_mem first_inner; /* u32 per inner node */
    cl_mem first_payload; /* u32 per inner node; defined where the children have payload */
    uint32_t payload_begin; /* what first_payload has for the first node that has payload */
    cl_mem payload[SVO_I_PAYLOAD_COUNT]; /* in the order of svo_compact_buffer; NULL: not held, or not carried */
} svo_i_compact_source;

/* The first inner node of a level. level: up to depth, where it is the number of inner nodes. */
static inline uint32_t svo_i_source_level_begin(const svo_compact_info *info, uint32_t level)
{
    uint32_t begin = 0;
    for (uint32_t above = 0; above < level; ++above) {
        begin += info->level_inner[above];
    }
    return begin;
}

/* Describes a tree and fills in its arrays, which must outlive the work; of one on the host there are copies that the
   work owns. */
svo_status svo_i_source_of_tree(svo_i_device_work *work, const svo_tree *tree, const svo_compact_options *options,
                                svo_i_compact_source *source);
/* The description alone: what svo_tree_info has, the levels' counts, form and directory_step_log2. */
void svo_i_source_describe(const svo_tree_info *tree, const svo_compact_options *options, svo_compact_info *out);

/*
 * Merges full leaves, before nodes are encoded in any form: makes eight full leaves with the same payload, or within
 * the tolerances, one leaf, on all levels but the root's and, where payload is not constant, those above payload_level,
 * which have no place for it. Makes new arrays of the source, which the work owns; what it had before stays as it is.
 * Sets source->info.minimized and the levels' counts. options: with tolerances in their ranges.
 */
svo_status svo_i_minimize(svo_i_device_work *work, const svo_compact_options *options, svo_i_compact_source *source);

#endif
