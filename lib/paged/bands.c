/* SPDX-License-Identifier: MIT */
/* Which nodes a page has, and where the file has them. */
#include "paged/paged.h"

svo_tree_buffer svo_i_paged_buffer(paged_array array)
{
    static const svo_tree_buffer buffers[PAGED_ARRAYS] = {SVO_TREE_CHILD_MASK, SVO_TREE_COLORS, SVO_TREE_NORMALS};
    return buffers[array];
}

size_t svo_i_paged_element_bytes(paged_array array)
{
    return svo_i_tree_element_bytes(svo_i_paged_buffer(array));
}

uint32_t svo_i_paged_last_level(const svo_paged *paged, const paged_band *band)
{
    return band->root_level + paged->layout.page_levels;
}

uint32_t svo_i_paged_count(const paged_band *band, uint32_t index, uint32_t level)
{
    const uint32_t *first = band->first[level - band->root_level];
    return first[index + 1] - first[index];
}

const paged_band *svo_i_paged_band(const svo_paged *paged, uint32_t page, uint32_t *index)
{
    const paged_band *band = paged->bands;
    while (page - band->first_page >= band->page_count) {
        ++band;
    }
    *index = page - band->first_page;
    return band;
}

void svo_i_paged_size(const svo_paged *paged, uint32_t page, uint32_t *inner_count, uint32_t *leaf_count)
{
    uint32_t index = 0;
    const paged_band *band = svo_i_paged_band(paged, page, &index);
    const uint32_t last_level = svo_i_paged_last_level(paged, band);
    *inner_count = *leaf_count = 0;
    for (uint32_t level = band->root_level + 1; level <= last_level; ++level) {
        *(level < paged->file.info.depth ? inner_count : leaf_count) += svo_i_paged_count(band, index, level);
    }
}

const file_chunk *svo_i_paged_chunk(const svo_paged *paged, paged_array array, uint32_t level, uint32_t *index)
{
    for (uint32_t i = 0; i < paged->load.head.header.chunk_count; ++i) {
        const file_entry *entry = &paged->file.entries[i];
        if (entry->buffer == svo_i_paged_buffer(array) && entry->level == level) {
            *index = i;
            return &paged->load.head.chunks[i];
        }
    }
    return NULL;
}
