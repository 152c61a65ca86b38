/* SPDX-License-Identifier: MIT */
/* E3: attributes. Table "e3-attributes". */
#ifndef SVOCL_TOOLS_ERRORS_E3_ATTRIBUTES_H
#define SVOCL_TOOLS_ERRORS_E3_ATTRIBUTES_H

#include "measure/suite.h"

extern const suite_subject errors_attributes;

#endif
