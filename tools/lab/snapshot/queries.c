/* SPDX-License-Identifier: MIT */
/* Renders a tree in every view, runs ray, voxel-ray and nearest-point queries on it, and fills it. */
#include "queries.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "compact.h"
#include "digest.h"
#include "lights.h"
#include "random.h"
#include "support/info_of.h"

#define PICTURE_WIDTH  160
#define PICTURE_HEIGHT 120
#define RAY_COUNT      20000
#define POINT_COUNT    4000

static const struct {
    const char *name;
    svo_render_view view;
} views[] = {
    {"shaded", SVO_VIEW_SHADED}, {"normal", SVO_VIEW_NORMAL}, {"depth", SVO_VIEW_DEPTH},
    {"steps", SVO_VIEW_STEPS},   {"level", SVO_VIEW_LEVEL},   {"triangles", SVO_VIEW_TRIANGLES},
};
static const struct {
    const char *name;
    uint32_t flags;
} traces[] = {{"closest", SVO_TRACE_CLOSEST}, {"any", SVO_TRACE_ANY}, {"count", SVO_TRACE_COUNT}};

static const char voxel_source[] =
    "__kernel void trace_voxels(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global svo_voxel_hit *hits,\n"
    "                           float footprint)\n"
    "{\n"
    "    SVO_TREE_MAKE(tree);\n"
    "    const svo_ray ray = rays[get_global_id(0)];\n"
    "    svo_voxel_hit hit;\n"
    "    svo_trace_voxel(&tree, &ray, footprint, &hit);\n"
    "    hits[get_global_id(0)] = hit;\n"
    "}\n";

static void draw(const char *name, const opened *session, svo_tree *tree, const char *from, const svo_camera *camera)
{
    char part[LINE_NAME_BYTES];
    const size_t bytes = (size_t)PICTURE_WIDTH * PICTURE_HEIGHT * 4;
    uint8_t *rgba = malloc(bytes);
    for (size_t i = 0; i < sizeof views / sizeof views[0] && rgba != NULL; ++i) {
        const svo_render_options options = {.struct_size = sizeof options,
                                            .width = PICTURE_WIDTH,
                                            .height = PICTURE_HEIGHT,
                                            .camera = *camera,
                                            .view = views[i].view};
        (void)snprintf(part, sizeof part, "picture %s %s", from, views[i].name);
        const svo_status status =
            svo_render(svo_tree_target(tree), &options, svo_in_host(rgba), &(svo_submit){.queue = session->queue});
        if (status == SVO_OK) {
            line_print_digest(name, part, rgba, bytes);
        } else {
            line_print_status(name, part, status);
        }
    }
    free(rgba);
}

static void draw_all(const char *name, const opened *session, svo_tree *tree, const svo_tree_info *info)
{
    svo_camera camera = {.vertical_fov = 0};
    (void)svo_camera_fit(svo_tree_target(tree), (float)PICTURE_WIDTH / PICTURE_HEIGHT, &camera);
    line_print_digest(name, "camera", &camera, sizeof camera);
    draw(name, session, tree, "framed", &camera);
    for (int axis = 0; axis < 3; ++axis) {
        camera.eye[axis] = (float)(info->origin[axis] + info->edge * 0.5);
        camera.target[axis] = (float)(info->origin[axis] + (axis == 1 ? 0.4 : 0.0) * info->edge);
    }
    camera.vertical_fov = 1.2f;
    draw(name, session, tree, "inside", &camera);
}

/* From random points around the grid to random points in it. Every 16th ray ends early, every 100th has no
   direction. */
