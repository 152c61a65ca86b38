/* SPDX-License-Identifier: MIT */
/* Tables of numbers as text, and the records of queries made of them. */
#include "support/query_table.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- tables of numbers ---- */

#define LINE_BYTES 1024
#define FIELDS_MAX 16

typedef struct number_form {
    size_t fields; /* numbers of a line, at most 16 */
    const char *line; /* what messages call a line: "ox,oy,oz,dx,dy,dz" */
    const char *noun; /* and what it stands for: "ray" */
} number_form;

typedef struct number_table {
    float *numbers; /* row by row, by malloc */
    size_t row_count; /* at least 1 */
} number_table;

/* A number with optional white space around it; false if there is none. */
static bool read_number(const char **text, float *out)
{
    char *end = NULL;
    const double number = strtod(*text, &end);
    if (end == *text) {
        return false;
    }
    while (*end == ' ' || *end == '\t' || *end == '\r' || *end == '\n') {
        ++end;
    }
    *text = end;
    *out = (float)number;
    return true;
}

/* Comma-separated numbers, at most limit; returns how many, 0 if anything else is among them. */
static size_t number_table_parse(const char *text, float *numbers, size_t limit)
{
    size_t count = 0;
    while (count < limit && read_number(&text, &numbers[count])) {
        ++count;
        if (*text == '\0') {
            return count;
        }
        if (*text != ',') {
            return 0;
        }
        ++text;
    }
    return 0;
}

static bool is_blank(const char *text)
{
    while (isspace((unsigned char)*text)) {
        ++text;
    }
    return *text == '\0';
}

static bool append(number_table *table, size_t *capacity, const float *numbers, size_t fields)
{
    if (table->row_count == *capacity) {
        const size_t larger = *capacity * 2 + 1024;
        float *grown = realloc(table->numbers, larger * fields * sizeof *grown);
        if (grown == NULL) {
            return false;
        }
        table->numbers = grown;
        *capacity = larger;
    }
    memcpy(table->numbers + fields * table->row_count++, numbers, fields * sizeof *numbers);
    return true;
}

static int read_lines(program *state, const char *path, FILE *file, const number_form *form, number_table *out)
{
    char line[LINE_BYTES];
    size_t capacity = 0;
    for (size_t number = 1; fgets(line, sizeof line, file) != NULL; ++number) {
        float numbers[FIELDS_MAX];
        const char *first = line;
        if (is_blank(line) || (number == 1 && !read_number(&first, numbers))) {
            continue;
        }
        if (number_table_parse(line, numbers, form->fields) != form->fields) {
            return program_fail(state, PROGRAM_FAILED, "%s:%zu: not %s", path, number, form->line);
        }
        if (!append(out, &capacity, numbers, form->fields)) {
            return program_fail(state, PROGRAM_FAILED, "%s: out of memory for %zu %ss", path, out->row_count,
                                form->noun);
        }
    }
    return ferror(file) == 0 ? PROGRAM_DONE : program_fail(state, PROGRAM_FAILED, "%s: %s", path, strerror(errno));
}

static void number_table_free(number_table *table)
{
    free(table->numbers);
    *table = (number_table){0};
}

/* Reads a file or, for "-", standard input. A first line that does not begin with a number is a heading; empty lines
   are skipped. Any other line is an error that names it. Returns the exit code. */
static int number_table_read(program *state, const char *path, const number_form *form, number_table *out)
{
    *out = (number_table){0};
    const bool standard = piped_is_standard_input(path);
    const char *name = standard ? "standard input" : path;
    FILE *file = standard ? stdin : fopen(path, "r");
    if (file == NULL) {
        return program_fail(state, PROGRAM_FAILED, "%s: %s", name, strerror(errno));
    }
    int exit_code = read_lines(state, name, file, form, out);
    if (!standard) {
        fclose(file);
    }
    if (exit_code == PROGRAM_DONE && out->row_count == 0) {
        exit_code = program_fail(state, PROGRAM_FAILED, "%s: no %s; a line is %s", name, form->noun, form->line);
    }
    if (exit_code != PROGRAM_DONE) {
        number_table_free(out);
    }
    return exit_code;
}

/* ---- rays and hits ---- */

#define FIELDS         6
#define CAMERA_NUMBERS 10

static svo_ray make_ray(const float numbers[FIELDS])
{
    svo_ray ray = {.t_min = 0, .t_max = INFINITY};
    memcpy(ray.origin, numbers, sizeof ray.origin);
    memcpy(ray.direction, numbers + 3, sizeof ray.direction);
    return ray;
}

