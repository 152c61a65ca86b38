/* SPDX-License-Identifier: MIT */
/* Snaps like a plan, but into floats. */
#include "measure/quantization.h"

#include <math.h>
#include <stdlib.h>

double quantization_source(const svo_mesh *mesh, size_t index)
{
    return mesh->positions_double != NULL ? mesh->positions_double[index] : (double)mesh->positions[index];
}

float *quantization_positions(const svo_mesh *mesh)
{
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL};
    double edge = 0;
    float *positions = calloc(mesh->vertex_count * 3 + 1, sizeof *positions);
    if (positions == NULL) {
        return NULL;
    }
    for (int pass = 0; pass < 2; ++pass) {
        for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
            const double at = quantization_source(mesh, i);
            if (isfinite(at) && pass == 0) {
                low[i % 3] = fmin(low[i % 3], at);
            } else if (isfinite(at)) {
                edge = fmax(edge, at - low[i % 3]);
            }
        }
    }
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        positions[i] =
            (float)rint((quantization_source(mesh, i) - low[i % 3]) * (QUANTIZATION_MAX / (edge > 0 ? edge : 1)));
    }
    return positions;
}

svo_mesh quantization_mesh(const svo_mesh *mesh, const float *positions)
{
    return (svo_mesh){.struct_size = sizeof(svo_mesh),
                      .positions = positions,
                      .vertex_count = mesh->vertex_count,
                      .indices = mesh->indices,
                      .triangle_count = mesh->triangle_count};
}
