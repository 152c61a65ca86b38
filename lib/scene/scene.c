/* SPDX-License-Identifier: MIT */
/*
 * Scenes: their checks, buffers, instances. trees.c holds the trees, hierarchy.c the boxes; rays.c launches rays.
 *
 * What follows from an instance's matrix is computed in double, add, subtract, multiply, divide and square root alone,
 * so the records are the same bytes on every machine.
 */
#include "svocl/scene.h"

#include <math.h>
#include <string.h>

#include "core/staging.h"
#include "core/struct_size.h"
#include "scene/hierarchy.h"
#include "scene/trees.h"
#include "svocl/plan.h"

#define KNOWN_NEEDS ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_RAYS)

/* Coordinates and entries of inverses are below this, so that the kernels' floats do not overflow. */
#define LARGEST 0x1p100

/* ---- plans ---- */

static svo_status check_options(svo_device *device, const char *function, const svo_scene_options *options)
{
    if ((options->trees == NULL) == (options->compacts == NULL)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.trees and options.compacts are %s",
                                 function, options->trees == NULL ? "NULL" : "both given");
    }
    if (options->tree_count < 1 || options->tree_count > SVO_SCENE_TREES_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.tree_count %u is not in 1 .. %u", function,
                                 options->tree_count, SVO_SCENE_TREES_MAX);
    }
    if (options->instance_count < 1 || options->instance_count > SVO_SCENE_INSTANCES_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.instance_count %u is not in 1 .. %u",
                                 function, options->instance_count, SVO_SCENE_INSTANCES_MAX);
    }
    if ((options->need & ~(KNOWN_NEEDS | (uint32_t)SVO_NEED_NONE)) != 0) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: options.need 0x%x has bits other than colors, normals and rays, 0x%x", function,
                                 options->need, KNOWN_NEEDS);
    }
    return SVO_OK;
}

static svo_status read_options(svo_device *device, const char *function, const svo_scene_options *given,
                               svo_scene_options *out)
{
    if (given == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options is NULL", function);
    }
    SVO_I_TRY(svo_i_struct_read(&device->message, function, "options", given, out,
                                SVO_I_STRUCT_SIZES(svo_scene_options, reserved)));
    SVO_I_TRY(check_options(device, function, out));
    out->need =
        out->need == SVO_NEED_DEFAULT ? (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL : out->need & KNOWN_NEEDS;
    return SVO_OK;
}

static svo_scene_info describe(const svo_scene_options *options, const uint64_t bytes[SVO_I_SCENE_BUFFERS])
{
    svo_scene_info info = {.struct_size = sizeof info,
                           .tree_count = options->tree_count,
                           .instance_count = options->instance_count,
                           .need = options->need};
    for (int i = 0; i < SVO_I_SCENE_BUFFERS; ++i) {
        uint64_t *sum = i == SVO_I_SCENE_INSTANCES ? &info.instance_bytes
                        : i == SVO_I_SCENE_HIERARCHY || (i >= SVO_I_SCENE_PARENTS && i <= SVO_I_SCENE_WIDE)
                            ? &info.hierarchy_bytes
                        : i >= SVO_I_SCENE_LIST ? &info.sort_bytes
                                                : &info.tree_bytes;
        *sum += bytes[i];
        info.total_bytes += bytes[i];
    }
    return info;
}

static svo_status write_info(svo_device *device, const char *function, const svo_scene_info *made, svo_scene_info *info)
{
    return svo_i_struct_write(&device->message, function, "info", made, info, SVO_I_STRUCT_SIZES(svo_scene_info, high));
}

svo_status svo_scene_plan(svo_device *device, const svo_scene_options *options, svo_scene_info *info)
{
    static const char function[] = "svo_scene_plan";
    svo_scene_options asked = {.trees = NULL};
    svo_i_arena arena = {.sources = NULL};
    svo_status status = SVO_OK;
    if (device == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(read_options(device, function, options, &asked));
    SVO_I_TRY_CLEANUP(svo_i_arena_plan(device, function, &asked, &arena));
    svo_i_hierarchy_plan(device, asked.instance_count, arena.bytes);
    const svo_scene_info made = describe(&asked, arena.bytes);
    SVO_I_TRY_CLEANUP(write_info(device, function, &made, info));

cleanup:
    svo_i_arena_free(&arena);
    return status;
}

/* ---- matrices ---- */

typedef struct linear {
    double m[3][3]; /* rows */
} linear;

static bool is_finite(const float matrix[12])
{
    bool finite = true;
    for (int i = 0; i < 12; ++i) {
        finite = finite && isfinite(matrix[i]);
    }
    return finite;
}

/* The transpose of the matrix of cofactors: the inverse times the determinant. */
static linear adjugate(const linear *a)
{
    linear out;
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            const int i1 = (i + 1) % 3;
            const int i2 = (i + 2) % 3;
            const int k1 = (k + 1) % 3;
            const int k2 = (k + 2) % 3;
            out.m[k][i] = a->m[i1][k1] * a->m[i2][k2] - a->m[i1][k2] * a->m[i2][k1];
        }
    }
    return out;
}

