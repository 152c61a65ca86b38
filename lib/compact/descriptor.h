/* SPDX-License-Identifier: MIT */
/* SVO_FORM_DESCRIPTOR: words in an order of short distances. */
#ifndef SVO_LIB_COMPACT_DESCRIPTOR_H
#define SVO_LIB_COMPACT_DESCRIPTOR_H

#include "compact/source.h"

/* Makes nodes, links, bases and payload. compact->info: that of the source. */
svo_status svo_i_descriptor_make(svo_i_device_work *work, const svo_i_compact_source *source, svo_compact *compact);
/* Sets stored_count and far_count of a tree's form, as exactly as the levels' counts tell. */
void svo_i_descriptor_count(svo_compact_info *info);

#endif
