/* SPDX-License-Identifier: MIT */
/* Records of points from tables of numbers. */
#include "support/point_table.h"

#include <stdlib.h>
#include <string.h>

#include "support/number_table.h"

#define FIELDS 6

int point_table_read(program *state, const char *path, point_table *out)
{
    static const number_form form = {.fields = FIELDS, .line = "x,y,z,nx,ny,nz", .noun = "point"};
    number_table read;
    *out = (point_table){0};
    int exit_code = number_table_read(state, path, &form, &read);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    out->points = calloc(read.row_count, sizeof *out->points);
    for (size_t i = 0; i < read.row_count && out->points != NULL; ++i) {
        svo_gather_point *point = &out->points[out->count++];
        memcpy(point->position, read.numbers + FIELDS * i, sizeof point->position);
        memcpy(point->normal, read.numbers + FIELDS * i + 3, sizeof point->normal);
    }
    if (out->points == NULL) {
        exit_code = program_fail(state, PROGRAM_FAILED, "%s: out of memory for %zu points", path, read.row_count);
    }
    number_table_free(&read);
    return exit_code;
}

void point_table_free(point_table *list)
{
    free(list->points);
    *list = (point_table){0};
}
