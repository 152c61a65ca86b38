/* SPDX-License-Identifier: MIT */
/* Makes what a mesh lacks. */
#include "measure/vertex_attributes.h"

#include <math.h>
#include <stdlib.h>

#include "measure/quantization.h"

/* One channel per axis. */
static void color_by_position(const svo_mesh *mesh, uint8_t *colors)
{
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL};
    double high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        const double at = quantization_source(mesh, i);
        low[i % 3] = isfinite(at) ? fmin(low[i % 3], at) : low[i % 3];
        high[i % 3] = isfinite(at) ? fmax(high[i % 3], at) : high[i % 3];
    }
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        const double share = (quantization_source(mesh, i) - low[i % 3]) / (high[i % 3] - low[i % 3]);
        colors[i / 3 * 4 + i % 3] = isfinite(share) ? (uint8_t)(255.0 * share) : 0;
        colors[i / 3 * 4 + 3] = 255;
    }
}

static void add_triangle(const svo_mesh *mesh, const size_t corners[3], double *sums)
{
    double edges[2][3];
    for (size_t axis = 0; axis < 3; ++axis) {
        const double first = quantization_source(mesh, 3 * corners[0] + axis);
        edges[0][axis] = quantization_source(mesh, 3 * corners[1] + axis) - first;
        edges[1][axis] = quantization_source(mesh, 3 * corners[2] + axis) - first;
    }
    for (size_t axis = 0; axis < 3; ++axis) {
        const size_t u = (axis + 1) % 3;
        const size_t v = (axis + 2) % 3;
        const double normal = edges[0][u] * edges[1][v] - edges[0][v] * edges[1][u];
        for (size_t corner = 0; corner < 3 && isfinite(normal); ++corner) {
            sums[3 * corners[corner] + axis] += normal;
        }
    }
}

static void sum_normals(const svo_mesh *mesh, double *sums, float *normals)
{
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        size_t corners[3];
        bool in_range = true;
        for (size_t corner = 0; corner < 3; ++corner) {
            corners[corner] = mesh->indices != NULL ? mesh->indices[3 * t + corner] : 3 * t + corner;
            in_range = in_range && corners[corner] < mesh->vertex_count;
        }
        if (in_range) {
            add_triangle(mesh, corners, sums);
        }
    }
    for (size_t v = 0; v < mesh->vertex_count; ++v) {
        const double *sum = sums + 3 * v;
        const double length = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
        for (size_t axis = 0; axis < 3; ++axis) {
            normals[3 * v + axis] = length > 0 ? (float)(sum[axis] / length) : axis == 1 ? 1.0F : 0.0F;
        }
    }
}

bool vertex_attributes_create(const svo_mesh *mesh, vertex_attributes *out)
{
    const size_t vertices = mesh->vertex_count + 1; /* calloc of nothing may be NULL */
    double *sums = mesh->normals == NULL ? calloc(vertices * 3, sizeof *sums) : NULL;
    *out = (vertex_attributes){.mesh = *mesh,
                               .colors = mesh->colors == NULL ? calloc(vertices * 4, 1) : NULL,
                               .normals = mesh->normals == NULL ? calloc(vertices * 3, sizeof(float)) : NULL};
    if ((mesh->colors == NULL && out->colors == NULL) ||
        (mesh->normals == NULL && (out->normals == NULL || sums == NULL))) {
        free(sums);
        vertex_attributes_free(out);
        return false;
    }
    if (out->colors != NULL) {
        color_by_position(mesh, out->colors);
    }
    if (out->normals != NULL) {
        sum_normals(mesh, sums, out->normals);
    }
    free(sums);
    out->mesh = (svo_mesh){.struct_size = sizeof out->mesh,
                           .positions = mesh->positions,
                           .positions_double = mesh->positions_double,
                           .vertex_count = mesh->vertex_count,
                           .indices = mesh->indices,
                           .triangle_count = mesh->triangle_count,
                           .colors = out->colors != NULL ? out->colors : mesh->colors,
                           .normals = out->normals != NULL ? out->normals : mesh->normals};
    return true;
}

void vertex_attributes_free(vertex_attributes *made)
{
    free(made->colors);
    free(made->normals);
    *made = (vertex_attributes){.colors = NULL};
}
