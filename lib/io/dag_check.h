/* SPDX-License-Identifier: MIT */
/* Whether the records of SVO_FORM_SHARED in a file can be read. */
#ifndef SVO_LIB_IO_DAG_CHECK_H
#define SVO_LIB_IO_DAG_CHECK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/memory.h"
#include "svocl/tree.h"

/* Records as they lie in a file. */
typedef struct svo_i_dag_records {
    const char *name; /* of the file, for messages */
    const svo_i_memory *memory; /* for what checking needs */
    const uint32_t *words;
    size_t word_count;
    uint32_t depth;
    uint32_t payload_level;
    bool places; /* numbers for the places of payload are stored */
} svo_i_dag_records;

/* What records unfold to. */
typedef struct svo_i_dag_counts {
    uint64_t inner[SVO_LEVELS_MAX]; /* inner nodes on each level */
    uint64_t leaf[SVO_LEVELS_MAX]; /* leaves on each level */
    uint64_t records;
    uint64_t places; /* 0 without places */
} svo_i_dag_counts;

/* Checks that each record lies within the words, on the level where its parents look for it, after those of earlier
   nodes, with the numbers that its subtrees have; and counts. Returns SVO_FILE_DAMAGED with what is wrong,
   SVO_OUT_OF_HOST_MEMORY. */
svo_status svo_i_dag_check(const svo_i_dag_records *records, svo_i_dag_counts *counts, svo_message *message);

#endif
