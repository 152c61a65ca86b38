/* SPDX-License-Identifier: MIT */
/*
 * Lights to files and back: what io/file_chunks.c does not know of them. io.h has the format. A file is bound to its
 * tree by the tree's hash, since places and arrays mean nothing for another one.
 */
#include <inttypes.h>
#include <string.h>

#include "core/message.h"
#include "core/struct_size.h"
#include "io/file_format.h"
#include "light/record.h"

#define FILE_LIGHT_MAGIC    "\x89SVL\r\n\x1a\n"
#define FILE_LIGHT_VERSION  1
#define FILE_LIGHT_WITH_SKY 2 /* the version of files with a map of the sky */
#define FILE_LIGHT_PHOTONS  3 /* of files that say how photons go on */

/* Chunks besides the buffers, which have their own values. */
#define KIND_RECORD   64u
#define KIND_SOURCES  65u
#define KIND_FINISHES 66u
#define KIND_SKY      67u /* width, height, texels */
#define KIND_PHOTONS  68u
#define CHUNKS_MAX    (5u + SVO_LIGHT_BUFFER_COUNT)

/* That chunk. */
typedef struct sky_chunk {
    uint32_t width, height;
    float texels[]; /* of three values each */
} sky_chunk;

#define SKY_HEAD_BYTES    sizeof(sky_chunk)
#define SKY_TEXEL_BYTES   (3 * sizeof(float))
#define SKY_MAP_BYTES_MAX ((uint64_t)SVO_SKY_WIDTH_MAX * SVO_SKY_HEIGHT_MAX * SKY_TEXEL_BYTES)

static_assert(sizeof(svo_i_light_record) == 168, "io.h: light");
static_assert(offsetof(svo_i_light_record, source_count) == 80, "io.h: source_count");
static_assert(sizeof(svo_i_photon_record) == 16, "io.h: photons");
static_assert(offsetof(svo_i_light_record, flux) == 136, "io.h: flux");

/* What failed on the device, in the caller's message. */
static svo_status told(svo_status status, const svo_tree *tree, svo_message *message)
{
    if (status != SVO_OK) {
        return svo_i_fail(message, status, "%s", svo_device_message(tree->device));
    }
    return SVO_OK;
}

/* The tree's hash, which needs its host arrays. */
static svo_status hash_tree(const svo_tree *tree, const char *function, svo_message *message, char hash[32])
{
    char text[SVO_HASH_TEXT_BYTES];
    if (!tree->downloaded) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                          "%s: the tree has no host arrays; call svo_tree_download first", function);
    }
    SVO_I_TRY(told(svo_tree_hash(tree, SVO_HASH_ALL, text), tree, message));
    memcpy(hash, text, 32);
    return SVO_OK;
}

/* Arrays that are read from the device or from a file. */
static void free_arrays(void *arrays[SVO_LIGHT_BUFFER_COUNT])
{
    for (int i = 0; i < SVO_LIGHT_BUFFER_COUNT; ++i) {
        svo_i_free(arrays[i]);
        arrays[i] = NULL;
    }
}

/* ---- saving ---- */

static void add_array(svo_i_file_save *state, uint32_t kind, const char *name, const void *plain, uint64_t bytes)
{
    if (bytes > 0) {
        state->arrays[state->array_count++] = (svo_i_file_array){kind, name, plain, bytes};
    }
}

/* Reads the map of the sky, if there is one, into new memory and lists it. */
static svo_status add_sky(svo_i_file_save *state, const svo_light *light, const svo_i_stored_light *stored,
                          const char *function, cl_command_queue queue, sky_chunk **map, svo_message *message)
{
    const uint64_t bytes = SKY_HEAD_BYTES + svo_i_light_sky_bytes(light);
    if (bytes == SKY_HEAD_BYTES) {
        return SVO_OK;
    }
    *map = svo_i_alloc(&light->device->memory, (size_t)bytes);
    if (*map == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: sky_map needs %" PRIu64 " bytes", function, bytes);
    }
    (*map)->width = stored->sky_width;
    (*map)->height = stored->sky_height;
    SVO_I_TRY(told(svo_i_light_read_sky(light, function, queue, (*map)->texels), light->tree, message));
    state->head.header.version = FILE_LIGHT_WITH_SKY;
    add_array(state, KIND_SKY, "sky_map", *map, bytes);
    return SVO_OK;
}

