/* SPDX-License-Identifier: MIT */
/* E8: light field probes. Tables "e8-probes", "e8-choices" and "e8-light". */
#ifndef SVOCL_TOOLS_ERRORS_E8_PROBES_H
#define SVOCL_TOOLS_ERRORS_E8_PROBES_H

#include "measure/suite.h"

extern const suite_subject errors_probes;

#endif
