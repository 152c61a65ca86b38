/* SPDX-License-Identifier: MIT */
/* How many bytes go to what. */
#ifndef SVO_LIB_PAGED_LAYOUT_H
#define SVO_LIB_PAGED_LAYOUT_H

#include "paged/paged.h"

/* Chooses the top level for a number of bytes, and sets what follows from it but capacities and bytes. */
void svo_i_paged_choose(svo_paged *paged, uint32_t page_levels, uint64_t budget_bytes);

/* Sets capacities and bytes, when the largest page is known. SVO_CAPACITY_EXCEEDED: budget_bytes are too few. */
svo_status svo_i_paged_fit(svo_paged *paged, uint64_t budget_bytes);

#endif
