/* SPDX-License-Identifier: MIT */
/* The cases, grouped by source file. */
#ifndef SVOCL_TOOLS_STRESS_CASES_H
#define SVOCL_TOOLS_STRESS_CASES_H

#include "stress/stress.h"

/* Cases by builds against the reference, by closed forms and symmetry, by payload and repetition. */
void stress_cases_builds(stress *run);
void stress_cases_forms(stress *run);
void stress_cases_payload(stress *run);

#endif
