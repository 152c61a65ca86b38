/* SPDX-License-Identifier: MIT */
/*
 * From nodes to records of the forms "shared" and "mirrored". Bottom-up, level by level: each node's record is made
 * from the records of its children, looked up in a hash table, and appended if no earlier node of the level has the
 * same. So records are numbered by their first node in Morton order, and equal occupancy gives equal words, whatever
 * the hash function.
 *
 * Kampe, Sintorn and Assarsson (2013) sort the nodes of a level instead. On the host a hash table does the same in one
 * pass, and keeps the order.
 *
 * Of a node's eight reflections one has the record: the lexicographically least, where a child is its record's number
 * and its own mirror. Subtrees that are their own reflections have several mirrors; the least one names them. So the
 * reflections of a subtree all get one record (Villanueva, Marton and Gobbetti, 2016, find it by hashes of contents).
 * When all records are known they are put in the order of their use and written in half words.
 */
#include <stdlib.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "compact/dag.h"
#include "shared/dag.clh"
#include "shared/mirrored.clh"

/* Slots of a new hash table, a power of two. */
#define FIRST_SLOT_COUNT 1024u

/* The different records of a level. Those of children are named by their first word in the children's level. Until they
   are written, records of the form "mirrored" have other words: bits 0-7 of the first one are the valid mask, bits 8-15
   the leaf mask, bits 16-23 the mirrors that change nothing; then the places of the subtree, with places; then for each
   inner child the word of its record << 3 | mirror, or above voxels its valid mask << 3. */
typedef struct level_records {
    uint32_t *words;
    size_t word_count, word_capacity;
    size_t record_count;
} level_records;

/* A node's children by octant: valid mask << 3 above voxels, else the record << 3 | mirror. */
typedef struct siblings {
    uint32_t valid, leaves, levels; /* levels: from the node to the voxels */
    uint32_t references[8];
} siblings;

/* Most nodes have the children of a node shortly before, so that its record is known without looking for its mirror. */
#define KNOWN_COUNT 0x4000u
typedef struct known_siblings {
    siblings of; /* levels 0: none */
    uint32_t reference; /* the node's record << 3 | mirror */
} known_siblings;

typedef struct encoder {
    const svo_i_dag_nodes *nodes;
    bool places;
    bool mirrored;
    const svo_i_memory *memory;
    const char *function;
    svo_message *message;
    level_records levels[SVO_LEVELS_MAX];
    uint32_t *record_of; /* per node with two and more levels below: its record's first word in its level; of the form
                            "mirrored" that << 3 | mirror */
    uint32_t *subtree_places; /* per such node: the places of its subtree; NULL without places */
    uint32_t *slots; /* hash table of the current level: first word of a record plus one, 0 for none */
    size_t slot_count;
    known_siblings *known; /* KNOWN_COUNT of them, by hash; NULL in the form "shared" */
} encoder;

static svo_status fail_memory(const encoder *made, size_t bytes)
{
    (void)svo_i_fail(made->message, SVO_OUT_OF_HOST_MEMORY, "%s: shared records need %zu bytes", made->function, bytes);
    return SVO_OUT_OF_HOST_MEMORY; /* not SVO_OK, as the analyzer sees */
}

static svo_status fail_words(const encoder *made, size_t count)
{
    return svo_i_fail(made->message, SVO_UNSUPPORTED, "%s: %zu words of records are above 2^%s - 1", made->function,
                      count, made->mirrored ? "29" : "32");
}

/* ---- the records of a level ---- */

static uint32_t inner_of(const uint32_t *record)
{
    return record[0] & 0xff & ~(record[0] >> 8);
}

/* The references of a record of the form "mirrored". */
static const uint32_t *references_of(const encoder *made, const uint32_t *record)
{
    return record + (made->places ? 2 : 1);
}

static uint32_t record_words(const encoder *made, const uint32_t *record, uint32_t levels)
{
    return made->mirrored ? (uint32_t)(references_of(made, record) - record) + svo_count_bits(inner_of(record))
                          : svo_shared_record_words(record[0], levels, made->places);
}