int ray_table_read(program *state, const char *path, ray_table *out)
{
    static const number_form form = {.fields = FIELDS, .line = "ox,oy,oz,dx,dy,dz", .noun = "ray"};
    number_table read;
    *out = (ray_table){0};
    int exit_code = number_table_read(state, path, &form, &read);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    out->rays = calloc(read.row_count, sizeof *out->rays);
    for (size_t i = 0; i < read.row_count && out->rays != NULL; ++i) {
        out->rays[out->count++] = make_ray(read.numbers + FIELDS * i);
    }
    if (out->rays == NULL) {
        exit_code = program_fail(state, PROGRAM_FAILED, "%s: out of memory for %zu rays", path, read.row_count);
    }
    number_table_free(&read);
    return exit_code;
}

void ray_table_free(ray_table *list)
{
    free(list->rays);
    *list = (ray_table){0};
}

bool ray_table_parse_camera(const char *text, const svo_camera *framed, svo_camera *out)
{
    float numbers[CAMERA_NUMBERS] = {0, 0, 0, 0, 0, 0, 0, 1, 0, 32};
    if (strcmp(text, "auto") == 0) {
        *out = *framed;
        return true;
    }
    const size_t count = number_table_parse(text, numbers, CAMERA_NUMBERS);
    if (count != 6 && count != 9 && count != 10) {
        return false;
    }
    memcpy(out->eye, numbers, sizeof out->eye);
    memcpy(out->target, numbers + 3, sizeof out->target);
    memcpy(out->up, numbers + 6, sizeof out->up);
    out->vertical_fov = numbers[9] * 0.017453293f;
    return true;
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void normalize(double vector[3])
{
    const double length = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
    for (int axis = 0; axis < 3; ++axis) {
        vector[axis] /= length;
    }
}

camera_axes ray_table_axes(const svo_camera *camera)
{
    camera_axes axes;
    double up[3];
    for (int axis = 0; axis < 3; ++axis) {
        axes.forward[axis] = (double)camera->target[axis] - (double)camera->eye[axis];
        up[axis] = (double)camera->up[axis];
    }
    normalize(axes.forward);
    cross(axes.forward, up, axes.right);
    normalize(axes.right);
    cross(axes.right, axes.forward, axes.up);
    return axes;
}

int ray_table_from_camera(program *state, const svo_camera *camera, uint32_t width, uint32_t height,
                          const double place[2], ray_table *out)
{
    const double column = place != NULL ? place[0] : 0.5;
    const double row = place != NULL ? place[1] : 0.5;
    const double tangent = tan(0.5 * (double)camera->vertical_fov);
    const camera_axes axes = ray_table_axes(camera);
    *out = (ray_table){.count = (size_t)width * height};
    out->rays = calloc(out->count, sizeof *out->rays);
    if (out->rays == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for %ux%u rays", width, height);
    }
    for (size_t i = 0; i < out->count; ++i) {
        const double across = (2.0 * ((double)(i % width) + column) / width - 1.0) * tangent * width / height;
        const double upwards = (1.0 - 2.0 * ((double)(i / width) + row) / height) * tangent; /* NOLINT: a row */
        out->rays[i] = (svo_ray){.t_min = 0, .t_max = INFINITY};
        for (int axis = 0; axis < 3; ++axis) {
            out->rays[i].origin[axis] = camera->eye[axis];
            out->rays[i].direction[axis] =
                (float)(axes.forward[axis] + across * axes.right[axis] + upwards * axes.up[axis]);
        }
    }
    return PROGRAM_DONE;
}

void ray_table_write_hits(output_file *file, const svo_hit *hits, size_t count)
{
    static const char heading[] = "ray,t,triangle,u,v\n";
    char line[128];
    output_write(file, heading, sizeof heading - 1);
    for (size_t i = 0; i < count; ++i) {
        const svo_hit *hit = &hits[i];
        const int length = hit->triangle == SVO_NO_TRIANGLE
                               ? snprintf(line, sizeof line, "%zu,inf,-1,0,0\n", i)
                               : snprintf(line, sizeof line, "%zu,%.9g,%lu,%.9g,%.9g\n", i, (double)hit->t,
                                          (unsigned long)hit->triangle, (double)hit->u, (double)hit->v);
        output_write(file, line, (size_t)length);
    }
}

void ray_table_write_voxel_hits(output_file *file, const svo_voxel_hit *hits, size_t count)
{
    static const char heading[] = "ray,t,level,face\n";
    char line[96];
    output_write(file, heading, sizeof heading - 1);
    for (size_t i = 0; i < count; ++i) {
        const svo_voxel_hit *hit = &hits[i];
        const int length = isinf(hit->t) ? snprintf(line, sizeof line, "%zu,inf,-1,-1\n", i)
                                         : snprintf(line, sizeof line, "%zu,%.9g,%lu,%lu\n", i, (double)hit->t,
                                                    (unsigned long)hit->level, (unsigned long)hit->face);
        output_write(file, line, (size_t)length);
    }
}

/* ---- points ---- */

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