static void fill_rays(const svo_tree_info *info, svo_ray *rays)
{
    uint64_t state = 1;
    for (size_t i = 0; i < RAY_COUNT; ++i) {
        svo_ray *ray = &rays[i];
        for (int axis = 0; axis < 3; ++axis) {
            const double from = info->origin[axis] + info->edge * ((double)next_random(&state) * 3.0 - 1.0);
            const double to = info->origin[axis] + info->edge * (double)next_random(&state);
            ray->origin[axis] = (float)from;
            ray->direction[axis] = i % 100 == 99 ? 0.0f : (float)(to - from);
        }
        ray->t_min = i % 16 == 1 ? 0.25f : 0.0f;
        ray->t_max = i % 16 == 0 ? 0.5f : INFINITY;
    }
}

static void trace(const char *name, const opened *session, svo_tree *tree, const svo_ray *rays)
{
    char part[LINE_NAME_BYTES];
    svo_hit *hits = calloc(RAY_COUNT, sizeof *hits);
    for (size_t i = 0; i < sizeof traces / sizeof traces[0] && hits != NULL; ++i) {
        (void)snprintf(part, sizeof part, "rays %s", traces[i].name);
        const svo_status status =
            svo_trace_triangles(svo_tree_target(tree), svo_in_host(rays), svo_in_host(hits), RAY_COUNT, traces[i].flags,
                                &(svo_submit){.queue = session->queue});
        if (status == SVO_OK) {
            line_print_digest(name, part, hits, RAY_COUNT * sizeof *hits);
        } else {
            line_print_status(name, part, status);
        }
    }
    free(hits);
}

static void query_nearest(const char *name, const opened *session, svo_tree *tree, const svo_tree_info *info)
{
    uint64_t state = 2;
    svo_query_point *points = calloc(POINT_COUNT, sizeof *points);
    svo_nearest *results = calloc(POINT_COUNT, sizeof *results);
    if (points == NULL || results == NULL) {
        line_print_status(name, "nearest", SVO_OUT_OF_HOST_MEMORY);
        goto cleanup;
    }
    for (size_t i = 0; i < POINT_COUNT; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            points[i].position[axis] =
                (float)(info->origin[axis] + info->edge * ((double)next_random(&state) * 2.0 - 0.5));
        }
        points[i].max_distance = i % 4 == 0 ? (float)info->edge * 0.05f : INFINITY;
    }
    const svo_status status = svo_tree_nearest(tree, svo_in_host(points), svo_in_host(results), POINT_COUNT,
                                               &(svo_submit){.queue = session->queue});
    if (status == SVO_OK) {
        line_print_digest(name, "nearest", results, POINT_COUNT * sizeof *results);
    } else {
        line_print_status(name, "nearest", status);
    }
cleanup:
    free(results);
    free(points);
}

static cl_kernel make_voxel_kernel(const opened *session, cl_program *program)
{
    const char *texts[] = {svo_kernel_source(svo_tree_target(NULL)), voxel_source};
    const svo_device_info on = info_of_device(session->device);
    cl_int error = CL_SUCCESS;
    *program = clCreateProgramWithSource(on.context, 2, texts, NULL, &error);
    if (*program == NULL ||
        clBuildProgram(*program, 1, &on.device, svo_kernel_options(svo_tree_target(NULL)), NULL, NULL) != CL_SUCCESS) {
        return NULL;
    }
    return clCreateKernel(*program, "trace_voxels", &error);
}

