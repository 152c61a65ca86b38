/* SPDX-License-Identifier: MIT */
/*
 * A .vox file to its models, its palette, and the nodes, layers and materials of its scene: chunks, some with
 * dictionaries of texts. voxels_vox.c places the models.
 */
#include "io/voxels_vox_file.h"

#include <inttypes.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/voxels_files.h"

#define CHUNK_HEAD_BYTES 12u
#define FILE_HEAD_BYTES  8u
#define PALETTE_BYTES    1024u
#define ORDER_BYTES      256u /* of an IMAP chunk */
#define TEXT_BYTES       64 /* longer than three numbers of 32 bits */
#define MATERIAL_MAX     256

/* ---- messages with a place, growing lists, numbers ---- */

/* "NAME: chunk XYZI at byte 68: ", what the format says, and the byte that the cursor is at. */
static svo_status damaged(const vox_cursor *cursor, const char *format, ...) __attribute__((format(printf, 2, 3)));
static svo_status damaged(const vox_cursor *cursor, const char *format, ...)
{
    svo_message detail;
    va_list arguments;
    va_start(arguments, format);
    svo_i_fail_v(&detail, SVO_FILE_DAMAGED, format, arguments);
    va_end(arguments);
    return svo_i_voxels_damaged(cursor->reader, "chunk %s at byte %zu: %s, at byte %zu", cursor->id, cursor->offset,
                                detail.text, (size_t)(cursor->at - cursor->reader->bytes));
}

/* Grows a list to room for one more element, by doubling. */
static svo_status grow(const voxel_reader *reader, void **list, size_t count, size_t *capacity, size_t element_bytes)
{
    if (count < *capacity) {
        return SVO_OK;
    }
    const size_t larger = 2 * *capacity + 16;
    void *grown = svo_i_grow(&reader->memory, *list, larger * element_bytes);
    if (grown == NULL) {
        return svo_i_voxels_fail(reader, SVO_OUT_OF_HOST_MEMORY, "no memory for %zu parts of the scene", larger);
    }
    *list = grown;
    *capacity = larger;
    return SVO_OK;
}

/* A number at an address in the file. */
static int32_t i32_at(const uint8_t *bytes)
{
    int32_t value = 0;
    memcpy(&value, bytes, sizeof value);
    return value;
}

/* Reads a number. what: for the message. */
static svo_status read_i32(vox_cursor *cursor, const char *what, int32_t *out)
{
    if (cursor->end - cursor->at < 4) {
        return damaged(cursor, "%s ends beyond its chunk", what);
    }
    *out = i32_at(cursor->at);
    cursor->at += 4;
    return SVO_OK;
}

/* ---- nodes, layers and materials ---- */

/* A text in the file, without a terminator. */
typedef struct vox_text {
    const char *bytes;
    size_t byte_count;
} vox_text;

/* What dictionaries of nodes and layers say. */
typedef struct attributes {
    bool hidden;
    bool is_named;
    vox_transform transform;
    int32_t frame; /* -1: not said */
} attributes;

static svo_status read_text(vox_cursor *cursor, vox_text *text)
{
    int32_t length = 0;
    SVO_I_TRY(read_i32(cursor, "the length of a text", &length));
    if (length < 0 || length > cursor->end - cursor->at) {
        return damaged(cursor, "a text of %" PRId32 " bytes, %td are left", length, cursor->end - cursor->at);
    }
    if (memchr(cursor->at, 0, (size_t)length) != NULL) {
        return damaged(cursor, "a text has a byte 0");
    }
    *text = (vox_text){.bytes = (const char *)cursor->at, .byte_count = (size_t)length};
    cursor->at += length;
    return SVO_OK;
}

static svo_status read_pair_count(vox_cursor *cursor, int32_t *count)
{
    SVO_I_TRY(read_i32(cursor, "the number of attributes", count));
    return *count >= 0 && *count <= (cursor->end - cursor->at) / 8
               ? SVO_OK
               : damaged(cursor, "%" PRId32 " attributes in %td bytes", *count, cursor->end - cursor->at);
}

static bool is_text(vox_text text, const char *name)
{
    return text.byte_count == strlen(name) && memcmp(text.bytes, name, text.byte_count) == 0;
}

