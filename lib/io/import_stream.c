/* SPDX-License-Identifier: MIT */
/* The answer of an import child: written frame by frame; parsed without trust in its bytes. */
#define _POSIX_C_SOURCE 200809L
#include "io/import_stream.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "core/message.h"

/* Child side */

int svo_i_stream_write(int stream, const void *bytes, size_t byte_count)
{
    const char *from = bytes;
    while (byte_count > 0) {
        const ssize_t written = write(stream, from, byte_count);
        if (written < 0 && errno == EINTR) {
            continue;
        }
        if (written <= 0) {
            return -1;
        }
        from += written;
        byte_count -= (size_t)written;
    }
    return 0;
}

int svo_i_stream_begin(int stream, stream_kind kind, uint64_t payload_bytes)
{
    const stream_frame frame = {.kind = kind, .payload_bytes = payload_bytes};
    return svo_i_stream_write(stream, &frame, sizeof frame);
}

static size_t padding_of(uint64_t payload_bytes)
{
    return (size_t)(-payload_bytes % STREAM_PAYLOAD_ALIGN);
}

int svo_i_stream_pad(int stream, uint64_t payload_bytes)
{
    static const uint8_t zeros[STREAM_PAYLOAD_ALIGN] = {0};
    return svo_i_stream_write(stream, zeros, padding_of(payload_bytes));
}

int svo_i_stream_frame(int stream, stream_kind kind, const void *payload, size_t payload_bytes)
{
    if (svo_i_stream_begin(stream, kind, payload_bytes) != 0 ||
        svo_i_stream_write(stream, payload, payload_bytes) != 0) {
        return -1;
    }
    return svo_i_stream_pad(stream, payload_bytes);
}

int svo_i_stream_file(int stream, const char *path)
{
    return svo_i_stream_frame(stream, STREAM_FILE, path, strlen(path) + 1);
}

int svo_i_stream_text(int stream, stream_kind kind, const char *format, ...)
{
    svo_message text;
    va_list arguments;
    va_start(arguments, format);
    svo_i_fail_v(&text, SVO_OK, format, arguments);
    va_end(arguments);
    return svo_i_stream_frame(stream, kind, text.text, strlen(text.text));
}

