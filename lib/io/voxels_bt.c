/* SPDX-License-Identifier: MIT */
/*
 * .bt files of OctoMap (Hornung et al., "OctoMap: An Efficient Probabilistic 3D Mapping Framework Based on Octrees",
 * 2013), as its library reads and writes them: lines of text, then two bytes for each inner node, each before those of
 * its children. Child i has bits 2 i and 2 i + 1; x counts 1, y 2 and z 4 of i:
 *
 *     00 unknown    01 a free leaf    10 an occupied leaf    11 an inner node
 *
 * A leaf above the last level stands for all voxels in it. There are always 16 levels, and the world's origin is in the
 * middle of them.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "io/import_text.h"
#include "io/voxels_formats.h"
#include "shared/nodes.clh"

#define BT_LEVELS      16u
#define BT_MIDDLE      (1 << (BT_LEVELS - 1))
#define BT_NODE_BYTES  2u
#define BT_OCCUPIED    2u
#define BT_INNER       3u
#define BT_HEADER_TEXT VOXELS_BT_MAGIC "\n# made by svocl\n#\nid OcTree\nsize %" PRIu64 "\nres %s\ndata\n"

/* ---- reading ---- */

typedef struct bt_reader {
    voxel_reader *reader;
    size_t at; /* byte of the next node */
    uint64_t size; /* nodes, by the header */
    uint64_t node_count, free_count, voxel_count; /* met so far */
    bool adds; /* the second time: voxels are added */
} bt_reader;

static svo_status refuse_line(const bt_reader *bt, const text_cursor *line, const char *what)
{
    return svo_i_voxels_damaged(bt->reader, "header: '%s' %s, at byte %zu", text_copy_word(line).text, what,
                                (size_t)(line->at - (const char *)bt->reader->bytes));
}

static svo_status read_size(bt_reader *bt, text_cursor *line)
{
    int64_t count = 0;
    (void)text_skip_blanks(line);
    const text_cursor word = *line;
    if (!text_take_integer(line, &count) || count < 0 || !text_at_word_end(line)) {
        return refuse_line(bt, &word, "is no number of nodes");
    }
    bt->size = (uint64_t)count;
    return SVO_OK;
}

static svo_status read_width(bt_reader *bt, text_cursor *line)
{
    double *width = &bt->reader->voxel_edge;
    (void)text_skip_blanks(line);
    const char *behind = svo_i_number_double(line->at, line->end, width);
    text_cursor word = *line;
    text_skip_word(&word);
    if (behind != word.at || !(*width > 0.0) || !isfinite(*width)) {
        return refuse_line(bt, line, "is no width of voxels above 0");
    }
    line->at = behind;
    return SVO_OK;
}

/* A line of the header. *done: it was the last. */
static svo_status read_line(bt_reader *bt, text_cursor *line, bool *has_size, bool *done)
{
    if (!text_skip_blanks(line) || *line->at == '#') {
        return SVO_OK;
    }
    if (text_take_word(line, "id")) {
        (void)text_skip_blanks(line);
        return text_take_word(line, "OcTree") ? SVO_OK : refuse_line(bt, line, "is not OcTree");
    }
    if (text_take_word(line, "size")) {
        *has_size = true;
        return read_size(bt, line);
    }
    if (text_take_word(line, "res")) {
        return read_width(bt, line);
    }
    *done = text_take_word(line, "data");
    return *done ? SVO_OK : refuse_line(bt, line, "is none of id, size, res, data");
}

static svo_status read_header(bt_reader *bt)
{
    const char *bytes = (const char *)bt->reader->bytes;
    text_cursor line = {.at = bytes, .end = bytes + bt->reader->byte_count, .line = 1};
    bool has_size = false;
    bool done = false;
    while (!done) {
        if (line.at == line.end) {
            return svo_i_voxels_damaged(bt->reader, "header: it ends without data, at byte %zu",
                                        bt->reader->byte_count);
        }
        SVO_I_TRY(read_line(bt, &line, &has_size, &done));
        while (line.at != line.end && *line.at++ != '\n') {
        }
    }
    bt->at = (size_t)(line.at - bytes);
    return has_size && bt->reader->voxel_edge > 0.0
               ? SVO_OK
               : svo_i_voxels_damaged(bt->reader, "header: no %s, before byte %zu", has_size ? "res" : "size", bt->at);
}

