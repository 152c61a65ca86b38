/* SPDX-License-Identifier: MIT */
/* What a build will do: as tables for people and as JSON for scripts. */
#ifndef SVOCL_TOOLS_SUPPORT_PLAN_REPORT_H
#define SVOCL_TOOLS_SUPPORT_PLAN_REPORT_H

#include <stdbool.h>

#include "support/json.h"
#include "svocl/plan.h"

/* input: its name. with_opengl: OpenGL was requested; the lines about the OpenCL front end are then left out. */
void plan_print(const svo_plan *plan, const char *input, bool with_opengl);

/* Adds depth, triangles, refused_triangles, expected_fragments, need[], constant[], stages[], kernels[{name, defines}],
   buffers[{name, bytes, certainty, persistent}], peak_bytes, tree_bytes, left_out[{what, reason}]. */
void plan_add_json(cJSON *document, const svo_plan *plan, bool with_opengl);

#endif
