/* SPDX-License-Identifier: MIT */
/* The subjects of `svocl bench`. */
#ifndef SVOCL_TOOLS_SVOCL_SUBJECTS_H
#define SVOCL_TOOLS_SVOCL_SUBJECTS_H

#include "measure/suite.h"

/* In their order; ends with NULL. Those of the group "all" come first, then those of "errors". */
extern const suite_subject *const subjects[];

/* Whether the name asks for any subject. */
bool subjects_know(const char *wanted);

#endif