/* A leaf, whose voxels are side along each axis from the place on. */
static svo_status take_leaf(bt_reader *bt, const int32_t place[3], int32_t side)
{
    bt->voxel_count += (uint64_t)side * (uint64_t)side * (uint64_t)side;
    if (!bt->adds) {
        return svo_i_voxels_limit(bt->reader, bt->voxel_count);
    }
    for (int32_t z = 0; z < side; ++z) {
        for (int32_t y = 0; y < side; ++y) {
            for (int32_t x = 0; x < side; ++x) {
                svo_i_voxels_add(
                    bt->reader,
                    (svo_voxel){.x = place[0] + x, .y = place[1] + y, .z = place[2] + z, .rgba = {255, 255, 255, 255}});
            }
        }
    }
    return SVO_OK;
}

/* An inner node, whose voxels are side along each axis from the place on, and all below it. */
static svo_status read_node(bt_reader *bt, const int32_t place[3], int32_t side)
{
    if (bt->reader->byte_count - bt->at < BT_NODE_BYTES) {
        return svo_i_voxels_damaged(bt->reader, "data: the file ends in a node, at byte %zu", bt->reader->byte_count);
    }
    const size_t begin = bt->at;
    const uint32_t bits = bt->reader->bytes[begin] | (uint32_t)bt->reader->bytes[begin + 1] << 8;
    bt->at += BT_NODE_BYTES;
    for (uint32_t child = 0; child < 8; ++child) {
        const uint32_t kind = bits >> 2 * child & 3u;
        const int32_t half = side / 2;
        const int32_t at[3] = {place[0] + ((child & 1u) != 0 ? half : 0), place[1] + ((child & 2u) != 0 ? half : 0),
                               place[2] + ((child & 4u) != 0 ? half : 0)};
        bt->node_count += kind != 0 ? 1 : 0;
        bt->free_count += kind == 1 ? 1 : 0;
        if (kind == BT_INNER && half == 1) {
            return svo_i_voxels_damaged(bt->reader, "data: an inner node below level %u, at byte %zu", BT_LEVELS - 1,
                                        begin);
        }
        SVO_I_TRY(kind == BT_OCCUPIED ? take_leaf(bt, at, half) : SVO_OK);
        SVO_I_TRY(kind == BT_INNER ? read_node(bt, at, half) : SVO_OK);
    }
    return SVO_OK;
}

/* All nodes: once to check and count them, then to add the voxels. */
static svo_status read_nodes(bt_reader *bt, bool adds)
{
    static const int32_t least[3] = {-BT_MIDDLE, -BT_MIDDLE, -BT_MIDDLE};
    bt->adds = adds;
    bt->node_count = 1;
    bt->free_count = bt->voxel_count = 0;
    return read_node(bt, least, 2 * BT_MIDDLE);
}

svo_status svo_i_voxels_read_bt(voxel_reader *reader)
{
    bt_reader bt = {.reader = reader};
    SVO_I_TRY(read_header(&bt));
    const size_t begin = bt.at;
    if (bt.size > 0) {
        SVO_I_TRY(read_nodes(&bt, false));
    }
    if (bt.node_count != bt.size || bt.at != reader->byte_count) {
        return svo_i_voxels_damaged(reader, "data: %" PRIu64 " nodes to byte %zu of %zu, and size is %" PRIu64,
                                    bt.node_count, bt.at, reader->byte_count, bt.size);
    }
    SVO_I_TRY(svo_i_voxels_reserve(reader, bt.voxel_count));
    bt.at = begin;
    if (bt.size > 0) {
        SVO_I_TRY(read_nodes(&bt, true));
    }
    if (bt.free_count > 0) {
        svo_i_voxels_warn(reader, "%" PRIu64 " free leaves are left out", bt.free_count);
    }
    reader->info.instance_voxels = bt.voxel_count;
    return SVO_OK;
}

/* ---- writing ---- */

typedef struct bt_writer {
    voxel_writer *writer;
    const svo_voxel *voxels; /* in the order of codes from least on */
    int32_t least[3]; /* the voxel of code 0 */
    bool puts; /* the second time: nodes are written */
    uint64_t node_count;
} bt_writer;

/* The first voxel of a range whose code is not below the given one. */
static uint64_t first_from(const bt_writer *bt, uint64_t begin, uint64_t end, uint64_t code)
{
    while (begin < end) {
        const uint64_t middle = begin + (end - begin) / 2;
        if (svo_i_voxel_code(&bt->voxels[middle], bt->least) < code) {
            begin = middle + 1;
        } else {
            end = middle;
        }
    }
    return begin;
}

