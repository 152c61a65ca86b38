/* SPDX-License-Identifier: MIT */
/* Cuts compact trees at a level, and compresses what is left. */
#include "web/pack.h"

#define ZLIB_CONST /* what is read is const */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "svocl/nodes.h"

#define MASKS_PER_ENTRY ((uint64_t)1 << WEB_DIRECTORY_STEP_LOG2)
/* The deepest level that is searched for the bounds of the occupied part. */
#define BOUNDS_LEVEL_MAX 6u
/* The length of a normal, squared, up to which pictures show the face's in its place. */
#define SHORT_NORMAL 0.04f

/* ---- cuts ---- */

web_tree web_tree_of(const svo_compact *compact)
{
    web_tree tree = {SVO_COMPACT_INFO_INIT, SVO_COMPACT_ARRAYS_INIT, NULL};
    (void)svo_compact_get_info(compact, &tree.info);
    (void)svo_compact_get_arrays(compact, &tree.arrays);
    return tree;
}

double web_tree_edge(const web_tree *tree, uint32_t level)
{
    const svo_compact_info *info = &tree->info;
    const svo_grid grid = {.depth = info->depth,
                           .snap_bits = info->snap_bits,
                           .origin = {info->origin[0], info->origin[1], info->origin[2]},
                           .scale = info->scale,
                           .edge = info->edge};
    return svo_grid_cell_edge(&grid, level);
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

static web_payload cut_light(const web_light *light, uint64_t node_count)
{
    const uint64_t held = light != NULL ? light->node_count : 0;
    return (web_payload){.count = held < node_count ? held : node_count, .first = 0, .stride = 1};
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
    cut.light = cut_light(tree->light, cut.node_count);
    cut.byte_count = (MASKS_PER_ENTRY + 4) * cut.directory_count + 4 * cut.colors.count + 2 * cut.normals.count +
                     (uint64_t)4 * WEB_LIGHT_FACES * cut.light.count;
    return cut;
}

/* ---- bounds ---- */

typedef struct bounds {
    uint32_t low[3], high[3]; /* high: one past the last cell */
} bounds;

/* width: of the cell, in voxels. */
static void extend(bounds *box, uint64_t code, uint32_t width)
{
    uint32_t cell[3];
    svo_code_to_cell(code, cell);
    for (int axis = 0; axis < 3; ++axis) {
        const uint32_t low = cell[axis] * width;
        box->low[axis] = low < box->low[axis] ? low : box->low[axis];
        box->high[axis] = low + width > box->high[axis] ? low + width : box->high[axis];
    }
}

uint64_t *web_tree_codes(const web_tree *tree, uint32_t level)
{
    const uint8_t *masks = tree->arrays.nodes;
    const web_cut cut = web_cut_at(tree, level);
    uint64_t *codes = malloc((size_t)cut.node_count * sizeof *codes);
    if (codes == NULL) {
        return NULL;
    }
    codes[0] = 0;
    uint64_t child = 1;
    for (uint64_t node = 0; node < cut.mask_count; ++node) {
        for (unsigned octant = 0; octant < 8; ++octant) {
            if ((masks[node] >> octant & 1u) != 0) {
                codes[child++] = codes[node] << 3 | octant;
            }
        }
    }
    return codes;
}

bool web_tree_bounds(const web_tree *tree, uint32_t low[3], uint32_t high[3])
{
    const svo_compact_info *info = &tree->info;
    const uint8_t *masks = tree->arrays.nodes;
    const uint32_t deepest = info->depth < BOUNDS_LEVEL_MAX ? info->depth : BOUNDS_LEVEL_MAX;
    const uint32_t voxels = 1u << info->depth;
    bounds box = {{voxels, voxels, voxels}, {0, 0, 0}};
    uint64_t *codes = web_tree_codes(tree, deepest);
    if (codes == NULL) {
        return false;
    }
    uint64_t node = 0;
    for (uint32_t level = 0; level <= deepest; ++level) {
        for (const uint64_t end = web_cut_at(tree, level).node_count; node < end; ++node) {
            if (level == deepest || masks[node] == 0) {
                extend(&box, codes[node], voxels >> level);
            }
        }
    }
    free(codes);
    memcpy(low, box.low, sizeof box.low);
    memcpy(high, box.high, sizeof box.high);
    return true;
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

void web_pack_light(const float light[3], unsigned char out[4])
{
    int exponent = 0;
    const float brightest = fmaxf(light[0], fmaxf(light[1], light[2]));
    (void)frexpf(brightest, &exponent);
    exponent = exponent < -127 || !(brightest > 0.0F) ? -127 : exponent > 127 ? 127 : exponent;
    for (int channel = 0; channel < 3; ++channel) {
        const float share = ldexpf(light[channel], -exponent);
        out[channel] = (unsigned char)(255.0F * (share < 1.0F ? share : 1.0F) + 0.5F);
    }
    out[3] = (unsigned char)(exponent + 128);
}

/* ---- compression ---- */

#define PIECE_BYTES ((size_t)1 << 16)
/* Levels of fewer bytes are not worth an end of their own. */
#define BLOCK_BYTES_MIN ((uint64_t)1 << 14)

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

/* Compresses a piece of at most PIECE_BYTES; flush: Z_NO_FLUSH, Z_SYNC_FLUSH after levels, or Z_FINISH after all. */
static web_pack_status deflate_piece(packed *to, const unsigned char *bytes, size_t byte_count, int flush)
{
    to->stream.next_in = bytes;
    to->stream.avail_in = (uInt)byte_count;
    for (;;) {
        const int result = deflate(&to->stream, flush);
        if (result == Z_STREAM_END || (flush != Z_FINISH && to->stream.avail_in == 0 && to->stream.avail_out > 0)) {
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

/* Elements first .. last of an array; NULL: there is none. */
static web_pack_status deflate_range(packed *to, const void *array, size_t element_bytes, uint64_t first, uint64_t last)
{
    return first < last
               ? deflate_bytes(to, (const unsigned char *)array + first * element_bytes, (last - first) * element_bytes)
               : WEB_PACK_DONE;
}

/* Masks first .. last; those from end on are zero. */
static web_pack_status deflate_masks(packed *to, const uint8_t *masks, uint64_t first, uint64_t last, uint64_t end)
{
    static const unsigned char zeros[1 << WEB_DIRECTORY_STEP_LOG2] = {0};
    const uint64_t held = end < first ? first : end < last ? end : last;
    const web_pack_status status = deflate_range(to, masks, 1, first, held);
    return status == WEB_PACK_DONE ? deflate_bytes(to, zeros, last - held) : status;
}

static web_pack_status deflate_normals(packed *to, const int16_t *normals, uint64_t first, uint64_t last)
{
    unsigned char piece[PIECE_BYTES];
    web_pack_status status = WEB_PACK_DONE;
    size_t used = 0;
    for (uint64_t i = first; i < last && status == WEB_PACK_DONE; ++i) {
        web_pack_normal(normals + 3 * i, piece + used);
        used += 2;
        if (used == sizeof piece || i + 1 == last) {
            status = deflate_piece(to, piece, used, Z_NO_FLUSH);
            used = 0;
        }
    }
    return status;
}

/* What a cut adds to the one above it. mask_count: of the page. */
static web_pack_status deflate_level(packed *to, const web_tree *tree, const web_cut *above, const web_cut *cut,
                                     uint64_t mask_count)
{
    const svo_compact_arrays *arrays = &tree->arrays;
    web_pack_status status = deflate_masks(to, arrays->nodes, MASKS_PER_ENTRY * above->directory_count,
                                           MASKS_PER_ENTRY * cut->directory_count, mask_count);
    if (status == WEB_PACK_DONE) {
        status = deflate_range(to, arrays->links, 4, above->directory_count, cut->directory_count);
    }
    if (status == WEB_PACK_DONE) {
        status = deflate_range(to, arrays->colors, 4, above->colors.count, cut->colors.count);
    }
    if (status == WEB_PACK_DONE) {
        status = deflate_normals(to, arrays->normals, above->normals.count, cut->normals.count);
    }
    if (status == WEB_PACK_DONE && tree->light != NULL) {
        status =
            deflate_range(to, tree->light->texels, sizeof *tree->light->texels, above->light.count, cut->light.count);
    }
    return status;
}

/* The levels one after the other; ends where the bytes since the last end suffice. */
static web_pack_status deflate_all(packed *to, const web_tree *tree, const web_cut *cut, web_packed *out)
{
    web_cut above = {0};
    uint64_t ended = 0; /* bytes of the stream in front of the last end */
    web_pack_status status = WEB_PACK_DONE;
    for (uint32_t level = 1; level <= cut->level && status == WEB_PACK_DONE; ++level) {
        const web_cut here = web_cut_at(tree, level);
        const bool is_last = level == cut->level;
        status = deflate_level(to, tree, &above, &here, cut->mask_count);
        if (status == WEB_PACK_DONE && (is_last || here.byte_count - ended >= BLOCK_BYTES_MIN)) {
            status = deflate_piece(to, NULL, 0, is_last ? Z_FINISH : Z_SYNC_FLUSH);
            out->ends[out->end_count++] = (size_t)to->stream.total_out;
            ended = here.byte_count;
        }
        above = here;
    }
    return status;
}

web_pack_status web_pack(const web_tree *tree, const web_cut *cut, size_t limit, web_packed *out)
{
    enum { WINDOW_BITS = 15, AS_GZIP = 16, MEMORY_LEVEL = 8 };
    packed to = {.limit = limit};
    *out = (web_packed){.bytes = NULL};
    if (deflateInit2(&to.stream, Z_BEST_COMPRESSION, Z_DEFLATED, WINDOW_BITS | AS_GZIP, MEMORY_LEVEL,
                     Z_DEFAULT_STRATEGY) != Z_OK) {
        return WEB_PACK_NO_MEMORY;
    }
    to.capacity = limit < PIECE_BYTES ? limit : PIECE_BYTES;
    to.bytes = malloc(to.capacity + 1);
    to.stream.next_out = to.bytes;
    to.stream.avail_out = (uInt)to.capacity;
    const web_pack_status status = to.bytes != NULL ? deflate_all(&to, tree, cut, out) : WEB_PACK_NO_MEMORY;
    (void)deflateEnd(&to.stream);
    if (status != WEB_PACK_DONE) {
        free(to.bytes);
        *out = (web_packed){.bytes = NULL};
        return status;
    }
    out->bytes = to.bytes;
    out->count = (size_t)to.stream.total_out;
    return WEB_PACK_DONE;
}
