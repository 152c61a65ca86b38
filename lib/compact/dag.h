/* SPDX-License-Identifier: MIT */
/*
 * The form "shared" on the host: from nodes to records (kernels/shared/dag.clh) and back. Both need host memory in
 * proportion to the nodes and know neither device nor payload, only where the payload of each node has its place.
 */
#ifndef SVO_LIB_COMPACT_DAG_H
#define SVO_LIB_COMPACT_DAG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/message.h"
#include "svocl/tree.h"

/* Inner nodes in breadth-first order, as svo_i_compact_source has them, in host memory. */
typedef struct svo_i_dag_nodes {
    uint32_t depth;
    uint32_t payload_level; /* the first level with payload */
    uint32_t level_begin[SVO_LEVELS_MAX]; /* level l has the inner nodes level_begin[l] .. level_begin[l + 1] - 1 */
    uint8_t *valid; /* children of each node */
    uint8_t *leaf; /* those that end there; NULL: the children of the nodes of level depth - 1, and no others */
    uint32_t *first_inner; /* the first inner child of each node */
    uint32_t *first_payload; /* the first child's payload, without meaning above payload_level */
} svo_i_dag_nodes;

/* Records. By malloc; released by svo_i_dag_free. */
typedef struct svo_i_dag {
    uint32_t depth;
    uint32_t payload_level;
    bool places; /* numbers for the places of payload are stored */
    uint32_t *words;
    size_t word_count; /* below 2^32 */
    uint64_t record_count; /* different nodes; those of the level above the voxels do not count */
    uint64_t place_count; /* 0 without places */
} svo_i_dag;

/* The nodes that check counts. */
typedef struct svo_i_dag_counts {
    uint64_t inner[SVO_LEVELS_MAX]; /* on each level */
    uint64_t leaf[SVO_LEVELS_MAX];
} svo_i_dag_counts;

/*
 * Makes records of nodes.
 *
 * places: whether records store where payload is. out: receives the records, also after a failure something to free.
 * place_of: receives the place of each payload, in the order of first_payload, which begins with 0; NULL without places.
 * Returns SVO_OUT_OF_HOST_MEMORY, SVO_UNSUPPORTED (2^32 words or more).
 */
svo_status svo_i_dag_encode(const svo_i_dag_nodes *nodes, bool places, svo_i_dag *out, uint32_t *place_of,
                            svo_message *message);

/*
 * Makes nodes of well formed records.
 *
 * nodes: level_begin is set, and the arrays have room for the inner nodes. place_of: as of svo_i_dag_encode.
 * Returns SVO_OUT_OF_HOST_MEMORY.
 */
svo_status svo_i_dag_decode(const svo_i_dag *dag, svo_i_dag_nodes *nodes, uint32_t *place_of, svo_message *message);

/* Whether words are what svo_i_dag_encode makes, as far as reading them needs: every record within the words, on the
   level where its parent looks for it, with the numbers that its subtrees have. Counts the nodes of each level.
   Returns SVO_FILE_DAMAGED with what is wrong, SVO_OUT_OF_HOST_MEMORY. */
svo_status svo_i_dag_check(const svo_i_dag *dag, svo_i_dag_counts *counts, svo_message *message);

void svo_i_dag_free(svo_i_dag *dag);

#endif
