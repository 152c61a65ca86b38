/* SPDX-License-Identifier: MIT */
/* Compact trees by --tree-form, --minimize, --directory-step, --color-error and --normal-bits: made from trees, or as
   they are in a .svc file. */
#ifndef SVOCL_TOOLS_SUPPORT_TREE_FORM_H
#define SVOCL_TOOLS_SUPPORT_TREE_FORM_H

#include <stdbool.h>

#include "support/job.h"
#include "support/json.h"
#include "support/session.h"
#include "svocl/compact.h"

struct table;

/* What the options ask for, where they have --tree-form. */
svo_compact_options tree_form_options(const options *given);

/* Whether a compact tree is what is asked for, so that it is taken as it is. */
bool tree_form_fits(const svo_compact *compact, const svo_compact_options *asked);

/* Whether it can stay where other payload than packed is wanted, or packed in another way. */
bool tree_form_is_plain(const svo_compact *compact);

/* Puts one with packed payload in its place where --color-error or --normal-bits ask for it. Returns the exit code. */
int tree_form_pack(program *state, const session *opened, svo_compact **compact);

/* Whether a compact tree of a file is all that the options ask for, or can become it by tree_form_pack. */
bool tree_form_keeps(const program *state, const svo_compact *compact);

/* Makes what the options ask for of a tree, on the device; a step of the progress bar. Returns the exit code. */
int tree_form_make(program *state, const session *opened, const svo_tree *tree, svo_compact **out);

/* Makes it of a compact tree on the device, which it replaces unless that fits; the same step. */
int tree_form_change(program *state, const session *opened, svo_compact **compact);

/* INPUT, a .svc file, on the device and on the host, in the form of --tree-form if there is one. Begins the progress
   bar, as job_load does, and opens the session of done, which has no tree. Returns the exit code; on failure nothing is
   left to release. */
int tree_form_load(program *state, unsigned further_steps, job *done, svo_compact **out);

/* With --tree-form: makes the form of the tree of done, on the device and on the host, and destroys the tree. Else *out
   is NULL. Returns the exit code. */
int tree_form_take(program *state, job *done, svo_compact **out);

/* What a compact tree is, as cells of a table's rows of two, and as the object "compact". */
void tree_form_add_rows(struct table *rows, const svo_compact *compact);
void tree_form_add_json(cJSON *document, const svo_compact *compact);

#endif