/* Through a kernel of its own, as in an application. */
static void trace_voxels(const char *name, const opened *session, svo_tree *tree, const svo_ray *rays)
{
    const cl_context context = info_of_device(session->device).context;
    const size_t count = RAY_COUNT;
    const size_t hit_bytes = count * sizeof(svo_voxel_hit);
    const float footprint = 0.01f;
    cl_program program = NULL;
    cl_kernel kernel = make_voxel_kernel(session, &program);
    cl_mem ray_memory =
        clCreateBuffer(context, CL_MEM_COPY_HOST_PTR, count * sizeof *rays, (void *)(uintptr_t)rays, NULL);
    cl_mem hit_memory = clCreateBuffer(context, CL_MEM_READ_WRITE, hit_bytes, NULL, NULL);
    svo_voxel_hit *hits = malloc(hit_bytes);
    svo_status status = SVO_CL_ERROR;
    if (kernel == NULL || ray_memory == NULL || hit_memory == NULL || hits == NULL) {
        goto cleanup;
    }
    if (svo_kernel_set_arguments(svo_tree_target(tree), kernel, 0) != SVO_OK ||
        clSetKernelArg(kernel, SVO_TREE_ARGUMENTS, sizeof ray_memory, &ray_memory) != CL_SUCCESS ||
        clSetKernelArg(kernel, SVO_TREE_ARGUMENTS + 1, sizeof hit_memory, &hit_memory) != CL_SUCCESS ||
        clSetKernelArg(kernel, SVO_TREE_ARGUMENTS + 2, sizeof footprint, &footprint) != CL_SUCCESS ||
        clEnqueueNDRangeKernel(session->queue, kernel, 1, NULL, &count, NULL, 0, NULL, NULL) != CL_SUCCESS ||
        clEnqueueReadBuffer(session->queue, hit_memory, CL_TRUE, 0, hit_bytes, hits, 0, NULL, NULL) != CL_SUCCESS) {
        goto cleanup;
    }
    status = SVO_OK;
    line_print_digest(name, "voxels along rays", hits, hit_bytes);
cleanup:
    if (status != SVO_OK) {
        line_print_status(name, "voxels along rays", status);
    }
    free(hits);
    if (hit_memory != NULL) {
        clReleaseMemObject(hit_memory);
    }
    if (ray_memory != NULL) {
        clReleaseMemObject(ray_memory);
    }
    if (kernel != NULL) {
        clReleaseKernel(kernel);
    }
    if (program != NULL) {
        clReleaseProgram(program);
    }
}

/* The inside of the tree, or why it has none. */
static void fill(const char *name, const opened *session, const svo_tree *tree, svo_solid_rule rule)
{
    const svo_solid_options options = {.struct_size = sizeof options, .rule = rule, .color = {7, 8, 9, 255}};
    svo_solid_info info = SVO_SOLID_INFO_INIT;
    svo_compact *solid = NULL;
    char hash[SVO_HASH_TEXT_BYTES] = "";
    char part[LINE_NAME_BYTES];
    line_text line = {.used = 0};
    svo_status status = svo_solid_create(tree, &options, session->queue, &solid, &info);
    if (status == SVO_OK) {
        status = svo_compact_download(solid, session->queue);
    }
    if (status == SVO_OK) {
        status = svo_compact_hash(solid, hash);
    }
    (void)snprintf(part, sizeof part, "solid %s", svo_name(SVO_NAME_SOLID_RULE, rule));
    if (status == SVO_OK) {
        line_text_add(&line, "%s %" PRIu64 " inside in %" PRIu64 ", %" PRIu64 " ambiguous", hash, info.inside_voxels,
                      info.inside_leaves, info.ambiguous_voxels);
        line_print(name, part, line.text);
    } else {
        line_print_status(name, part, status);
    }
    svo_compact_destroy(&solid);
}

void describe_queries(const char *name, const opened *session, svo_tree *tree)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    line_text line = {.used = 0};
    svo_ray *rays = calloc(RAY_COUNT, sizeof *rays);
    if (rays == NULL) {
        line_print_status(name, "rays", SVO_OUT_OF_HOST_MEMORY);
        return;
    }
    svo_tree_get_info(tree, &info);
    fill_rays(&info, rays);
    trace(name, session, tree, rays);
    trace_voxels(name, session, tree, rays);
    describe_compact(name, session, tree, rays, RAY_COUNT);
    query_nearest(name, session, tree, &info);
    fill(name, session, tree, SVO_SOLID_WINDING);
    fill(name, session, tree, SVO_SOLID_PARITY);
    describe_lights(name, session, tree);
    draw_all(name, session, tree, &info);
    line_text_add(&line, "%" PRIu64, info_of_tree(tree).ray_bytes);
    line_print(name, "bytes of the hierarchy for rays", line.text);
    free(rays);
}
