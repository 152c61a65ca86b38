/* SPDX-License-Identifier: MIT */
/* Whether the inside of a tree is as the exact reference says: option --solid of verify. */
#ifndef SVOCL_TOOLS_SUPPORT_SOLID_VERDICT_H
#define SVOCL_TOOLS_SUPPORT_SOLID_VERDICT_H

#include "support/build_report.h"
#include "support/solid_check.h"

typedef struct solid_verdict {
    solid_result made; /* none without --solid */
    solid_differences found;
} solid_verdict;

/* Refuses --solid at a depth above SOLID_CHECK_DEPTH_MAX, before anything is built. Returns the exit code, its line
   printed. */
int solid_verdict_check_depth(program *state);

/* Makes the solid that --solid asks for and compares it. tree: downloaded, with SVO_NEED_RAYS. Returns the exit code,
   its line printed. Release the verdict in any case. */
int solid_verdict_find(program *state, const session *opened, const svo_tree *tree, solid_verdict *out);
void solid_verdict_release(solid_verdict *verdict);

/* True without --solid. */
bool solid_verdict_is_exact(const solid_verdict *verdict);
/* The solid's table and what differs; nothing without --solid. */
void solid_verdict_print(const program *state, const solid_verdict *verdict);
void solid_verdict_add_json(cJSON *document, const program *state, const solid_verdict *verdict);

#endif
