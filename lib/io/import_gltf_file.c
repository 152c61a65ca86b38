/* SPDX-License-Identifier: MIT */
/*
 * The container of glTF 2.0 (Khronos, "glTF 2.0 Specification", 3.6 and 4): JSON by cJSON; buffers beside the file, in
 * it as base64, or in the binary chunk; accessors with strides, normalized integers and sparse values.
 */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/message.h"
#include "io/import_gltf.h"

#define CHUNK_JSON   0x4e4f534au
#define CHUNK_BINARY 0x004e4942u
#define STRIDE_MAX   65536.0 /* glTF's is 252 */
#define WHOLE_MAX    9007199254740992.0 /* 2^53 */
#define SPARSE_MAX   ((size_t)1 << 30) /* bytes of elements that are sparse */

static const char *const table_names[GLTF_KIND_COUNT] = {"accessors", "bufferViews", "buffers",  "images", "materials",
                                                         "meshes",    "nodes",       "samplers", "scenes", "textures"};

static svo_status out_of_memory(const gltf_file *file)
{
    return svo_i_read_out_of_memory(file->reader);
}

/* ---- JSON ---- */

const cJSON *svo_i_gltf_get(const cJSON *owner, const char *name)
{
    return owner != NULL ? cJSON_GetObjectItemCaseSensitive(owner, name) : NULL;
}

const cJSON *svo_i_gltf_extension(const cJSON *owner, const char *name)
{
    return svo_i_gltf_get(svo_i_gltf_get(owner, "extensions"), name);
}

svo_status svo_i_gltf_element(const gltf_file *file, const cJSON *element, const char *name, gltf_kind kind,
                              uint32_t *index)
{
    const gltf_table *table = &file->tables[kind];
    const double value = cJSON_IsNumber(element) ? element->valuedouble : -1;
    if (!(value >= 0 && value < table->count) || value != floor(value)) {
        return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED, "%s %g is none of the %" PRIu32 " %s", name, value,
                          table->count, table_names[kind]);
    }
    *index = (uint32_t)value;
    return SVO_OK;
}

svo_status svo_i_gltf_index(const gltf_file *file, const cJSON *owner, const char *name, gltf_kind kind,
                            uint32_t *index)
{
    const cJSON *item = svo_i_gltf_get(owner, name);
    *index = GLTF_NONE;
    return item != NULL ? svo_i_gltf_element(file, item, name, kind, index) : SVO_OK;
}

svo_status svo_i_gltf_numbers(const gltf_file *file, const cJSON *owner, const char *name, double *values, int count)
{
    const cJSON *item = svo_i_gltf_get(owner, name);
    if (item == NULL) {
        return SVO_OK;
    }
    bool sound = count == 1 ? cJSON_IsNumber(item) : cJSON_IsArray(item) && cJSON_GetArraySize(item) == count;
    const cJSON *number = count == 1 ? item : item->child;
    for (int i = 0; i < count && sound; ++i, number = number->next) {
        sound = cJSON_IsNumber(number);
        values[i] = number->valuedouble;
    }
    return sound ? SVO_OK
                 : svo_i_fail(file->reader->message, SVO_IMPORT_FAILED, "%s is not %d number%s", name, count,
                              count == 1 ? "" : "s");
}

/* A property that is a whole number up to most; *value stays where there is none. */
static svo_status get_whole(const gltf_file *file, const cJSON *owner, const char *name, double most, uint64_t *value)
{
    double number = (double)*value;
    SVO_I_TRY(svo_i_gltf_numbers(file, owner, name, &number, 1));
    if (!(number >= 0 && number <= most) || number != floor(number)) {
        return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED, "%s %g is no whole number from 0 to %.0f", name,
                          number, most);
    }
    *value = (uint64_t)number;
    return SVO_OK;
}

