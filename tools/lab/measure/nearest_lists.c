/* SPDX-License-Identifier: MIT */
/* Rounds vertices to nearest, half to even, and enumerates the snapped mesh by the reference of those. */
#include "measure/nearest_lists.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

/* A triangle with such a coordinate touches nothing. */
#define UNITS_FAR (1 << 29)

/* Owned arrays. */
typedef struct nearest_mesh {
    int32_t *vertices;
    uint32_t *indices; /* of the triangles whose indices are in range */
    uint32_t *triangle_ids;
    size_t triangle_count;
} nearest_mesh;

static void snap(const svo_mesh *mesh, const svo_tree_info *info, int32_t *vertices)
{
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        const double value = mesh->positions_double != NULL ? mesh->positions_double[i] : (double)mesh->positions[i];
        const double q = rint((value - info->origin[i % 3]) * info->scale);
        vertices[i] = fabs(q) < (double)UNITS_FAR ? (int32_t)q : UNITS_FAR; /* also what is not finite */
    }
}

static void take_triangles(const svo_mesh *mesh, nearest_mesh *out)
{
    for (size_t triangle = 0; triangle < mesh->triangle_count; ++triangle) {
        uint32_t *corners = out->indices + out->triangle_count * 3;
        bool good = true;
        for (size_t k = 0; k < 3; ++k) {
            corners[k] = mesh->indices != NULL ? mesh->indices[triangle * 3 + k] : (uint32_t)(triangle * 3 + k);
            good = good && corners[k] < mesh->vertex_count;
        }
        out->triangle_ids[out->triangle_count] = (uint32_t)triangle;
        out->triangle_count += good;
    }
}

bool nearest_list_pairs(const svo_mesh *mesh, const svo_tree_info *info, oracle_coverage coverage, oracle_pairs *out)
{
    nearest_mesh made = {.vertices = malloc(mesh->vertex_count * 3 * sizeof *made.vertices + 1),
                         .indices = malloc((mesh->triangle_count + 1) * 3 * sizeof *made.indices),
                         .triangle_ids = malloc((mesh->triangle_count + 1) * sizeof *made.triangle_ids)};
    *out = (oracle_pairs){0};
    bool good = made.vertices != NULL && made.indices != NULL && made.triangle_ids != NULL;
    if (good) {
        snap(mesh, info, made.vertices);
        take_triangles(mesh, &made);
        const oracle_mesh snapped = {made.vertices, made.indices, made.triangle_ids, made.triangle_count};
        const oracle_request request = {info->depth, info->snap_bits, coverage, ORACLE_SAT};
        good = oracle_enumerate(&snapped, &request, out);
    }
    free(made.vertices);
    free(made.indices);
    free(made.triangle_ids);
    return good;
}
