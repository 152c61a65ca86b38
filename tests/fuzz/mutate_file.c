/* SPDX-License-Identifier: MIT */
/*
 * Mutations of .svo and .svc files that pass the checks of lengths and checksums: after most changes, the header, the
 * chunk table and all checksums are recomputed. Otherwise a fuzzer would never get past the first checksum. Only
 * libFuzzer calls it; the inputs it stores need no further processing.
 */
#include <stdbool.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>
#include <zstd.h>

#include "fuzz.h"
#include "io/file_format.h"

#define PLAIN_BYTES_MAX ((size_t)1 << 20)

/* splitmix64 (Steele, Lea, Flood, 2014) */
static uint64_t next_random(uint64_t *state)
{
    uint64_t z = *state += UINT64_C(0x9E3779B97F4A7C15);
    z = (z ^ z >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ z >> 27) * UINT64_C(0x94D049BB133111EB);
    return z ^ z >> 31;
}

/* The head of the file; bytes beyond the end of the file are zero. Files need not be aligned in memory. */
static file_head read_head(const uint8_t *data, size_t byte_count)
{
    file_head head;
    memset(&head, 0, sizeof head);
    memcpy(&head, data, byte_count < sizeof head ? byte_count : sizeof head);
    return head;
}

static uint32_t chunk_count(const file_head *head)
{
    return head->header.chunk_count < FILE_CHUNKS_MAX ? head->header.chunk_count : FILE_CHUNKS_MAX;
}

/* Sets length and checksum of the uncompressed chunk; unchanged if decompression fails. */
static void repair_packed(file_chunk *chunk, const uint8_t *stored)
{
    static uint8_t plain[PLAIN_BYTES_MAX];
    const size_t got = ZSTD_decompress(plain, sizeof plain, stored, (size_t)chunk->stored_bytes);
    if (!ZSTD_isError(got)) {
        chunk->plain_bytes = got;
        chunk->hash = XXH3_64bits(plain, got);
    }
}

static void repair_chunk(file_chunk *chunk, const uint8_t *data, size_t byte_count)
{
    if (chunk->offset > byte_count || chunk->stored_bytes > byte_count - chunk->offset) {
        return;
    }
    if (chunk->codec == FILE_CODEC_ZSTD) {
        repair_packed(chunk, data + chunk->offset);
    } else {
        chunk->plain_bytes = chunk->stored_bytes;
        chunk->hash = XXH3_64bits(data + chunk->offset, (size_t)chunk->stored_bytes);
    }
}

/* Makes it a file of a known format and version: of a light, of compact trees, or else of trees. */
static void repair_identity(file_header *header)
{
#ifdef FUZZ_LIGHT
    memcpy(header->magic, "\x89SVL\r\n\x1a\n", FILE_MAGIC_BYTES);
    header->version = header->version % 4 == 0 ? 3 : header->version % 4;
    return;
#endif
    const bool compact = memcmp(header->magic, FILE_COMPACT_MAGIC, FILE_MAGIC_BYTES) == 0;
    const uint32_t newest = compact ? FILE_COMPACT_VERSION : FILE_VERSION;
    if (!compact) {
        memcpy(header->magic, FILE_MAGIC, FILE_MAGIC_BYTES);
    }
    if (header->version == 0 || header->version > newest) {
        header->version = newest;
    }
}

/* Recomputes checksums and, on request, offsets: chunks back to back, the last one takes all remaining bytes. */
static void repair(uint8_t *data, size_t byte_count, bool places)
{
    file_head head = read_head(data, byte_count);
    repair_identity(&head.header);
    head.header.file_bytes = byte_count;
    const uint32_t count = chunk_count(&head);
    const size_t head_bytes = sizeof head.header + count * sizeof head.chunks[0];
    if (byte_count < head_bytes) {
        return;
    }
    head.header.chunk_count = count;
    head.header.header_bytes = (uint32_t)head_bytes;
    size_t offset = head_bytes;
    for (uint32_t i = 0; i < count; ++i) {
        file_chunk *chunk = &head.chunks[i];
        if (places) {
            const size_t left = byte_count - offset;
            chunk->offset = offset;
            chunk->stored_bytes = i + 1 == count || chunk->stored_bytes > left ? left : chunk->stored_bytes;
            offset += (size_t)chunk->stored_bytes;
        }
        repair_chunk(chunk, data, byte_count);
    }
    head.header.header_hash = XXH3_64bits((const uint8_t *)&head + FILE_HASH_BEGIN, head_bytes - FILE_HASH_BEGIN);
    memcpy(data, &head, head_bytes);
}

