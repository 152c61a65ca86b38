/* SPDX-License-Identifier: MIT */
/* E7: cones. Tables "e7-cones", "e7-directions" and "e7-alternatives". */
#ifndef SVOCL_TOOLS_ERRORS_E7_CONES_H
#define SVOCL_TOOLS_ERRORS_E7_CONES_H

#include "measure/suite.h"

extern const suite_subject errors_cones;

#endif
