/* SPDX-License-Identifier: MIT */
/*
 * Times the methods interleaved, then runs each in several orders of the samples or, for svocl, of the triangles. The
 * samples are those of a tree's (voxel, triangle) pairs, each interpolated in double; kernels of averages.cl average
 * them as common methods do.
 */
#include "errors/attribute_methods.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "measure/spread.h"
#include "reference/oracle.h"
#include "scenes/maths.h"
#include "support/info_of.h"
#include "support/input.h"
#include "support/session.h"
#include "svocl/svocl.h"

/* ---- samples ---- */

typedef struct attribute_samples {
    size_t count; /* pairs */
    size_t leaf_count;
    uint32_t *leaves; /* per pair */
    float (*values)[4]; /* per pair, at the projection of the voxel's center: color 0 .. 255; normal -1 .. 1 */
    double (*means)[3]; /* per leaf: weighted by area, at the centroids of the parts inside; normals of any length */
    bool *judged; /* per leaf: it has an area, and its mean normal is not close to zero */
} attribute_samples;

#define LEAST_AREA   1e-6 /* of a voxel face: below it, a triangle only touches the voxel */
#define LEAST_LENGTH 0.05 /* of a mean normal with a direction */

typedef struct pair {
    double triangle[3][3]; /* vertex, axis: in voxels from the voxel's corner */
    size_t corners[3]; /* vertices of the mesh */
} pair;

