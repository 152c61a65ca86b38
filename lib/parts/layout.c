/* SPDX-License-Identifier: MIT */
/* Who writes what of a .svo file, and the file that says so. */
#define _POSIX_C_SOURCE 200809L
#include "parts/layout.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "output/output.h"

#define LAYOUT_MAGIC   "\x89SVH\r\n\x1a\n"
#define LAYOUT_VERSION 1u
#define NAME_BYTES     48

/* What a byte costs: one that is copied is read, compared with its checksum and written; one of a chunk's checksum is
   read and goes into two checksums; what no part has, one share copies and sums up. */
#define COPY_COST 2u
#define HASH_COST 1u
#define REST_COST 3u

/* The front of the file; parts and nodes above them follow. hash: of all bytes after itself. What is compared begins
   after the token. */
typedef struct layout_head {
    uint8_t magic[8];
    uint64_t hash;
    char token[OWNER_BYTES];
    uint32_t version, share_count;
    uint64_t layout_bytes, file_bytes;
    uint64_t identity[2];
    uint64_t piece_count, upper_count;
    uint64_t upper_begin[SVO_LEVELS_MAX]; /* deeper trees are not stitched */
    uint32_t owners[FILE_CHUNKS_MAX];
} layout_head;

typedef struct layout_piece {
    uint64_t code, head_hash, fragments, list_count;
    uint32_t level, share;
    uint32_t level_begin[SVO_LEVELS_MAX];
} layout_piece;

typedef struct layout_upper {
    uint64_t code;
    svo_i_part_payload payload;
    uint8_t mask, reserved;
} layout_upper;

static_assert(sizeof(layout_head) == 16 + OWNER_BYTES + 56 + 8 * SVO_LEVELS_MAX + 4 * FILE_CHUNKS_MAX, "no padding");
static_assert(sizeof(layout_piece) == 40 + 4 * SVO_LEVELS_MAX, "no padding");
static_assert(sizeof(layout_upper) == 24, "no padding");

static svo_status no_memory(const svo_i_stitcher *s)
{
    return svo_i_fail(s->message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the shares of %zu parts", s->path,
                      s->all.piece_count);
}

/* ---- who does what ---- */

/* A chunk in the order of its cost, the largest first. */
typedef struct weighed_chunk {
    uint64_t cost;
    uint32_t index;
} weighed_chunk;

static int compare_chunks(const void *a, const void *b)
{
    const weighed_chunk *first = a;
    const weighed_chunk *second = b;
    if (first->cost != second->cost) {
        return first->cost < second->cost ? 1 : -1;
    }
    return first->index < second->index ? -1 : 1;
}

static uint32_t find_least(const uint64_t *loads, uint32_t count)
{
    uint32_t least = 0;
    for (uint32_t i = 1; i < count; ++i) {
        least = loads[i] < loads[least] ? i : least;
    }
    return least;
}

/* Gives each chunk to a share. Small ones stay together, since a share opens all parts for its chunks. */
static void give_chunks(const svo_i_stitcher *s, uint64_t fair, uint64_t *loads, svo_i_layout *layout)
{
    weighed_chunk chunks[FILE_CHUNKS_MAX] = {{.cost = 0}};
    uint32_t share = 0;
    for (uint32_t i = 0; i < s->filling_count; ++i) {
        const bool is_of_parts = svo_i_chunks_are_of_parts(s, s->fillings[i].entry.buffer);
        chunks[i] = (weighed_chunk){s->head.chunks[i].stored_bytes * (is_of_parts ? HASH_COST : REST_COST), i};
    }
    qsort(chunks, s->filling_count, sizeof *chunks, compare_chunks);
    for (uint32_t i = 0; i < s->filling_count; ++i) {
        const bool is_full = loads[share] + chunks[i].cost > fair;
        share = is_full ? find_least(loads, layout->share_count) : share;
        layout->owners[chunks[i].index] = share;
        loads[share] += chunks[i].cost;
    }
}