/* Lists how photons go on, if they do. */
static void add_photons(svo_i_file_save *state, const svo_i_photon_record *photons)
{
    if (photons->emission_photons != 0 || photons->bounces != 0 || photons->photon_alpha != 0) {
        state->head.header.version = FILE_LIGHT_PHOTONS;
        add_array(state, KIND_PHOTONS, "photons", photons, sizeof *photons);
    }
}

/* Reads the light's buffers into new memory and lists them. */
static svo_status add_buffers(svo_i_file_save *state, const svo_light *light, const char *function,
                              cl_command_queue queue, void *arrays[SVO_LIGHT_BUFFER_COUNT], svo_message *message)
{
    for (svo_light_buffer i = 0; i < SVO_LIGHT_BUFFER_COUNT; ++i) {
        const char *name = svo_name(SVO_NAME_LIGHT_BUFFER, i);
        const uint64_t bytes = light->info.bytes[i];
        if (bytes == 0) {
            continue;
        }
        arrays[i] = svo_i_alloc(&light->device->memory, (size_t)bytes);
        if (arrays[i] == NULL) {
            return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: %s needs %" PRIu64 " bytes", function, name, bytes);
        }
        SVO_I_TRY(told(svo_i_light_read_array(light, function, queue, i, arrays[i]), light->tree, message));
        add_array(state, (uint32_t)i, name, arrays[i], bytes);
    }
    return SVO_OK;
}

static void fill_header(const svo_tree *tree, file_header *header)
{
    svo_i_file_fill_header(header, &tree->info);
    memcpy(header->magic, FILE_LIGHT_MAGIC, FILE_MAGIC_BYTES);
    header->version = FILE_LIGHT_VERSION;
}

svo_status svo_light_save(const svo_light *light, svo_sink sink, const svo_save_options *options,
                          cl_command_queue queue, svo_message *message)
{
    static const char function[] = "svo_light_save";
    void *arrays[SVO_LIGHT_BUFFER_COUNT] = {NULL};
    sky_chunk *sky = NULL;
    svo_i_stored_light stored;
    svo_save_options asked;
    svo_status status = SVO_OK;
    if (light == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: light is NULL", function);
    }
    SVO_I_TRY(svo_i_struct_read(message, function, "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_save_options, struct_size)));
    if (light->options.no_cones != 0) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: the light was made with no_cones: it stores nothing",
                          function);
    }
    svo_i_file_save state = {.memory = &light->device->memory, .compress = asked.compress != 0};
    svo_i_light_describe(light, &stored);
    SVO_I_TRY(hash_tree(light->tree, function, message, stored.record.tree_hash));
    fill_header(light->tree, &state.head.header);
    add_array(&state, KIND_RECORD, "light", &stored.record, sizeof stored.record);
    add_array(&state, KIND_SOURCES, "sources", stored.sources, stored.record.source_count * sizeof *stored.sources);
    add_array(&state, KIND_FINISHES, "finishes", stored.finishes, stored.record.finish_count * sizeof *stored.finishes);
    SVO_I_TRY_CLEANUP(add_sky(&state, light, &stored, function, queue, &sky, message));
    add_photons(&state, &stored.photons);
    SVO_I_TRY_CLEANUP(add_buffers(&state, light, function, queue, arrays, message));
    SVO_I_TRY_CLEANUP(svo_i_file_write(&state, function, sink, message));

cleanup:
    svo_i_free(sky);
    free_arrays(arrays);
    return status;
}

/* ---- loading ---- */

/* Where reading is in the file. */
typedef struct position {
    uint32_t chunk_index;
    uint64_t offset;
} position;

/* Reads the next chunk, of this kind and length, into new memory; of length 0 there is none. */
static svo_status load_chunk(const svo_i_file_load *state, position *at, uint32_t kind, const char *name,
                             uint64_t bytes, void **out)
{
    const file_chunk *chunk = &state->head.chunks[at->chunk_index];
    if (bytes == 0) {
        return SVO_OK;
    }
    if (at->chunk_index == state->head.header.chunk_count || chunk->kind != kind) {
        return svo_i_file_damaged(state, "chunk %s is missing", name);
    }
    SVO_I_TRY(svo_i_file_check_place(state, chunk, name, at->offset));
    if (chunk->plain_bytes != bytes) {
        return svo_i_file_damaged(state, "chunk %s: %" PRIu64 " bytes, %" PRIu64 " expected", name, chunk->plain_bytes,
                                  bytes);
    }
    *out = bytes <= SIZE_MAX ? svo_i_alloc(&state->host_memory, (size_t)bytes) : NULL;
    if (*out == NULL) {
        return svo_i_file_no_memory(state, name, bytes);
    }
    at->offset += chunk->stored_bytes;
    at->chunk_index += 1;
    return svo_i_file_read_chunk(state, chunk, name, *out);
}

