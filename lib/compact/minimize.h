/* SPDX-License-Identifier: MIT */
/*
 * Merges full leaves, before nodes are encoded in any form.
 *
 * Reads: a source.
 * Writes: new arrays of the source, which the work owns; what it had before stays as it is.
 * Needs: options whose tolerances are in their ranges.
 */
#ifndef SVO_LIB_COMPACT_MINIMIZE_H
#define SVO_LIB_COMPACT_MINIMIZE_H

#include "compact/source.h"

/* Makes eight full leaves with the same payload, or within the tolerances, one leaf, on all levels but the root's and,
   where payload is not constant, those above payload_level, which have no place for it. Sets source->info.minimized and
   the levels' counts. */
svo_status svo_i_minimize(svo_i_device_work *work, const svo_compact_options *options, svo_i_compact_source *source);

#endif
