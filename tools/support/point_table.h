/* SPDX-License-Identifier: MIT */
/* Points whose light is asked for, from CSV files. */
#ifndef SVOCL_TOOLS_SUPPORT_POINT_TABLE_H
#define SVOCL_TOOLS_SUPPORT_POINT_TABLE_H

#include "support/program.h"
#include "svocl/light_types.h"

typedef struct point_table {
    svo_gather_point *points; /* by malloc */
    size_t count; /* at least 1 */
} point_table;

/* Lines x,y,z,nx,ny,nz; see number_table_read. Returns the exit code. */
int point_table_read(program *state, const char *path, point_table *out);
void point_table_free(point_table *list);

#endif
