/* SPDX-License-Identifier: MIT */
/* Times the methods interleaved, then runs each in several orders of the samples or, for svocl, of the triangles. */
#include "errors/attribute_methods.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "errors/averages.h"
#include "measure/interleave.h"
#include "measure/spread.h"
#include "scenes/maths.h"

#define QUICK_ORDERS 3u
#define FULL_ORDERS  5u
#define DEGREES      57.29577951308232

typedef struct attribute_bench attribute_bench;

typedef struct attribute_method {
    attribute_bench *bench;
    const char *name;
    bool ours;
    svo_weights weights; /* of ours */
    average_method average; /* of the others */
} attribute_method;

struct attribute_bench {
    error_run *run;
    svo_mesh mesh; /* with indices of its own */
    uint32_t *indices; /* in the current order */
    attribute kind;
    unsigned depth;
    attribute_samples samples;
    averages *kernels;
    double (*found)[3], (*first)[3]; /* means of a method: in the current order, in the first one */
    double *errors, *differences; /* per leaf */
    attribute_method methods[ATTRIBUTE_METHODS_MAX];
    size_t method_count;
};

static void add_method(attribute_bench *bench, const char *name, bool ours, svo_weights weights, average_method average)
{
    bench->methods[bench->method_count++] = (attribute_method){bench, name, ours, weights, average};
}

static void list_methods(attribute_bench *bench)
{
    add_method(bench, "RGBA8 running average", false, SVO_WEIGHTS_AREA, AVERAGE_RGBA8);
    add_method(bench, "float atomics", false, SVO_WEIGHTS_AREA, AVERAGE_FLOAT);
    add_method(bench, "integers, uniform", true, SVO_WEIGHTS_UNIFORM, AVERAGE_METHOD_COUNT);
    add_method(bench, "integers, at the center", true, SVO_WEIGHTS_CENTER, AVERAGE_METHOD_COUNT);
    add_method(bench, "integers, by area", true, SVO_WEIGHTS_AREA, AVERAGE_METHOD_COUNT);
}

/* ---- builds ---- */

static svo_tree *build(const attribute_bench *bench, svo_weights weights, uint32_t need, svo_build_report *report)
{
    const session *opened = &bench->run->opened;
    const svo_plan_options plan_options = {.struct_size = sizeof plan_options, .need = need, .weights = weights};
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    if (svo_plan_create(opened->device, &bench->mesh, bench->depth, &plan_options, &plan) == SVO_OK &&
        svo_build(plan, opened->frontend, opened->queue, &tree, report) == SVO_OK &&
        svo_tree_download(tree, opened->queue) != SVO_OK) {
        svo_tree_destroy(&tree);
    }
    svo_plan_destroy(&plan);
    return tree;
}

static uint32_t need_of(attribute kind)
{
    return kind == ATTRIBUTE_COLOR ? SVO_NEED_COLOR : SVO_NEED_NORMAL;
}

static double run_ours(void *user)
{
    const attribute_method *method = user;
    svo_build_report report = {.struct_size = sizeof report};
    svo_tree *tree = build(method->bench, method->weights, need_of(method->bench->kind), &report);
    const bool worked = tree != NULL;
    svo_tree_destroy(&tree);
    return worked ? report.stage_times[SVO_STAGE_LINK].ms + report.stage_times[SVO_STAGE_FILTER].ms : -1.0;
}

static double run_kernel(void *user)
{
    const attribute_method *method = user;
    return averages_run(method->bench->kernels, method->average);
}

/* ---- results in the current order ---- */

static bool find_ours(const attribute_method *method, double (*means)[3])
{
    const attribute_bench *bench = method->bench;
    svo_tree *tree = build(bench, method->weights, need_of(bench->kind), NULL);
    if (tree == NULL) {
        return false;
    }
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    svo_tree_get_info(tree, &info);
    svo_tree_get_arrays(tree, &arrays);
    const bool same_leaves = info.leaf_count == bench->samples.leaf_count;
    for (size_t leaf = 0; leaf < bench->samples.leaf_count && same_leaves; ++leaf) {
        const size_t node = (size_t)info.inner_count + leaf;
        for (size_t channel = 0; channel < 3; ++channel) {
            means[leaf][channel] = bench->kind == ATTRIBUTE_COLOR ? (double)arrays.colors[node * 4 + channel]
                                                                  : arrays.normals[node * 3 + channel] / 32767.0;
        }
    }
    svo_tree_destroy(&tree);
    return same_leaves;
}

static bool find_average(const attribute_method *method, double (*means)[3])
{
    return averages_run(method->bench->kernels, method->average) >= 0.0 &&
           averages_read(method->bench->kernels, method->average, means);
}

/* Colors: the worst channel. Normals: the angle between directions, in degrees. */
static double distance(attribute kind, const double a[3], const double b[3])
{
    if (kind == ATTRIBUTE_COLOR) {
        return fmax(fabs(a[0] - b[0]), fmax(fabs(a[1] - b[1]), fabs(a[2] - b[2])));
    }
    const vector3 left = vector(a[0], a[1], a[2]);
    const vector3 right = vector(b[0], b[1], b[2]);
    if (a[0] == b[0] && a[1] == b[1] && a[2] == b[2]) {
        return 0.0;
    }
    return DEGREES * atan2(vector_length(vector_cross(left, right)), vector_dot(left, right));
}

/* ---- orders ---- */

static bool upload(attribute_bench *bench)
{
    return bench->kind == ATTRIBUTE_COLOR ? averages_upload(bench->kernels, &bench->samples, 1.0, 0.0)
                                          : averages_upload(bench->kernels, &bench->samples, 127.5, 127.5);
}