static svo_status list_table(gltf_file *file, gltf_kind kind)
{
    const cJSON *array = svo_i_gltf_get(file->root, table_names[kind]);
    gltf_table *table = &file->tables[kind];
    const cJSON *item = NULL;
    if (array != NULL && !cJSON_IsArray(array)) {
        return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED, "%s is no array", table_names[kind]);
    }
    table->items = malloc(((size_t)cJSON_GetArraySize(array) + 1) * sizeof *table->items);
    if (table->items == NULL) {
        return out_of_memory(file);
    }
    cJSON_ArrayForEach(item, array)
    {
        table->items[table->count++] = item;
    }
    return SVO_OK;
}

/* ---- container ---- */

static uint32_t word_at(const char *bytes)
{
    uint32_t word = 0;
    memcpy(&word, bytes, sizeof word);
    return word;
}

/* Finds the JSON of a binary file and its binary chunk. */
static svo_status open_chunks(gltf_file *file, gltf_bytes *json)
{
    const mesh_reader *reader = file->reader;
    const size_t byte_count = reader->byte_count;
    uint64_t at = 12;
    *json = (gltf_bytes){.bytes = NULL};
    while (at + 8 <= byte_count) {
        const uint64_t length = word_at(reader->bytes + at);
        const uint32_t kind = word_at(reader->bytes + at + 4);
        if (length > byte_count - at - 8) {
            return svo_i_fail(reader->message, SVO_IMPORT_FAILED,
                              "byte %" PRIu64 ": a chunk of %" PRIu64 " bytes in a file of %zu bytes", at, length,
                              byte_count);
        }
        const gltf_bytes chunk = {.bytes = (const uint8_t *)reader->bytes + at + 8, .byte_count = length};
        if (kind == CHUNK_JSON && json->bytes == NULL) {
            *json = chunk;
        } else if (kind == CHUNK_BINARY && file->chunk.bytes == NULL) {
            file->chunk = chunk;
        }
        at += 8 + length;
    }
    return json->bytes != NULL ? SVO_OK : svo_i_fail(reader->message, SVO_IMPORT_FAILED, "no chunk of JSON");
}

static svo_status parse(gltf_file *file, const gltf_bytes *json)
{
    const char *text = (const char *)json->bytes;
    const char *end = text;
    file->root = cJSON_ParseWithLengthOpts(text, (size_t)json->byte_count, &end, 0);
    if (!cJSON_IsObject(file->root)) {
        return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED,
                          "byte %zu of its JSON: not understood, or no memory for it",
                          end != NULL ? (size_t)(end - text) : (size_t)0);
    }
    return SVO_OK;
}

static svo_status check_version(const gltf_file *file, bool *is_older)
{
    const cJSON *version = svo_i_gltf_get(svo_i_gltf_get(file->root, "asset"), "version");
    const char *text = cJSON_IsString(version) ? version->valuestring : "none";
    *is_older = strncmp(text, "1.", 2) == 0 || strncmp(text, "0.", 2) == 0;
    return strncmp(text, "2.", 2) == 0
               ? SVO_OK
               : svo_i_fail(file->reader->message, SVO_IMPORT_FAILED, "glTF of version %.40s; 2.0 is read", text);
}

svo_status svo_i_gltf_open(const mesh_reader *reader, gltf_file *file, bool *is_older)
{
    *file = (gltf_file){.reader = reader};
    *is_older = false;
    gltf_bytes json = {.bytes = (const uint8_t *)reader->bytes, .byte_count = reader->byte_count};
    if (reader->byte_count >= 12 && memcmp(reader->bytes, "glTF", 4) == 0) {
        *is_older = word_at(reader->bytes + 4) == 1;
        if (*is_older) {
            return svo_i_fail(reader->message, SVO_IMPORT_FAILED, "glTF of version 1; 2.0 is read");
        }
        SVO_I_TRY(open_chunks(file, &json));
    }
    SVO_I_TRY(parse(file, &json));
    SVO_I_TRY(check_version(file, is_older));
    for (gltf_kind kind = 0; kind < GLTF_KIND_COUNT; ++kind) {
        SVO_I_TRY(list_table(file, kind));
    }
    file->buffers = calloc((size_t)file->tables[GLTF_BUFFER].count + 1, sizeof *file->buffers);
    return file->buffers != NULL ? SVO_OK : out_of_memory(file);
}

