/* SPDX-License-Identifier: MIT */
/* E4: level of detail. Table "e4-detail". */
#ifndef SVOCL_TOOLS_ERRORS_E4_DETAIL_H
#define SVOCL_TOOLS_ERRORS_E4_DETAIL_H

#include "measure/suite.h"

extern const suite_subject errors_detail;

#endif