static void shuffle_triangles(attribute_bench *bench, uint64_t seed)
{
    random_stream random = {seed};
    for (size_t t = bench->mesh.triangle_count; t-- > 1;) {
        const size_t other = random_index(&random, (uint32_t)t + 1);
        uint32_t kept[3];
        memcpy(kept, bench->indices + 3 * t, sizeof kept);
        memmove(bench->indices + 3 * t, bench->indices + 3 * other, sizeof kept);
        memcpy(bench->indices + 3 * other, kept, sizeof kept);
    }
}

/* Keeps each leaf's largest difference from the first order. */
static void widen_differences(attribute_bench *bench)
{
    for (size_t leaf = 0; leaf < bench->samples.leaf_count; ++leaf) {
        const double difference = distance(bench->kind, bench->found[leaf], bench->first[leaf]);
        bench->differences[leaf] = fmax(bench->differences[leaf], bench->samples.judged[leaf] ? difference : 0.0);
    }
}

static bool run_orders(attribute_bench *bench, attribute_method *method)
{
    const unsigned order_count = bench->run->quick ? QUICK_ORDERS : FULL_ORDERS;
    bool worked = true;
    memset(bench->differences, 0, bench->samples.leaf_count * sizeof *bench->differences);
    for (unsigned order = 0; order < order_count && worked; ++order) {
        double(*means)[3] = order == 0 ? bench->first : bench->found;
        if (order > 0 && method->ours) {
            shuffle_triangles(bench, order);
        } else if (order > 0) {
            attribute_samples_shuffle(&bench->samples, order);
            worked = upload(bench);
        }
        worked = worked && (method->ours ? find_ours(method, means) : find_average(method, means));
        if (worked && order > 0) {
            widen_differences(bench);
        }
    }
    return worked;
}

static void summarize(attribute_bench *bench, attribute_method_result *result)
{
    size_t count = 0;
    for (size_t leaf = 0; leaf < bench->samples.leaf_count; ++leaf) {
        if (bench->samples.judged[leaf]) {
            const double error = distance(bench->kind, bench->first[leaf], bench->samples.means[leaf]);
            bench->errors[count++] = error;
            result->mean += error;
            result->order_mean += bench->differences[leaf];
            result->order_largest = fmax(result->order_largest, bench->differences[leaf]);
        }
    }
    if (count > 0) {
        (void)spread_of(bench->errors, count); /* sorts them */
        result->mean /= (double)count;
        result->order_mean /= (double)count;
        result->percentile_99 = spread_quantile(bench->errors, count, 0.99);
        result->largest = bench->errors[count - 1];
    }
}

/* ---- the measurement ---- */

static bool prepare(attribute_bench *bench, const svo_mesh *mesh)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    bench->mesh = *mesh;
    bench->indices = calloc(mesh->triangle_count * 3 + 1, sizeof *bench->indices);
    if (bench->indices == NULL || mesh->indices == NULL || mesh->material_count > 0) {
        return false;
    }
    memcpy(bench->indices, mesh->indices, mesh->triangle_count * 3 * sizeof *bench->indices);
    bench->mesh.indices = bench->indices;
    svo_tree *tree = build(bench, SVO_WEIGHTS_AREA, SVO_NEED_RAYS, NULL);
    if (tree == NULL) {
        return false;
    }
    svo_tree_get_info(tree, &info);
    svo_tree_get_arrays(tree, &arrays);
    bool worked = attribute_samples_create(&bench->mesh, bench->kind, &info, &arrays, &bench->samples);
    svo_tree_destroy(&tree);
    const size_t leaf_count = bench->samples.leaf_count;
    bench->found = calloc(leaf_count + 1, sizeof *bench->found);
    bench->first = calloc(leaf_count + 1, sizeof *bench->first);
    bench->errors = calloc(leaf_count + 1, sizeof *bench->errors);
    bench->differences = calloc(leaf_count + 1, sizeof *bench->differences);
    bench->kernels = worked ? averages_create(&bench->run->opened, &bench->samples) : NULL;
    return bench->found != NULL && bench->first != NULL && bench->errors != NULL && bench->differences != NULL &&
           bench->kernels != NULL && upload(bench);
}

static bool measure(attribute_bench *bench, attribute_method_result *results)
{
    interleaved_method timed[ATTRIBUTE_METHODS_MAX];
    for (size_t i = 0; i < bench->method_count; ++i) {
        timed[i] =
            (interleaved_method){.work_ms = bench->methods[i].ours ? run_ours : run_kernel, .user = &bench->methods[i]};
    }
    bool worked = interleave_measure(timed, bench->method_count, bench->run->rounds);
    for (size_t i = 0; i < bench->method_count && worked; ++i) {
        results[i] = (attribute_method_result){.method = bench->methods[i].name, .ms = timed[i].median_ms};
        worked = run_orders(bench, &bench->methods[i]);
        summarize(bench, &results[i]);
    }
    return worked;
}

int attribute_methods_measure(error_run *run, const svo_mesh *mesh, attribute kind, unsigned depth,
                              attribute_method_result *results, size_t *result_count, double *pairs_per_leaf)
{
    attribute_bench bench = {.run = run, .kind = kind, .depth = depth};
    list_methods(&bench);
    const bool worked = prepare(&bench, mesh) && measure(&bench, results);
    *result_count = bench.method_count;
    *pairs_per_leaf =
        bench.samples.leaf_count > 0 ? (double)bench.samples.count / (double)bench.samples.leaf_count : 0.0;
    averages_destroy(&bench.kernels);
    attribute_samples_free(&bench.samples);
    free(bench.indices);
    free(bench.found);
    free(bench.first);
    free(bench.errors);
    free(bench.differences);
    return worked ? PROGRAM_DONE : errors_fail(run);
}
