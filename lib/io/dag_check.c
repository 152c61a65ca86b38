/* SPDX-License-Identifier: MIT */
/*
 * Checks the records of SVO_FORM_SHARED (kernels/shared/dag.clh). Each is looked at once, whatever the number of its
 * nodes, which are counted along: a small file that would unfold to 2^48 nodes is refused in no time.
 */
#include "io/dag_check.h"

#include "shared/dag.clh"

typedef struct check {
    const svo_i_dag_records *dag;
    svo_message *message;
    uint64_t *node_counts; /* at a record's first word: how many nodes have it; 0 for words that begin none */
    uint64_t *place_counts; /* at a record's first word: the places of its subtree */
    size_t level_words[SVO_LEVELS_MAX]; /* where each level's records begin */
    svo_i_dag_counts *counts;
} check;

/* Whether all bits of a record's words that mean nothing are 0. */
static bool is_filled_with_zeros(const check *job, size_t at, uint32_t levels, uint32_t words)
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

static svo_status fail_record(const check *job, size_t at, const char *what)
{
    return svo_i_fail(job->message, SVO_FILE_DAMAGED, "%s: shared record at word %zu: %s", job->dag->name, at, what);
}

/* The words of the record at a word, whose masks must be sound. */
static svo_status measure_record(const check *job, size_t at, uint32_t levels, uint32_t *words)
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

/* Adds nodes to those of a level. */
static svo_status count_nodes(check *job, size_t at, uint32_t level, uint64_t inner, uint64_t leaves)
{
    job->counts->inner[level] += inner;
    job->counts->leaf[level] += leaves;
    return job->counts->inner[level] > UINT32_MAX || job->counts->leaf[level] > UINT32_MAX
               ? fail_record(job, at, "its children's level unfolds to 2^32 nodes or more")
               : SVO_OK;
}

/* Counts the children of a record on the level below. next: where that level's next new record must be. */
static svo_status count_children(check *job, size_t at, uint32_t levels, uint32_t words, size_t *next)
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
static svo_status check_level(check *job, uint32_t level)
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
static svo_status check_places(check *job, size_t at, uint32_t levels, uint32_t words)
{
    const svo_i_dag_records *dag = job->dag;
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

static svo_status check_records(check *job)
{
    const svo_i_dag_records *dag = job->dag;
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

svo_status svo_i_dag_check(const svo_i_dag_records *records, svo_i_dag_counts *counts, svo_message *message)
{
    check job = {.dag = records, .message = message, .counts = counts};
    *counts = (svo_i_dag_counts){.records = 0};
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