static void open_pair(const svo_mesh *mesh, const svo_tree_info *info, const svo_tree_arrays *arrays, uint64_t code,
                      uint32_t entry, pair *out)
{
    const size_t id = arrays->triangle_ids[entry];
    oracle_box box;
    oracle_voxel_box(code, info->depth, info->depth, &box); /* in voxels */
    for (size_t i = 0; i < 3; ++i) {
        out->corners[i] = mesh->indices != NULL ? mesh->indices[id * 3 + i] : id * 3 + i;
        for (size_t axis = 0; axis < 3; ++axis) {
            const size_t at = out->corners[i] * 3 + axis;
            const double x = mesh->positions_double != NULL ? mesh->positions_double[at] : (double)mesh->positions[at];
            out->triangle[i][axis] =
                ldexp((x - info->origin[axis]) / info->edge, (int)info->depth) - (double)box.corner[axis];
        }
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
    static const double center[3] = {0.5, 0.5, 0.5};
    double centroid[3];
    double weights[3];
    double value[3];
    oracle_corner_weights(opened->triangle, center, weights);
    interpolate(mesh, kind, opened, weights, value);
    for (int channel = 0; channel < 3; ++channel) {
        sample[channel] = (float)value[channel];
    }
    sample[3] = 1.0f;
    const double area = oracle_part(opened->triangle, 1.0, centroid);
    oracle_corner_weights(opened->triangle, centroid, weights);
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

static void attribute_samples_free(attribute_samples *made)
{
    free(made->leaves);
    free(made->values);
    free(made->means);
    free(made->judged);
    *made = (attribute_samples){0};
}

/* mesh: with colors and normals per vertex, without materials. info, arrays: of its downloaded tree with lists. Returns
   false, with nothing to release, when memory runs out or the tree is malformed. */
static bool attribute_samples_create(const svo_mesh *mesh, attribute kind, const svo_tree_info *info,
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

/* Shuffles the pairs. */
static void attribute_samples_shuffle(attribute_samples *made, uint64_t seed)
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

/* ---- averages by kernels ---- */

typedef enum average_method { AVERAGE_RGBA8 = 0, AVERAGE_FLOAT, AVERAGE_METHOD_COUNT } average_method;
typedef struct averages averages;

#define GROUP_ITEMS 64u

extern const char averages_source[];

struct averages {
    const session *opened;
    cl_program program;
    cl_kernel kernels[AVERAGE_METHOD_COUNT];
    cl_mem cells, samples, results;
    size_t count, leaf_count;
    double scale, offset;
};

static const char *const kernel_names[AVERAGE_METHOD_COUNT] = {"average_rgba8", "add_float"};
static const size_t words_per_leaf[AVERAGE_METHOD_COUNT] = {1, 4};

static bool compile(averages *made)
{
    const char *source = averages_source;
    const svo_device_info on = info_of_device(made->opened->device);
    made->program = clCreateProgramWithSource(on.context, 1, &source, NULL, NULL);
    bool worked = made->program != NULL && clBuildProgram(made->program, 1, &on.device, NULL, NULL, NULL) == CL_SUCCESS;
    for (int method = 0; method < AVERAGE_METHOD_COUNT && worked; ++method) {
        made->kernels[method] = clCreateKernel(made->program, kernel_names[method], NULL);
        worked = made->kernels[method] != NULL;
    }
    return worked;
}

static bool make_buffers(averages *made)
{
    cl_context context = info_of_device(made->opened->device).context;
    made->cells = clCreateBuffer(context, CL_MEM_READ_ONLY, made->count * sizeof(cl_uint), NULL, NULL);
    made->samples = clCreateBuffer(context, CL_MEM_READ_ONLY, made->count * sizeof(cl_float4), NULL, NULL);
    made->results = clCreateBuffer(context, CL_MEM_READ_WRITE, made->leaf_count * 4 * sizeof(cl_uint), NULL, NULL);
    return made->cells != NULL && made->samples != NULL && made->results != NULL;
}

static bool set_arguments(averages *made)
{
    const cl_uint count = (cl_uint)made->count;
    bool worked = true;
    for (int method = 0; method < AVERAGE_METHOD_COUNT && worked; ++method) {
        cl_kernel kernel = made->kernels[method];
        worked = clSetKernelArg(kernel, 0, sizeof(cl_mem), (const void *)&made->cells) == CL_SUCCESS &&
                 clSetKernelArg(kernel, 1, sizeof(cl_mem), (const void *)&made->samples) == CL_SUCCESS &&
                 clSetKernelArg(kernel, 2, sizeof(cl_mem), (const void *)&made->results) == CL_SUCCESS &&
                 clSetKernelArg(kernel, 3, sizeof count, &count) == CL_SUCCESS;
    }
    return worked;
}

static void averages_destroy(averages **made)
{
    averages *old = *made;
    if (old == NULL) {
        return;
    }
    cl_mem buffers[3] = {old->cells, old->samples, old->results};
    for (int i = 0; i < 3; ++i) {
        if (buffers[i] != NULL) {
            clReleaseMemObject(buffers[i]);
        }
    }
    for (int method = 0; method < AVERAGE_METHOD_COUNT; ++method) {
        if (old->kernels[method] != NULL) {
            clReleaseKernel(old->kernels[method]);
        }
    }
    if (old->program != NULL) {
        clReleaseProgram(old->program);
    }
    free(old);
    *made = NULL;
}

/* NULL on failure. */
static averages *averages_create(const session *opened, const attribute_samples *samples)
{
    averages *made = calloc(1, sizeof *made);
    if (made == NULL) {
        return NULL;
    }
    made->opened = opened;
    made->count = samples->count;
    made->leaf_count = samples->leaf_count;
    if (!compile(made) || !make_buffers(made) || !set_arguments(made)) {
        averages_destroy(&made);
    }
    return made;
}

/* Uploads the samples in their current order, as 8-bit values of value * scale + offset. */
static bool averages_upload(averages *made, const attribute_samples *samples, double scale, double offset)
{
    cl_command_queue queue = made->opened->queue;
    float(*scaled)[4] = calloc(made->count + 1, sizeof *scaled);
    made->scale = scale;
    made->offset = offset;
    for (size_t i = 0; i < made->count && scaled != NULL; ++i) {
        for (int channel = 0; channel < 3; ++channel) {
            scaled[i][channel] = (float)((double)samples->values[i][channel] * scale + offset);
        }
    }
    const bool worked = scaled != NULL &&
                        clEnqueueWriteBuffer(queue, made->samples, CL_TRUE, 0, made->count * sizeof *scaled, scaled, 0,
                                             NULL, NULL) == CL_SUCCESS &&
                        clEnqueueWriteBuffer(queue, made->cells, CL_TRUE, 0, made->count * sizeof(cl_uint),
                                             samples->leaves, 0, NULL, NULL) == CL_SUCCESS;
    free(scaled);
    return worked;
}

/* Clears the means and runs the method. Returns the milliseconds of the kernel, below 0 on failure. */
static double averages_run(averages *made, average_method method)
{
    cl_command_queue queue = made->opened->queue;
    const cl_uint zero = 0;
    const size_t group = GROUP_ITEMS;
    const size_t size = (made->count + group - 1) / group * group;
    if (clEnqueueFillBuffer(queue, made->results, &zero, sizeof zero, 0, made->leaf_count * 4 * sizeof zero, 0, NULL,
                            NULL) != CL_SUCCESS ||
        clFinish(queue) != CL_SUCCESS) {
        return -1.0;
    }
    const double started_ms = input_now_ms();
    const bool worked =
        clEnqueueNDRangeKernel(queue, made->kernels[method], 1, NULL, &size, &group, 0, NULL, NULL) == CL_SUCCESS &&
        clFinish(queue) == CL_SUCCESS;
    return worked ? input_now_ms() - started_ms : -1.0;
}

static void unpack(const averages *made, average_method method, const cl_uint *words, double mean[3])
{
    union {
        cl_uint bits;
        float number;
    } sums[4];
    for (size_t i = 0; i < 4 && method == AVERAGE_FLOAT; ++i) {
        sums[i].bits = words[i];
    }
    for (unsigned channel = 0; channel < 3; ++channel) {
        const double octets = method == AVERAGE_FLOAT ? (double)sums[channel].number / fmax((double)sums[3].number, 1.0)
                                                      : (double)(words[0] >> 8 * channel & 255u);
        mean[channel] = (octets - made->offset) / made->scale;
    }
}

/* The means of the last run of that method, in the units of the samples. */
static bool averages_read(averages *made, average_method method, double (*means)[3])
{
    const size_t bytes = made->leaf_count * words_per_leaf[method] * sizeof(cl_uint);
    cl_uint *words = malloc(bytes + 1);
    const bool worked = words != NULL && clEnqueueReadBuffer(made->opened->queue, made->results, CL_TRUE, 0, bytes,
                                                             words, 0, NULL, NULL) == CL_SUCCESS;
    for (size_t leaf = 0; leaf < made->leaf_count && worked; ++leaf) {
        unpack(made, method, words + leaf * words_per_leaf[method], means[leaf]);
    }
    free(words);
    return worked;
}

/* ---- methods ---- */

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