/* Gives runs of parts to the shares, as long as what each has room for beside its chunks. */
static void give_parts(const svo_i_stitcher *s, uint64_t copied, uint64_t fair, const uint64_t *loads,
                       svo_i_layout *layout)
{
    uint64_t rooms = 0;
    for (uint32_t i = 0; i < layout->share_count; ++i) {
        rooms += loads[i] < fair ? fair - loads[i] : 0;
    }
    const double scale = rooms > 0 ? (double)copied / (double)rooms : 0.0;
    uint64_t room = 0;
    uint64_t given = 0;
    size_t piece = 0;
    for (uint32_t i = 0; i < layout->share_count; ++i) {
        room += loads[i] < fair ? fair - loads[i] : 0;
        const bool is_last = i + 1 == layout->share_count;
        while (piece < s->all.piece_count) {
            const uint64_t cost = COPY_COST * svo_i_chunks_part_bytes(s, &s->all.pieces[piece]);
            const uint64_t middle = given + cost / 2;
            if (!is_last && (double)middle > (double)room * scale) {
                break;
            }
            layout->shares[piece++] = i;
            given += cost;
        }
    }
}

svo_status svo_i_layout_make(const svo_i_stitcher *s, svo_i_layout *layout)
{
    uint64_t copied = 0;
    uint64_t total = 0;
    uint64_t *loads = svo_i_alloc_zeroed(NULL, layout->share_count, sizeof *loads);
    layout->shares = svo_i_alloc_zeroed(NULL, s->all.piece_count + 1, sizeof *layout->shares);
    if (loads == NULL || layout->shares == NULL) {
        svo_i_free(loads);
        return no_memory(s);
    }
    for (size_t i = 0; i < s->all.piece_count; ++i) {
        copied += COPY_COST * svo_i_chunks_part_bytes(s, &s->all.pieces[i]);
    }
    for (uint32_t i = 0; i < s->filling_count; ++i) {
        total += s->head.chunks[i].stored_bytes;
    }
    const uint64_t fair = (copied + total * HASH_COST) / layout->share_count + 1;
    give_chunks(s, fair, loads, layout);
    give_parts(s, copied, fair, loads, layout);
    svo_i_free(loads);
    return SVO_OK;
}

/* ---- writing ---- */

char *svo_i_layout_path(const svo_parts *parts, uint32_t share_count)
{
    char name[NAME_BYTES];
    (void)snprintf(name, sizeof name, "stitch-%" PRIu32, share_count);
    return svo_i_folder_path(parts, name);
}

static size_t upper_count(const svo_i_pieces *all)
{
    return all->upper_begin[all->header.depth];
}

static void fill_lists(const svo_i_stitcher *s, const svo_i_layout *layout, layout_piece *pieces, layout_upper *uppers)
{
    for (size_t i = 0; i < s->all.piece_count; ++i) {
        const svo_i_piece *from = &s->all.pieces[i];
        pieces[i] = (layout_piece){.code = from->code,
                                   .head_hash = from->head_hash,
                                   .fragments = from->fragments,
                                   .list_count = from->list_count,
                                   .level = from->level,
                                   .share = layout->shares[i]};
        memcpy(pieces[i].level_begin, from->level_begin, sizeof from->level_begin);
    }
    for (size_t i = 0; i < upper_count(&s->all); ++i) {
        const svo_i_upper_node *from = &s->all.uppers[i];
        uppers[i] = (layout_upper){.code = from->code, .payload = from->payload, .mask = from->mask};
    }
}

/* The bytes of the file, by svo_i_alloc; NULL when out of memory. */
static layout_head *make_bytes(const svo_parts *parts, const svo_i_stitcher *s, const svo_i_layout *layout)
{
    const size_t piece_bytes = s->all.piece_count * sizeof(layout_piece);
    const size_t bytes = sizeof(layout_head) + piece_bytes + upper_count(&s->all) * sizeof(layout_upper);
    layout_head *head = svo_i_alloc_zeroed(NULL, 1, bytes);
    if (head == NULL) {
        return NULL;
    }
    *head = (layout_head){.version = LAYOUT_VERSION,
                          .share_count = layout->share_count,
                          .layout_bytes = bytes,
                          .file_bytes = s->head.header.file_bytes,
                          .identity = {parts->identity[0], parts->identity[1]},
                          .piece_count = s->all.piece_count,
                          .upper_count = upper_count(&s->all)};
    memcpy(head->magic, LAYOUT_MAGIC, sizeof head->magic);
    (void)snprintf(head->token, sizeof head->token, "%s", layout->token);
    memcpy(head->owners, layout->owners, sizeof head->owners);
    for (uint32_t level = 0; level <= s->all.header.depth; ++level) {
        head->upper_begin[level] = s->all.upper_begin[level];
    }
    layout_piece *pieces = (layout_piece *)(head + 1);
    fill_lists(s, layout, pieces, (layout_upper *)(pieces + s->all.piece_count));
    const size_t begin = offsetof(layout_head, token);
    head->hash = XXH3_64bits((const char *)head + begin, bytes - begin);
    return head;
}

