/* SPDX-License-Identifier: MIT */
/*
 * From nodes to records of the form "shared". Bottom-up, level by level: each node's record is made from the records of
 * its children, looked up in a hash table, and appended if no earlier node of the level has the same. So records are
 * numbered by their first node in Morton order, and equal occupancy gives equal words, whatever the hash function.
 *
 * Kampe, Sintorn and Assarsson (2013) sort the nodes of a level instead. On the host a hash table does the same in one
 * pass, and keeps the order.
 */
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "compact/dag.h"
#include "shared/dag.clh"

/* Slots of a new hash table, a power of two. */
#define FIRST_SLOT_COUNT 1024u

/* The different records of a level. Those of children are named by their first word in the children's level. */
typedef struct level_records {
    uint32_t *words;
    size_t word_count, word_capacity;
    size_t record_count;
} level_records;

typedef struct encoder {
    const svo_i_dag_nodes *nodes;
    bool places;
    const svo_i_memory *memory;
    const char *function;
    svo_message *message;
    level_records levels[SVO_LEVELS_MAX];
    uint32_t *record_of; /* per node with two and more levels below: its record's first word in its level */
    uint32_t *subtree_places; /* per such node: the places of its subtree; NULL without places */
    uint32_t *slots; /* hash table of the current level: first word of a record plus one, 0 for none */
    size_t slot_count;
} encoder;

static svo_status fail_memory(const encoder *made, size_t bytes)
{
    return svo_i_fail(made->message, SVO_OUT_OF_HOST_MEMORY, "%s: shared records need %zu bytes", made->function,
                      bytes);
}

static svo_status fail_words(const encoder *made, size_t count)
{
    return svo_i_fail(made->message, SVO_UNSUPPORTED, "%s: %zu words of records are above 2^32 - 1", made->function,
                      count);
}

/* ---- the records of a level ---- */

/* Makes room for one more record, of fewer than 2^32 words with it, and returns where it goes; NULL when out of
   memory. */
static uint32_t *reserve_record(const encoder *made, level_records *level)
{
    if (level->word_count + SVO_SHARED_RECORD_WORDS_MAX > level->word_capacity) {
        const size_t doubled = 2 * level->word_capacity + SVO_SHARED_RECORD_WORDS_MAX;
        const size_t capacity = doubled < UINT32_MAX ? doubled : UINT32_MAX;
        uint32_t *grown = svo_i_grow(made->memory, level->words, capacity * sizeof *grown);
        if (grown == NULL) {
            return NULL;
        }
        level->words = grown;
        level->word_capacity = capacity;
    }
    return level->words + level->word_count;
}

static size_t slot_of(const encoder *made, const uint32_t *record, size_t word_count)
{
    return (size_t)XXH3_64bits(record, word_count * sizeof *record) & (made->slot_count - 1);
}

static size_t next_slot(const encoder *made, size_t slot)
{
    return (slot + 1) & (made->slot_count - 1);
}

/* An empty table with twice as many slots, or the first one, and the records of a level in it. */
static svo_status grow_table(encoder *made, const level_records *level, uint32_t levels)
{
    const size_t slot_count = made->slot_count == 0 ? FIRST_SLOT_COUNT : 2 * made->slot_count;
    uint32_t *slots = svo_i_alloc_zeroed(made->memory, slot_count, sizeof *slots);
    if (slots == NULL) {
        return fail_memory(made, slot_count * sizeof *slots);
    }
    svo_i_free(made->slots);
    made->slots = slots;
    made->slot_count = slot_count;
    for (size_t at = 0; at < level->word_count;) {
        const uint32_t *record = level->words + at;
        const size_t words = svo_shared_record_words(record[0], levels, made->places);
        size_t slot = slot_of(made, record, words);
        while (slots[slot] != 0) {
            slot = next_slot(made, slot);
        }
        slots[slot] = (uint32_t)at + 1;
        at += words;
    }
    return SVO_OK;
}

/* Takes the record, which lies behind the last one of its level, unless the level has the same already. first_word:
   receives where it is. */
static svo_status unify_record(encoder *made, level_records *level, const uint32_t *record, uint32_t levels,
                               uint32_t *first_word)
{
    const size_t words = svo_shared_record_words(record[0], levels, made->places);
    if (2 * (level->record_count + 1) > made->slot_count) {
        SVO_I_TRY(grow_table(made, level, levels));
    }
    size_t slot = slot_of(made, record, words);
    for (; made->slots[slot] != 0; slot = next_slot(made, slot)) {
        const uint32_t *known = level->words + (made->slots[slot] - 1);
        if (known[0] == record[0] && memcmp(known, record, words * sizeof *record) == 0) {
            *first_word = made->slots[slot] - 1;
            return SVO_OK;
        }
    }
    made->slots[slot] = (uint32_t)level->word_count + 1;
    *first_word = (uint32_t)level->word_count;
    level->word_count += words;
    ++level->record_count;
    return SVO_OK;
}

