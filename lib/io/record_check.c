/* SPDX-License-Identifier: MIT */
/*
 * Whether the words of a file make records of SVO_FORM_SHARED (kernels/shared/dag.clh) or SVO_FORM_MIRRORED
 * (mirrored.clh beside it). Each record is looked at once, whatever the number of its nodes, which are counted along: a
 * small file that would unfold to 2^48 nodes is refused in no time.
 */
#include <stdbool.h>

#include "core/compact.h"
#include "core/message.h"
#include "io/file_format.h"
#include "shared/dag.clh"
#include "shared/mirrored.clh"

/* Records as they lie in a file. */
typedef struct dag_records {
    const char *name; /* of the file, for messages */
    const svo_i_memory *memory; /* for what checking needs */
    const uint32_t *words;
    const uint32_t *links;
    size_t word_count;
    uint32_t depth;
    uint32_t payload_level;
    bool places; /* numbers for the places of payload are stored */
} dag_records;

/* Adds nodes to those of a level. False from 2^32 nodes on. */
static bool add_nodes(svo_i_record_counts *counts, uint32_t level, uint64_t inner, uint64_t leaves)
{
    counts->inner[level] += inner;
    counts->leaf[level] += leaves;
    return counts->inner[level] <= UINT32_MAX && counts->leaf[level] <= UINT32_MAX;
}

/* ---- SVO_FORM_SHARED ---- */

typedef struct dag_check {
    const dag_records *dag;
    svo_message *message;
    uint64_t *node_counts; /* at a record's first word: how many nodes have it; 0 for words that begin none */
    uint64_t *place_counts; /* at a record's first word: the places of its subtree */
    size_t level_words[SVO_LEVELS_MAX]; /* where each level's records begin */
    svo_i_record_counts *counts;
} dag_check;

/* Whether all bits of a record's words that mean nothing are 0. */
static bool is_filled_with_zeros(const dag_check *job, size_t at, uint32_t levels, uint32_t words)
{
    const uint32_t *record = job->dag->words + at;
    const uint32_t masks = record[0] & 0xffff;
    const uint32_t inner = svo_count_bits(masks & 0xff & ~(masks >> 8));
    if (levels <= 2) {
        const uint32_t used = (2 + inner) & 3; /* bytes of the last word; 0: all */
        return used == 0 || record[words - 1] >> 8 * used == 0;
    }
    const uint32_t numbers = svo_shared_number_count(masks, job->dag->places);
    const bool is_odd = (numbers & 1) == 0; /* half words, with that of the masks */
    return levels > SVO_SHARED_SHORT_LEVELS ? record[0] >> 16 == 0 : !is_odd || record[numbers >> 1] >> 16 == 0;
}

static svo_status fail_record(const dag_check *job, size_t at, const char *what)
{
    return svo_i_fail(job->message, SVO_FILE_DAMAGED, "%s: shared record at word %zu: %s", job->dag->name, at, what);
}

/* The words of the record at a word, whose masks must be sound. */
static svo_status measure_record(const dag_check *job, size_t at, uint32_t levels, uint32_t *words)
{
    const uint32_t first = job->dag->words[at];
    const uint32_t masks = first & 0xffff;
    if ((masks & 0xff) == 0 && at > 0) {
        return fail_record(job, at, "it has no children");
    }
    if ((masks >> 8 & ~masks) != 0 || (levels == 1 && masks >> 8 != (masks & 0xff))) {
        return fail_record(job, at, "its leaves are not among its children, or miss some");
    }
    *words = svo_shared_record_words(masks, levels, job->dag->places);
    if (at + *words > job->dag->word_count) {
        return fail_record(job, at, "it ends behind the last word");
    }
    return is_filled_with_zeros(job, at, levels, *words) ? SVO_OK : fail_record(job, at, "an unused bit is not 0");
}