void svo_i_gltf_close(gltf_file *file)
{
    for (uint32_t i = 0; file->buffers != NULL && i < file->tables[GLTF_BUFFER].count; ++i) {
        svo_i_file_close(&file->buffers[i].file);
        free(file->buffers[i].owned);
    }
    free(file->buffers);
    for (gltf_kind kind = 0; kind < GLTF_KIND_COUNT; ++kind) {
        free(file->tables[kind].items);
    }
    cJSON_Delete(file->root);
}

/* ---- URIs ---- */

static int digit_of(char c)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *found = c != '\0' ? strchr(digits, c) : NULL;
    return found != NULL ? (int)(found - digits) : c == '-' ? 62 : c == '_' ? 63 : -1;
}

/* The bytes of base64 text (RFC 4648); NULL: no memory. */
static uint8_t *decode_base64(const char *text, uint64_t *byte_count)
{
    uint8_t *bytes = malloc(strlen(text) / 4 * 3 + 3);
    uint32_t group = 0;
    unsigned bits = 0;
    *byte_count = 0;
    for (; bytes != NULL && *text != '\0'; ++text) {
        const int digit = digit_of(*text);
        if (digit < 0) {
            continue; /* padding */
        }
        group = group << 6 | (uint32_t)digit;
        bits += 6;
        if (bits >= 8) {
            bits -= 8;
            bytes[(*byte_count)++] = (uint8_t)(group >> bits);
        }
    }
    return bytes;
}

static int hex_of(char c)
{
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
}

/* A path without its percent-encoded bytes; NULL: no memory. */
static char *decode_path(const char *uri)
{
    char *path = malloc(strlen(uri) + 1);
    char *to = path;
    for (; path != NULL && *uri != '\0'; ++uri) {
        const bool coded = uri[0] == '%' && hex_of(uri[1]) >= 0 && hex_of(uri[2]) >= 0;
        const int byte = coded ? hex_of(uri[1]) * 16 + hex_of(uri[2]) : uri[0];
        *to++ = (char)byte;
        uri += coded ? 2 : 0;
    }
    if (path != NULL) {
        *to = '\0';
    }
    return path;
}

svo_status svo_i_gltf_uri(const gltf_file *file, const char *uri, uint8_t **data, uint64_t *byte_count, char **path)
{
    static const char mark[] = ";base64,";
    *data = NULL;
    *path = NULL;
    if (strncmp(uri, "data:", 5) != 0) {
        *path = decode_path(uri);
        return *path != NULL ? SVO_OK : out_of_memory(file);
    }
    const char *text = strstr(uri, mark);
    if (text == NULL) {
        return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED, "a data URI that is not base64");
    }
    *data = decode_base64(text + strlen(mark), byte_count);
    return *data != NULL ? SVO_OK : out_of_memory(file);
}

/* ---- buffers ---- */

static svo_status open_file(gltf_file *file, const char *path, gltf_buffer *buffer)
{
    if (file->reader->path == NULL) {
        return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED, "%s is another file", path);
    }
    const char *trouble = svo_i_file_open_beside(file->reader->path, path, &buffer->file);
    if (trouble != NULL) {
        return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED, "buffer %s cannot be read: %s", path, trouble);
    }
    svo_i_stream_work(file->reader->stream, file->reader->work, (stream_work){buffer->file.byte_count, 0});
    if (svo_i_file_tell_beside(file->reader->stream, file->reader->path, path) != 0) {
        return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED, "buffer %s: out of memory", path);
    }
    buffer->content = (gltf_bytes){(const uint8_t *)buffer->file.bytes, buffer->file.byte_count};
    return SVO_OK;
}

