/* SPDX-License-Identifier: MIT */
/* Cutting the fragment list into chunks. */
#ifndef SVO_LIB_PLAN_CHUNKING_H
#define SVO_LIB_PLAN_CHUNKING_H

#include "plan/plan_data.h"

SVO_I_SHARED_BEGIN

svo_status svo_i_chunking_create(const svo_plan *plan, uint64_t chunk_bytes, svo_i_chunking *chunking);
/* Replaces a chunking whose chunks were too small by one in which needed[i] fragments of chunk i fit. */
svo_status svo_i_chunking_grow(const svo_plan *plan, uint64_t chunk_bytes, const uint64_t *needed,
                               svo_i_chunking *chunking);
void svo_i_chunking_destroy(svo_i_chunking *chunking);

SVO_I_SHARED_END

#endif
