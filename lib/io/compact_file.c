/* SPDX-License-Identifier: MIT */
/* Compact trees to files and back: what file_chunks.c does not know of them. io.h has the format. */
#include <inttypes.h>
#include <string.h>

#include "core/compact.h"
#include "core/message.h"
#include "core/packed.h"
#include "core/struct_size.h"
#include "io/file_format.h"

/* ---- saving ---- */

static void fill_header(const svo_compact_info *info, file_header *header)
{
    memcpy(header->magic, FILE_COMPACT_MAGIC, FILE_MAGIC_BYTES);
    header->version = info->packed != 0     ? FILE_COMPACT_PACKED
                      : info->is_exact != 0 ? FILE_COMPACT_EXACT
                                            : FILE_COMPACT_EXACT - 1;
    header->depth = info->depth;
    header->snap_bits = info->snap_bits;
    header->coverage = info->coverage;
    header->need = (uint16_t)info->need;
    header->constant = (uint16_t)info->constant;
    header->weights = (uint16_t)info->weights;
    header->payload_level = (uint16_t)info->payload_level;
    memcpy(header->origin, info->origin, sizeof header->origin);
    header->edge = info->edge;
    header->scale = info->scale;
    header->triangles = info->triangles;
    header->refused_triangles = info->refused_triangles;
    header->fragments = info->fragments;
    for (uint32_t level = 0; level <= info->depth; ++level) {
        header->level_begin[level + 1] = header->level_begin[level] + info->level_inner[level];
    }
}

static void fill_counts(const svo_compact_info *info, file_counts *counts)
{
    *counts =
        (file_counts){.form = info->form,
                      .minimized = info->minimized,
                      .directory_step_log2 = info->directory_step_log2,
                      .packed = info->packed | (info->packed != 0 && info->is_exact == 0 ? FILE_PACKED_ROUNDED : 0),
                      .stored_count = info->stored_count,
                      .far_count = info->far_count,
                      .shared_count = info->shared_count};
    memcpy(counts->level_leaf, info->level_leaf, sizeof counts->level_leaf);
}

svo_status svo_compact_save(const svo_compact *compact, svo_sink sink, const svo_save_options *options,
                            svo_message *message)
{
    static const char function[] = "svo_compact_save";
    svo_save_options asked;
    file_counts counts;
    if (compact == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: compact is NULL", function);
    }
    SVO_I_TRY(svo_i_struct_read(message, function, "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_save_options, struct_size)));
    if (!compact->downloaded) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                          "%s: there are no host arrays; call svo_compact_download first", function);
    }
    svo_i_file_save state = {.memory = &compact->memory, .compress = asked.compress != 0};
    fill_header(&compact->info, &state.head.header);
    fill_counts(&compact->info, &counts);
    state.arrays[state.array_count++] = (svo_i_file_array){FILE_COUNTS, "counts", &counts, sizeof counts};
    for (uint32_t i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        if (compact->info.bytes[i] > 0) {
            state.arrays[state.array_count++] = (svo_i_file_array){
                i, svo_name(SVO_NAME_COMPACT_BUFFER, (svo_compact_buffer)i), compact->host[i], compact->info.bytes[i]};
        }
    }
    return svo_i_file_write(&state, function, sink, message);
}

/* ---- loading ---- */

/* Reads a chunk whose place was checked into new memory. *out, in host_memory, is set as soon as there is memory, also
   on failure. */
static svo_status load_chunk(const svo_i_file_load *state, const file_chunk *chunk, const char *array, void **out)
{
    if (chunk->plain_bytes > 0 && chunk->plain_bytes <= SIZE_MAX) {
        *out = svo_i_alloc(&state->host_memory, (size_t)chunk->plain_bytes);
        if (*out == NULL) {
            return svo_i_file_no_memory(state, array, chunk->plain_bytes);
        }
    }
    return svo_i_file_read_chunk(state, chunk, array, *out);
}

static void fill_info(const file_header *header, const file_counts *counts, svo_compact_info *info)
{
    *info = (svo_compact_info){
        .struct_size = sizeof *info,
        .form = (svo_form)counts->form,
        .minimized = counts->minimized,
        .directory_step_log2 = counts->directory_step_log2,
        .depth = header->depth,
        .snap_bits = header->snap_bits,
        .coverage = header->coverage,
        .need = header->need,
        .constant = header->constant,
        .weights = header->weights,
        .payload_level = header->payload_level,
        .origin = {header->origin[0], header->origin[1], header->origin[2]},
        .edge = header->edge,
        .scale = header->scale,
        .triangles = header->triangles,
        .refused_triangles = header->refused_triangles,
        .fragments = header->fragments,
        .stored_count = counts->stored_count,
        .far_count = counts->far_count,
        .shared_count = counts->shared_count,
        .is_exact = header->version >= FILE_COMPACT_EXACT && (counts->packed & FILE_PACKED_ROUNDED) == 0 ? 1 : 0,
        .packed = counts->packed & ~FILE_PACKED_ROUNDED};
    for (uint32_t level = 0; level < header->depth; ++level) {
        info->level_inner[level] = header->level_begin[level + 1] - header->level_begin[level];
    }
    memcpy(info->level_leaf, counts->level_leaf, sizeof info->level_leaf);
}

