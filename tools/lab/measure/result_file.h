/* SPDX-License-Identifier: MIT */
/* Results that an earlier run wrote. */
#ifndef SVOCL_TOOLS_MEASURE_RESULT_FILE_H
#define SVOCL_TOOLS_MEASURE_RESULT_FILE_H

#include "measure/result.h"
#include "support/program.h"

/* Reads a JSON file of results, "-" for standard input. NULL after a failure, which is printed. */
result_set *result_file_read(program *state, const char *path);

#endif