/* Reads exactly count whole numbers with spaces between them. The cursor is behind the text. */
static svo_status read_numbers(const vox_cursor *cursor, const char *key, vox_text text, int32_t *numbers, size_t count)
{
    char copy[TEXT_BYTES] = "";
    const bool fits = text.byte_count < sizeof copy;
    if (fits) {
        memcpy(copy, text.bytes, text.byte_count);
    }
    const char *rest = copy;
    for (size_t i = 0; i < count; ++i) {
        char *end = NULL;
        const bool apart = i == 0 || *rest == ' ';
        const long long number = strtoll(rest, &end, 10);
        if (!fits || !apart || end == rest || number < INT32_MIN || number > INT32_MAX) {
            return damaged(cursor, "%s is not %zu whole numbers", key, count);
        }
        numbers[i] = (int32_t)number;
        rest = end;
    }
    return rest[strspn(rest, " ")] == '\0' ? SVO_OK : damaged(cursor, "%s is not %zu whole numbers", key, count);
}

/*
 * The byte of a rotation:
 *
 *   7   6      5      4      3-2             1-0
 *   0   sign2  sign1  sign0  column of row 1 column of row 0
 */
static svo_status read_rotation(const vox_cursor *cursor, vox_text text, vox_transform *transform)
{
    int32_t byte = 0;
    SVO_I_TRY(read_numbers(cursor, "_r", text, &byte, 1));
    const uint32_t first = (uint32_t)byte & 3u;
    const uint32_t second = (uint32_t)byte >> 2 & 3u;
    if (byte < 0 || byte > 127 || first > 2 || second > 2 || first == second) {
        return damaged(cursor, "rotation %" PRId32 " is none", byte);
    }
    transform->column[0] = (uint8_t)first;
    transform->column[1] = (uint8_t)second;
    transform->column[2] = (uint8_t)(3u - first - second);
    for (int row = 0; row < 3; ++row) {
        transform->sign[row] = ((uint32_t)byte >> (4 + row) & 1u) != 0 ? -1 : 1;
    }
    return SVO_OK;
}

static svo_status read_attribute(const vox_cursor *cursor, vox_text key, vox_text value, attributes *read)
{
    int32_t numbers[3] = {0, 0, 0};
    if (is_text(key, "_hidden")) {
        read->hidden = is_text(value, "1");
    } else if (is_text(key, "_name")) {
        read->is_named = value.byte_count > 0;
    } else if (is_text(key, "_r")) {
        return read_rotation(cursor, value, &read->transform);
    } else if (is_text(key, "_t")) {
        SVO_I_TRY(read_numbers(cursor, "_t", value, numbers, 3));
        for (int axis = 0; axis < 3; ++axis) {
            read->transform.translation[axis] = numbers[axis];
        }
    } else if (is_text(key, "_f")) {
        SVO_I_TRY(read_numbers(cursor, "_f", value, numbers, 1));
        if (numbers[0] < 0) {
            return damaged(cursor, "frame %" PRId32 " is below 0", numbers[0]);
        }
        read->frame = numbers[0];
    }
    return SVO_OK;
}

static svo_status read_attributes(vox_cursor *cursor, attributes *read)
{
    int32_t count = 0;
    *read = (attributes){.transform = {.column = {0, 1, 2}, .sign = {1, 1, 1}}, .frame = -1};
    SVO_I_TRY(read_pair_count(cursor, &count));
    for (int32_t i = 0; i < count; ++i) {
        vox_text key = {.byte_count = 0};
        vox_text value = {.byte_count = 0};
        SVO_I_TRY(read_text(cursor, &key));
        SVO_I_TRY(read_text(cursor, &value));
        SVO_I_TRY(read_attribute(cursor, key, value, read));
    }
    return SVO_OK;
}

/* Which of the frames of a node is shown: the last to begin at the asked frame or earlier; where none does, the one
   that begins first. Frames without a number count from 0. */
typedef struct frame_choice {
    int64_t asked;
    int64_t begins; /* of the chosen one; -1: none yet */
} frame_choice;

static bool choose_frame(frame_choice *choice, int64_t begins)
{
    const int64_t held = choice->begins;
    const bool none_in_time = held < 0 || held > choice->asked;
    const bool chosen =
        begins <= choice->asked ? none_in_time || begins >= held : none_in_time && (held < 0 || begins < held);
    choice->begins = chosen ? begins : held;
    return chosen;
}

