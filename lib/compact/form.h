/* SPDX-License-Identifier: MIT */
/* The forms of a compact tree: who makes the nodes, and how kernels read them. */
#ifndef SVO_LIB_COMPACT_FORM_H
#define SVO_LIB_COMPACT_FORM_H

#include "compact/source.h"

/* The default of directory_step_log2, below 0.40 bytes a leaf on measured scenes. */
#define SVO_I_DIRECTORY_LOG2 5u

/* The options that select a form's reader in kernels/rays/read.clh, for any kernel; a static string. */
const char *svo_i_form_defines(const svo_compact_info *info);
/* The same as a whole: the options for the caller's kernels. */
const char *svo_i_form_options(const svo_compact_info *info);
/* Bytes of svo_expanded in kernels/compact/expand.cl. */
size_t svo_i_form_expanded_bytes(svo_form form);
/* What stored_count and far_count will be, before payload and links are counted: exact, or bounds. */
void svo_i_form_count(svo_compact_info *info);

/* Makes the nodes, links, bases and payload of the form in the source's info. compact->info: that of the source. */
svo_status svo_i_form_make(svo_i_device_work *work, const svo_i_compact_source *source, svo_compact *compact);

#endif