static svo_status count_nodes(dag_check *job, size_t at, uint32_t level, uint64_t inner, uint64_t leaves)
{
    return add_nodes(job->counts, level, inner, leaves)
               ? SVO_OK
               : fail_record(job, at, "its children's level unfolds to 2^32 nodes or more");
}

/* Counts the children of a record on the level below. next: where that level's next new record must be. */
static svo_status count_children(dag_check *job, size_t at, uint32_t levels, uint32_t words, size_t *next)
{
    const uint32_t masks = job->dag->words[at] & 0xffff;
    const uint32_t level = job->dag->depth - levels;
    const uint32_t inner = svo_count_bits(masks & 0xff & ~(masks >> 8));
    const uint64_t nodes = job->node_counts[at];
    SVO_I_TRY(count_nodes(job, at, level + 1, nodes * inner, nodes * svo_count_bits(masks >> 8)));
    for (uint32_t rank = 0; rank < inner && levels == 2; ++rank) {
        const uint32_t mask = job->dag->words[at + ((rank + 2) >> 2)] >> 8 * ((rank + 2) & 3) & 0xff;
        if (mask == 0) {
            return fail_record(job, at, "a child of it has no children");
        }
        SVO_I_TRY(count_nodes(job, at, level + 2, 0, nodes * svo_count_bits(mask)));
    }
    const uint32_t numbers = svo_shared_number_count(masks, job->dag->places);
    for (size_t i = at + svo_shared_children_begin(levels, numbers); i < at + words && levels > 2; ++i) {
        const size_t child = job->dag->words[i];
        uint32_t child_words = 0;
        if (child == *next && child < job->dag->word_count) {
            SVO_I_TRY(measure_record(job, child, levels - 1, &child_words));
            *next += child_words;
        } else if (child > *next || child < job->level_words[level + 1] || job->node_counts[child] == 0) {
            return fail_record(job, at, "a child of it is no record of the next level");
        }
        job->node_counts[child] += nodes;
    }
    return SVO_OK;
}

/* Looks at the records of a level, which must be in the order of their first nodes. */
static svo_status check_level(dag_check *job, uint32_t level)
{
    const uint32_t levels = job->dag->depth - level;
    const size_t end = job->level_words[level + 1];
    size_t next = end;
    for (size_t at = job->level_words[level]; at < end;) {
        uint32_t words = 0;
        SVO_I_TRY(measure_record(job, at, levels, &words));
        SVO_I_TRY(count_children(job, at, levels, words, &next));
        ++job->counts->records;
        at += words;
    }
    job->level_words[level + 2] = next;
    return SVO_OK;
}

/* Counts the places of a record's subtree and compares those that it stores. */
static svo_status check_places(dag_check *job, size_t at, uint32_t levels, uint32_t words)
{
    const dag_records *dag = job->dag;
    const uint32_t payload_levels = dag->depth - dag->payload_level;
    const uint32_t masks = dag->words[at] & 0xffff;
    const uint32_t numbers = svo_shared_number_count(masks, dag->places);
    const uint32_t inner = svo_count_bits(masks & 0xff & ~(masks >> 8));
    const uint32_t *record = dag->words + at;
    uint64_t before = levels == 2 ? svo_shared_places_before(record, 2, payload_levels, 0, inner) : 0;
    for (uint32_t rank = 0; rank < inner && levels > 2; ++rank) {
        if (rank > 0 && svo_shared_places_before(record, levels, payload_levels, 0, rank) != before) {
            return fail_record(job, at, "its numbers are not those of its children");
        }
        before += job->place_counts[record[words - inner + rank]];
    }
    if (levels > 2 && numbers > 0 && numbers == inner &&
        svo_shared_places_before(record, levels, payload_levels, 0, inner) != before) {
        return fail_record(job, at, "its last number is not that of its children");
    }
    job->place_counts[at] =
        before + (levels <= payload_levels ? 1 : 0) + (levels <= payload_levels + 1 ? svo_count_bits(masks >> 8) : 0);
    return SVO_OK;
}

