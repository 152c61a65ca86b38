/* SPDX-License-Identifier: MIT */
/* A table of `svocl bench compact`: how much of a tree SVO_FORM_SHARED stores once, with and without merged leaves. */
#ifndef SVOCL_TOOLS_BENCH_COMPACT_SHARED_H
#define SVOCL_TOOLS_BENCH_COMPACT_SHARED_H

#include "measure/suite.h"

/* Adds the table without rows. */
void compact_shared_begin(suite *all);
/* Adds a row for a tree on the device. Returns what a call of the library returned. */
svo_status compact_shared_run(suite *all, const input *source, const svo_tree *tree);

#endif