static double column_length(const linear *a, int k)
{
    return sqrt(a->m[0][k] * a->m[0][k] + a->m[1][k] * a->m[1][k] + a->m[2][k] * a->m[2][k]);
}

/* Stores the inverse in two floats per entry, and the images of the faces' normals, which are its rows. */
static bool store_inverse(const linear *inverse, svo_scene_instance *out)
{
    bool fits = true;
    for (int row = 0; row < 3; ++row) {
        const double *entries = inverse->m[row];
        const double length = sqrt(entries[0] * entries[0] + entries[1] * entries[1] + entries[2] * entries[2]);
        for (int k = 0; k < 3; ++k) {
            fits = fits && fabs(entries[k]) < LARGEST;
            out->inverse[3 * row + k] = (float)entries[k];
            out->inverse_rest[3 * row + k] = (float)(entries[k] - (double)out->inverse[3 * row + k]);
            out->normals[3 * row + k] = (float)(entries[k] / length) + 0.0F; /* never -0 */
        }
    }
    return fits;
}

/* The box of the image of a box, rounded outwards. */
static bool store_box(const linear *a, const float matrix[12], const svo_i_scene_box *box, svo_scene_instance *out)
{
    bool fits = true;
    for (int row = 0; row < 3; ++row) {
        double middle = (double)matrix[4 * row + 3];
        double half = 0;
        double size = fabs(middle);
        for (int k = 0; k < 3; ++k) {
            middle += a->m[row][k] * (0.5 * (box->low[k] + box->high[k]));
            half += fabs(a->m[row][k]) * (0.5 * (box->high[k] - box->low[k]));
            size += fabs(a->m[row][k]) * fmax(fabs(box->low[k]), fabs(box->high[k]));
        }
        half += size * 0x1p-48; /* what these sums may round */
        fits = fits && middle - half > -LARGEST && middle + half < LARGEST;
        out->low[row] = nextafterf((float)(middle - half), -INFINITY);
        out->high[row] = nextafterf((float)(middle + half), INFINITY);
        out->translation[row] = matrix[4 * row + 3];
    }
    return fits;
}

/* What the kernels know of an instance: inverts the matrix, in double, and finds the world's box of an instance of a
   tree. Refuses a matrix that is not finite, flat, or too large, and names the instance. */
static svo_status place(svo_device *device, const char *function, uint32_t instance, const float matrix[12],
                        const svo_i_scene_box *tree_box, svo_scene_instance *out)
{
    linear a;
    if (!is_finite(matrix)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: the matrix of instance %u is not finite", function,
                                 instance);
    }
    for (int i = 0; i < 12; ++i) {
        if (i % 4 < 3) {
            a.m[i / 4][i % 4] = (double)matrix[i];
        }
    }
    const linear scaled = adjugate(&a);
    const double determinant = a.m[0][0] * scaled.m[0][0] + a.m[0][1] * scaled.m[1][0] + a.m[0][2] * scaled.m[2][0];
    const double lengths[3] = {column_length(&a, 0), column_length(&a, 1), column_length(&a, 2)};
    const double least = SVO_SCENE_DETERMINANT_MIN * lengths[0] * lengths[1] * lengths[2];
    if (!(fabs(determinant) > least)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: the matrix of instance %u is flat: determinant %g, its size is not above %g",
                                 function, instance, determinant, least);
    }
    linear inverse;
    for (int i = 0; i < 9; ++i) {
        inverse.m[i / 3][i % 3] = scaled.m[i / 3][i % 3] / determinant;
    }
    const bool inverse_fits = store_inverse(&inverse, out);
    if (!store_box(&a, matrix, tree_box, out) || !inverse_fits) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: the matrix of instance %u or its inverse leads beyond 2^100", function, instance);
    }
    out->widest = (float)fmax(lengths[0], fmax(lengths[1], lengths[2]));
    return SVO_OK;
}

/* ---- creation ---- */

