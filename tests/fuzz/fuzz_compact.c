/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: arbitrary bytes as the file of a compact tree. Either they are refused with a one-line message, or a
 * walk from the root stays inside the arrays and finds the nodes and the places of payload that the description tells.
 */
#include <string.h>

#include "fuzz.h"
#include "svocl/io.h"
#include "svocl/plan.h"

#define NAME "input"

typedef struct walk {
    svo_compact_info info;
    svo_compact_arrays arrays;
    uint64_t inner_count, leaf_count;
} walk;

static uint32_t count_bits(uint32_t mask)
{
    return (uint32_t)__builtin_popcount(mask);
}

static void check_place(const walk *w, uint64_t place)
{
    REQUIRE(place == SVO_NO_NODE || place < w->info.payload_count);
}

/* The word of a node and all below it. */
static void walk_words(walk *w, uint64_t at, uint32_t level)
{
    const uint32_t *words = w->arrays.nodes;
    REQUIRE(at < w->info.stored_count && level < w->info.depth);
    const uint32_t word = words[at];
    const uint32_t inner = word & ~(word >> 8) & 255;
    uint64_t first = at + (word >> 17);
    ++w->inner_count;
    w->leaf_count += count_bits(word & word >> 8 & 255);
    if (w->arrays.bases != NULL && (word & 255) != 0) {
        const uint32_t base = w->arrays.bases[at];
        check_place(w, base == SVO_NO_NODE ? base : (uint64_t)base + count_bits(word & 255) - 1);
    }
    if ((word >> 16 & 1) != 0) {
        REQUIRE(first < w->info.stored_count);
        first = at + words[first];
    }
    for (uint32_t rank = 0; rank < count_bits(inner); ++rank) {
        walk_words(w, first + rank, level + 1);
    }
}

/* A node above level depth and all below it; leaves of the deepest level have no mask. */
static void walk_masks(walk *w, uint64_t node, uint32_t level)
{
    const uint8_t *masks = w->arrays.nodes;
    if (w->arrays.bases != NULL && node >= w->arrays.bases[0]) {
        check_place(w, node - w->arrays.bases[0]);
    }
    if (level == w->info.depth || (node > 0 && masks[node] == 0)) {
        ++w->leaf_count;
        return;
    }
    REQUIRE(node < w->info.stored_count);
    ++w->inner_count;
    const uint64_t entry = node >> w->info.directory_step_log2;
    uint64_t child = w->arrays.links[entry];
    for (uint64_t before = entry << w->info.directory_step_log2; before < node; ++before) {
        child += count_bits(masks[before]);
    }
    for (uint32_t rank = 0; rank < count_bits(masks[node]); ++rank) {
        walk_masks(w, child + rank, level + 1);
    }
}

static void check_refusal(svo_status status, const svo_compact *compact, const svo_message *message)
{
    REQUIRE(status == SVO_FILE_DAMAGED || status == SVO_OUT_OF_HOST_MEMORY);
    REQUIRE(compact == NULL);
    REQUIRE(strncmp(message->text, NAME ": ", strlen(NAME ": ")) == 0);
    REQUIRE(strchr(message->text, '\n') == NULL);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t byte_count)
{
    static const uint8_t nothing;
    svo_compact *compact = NULL;
    svo_message message = {""};
    const svo_status status =
        svo_compact_load_memory(data != NULL ? data : &nothing, byte_count, NAME, NULL, &compact, &message);
    if (status != SVO_OK) {
        check_refusal(status, compact, &message);
        return 0;
    }
    walk w = {.info = SVO_COMPACT_INFO_INIT, .arrays = SVO_COMPACT_ARRAYS_INIT};
    char hash[SVO_HASH_TEXT_BYTES];
    svo_compact_get_info(compact, &w.info);
    svo_compact_get_arrays(compact, &w.arrays);
    REQUIRE(w.info.depth >= SVO_DEPTH_MIN && w.info.depth <= SVO_DEPTH_MAX);
    if (w.info.form == SVO_FORM_IMPLIED) {
        walk_masks(&w, 0, 0);
    } else {
        walk_words(&w, 0, 0);
    }
    REQUIRE(w.inner_count == w.info.inner_count && w.leaf_count == w.info.leaf_count);
    REQUIRE(svo_compact_hash(compact, hash) == SVO_OK && strlen(hash) == SVO_HASH_TEXT_BYTES - 1);
    svo_compact_destroy(&compact);
    REQUIRE(compact == NULL);
    return 0;
}