static uint64_t smaller(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

static uint64_t add(uint64_t a, uint64_t b)
{
    return a > UINT64_MAX - b ? UINT64_MAX : a + b;
}

static uint64_t times(uint64_t a, uint64_t factor, uint64_t most)
{
    return a > most / factor ? most : a * factor;
}

uint64_t svo_i_stream_memory(const stream_work *work)
{
    return times(work->read_bytes, STREAM_MEMORY_OF_FILES, UINT64_MAX / 4) +
           times(work->made_bytes, STREAM_MEMORY_OF_MADE, STREAM_MADE_BYTES_MAX);
}

void svo_i_stream_add(stream_work *sum, const stream_work *more)
{
    sum->read_bytes = add(sum->read_bytes, more->read_bytes);
    sum->made_bytes = add(sum->made_bytes, more->made_bytes);
}

void svo_i_stream_work(int stream, stream_work *done, stream_work more)
{
    struct rlimit processor;
    struct rlimit space;
    (void)svo_i_stream_frame(stream, STREAM_WORK, &more, sizeof more);
    if (getrlimit(RLIMIT_CPU, &processor) == 0 && processor.rlim_cur != RLIM_INFINITY) {
        processor.rlim_cur += add(more.read_bytes, more.made_bytes) / STREAM_BYTES_A_SECOND + 1;
        (void)setrlimit(RLIMIT_CPU, &processor); /* refused where the limit is for the file as a whole */
    }
    if (done != NULL && getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY) {
        const uint64_t before = svo_i_stream_memory(done);
        svo_i_stream_add(done, &more);
        space.rlim_cur = smaller(add(space.rlim_cur, svo_i_stream_memory(done) - before), space.rlim_max);
        (void)setrlimit(RLIMIT_AS, &space);
    }
}

/* Parent side */

typedef struct parse_state {
    svo_import *import;
    const char *path;
    bool strict;
    svo_log_callback log;
    void *log_user;
    svo_message *message;
    const uint8_t *payload[STREAM_KIND_COUNT]; /* the last frame of each kind, NULL: none */
    size_t payload_bytes[STREAM_KIND_COUNT];
    size_t texture_capacity;
} parse_state;

static svo_status malformed(const parse_state *state, const char *what)
{
    return svo_i_fail(state->message, SVO_IMPORT_FAILED, "%s: the reader's answer is damaged: %s", state->path, what);
}

/* The child's text on one line, without control characters that a terminal would obey. */
static void copy_text(svo_message *text, const uint8_t *payload, size_t payload_bytes)
{
    const size_t length = payload_bytes < sizeof text->text ? payload_bytes : sizeof text->text - 1;
    for (size_t i = 0; i < length; ++i) {
        text->text[i] = payload[i] < 0x20 || payload[i] == 0x7f ? ' ' : (char)payload[i];
    }
    text->text[length] = '\0';
}

static svo_status take_text(const parse_state *state, stream_kind kind, const uint8_t *payload, size_t payload_bytes)
{
    svo_message text;
    copy_text(&text, payload, payload_bytes);
    if (kind == STREAM_NO_MEMORY) {
        return svo_i_fail(state->message, SVO_OUT_OF_HOST_MEMORY, "%s: %s", state->path, text.text);
    }
    if (kind == STREAM_FAILURE || state->strict) {
        return svo_i_fail(state->message, SVO_IMPORT_FAILED, "%s: %s", state->path, text.text);
    }
    ++state->import->info.warnings;
    if (state->log != NULL) {
        svo_message line;
        (void)svo_i_fail(&line, SVO_OK, "%s: %s", state->path, text.text);
        state->log(state->log_user, SVO_LOG_WARNING, line.text);
    }
    return SVO_OK;
}

static bool texture_is_sound(const stream_texture *texture, size_t texel_bytes)
{
    return texture->width >= 1 && texture->width <= STREAM_TEXTURE_SIDE_MAX && texture->height >= 1 &&
           texture->height <= STREAM_TEXTURE_SIDE_MAX && texture->wrap_u <= SVO_WRAP_MIRROR &&
           texture->wrap_v <= SVO_WRAP_MIRROR && texel_bytes == (size_t)texture->width * texture->height * 4;
}

static svo_status take_texture(parse_state *state, const uint8_t *payload, size_t payload_bytes)
{
    stream_texture texture;
    if (payload_bytes < sizeof texture) {
        return malformed(state, "a texture without a size");
    }
    memcpy(&texture, payload, sizeof texture);
    if (!texture_is_sound(&texture, payload_bytes - sizeof texture)) {
        return malformed(state, "a texture of another length than its size says");
    }
    svo_import *import = state->import;
    if (import->mesh.texture_count == state->texture_capacity) {
        const size_t capacity = 2 * state->texture_capacity + 8;
        svo_texture *textures = svo_i_grow(&import->memory, import->textures, capacity * sizeof *textures);
        if (textures == NULL) {
            return svo_i_fail(state->message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu textures", state->path,
                              capacity);
        }
        import->textures = textures;
        state->texture_capacity = capacity;
    }
    import->textures[import->mesh.texture_count++] = (svo_texture){.rgba = payload + sizeof texture,
                                                                   .width = texture.width,
                                                                   .height = texture.height,
                                                                   .wrap_u = (svo_wrap)texture.wrap_u,
                                                                   .wrap_v = (svo_wrap)texture.wrap_v};
    return SVO_OK;
}

/* Readers may open a file more than once. */
static svo_status take_file(parse_state *state, const uint8_t *payload, size_t payload_bytes)
{
    svo_import *import = state->import;
    const char *path = (const char *)payload;
    if (payload_bytes == 0 || memchr(payload, '\0', payload_bytes) != payload + payload_bytes - 1) {
        return malformed(state, "a file without a path");
    }
    for (size_t i = 0; i < import->file_count; ++i) {
        if (strcmp(import->files[i], path) == 0) {
            return SVO_OK;
        }
    }
    if (import->file_count == import->file_capacity) {
        const size_t capacity = 2 * import->file_capacity + 8;
        const char **files = svo_i_grow(&import->memory, (void *)import->files, capacity * sizeof *files);
        if (files == NULL) {
            return svo_i_fail(state->message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu paths", state->path,
                              capacity);
        }
        import->files = files;
        import->file_capacity = capacity;
    }
    import->files[import->file_count++] = path;
    return SVO_OK;
}

static svo_status take_frame(parse_state *state, stream_kind kind, const uint8_t *payload, size_t payload_bytes)
{
    switch (kind) {
    case STREAM_WARNING:
    case STREAM_FAILURE:
    case STREAM_NO_MEMORY:
        return take_text(state, kind, payload, payload_bytes);
    case STREAM_TEXTURE:
        return take_texture(state, payload, payload_bytes);
    case STREAM_WORK:
        return SVO_OK; /* import.c has read it */
    case STREAM_FILE:
        return take_file(state, payload, payload_bytes);
    default:
        if (state->payload[kind] != NULL) {
            return malformed(state, "an array came twice");
        }
        state->payload[kind] = payload;
        state->payload_bytes[kind] = payload_bytes;
        return SVO_OK;
    }
}

static svo_status take_frames(parse_state *state)
{
    const uint8_t *bytes = state->import->bytes;
    const size_t byte_count = state->import->byte_count;
    size_t offset = STREAM_GREETING_BYTES;
    while (state->payload[STREAM_END] == NULL) {
        stream_frame frame;
        if (byte_count - offset < sizeof frame) {
            return malformed(state, "it ends too early");
        }
        memcpy(&frame, bytes + offset, sizeof frame);
        offset += sizeof frame;
        const size_t left_bytes = byte_count - offset;
        if (frame.kind >= STREAM_KIND_COUNT || frame.zero != 0) {
            return malformed(state, "an unknown frame");
        }
        if (frame.payload_bytes > left_bytes || padding_of(frame.payload_bytes) > left_bytes - frame.payload_bytes) {
            return malformed(state, "it ends too early");
        }
        const size_t payload_bytes = (size_t)frame.payload_bytes;
        SVO_I_TRY(take_frame(state, (stream_kind)frame.kind, bytes + offset, payload_bytes));
        offset += payload_bytes + padding_of(frame.payload_bytes);
    }
    return offset == byte_count ? SVO_OK : malformed(state, "something follows its end");
}

/* Whether an array, if present, has element_count elements. */
static bool length_fits(const parse_state *state, stream_kind kind, size_t element_count, size_t element_bytes)
{
    return state->payload[kind] == NULL || (state->payload_bytes[kind] % element_bytes == 0 &&
                                            state->payload_bytes[kind] / element_bytes == element_count);
}

static svo_status check_lengths(parse_state *state)
{
    svo_mesh *mesh = &state->import->mesh;
    const size_t vertex_bytes = 3 * sizeof(float);
    const size_t triangle_bytes = 3 * sizeof(uint32_t);
    mesh->vertex_count = state->payload_bytes[STREAM_POSITIONS] / vertex_bytes;
    mesh->triangle_count = state->payload_bytes[STREAM_INDICES] / triangle_bytes;
    mesh->material_count = state->payload_bytes[STREAM_MATERIALS] / sizeof(svo_material);
    if (state->payload[STREAM_POSITIONS] == NULL || mesh->triangle_count == 0) {
        return malformed(state, "no mesh");
    }
    if (mesh->vertex_count > UINT32_MAX || mesh->triangle_count > UINT32_MAX || mesh->material_count > UINT16_MAX) {
        return malformed(state, "too many vertices, triangles or materials");
    }
    if (!length_fits(state, STREAM_POSITIONS, mesh->vertex_count, vertex_bytes) ||
        !length_fits(state, STREAM_NORMALS, mesh->vertex_count, vertex_bytes) ||
        !length_fits(state, STREAM_COLORS, mesh->vertex_count, 4) ||
        !length_fits(state, STREAM_UVS, mesh->vertex_count, 2 * sizeof(float)) ||
        !length_fits(state, STREAM_INDICES, mesh->triangle_count, triangle_bytes) ||
        !length_fits(state, STREAM_TRIANGLE_MATERIALS, mesh->triangle_count, sizeof(uint16_t)) ||
        !length_fits(state, STREAM_MATERIALS, mesh->material_count, sizeof(svo_material)) ||
        !length_fits(state, STREAM_FINISHES, mesh->material_count, sizeof(svo_finish)) ||
        !length_fits(state, STREAM_NORMAL_MAPS, mesh->material_count, sizeof(svo_normal_map))) {
        return malformed(state, "the arrays do not fit each other");
    }
    return SVO_OK;
}

/* Which vertex of the mesh each vertex of the file is. */
static svo_status take_file_vertices(const parse_state *state)
{
    svo_import *import = state->import;
    const uint32_t *vertices = (const uint32_t *)(const void *)state->payload[STREAM_FILE_VERTICES];
    const size_t count = state->payload_bytes[STREAM_FILE_VERTICES] / sizeof *vertices;
    if (!length_fits(state, STREAM_FILE_VERTICES, count, sizeof *vertices)) {
        return malformed(state, "the vertices of the file are no whole numbers");
    }
    for (size_t i = 0; i < count; ++i) {
        if (vertices[i] != SVO_NO_VERTEX && vertices[i] >= import->mesh.vertex_count) {
            return malformed(state, "a vertex of the file is none of the mesh");
        }
    }
    import->file_vertices = vertices;
    import->file_vertex_count = count;
    return SVO_OK;
}

static svo_status take_counts(const parse_state *state)
{
    static const char *const readers[STREAM_READER_COUNT] = {"assimp", "obj", "ply", "stl", "off", "gltf"};
    stream_counts counts;
    if (state->payload[STREAM_COUNTS] == NULL || state->payload_bytes[STREAM_COUNTS] != sizeof counts) {
        return malformed(state, "no counts");
    }
    memcpy(&counts, state->payload[STREAM_COUNTS], sizeof counts);
    if (counts.reader >= STREAM_READER_COUNT) {
        return malformed(state, "an unknown reader");
    }
    svo_import_info *info = &state->import->info;
    info->struct_size = sizeof *info;
    info->reader = readers[counts.reader];
    info->declared_vertices = counts.declared_vertices;
    info->used_vertices = counts.used_vertices;
    info->declared_faces = counts.declared_faces;
    info->read_faces = counts.read_faces;
    info->triangles = state->import->mesh.triangle_count;
    return SVO_OK;
}

/* Whether a finish is one that svo_light_set_sources takes. */
static bool finish_is_sound(const svo_finish *finish)
{
    bool sound = isfinite(finish->exponent) && finish->exponent >= 0;
    for (int i = 0; i < 3; ++i) {
        sound = sound && isfinite(finish->emission[i]) && finish->emission[i] >= 0;
        sound = sound && finish->specular[i] >= 0 && finish->specular[i] <= 1;
    }
    return sound;
}

static bool texture_exists(const svo_mesh *mesh, uint32_t index)
{
    return index == SVO_NO_TEXTURE || index < mesh->texture_count;
}

static svo_status check_materials(const parse_state *state)
{
    const svo_mesh *mesh = &state->import->mesh;
    for (size_t i = 0; mesh->finishes != NULL && i < mesh->material_count; ++i) {
        if (!finish_is_sound(&mesh->finishes[i])) {
            return malformed(state, "a material's finish is out of range");
        }
    }
    for (size_t i = 0; i < mesh->material_count; ++i) {
        if (!texture_exists(mesh, mesh->materials[i].texture_index)) {
            return malformed(state, "a material's texture does not exist");
        }
    }
    for (size_t i = 0; mesh->normal_maps != NULL && i < mesh->material_count; ++i) {
        const svo_normal_map *map = &mesh->normal_maps[i];
        if (!texture_exists(mesh, map->texture_index) || !isfinite(map->scale)) {
            return malformed(state, "a material's normal map does not exist or has no scale");
        }
    }
    for (size_t i = 0; mesh->triangle_materials != NULL && i < mesh->triangle_count; ++i) {
        if (mesh->triangle_materials[i] >= mesh->material_count) {
            return malformed(state, "a triangle's material does not exist");
        }
    }
    return SVO_OK;
}

/* Payloads begin at multiples of 8 bytes in an allocation, so they are aligned as arrays. */
static void fill_mesh(const parse_state *state)
{
    svo_mesh *mesh = &state->import->mesh;
    mesh->struct_size = sizeof *mesh;
    mesh->positions = (const float *)(const void *)state->payload[STREAM_POSITIONS];
    mesh->normals = (const float *)(const void *)state->payload[STREAM_NORMALS];
    mesh->colors = state->payload[STREAM_COLORS];
    mesh->uvs = (const float *)(const void *)state->payload[STREAM_UVS];
    mesh->indices = (const uint32_t *)(const void *)state->payload[STREAM_INDICES];
    mesh->triangle_materials = (const uint16_t *)(const void *)state->payload[STREAM_TRIANGLE_MATERIALS];
    mesh->materials = (const svo_material *)(const void *)state->payload[STREAM_MATERIALS];
    mesh->textures = state->import->textures;
    mesh->finishes = (const svo_finish *)(const void *)state->payload[STREAM_FINISHES];
    mesh->normal_maps = (const svo_normal_map *)(const void *)state->payload[STREAM_NORMAL_MAPS];
}

svo_status svo_i_stream_parse(svo_import *import, const char *path, bool strict, svo_log_callback log, void *log_user,
                              svo_message *message)
{
    parse_state state = {
        .import = import, .path = path, .strict = strict, .log = log, .log_user = log_user, .message = message};
    if (import->byte_count < STREAM_GREETING_BYTES ||
        memcmp(import->bytes, STREAM_GREETING, STREAM_GREETING_BYTES) != 0) {
        return malformed(&state, "it is not from an import child of this version");
    }
    SVO_I_TRY(take_frames(&state));
    SVO_I_TRY(check_lengths(&state));
    SVO_I_TRY(take_counts(&state));
    SVO_I_TRY(take_file_vertices(&state));
    fill_mesh(&state);
    return check_materials(&state);
}