svo_status svo_i_layout_save(const svo_parts *parts, const svo_i_stitcher *s, const svo_i_layout *layout)
{
    svo_i_output output = {.descriptor = -1};
    char *path = svo_i_layout_path(parts, layout->share_count);
    layout_head *head = make_bytes(parts, s, layout);
    if (path == NULL || head == NULL) {
        svo_i_free(path);
        svo_i_free(head);
        return no_memory(s);
    }
    int error = svo_i_output_open(path, NULL, &output);
    if (error == 0) {
        error = svo_i_output_write(&output, head, (size_t)head->layout_bytes);
    }
    if (error == 0) {
        error = svo_i_output_commit_unflushed(&output);
    }
    svo_i_output_abandon(&output);
    const svo_status status = error == 0 ? SVO_OK
                                         : svo_i_fail(s->message, svo_i_file_status(error), "%s: cannot be written: %s",
                                                      path, strerror(error));
    svo_i_free(head);
    svo_i_free(path);
    return status;
}

/* ---- reading ---- */

/* Whether bytes are a layout of the plan, of which every place that is used is inside. */
static bool is_whole(const svo_parts *parts, const layout_head *head, size_t byte_count)
{
    const size_t begin = offsetof(layout_head, token);
    if (byte_count < sizeof *head || memcmp(head->magic, LAYOUT_MAGIC, sizeof head->magic) != 0 ||
        head->version != LAYOUT_VERSION || head->layout_bytes != byte_count ||
        head->hash != XXH3_64bits((const char *)head + begin, byte_count - begin) ||
        memcmp(head->identity, parts->identity, sizeof head->identity) != 0 || head->piece_count > byte_count ||
        head->upper_count > byte_count || memchr(head->token, '\0', sizeof head->token) == NULL) {
        return false;
    }
    const layout_piece *pieces = (const layout_piece *)(head + 1);
    const uint32_t depth = parts->header.depth;
    bool whole =
        depth <= SVO_DEPTH_MAX &&
        byte_count == sizeof *head + head->piece_count * sizeof *pieces + head->upper_count * sizeof(layout_upper) &&
        head->upper_begin[depth] == head->upper_count;
    for (uint32_t level = 0; level < depth; ++level) {
        whole = whole && head->upper_begin[level] <= head->upper_begin[level + 1];
    }
    for (size_t i = 0; whole && i < head->piece_count; ++i) {
        whole = pieces[i].level < depth && pieces[i].share < head->share_count &&
                (i == 0 || pieces[i].share >= pieces[i - 1].share);
    }
    return whole;
}

/* The file of a layout. *out stays NULL where there is none that is whole. */
static svo_status read_layout(const svo_parts *parts, uint32_t share_count, layout_head **out, svo_message *message)
{
    unsigned char *bytes = NULL;
    size_t byte_count = 0;
    char *path = svo_i_layout_path(parts, share_count);
    if (path == NULL) {
        return svo_i_folder_no_memory(parts, message);
    }
    const svo_status status = svo_i_file_read_found(path, &bytes, &byte_count, message);
    svo_i_free(path);
    layout_head *head = (layout_head *)(void *)bytes;
    if (status == SVO_OK && head != NULL && is_whole(parts, head, byte_count) && head->share_count == share_count) {
        *out = head;
        return SVO_OK;
    }
    svo_i_free(bytes);
    return status;
}

