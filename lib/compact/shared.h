/* SPDX-License-Identifier: MIT */
/* SVO_FORM_SHARED: nodes with equal subtrees have one record. */
#ifndef SVO_LIB_COMPACT_SHARED_H
#define SVO_LIB_COMPACT_SHARED_H

#include "compact/source.h"

/* Makes nodes, links and payload. compact->info: that of the source. */
svo_status svo_i_shared_make(svo_i_device_work *work, const svo_i_compact_source *source, svo_compact *compact);
/* Sets bounds of stored_count and shared_count by the levels' counts, as if no two subtrees were equal. */
void svo_i_shared_count(svo_compact_info *info);

#endif