static svo_status load_record(const svo_i_file_load *state, position *at, svo_i_light_record *record)
{
    svo_status status = SVO_OK;
    void *plain = NULL;
    SVO_I_TRY_CLEANUP(load_chunk(state, at, KIND_RECORD, "light", sizeof *record, &plain));
    memcpy(record, plain, sizeof *record);

cleanup:
    svo_i_free(plain);
    return status;
}

/* Whether the light is that of the tree. */
static svo_status check_tree(const svo_i_file_load *state, const svo_tree *tree, const svo_i_light_record *record)
{
    char hash[32] = {0};
    SVO_I_TRY(hash_tree(tree, "svo_light_load", state->source.message, hash));
    return memcmp(hash, record->tree_hash, sizeof hash) == 0
               ? SVO_OK
               : svo_i_fail(state->source.message, SVO_INVALID_ARGUMENT,
                            "%s: the light is of a tree of hash %.32s, not of this one of hash %.32s",
                            state->source.name, record->tree_hash, hash);
}

/* Lists and arrays, in new memory. */
typedef struct loaded {
    void *sources, *finishes;
    sky_chunk *sky; /* NULL: none */
    svo_i_photon_record photons;
    void *arrays[SVO_LIGHT_BUFFER_COUNT];
} loaded;

/* Reads the map of the sky, if a chunk of it is next. */
static svo_status load_sky(const svo_i_file_load *state, position *at, const svo_i_light_record *record, loaded *got)
{
    const file_chunk *chunk = &state->head.chunks[at->chunk_index];
    void *plain = NULL;
    if (at->chunk_index == state->head.header.chunk_count || chunk->kind != KIND_SKY) {
        return SVO_OK;
    }
    if (chunk->plain_bytes <= SKY_HEAD_BYTES || chunk->plain_bytes > SKY_HEAD_BYTES + SKY_MAP_BYTES_MAX) {
        return svo_i_file_damaged(state, "chunk sky_map: %" PRIu64 " bytes are no map", chunk->plain_bytes);
    }
    SVO_I_TRY(svo_i_file_limit(state, 0, chunk->plain_bytes));
    const svo_status status = load_chunk(state, at, KIND_SKY, "sky_map", chunk->plain_bytes, &plain);
    got->sky = plain;
    SVO_I_TRY(status);
    const uint64_t texels = (uint64_t)got->sky->width * got->sky->height;
    return record->has_setup != 0 && texels <= SKY_MAP_BYTES_MAX / SKY_TEXEL_BYTES &&
                   chunk->plain_bytes == SKY_HEAD_BYTES + texels * SKY_TEXEL_BYTES
               ? SVO_OK
               : svo_i_file_damaged(state, "chunk sky_map: %" PRIu64 " bytes are no map of %" PRIu32 " x %" PRIu32,
                                    chunk->plain_bytes, got->sky->width, got->sky->height);
}

/* Reads how photons go on, if that chunk is next. */
static svo_status load_photons(const svo_i_file_load *state, position *at, const svo_i_light_record *record,
                               svo_i_photon_record *photons)
{
    const file_chunk *chunk = &state->head.chunks[at->chunk_index];
    svo_status status = SVO_OK;
    void *plain = NULL;
    if (at->chunk_index == state->head.header.chunk_count || chunk->kind != KIND_PHOTONS) {
        return SVO_OK;
    }
    SVO_I_TRY_CLEANUP(load_chunk(state, at, KIND_PHOTONS, "photons", sizeof *photons, &plain));
    memcpy(photons, plain, sizeof *photons);
    if (record->has_setup == 0 || photons->photon_alpha > 1 || photons->reserved != 0) {
        status = svo_i_file_damaged(state, "chunk photons: %" PRIu32 ", %" PRIu32 " are not 0 or 1, 0",
                                    photons->photon_alpha, photons->reserved);
    }

cleanup:
    svo_i_free(plain);
    return status;
}