/* Leaves and inner nodes of a level are children of the level above. */
static svo_status check_leaf_counts(const svo_i_file_load *state, const file_counts *counts)
{
    const file_header *header = &state->head.header;
    if (header->level_begin[header->depth + 1] != header->level_begin[header->depth]) {
        return svo_i_file_damaged(state, "header: there are inner nodes on level %" PRIu32, header->depth);
    }
    for (uint32_t level = 0; level < SVO_LEVELS_MAX; ++level) {
        const bool known = level > 0 && level <= header->depth;
        const uint64_t inner = known ? header->level_begin[level + 1] - header->level_begin[level] : 0;
        const uint64_t parents = known ? header->level_begin[level] - header->level_begin[level - 1] : 0;
        if (counts->level_leaf[level] + inner > 8 * parents) {
            return svo_i_file_damaged(state, "counts: level %" PRIu32 " has %" PRIu32 " leaves", level,
                                      counts->level_leaf[level]);
        }
    }
    return SVO_OK;
}

/* Packed payload is held, differs from node to node, and makes the version. */
static svo_status check_packed(const svo_i_file_load *state, const file_counts *counts)
{
    const file_header *header = &state->head.header;
    const uint32_t packed = counts->packed & ~FILE_PACKED_ROUNDED;
    const uint32_t possible = header->need & ~(uint32_t)header->constant & SVO_I_PAYLOAD_NEEDS;
    const bool fits = header->version >= FILE_COMPACT_PACKED ? packed != 0 : counts->packed == 0;
    return fits && (packed & ~possible) == 0
               ? SVO_OK
               : svo_i_file_damaged(state, "counts: packed 0x%" PRIx32 " does not fit the payload", counts->packed);
}

/* How many words there are is for the records to tell. */
static svo_status check_shared_counts(const svo_i_file_load *state, const file_counts *counts)
{
    return counts->far_count == 0 && counts->stored_count > 0 && counts->stored_count <= UINT32_MAX
               ? SVO_OK
               : svo_i_file_damaged(state, "counts: %" PRIu64 " words, %" PRIu64 " of them far", counts->stored_count,
                                    counts->far_count);
}

static svo_status check_counts(const svo_i_file_load *state, const file_counts *counts)
{
    const bool implied = counts->form == SVO_FORM_IMPLIED;
    const uint64_t inner = state->head.header.level_begin[state->head.header.depth];
    const uint32_t step_log2 = counts->directory_step_log2;
    uint64_t stored = inner + counts->far_count;
    if (counts->form >= SVO_FORM_COUNT || counts->minimized > 1) {
        return svo_i_file_damaged(state, "counts: form %" PRIu32 " or minimized %" PRIu32 " is not known", counts->form,
                                  counts->minimized);
    }
    SVO_I_TRY(check_packed(state, counts));
    if (implied ? step_log2 < SVO_I_DIRECTORY_LOG2_MIN || step_log2 > SVO_I_DIRECTORY_LOG2_MAX : step_log2 != 0) {
        return svo_i_file_damaged(state, "counts: directory_step_log2 %" PRIu32 " does not fit the form", step_log2);
    }
    SVO_I_TRY(check_leaf_counts(state, counts));
    if (counts->form == SVO_FORM_SHARED || counts->form == SVO_FORM_MIRRORED) {
        return check_shared_counts(state, counts);
    }
    for (uint32_t level = 0; implied && level < state->head.header.depth; ++level) {
        stored += counts->level_leaf[level];
    }
    if (counts->shared_count != 0 || counts->far_count > (implied ? 0 : inner) || counts->stored_count != stored ||
        stored > UINT32_MAX) {
        return svo_i_file_damaged(state, "counts: %" PRIu64 " nodes and %" PRIu64 " far words are not %" PRIu64, inner,
                                  counts->far_count, counts->stored_count);
    }
    return SVO_OK;
}

/* The chunk after the table must be the counts. */
static svo_status load_counts(const svo_i_file_load *state, file_counts *counts, uint64_t *offset)
{
    const file_header *header = &state->head.header;
    const file_chunk *chunk = &state->head.chunks[0];
    svo_status status = SVO_OK;
    void *plain = NULL;
    if (header->chunk_count == 0 || chunk->kind != FILE_COUNTS || chunk->plain_bytes != sizeof *counts) {
        return svo_i_file_damaged(state, "chunk counts is missing");
    }
    if ((header->need & ~SVO_I_PAYLOAD_NEEDS) != 0) {
        return svo_i_file_damaged(state, "header: need 0x%" PRIx16 " is not of payload alone", header->need);
    }
    SVO_I_TRY(svo_i_file_check_place(state, chunk, "counts", header->header_bytes));
    SVO_I_TRY_CLEANUP(load_chunk(state, chunk, "counts", &plain));
    memcpy(counts, plain, sizeof *counts);
    *offset = header->header_bytes + chunk->stored_bytes;

cleanup:
    svo_i_free(plain);
    return status;
}