static svo_status check_records(dag_check *job)
{
    const dag_records *dag = job->dag;
    const uint32_t level_count = dag->depth > 1 ? dag->depth - 1 : 1;
    uint32_t words = 0;
    if (dag->word_count == 0) {
        return fail_record(job, 0, "there is none");
    }
    SVO_I_TRY(measure_record(job, 0, dag->depth, &words));
    job->level_words[1] = words;
    job->node_counts[0] = 1;
    job->counts->inner[0] = 1;
    for (uint32_t level = 0; level < level_count; ++level) {
        SVO_I_TRY(check_level(job, level));
    }
    if (job->level_words[level_count] != dag->word_count) {
        return fail_record(job, job->level_words[level_count], "it is the child of none");
    }
    for (uint32_t level = level_count; level-- > 0 && dag->places;) {
        for (size_t at = job->level_words[level]; at < job->level_words[level + 1]; at += words) {
            SVO_I_TRY(measure_record(job, at, dag->depth - level, &words));
            SVO_I_TRY(check_places(job, at, dag->depth - level, words));
        }
    }
    job->counts->places = job->place_counts[0];
    return SVO_OK;
}

/* Checks that each record lies within the words, on the level where its parents look for it, after those of earlier
   nodes, with the numbers that its subtrees have; and counts. */
static svo_status check_dag(const dag_records *records, svo_i_record_counts *counts, svo_message *message)
{
    dag_check job = {.dag = records, .message = message, .counts = counts};
    *counts = (svo_i_record_counts){.records = 0};
    job.node_counts = svo_i_alloc_zeroed(records->memory, records->word_count + 1, sizeof *job.node_counts);
    job.place_counts = svo_i_alloc_zeroed(records->memory, records->word_count + 1, sizeof *job.place_counts);
    const svo_status status =
        job.node_counts != NULL && job.place_counts != NULL
            ? check_records(&job)
            : svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: %zu words need %zu bytes to check", records->name,
                         records->word_count, 2 * records->word_count * sizeof *job.node_counts);
    svo_i_free(job.node_counts);
    svo_i_free(job.place_counts);
    return status;
}

/* ---- SVO_FORM_MIRRORED ---- */

typedef struct mirrored_record {
    uint64_t nodes; /* how many have it */
    uint64_t places; /* of its subtree */
    uint32_t at; /* its first half word */
    uint32_t uses; /* references to it */
    uint32_t first; /* how many other records of the level were referred to before */
} mirrored_record;

typedef struct mirrored_check {
    const dag_records *dag;
    svo_message *message;
    svo_i_record_counts *counts;
    uint32_t half_count;
    uint32_t *index_of; /* at a record's first half word: its index plus 1; 0 elsewhere */
    mirrored_record *records;
    uint32_t level_begin[SVO_LEVELS_MAX]; /* the first record of each level */
} mirrored_check;

static svo_status fail_half(const mirrored_check *job, uint64_t at, const char *what)
{
    (void)svo_i_fail(job->message, SVO_FILE_DAMAGED, "%s: mirrored record at half word %llu: %s", job->dag->name,
                     (unsigned long long)at, what);
    return SVO_FILE_DAMAGED; /* not SVO_OK, as the analyzer sees */
}

static uint32_t half_at(const mirrored_check *job, uint32_t at)
{
    return svo_mirrored_half(job->dag->words, at);
}

