/* SPDX-License-Identifier: MIT */
/* Compact trees for rooms that make them of what is no finished tree. */
#ifndef SVO_LIB_COMPACT_COMPACT_H
#define SVO_LIB_COMPACT_COMPACT_H

#include "core/compact.h"
#include "core/device.h"

/* The options with defaults filled in, or what is wrong with them. function: begins messages. */
svo_status svo_i_compact_options(svo_device *device, const char *function, const svo_compact_options *options,
                                 svo_compact_options *out);

/*
 * Makes what svo_compact_create makes in SVO_FORM_SHARED, without minimize.
 *
 * tree: its host arrays, on no device; payload lies depth-first (svo_i_form_share). asked: from svo_i_compact_options;
 * leave_out names nothing that the tree holds. Returns what svo_compact_create returns.
 */
svo_status svo_i_compact_share(svo_device *device, const char *function, const svo_tree *tree,
                               const svo_compact_options *asked, cl_command_queue queue, svo_compact **out);

#endif
