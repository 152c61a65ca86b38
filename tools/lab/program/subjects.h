/* SPDX-License-Identifier: MIT */
/* The subjects of `svocl bench`. */
#ifndef SVOCL_TOOLS_PROGRAM_SUBJECTS_H
#define SVOCL_TOOLS_PROGRAM_SUBJECTS_H

#include "measure/suite.h"

/* In order of execution; ends with NULL. The group "all" comes first, then the group "errors". */
extern const suite_subject *const subjects[];

/* Whether the name is a subject or a group of subjects. */
bool subjects_know(const char *wanted);

#endif
