/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: arbitrary bytes as the file of a compact tree. Either they are refused with a one-line message, or a
 * walk from the root stays inside the arrays and finds the nodes and the places of payload that the description tells.
 */
#include <stdlib.h>
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

/* ---- records, which many nodes may share ---- */

/* What a subtree holds. */
typedef struct subtree {
    uint64_t inner, leaf, places;
    int known;
} subtree;

static uint64_t count_places(const walk *w, uint32_t levels)
{
    return levels <= w->info.depth - w->info.payload_level ? 1 : 0;
}

/* A node on the level above the voxels. */
static subtree count_mask(const walk *w, uint32_t mask)
{
    REQUIRE(mask != 0);
    return (subtree){1, count_bits(mask), count_places(w, 1) + count_bits(mask) * count_places(w, 0), 1};
}

/* before[rank] of a record. */
static uint64_t number_of(const uint32_t *record, uint32_t levels, uint32_t rank)
{
    return levels > 5 ? record[rank] : record[rank / 2] >> 16 * (rank % 2) & 65535;
}

/* A record and all below it, each once. levels: above 1. known: by first word. */
static subtree walk_record(const walk *w, uint64_t at, uint32_t levels, subtree *known)
{
    REQUIRE(at < w->info.stored_count);
    if (known[at].known != 0) {
        return known[at];
    }
    const uint32_t *record = (const uint32_t *)w->arrays.nodes + at;
    const uint32_t leaf = record[0] >> 8 & 255;
    const uint32_t inner = record[0] & ~leaf & 255;
    const uint32_t children = count_bits(inner);
    const int has_places = (w->info.need & ~w->info.constant) != 0;
    const uint32_t numbers = has_places ? children - (inner > leaf ? 1 : 0) : 0;
    const uint32_t names = 1 + (levels > 5 ? numbers : numbers / 2);
    REQUIRE(at + (levels == 2 ? (children + 5) / 4 : names + children) <= w->info.stored_count);
    subtree found = {1, count_bits(leaf), 0, 1};
    uint64_t before = 0;
    for (uint32_t rank = 0; rank < children; ++rank) {
        const uint32_t byte = 2 + rank;
        const subtree child = levels == 2 ? count_mask(w, record[byte / 4] >> 8 * (byte % 4) & 255)
                                          : walk_record(w, record[names + rank], levels - 1, known);
        found.inner += child.inner;
        found.leaf += child.leaf;
        before += child.places;
        REQUIRE(levels == 2 || rank >= numbers || number_of(record, levels, rank + 1) == before);
    }
    found.places = before + count_places(w, levels) + count_bits(leaf) * count_places(w, levels - 1);
    known[at] = found;
    return found;
}

static uint32_t half_of(const walk *w, uint64_t at)
{
    REQUIRE(at / 2 < w->info.stored_count);
    return ((const uint32_t *)w->arrays.nodes)[at / 2] >> 16 * (at % 2) & 65535;
}

static uint32_t byte_of(const walk *w, uint64_t at, uint32_t index)
{
    return half_of(w, at + index / 2) >> 8 * (index % 2) & 255;
}

/* The same for half words with two levels below. */
static subtree walk_bytes(const walk *w, uint64_t at)
{
    const uint32_t children = count_bits(byte_of(w, at, 0));
    subtree found = {1, 0, count_places(w, 2), 1};
    for (uint32_t index = 1; index <= children; ++index) {
        const uint32_t mask = byte_of(w, at, index);
        const subtree child = mask != 0 ? count_mask(w, mask) : (subtree){0, 1, count_places(w, 1), 1};
        found.inner += child.inner;
        found.leaf += child.leaf;
        found.places += child.places;
    }
    return found;
}

