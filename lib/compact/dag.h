/* SPDX-License-Identifier: MIT */
/*
 * The forms "shared" and "mirrored" on the host: from nodes to records (kernels/shared/dag.clh, mirrored.clh). It needs
 * host memory in proportion to the nodes and knows neither device nor payload, only where the payload of each node has
 * its place.
 */
#ifndef SVO_LIB_COMPACT_DAG_H
#define SVO_LIB_COMPACT_DAG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/memory.h"
#include "svocl/tree.h"

/* Inner nodes in breadth-first order, as svo_i_compact_source has them, in host memory. */
typedef struct svo_i_dag_nodes {
    uint32_t depth;
    uint32_t payload_level; /* the first level with payload */
    uint32_t level_begin[SVO_LEVELS_MAX]; /* level l has the inner nodes level_begin[l] .. level_begin[l + 1] - 1 */
    const uint8_t *valid; /* children of each node */
    const uint8_t *leaf; /* those that end there */
    const uint32_t *first_inner; /* the first inner child of each node */
    const uint32_t *first_payload; /* the first child's payload; NULL without places */
    uint32_t payload_begin; /* what first_payload has for the first node that has payload */
} svo_i_dag_nodes;

/* Records, released by svo_i_dag_free. */
typedef struct svo_i_dag {
    uint32_t links[SVO_LEVELS_MAX]; /* as svocl/compact.h says */
    uint32_t link_count;
    uint32_t *words;
    size_t word_count; /* below 2^32; of the form "mirrored" below 2^28 + 1 */
    uint64_t record_count; /* different nodes; those of the level above the voxels do not count */
    uint64_t place_count; /* 0 without places */
} svo_i_dag;

/*
 * Makes records of nodes.
 *
 * function: begins messages. memory: where the words and what is needed meanwhile come from. mirrored: whether nodes
 * whose subtrees are reflections share a record too, in the form "mirrored". out: receives the records, also after a
 * failure something to free. place_of: receives the place of each payload, in the order of first_payload; NULL without
 * places.
 * Returns SVO_OUT_OF_HOST_MEMORY, SVO_UNSUPPORTED (2^32 words or more; mirrored: 2^29 half words).
 */
svo_status svo_i_dag_encode(const char *function, const svo_i_dag_nodes *nodes, const svo_i_memory *memory,
                            bool mirrored, svo_i_dag *out, uint32_t *place_of, svo_message *message);

void svo_i_dag_free(svo_i_dag *dag);

#endif
