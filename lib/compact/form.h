/* SPDX-License-Identifier: MIT */
/*
 * The forms of a compact tree: who makes the nodes, and how kernels read them.
 *
 * The room, each file after those that it uses:
 *   source          what encoders read: a tree's nodes, or those of a minimized one
 *   dag             records of the form "shared", on the host
 *   form            this: the forms
 *   packing_blocks  how a block of packed payload is coded
 *   packing         payload arrays to packed ones, on the host
 *   compact         plan, creation, expansion
 *   pack            payload of a compact tree packed, and read on the host
 *   rays            rays through compact trees, pictures, the caller's kernels
 */
#ifndef SVO_LIB_COMPACT_FORM_H
#define SVO_LIB_COMPACT_FORM_H

#include "compact/source.h"

/* The options that select a form's reader in kernels/rays/read.clh, for any kernel; a static string. */
const char *svo_i_form_defines(const svo_compact_info *info);
/* The same as a whole: the options for the caller's kernels. */
const char *svo_i_form_options(const svo_compact_info *info);
/* What stored_count and far_count will be, before payload and links are counted: exact, or bounds. */
void svo_i_form_count(svo_compact_info *info);

/* Makes the nodes, links, bases and payload of the form in the source's info. compact->info: that of the source. */
svo_status svo_i_form_make(svo_i_device_work *work, const svo_i_compact_source *source, svo_compact *compact);
/* The same in SVO_FORM_SHARED, of a tree's host arrays, where payload lies depth-first: a node's before those of its
   children's subtrees, one after the other. That is the order of this form. compact->info: of the tree. */
svo_status svo_i_form_share(svo_i_device_work *work, const svo_tree *tree, svo_compact *compact);

#endif
