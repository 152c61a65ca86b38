/* SPDX-License-Identifier: MIT */
/* Payload arrays to packed ones (kernels/shared/packed.clh), on the host. */
#ifndef SVO_LIB_COMPACT_PACKING_H
#define SVO_LIB_COMPACT_PACKING_H

#include "core/compact.h"

/* An array that is packed. */
typedef struct svo_i_packing {
    svo_compact_buffer buffer; /* which payload */
    const void *elements; /* count of them, as the array has them */
    uint64_t count; /* above 0, below 2^32 */
    uint32_t error; /* most that a component may change; of colors alpha does not */
    uint32_t normal_bits; /* of normals: 0, or 4 .. 8 bits for each of two octahedral numbers */
} svo_i_packing;

/*
 * Packs an array. The words are the same on every machine.
 *
 * function: for messages. words: receives them, in memory; the caller frees them, also after a failure.
 * Returns SVO_OUT_OF_HOST_MEMORY, or SVO_UNSUPPORTED where 2^32 words would be needed.
 */
svo_status svo_i_pack_payload(const char *function, const svo_i_packing *what, const svo_i_memory *memory,
                              uint32_t **words, svo_message *message);

#endif
