/* SPDX-License-Identifier: MIT */
/* Packed payload (kernels/shared/packed.clh) on the host: what its head says, and whether words are such an array. */
#ifndef SVO_LIB_CORE_PACKED_H
#define SVO_LIB_CORE_PACKED_H

#include "core/compact.h"

SVO_I_SHARED_BEGIN

/* The length of a packed array, by its head. */
uint64_t svo_i_packed_bytes(const uint32_t *words);
/* Sets largest_error and mean_error of an array to what its head says. */
void svo_i_packed_errors(const uint32_t *words, svo_compact_buffer buffer, svo_compact_info *info);

/* Checks the words of an array, of which there are info->bytes[buffer] bytes: every block is where the one before ends,
   and no element leads outside. name: the file's. Returns SVO_FILE_DAMAGED with what is wrong and where. */
svo_status svo_i_packed_check(const svo_compact *compact, svo_compact_buffer buffer, const char *name,
                              svo_message *message);

/* Writes elements in the array's own layout. words: checked, or made by svo_i_pack_payload. */
void svo_i_packed_read(const uint32_t *words, svo_compact_buffer buffer, uint64_t first, uint64_t count, void *out);

SVO_I_SHARED_END

/* Whether every color's alpha is 255, by an array's first words. */
#define SVO_I_PACKED_ALPHA_WORDS 4
bool svo_i_packed_is_opaque(const uint32_t words[SVO_I_PACKED_ALPHA_WORDS]);

#endif