static svo_status load_arrays(const svo_i_file_load *state, uint64_t offset, svo_compact *compact)
{
    uint32_t chunk_index = 1;
    for (uint32_t i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        const char *name = svo_name(SVO_NAME_COMPACT_BUFFER, (svo_compact_buffer)i);
        const file_chunk *chunk = &state->head.chunks[chunk_index];
        if (compact->info.bytes[i] == 0) {
            continue;
        }
        if (chunk_index == state->head.header.chunk_count || chunk->kind != i) {
            return svo_i_file_damaged(state, "chunk %s is missing", name);
        }
        SVO_I_TRY(svo_i_file_check_place(state, chunk, name, offset));
        if (chunk->plain_bytes != compact->info.bytes[i]) {
            return svo_i_file_damaged(state, "chunk %s: %" PRIu64 " bytes, %" PRIu64 " expected", name,
                                      chunk->plain_bytes, compact->info.bytes[i]);
        }
        SVO_I_TRY(load_chunk(state, chunk, name, &compact->host[i]));
        offset += chunk->stored_bytes;
        ++chunk_index;
    }
    return svo_i_file_check_end(state, chunk_index, offset);
}

/* The lengths of packed arrays are those of their chunks. */
static void find_packed_bytes(const svo_i_file_load *state, svo_compact_info *info)
{
    for (uint32_t k = 0; k < state->head.header.chunk_count; ++k) {
        const file_chunk *chunk = &state->head.chunks[k];
        if (chunk->kind < SVO_COMPACT_BUFFER_COUNT && svo_i_compact_is_packed(info, (svo_compact_buffer)chunk->kind)) {
            info->bytes[chunk->kind] = chunk->plain_bytes;
        }
    }
    svo_i_compact_count(info);
}

static svo_status check_payload(const svo_i_file_load *state, svo_compact *compact)
{
    for (uint32_t i = SVO_I_PAYLOAD_FIRST; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        const svo_compact_buffer buffer = (svo_compact_buffer)i;
        if (svo_i_compact_is_packed(&compact->info, buffer)) {
            SVO_I_TRY(svo_i_packed_check(compact, buffer, state->source.name, state->source.message));
            svo_i_packed_errors(compact->host[i], buffer, &compact->info);
        }
    }
    return SVO_OK;
}

static uint64_t count_bytes(const svo_compact_info *info)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        bytes += info->bytes[i];
    }
    return bytes;
}

static svo_status load(svo_i_file_load *state, svo_compact **out)
{
    static const svo_i_file_kind kind = {"compact tree's", FILE_COMPACT_MAGIC, FILE_COMPACT_OLDEST,
                                         FILE_COMPACT_VERSION, 1 + SVO_COMPACT_BUFFER_COUNT};
    file_counts counts = {.form = 0};
    uint64_t offset = 0;
    svo_status status = SVO_OK;
    if (state->last_level != 0) {
        return svo_i_fail(state->source.message, SVO_INVALID_ARGUMENT,
                          "svo_compact_load: options.last_level is %" PRIu32 "; compact trees are read whole",
                          state->last_level);
    }
    SVO_I_TRY(svo_i_file_read_head(state, &kind));
    SVO_I_TRY(load_counts(state, &counts, &offset));
    SVO_I_TRY(check_counts(state, &counts));
    svo_compact *compact = svo_i_compact_new(&state->host_memory);
    if (compact == NULL) {
        return svo_i_fail(state->source.message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a compact tree",
                          state->source.name);
    }
    fill_info(&state->head.header, &counts, &compact->info);
    find_packed_bytes(state, &compact->info);
    SVO_I_TRY_CLEANUP(svo_i_file_limit(state, compact->info.stored_count, count_bytes(&compact->info)));
    SVO_I_TRY_CLEANUP(load_arrays(state, offset, compact));
    SVO_I_TRY_CLEANUP(svo_i_compact_check(compact, state->source.name, state->source.message));
    SVO_I_TRY_CLEANUP(check_payload(state, compact));
    compact->downloaded = true;
    *out = compact;
    compact = NULL;

cleanup:
    svo_compact_destroy(&compact);
    return status;
}

svo_status svo_compact_load(svo_source source, const svo_load_options *options, svo_compact **out, svo_message *message)
{
    svo_i_file_load state = {.voxels_max = 0};
    if (out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_compact_load: out is NULL");
    }
    SVO_I_TRY(svo_i_file_load_open("svo_compact_load", source, options, message, &state));
    const svo_status status = load(&state, out);
    svo_i_source_close(&state.source);
    return status;
}