/* Finds the end of a record and looks at its masks. end: of its level, or of all. */
static svo_status measure_halves(const mirrored_check *job, uint32_t at, uint32_t levels, uint32_t end, uint32_t *next)
{
    const uint32_t head = half_at(job, at);
    const uint32_t valid = (levels > 2 ? head | head >> 8 : head) & 0xff;
    *next = at + svo_mirrored_record_halves(head, levels, job->dag->places);
    if (valid == 0 && at > 0) {
        return fail_half(job, at, "it has no children");
    }
    if (*next > end) {
        return fail_half(job, at, "it ends behind the last half word of its level");
    }
    const bool is_odd = levels == 1 || (levels == 2 && (svo_count_bits(valid) & 1) == 0);
    return is_odd && half_at(job, *next - 1) >> 8 != 0 ? fail_half(job, at, "an unused bit is not 0") : SVO_OK;
}

/* Finds where the records of a level begin. */
static svo_status find_level(mirrored_check *job, uint32_t level, uint32_t *at, uint32_t *known)
{
    const uint32_t levels = job->dag->depth - level;
    const bool last = levels <= 2;
    const uint32_t end = last ? job->half_count : job->dag->links[levels - 1];
    job->level_begin[level] = *known;
    if ((levels > 1 && job->dag->links[levels] != *at) || end > job->half_count) {
        return svo_i_fail(job->message, SVO_FILE_DAMAGED, "%s: links do not tell where level %u begins and ends",
                          job->dag->name, level);
    }
    while (*at < end) {
        uint32_t next = 0;
        /* Of the last word a half may be free. */
        if (last && *at > 0 && *at + 1 == end && half_at(job, *at) == 0) {
            break;
        }
        SVO_I_TRY(measure_halves(job, *at, levels, end, &next));
        job->index_of[*at] = ++*known;
        *at = next;
        if (level == 0) {
            break;
        }
    }
    job->level_begin[level + 1] = *known;
    return SVO_OK;
}

/* Finds the records of all levels. */
static svo_status find_records(mirrored_check *job, uint32_t level_count)
{
    uint32_t at = 0;
    uint32_t known = 0;
    for (uint32_t level = 0; level < level_count; ++level) {
        SVO_I_TRY(find_level(job, level, &at, &known));
    }
    if (at + 1 < job->half_count || (at < job->half_count && half_at(job, at) != 0)) {
        return fail_half(job, at, "it is the child of none");
    }
    job->counts->records = known;
    job->records = svo_i_alloc_zeroed(job->dag->memory, known, sizeof *job->records);
    if (job->records == NULL) {
        (void)svo_i_fail(job->message, SVO_OUT_OF_HOST_MEMORY, "%s: %u records need %zu bytes to check", job->dag->name,
                         known, known * sizeof *job->records);
        return SVO_OUT_OF_HOST_MEMORY; /* not SVO_OK, as the analyzer sees */
    }
    for (uint32_t half = 0; half < job->half_count; ++half) {
        if (job->index_of[half] != 0) {
            job->records[job->index_of[half] - 1].at = half;
        }
    }
    return SVO_OK;
}

/* The children of a record with two levels below. */
static svo_status count_bytes(mirrored_check *job, const mirrored_record *record, uint32_t level)
{
    const uint32_t children = svo_count_bits(half_at(job, record->at) & 0xff);
    bool few = true;
    for (uint32_t index = 1; index <= children; ++index) {
        const uint32_t mask = svo_mirrored_byte(job->dag->words, record->at, index);
        few = few && add_nodes(job->counts, level + 1, mask != 0 ? record->nodes : 0, mask != 0 ? 0 : record->nodes) &&
              add_nodes(job->counts, level + 2, 0, record->nodes * svo_count_bits(mask));
    }
    return few ? SVO_OK : fail_half(job, record->at, "its children's levels unfold to 2^32 nodes or more");
}

/* Where the references of a record begin. */
static uint32_t references_begin(const mirrored_check *job, const mirrored_record *record, uint32_t levels)
{
    return record->at + 1 + svo_mirrored_number_halves(half_at(job, record->at), levels, job->dag->places);
}

/* Reads the reference at a half word and goes behind it. NULL where it leads to no record of the next level, or has not
   the size that it needs. */
