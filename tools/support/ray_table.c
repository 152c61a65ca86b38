/* SPDX-License-Identifier: MIT */
/* Rays and hits as files for `svocl trace`. */
#include "support/ray_table.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LINE_BYTES     1024
#define FIELDS         6
#define CAMERA_NUMBERS 10

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
static size_t read_numbers(const char *text, float *numbers, size_t limit)
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

static svo_ray make_ray(const float numbers[FIELDS])
{
    svo_ray ray = {.t_min = 0, .t_max = INFINITY};
    memcpy(ray.origin, numbers, sizeof ray.origin);
    memcpy(ray.direction, numbers + 3, sizeof ray.direction);
    return ray;
}

static bool append(ray_table *list, size_t *capacity, const svo_ray *ray)
{
    if (list->count == *capacity) {
        const size_t larger = *capacity * 2 + 1024;
        svo_ray *rays = realloc(list->rays, larger * sizeof *rays);
        if (rays == NULL) {
            return false;
        }
        list->rays = rays;
        *capacity = larger;
    }
    list->rays[list->count++] = *ray;
    return true;
}

static int read_lines(program *state, const char *path, FILE *file, ray_table *out)
{
    char line[LINE_BYTES];
    size_t capacity = 0;
    for (size_t number = 1; fgets(line, sizeof line, file) != NULL; ++number) {
        float numbers[FIELDS];
        const char *first = line;
        if (is_blank(line) || (number == 1 && !read_number(&first, numbers))) {
            continue;
        }
        if (read_numbers(line, numbers, FIELDS) != FIELDS) {
            return program_fail(state, PROGRAM_FAILED, "%s:%zu: not ox,oy,oz,dx,dy,dz", path, number);
        }
        const svo_ray ray = make_ray(numbers);
        if (!append(out, &capacity, &ray)) {
            return program_fail(state, PROGRAM_FAILED, "%s: out of memory for %zu rays", path, out->count);
        }
    }
    return ferror(file) == 0 ? PROGRAM_DONE : program_fail(state, PROGRAM_FAILED, "%s: %s", path, strerror(errno));
}

int ray_table_read(program *state, const char *path, ray_table *out)
{
    *out = (ray_table){0};
    const bool standard = piped_is_standard_input(path);
    const char *name = standard ? "standard input" : path;
    FILE *file = standard ? stdin : fopen(path, "r");
    if (file == NULL) {
        return program_fail(state, PROGRAM_FAILED, "%s: %s", name, strerror(errno));
    }
    int exit_code = read_lines(state, name, file, out);
    if (!standard) {
        fclose(file);
    }
    if (exit_code == PROGRAM_DONE && out->count == 0) {
        exit_code = program_fail(state, PROGRAM_FAILED, "%s: no ray; a line is ox,oy,oz,dx,dy,dz", name);
    }
    if (exit_code != PROGRAM_DONE) {
        ray_table_free(out);
    }
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
    const size_t count = read_numbers(text, numbers, CAMERA_NUMBERS);
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

int ray_table_from_camera(program *state, const svo_camera *camera, uint32_t width, uint32_t height, ray_table *out)
{
    const double tangent = tan(0.5 * (double)camera->vertical_fov);
    const camera_axes axes = ray_table_axes(camera);
    *out = (ray_table){.count = (size_t)width * height};
    out->rays = calloc(out->count, sizeof *out->rays);
    if (out->rays == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for %ux%u rays", width, height);
    }
    for (size_t i = 0; i < out->count; ++i) {
        const double across = (2.0 * ((double)(i % width) + 0.5) / width - 1.0) * tangent * width / height;
        const double upwards = (1.0 - 2.0 * ((double)(i / width) + 0.5) / height) * tangent; /* NOLINT: a row */
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
