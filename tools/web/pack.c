/* SPDX-License-Identifier: MIT */
/* Cuts compact trees at a level, and compresses what is left. */
#include "web/pack.h"

#define ZLIB_CONST /* what is read is const */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "svocl/plan.h"

#define MASKS_PER_ENTRY ((uint64_t)1 << WEB_DIRECTORY_STEP_LOG2)
/* The length of a normal, squared, up to which pictures show the face's in its place. */
#define SHORT_NORMAL 0.04f

/* ---- cuts ---- */

web_tree web_tree_of(const svo_compact *compact)
{
    web_tree tree = {SVO_COMPACT_INFO_INIT, SVO_COMPACT_ARRAYS_INIT};
    (void)svo_compact_get_info(compact, &tree.info);
    (void)svo_compact_get_arrays(compact, &tree.arrays);
    return tree;
}

static web_payload cut_payload(const web_tree *tree, bool held, uint32_t need, uint64_t node_count)
{
    if (held && (tree->info.constant & need) != 0) {
        return (web_payload){.count = 1, .first = 0, .stride = 0};
    }
    const uint32_t first = tree->arrays.bases != NULL ? tree->arrays.bases[0] : 0;
    const bool reached = held && node_count > first;
    return (web_payload){.count = reached ? node_count - first : 0, .first = first, .stride = 1};
}

static uint64_t whole_masks(const web_cut *cut)
{
    return cut->directory_count * MASKS_PER_ENTRY;
}

web_cut web_cut_at(const web_tree *tree, uint32_t level)
{
    web_cut cut = {.level = level};
    for (uint32_t l = 0; l < level; ++l) {
        cut.mask_count += (uint64_t)tree->info.level_inner[l] + tree->info.level_leaf[l];
        cut.leaf_count += tree->info.level_leaf[l];
    }
    const uint64_t last = (uint64_t)tree->info.level_inner[level] + tree->info.level_leaf[level];
    cut.node_count = cut.mask_count + last;
    cut.leaf_count += last;
    cut.directory_count = (cut.mask_count + MASKS_PER_ENTRY - 1) / MASKS_PER_ENTRY;
    cut.colors = cut_payload(tree, tree->arrays.colors != NULL, SVO_NEED_COLOR, cut.node_count);
    cut.normals = cut_payload(tree, tree->arrays.normals != NULL, SVO_NEED_NORMAL, cut.node_count);
    cut.byte_count = whole_masks(&cut) + 4 * cut.directory_count + 4 * cut.colors.count + 2 * cut.normals.count;
    return cut;
}

/* ---- normals ---- */

static unsigned char pack_coordinate(float coordinate)
{
    return (unsigned char)(128.0f + rintf(127.0f * coordinate));
}

void web_pack_normal(const int16_t normal[3], unsigned char out[2])
{
    const float x = (float)normal[0] / 32767.0f;
    const float y = (float)normal[1] / 32767.0f;
    const float z = (float)normal[2] / 32767.0f;
    const float sum = fabsf(x) + fabsf(y) + fabsf(z);
    if (!(x * x + y * y + z * z > SHORT_NORMAL)) {
        out[0] = out[1] = 0;
        return;
    }
    float u = x / sum;
    float v = y / sum;
    if (z < 0.0f) {
        const float unfolded = u;
        u = (1.0f - fabsf(v)) * (unfolded >= 0.0f ? 1.0f : -1.0f);
        v = (1.0f - fabsf(unfolded)) * (v >= 0.0f ? 1.0f : -1.0f);
    }
    out[0] = pack_coordinate(u);
    out[1] = pack_coordinate(v);
}

/* ---- compression ---- */

#define PIECE_BYTES ((size_t)1 << 16)

/* What deflate has made so far. */
typedef struct packed {
    z_stream stream;
    unsigned char *bytes; /* by malloc */
    size_t capacity, limit;
} packed;

static web_pack_status make_room(packed *to)
{
    const size_t used = to->capacity - to->stream.avail_out;
    const size_t wanted = to->capacity < to->limit / 2 ? 2 * to->capacity : to->limit;
    if (used == to->limit) {
        return WEB_PACK_TOO_LARGE;
    }
    unsigned char *grown = realloc(to->bytes, wanted);
    if (grown == NULL) {
        return WEB_PACK_NO_MEMORY;
    }
    to->bytes = grown;
    to->capacity = wanted;
    to->stream.next_out = grown + used;
    to->stream.avail_out = (uInt)(wanted - used);
    return WEB_PACK_DONE;
}