static mirrored_record *follow(const mirrored_check *job, uint32_t levels, bool is_long, uint32_t *at)
{
    const uint32_t level = job->dag->depth - levels;
    uint64_t place = half_at(job, *at) & (SVO_MIRRORED_SHORT_PLACES - 1);
    if (is_long) {
        place |= half_at(job, *at + 1) << 13;
    }
    *at += is_long ? 2 : 1;
    place += job->dag->links[levels - 1];
    if (place >= job->half_count || is_long != (place - job->dag->links[levels - 1] >= SVO_MIRRORED_SHORT_PLACES)) {
        return NULL;
    }
    const uint32_t index = job->index_of[place];
    return index > job->level_begin[level + 1] && index <= job->level_begin[level + 2] ? &job->records[index - 1]
                                                                                       : NULL;
}

/* Counts the children of a record on the level below. known: how many records of that level were referred to. */
static svo_status count_references(mirrored_check *job, const mirrored_record *record, uint32_t level, uint32_t *known)
{
    const uint32_t levels = job->dag->depth - level;
    const uint32_t head = half_at(job, record->at);
    const uint32_t inner = head & 0xff;
    uint32_t at = references_begin(job, record, levels);
    if (!add_nodes(job->counts, level + 1, record->nodes * svo_count_bits(inner),
                   record->nodes * svo_count_bits(head >> 8 & ~inner))) {
        return fail_half(job, record->at, "its children's level unfolds to 2^32 nodes or more");
    }
    for (uint32_t octant = 0; octant < 8; ++octant) {
        if ((inner >> octant & 1) == 0) {
            continue;
        }
        mirrored_record *child = follow(job, levels, (head >> 8 >> octant & 1) != 0, &at);
        if (child == NULL) {
            return fail_half(job, record->at, "a child of it is no record of the next level");
        }
        child->nodes += record->nodes;
        if (child->uses == 0) {
            child->first = (*known)++;
        }
        ++child->uses;
    }
    return SVO_OK;
}

/* The records of a level, whose nodes are counted: their children, and the order of those. */
static svo_status count_level(mirrored_check *job, uint32_t level)
{
    const uint32_t levels = job->dag->depth - level;
    uint32_t known = 0;
    for (uint32_t i = job->level_begin[level]; i < job->level_begin[level + 1]; ++i) {
        const mirrored_record *record = &job->records[i];
        if (levels == 1) {
            (void)add_nodes(job->counts, 1, 0, svo_count_bits(half_at(job, record->at)));
        } else if (levels == 2) {
            SVO_I_TRY(count_bytes(job, record, level));
        } else {
            SVO_I_TRY(count_references(job, record, level, &known));
        }
    }
    for (uint32_t i = job->level_begin[level + 1]; levels > 2 && i < job->level_begin[level + 2]; ++i) {
        const mirrored_record *record = &job->records[i];
        const mirrored_record *before = i > job->level_begin[level + 1] ? record - 1 : NULL;
        if (record->uses == 0) {
            return fail_half(job, record->at, "it is the child of none");
        }
        if (before != NULL &&
            (before->uses < record->uses || (before->uses == record->uses && before->first > record->first))) {
            return fail_half(job, record->at, "it is used more often, or earlier, than the one before it");
        }
    }
    return SVO_OK;
}

