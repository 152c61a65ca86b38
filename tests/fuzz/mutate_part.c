/* SPDX-License-Identifier: MIT */
/* Mutations of part files that pass the checks of lengths and checksums, as mutate_file.c has them for trees. */
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "fuzz.h"
#include "part_header.h"
#include "parts/part_file.h"

/* Places the segments back to back, the last with all that is left, and recomputes the checksums. */
static void repair(uint8_t *data, size_t byte_count)
{
    static part_file file;
    const svo_part_header header = part_header();
    const size_t most = byte_count < sizeof file ? byte_count : sizeof file;
    if (byte_count < sizeof file.head) {
        return;
    }
    memset(&file, 0, sizeof file);
    memcpy(&file, data, most);
    part_head *head = &file.head;
    const size_t room = (byte_count - sizeof *head) / sizeof(part_segment);
    head->segment_count %= PART_SEGMENTS_MAX + 1;
    head->segment_count = head->segment_count < room ? head->segment_count : (uint32_t)room;
    size_t offset = sizeof *head + head->segment_count * sizeof(part_segment);
    for (uint32_t i = 0; i < head->segment_count; ++i) {
        part_segment *segment = &file.segments[i];
        const uint64_t left = byte_count - offset;
        segment->offset = offset;
        segment->bytes = i + 1 == head->segment_count || segment->bytes > left ? left : segment->bytes;
        segment->hash = XXH3_64bits(data + offset, (size_t)segment->bytes);
        offset += (size_t)segment->bytes;
    }
    memcpy(head->magic, PART_MAGIC, PART_MAGIC_BYTES);
    head->version = PART_VERSION;
    head->file_bytes = byte_count;
    svo_i_part_identity(&header, head->whole);
    const size_t head_bytes = sizeof *head + head->segment_count * sizeof(part_segment);
    head->head_hash = XXH3_64bits((const char *)&file + PART_HASH_BEGIN, head_bytes - PART_HASH_BEGIN);
    memcpy(data, &file, head_bytes);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t byte_count, size_t byte_count_max, unsigned seed)
{
    byte_count = LLVMFuzzerMutate(data, byte_count, byte_count_max);
    if (seed % 8 != 0) {
        repair(data, byte_count);
    }
    return byte_count;
}