static svo_status load_arrays(const svo_i_file_load *state, position *at, const svo_tree *tree,
                              const svo_i_light_record *record, loaded *got)
{
    uint64_t bytes[SVO_LIGHT_BUFFER_COUNT] = {0};
    uint64_t all_bytes = 0;
    if (!svo_i_light_count_arrays(tree, record, bytes)) {
        return svo_i_file_damaged(state, "chunk light: its values do not fit the tree");
    }
    for (int i = 0; i < SVO_LIGHT_BUFFER_COUNT; ++i) {
        all_bytes += bytes[i];
    }
    SVO_I_TRY(svo_i_file_limit(state, tree->info.leaf_count, all_bytes));
    SVO_I_TRY(
        load_chunk(state, at, KIND_SOURCES, "sources", record->source_count * sizeof(svo_light_source), &got->sources));
    SVO_I_TRY(
        load_chunk(state, at, KIND_FINISHES, "finishes", record->finish_count * sizeof(svo_finish), &got->finishes));
    SVO_I_TRY(load_sky(state, at, record, got));
    SVO_I_TRY(load_photons(state, at, record, &got->photons));
    for (svo_light_buffer i = 0; i < SVO_LIGHT_BUFFER_COUNT; ++i) {
        SVO_I_TRY(load_chunk(state, at, (uint32_t)i, svo_name(SVO_NAME_LIGHT_BUFFER, i), bytes[i], &got->arrays[i]));
    }
    return svo_i_file_check_end(state, at->chunk_index, at->offset);
}

/* Makes the light of what was loaded. */
static svo_status restore(const svo_i_file_load *state, svo_tree *tree, svo_i_stored_light *stored, const loaded *got,
                          cl_command_queue queue, svo_light **out)
{
    stored->sources = got->sources;
    stored->finishes = got->finishes;
    stored->photons = got->photons;
    if (got->sky != NULL) {
        stored->sky_width = got->sky->width;
        stored->sky_height = got->sky->height;
        stored->sky_map = got->sky->texels;
    }
    for (int i = 0; i < SVO_LIGHT_BUFFER_COUNT; ++i) {
        stored->arrays[i] = got->arrays[i];
    }
    return told(svo_i_light_restore(tree, "svo_light_load", stored, queue, out), tree, state->source.message);
}

static svo_status load(svo_i_file_load *state, svo_tree *tree, cl_command_queue queue, svo_light **out)
{
    static const svo_i_file_kind kind = {"light's", FILE_LIGHT_MAGIC, FILE_LIGHT_VERSION, FILE_LIGHT_PHOTONS,
                                         CHUNKS_MAX};
    svo_i_stored_light stored = {.sources = NULL};
    loaded got = {.sources = NULL};
    svo_status status = SVO_OK;
    if (state->last_level != 0) {
        return svo_i_fail(state->source.message, SVO_INVALID_ARGUMENT,
                          "svo_light_load: options.last_level is %" PRIu32 "; lights are read whole",
                          state->last_level);
    }
    SVO_I_TRY(svo_i_file_read_head(state, &kind));
    position at = {.chunk_index = 0, .offset = state->head.header.header_bytes};
    SVO_I_TRY(load_record(state, &at, &stored.record));
    SVO_I_TRY(check_tree(state, tree, &stored.record));
    SVO_I_TRY_CLEANUP(load_arrays(state, &at, tree, &stored.record, &got));
    SVO_I_TRY_CLEANUP(restore(state, tree, &stored, &got, queue, out));

cleanup:
    svo_i_free(got.sources);
    svo_i_free(got.finishes);
    svo_i_free(got.sky);
    free_arrays(got.arrays);
    return status;
}

svo_status svo_light_load(svo_tree *tree, svo_source source, const svo_load_options *options, cl_command_queue queue,
                          svo_light **out, svo_message *message)
{
    static const char function[] = "svo_light_load";
    svo_i_file_load state = {.voxels_max = 0};
    if (tree == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function, tree == NULL ? "tree" : "out");
    }
    if (tree->device == NULL) {
        return svo_i_fail(message, SVO_NOT_ON_DEVICE, "%s: the tree is on no device; call svo_tree_upload first",
                          function);
    }
    SVO_I_TRY(svo_i_file_load_open(function, source, options, message, &state));
    const svo_status status = load(&state, tree, queue, out);
    svo_i_source_close(&state.source);
    return status;
}