static svo_status open_buffer(gltf_file *file, uint32_t index)
{
    gltf_buffer *buffer = &file->buffers[index];
    const cJSON *uri = svo_i_gltf_get(file->tables[GLTF_BUFFER].items[index], "uri");
    if (cJSON_IsString(uri)) {
        char *path = NULL;
        uint64_t byte_count = 0;
        SVO_I_TRY(svo_i_gltf_uri(file, uri->valuestring, &buffer->owned, &byte_count, &path));
        buffer->content = (gltf_bytes){buffer->owned, byte_count};
        const svo_status status = path != NULL ? open_file(file, path, buffer) : SVO_OK;
        free(path);
        return status;
    }
    if (index > 0 || file->chunk.bytes == NULL) {
        return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED, "buffer %" PRIu32 " has no bytes", index);
    }
    buffer->content = file->chunk;
    return SVO_OK;
}

svo_status svo_i_gltf_view(gltf_file *file, uint32_t index, gltf_bytes *view)
{
    const cJSON *item = file->tables[GLTF_BUFFER_VIEW].items[index];
    uint32_t buffer = 0;
    uint64_t offset = 0;
    uint64_t byte_count = 0;
    SVO_I_TRY(svo_i_gltf_index(file, item, "buffer", GLTF_BUFFER, &buffer));
    SVO_I_TRY(get_whole(file, item, "byteOffset", WHOLE_MAX, &offset));
    SVO_I_TRY(get_whole(file, item, "byteLength", WHOLE_MAX, &byte_count));
    if (buffer == GLTF_NONE) {
        return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED, "bufferView %" PRIu32 " has no buffer", index);
    }
    if (file->buffers[buffer].content.bytes == NULL) {
        SVO_I_TRY(open_buffer(file, buffer));
    }
    const gltf_bytes *whole = &file->buffers[buffer].content;
    if (offset > whole->byte_count || byte_count > whole->byte_count - offset) {
        return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED,
                          "bufferView %" PRIu32 ": %" PRIu64 " bytes from %" PRIu64 " on are beyond the %" PRIu64
                          " of buffer %" PRIu32,
                          index, byte_count, offset, whole->byte_count, buffer);
    }
    *view = (gltf_bytes){.bytes = whole->bytes + offset, .byte_count = byte_count};
    return SVO_OK;
}

/* ---- accessors ---- */

/* Bytes of a component; 0: no type of glTF. */
static size_t component_bytes(uint32_t component)
{
    static const size_t bytes[] = {1, 1, 2, 2, 0, 4, 4};
    return component >= 5120 && component <= 5126 ? bytes[component - 5120] : 0;
}

/* A range of an array within a view. */
static svo_status find_range(gltf_file *file, const cJSON *item, uint32_t index, const gltf_accessor *accessor,
                             const uint8_t **bytes)
{
    uint32_t view_index = GLTF_NONE;
    uint64_t offset = 0;
    gltf_bytes view;
    SVO_I_TRY(svo_i_gltf_index(file, item, "bufferView", GLTF_BUFFER_VIEW, &view_index));
    SVO_I_TRY(get_whole(file, item, "byteOffset", WHOLE_MAX, &offset));
    if (view_index == GLTF_NONE) {
        return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED, "accessor %" PRIu32 " has no bufferView", index);
    }
    SVO_I_TRY(svo_i_gltf_view(file, view_index, &view));
    const uint64_t element_bytes = accessor->width * component_bytes(accessor->component);
    const uint64_t byte_count =
        accessor->count > 0 ? (accessor->count - 1) * (uint64_t)accessor->stride + element_bytes : 0;
    if (offset > view.byte_count || byte_count > view.byte_count - offset) {
        return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED,
                          "accessor %" PRIu32 ": %" PRIu64 " bytes from %" PRIu64 " on are beyond the %" PRIu64
                          " of bufferView %" PRIu32,
                          index, byte_count, offset, view.byte_count, view_index);
    }
    *bytes = view.bytes + offset;
    return SVO_OK;
}