/* The number of a node's frames or models, each of which has at least element_bytes. */
static svo_status read_frame_count(vox_cursor *cursor, const char *what, ptrdiff_t element_bytes, int32_t *count)
{
    SVO_I_TRY(read_i32(cursor, what, count));
    return *count >= 1 && *count <= (cursor->end - cursor->at) / element_bytes
               ? SVO_OK
               : damaged(cursor, "%s is %" PRId32 " in %td bytes", what, *count, cursor->end - cursor->at);
}

/* Begins a node: its id and its attributes. */
static svo_status begin_node(vox_file *file, vox_cursor *cursor, vox_node_kind kind, vox_node *node)
{
    attributes own;
    *node = (vox_node){.kind = kind, .offset = cursor->offset, .layer = -1};
    SVO_I_TRY(read_i32(cursor, "the node's id", &node->id));
    SVO_I_TRY(read_attributes(cursor, &own));
    node->hidden = own.hidden;
    file->reader->info.names += own.is_named ? 1 : 0;
    return SVO_OK;
}

static svo_status add_node(vox_file *file, const vox_node *node)
{
    SVO_I_TRY(grow(file->reader, (void **)&file->nodes, file->node_count, &file->node_capacity, sizeof *file->nodes));
    file->nodes[file->node_count++] = *node;
    return SVO_OK;
}

/* Reads one node chunk, or the attributes of a layer, into the file's lists. */
static svo_status read_transform(vox_file *file, vox_cursor *cursor)
{
    vox_node node;
    int32_t reserved = 0;
    int32_t frames = 0;
    frame_choice choice = {.asked = file->reader->options.frame, .begins = -1};
    SVO_I_TRY(begin_node(file, cursor, VOX_NODE_TRANSFORM, &node));
    SVO_I_TRY(read_i32(cursor, "the child's id", &node.child));
    SVO_I_TRY(read_i32(cursor, "a reserved number", &reserved));
    SVO_I_TRY(read_i32(cursor, "the layer's id", &node.layer));
    SVO_I_TRY(read_frame_count(cursor, "the number of frames", 4, &frames));
    for (int32_t i = 0; i < frames; ++i) {
        attributes frame;
        SVO_I_TRY(read_attributes(cursor, &frame));
        if (choose_frame(&choice, frame.frame >= 0 ? frame.frame : i)) {
            node.transform = frame.transform;
        }
    }
    file->reader->info.left_out_frames += (uint64_t)frames - 1;
    return add_node(file, &node);
}

static svo_status read_group(vox_file *file, vox_cursor *cursor)
{
    vox_node node;
    int32_t count = 0;
    SVO_I_TRY(begin_node(file, cursor, VOX_NODE_GROUP, &node));
    SVO_I_TRY(read_i32(cursor, "the number of children", &count));
    if (count < 0 || count > (cursor->end - cursor->at) / VOX_NODE_BYTES) {
        return damaged(cursor, "%" PRId32 " children in %td bytes", count, cursor->end - cursor->at);
    }
    node.children = cursor->at;
    node.child_count = (uint32_t)count;
    ++file->reader->info.groups;
    return add_node(file, &node);
}

static svo_status read_shape(vox_file *file, vox_cursor *cursor)
{
    vox_node node;
    int32_t models = 0;
    frame_choice choice = {.asked = file->reader->options.frame, .begins = -1};
    SVO_I_TRY(begin_node(file, cursor, VOX_NODE_SHAPE, &node));
    SVO_I_TRY(read_frame_count(cursor, "the number of models", 8, &models));
    for (int32_t i = 0; i < models; ++i) {
        int32_t model = 0;
        attributes own;
        SVO_I_TRY(read_i32(cursor, "a model's id", &model));
        if (model < 0) {
            return damaged(cursor, "model %" PRId32 " is below 0", model);
        }
        SVO_I_TRY(read_attributes(cursor, &own));
        if (choose_frame(&choice, own.frame >= 0 ? own.frame : i)) {
            node.child = model;
        }
    }
    file->reader->info.left_out_frames += (uint64_t)models - 1;
    return add_node(file, &node);
}

static svo_status read_layer(vox_file *file, vox_cursor *cursor)
{
    vox_layer layer = {.offset = cursor->offset};
    attributes own;
    SVO_I_TRY(read_i32(cursor, "the layer's id", &layer.id));
    SVO_I_TRY(read_attributes(cursor, &own));
    layer.hidden = own.hidden;
    ++file->reader->info.layers;
    file->reader->info.names += own.is_named ? 1 : 0;
    SVO_I_TRY(
        grow(file->reader, (void **)&file->layers, file->layer_count, &file->layer_capacity, sizeof *file->layers));
    file->layers[file->layer_count++] = layer;
    return SVO_OK;
}

