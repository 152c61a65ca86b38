/* SPDX-License-Identifier: MIT */
/* The nodes on the device, and the way of a page's nodes to their place there. */
#ifndef SVO_LIB_PAGED_POOL_H
#define SVO_LIB_PAGED_POOL_H

#include "paged/scan.h"

/* Makes the buffers with the top levels, and everything else whose size the layout says. */
svo_status svo_i_paged_make_pool(svo_paged *paged, const paged_top *top);
void svo_i_paged_release_pool(svo_paged *paged);

/* Reads a page, whose place is set, from the file to the stage, which goes to the device before if the page's nodes do
   not follow those of the stage. SVO_FILE_DAMAGED: they are not those of svo_i_paged_scan. */
svo_status svo_i_paged_stage_page(svo_paged *paged, uint32_t page);
/* Writes what is in the stage to the device. */
svo_status svo_i_paged_flush(svo_paged *paged);

/* The table of pages to the device and, with marks, back. */
svo_status svo_i_paged_write_table(svo_paged *paged);
svo_status svo_i_paged_read_table(svo_paged *paged);

#endif