/* Changes a few bytes of a part of the file; its length does not change. */
static void mutate_part(uint8_t *data, size_t begin, size_t end, uint64_t *random)
{
    if (end <= begin) {
        return;
    }
    const size_t first = begin + (size_t)(next_random(random) % (end - begin));
    const size_t length_max = (size_t)1 << next_random(random) % 5;
    const size_t length = length_max < end - first ? length_max : end - first;
    (void)LLVMFuzzerMutate(data + first, length, length);
}

/* Changes a chunk, possibly its length; the bytes after it move. Returns the file's new length. */
static size_t resize_chunk(uint8_t *data, size_t byte_count, size_t byte_count_max, uint32_t chunk_index)
{
    file_head head = read_head(data, byte_count);
    file_chunk *chunk = &head.chunks[chunk_index];
    if (chunk->offset > byte_count || chunk->stored_bytes > byte_count - chunk->offset) {
        return byte_count;
    }
    const size_t begin = (size_t)chunk->offset;
    const size_t stored_bytes = (size_t)chunk->stored_bytes;
    const size_t tail_bytes = byte_count - begin - stored_bytes;
    uint8_t *tail = malloc(tail_bytes + 1);
    REQUIRE(tail != NULL);
    memcpy(tail, data + begin + stored_bytes, tail_bytes);
    const size_t room_bytes = byte_count_max - begin - tail_bytes;
    const size_t mutated_bytes = room_bytes > 0 ? LLVMFuzzerMutate(data + begin, stored_bytes, room_bytes) : 0;
    memcpy(data + begin + mutated_bytes, tail, tail_bytes);
    free(tail);
    chunk->stored_bytes = mutated_bytes;
    memcpy(data + offsetof(file_head, chunks) + chunk_index * sizeof *chunk, chunk, sizeof *chunk);
    return begin + mutated_bytes + tail_bytes;
}

/* Makes one change: a value of the header, the table, a chunk's bytes, a chunk's length, or anywhere. */
static size_t change(uint8_t *data, size_t byte_count, size_t byte_count_max, uint64_t *random)
{
    const file_head head = read_head(data, byte_count);
    const uint32_t count = chunk_count(&head);
    const size_t head_bytes = sizeof head.header + count * sizeof head.chunks[0];
    const uint64_t kind = next_random(random) % 8;
    if (kind == 0 || count == 0 || byte_count < head_bytes) {
        return LLVMFuzzerMutate(data, byte_count, byte_count_max);
    }
    const uint32_t chunk_index = (uint32_t)(next_random(random) % count);
    const file_chunk *chunk = &head.chunks[chunk_index];
    if (kind == 1) {
        mutate_part(data, FILE_HASH_BEGIN, sizeof head.header, random);
    } else if (kind == 2) {
        mutate_part(data, sizeof head.header, head_bytes, random);
    } else if (kind == 3) {
        return resize_chunk(data, byte_count, byte_count_max, chunk_index);
    } else if (chunk->offset <= byte_count && chunk->stored_bytes <= byte_count - chunk->offset) {
        mutate_part(data, (size_t)chunk->offset, (size_t)(chunk->offset + chunk->stored_bytes), random);
    }
    return byte_count;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t byte_count, size_t byte_count_max, unsigned seed)
{
    uint64_t random = seed;
    for (uint64_t changes = 1 + next_random(&random) % 3; changes > 0; --changes) {
        byte_count = change(data, byte_count, byte_count_max, &random);
    }
    const uint64_t kind = next_random(&random) % 8;
    if (kind != 0) {
        repair(data, byte_count, kind != 1);
    }
    return byte_count;
}
