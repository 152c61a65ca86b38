/* SPDX-License-Identifier: MIT */
/* Rays and hits as files for `svocl trace`. */
#include "support/ray_table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/number_table.h"

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
