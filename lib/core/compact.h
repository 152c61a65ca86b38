/* SPDX-License-Identifier: MIT */
/* The fields of a compact tree and the properties of its arrays, for encoders, files and rays. */
#ifndef SVO_LIB_CORE_COMPACT_H
#define SVO_LIB_CORE_COMPACT_H

#include <stdbool.h>

#include "core/memory.h"
#include "core/message.h"
#include "svocl/compact.h"
#include "svocl/plan.h"

/* Payload arrays are the last ones. */
#define SVO_I_PAYLOAD_FIRST SVO_COMPACT_COLORS
#define SVO_I_PAYLOAD_COUNT (SVO_COMPACT_BUFFER_COUNT - SVO_I_PAYLOAD_FIRST)

struct svo_compact {
    svo_compact_info info; /* complete; bounds is 0 */
    svo_device *device; /* NULL: never on a device */
    svo_i_memory memory; /* of the compact tree and its host arrays */
    cl_mem buffers[SVO_COMPACT_BUFFER_COUNT]; /* owned; NULL where absent */
    void *host[SVO_COMPACT_BUFFER_COUNT]; /* in memory, owned; NULL where absent or not downloaded */
    bool downloaded; /* host[] has all arrays */
};

/* What compact trees carry of a tree's needs. */
#define SVO_I_PAYLOAD_NEEDS \
    ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_FILL)

/* The least and the greatest directory_step_log2. */
#define SVO_I_DIRECTORY_LOG2_MIN 4u
#define SVO_I_DIRECTORY_LOG2_MAX 6u

SVO_I_SHARED_BEGIN

/* An empty compact tree without arrays, or NULL when out of memory. Released by svo_compact_destroy. memory: NULL means
   malloc and free. */
svo_compact *svo_i_compact_new(const svo_i_memory *memory);

/* Sets what follows from form, depth, need, constant, payload_level, directory_step_log2, the levels' counts,
   stored_count and far_count: the sums of the counts, payload_count, bytes, total_bytes. */
void svo_i_compact_count(svo_compact_info *info);

/* Whether payload has one element for all nodes, and the bytes of an element of an array. */
bool svo_i_compact_is_constant(const svo_compact_info *info, svo_compact_buffer buffer);
/* Whether an array is packed; info->bytes then has its length, which does not follow from the counts. */
bool svo_i_compact_is_packed(const svo_compact_info *info, svo_compact_buffer buffer);
size_t svo_i_compact_element_bytes(const svo_compact_info *info, svo_compact_buffer buffer);
/* The svo_need bit of a payload array; 0 for others. And the array of a tree that has the same elements. */
uint32_t svo_i_compact_need(svo_compact_buffer buffer);
svo_tree_buffer svo_i_compact_tree_buffer(svo_compact_buffer buffer);
/* Whether some payload has an element per node, which then has a place. */
bool svo_i_compact_has_places(const svo_compact_info *info);

SVO_I_SHARED_END

#endif
