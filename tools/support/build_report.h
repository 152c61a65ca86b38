/* SPDX-License-Identifier: MIT */
/* What a build did, as a table for people and as JSON for scripts. */
#ifndef SVOCL_TOOLS_SUPPORT_BUILD_REPORT_H
#define SVOCL_TOOLS_SUPPORT_BUILD_REPORT_H

#include "support/job.h"

void report_print(const program *state, const job *done, const char *hash);
cJSON *report_to_json(const program *state, const job *done, const char *hash);

/* One line with the number of refused triangles and the reasons, if there are any; and the same as JSON. */
void report_print_refused(const job *done);
void report_add_refused(cJSON *document, const job *done);

#endif
