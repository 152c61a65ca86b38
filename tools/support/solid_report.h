/* SPDX-License-Identifier: MIT */
/* --solid: fills a tree by the options and reports what its inside is. */
#ifndef SVOCL_TOOLS_SUPPORT_SOLID_REPORT_H
#define SVOCL_TOOLS_SUPPORT_SOLID_REPORT_H

#include "support/job.h"
#include "svocl/solid.h"

typedef struct solid_result {
    svo_compact *solid; /* NULL without --solid */
    svo_solid_info info;
    svo_compact_info form;
    double ms, compile_ms; /* wall clock: of making it, of compiling kernels for it */
} solid_result;

/* Whether --solid is given. */
bool solid_is_wanted(const program *state);
/* The rule that it names. */
svo_solid_rule solid_rule(const program *state);
/* The svo_need bits that a build needs besides, and its result then has. */
uint32_t solid_need(const program *state, uint32_t need);

/* Makes the solid of a tree on the device, unless --solid is missing. Returns the exit code, its line printed. */
int solid_make(program *state, const svo_device *device, const svo_tree *tree, solid_result *out);
void solid_release(solid_result *made);

/* A table with the voxels, and a line where the surface is not closed; nothing without a solid. */
void solid_print(const program *state, const solid_result *made);
/* Adds the object "solid" and returns it; NULL, and nothing is added, without a solid. */
cJSON *solid_add_json(cJSON *document, const program *state, const solid_result *made);

#endif