/* ---- one record ---- */

/* 1 where a node with so many levels below it has a place, else 0. */
static uint32_t own_place(const svo_i_dag_nodes *nodes, uint32_t levels)
{
    return levels <= nodes->depth - nodes->payload_level ? 1 : 0;
}

/* The places of an inner node's subtree. */
static uint32_t places_of_subtree(const encoder *made, uint32_t node, uint32_t levels)
{
    return levels == 1 ? svo_count_bits(made->nodes->valid[node]) + own_place(made->nodes, 1)
                       : made->subtree_places[node];
}

/* Writes the number of places before an inner child into a record. */
static void put_number(uint32_t *record, uint32_t levels, uint32_t rank, uint32_t before)
{
    if (levels > SVO_SHARED_SHORT_LEVELS) {
        record[rank] = before;
    } else {
        record[rank >> 1] |= before << 16 * (rank & 1);
    }
}

/* Makes a node's record. record: SVO_SHARED_RECORD_WORDS_MAX words. levels: above 1, or 1 for the root. */
static void make_record(const encoder *made, uint32_t node, uint32_t levels, uint32_t *record)
{
    const uint32_t valid = made->nodes->valid[node];
    const uint32_t leaves = made->nodes->leaf[node];
    const uint32_t masks = valid | leaves << 8;
    const uint32_t inner = svo_count_bits(valid & ~leaves);
    const uint32_t numbers = svo_shared_number_count(masks, made->places);
    const uint32_t children_begin = levels > 2 ? svo_shared_children_begin(levels, numbers) : 0;
    uint32_t before = 0;
    memset(record, 0, SVO_SHARED_RECORD_WORDS_MAX * sizeof *record);
    record[0] = masks;
    for (uint32_t rank = 0; rank < inner; ++rank) {
        const uint32_t child = made->nodes->first_inner[node] + rank;
        if (levels == 2) {
            record[(rank + 2) >> 2] |= (uint32_t)made->nodes->valid[child] << 8 * ((rank + 2) & 3);
            continue;
        }
        record[children_begin + rank] = made->record_of[child];
        if (rank < numbers) {
            before += places_of_subtree(made, child, levels - 1);
            put_number(record, levels, rank + 1, before);
        }
    }
}

/* ---- all levels ---- */

static void count_places(encoder *made, uint32_t node, uint32_t levels)
{
    const svo_i_dag_nodes *nodes = made->nodes;
    const uint32_t leaves = nodes->leaf[node];
    const uint32_t inner = svo_count_bits(nodes->valid[node] & ~leaves);
    uint32_t places = own_place(nodes, levels) + own_place(nodes, levels - 1) * svo_count_bits(leaves);
    for (uint32_t rank = 0; rank < inner; ++rank) {
        places += places_of_subtree(made, nodes->first_inner[node] + rank, levels - 1);
    }
    made->subtree_places[node] = places;
}

static svo_status encode_level(encoder *made, uint32_t level)
{
    const svo_i_dag_nodes *nodes = made->nodes;
    const uint32_t levels = nodes->depth - level;
    level_records *records = &made->levels[level];
    svo_i_free(made->slots);
    made->slots = NULL;
    made->slot_count = 0;
    for (uint32_t node = nodes->level_begin[level]; node < nodes->level_begin[level + 1]; ++node) {
        uint32_t first_word = 0;
        if (records->word_count > UINT32_MAX - SVO_SHARED_RECORD_WORDS_MAX) {
            return fail_words(made, records->word_count + SVO_SHARED_RECORD_WORDS_MAX);
        }
        uint32_t *record = reserve_record(made, records);
        if (record == NULL) {
            return fail_memory(made, (records->word_capacity + SVO_SHARED_RECORD_WORDS_MAX) * sizeof *record);
        }
        make_record(made, node, levels, record);
        SVO_I_TRY(unify_record(made, records, record, levels, &first_word));
        made->record_of[node] = first_word;
        if (made->places) {
            count_places(made, node, levels);
        }
    }
    return SVO_OK;
}

