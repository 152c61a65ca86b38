/* SPDX-License-Identifier: MIT */
/* The cut of the fragment list into chunks. */
#ifndef SVO_LIB_PLAN_CHUNKING_H
#define SVO_LIB_PLAN_CHUNKING_H

#include "plan/plan_data.h"

SVO_I_SHARED_BEGIN

/* Cuts the list into chunks of at most chunk_bytes, by the fragment estimate. */
svo_status svo_i_chunking_create(const svo_plan *plan, uint64_t chunk_bytes, svo_i_chunking *chunking);
void svo_i_chunking_destroy(svo_i_chunking *chunking);

SVO_I_SHARED_END

/* The limit on chunks: the least of the front end's, the device's and the request's. frontend_bytes: UINT64_MAX where
   no front end is known. */
uint64_t svo_i_chunk_bytes_max(const svo_plan *plan, uint64_t frontend_bytes);
/* Replaces a chunking with chunks that were too small. needed: number of fragments of each chunk. */
svo_status svo_i_chunking_grow(const svo_plan *plan, uint64_t chunk_bytes, const uint64_t *needed,
                               svo_i_chunking *chunking);

#endif