bool svo_i_layout_is_there(const svo_parts *parts, const svo_i_stitcher *s, svo_i_layout *layout)
{
    const size_t begin = offsetof(layout_head, version);
    layout_head *own = make_bytes(parts, s, layout);
    layout_head *found = NULL;
    svo_message ignored;
    (void)read_layout(parts, layout->share_count, &found, &ignored);
    const bool is_same =
        own != NULL && found != NULL && own->layout_bytes == found->layout_bytes &&
        memcmp((const char *)own + begin, (const char *)found + begin, (size_t)own->layout_bytes - begin) == 0;
    if (is_same) {
        memcpy(layout->token, found->token, sizeof layout->token);
    }
    svo_i_free(own);
    svo_i_free(found);
    return is_same;
}

static bool take_pieces(const svo_parts *parts, const layout_piece *from, svo_i_pieces *all, svo_i_layout *layout)
{
    for (size_t i = 0; i < all->piece_count; ++i) {
        svo_i_piece *to = &all->pieces[i];
        char *path = svo_i_part_path(parts, from[i].level, from[i].code, "part");
        if (path == NULL) {
            return false;
        }
        layout->paths[layout->path_count++] = path;
        layout->shares[i] = from[i].share;
        *to = (svo_i_piece){.path = path,
                            .level = from[i].level,
                            .code = from[i].code,
                            .head_hash = from[i].head_hash,
                            .fragments = from[i].fragments,
                            .list_count = from[i].list_count};
        memcpy(to->level_begin, from[i].level_begin, sizeof to->level_begin);
    }
    return true;
}

static bool take_lists(const svo_parts *parts, const layout_head *head, svo_i_pieces *all, svo_i_layout *layout)
{
    const layout_piece *pieces = (const layout_piece *)(head + 1);
    const layout_upper *uppers = (const layout_upper *)(pieces + head->piece_count);
    const size_t piece_count = (size_t)head->piece_count;
    all->pieces = svo_i_alloc_zeroed(NULL, piece_count + 1, sizeof *all->pieces);
    all->uppers = svo_i_alloc_zeroed(NULL, (size_t)head->upper_count + 1, sizeof *all->uppers);
    layout->shares = svo_i_alloc_zeroed(NULL, piece_count + 1, sizeof *layout->shares);
    layout->paths = svo_i_alloc_zeroed(NULL, piece_count + 1, sizeof *layout->paths);
    if (all->pieces == NULL || all->uppers == NULL || layout->shares == NULL || layout->paths == NULL) {
        return false;
    }
    all->piece_count = piece_count;
    for (uint32_t level = 0; level <= all->header.depth; ++level) {
        all->upper_begin[level] = (size_t)head->upper_begin[level];
    }
    for (size_t i = 0; i < head->upper_count; ++i) {
        all->uppers[i] =
            (svo_i_upper_node){.code = uppers[i].code, .payload = uppers[i].payload, .mask = uppers[i].mask};
    }
    return take_pieces(parts, pieces, all, layout);
}

svo_status svo_i_layout_load(const svo_parts *parts, svo_i_stitcher *s, svo_i_layout *layout)
{
    layout_head *head = NULL;
    SVO_I_TRY(read_layout(parts, layout->share_count, &head, s->message));
    if (head == NULL) {
        return svo_i_fail(s->message, SVO_UNAVAILABLE, "%s: a file of %" PRIu32 " shares has not been begun",
                          parts->folder, layout->share_count);
    }
    memcpy(layout->token, head->token, sizeof layout->token);
    memcpy(layout->owners, head->owners, sizeof layout->owners);
    const bool taken = take_lists(parts, head, &s->all, layout);
    const uint64_t file_bytes = head->file_bytes;
    svo_i_free(head);
    if (!taken) {
        return no_memory(s);
    }
    SVO_I_TRY(svo_i_chunks_begin(s));
    return s->head.header.file_bytes == file_bytes
               ? SVO_OK
               : svo_i_fail(s->message, SVO_UNAVAILABLE, "%s: its shares are of another version of svocl",
                            parts->folder);
}

void svo_i_layout_free(svo_i_layout *layout)
{
    for (size_t i = 0; i < layout->path_count; ++i) {
        svo_i_free(layout->paths[i]);
    }
    svo_i_free(layout->paths);
    svo_i_free(layout->shares);
}
