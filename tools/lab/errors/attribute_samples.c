/* SPDX-License-Identifier: MIT */
/* Visits each entry of the leaf lists once and interpolates attributes in double. */
#include "errors/attribute_samples.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reference/oracle.h"
#include "scenes/maths.h"

#define LEAST_AREA   1e-6 /* of a voxel face: below it, a triangle only touches the voxel */
#define LEAST_LENGTH 0.05 /* of a mean normal with a direction */

typedef struct pair {
    oracle_triangle triangle;
    oracle_box box;
    size_t corners[3]; /* vertices of the mesh */
} pair;

static void open_pair(const svo_mesh *mesh, const svo_tree_info *info, const svo_tree_arrays *arrays, uint64_t code,
                      uint32_t entry, pair *out)
{
    const size_t id = arrays->triangle_ids[entry];
    oracle_voxel_box(code, info->depth, info->snap_bits, &out->box);
    for (size_t i = 0; i < 3; ++i) {
        const size_t vertex = arrays->indices[(size_t)entry * 3 + i];
        memcpy(out->triangle.vertex[i], arrays->vertices + vertex * 3, sizeof out->triangle.vertex[i]);
        out->corners[i] = mesh->indices != NULL ? mesh->indices[id * 3 + i] : id * 3 + i;
    }
}

static void interpolate(const svo_mesh *mesh, attribute kind, const pair *opened, const double weights[3],
                        double value[3])
{
    for (size_t channel = 0; channel < 3; ++channel) {
        value[channel] = 0.0;
        for (size_t i = 0; i < 3; ++i) {
            const size_t vertex = opened->corners[i];
            value[channel] += weights[i] * (kind == ATTRIBUTE_COLOR ? (double)mesh->colors[vertex * 4 + channel]
                                                                    : (double)mesh->normals[vertex * 3 + channel]);
        }
    }
}

/* Sets the sample and adds to the leaf's mean. Returns the weight. */
static double add_pair(const svo_mesh *mesh, attribute kind, const pair *opened, float sample[4], double mean[3])
{
    const double half = (double)opened->box.width / 2.0;
    const double center[3] = {half, half, half};
    double centroid[3];
    double weights[3];
    double value[3];
    oracle_corner_weights(&opened->triangle, &opened->box, center, weights);
    interpolate(mesh, kind, opened, weights, value);
    for (int channel = 0; channel < 3; ++channel) {
        sample[channel] = (float)value[channel];
    }
    sample[3] = 1.0f;
    const double area = oracle_part(&opened->triangle, &opened->box, centroid);
    oracle_corner_weights(&opened->triangle, &opened->box, centroid, weights);
    interpolate(mesh, kind, opened, weights, value);
    for (int channel = 0; channel < 3; ++channel) {
        mean[channel] += area * value[channel];
    }
    return area;
}

static void fill(const svo_mesh *mesh, attribute kind, const svo_tree_info *info, const svo_tree_arrays *arrays,
                 const uint64_t *codes, attribute_samples *out)
{
    for (size_t leaf = 0; leaf < out->leaf_count; ++leaf) {
        double *mean = out->means[leaf];
        double area = 0.0;
        for (size_t i = arrays->list_begin[leaf]; i < arrays->list_begin[leaf + 1]; ++i) {
            pair opened;
            open_pair(mesh, info, arrays, codes[leaf], arrays->list[i], &opened);
            out->leaves[i] = (uint32_t)leaf;
            area += add_pair(mesh, kind, &opened, out->values[i], mean);
        }
        for (int channel = 0; channel < 3 && area > 0.0; ++channel) {
            mean[channel] /= area;
        }
        const double length = sqrt(mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2]);
        out->judged[leaf] = area > LEAST_AREA && (kind == ATTRIBUTE_COLOR || length > LEAST_LENGTH);
    }
}

bool attribute_samples_create(const svo_mesh *mesh, attribute kind, const svo_tree_info *info,
                              const svo_tree_arrays *arrays, attribute_samples *out)
{
    const size_t count = (size_t)info->list_count;
    const size_t leaf_count = (size_t)info->leaf_count;
    uint64_t *codes = calloc(leaf_count + 1, sizeof *codes);
    *out = (attribute_samples){.count = count,
                               .leaf_count = leaf_count,
                               .leaves = calloc(count + 1, sizeof *out->leaves),
                               .values = calloc(count + 1, sizeof *out->values),
                               .means = calloc(leaf_count + 1, sizeof *out->means),
                               .judged = calloc(leaf_count + 1, sizeof *out->judged)};
    const bool good = codes != NULL && out->leaves != NULL && out->values != NULL && out->means != NULL &&
                      out->judged != NULL && mesh->colors != NULL && mesh->normals != NULL &&
                      oracle_leaf_codes(arrays->child_mask, info->inner_count, info->depth, info->leaf_count, codes);
    if (good) {
        fill(mesh, kind, info, arrays, codes, out);
    } else {
        attribute_samples_free(out);
    }
    free(codes);
    return good;
}

void attribute_samples_free(attribute_samples *made)
{
    free(made->leaves);
    free(made->values);
    free(made->means);
    free(made->judged);
    *made = (attribute_samples){0};
}

void attribute_samples_shuffle(attribute_samples *made, uint64_t seed)
{
    random_stream random = {seed};
    for (size_t i = made->count; i-- > 1;) {
        const size_t other = random_index(&random, (uint32_t)i + 1);
        float kept[4];
        const uint32_t leaf = made->leaves[i];
        memcpy(kept, made->values[i], sizeof kept);
        memcpy(made->values[i], made->values[other], sizeof kept);
        memcpy(made->values[other], kept, sizeof kept);
        made->leaves[i] = made->leaves[other];
        made->leaves[other] = leaf;
    }
}