static svo_status allocate(svo_scene *scene, const char *function, const uint64_t bytes[SVO_I_SCENE_BUFFERS])
{
    static const char *const names[SVO_I_SCENE_BUFFERS] = {
        "nodes",     "nodes",     "nodes",  "ray_nodes",   "ray_leaves",  "tree_params", "trees",
        "instances", "hierarchy", "colors", "normals",     "bounds",      "parents",     "arrivals",
        "wide",      "codes",     "codes",  "sort_counts", "sort_counts", "partials"};
    for (int i = 0; i < SVO_I_SCENE_BUFFERS; ++i) {
        if (bytes[i] > 0) {
            SVO_I_TRY(svo_i_device_buffer(scene->device, function, names[i], CL_MEM_READ_WRITE, (size_t)bytes[i],
                                          &scene->buffers[i]));
        }
    }
    return SVO_OK;
}

static svo_status allocate_host(svo_scene *scene, const char *function)
{
    scene->tree_boxes = svo_i_alloc_zeroed(&scene->device->memory, scene->info.tree_count, sizeof *scene->tree_boxes);
    scene->tree_of = svo_i_alloc_zeroed(&scene->device->memory, scene->info.instance_count, sizeof *scene->tree_of);
    scene->boxes = svo_i_alloc_zeroed(&scene->device->memory, scene->info.instance_count, sizeof *scene->boxes);
    return scene->tree_boxes != NULL && scene->tree_of != NULL && scene->boxes != NULL
               ? SVO_OK
               : svo_i_device_fail(scene->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u instances", function,
                                   scene->info.instance_count);
}

static svo_status write_instances(svo_scene *scene, const char *function, cl_command_queue queue, uint32_t first,
                                  uint32_t count, const svo_scene_instance *records)
{
    const size_t bytes = sizeof *records;
    SVO_I_TRY(svo_i_device_write(scene->device, function, queue, scene->buffers[SVO_I_SCENE_INSTANCES], first * bytes,
                                 records, count * bytes));
    for (uint32_t i = 0; i < count; ++i) {
        svo_i_instance_box *box = &scene->boxes[first + i];
        memcpy(box->low, records[i].low, sizeof box->low);
        memcpy(box->high, records[i].high, sizeof box->high);
        box->leaf_edge = (float)(scene->tree_boxes[records[i].tree].leaf_edge * (double)records[i].widest);
    }
    return SVO_OK;
}

/* The records of consecutive instances; the caller frees them. matrix: of the first; stride: floats to the next. */
static svo_status make_records(const svo_scene *scene, const char *function, uint32_t first, uint32_t count,
                               const float *matrix, size_t stride, svo_scene_instance **out)
{
    *out = svo_i_alloc_zeroed(&scene->device->memory, count, sizeof **out);
    if (*out == NULL) {
        return svo_i_device_fail(scene->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u instances", function,
                                 count);
    }
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t tree = scene->tree_of[first + i];
        (*out)[i].tree = tree;
        SVO_I_TRY(place(scene->device, function, first + i, matrix + i * stride, &scene->tree_boxes[tree], &(*out)[i]));
    }
    return SVO_OK;
}

static svo_status place_all(svo_scene *scene, const char *function, cl_command_queue queue,
                            const svo_instance *instances)
{
    const uint32_t count = scene->info.instance_count;
    svo_scene_instance *records = NULL;
    svo_status status = SVO_OK;
    for (uint32_t i = 0; i < count; ++i) {
        if (instances[i].tree >= scene->info.tree_count) {
            return svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT,
                                     "%s: the tree of instance %u is %u, not below %u", function, i, instances[i].tree,
                                     scene->info.tree_count);
        }
        scene->tree_of[i] = instances[i].tree;
    }
    SVO_I_TRY_CLEANUP(
        make_records(scene, function, 0, count, instances[0].transform, sizeof *instances / sizeof(float), &records));
    SVO_I_TRY_CLEANUP(write_instances(scene, function, queue, 0, count, records));

cleanup:
    svo_i_free(records);
    return status;
}

/* Zero means that nothing has arrived; the refit leaves zeros. */
static svo_status clear_arrivals(const svo_scene *scene, const char *function, cl_command_queue queue)
{
    const cl_uint zero = 0;
    const cl_mem arrivals = scene->buffers[SVO_I_SCENE_ARRIVALS];
    if (arrivals == NULL) {
        return SVO_OK;
    }
    const size_t bytes = (size_t)(scene->info.instance_count - 1) * SVO_SCENE_BOUNDS * sizeof zero;
    cl_int error = clEnqueueFillBuffer(queue, arrivals, &zero, sizeof zero, 0, bytes, 0, NULL, NULL);
    error = error == CL_SUCCESS ? clFinish(queue) : error;
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(scene->device, function, "clEnqueueFillBuffer", error);
}