static svo_status read_material_id(vox_cursor *cursor, int32_t *id)
{
    SVO_I_TRY(read_i32(cursor, "the material's id", id));
    return *id >= 0 && *id <= MATERIAL_MAX
               ? SVO_OK
               : damaged(cursor, "material %" PRId32 " is not in 0 .. %d", *id, MATERIAL_MAX);
}

/* Reads a material of version 200 or 150 into the reader's properties. */
static svo_status read_matl(vox_file *file, vox_cursor *cursor)
{
    int32_t id = 0;
    int32_t count = 0;
    SVO_I_TRY(read_material_id(cursor, &id));
    SVO_I_TRY(read_pair_count(cursor, &count));
    for (int32_t i = 0; i < count; ++i) {
        vox_text key = {.byte_count = 0};
        vox_text value = {.byte_count = 0};
        SVO_I_TRY(read_text(cursor, &key));
        SVO_I_TRY(read_text(cursor, &value));
        if (key.byte_count == 0) {
            return damaged(cursor, "an attribute without a key");
        }
        SVO_I_TRY(svo_i_voxels_add_property(file->reader, (uint32_t)id, key.bytes, key.byte_count, value.bytes,
                                            value.byte_count));
    }
    return SVO_OK;
}

static svo_status add_words(vox_file *file, int32_t id, const char *key, const char *value)
{
    return svo_i_voxels_add_property(file->reader, (uint32_t)id, key, strlen(key), value, strlen(value));
}

/* A material as versions before the scene have it, under the keys of MATL. Bit 7 has no value. */
static svo_status read_matt(vox_file *file, vox_cursor *cursor)
{
    static const char *const types[] = {"_diffuse", "_metal", "_glass", "_emit"};
    static const char *const keys[] = {"_plastic", "_rough", "_spec", "_ior", "_att", "_flux", "_emit"};
    int32_t id = 0;
    int32_t type = 0;
    int32_t weight = 0;
    int32_t bits = 0;
    char value[VOXEL_NUMBER_BYTES];
    SVO_I_TRY(read_material_id(cursor, &id));
    SVO_I_TRY(read_i32(cursor, "the material's type", &type));
    if (type < 0 || type > 3) {
        return damaged(cursor, "material type %" PRId32 " is not in 0 .. 3", type);
    }
    SVO_I_TRY(read_i32(cursor, "the material's weight", &weight));
    SVO_I_TRY(read_i32(cursor, "the material's properties", &bits));
    SVO_I_TRY(add_words(file, id, "_type", types[type]));
    for (int bit = -1; bit < (int)(sizeof keys / sizeof keys[0]); ++bit) {
        float number = 0.0f;
        int32_t word = weight;
        if (bit >= 0 && ((uint32_t)bits >> bit & 1u) == 0) {
            continue;
        }
        if (bit >= 0) {
            SVO_I_TRY(read_i32(cursor, keys[bit], &word));
        }
        memcpy(&number, &word, sizeof number);
        if (!isfinite(number)) {
            return damaged(cursor, "a property of material %" PRId32 " is not finite", id);
        }
        SVO_I_TRY(add_words(file, id, bit < 0 ? "_weight" : keys[bit], svo_i_voxel_number(value, (double)number, 9)));
    }
    return SVO_OK;
}

/* ---- chunks, models and the palette ---- */

/* The palette that files without RGBA mean: a cube of colors, whose sides fall in steps of 51 from white on without
   black, then ramps of red, green, blue and gray without the steps that the cube has. */
static void default_palette(uint8_t palette[256][4])
{
    size_t index = 1;
    memset(palette[0], 0, 4);
    for (unsigned i = 0; i < 215; ++i, ++index) {
        const uint8_t color[4] = {(uint8_t)(255 - i / 36 * 51), (uint8_t)(255 - i / 6 % 6 * 51),
                                  (uint8_t)(255 - i % 6 * 51), 255};
        memcpy(palette[index], color, 4);
    }
    for (unsigned ramp = 0; ramp < 4; ++ramp) {
        for (unsigned step = 14; step > 0; --step) {
            if (step % 3 == 0) {
                continue;
            }
            for (unsigned channel = 0; channel < 3; ++channel) {
                palette[index][channel] = (uint8_t)(ramp == channel || ramp == 3 ? step * 17 : 0);
            }
            palette[index++][3] = 255;
        }
    }
}

