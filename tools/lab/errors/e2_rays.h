/* SPDX-License-Identifier: MIT */
/* E2: rays. Tables "e2-rays" and "e2-input". */
#ifndef SVOCL_TOOLS_ERRORS_E2_RAYS_H
#define SVOCL_TOOLS_ERRORS_E2_RAYS_H

#include "measure/suite.h"

extern const suite_subject errors_rays;

#endif
