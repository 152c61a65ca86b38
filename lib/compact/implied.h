/* SPDX-License-Identifier: MIT */
/* SVO_FORM_IMPLIED: child masks breadth-first, and a directory. */
#ifndef SVO_LIB_COMPACT_IMPLIED_H
#define SVO_LIB_COMPACT_IMPLIED_H

#include "compact/source.h"

/* Makes nodes, links, bases and payload. compact->info: that of the source. */
svo_status svo_i_implied_make(svo_i_device_work *work, const svo_i_compact_source *source, svo_compact *compact);
/* Sets stored_count and far_count of a tree's form, as exactly as the levels' counts tell. */
void svo_i_implied_count(svo_compact_info *info);

#endif