/* The levels' records behind each other, their children named by their first word in all of them. */
static svo_status join_levels(const encoder *made, uint32_t level_count, svo_i_dag *out)
{
    const uint32_t depth = made->nodes->depth;
    size_t total = 0;
    for (uint32_t level = 0; level < level_count; ++level) {
        total += made->levels[level].word_count;
        out->record_count += made->levels[level].record_count;
    }
    if (total > UINT32_MAX) {
        return fail_words(made, total);
    }
    out->words = svo_i_alloc(made->memory, total * sizeof *out->words);
    if (out->words == NULL) {
        return fail_memory(made, total * sizeof *out->words);
    }
    for (uint32_t level = 0; level < level_count; ++level) {
        const size_t end = out->word_count + made->levels[level].word_count;
        if (end > out->word_count) {
            memcpy(out->words + out->word_count, made->levels[level].words,
                   made->levels[level].word_count * sizeof *out->words);
        }
        while (out->word_count < end) {
            uint32_t *record = out->words + out->word_count;
            const uint32_t levels = depth - level;
            const uint32_t words = svo_shared_record_words(record[0], levels, made->places);
            const uint32_t numbers = svo_shared_number_count(record[0] & 0xffff, made->places);
            for (uint32_t at = svo_shared_children_begin(levels, numbers); at < words && levels > 2; ++at) {
                record[at] += (uint32_t)end;
            }
            out->word_count += words;
        }
    }
    return SVO_OK;
}

/* Gives the children of an inner node their places. inner_places: of inner nodes, that of the node already set. */
static void place_children(const encoder *made, uint32_t node, uint32_t levels, uint32_t *inner_places,
                           uint32_t *place_of)
{
    const svo_i_dag_nodes *nodes = made->nodes;
    const uint32_t leaves = nodes->leaf[node];
    const uint32_t child_own = own_place(nodes, levels - 1);
    uint32_t place = inner_places[node] + own_place(nodes, levels);
    uint32_t inner = nodes->first_inner[node];
    uint32_t payload = nodes->first_payload[node] - nodes->payload_begin;
    for (uint32_t octant = 0; octant < 8; ++octant) {
        if ((nodes->valid[node] >> octant & 1) == 0) {
            continue;
        }
        if (child_own != 0) {
            place_of[payload++] = place;
        }
        if ((leaves >> octant & 1) != 0) {
            place += child_own;
        } else {
            inner_places[inner] = place;
            place += places_of_subtree(made, inner, levels - 1);
            ++inner;
        }
    }
}

/* Gives each payload its place, from the root on. */
static svo_status place_payload(const encoder *made, uint32_t *place_of)
{
    const svo_i_dag_nodes *nodes = made->nodes;
    const size_t bytes = nodes->level_begin[nodes->depth] * sizeof(uint32_t);
    uint32_t *inner_places = svo_i_alloc(made->memory, bytes);
    if (inner_places == NULL) {
        return fail_memory(made, bytes);
    }
    inner_places[0] = 0;
    if (nodes->payload_level == 0) {
        place_of[0] = 0;
    }
    for (uint32_t level = 0; level < nodes->depth; ++level) {
        for (uint32_t node = nodes->level_begin[level]; node < nodes->level_begin[level + 1]; ++node) {
            place_children(made, node, nodes->depth - level, inner_places, place_of);
        }
    }
    svo_i_free(inner_places);
    return SVO_OK;
}

static svo_status encode(encoder *made, svo_i_dag *out, uint32_t *place_of)
{
    const svo_i_dag_nodes *nodes = made->nodes;
    /* The level above the voxels has no records, unless it is the root's. */
    const uint32_t level_count = nodes->depth > 1 ? nodes->depth - 1 : 1;
    const size_t bytes = nodes->level_begin[level_count] * sizeof(uint32_t);
    made->record_of = svo_i_alloc(made->memory, bytes);
    made->subtree_places = made->places ? svo_i_alloc(made->memory, bytes) : NULL;
    if (made->record_of == NULL || (made->places && made->subtree_places == NULL)) {
        return fail_memory(made, bytes);
    }
    for (uint32_t level = level_count; level-- > 0;) {
        SVO_I_TRY(encode_level(made, level));
    }
    SVO_I_TRY(join_levels(made, level_count, out));
    if (made->subtree_places == NULL) {
        return SVO_OK;
    }
    out->place_count = made->subtree_places[0];
    return place_of != NULL ? place_payload(made, place_of) : SVO_OK;
}

svo_status svo_i_dag_encode(const char *function, const svo_i_dag_nodes *nodes, const svo_i_memory *memory, bool places,
                            svo_i_dag *out, uint32_t *place_of, svo_message *message)
{
    encoder made = {.nodes = nodes, .places = places, .memory = memory, .function = function, .message = message};
    *out = (svo_i_dag){.depth = nodes->depth, .payload_level = nodes->payload_level, .places = places};
    const svo_status status = encode(&made, out, place_of);
    for (uint32_t level = 0; level < SVO_LEVELS_MAX; ++level) {
        svo_i_free(made.levels[level].words);
    }
    svo_i_free(made.record_of);
    svo_i_free(made.subtree_places);
    svo_i_free(made.slots);
    return status;
}

void svo_i_dag_free(svo_i_dag *dag)
{
    svo_i_free(dag->words);
    *dag = (svo_i_dag){.words = NULL};
}