static svo_status make(svo_scene *scene, const char *function, const svo_scene_options *options, svo_i_arena *arena,
                       cl_command_queue queue)
{
    SVO_I_TRY(svo_i_arena_plan(scene->device, function, options, arena));
    svo_i_hierarchy_plan(scene->device, options->instance_count, arena->bytes);
    scene->info = describe(options, arena->bytes);
    scene->form = arena->sources[0].form;
    scene->is_packed = arena->is_packed;
    scene->node_buffers = options->compacts != NULL ? SVO_I_SCENE_NODE_BUFFERS : 2;
    SVO_I_TRY(svo_i_device_queue(scene->device, function, queue, &queue));
    SVO_I_TRY(allocate_host(scene, function));
    SVO_I_TRY(allocate(scene, function, arena->bytes));
    SVO_I_TRY(svo_i_arena_fill(arena, scene, function, queue));
    SVO_I_TRY(place_all(scene, function, queue, options->instances));
    SVO_I_TRY(clear_arrivals(scene, function, queue));
    return svo_i_hierarchy_build(scene, function, queue);
}

svo_status svo_scene_create(svo_device *device, const svo_scene_options *options, cl_command_queue queue,
                            svo_scene **scene)
{
    static const char function[] = "svo_scene_create";
    svo_scene_options asked = {.trees = NULL};
    svo_i_arena arena = {.sources = NULL};
    svo_scene *made = NULL;
    svo_status status = SVO_OK;
    if (device == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(read_options(device, function, options, &asked));
    if (asked.instances == NULL || scene == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 scene == NULL ? "scene" : "options.instances");
    }
    made = svo_i_alloc_zeroed(&device->memory, 1, sizeof *made);
    if (made == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a scene", function);
    }
    made->device = device;
    SVO_I_TRY_CLEANUP(make(made, function, &asked, &arena, queue));
    *scene = made;
    made = NULL;

cleanup:
    svo_i_arena_free(&arena);
    svo_scene_destroy(&made);
    return status;
}

void svo_scene_destroy(svo_scene **scene)
{
    if (scene == NULL || *scene == NULL) {
        return;
    }
    svo_scene *old = *scene;
    for (int i = 0; i < SVO_I_SCENE_BUFFERS; ++i) {
        if (old->buffers[i] != NULL) {
            clReleaseMemObject(old->buffers[i]);
        }
    }
    svo_i_free(old->tree_boxes);
    svo_i_free(old->tree_of);
    svo_i_free(old->boxes);
    svo_i_free(old);
    *scene = NULL;
}

svo_status svo_scene_get_info(const svo_scene *scene, svo_scene_info *info)
{
    return scene != NULL ? write_info(scene->device, "svo_scene_get_info", &scene->info, info) : SVO_INVALID_ARGUMENT;
}

/* ---- changes ---- */

/* From the first command on a failure loses the scene. */
static svo_status keep(svo_scene *scene, svo_status status)
{
    scene->lost = status != SVO_OK;
    return status;
}

static svo_status move(svo_scene *scene, const char *function, cl_command_queue queue, uint32_t first, uint32_t count,
                       const svo_scene_instance *records)
{
    SVO_I_TRY(write_instances(scene, function, queue, first, count, records));
    return svo_i_hierarchy_refit(scene, function, queue);
}

svo_status svo_scene_set_transforms(svo_scene *scene, uint32_t first, uint32_t count, const float *transforms,
                                    cl_command_queue queue)
{
    static const char function[] = "svo_scene_set_transforms";
    svo_scene_instance *records = NULL;
    svo_status status = SVO_OK;
    if (scene == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(svo_i_scene_check(scene, function));
    if (first > scene->info.instance_count || count > scene->info.instance_count - first) {
        return svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT,
                                 "%s: first %u and count %u lead beyond the %u instances", function, first, count,
                                 scene->info.instance_count);
    }
    if (count == 0) {
        return SVO_OK;
    }
    if (transforms == NULL) {
        return svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT, "%s: transforms is NULL", function);
    }
    SVO_I_TRY(svo_i_device_queue(scene->device, function, queue, &queue));
    SVO_I_TRY_CLEANUP(make_records(scene, function, first, count, transforms, 12, &records));
    SVO_I_TRY_CLEANUP(keep(scene, move(scene, function, queue, first, count, records)));

cleanup:
    svo_i_free(records);
    return status;
}

svo_status svo_scene_rebuild(svo_scene *scene, cl_command_queue queue)
{
    static const char function[] = "svo_scene_rebuild";
    if (scene == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(svo_i_scene_check(scene, function));
    SVO_I_TRY(svo_i_device_queue(scene->device, function, queue, &queue));
    return keep(scene, svo_i_hierarchy_build(scene, function, queue));
}