/* Gives an accessor memory of its own, packed: its elements, or zeros where it has no view. */
static svo_status own_elements(const gltf_file *file, uint32_t index, gltf_accessor *accessor)
{
    const size_t element_bytes = accessor->width * component_bytes(accessor->component);
    if (accessor->count > SPARSE_MAX / element_bytes) {
        return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED,
                          "accessor %" PRIu32 ": %" PRIu32 " sparse elements take more than 2^30 bytes", index,
                          accessor->count);
    }
    accessor->owned = calloc((size_t)accessor->count + 1, element_bytes);
    if (accessor->owned == NULL) {
        return out_of_memory(file);
    }
    for (uint32_t i = 0; accessor->bytes != NULL && i < accessor->count; ++i) {
        memcpy(accessor->owned + i * element_bytes, accessor->bytes + i * accessor->stride, element_bytes);
    }
    accessor->bytes = accessor->owned;
    accessor->stride = element_bytes;
    return SVO_OK;
}

/* Replaces elements by sparse values. */
static svo_status apply_sparse(gltf_file *file, const cJSON *sparse, uint32_t index, gltf_accessor *accessor)
{
    const size_t element_bytes = accessor->width * component_bytes(accessor->component);
    gltf_accessor values = *accessor;
    gltf_accessor places = {.width = 1};
    uint64_t count = 0;
    uint64_t component = 0;
    const cJSON *indices = svo_i_gltf_get(sparse, "indices");
    SVO_I_TRY(get_whole(file, sparse, "count", accessor->count, &count));
    SVO_I_TRY(get_whole(file, indices, "componentType", 5125, &component));
    if (component != 5121 && component != 5123 && component != 5125) {
        return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED,
                          "accessor %" PRIu32 ": sparse indices of componentType %" PRIu64, index, component);
    }
    values.count = places.count = (uint32_t)count;
    values.stride = element_bytes;
    places.component = (uint32_t)component;
    places.stride = component_bytes(places.component);
    SVO_I_TRY(find_range(file, indices, index, &places, &places.bytes));
    SVO_I_TRY(find_range(file, svo_i_gltf_get(sparse, "values"), index, &values, &values.bytes));
    SVO_I_TRY(own_elements(file, index, accessor));
    for (uint32_t i = 0; i < places.count; ++i) {
        const uint32_t place = svo_i_gltf_vertex(&places, i);
        if (place >= accessor->count) {
            return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED,
                              "accessor %" PRIu32 ": sparse index %" PRIu32 " is not below %" PRIu32, index, place,
                              accessor->count);
        }
        memcpy(accessor->owned + place * element_bytes, values.bytes + i * element_bytes, element_bytes);
    }
    return SVO_OK;
}

/* What the accessor says of its elements. */
static svo_status read_shape(const gltf_file *file, const cJSON *item, uint32_t index, gltf_accessor *accessor)
{
    static const char *const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    const cJSON *type = svo_i_gltf_get(item, "type");
    uint64_t component = 0;
    uint64_t count = 0;
    SVO_I_TRY(get_whole(file, item, "componentType", 5126, &component));
    SVO_I_TRY(get_whole(file, item, "count", GATHER_NO_VERTEX - 1, &count));
    for (uint32_t i = 0; i < 4; ++i) {
        accessor->width = cJSON_IsString(type) && strcmp(type->valuestring, types[i]) == 0 ? i + 1 : accessor->width;
    }
    if (accessor->width == 0 || component_bytes((uint32_t)component) == 0) {
        return svo_i_fail(file->reader->message, SVO_IMPORT_FAILED,
                          "accessor %" PRIu32 ": componentType %" PRIu64 " and type %.20s are not read", index,
                          component, cJSON_IsString(type) ? type->valuestring : "none");
    }
    accessor->component = (uint32_t)component;
    accessor->count = (uint32_t)count;
    accessor->normalized = cJSON_IsTrue(svo_i_gltf_get(item, "normalized"));
    return SVO_OK;
}

