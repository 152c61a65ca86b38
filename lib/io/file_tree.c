/* SPDX-License-Identifier: MIT */
/* Chunks of built trees: an array each up to version 2; since version 3 an array of one level, the levels in order. */
#include "io/file_tree.h"

/* The levels that an array has elements of. A constant has one element, and it stands with its first level. */
static void find_levels(const svo_tree_info *info, svo_tree_buffer buffer, uint32_t *first, uint32_t *last)
{
    switch (buffer) {
    case SVO_TREE_CHILD_MASK:
        *first = 0;
        *last = info->depth - 1;
        break;
    case SVO_TREE_COLORS:
    case SVO_TREE_NORMALS:
    case SVO_TREE_MATERIALS:
    case SVO_TREE_FILLS:
        *first = info->payload_level;
        *last = svo_i_tree_is_constant(info, buffer) ? info->payload_level : info->depth;
        break;
    default:
        *first = *last = info->depth;
        break;
    }
}

static bool is_in_file(const svo_tree_info *info, uint32_t version, svo_tree_buffer buffer)
{
    return svo_i_tree_holds(info, buffer) && (buffer != SVO_TREE_FIRST_CHILD || version < FILE_BY_LEVELS);
}

uint32_t svo_i_file_list_entries(const svo_tree_info *info, uint32_t version, file_entry entries[FILE_CHUNKS_MAX])
{
    const uint32_t last_level = version < FILE_BY_LEVELS ? 0 : info->depth;
    uint32_t count = 0;
    for (uint32_t level = 0; level <= last_level; ++level) {
        for (uint32_t i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
            const svo_tree_buffer buffer = (svo_tree_buffer)i;
            uint32_t first = 0, last = 0;
            if (version >= FILE_BY_LEVELS) {
                find_levels(info, buffer, &first, &last);
            }
            if (is_in_file(info, version, buffer) && level >= first && level <= last) {
                entries[count++] = (file_entry){buffer, level};
            }
        }
    }
    return count;
}

uint32_t svo_i_file_entry_kind(const file_entry *entry)
{
    return (uint32_t)entry->buffer | entry->level << FILE_KIND_BITS;
}

/* Nodes before a level, in an array whose first element is the first node of another level. */
static uint64_t nodes_before(const svo_tree_info *info, uint32_t level, uint32_t first_level)
{
    return info->level_begin[level] - info->level_begin[first_level];
}

/* Whether the array is in pieces, so that an entry is one level of it. */
static bool is_divided(const svo_tree_info *info, uint32_t version, svo_tree_buffer buffer, uint32_t *first)
{
    uint32_t last = 0;
    find_levels(info, buffer, first, &last);
    return version >= FILE_BY_LEVELS && last > *first;
}

uint64_t svo_i_file_entry_begin(const svo_tree_info *info, uint32_t version, const file_entry *entry)
{
    uint32_t first = 0;
    return is_divided(info, version, entry->buffer, &first) ? nodes_before(info, entry->level, first) : 0;
}

uint64_t svo_i_file_entry_count(const svo_tree_info *info, uint32_t version, const file_entry *entry)
{
    uint32_t first = 0;
    return is_divided(info, version, entry->buffer, &first) ? nodes_before(info, entry->level + 1, entry->level)
                                                            : svo_i_tree_element_count(info, entry->buffer);
}