/* Counts the places of a record's subtree and compares those that it stores. Those of its children are counted. */
static svo_status count_places(const mirrored_check *job, mirrored_record *record, uint32_t level)
{
    const uint32_t levels = job->dag->depth - level;
    const uint32_t payload_levels = job->dag->depth - job->dag->payload_level;
    const uint32_t head = half_at(job, record->at);
    const uint32_t inner = head & 0xff;
    const uint32_t leaves = head >> 8 & ~inner;
    const uint32_t ended = svo_count_bits(levels > 2 ? leaves : inner);
    const uint32_t numbers = svo_shared_number_count(inner | leaves | leaves << 8, 1);
    uint64_t before = 0;
    for (uint32_t index = 1; levels == 2 && index <= ended; ++index) {
        before += svo_count_bits(svo_mirrored_byte(job->dag->words, record->at, index));
    }
    uint32_t at = levels > 2 ? references_begin(job, record, levels) : 0;
    uint32_t rank = 0;
    for (uint32_t octant = 0; levels > 2 && octant < 8; ++octant) {
        if ((inner >> octant & 1) != 0) {
            const mirrored_record *child = follow(job, levels, (head >> 8 >> octant & 1) != 0, &at);
            before += child != NULL ? child->places : 0;
            ++rank;
            if (rank <= numbers && svo_mirrored_before(job->dag->words, levels, record->at, rank) != before) {
                return fail_half(job, record->at, "its numbers are not those of its children");
            }
        }
    }
    record->places = before + (levels <= payload_levels ? 1 : 0) + (levels <= payload_levels + 1 ? ended : 0);
    return SVO_OK;
}

static svo_status check_mirrored(mirrored_check *job)
{
    const uint32_t level_count = job->dag->depth > 1 ? job->dag->depth - 1 : 1;
    SVO_I_TRY(find_records(job, level_count));
    job->records[0].nodes = 1;
    job->counts->inner[0] = 1;
    for (uint32_t level = 0; level < level_count; ++level) {
        SVO_I_TRY(count_level(job, level));
    }
    for (uint32_t level = level_count; level-- > 0 && job->dag->places;) {
        for (uint32_t i = job->level_begin[level]; i < job->level_begin[level + 1]; ++i) {
            SVO_I_TRY(count_places(job, &job->records[i], level));
        }
    }
    job->counts->places = job->records[0].places;
    return SVO_OK;
}

/* The same as check_dag for the other form: each reference leads to a record of the next level, and has no more bits
   than it needs; records are in the order of their use. */
static svo_status check_half_words(const dag_records *dag, svo_i_record_counts *counts, svo_message *message)
{
    mirrored_check job = {.dag = dag, .message = message, .counts = counts};
    *counts = (svo_i_record_counts){.records = 0};
    if (dag->word_count == 0 || dag->word_count > SVO_MIRRORED_HALVES_MAX / 2) {
        return fail_half(&job, 0, "there is none, or there are 2^29 half words and more");
    }
    job.half_count = (uint32_t)(2 * dag->word_count);
    job.index_of = svo_i_alloc_zeroed(dag->memory, job.half_count, sizeof *job.index_of);
    const svo_status status =
        job.index_of != NULL ? check_mirrored(&job)
                             : svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: %u half words need %zu bytes to check",
                                          dag->name, job.half_count, job.half_count * sizeof *job.index_of);
    svo_i_free(job.index_of);
    svo_i_free(job.records);
    return status;
}

/* ---- both ---- */

svo_status svo_i_records_check(const svo_compact *compact, const char *name, svo_i_record_counts *counts,
                               svo_message *message)
{
    const svo_compact_info *info = &compact->info;
    const dag_records records = {.name = name,
                                 .memory = &compact->memory,
                                 .words = compact->host[SVO_COMPACT_NODES],
                                 .links = compact->host[SVO_COMPACT_LINKS],
                                 .word_count = (size_t)info->stored_count,
                                 .depth = info->depth,
                                 .payload_level = info->payload_level,
                                 .places = svo_i_compact_has_places(info)};
    if (records.links[0] != records.depth || records.links[1] != records.depth - records.payload_level) {
        return svo_i_fail(message, SVO_FILE_DAMAGED, "%s: links are %u and %u", name, (unsigned)records.links[0],
                          (unsigned)records.links[1]);
    }
    return info->form == SVO_FORM_MIRRORED ? check_half_words(&records, counts, message)
                                           : check_dag(&records, counts, message);
}