static svo_status read_pack(vox_file *file, vox_cursor *cursor)
{
    int32_t count = 0;
    SVO_I_TRY(read_i32(cursor, "the number of models", &count));
    if (count < 0) {
        return damaged(cursor, "%" PRId32 " models", count);
    }
    file->packed = count;
    return SVO_OK;
}

static svo_status read_size(vox_file *file, vox_cursor *cursor)
{
    if (file->has_size) {
        return damaged(cursor, "the size before it has no XYZI");
    }
    for (int axis = 0; axis < 3; ++axis) {
        SVO_I_TRY(read_i32(cursor, "a size", &file->size[axis]));
        if (file->size[axis] < 1 || file->size[axis] > VOX_SIDE_MAX) {
            return damaged(cursor, "size %c %" PRId32 " is not in 1 .. %d", "xyz"[axis], file -> size[axis],
                           VOX_SIDE_MAX);
        }
    }
    file->has_size = true;
    return SVO_OK;
}

static svo_status read_voxels(vox_file *file, vox_cursor *cursor)
{
    int32_t count = 0;
    if (!file->has_size) {
        return damaged(cursor, "no SIZE before it");
    }
    SVO_I_TRY(read_i32(cursor, "the number of voxels", &count));
    if (count < 0 || (uint64_t)count * 4 != (uint64_t)(cursor->end - cursor->at)) {
        return damaged(cursor, "%" PRId32 " voxels in %td bytes", count, cursor->end - cursor->at);
    }
    vox_model model = {.voxels = cursor->at, .count = (uint32_t)count};
    memcpy(model.size, file->size, sizeof model.size);
    for (; cursor->at < cursor->end; cursor->at += 4) {
        for (int axis = 0; axis < 3; ++axis) {
            if (cursor->at[axis] >= model.size[axis]) {
                return damaged(cursor, "voxel %td: %c %d is not below %" PRId32, (cursor->at - model.voxels) / 4,
                               "xyz"[axis], cursor -> at[axis], model.size[axis]);
            }
        }
        model.filled += cursor->at[3] != 0 ? 1 : 0;
        file->is_used[cursor->at[3]] = true;
    }
    SVO_I_TRY(
        grow(file->reader, (void **)&file->models, file->model_count, &file->model_capacity, sizeof *file->models));
    file->models[file->model_count++] = model;
    file->has_size = false;
    return SVO_OK;
}

static svo_status read_palette(vox_file *file, vox_cursor *cursor)
{
    if (cursor->end - cursor->at != PALETTE_BYTES) {
        return damaged(cursor, "%td bytes of colors, not %u", cursor->end - cursor->at, PALETTE_BYTES);
    }
    memcpy(file->palette[1], cursor->at, PALETTE_BYTES - 4); /* the last entry is no voxel's */
    file->has_palette = true;
    return SVO_OK;
}

/* The order in which an editor shows the palette; it changes no color. */
static svo_status check_order(vox_file *file, vox_cursor *cursor)
{
    ++file->reader->info.palette_orders;
    return cursor->end - cursor->at == ORDER_BYTES
               ? SVO_OK
               : damaged(cursor, "%td bytes of indices, not %u", cursor->end - cursor->at, ORDER_BYTES);
}

/* What no list of voxels has is counted. */
static svo_status count_camera(vox_file *file, vox_cursor *cursor)
{
    (void)cursor;
    ++file->reader->info.cameras;
    return SVO_OK;
}

static svo_status count_render_setting(vox_file *file, vox_cursor *cursor)
{
    (void)cursor;
    ++file->reader->info.render_settings;
    return SVO_OK;
}

static svo_status count_notes(vox_file *file, vox_cursor *cursor)
{
    (void)cursor;
    ++file->reader->info.notes;
    return SVO_OK;
}

