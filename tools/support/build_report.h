/* SPDX-License-Identifier: MIT */
/* What a plan, a build and the solid of a mesh took and gave, for people and as JSON. */
#ifndef SVOCL_TOOLS_SUPPORT_BUILD_REPORT_H
#define SVOCL_TOOLS_SUPPORT_BUILD_REPORT_H

#include <stdbool.h>
#include <stdint.h>

#include "support/job.h"
#include "support/json.h"
#include "svocl/plan.h"
#include "svocl/solid.h"

/* The most bytes that this process ever had resident, from /proc; 0: not known. */
uint64_t peak_memory_bytes(void);

/* ---- plans ---- */

/* name: of the input. with_opengl: OpenGL was requested; the lines about the OpenCL front end are then left out. */
void plan_print(const svo_plan *plan, const char *name, bool with_opengl);

/* Adds depth, triangles, refused_triangles, expected_fragments, need[], constant[], stages[], kernels[{name, defines}],
   buffers[{name, bytes, certainty, persistent}], peak_bytes, tree_bytes, left_out[{what, reason}]. */
void plan_add_json(cJSON *document, const svo_plan *plan, bool with_opengl);

/* ---- solids ---- */

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

/* ---- builds ---- */

void report_print(const program *state, const job *done, const char *hash);
cJSON *report_to_json(const program *state, const job *done, const char *hash);

/* One line with the number of refused triangles and the reasons, if there are any; and the same as JSON. */
void report_print_refused(const job *done);
void report_add_refused(cJSON *document, const job *done);

#endif
