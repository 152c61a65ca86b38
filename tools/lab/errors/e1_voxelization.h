/* SPDX-License-Identifier: MIT */
/* E1: voxelization. Table "e1-voxelization". */
#ifndef SVOCL_TOOLS_ERRORS_E1_VOXELIZATION_H
#define SVOCL_TOOLS_ERRORS_E1_VOXELIZATION_H

#include "measure/suite.h"

extern const suite_subject errors_voxelization;

#endif
