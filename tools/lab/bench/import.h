/* SPDX-License-Identifier: MIT */
/* Subject "import": mesh files, compared with assimp alone. */
#ifndef SVOCL_TOOLS_BENCH_IMPORT_H
#define SVOCL_TOOLS_BENCH_IMPORT_H

#include "measure/suite.h"

extern const suite_subject bench_import;

#endif
