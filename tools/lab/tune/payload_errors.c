/* SPDX-License-Identifier: MIT */
/* Parts of triangles in voxels are those of the reference (oracle_part), in double. */
#include "tune/payload_errors.h"

#include <math.h>
#include <string.h>

#include "path/albedo.h"
#include "reference/oracle.h"
#include "scenes/maths.h"
#include "support/info_of.h"
#include "tune/delta_e.h"

#define LEAST_AREA   1e-6 /* of a voxel's face: below it, surface only touches the voxel */
#define LEAST_LENGTH 0.05 /* of a mean normal with a direction */
#define DEGREES      (180 / 3.14159265358979323846)

/* Sums over the surface in a voxel. */
typedef struct surface_mean {
    double area, alpha;
    double color[3], normal[3];
} surface_mean;

static size_t corner_of(const svo_mesh *mesh, size_t triangle, size_t corner)
{
    return mesh->indices != NULL ? mesh->indices[3 * triangle + corner] : 3 * triangle + corner;
}

/* In voxels, from the corner of a cell. */
static void open_triangle(const svo_mesh *mesh, const svo_tree_info *info, const uint32_t cell[3], size_t triangle,
                          double out[3][3])
{
    for (size_t i = 0; i < 9; ++i) {
        const size_t at = 3 * corner_of(mesh, triangle, i / 3) + i % 3;
        const double x = mesh->positions_double != NULL ? mesh->positions_double[at] : (double)mesh->positions[at];
        out[i / 3][i % 3] = ldexp((x - info->origin[i % 3]) / info->edge, (int)info->depth) - (double)cell[i % 3];
    }
}

static vector3 normal_of(const svo_mesh *mesh, size_t triangle, const double corners[3][3], const double weights[3])
{
    vector3 sum = vector(0, 0, 0);
    for (size_t i = 0; i < 3 && mesh->normals != NULL; ++i) {
        const float *own = mesh->normals + 3 * corner_of(mesh, triangle, i);
        const vector3 at = vector((double)own[0], (double)own[1], (double)own[2]);
        const double length = vector_length(at);
        sum = length > 0 && isfinite(length) ? vector_add(sum, vector_scale(at, weights[i] / length)) : sum;
    }
    if (vector_length(sum) > 0) {
        return vector_normalize(sum);
    }
    const vector3 first = vector(corners[0][0], corners[0][1], corners[0][2]);
    return vector_normalize(vector_cross(vector_subtract(vector(corners[1][0], corners[1][1], corners[1][2]), first),
                                         vector_subtract(vector(corners[2][0], corners[2][1], corners[2][2]), first)));
}

/* The part of a triangle in one eighth of the voxel. */
static void add_part(const svo_mesh *mesh, size_t triangle, const double corners[3][3], unsigned octant,
                     surface_mean *mean)
{
    double moved[3][3];
    double centroid[3];
    double weights[3];
    double albedo[3];
    for (unsigned i = 0; i < 9; ++i) {
        moved[i / 3][i % 3] = corners[i / 3][i % 3] - 0.5 * (double)(octant >> i % 3 & 1u);
    }
    const double area = oracle_part(moved, 0.5, centroid) / 4;
    if (!(area > 0)) {
        return;
    }
    oracle_corner_weights(moved, centroid, weights);
    const double alpha = path_albedo(mesh, (uint32_t)triangle, weights[1], weights[2], albedo);
    const vector3 normal = normal_of(mesh, triangle, corners, weights);
    const double components[3] = {normal.x, normal.y, normal.z};
    mean->area += area;
    mean->alpha += area * alpha;
    for (int i = 0; i < 3; ++i) {
        mean->color[i] += area * alpha * albedo[i];
        mean->normal[i] += area * components[i];
    }
}

