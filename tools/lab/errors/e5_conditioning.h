/* SPDX-License-Identifier: MIT */
/* E5: ill-conditioned meshes. Table "e5-conditioning". */
#ifndef SVOCL_TOOLS_ERRORS_E5_CONDITIONING_H
#define SVOCL_TOOLS_ERRORS_E5_CONDITIONING_H

#include "measure/suite.h"

extern const suite_subject errors_conditioning;

#endif
