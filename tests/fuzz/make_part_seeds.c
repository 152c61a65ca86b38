/* SPDX-License-Identifier: MIT */
/* Writes part files of the tree in part_header.h: make_part_seeds FOLDER. */
#include <stdio.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "fuzz.h"
#include "part_header.h"
#include "parts/part_file.h"

/* Levels of a part under a node of level 1: a root, two nodes, three leaves. */
static const uint8_t root_mask = 0x81;
static const uint8_t masks[2] = {0x01, 0x0c};

static part_file file;
static uint8_t bytes[4096];
static size_t byte_count;

static void add(uint32_t kind, uint32_t level, const void *from, size_t count)
{
    file.segments[file.head.segment_count++] = (part_segment){
        .kind = kind, .level = level, .offset = byte_count, .bytes = count, .hash = XXH3_64bits(from, count)};
    memcpy(bytes + byte_count, from, count);
    byte_count += count;
}

static void add_payload(uint32_t level, size_t nodes)
{
    static const uint8_t values[16] = {200, 100, 50, 255, 7, 7, 7, 255, 9, 8, 7, 6, 5, 4, 3, 2};
    add(SVO_TREE_COLORS, level, values, nodes * 4);
    add(SVO_TREE_MATERIALS, level, values, nodes * 2);
    add(SVO_TREE_FILLS, level, values, nodes * 2);
}

static int save(const char *folder, const char *name)
{
    char path[512];
    const svo_part_header header = part_header();
    part_head *head = &file.head;
    const size_t head_bytes = sizeof *head + head->segment_count * sizeof(part_segment);
    for (uint32_t i = 0; i < head->segment_count; ++i) {
        file.segments[i].offset += head_bytes;
    }
    memcpy(head->magic, PART_MAGIC, PART_MAGIC_BYTES);
    head->version = PART_VERSION;
    head->file_bytes = head_bytes + byte_count;
    svo_i_part_identity(&header, head->whole);
    head->head_hash = XXH3_64bits((const char *)&file + PART_HASH_BEGIN, head_bytes - PART_HASH_BEGIN);
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *out = fopen(path, "wb");
    REQUIRE(out != NULL && fwrite(&file, 1, head_bytes, out) == head_bytes);
    REQUIRE(fwrite(bytes, 1, byte_count, out) == byte_count);
    return fclose(out);
}

int main(int argc, char **argv)
{
    static const uint64_t runs[2] = {UINT64_C(1) << 48 | 1000, UINT64_C(2) << 48 | 500};
    static const uint32_t level_begin[] = {0, 1, 3, 6};
    REQUIRE(argc == 2);
    file.head.level = 1;
    file.head.code = 5;
    REQUIRE(save(argv[1], "empty") == 0);
    file.head.fragments = 4;
    file.head.root = (svo_i_node_sums){.weight = 1500, .color = {1500, 3000, 4500, 382500}};
    memcpy(file.head.level_begin, level_begin, sizeof level_begin);
    add(SVO_TREE_CHILD_MASK, 0, &root_mask, 1);
    add_payload(0, 1);
    add(SVO_TREE_CHILD_MASK, 1, masks, 2);
    add_payload(1, 2);
    add_payload(2, 3);
    add(PART_RUNS, 0, runs, sizeof runs);
    return save(argv[1], "three_leaves");
}