/* A record in half words and all below it, each once. levels: above 1. known: by first half word. */
static subtree walk_halves(const walk *w, uint64_t at, uint32_t levels, subtree *known)
{
    REQUIRE(at / 2 < w->info.stored_count);
    if (known[at].known == 0 && levels == 2) {
        known[at] = walk_bytes(w, at);
    }
    if (known[at].known != 0) {
        return known[at];
    }
    const uint32_t inner = half_of(w, at) & 255;
    const uint32_t wide = half_of(w, at) >> 8;
    const uint32_t leaf = wide & ~inner;
    const int has_places = (w->info.need & ~w->info.constant) != 0;
    const uint32_t numbers = has_places ? count_bits(inner) - (inner > leaf ? 1 : 0) : 0;
    uint64_t reference = at + 1 + (levels > 5 ? 2 * numbers : numbers);
    subtree found = {1, count_bits(leaf), 0, 1};
    uint64_t before = 0;
    uint32_t rank = 0;
    for (uint32_t octant = 0; octant < 8; ++octant) {
        if ((inner >> octant & 1) == 0) {
            continue;
        }
        const uint32_t is_long = wide >> octant & 1;
        uint64_t place = w->arrays.links[levels - 1] + (half_of(w, reference) & 8191);
        place += is_long != 0 ? (uint64_t)half_of(w, reference + 1) << 13 : 0;
        reference += 1 + is_long;
        const subtree child = walk_halves(w, place, levels - 1, known);
        found.inner += child.inner;
        found.leaf += child.leaf;
        before += child.places;
        ++rank;
        REQUIRE(rank > numbers ||
                before == (levels > 5 ? half_of(w, at + 2 * rank - 1) | half_of(w, at + 2 * rank) << 16
                                      : half_of(w, at + rank)));
    }
    found.places = before + count_places(w, levels) + count_bits(leaf) * count_places(w, levels - 1);
    known[at] = found;
    return found;
}

static void walk_records(walk *w)
{
    const int mirrored = w->info.form == SVO_FORM_MIRRORED;
    const uint32_t *words = w->arrays.nodes;
    subtree *known = calloc(2 * w->info.stored_count, sizeof *known);
    if (known == NULL) {
        abort();
    }
    REQUIRE(w->arrays.links[0] == w->info.depth && w->arrays.links[1] == w->info.depth - w->info.payload_level);
    const uint32_t mask = (mirrored && w->info.depth > 2 ? words[0] | words[0] >> 8 : words[0]) & 255;
    const subtree all = mask == 0            ? (subtree){1, 0, count_places(w, w->info.depth), 1}
                        : w->info.depth == 1 ? count_mask(w, mask)
                        : mirrored           ? walk_halves(w, 0, w->info.depth, known)
                                             : walk_record(w, 0, w->info.depth, known);
    w->inner_count = all.inner;
    w->leaf_count = all.leaf;
    REQUIRE((w->info.need & ~w->info.constant) == 0 || all.places == w->info.payload_count);
    free(known);
}

/* Every element of every payload array, packed or not. */
static void read_payload(const svo_compact *compact, const svo_compact_info *info)
{
    static uint8_t elements[6 * 256];
    for (int k = 0; k < SVO_PAYLOAD_COUNT; ++k) {
        const svo_compact_buffer buffer = (svo_compact_buffer)(SVO_COMPACT_COLORS + k);
        for (uint64_t first = 0; info->bytes[buffer] > 0 && first < info->payload_count; first += 256) {
            const uint64_t left = info->payload_count - first;
            REQUIRE(svo_compact_read_payload(compact, buffer, first, left < 256 ? left : 256, elements) == SVO_OK);
        }
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
        svo_compact_load(svo_from_memory(data != NULL ? data : &nothing, byte_count, NAME), NULL, &compact, &message);
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
    } else if (w.info.form == SVO_FORM_SHARED || w.info.form == SVO_FORM_MIRRORED) {
        walk_records(&w);
    } else {
        walk_words(&w, 0, 0);
    }
    REQUIRE(w.inner_count == w.info.inner_count && w.leaf_count == w.info.leaf_count);
    read_payload(compact, &w.info);
    REQUIRE(svo_compact_hash(compact, hash) == SVO_OK && strlen(hash) == SVO_HASH_TEXT_BYTES - 1);
    svo_compact_destroy(&compact);
    REQUIRE(compact == NULL);
    return 0;
}
