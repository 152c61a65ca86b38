/* SPDX-License-Identifier: MIT */
/* Points from a file, or spread over a mesh. */
#include "support/light_points.h"

#include <stdlib.h>

#include "path/surface_points.h"
#include "support/piped.h"

#define POINTS_MAX 10000000u

int light_points_check(program *state)
{
    const char *path = state->options.points_path;
    if (path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--points FILE is missing");
    }
    return state->piped.name != NULL && piped_is_standard_input(path)
               ? program_fail(state, PROGRAM_WRONG_USAGE, "INPUT and --points both read standard input")
               : PROGRAM_DONE;
}

/* A whole number of points in place of a file; 0: it is none. */
static size_t point_count_of(const char *text)
{
    char *end = NULL;
    const unsigned long count = text[0] >= '0' && text[0] <= '9' ? strtoul(text, &end, 10) : 0;
    return end != NULL && *end == '\0' && count <= POINTS_MAX ? count : 0;
}

bool light_points_are_read(const program *state)
{
    return point_count_of(state->options.points_path) == 0;
}

int light_points_make(program *state, const svo_mesh *mesh, point_table *out)
{
    const size_t count = point_count_of(state->options.points_path);
    if (count == 0) {
        return point_table_read(state, state->options.points_path, out);
    }
    if (mesh == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--points %zu needs a mesh to spread points over", count);
    }
    *out = (point_table){.points = calloc(count, sizeof *out->points), .count = count};
    return out->points != NULL && surface_points(mesh, count, (uint32_t)state->options.seed, out->points)
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_FAILED, "%s: out of memory for %zu points, or no area for them",
                              state->options.input, count);
}