static void add_leaf(const svo_mesh *mesh, const svo_tree *lists, const svo_tree_arrays *arrays, const uint32_t cell[3],
                     surface_mean *mean)
{
    const svo_tree_info info = info_of_tree(lists);
    svo_node node;
    if (svo_tree_find_cell(lists, info.depth, cell, &node) != SVO_OK || node.level != info.depth) {
        return;
    }
    const size_t leaf = node.index - (size_t)info.inner_count;
    for (size_t i = arrays->list_begin[leaf]; i < arrays->list_begin[leaf + 1]; ++i) {
        const size_t triangle = arrays->triangle_ids[arrays->list[i]];
        double corners[3][3];
        open_triangle(mesh, &info, cell, triangle, corners);
        for (unsigned octant = 0; octant < 8; ++octant) {
            add_part(mesh, triangle, corners, octant, mean);
        }
    }
}

/* IEC 61966-2-1. */
static double linear_of(uint8_t value)
{
    const double share = value / 255.0;
    return share <= 0.04045 ? share / 12.92 : pow((share + 0.055) / 1.055, 2.4);
}

static void compare_color(const surface_mean *mean, const uint8_t *color, size_t index, tune_errors *errors)
{
    double truth[3];
    double own[3];
    double labs[2][3];
    double square = 0;
    for (int i = 0; i < 3; ++i) {
        truth[i] = mean->color[i] / mean->alpha;
        own[i] = linear_of(color[i]);
        square += (own[i] - truth[i]) * (own[i] - truth[i]) / 3;
    }
    delta_e_lab(truth, labs[0]);
    delta_e_lab(own, labs[1]);
    samples_add(&errors->of[QUANTITY_COLOR], index, sqrt(square));
    samples_add(&errors->of[QUANTITY_DELTA_E], index, delta_e_2000(labs[0], labs[1]));
}

static void compare_normal(const surface_mean *mean, const int16_t *normal, size_t index, tune_errors *errors)
{
    const vector3 truth = vector(mean->normal[0], mean->normal[1], mean->normal[2]);
    const vector3 own = vector(normal[0], normal[1], normal[2]);
    if (vector_length(truth) > LEAST_LENGTH * mean->area) {
        const double angle = atan2(vector_length(vector_cross(truth, own)), vector_dot(truth, own));
        samples_add(&errors->of[QUANTITY_NORMAL], index, angle * DEGREES);
    }
}

void payload_errors_add(const svo_mesh *mesh, const svo_tree *tree, const svo_tree *lists, size_t count, uint32_t seed,
                        tune_errors *errors)
{
    const svo_tree_info info = info_of_tree(tree);
    random_stream random = {.state = seed};
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    svo_tree_arrays of_lists = SVO_TREE_ARRAYS_INIT;
    svo_tree_get_arrays(tree, &arrays);
    svo_tree_get_arrays(lists, &of_lists);
    errors->voxel = ldexp(info.edge, -(int)info.depth);
    errors->voxels = info.leaf_count;
    for (size_t i = 0; i < count && info.leaf_count > 0; ++i) {
        const size_t place = (size_t)(info.inner_count + random_bits(&random) % info.leaf_count);
        surface_mean mean = {.area = 0};
        svo_node node;
        (void)svo_tree_find_node(tree, (uint32_t)place, &node);
        add_leaf(mesh, lists, &of_lists, node.cell, &mean);
        if (mean.area > LEAST_AREA && mean.alpha > 0 && arrays.colors != NULL) {
            const bool is_constant = (info.constant & (uint32_t)SVO_NEED_COLOR) != 0;
            compare_color(&mean, arrays.colors + (is_constant ? 0 : 4 * place), i, errors);
        }
        if (mean.area > LEAST_AREA && arrays.normals != NULL) {
            const bool is_constant = (info.constant & (uint32_t)SVO_NEED_NORMAL) != 0;
            compare_normal(&mean, arrays.normals + (is_constant ? 0 : 3 * place), i, errors);
        }
    }
}