/* Compresses a piece of at most PIECE_BYTES; flush: Z_NO_FLUSH, or Z_FINISH after the last one. */
static web_pack_status deflate_piece(packed *to, const unsigned char *bytes, size_t byte_count, int flush)
{
    to->stream.next_in = bytes;
    to->stream.avail_in = (uInt)byte_count;
    for (;;) {
        const int result = deflate(&to->stream, flush);
        if (result == Z_STREAM_END || (flush == Z_NO_FLUSH && to->stream.avail_in == 0 && to->stream.avail_out > 0)) {
            return WEB_PACK_DONE;
        }
        const web_pack_status status = to->stream.avail_out == 0 ? make_room(to) : WEB_PACK_NO_MEMORY;
        if (status != WEB_PACK_DONE) {
            return status;
        }
    }
}

static web_pack_status deflate_bytes(packed *to, const void *bytes, uint64_t byte_count)
{
    web_pack_status status = WEB_PACK_DONE;
    for (uint64_t at = 0; at < byte_count && status == WEB_PACK_DONE; at += PIECE_BYTES) {
        const uint64_t left = byte_count - at;
        status = deflate_piece(to, (const unsigned char *)bytes + at, left < PIECE_BYTES ? (size_t)left : PIECE_BYTES,
                               Z_NO_FLUSH);
    }
    return status;
}

static web_pack_status deflate_normals(packed *to, const int16_t *normals, uint64_t count)
{
    unsigned char piece[PIECE_BYTES];
    web_pack_status status = WEB_PACK_DONE;
    size_t used = 0;
    for (uint64_t i = 0; i < count && status == WEB_PACK_DONE; ++i) {
        web_pack_normal(normals + 3 * i, piece + used);
        used += 2;
        if (used == sizeof piece || i + 1 == count) {
            status = deflate_piece(to, piece, used, Z_NO_FLUSH);
            used = 0;
        }
    }
    return status;
}

static web_pack_status deflate_all(packed *to, const web_tree *tree, const web_cut *cut)
{
    static const unsigned char zeros[1 << WEB_DIRECTORY_STEP_LOG2] = {0};
    web_pack_status status = deflate_bytes(to, tree->arrays.nodes, cut->mask_count);
    if (status == WEB_PACK_DONE) {
        status = deflate_bytes(to, zeros, whole_masks(cut) - cut->mask_count);
    }
    if (status == WEB_PACK_DONE) {
        status = deflate_bytes(to, tree->arrays.links, 4 * cut->directory_count);
    }
    if (status == WEB_PACK_DONE) {
        status = deflate_bytes(to, tree->arrays.colors, 4 * cut->colors.count);
    }
    if (status == WEB_PACK_DONE) {
        status = deflate_normals(to, tree->arrays.normals, cut->normals.count);
    }
    return status == WEB_PACK_DONE ? deflate_piece(to, zeros, 0, Z_FINISH) : status;
}

web_pack_status web_pack(const web_tree *tree, const web_cut *cut, size_t limit, unsigned char **out,
                         size_t *byte_count)
{
    enum { WINDOW_BITS = 15, AS_GZIP = 16, MEMORY_LEVEL = 8 };
    packed to = {.limit = limit};
    if (deflateInit2(&to.stream, Z_BEST_COMPRESSION, Z_DEFLATED, WINDOW_BITS | AS_GZIP, MEMORY_LEVEL,
                     Z_DEFAULT_STRATEGY) != Z_OK) {
        return WEB_PACK_NO_MEMORY;
    }
    to.capacity = limit < PIECE_BYTES ? limit : PIECE_BYTES;
    to.bytes = malloc(to.capacity + 1);
    to.stream.next_out = to.bytes;
    to.stream.avail_out = (uInt)to.capacity;
    const web_pack_status status = to.bytes != NULL ? deflate_all(&to, tree, cut) : WEB_PACK_NO_MEMORY;
    (void)deflateEnd(&to.stream);
    if (status != WEB_PACK_DONE) {
        free(to.bytes);
        return status;
    }
    *out = to.bytes;
    *byte_count = (size_t)to.stream.total_out;
    return WEB_PACK_DONE;
}
