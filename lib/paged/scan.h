/* SPDX-License-Identifier: MIT */
/* The first and only reading of the whole file. */
#ifndef SVO_LIB_PAGED_SCAN_H
#define SVO_LIB_PAGED_SCAN_H

#include "paged/paged.h"

/* The arrays of the top levels; NULL where there is none. */
typedef struct paged_top {
    uint8_t *arrays[PAGED_ARRAYS]; /* owned. An element for every node, or one for all */
} paged_top;

/* Reads the top levels into top, and of all pages which nodes they have and a checksum. Checks nodes and checksums. */
svo_status svo_i_paged_scan(svo_paged *paged, paged_top *top);

/* The checksum of a page after further bytes of it, which begins with 0. */
uint64_t svo_i_paged_hash(uint64_t hash, const void *bytes, size_t byte_count);

#endif