static svo_status read_stride(const gltf_file *file, uint32_t view, uint32_t index, gltf_accessor *accessor)
{
    const size_t element_bytes = accessor->width * component_bytes(accessor->component);
    uint64_t stride = element_bytes;
    if (view != GLTF_NONE) {
        SVO_I_TRY(get_whole(file, file->tables[GLTF_BUFFER_VIEW].items[view], "byteStride", STRIDE_MAX, &stride));
    }
    accessor->stride = (size_t)stride;
    return stride >= element_bytes
               ? SVO_OK
               : svo_i_fail(file->reader->message, SVO_IMPORT_FAILED,
                            "accessor %" PRIu32 ": byteStride %" PRIu64 " is below the %zu bytes of an element", index,
                            stride, element_bytes);
}

static svo_status open_accessor(gltf_file *file, uint32_t index, gltf_accessor *accessor)
{
    const cJSON *item = file->tables[GLTF_ACCESSOR].items[index];
    const cJSON *sparse = svo_i_gltf_get(item, "sparse");
    uint32_t view = GLTF_NONE;
    SVO_I_TRY(read_shape(file, item, index, accessor));
    SVO_I_TRY(svo_i_gltf_index(file, item, "bufferView", GLTF_BUFFER_VIEW, &view));
    if (view != GLTF_NONE || sparse == NULL) { /* without both, its values are compressed */
        SVO_I_TRY(read_stride(file, view, index, accessor));
        SVO_I_TRY(find_range(file, item, index, accessor, &accessor->bytes));
    }
    return sparse != NULL ? apply_sparse(file, sparse, index, accessor) : SVO_OK;
}

svo_status svo_i_gltf_accessor(gltf_file *file, uint32_t index, gltf_accessor *accessor)
{
    *accessor = (gltf_accessor){.bytes = NULL};
    const svo_status status = open_accessor(file, index, accessor);
    if (status != SVO_OK) {
        svo_i_gltf_accessor_free(accessor);
    }
    return status;
}

void svo_i_gltf_accessor_free(gltf_accessor *accessor)
{
    free(accessor->owned);
    *accessor = (gltf_accessor){.bytes = NULL};
}

/* Normalized integers as the specification has them (3.6.2.2). */
static double signed_share(int32_t value, double largest, bool normalized)
{
    const double share = value / largest;
    return !normalized ? value : share < -1 ? -1 : share;
}

double svo_i_gltf_component(const gltf_accessor *accessor, uint32_t element, uint32_t component)
{
    const uint8_t *at = accessor->bytes + element * accessor->stride + component * component_bytes(accessor->component);
    const bool normalized = accessor->normalized;
    int16_t narrow = 0;
    uint16_t wide = 0;
    uint32_t word = 0;
    float number = 0;
    switch (accessor->component) {
    case 5120:
        return signed_share((int8_t)*at, 127, normalized);
    case 5121:
        return normalized ? *at / 255.0 : *at;
    case 5122:
        memcpy(&narrow, at, sizeof narrow);
        return signed_share(narrow, 32767, normalized);
    case 5123:
        memcpy(&wide, at, sizeof wide);
        return normalized ? wide / 65535.0 : wide;
    case 5125:
        memcpy(&word, at, sizeof word);
        return normalized ? word / 4294967295.0 : word;
    default:
        memcpy(&number, at, sizeof number);
        return number;
    }
}

uint32_t svo_i_gltf_vertex(const gltf_accessor *accessor, uint32_t element)
{
    const uint8_t *at = accessor->bytes + element * accessor->stride;
    uint16_t wide = 0;
    uint32_t word = 0;
    switch (accessor->component) {
    case 5121:
        return *at;
    case 5123:
        memcpy(&wide, at, sizeof wide);
        return wide;
    default:
        memcpy(&word, at, sizeof word);
        return word;
    }
}