static svo_status read_content(vox_file *file, vox_cursor *cursor)
{
    static const struct {
        const char *id;
        svo_status (*read)(vox_file *file, vox_cursor *cursor);
    } chunks[] = {{"PACK", read_pack},
                  {"SIZE", read_size},
                  {"XYZI", read_voxels},
                  {"RGBA", read_palette},
                  {"IMAP", check_order},
                  {"MATT", read_matt},
                  {"MATL", read_matl},
                  {"LAYR", read_layer},
                  {"nTRN", read_transform},
                  {"nGRP", read_group},
                  {"nSHP", read_shape},
                  {"rCAM", count_camera},
                  {"rOBJ", count_render_setting},
                  {"NOTE", count_notes}};
    for (size_t i = 0; i < sizeof chunks / sizeof chunks[0]; ++i) {
        if (strcmp(cursor->id, chunks[i].id) == 0) {
            return chunks[i].read(file, cursor);
        }
    }
    ++file->reader->info.other_chunks; /* not known: skipped */
    return SVO_OK;
}

/* Reads the head of a chunk; the cursor is then its content. *next: where its children end. */
static svo_status open_chunk(const vox_file *file, size_t offset, size_t end, vox_cursor *cursor, size_t *next)
{
    const uint8_t *bytes = file->reader->bytes;
    *cursor = (vox_cursor){.reader = file->reader, .id = "?", .offset = offset, .at = bytes + offset};
    if (end - offset < CHUNK_HEAD_BYTES) {
        return damaged(cursor, "truncated: its head has %u bytes, %zu are there", CHUNK_HEAD_BYTES, end - offset);
    }
    for (size_t i = 0; i < 4; ++i) {
        const uint8_t letter = bytes[offset + i];
        cursor->id[i] = (char)(letter > ' ' && letter < 127 ? letter : '?');
    }
    const int32_t content_bytes = i32_at(bytes + offset + 4);
    const int32_t children_bytes = i32_at(bytes + offset + 8);
    const size_t left = end - offset - CHUNK_HEAD_BYTES;
    if (content_bytes < 0 || children_bytes < 0 || (uint64_t)content_bytes + (uint64_t)children_bytes > left) {
        return damaged(cursor, "truncated: %" PRId32 " and %" PRId32 " bytes expected, %zu there", content_bytes,
                       children_bytes, left);
    }
    cursor->at += CHUNK_HEAD_BYTES;
    cursor->end = cursor->at + content_bytes;
    *next = offset + CHUNK_HEAD_BYTES + (size_t)content_bytes + (size_t)children_bytes;
    return SVO_OK;
}

static svo_status read_chunks(vox_file *file, size_t offset, size_t end)
{
    while (offset < end) {
        vox_cursor cursor;
        size_t next = 0;
        SVO_I_TRY(open_chunk(file, offset, end, &cursor, &next));
        SVO_I_TRY(read_content(file, &cursor));
        offset = next;
    }
    return SVO_OK;
}

svo_status svo_i_vox_read_file(vox_file *file)
{
    voxel_reader *reader = file->reader;
    vox_cursor main_chunk;
    size_t end = 0;
    default_palette(file->palette);
    if (reader->byte_count < FILE_HEAD_BYTES) {
        return svo_i_voxels_damaged(reader, "truncated: %u bytes expected at least, %zu there", FILE_HEAD_BYTES,
                                    reader->byte_count);
    }
    const int32_t version = i32_at(reader->bytes + 4);
    if (version != 150 && version != 200) {
        return svo_i_voxels_damaged(reader, "byte 4: version %" PRId32 " is not known, only 150 and 200", version);
    }
    reader->info.version = (uint32_t)version;
    SVO_I_TRY(open_chunk(file, FILE_HEAD_BYTES, reader->byte_count, &main_chunk, &end));
    if (strcmp(main_chunk.id, "MAIN") != 0) {
        return damaged(&main_chunk, "not MAIN");
    }
    if (end != reader->byte_count) {
        return damaged(&main_chunk, "it ends at byte %zu, the file at %zu", end, reader->byte_count);
    }
    SVO_I_TRY(read_chunks(file, (size_t)(main_chunk.end - reader->bytes), end));
    if (file->has_size) {
        return svo_i_voxels_damaged(reader, "byte %zu: the last SIZE has no XYZI", end);
    }
    if (file->packed >= 0 && (uint64_t)file->packed != file->model_count) {
        return svo_i_voxels_damaged(reader, "byte %zu: %zu models, PACK says %" PRId64, end, file->model_count,
                                    file->packed);
    }
    reader->info.models = file->model_count;
    for (size_t i = 1; i < 256 && file->has_palette; ++i) {
        reader->info.unused_colors += file->is_used[i] ? 0 : 1;
    }
    return SVO_OK;
}