/* The words of a level at most. With references << 3 they are below 2^32 - 2. */
static size_t level_words_max(const encoder *made)
{
    return (made->mirrored ? SVO_MIRRORED_HALVES_MAX : UINT32_MAX) - 1 - SVO_SHARED_RECORD_WORDS_MAX;
}

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
        const size_t words = record_words(made, record, levels);
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
    const size_t words = record_words(made, record, levels);
    if (2 * (level->record_count + 1) > made->slot_count) {
        SVO_I_TRY(grow_table(made, level, levels));
    }
    if (made->slots == NULL) {
        return SVO_OUT_OF_HOST_MEMORY; /* never: the analyzer does not look into grow_table */
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

/* ---- one record of the form "mirrored" ---- */

static siblings find_siblings(const encoder *made, uint32_t node, uint32_t levels)
{
    siblings found = {.valid = made->nodes->valid[node], .leaves = made->nodes->leaf[node], .levels = levels};
    uint32_t child = made->nodes->first_inner[node];
    for (uint32_t octant = 0; octant < 8; ++octant) {
        if ((found.valid >> octant & ~(found.leaves >> octant) & 1) == 0) {
            continue;
        }
        found.references[octant] = levels == 2 ? (uint32_t)made->nodes->valid[child] << 3 : made->record_of[child];
        ++child;
    }
    return found;
}

/* The least mirror that gives the same. symmetries: the mirrors that change nothing; they are a group. */
static uint32_t least_mirror(uint32_t symmetries, uint32_t mirror)
{
    uint32_t least = 0;
    while ((symmetries >> (least ^ mirror) & 1) == 0) {
        ++least;
    }
    return least;
}

/* What a mirrored node has in an octant: 0 for nothing, 1 for a leaf, 2 and more for an inner child. */
static uint32_t mirrored_key(const encoder *made, const siblings *of, uint32_t octant, uint32_t mirror)
{
    const uint32_t from = octant ^ mirror;
    const uint32_t reference = of->references[from];
    if ((of->valid >> from & 1) == 0) {
        return 0;
    }
    if ((of->leaves >> from & 1) != 0) {
        return 1;
    }
    if (of->levels == 2) {
        return 2 + (svo_mirrored_mask(reference >> 3, mirror) << 3);
    }
    const uint32_t *record = made->levels[made->nodes->depth - of->levels + 1].words + (reference >> 3);
    return 2 + ((reference & ~7u) | least_mirror(record[0] >> 16 & 0xff, (reference & 7) ^ mirror));
}

/* The mirrors, one bit each, that give the least of the eight mirrored nodes. */
static uint32_t find_mirrors(const encoder *made, const siblings *of)
{
    uint32_t mirrors = 0xff;
    for (uint32_t octant = 0; octant < 8 && (mirrors & (mirrors - 1)) != 0; ++octant) {
        uint32_t least = UINT32_MAX;
        uint32_t kept = 0;
        for (uint32_t mirror = 0; mirror < 8; ++mirror) {
            if ((mirrors >> mirror & 1) != 0) {
                const uint32_t key = mirrored_key(made, of, octant, mirror);
                kept = key < least ? 0 : kept;
                least = key < least ? key : least;
                kept |= key == least ? 1u << mirror : 0;
            }
        }
        mirrors = kept;
    }
    return mirrors;
}

/* Makes a node's record as make_record does, and returns the mirror that leads from it to the node. The root has none:
   it stays as it is. */
static uint32_t make_mirrored(const encoder *made, uint32_t node, const siblings *of, uint32_t *record)
{
    const uint32_t mirrors = node == 0 ? 1 : find_mirrors(made, of);
    const uint32_t mirror = least_mirror(mirrors, 0);
    uint32_t symmetries = 0;
    for (uint32_t other = 0; other < 8; ++other) {
        symmetries |= (mirrors >> (other ^ mirror) & 1) << other;
    }
    record[0] = svo_mirrored_mask(of->valid, mirror) | svo_mirrored_mask(of->leaves, mirror) << 8 | symmetries << 16;
    record[1] = made->places ? made->subtree_places[node] : 0;
    uint32_t *reference = record + (made->places ? 2 : 1);
    for (uint32_t octant = 0; octant < 8; ++octant) {
        const uint32_t key = mirrored_key(made, of, octant, mirror);
        if (key > 1) {
            *reference++ = key - 2;
        }
    }
    return mirror;
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

/* Finds or makes the record of a node. */
static svo_status encode_node(encoder *made, level_records *records, uint32_t node, uint32_t levels)
{
    uint32_t first_word = 0;
    uint32_t mirror = 0;
    known_siblings *known = NULL;
    siblings of = {.levels = 0};
    if (made->mirrored) {
        of = find_siblings(made, node, levels);
        known = &made->known[XXH3_64bits(&of, sizeof of) & (KNOWN_COUNT - 1)];
        if (memcmp(&known->of, &of, sizeof of) == 0) {
            made->record_of[node] = known->reference;
            return SVO_OK;
        }
    }
    if (records->word_count > level_words_max(made)) {
        return fail_words(made, records->word_count + SVO_SHARED_RECORD_WORDS_MAX);
    }
    uint32_t *record = reserve_record(made, records);
    if (record == NULL) {
        return fail_memory(made, (records->word_capacity + SVO_SHARED_RECORD_WORDS_MAX) * sizeof *record);
    }
    if (made->mirrored) {
        mirror = make_mirrored(made, node, &of, record);
    } else {
        make_record(made, node, levels, record);
    }
    SVO_I_TRY(unify_record(made, records, record, levels, &first_word));
    made->record_of[node] = first_word;
    if (known != NULL) {
        made->record_of[node] = first_word << 3 | mirror;
        *known = (known_siblings){of, made->record_of[node]};
    }
    return SVO_OK;
}

static svo_status encode_level(encoder *made, uint32_t level)
{
    const svo_i_dag_nodes *nodes = made->nodes;
    const uint32_t levels = nodes->depth - level;
    svo_i_free(made->slots);
    made->slots = NULL;
    made->slot_count = 0;
    for (uint32_t node = nodes->level_begin[level]; node < nodes->level_begin[level + 1]; ++node) {
        if (made->places) {
            count_places(made, node, levels);
        }
        SVO_I_TRY(encode_node(made, &made->levels[level], node, levels));
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

/* ---- records of the form "mirrored" in half words ---- */

/* A record of a level. */
typedef struct ranked {
    uint32_t uses; /* references to it */
    uint32_t first; /* how many other records of the level were referred to before */
    uint32_t record; /* its first word */
} ranked;

typedef struct layout {
    const encoder *made;
    uint32_t level_count;
    ranked *order[SVO_LEVELS_MAX]; /* of each level, as they are written */
    uint32_t *at[SVO_LEVELS_MAX]; /* at a record's first word: its index in order plus 1, then its place in its level */
    uint32_t halves[SVO_LEVELS_MAX]; /* of each level */
    svo_i_dag *out;
} layout;

static int compare_ranked(const void *a, const void *b)
{
    const ranked *x = a;
    const ranked *y = b;
    return x->uses != y->uses ? (x->uses > y->uses ? -1 : 1) : x->first < y->first ? -1 : 1;
}

/* Counts how often the records of a level are referred to, and sorts them. That above is sorted. */
static svo_status rank_level(layout *l, uint32_t level)
{
    const level_records *records = &l->made->levels[level];
    const size_t bytes = records->record_count * sizeof(ranked);
    uint32_t known = 0;
    l->order[level] = svo_i_alloc(l->made->memory, bytes);
    l->at[level] = svo_i_alloc_zeroed(l->made->memory, records->word_count, sizeof *l->at[level]);
    if (l->order[level] == NULL || l->at[level] == NULL) {
        return fail_memory(l->made, bytes + records->word_count * sizeof *l->at[level]);
    }
    if (level == 0) {
        l->order[0][0] = (ranked){.uses = 1};
        return SVO_OK;
    }
    for (size_t i = 0; i < l->made->levels[level - 1].record_count; ++i) {
        const uint32_t *above = l->made->levels[level - 1].words + l->order[level - 1][i].record;
        for (uint32_t rank = 0; rank < svo_count_bits(inner_of(above)); ++rank) {
            const uint32_t record = references_of(l->made, above)[rank] >> 3;
            uint32_t *index = &l->at[level][record];
            if (*index == 0) {
                l->order[level][known] = (ranked){.first = known, .record = record};
                *index = ++known;
            }
            ++l->order[level][*index - 1].uses;
        }
    }
    qsort(l->order[level], known, sizeof(ranked), compare_ranked);
    return SVO_OK;
}

/* Half word 0 of a record. The level below has its places. */
static uint32_t head_of(const layout *l, uint32_t level, const uint32_t *record)
{
    const uint32_t inner = inner_of(record);
    const uint32_t *at = l->at[level + 1];
    uint32_t wide = record[0] >> 8 & 0xff;
    uint32_t rank = 0;
    if (at == NULL) {
        return record[0] & 0xff; /* no level below has records */
    }
    for (uint32_t octant = 0; octant < 8; ++octant) {
        if ((inner >> octant & 1) != 0) {
            const uint32_t place = at[references_of(l->made, record)[rank] >> 3];
            wide |= place >= SVO_MIRRORED_SHORT_PLACES ? 1u << octant : 0;
            ++rank;
        }
    }
    return inner | wide << 8;
}

/* Gives the records of a level their places. The level below has them. */
static svo_status place_level(layout *l, uint32_t level)
{
    size_t end = 0;
    for (size_t i = 0; i < l->made->levels[level].record_count; ++i) {
        const uint32_t first_word = l->order[level][i].record;
        const uint32_t head = head_of(l, level, l->made->levels[level].words + first_word);
        l->at[level][first_word] = (uint32_t)end;
        end += svo_mirrored_record_halves(head, l->made->nodes->depth - level, l->made->places);
        if (end >= SVO_MIRRORED_HALVES_MAX) {
            return fail_words(l->made, end);
        }
    }
    l->halves[level] = (uint32_t)end;
    return SVO_OK;
}

/* Appends half words; the words are 0 before. */
typedef struct half_writer {
    uint32_t *words;
    size_t at;
} half_writer;

static void put_half(half_writer *to, uint32_t half)
{
    to->words[to->at >> 1] |= (half & 0xffff) << 16 * (to->at & 1);
    ++to->at;
}

/* A record with two levels below. */
static void write_bytes(const layout *l, const uint32_t *record, half_writer *to)
{
    const uint32_t *reference = references_of(l->made, record);
    uint32_t bytes = record[0] & 0xff;
    uint32_t count = 1;
    for (uint32_t octant = 0; octant < 8; ++octant) {
        if ((record[0] >> octant & 1) == 0) {
            continue;
        }
        const bool ends = (record[0] >> 8 >> octant & 1) != 0;
        bytes |= (ends ? 0 : *reference++ >> 3) << 8 * (count & 1);
        ++count;
        if ((count & 1) == 0) {
            put_half(to, bytes);
            bytes = 0;
        }
    }
    if ((count & 1) != 0) {
        put_half(to, bytes);
    }
}

/* A record with more levels below it. */
static void write_references(const layout *l, uint32_t level, const uint32_t *record, half_writer *to)
{
    const uint32_t levels = l->made->nodes->depth - level;
    const uint32_t inner = svo_count_bits(inner_of(record));
    const uint32_t numbers = svo_shared_number_count(record[0] & 0xffff, l->made->places);
    const uint32_t *references = references_of(l->made, record);
    const uint32_t *at = l->at[level + 1];
    uint32_t before = 0;
    put_half(to, head_of(l, level, record));
    for (uint32_t rank = 0; rank < numbers; ++rank) {
        before += l->made->levels[level + 1].words[(references[rank] >> 3) + 1];
        put_half(to, before);
        if (levels > SVO_SHARED_SHORT_LEVELS) {
            put_half(to, before >> 16);
        }
    }
    for (uint32_t rank = 0; rank < inner && at != NULL; ++rank) {
        const uint32_t place = at[references[rank] >> 3];
        put_half(to, (place & (SVO_MIRRORED_SHORT_PLACES - 1)) | references[rank] << 13);
        if (place >= SVO_MIRRORED_SHORT_PLACES) {
            put_half(to, place >> 13);
        }
    }
}

/* Writes all records. The levels have their places. */
static svo_status write_levels(layout *l)
{
    const uint32_t depth = l->made->nodes->depth;
    size_t total = 0;
    for (uint32_t level = 0; level < l->level_count; ++level) {
        if (depth - level > 1) {
            l->out->links[depth - level] = (uint32_t)total;
        }
        l->out->record_count += l->made->levels[level].record_count;
        total += l->halves[level];
    }
    if (total >= SVO_MIRRORED_HALVES_MAX) {
        return fail_words(l->made, total);
    }
    l->out->word_count = (total + 1) / 2;
    l->out->words = svo_i_alloc_zeroed(l->made->memory, l->out->word_count, sizeof *l->out->words);
    if (l->out->words == NULL) {
        return fail_memory(l->made, l->out->word_count * sizeof *l->out->words);
    }
    half_writer to = {.words = l->out->words};
    for (uint32_t level = 0; level < l->level_count; ++level) {
        for (size_t i = 0; i < l->made->levels[level].record_count; ++i) {
            const uint32_t *record = l->made->levels[level].words + l->order[level][i].record;
            if (depth - level == 1) {
                put_half(&to, record[0] & 0xff);
            } else if (depth - level == 2) {
                write_bytes(l, record, &to);
            } else {
                write_references(l, level, record, &to);
            }
        }
    }
    return SVO_OK;
}

static svo_status lay_out(const encoder *made, uint32_t level_count, svo_i_dag *out)
{
    layout l = {.made = made, .level_count = level_count, .out = out};
    svo_status status = SVO_OK;
    for (uint32_t level = 0; level < level_count; ++level) {
        SVO_I_TRY_CLEANUP(rank_level(&l, level));
    }
    for (uint32_t level = level_count; level-- > 0;) {
        SVO_I_TRY_CLEANUP(place_level(&l, level));
    }
    SVO_I_TRY_CLEANUP(write_levels(&l));

cleanup:
    for (uint32_t level = 0; level < level_count; ++level) {
        svo_i_free(l.order[level]);
        svo_i_free(l.at[level]);
    }
    return status;
}

/* ---- places of payload ---- */

/* Where the inner nodes are on the way down. */
typedef struct descent {
    uint32_t *places; /* of their payload */
    uint8_t *mirrors; /* as a walk over the records adds them up; NULL: none */
} descent;

/* Gives the children of an inner node their places, in the order of its record. d: the node's own are set. */
static void place_children(const encoder *made, uint32_t node, uint32_t levels, const descent *d, uint32_t *place_of)
{
    const svo_i_dag_nodes *nodes = made->nodes;
    const uint32_t valid = nodes->valid[node];
    const uint32_t leaves = nodes->leaf[node];
    const uint32_t child_own = own_place(nodes, levels - 1);
    const uint32_t mirror = d->mirrors != NULL ? d->mirrors[node] : 0;
    const uint32_t payload = nodes->first_payload[node] - nodes->payload_begin;
    const uint32_t *reference = NULL; /* of the next inner child, if it has a mirror of its own */
    uint32_t place = d->places[node] + own_place(nodes, levels);
    if (d->mirrors != NULL && levels > 2) {
        reference = references_of(made, made->levels[nodes->depth - levels].words + (made->record_of[node] >> 3));
    }
    for (uint32_t stored = 0; stored < 8; ++stored) {
        const uint32_t octant = stored ^ mirror;
        const uint32_t earlier = (1u << octant) - 1;
        if ((valid >> octant & 1) == 0) {
            continue;
        }
        if (child_own != 0) {
            place_of[payload + svo_count_bits(valid & earlier)] = place;
        }
        if ((leaves >> octant & 1) != 0) {
            place += child_own;
            continue;
        }
        const uint32_t inner = nodes->first_inner[node] + svo_count_bits(valid & ~leaves & earlier);
        d->places[inner] = place;
        place += places_of_subtree(made, inner, levels - 1);
        if (d->mirrors != NULL) {
            d->mirrors[inner] = (uint8_t)(mirror ^ (reference != NULL ? *reference++ & 7 : 0));
        }
    }
}

/* Gives each payload its place, from the root on. */
static svo_status place_payload(const encoder *made, uint32_t *place_of)
{
    const svo_i_dag_nodes *nodes = made->nodes;
    const size_t count = nodes->level_begin[nodes->depth];
    svo_status status = SVO_OK;
    descent d = {.places = svo_i_alloc(made->memory, count * sizeof *d.places)};
    d.mirrors = made->mirrored ? svo_i_alloc(made->memory, count) : NULL;
    if (d.places == NULL || (made->mirrored && d.mirrors == NULL)) {
        status = fail_memory(made, count * (sizeof *d.places + (made->mirrored ? 1 : 0)));
        goto cleanup;
    }
    d.places[0] = 0;
    if (d.mirrors != NULL) {
        d.mirrors[0] = 0;
    }
    if (nodes->payload_level == 0) {
        place_of[0] = 0;
    }
    for (uint32_t level = 0; level < nodes->depth; ++level) {
        for (uint32_t node = nodes->level_begin[level]; node < nodes->level_begin[level + 1]; ++node) {
            place_children(made, node, nodes->depth - level, &d, place_of);
        }
    }

cleanup:
    svo_i_free(d.places);
    svo_i_free(d.mirrors);
    return status;
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
    made->known = made->mirrored ? svo_i_alloc_zeroed(made->memory, KNOWN_COUNT, sizeof *made->known) : NULL;
    if (made->mirrored && made->known == NULL) {
        return fail_memory(made, KNOWN_COUNT * sizeof *made->known);
    }
    for (uint32_t level = level_count; level-- > 0;) {
        SVO_I_TRY(encode_level(made, level));
    }
    SVO_I_TRY(made->mirrored ? lay_out(made, level_count, out) : join_levels(made, level_count, out));
    if (made->subtree_places == NULL) {
        return SVO_OK;
    }
    out->place_count = made->subtree_places[0];
    return place_of != NULL ? place_payload(made, place_of) : SVO_OK;
}

svo_status svo_i_dag_encode(const char *function, const svo_i_dag_nodes *nodes, const svo_i_memory *memory,
                            bool mirrored, svo_i_dag *out, uint32_t *place_of, svo_message *message)
{
    encoder made = {.nodes = nodes,
                    .places = nodes->first_payload != NULL,
                    .mirrored = mirrored,
                    .memory = memory,
                    .function = function,
                    .message = message};
    *out = (svo_i_dag){.links = {nodes->depth, nodes->depth - nodes->payload_level}, .link_count = 2};
    if (mirrored) {
        out->link_count = nodes->depth + 1;
    }
    const svo_status status = encode(&made, out, place_of);
    for (uint32_t level = 0; level < SVO_LEVELS_MAX; ++level) {
        svo_i_free(made.levels[level].words);
    }
    svo_i_free(made.record_of);
    svo_i_free(made.subtree_places);
    svo_i_free(made.slots);
    svo_i_free(made.known);
    return status;
}

void svo_i_dag_free(svo_i_dag *dag)
{
    svo_i_free(dag->words);
    *dag = (svo_i_dag){.words = NULL};
}