/* The inner node whose voxels are begin .. end - 1, with codes from code on, and all below it. level: 0 is the root. */
static svo_status put_node(bt_writer *bt, uint32_t level, uint64_t begin, uint64_t end, uint64_t code)
{
    const uint32_t shift = 3 * (BT_LEVELS - 1 - level);
    uint64_t ends[9] = {begin};
    uint32_t bits = 0;
    for (uint32_t child = 0; child < 8; ++child) {
        ends[child + 1] = first_from(bt, ends[child], end, code + ((uint64_t)(child + 1) << shift));
        const uint64_t count = ends[child + 1] - ends[child];
        const uint32_t kind = count == 0 ? 0 : count == UINT64_C(1) << shift ? BT_OCCUPIED : BT_INNER;
        bits |= kind << 2 * child;
        bt->node_count += kind != 0 ? 1 : 0;
    }
    const uint8_t bytes[BT_NODE_BYTES] = {(uint8_t)bits, (uint8_t)(bits >> 8)};
    SVO_I_TRY(bt->puts ? svo_i_voxels_put(bt->writer, bytes, sizeof bytes) : SVO_OK);
    for (uint32_t child = 0; child < 8; ++child) {
        if ((bits >> 2 * child & 3u) == BT_INNER) {
            SVO_I_TRY(put_node(bt, level + 1, ends[child], ends[child + 1], code + ((uint64_t)child << shift)));
        }
    }
    return SVO_OK;
}

/* Counts the nodes, or writes them. */
static svo_status put_nodes(bt_writer *bt, bool puts)
{
    bt->puts = puts;
    bt->node_count = 1;
    return put_node(bt, 0, 0, bt->writer->list.voxel_count, 0);
}

/* Finds the file's least voxel in the list: planes are whole multiples of the width. */
static svo_status place_list(bt_writer *bt)
{
    const svo_voxels_info *list = &bt->writer->list;
    for (int axis = 0; axis < 3; ++axis) {
        const double moved = rint(list->origin[axis] / list->voxel_edge);
        const double low = list->low[axis] + moved;
        const double high = list->high[axis] + moved;
        if (!(low >= -BT_MIDDLE && high <= BT_MIDDLE)) {
            return svo_i_voxels_write_fail(bt->writer, SVO_INVALID_ARGUMENT,
                                           "voxels %.0f .. %.0f along %c are not in %d .. %d, which a .bt file holds",
                                           low, high - 1.0, "xyz"[axis], -BT_MIDDLE, BT_MIDDLE - 1);
        }
        bt->least[axis] = (int32_t)(-BT_MIDDLE - moved);
    }
    return SVO_OK;
}

static svo_status put_header(const bt_writer *bt, uint64_t node_count)
{
    char width[VOXEL_NUMBER_BYTES];
    svo_message text;
    (void)svo_i_voxel_number(width, bt->writer->list.voxel_edge, 17);
    const int length = snprintf(text.text, sizeof text.text, BT_HEADER_TEXT, node_count, width);
    return svo_i_voxels_put(bt->writer, text.text, (size_t)length);
}

svo_status svo_i_voxels_write_bt(voxel_writer *writer)
{
    svo_status status = SVO_OK;
    bt_writer bt = {.writer = writer};
    const size_t count = (size_t)writer->list.voxel_count;
    if (count == 0) {
        return put_header(&bt, 0);
    }
    SVO_I_TRY(place_list(&bt));
    svo_voxel *sorted = svo_i_alloc(writer->memory, count * sizeof *sorted);
    svo_voxel *spare = svo_i_alloc(writer->memory, count * sizeof *spare);
    if (sorted == NULL || spare == NULL) {
        SVO_I_TRY_CLEANUP(
            svo_i_voxels_write_fail(writer, SVO_OUT_OF_HOST_MEMORY, "no memory to sort %zu voxels", count));
    }
    memcpy(sorted, writer->voxels, count * sizeof *sorted);
    svo_i_voxel_sort(sorted, spare, count, bt.least, BT_LEVELS, SVO_I_VOXEL_MORTON);
    bt.voxels = sorted;
    SVO_I_TRY_CLEANUP(put_nodes(&bt, false));
    SVO_I_TRY_CLEANUP(put_header(&bt, bt.node_count));
    SVO_I_TRY_CLEANUP(put_nodes(&bt, true));
cleanup:
    svo_i_free(sorted);
    svo_i_free(spare);
    return status;
}
