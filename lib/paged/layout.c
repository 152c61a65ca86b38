/* SPDX-License-Identifier: MIT */
/*
 * The top level and the room for pages. Bands are counted from the leaves up, so the top level is above the leaves by a
 * multiple of the levels of a page.
 */
#include "paged/layout.h"

#include <inttypes.h>

#include "shared/page.h"

/* The share of the bytes that the top levels may take, unless there are no fewer of them. */
#define TOP_SHARE 4u

/* Of an inner node beside its payload: mask and link. */
#define INNER_BYTES 5u

static uint64_t node_bytes(const paged_layout *layout, uint64_t inner_count, uint64_t leaf_count)
{
    return inner_count * (INNER_BYTES + layout->payload_bytes) + leaf_count * layout->payload_bytes;
}

static uint64_t count_nodes(const svo_tree_info *info, uint32_t level)
{
    return info->level_begin[level + 1] - info->level_begin[level];
}

/* Sets what follows from the top level. */
static void set_top(const svo_tree_info *info, uint32_t top_level, paged_layout *layout)
{
    const bool is_whole = top_level == info->depth;
    layout->top_level = top_level;
    layout->band_count = 0;
    layout->page_count = 0;
    layout->top_inner_count = info->level_begin[is_whole ? info->depth : top_level + 1];
    layout->inner_count = info->level_begin[info->depth] - layout->top_inner_count;
    layout->leaf_count = is_whole ? 0 : info->leaf_count;
    for (uint32_t level = top_level; level < info->depth; level += layout->page_levels) {
        ++layout->band_count;
        layout->page_count += (uint32_t)count_nodes(info, level);
    }
}

/* Bytes of what is always there: top levels, the table of pages, payload that all nodes share. */
static uint64_t fixed_bytes(const svo_tree_info *info, const paged_layout *layout)
{
    uint64_t bytes = (uint64_t)layout->page_count * SVO_PAGE_WORDS * sizeof(uint32_t) +
                     node_bytes(layout, layout->top_inner_count, info->leaf_count - layout->leaf_count);
    for (int i = 0; i < PAGED_ARRAYS; ++i) {
        bytes += svo_i_tree_is_constant(info, svo_i_paged_buffer((paged_array)i))
                     ? svo_i_paged_element_bytes((paged_array)i)
                     : 0;
    }
    return bytes;
}

/* No page has more bytes than one with every child. */
static uint64_t full_page_bytes(const paged_layout *layout)
{
    uint64_t count = 0;
    for (uint32_t level = 1; level <= layout->page_levels; ++level) {
        count = 8 * count + 8;
    }
    return node_bytes(layout, count, 0);
}

void svo_i_paged_choose(svo_paged *paged, uint32_t page_levels, uint64_t budget_bytes)
{
    const svo_tree_info *info = &paged->file.info;
    paged_layout *layout = &paged->layout;
    layout->page_levels = page_levels;
    layout->payload_bytes = 0;
    for (int i = 0; i < PAGED_ARRAYS; ++i) {
        const svo_tree_buffer buffer = svo_i_paged_buffer((paged_array)i);
        layout->by_node[i] = svo_i_tree_holds(info, buffer) && !svo_i_tree_is_constant(info, buffer);
        layout->payload_bytes +=
            layout->by_node[i] && i != PAGED_MASKS ? (uint32_t)svo_i_paged_element_bytes((paged_array)i) : 0;
    }
    for (uint32_t level = info->depth;; level -= page_levels) {
        set_top(info, level, layout);
        const uint64_t fixed = fixed_bytes(info, layout);
        const bool fits = fixed <= budget_bytes / TOP_SHARE && full_page_bytes(layout) <= budget_bytes - fixed;
        if (level <= page_levels || (level == info->depth && fixed <= budget_bytes / TOP_SHARE) || fits) {
            break;
        }
    }
}

/* count * part / whole, rounded down or one less, without overflow. part is at most whole. */
static uint64_t take_share(uint64_t count, uint64_t part, uint64_t whole)
{
    if (part == whole) {
        return count;
    }
    while (whole >= (uint64_t)1 << 31) {
        whole = (whole >> 1) + 1;
        part >>= 1;
    }
    return count * part / whole;
}

/* Elements for inner nodes and leaves beyond those of the largest page, within a number of bytes. Bands are read from
   the top down, so inner nodes of all but the last come first, with half of the bytes at most; what is left is shared
   as the last band's nodes are. */
static void share_room(const svo_paged *paged, uint64_t bytes, uint64_t *inner, uint64_t *leaves)
{
    const paged_layout *layout = &paged->layout;
    const svo_tree_info *info = &paged->file.info;
    const uint64_t more_inner = layout->inner_count - paged->largest_inner;
    const uint64_t more_leaves = layout->leaf_count - paged->largest_leaves;
    const uint32_t last_root_level = info->depth - layout->page_levels;
    const uint64_t above = info->level_begin[last_root_level + 1] - layout->top_inner_count;
    const uint64_t afforded = bytes / 2 / node_bytes(layout, 1, 0);
    uint64_t first = above < afforded ? above : afforded;
    first = first < more_inner ? first : more_inner;
    const uint64_t rest = node_bytes(layout, more_inner - first, more_leaves);
    const uint64_t left = bytes - node_bytes(layout, first, 0);
    const uint64_t part = left < rest ? left : rest;
    *inner = first + take_share(more_inner - first, part, rest);
    *leaves = take_share(more_leaves, part, rest);
}

svo_status svo_i_paged_fit(svo_paged *paged, uint64_t budget_bytes)
{
    const svo_tree_info *info = &paged->file.info;
    paged_layout *layout = &paged->layout;
    const uint64_t fixed = fixed_bytes(info, layout);
    const uint64_t top_leaves = info->leaf_count - layout->leaf_count;
    uint64_t inner = 0, leaves = 0;
    layout->least_bytes = fixed + node_bytes(layout, paged->largest_inner, paged->largest_leaves);
    layout->whole_bytes = fixed + node_bytes(layout, layout->inner_count, layout->leaf_count);
    if (budget_bytes < layout->least_bytes) {
        return svo_i_device_fail(paged->device, SVO_CAPACITY_EXCEEDED,
                                 "svo_paged_open: budget_bytes %" PRIu64 " is below %" PRIu64 ", the least for %s",
                                 budget_bytes, layout->least_bytes, paged->path);
    }
    if (layout->page_count > 0) {
        share_room(paged, budget_bytes - layout->least_bytes, &inner, &leaves);
    }
    inner += layout->top_inner_count + paged->largest_inner;
    leaves += top_leaves + paged->largest_leaves;
    if (inner + leaves >= SVO_PAGE_ROOT) {
        return svo_i_device_fail(paged->device, SVO_UNSUPPORTED,
                                 "svo_paged_open: budget_bytes %" PRIu64 " is room for %" PRIu64
                                 " nodes, and there may be %u",
                                 budget_bytes, inner + leaves, SVO_PAGE_ROOT - 1);
    }
    layout->inner_capacity = (uint32_t)inner;
    layout->leaf_capacity = (uint32_t)leaves;
    layout->device_bytes = fixed + node_bytes(layout, inner - layout->top_inner_count, leaves - top_leaves);
    return SVO_OK;
}
