/* SPDX-License-Identifier: MIT */
/* Voxels to trees and files. */
#ifndef SVOCL_TOOLS_BENCH_CONVERT_H
#define SVOCL_TOOLS_BENCH_CONVERT_H

#include "measure/suite.h"

extern const suite_subject bench_convert;

#endif
