/* SPDX-License-Identifier: MIT */
/* Builds, makes the sets of rays, and measures. */
#include "bench/ray_run.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "measure/quantization.h"
#include "measure/ray_sets.h"
#include "support/info_of.h"

/* Embree's builds; the first one's calls are measured one by one. */
static const struct {
    const char *name;
    embree_options options;
} builds[RAY_BUILDS] = {{"medium", {.quality = EMBREE_MEDIUM}},
                        {"low", {.quality = EMBREE_LOW}},
                        {"high", {.quality = EMBREE_HIGH}},
                        {"robust", {.quality = EMBREE_MEDIUM, .robust = true}}};

static const unsigned widths[RAY_CALLS] = {1, 8, 16};

/* ---- the scene ---- */

/* Quantizes coordinates to integers 0 .. 2^20 - 1. Coordinates that are not finite stay so, and the build refuses their
   triangles. */
static int snap_mesh(ray_run *run)
{
    const svo_mesh *mesh = run->work.source.mesh;
    run->positions = quantization_positions(mesh);
    if (run->positions == NULL) {
        return program_fail(run->state, PROGRAM_FAILED, "out of memory for %zu vertices", mesh->vertex_count);
    }
    run->snapped = quantization_mesh(mesh, run->positions);
    run->work.source.mesh = &run->snapped;
    return PROGRAM_DONE;
}

#define TILE          4u /* columns and rows of 16 rays */
#define CLOSE_SHARE   0.25f /* of the distance to what the camera looks at */
#define OCCLUSION_MAX 0.05 /* of the diagonal of the box */

static cl_mem make_buffer(const ray_run *run, size_t bytes)
{
    cl_int error = CL_SUCCESS;
    return clCreateBuffer(info_of_device(run->work.opened.device).context, CL_MEM_READ_WRITE, bytes, NULL, &error);
}

/* Embree's BVHs of the triangles that the tree holds. */
static int open_peers(ray_run *run)
{
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    const svo_tree_info *info = &run->work.result.info;
    svo_tree_get_arrays(run->work.result.tree, &arrays);
    float *vertices = calloc((size_t)info->vertex_count * 3 + 1, sizeof *vertices);
    bool opened = vertices != NULL;
    for (size_t i = 0; opened && i < (size_t)info->vertex_count * 3; ++i) {
        vertices[i] = (float)arrays.vertices[i];
    }
    for (size_t i = 0; opened && i < RAY_BUILDS; ++i) {
        embree_options asked = builds[i].options;
        asked.isa = run->state->options.isa;
        run->peers[i] = embree_create(vertices, (size_t)info->vertex_count, arrays.indices,
                                      (size_t)info->list_triangle_count, &asked);
        opened = run->peers[i] != NULL;
    }
    free(vertices);
    return opened ? PROGRAM_DONE : program_fail(run->state, PROGRAM_FAILED, "Embree cannot take the triangles");
}

static int open_grid(ray_run *run)
{
    const uint32_t depth = run->work.result.info.depth;
    if (depth > GRID_RAYS_DEPTH_MAX) {
        return program_fail(run->state, PROGRAM_WRONG_USAGE, "--vs grid takes depths up to %d, not %u",
                            GRID_RAYS_DEPTH_MAX, depth);
    }
    run->grid = grid_rays_create(&run->work.opened, run->work.result.tree);
    run->grid_hits = make_buffer(run, run->ray_count * sizeof(svo_hit));
    return run->grid != NULL && run->grid_hits != NULL
               ? PROGRAM_DONE
               : program_fail(run->state, PROGRAM_FAILED, "the grid cannot be made: no memory, or no kernel");
}

/* Opens what --vs asks for. */
static int open_rivals(ray_run *run)
{
    const int versus = run->state->options.versus;
    return versus == OPTION_VERSUS_EMBREE ? open_peers(run)
           : versus == OPTION_VERSUS_GRID ? open_grid(run)
                                          : PROGRAM_DONE;
}

bool ray_run_has_rivals(const ray_run *run)
{
    return run->peers[0] != NULL || run->grid != NULL;
}

/* ---- rays ---- */

static void find_bounds(const ray_run *run, double low[3], double high[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = HUGE_VAL;
        high[axis] = 0;
    }
    for (size_t i = 0; i < run->snapped.vertex_count * 3; ++i) {
        const double at = (double)run->positions[i];
        low[i % 3] = isfinite(at) ? fmin(low[i % 3], at) : low[i % 3];
        high[i % 3] = isfinite(at) ? fmax(high[i % 3], at) : high[i % 3];
    }
}

static void move_close(svo_camera *camera)
{
    for (int axis = 0; axis < 3; ++axis) {
        camera->eye[axis] = camera->target[axis] + CLOSE_SHARE * (camera->eye[axis] - camera->target[axis]);
    }
}

/* The rays of a set; false where there are none. Those that start at hits need the sets that were traced before. */
static bool fill_set(const ray_run *run, ray_set_kind kind, ray_set *set)
{
    svo_camera camera = {.vertical_fov = 0};
    const svo_ray *primary = run->sets[RAY_SET_PRIMARY].rays;
    double low[3];
    double high[3];
    find_bounds(run, low, high);
    const double diagonal = hypot(hypot(high[0] - low[0], high[1] - low[1]), high[2] - low[2]);
    (void)svo_camera_fit(svo_tree_target(run->work.result.tree), 1.0f, &camera);
    switch (kind) {
    case RAY_SET_PRIMARY:
        ray_set_primary(&camera, TILE, run->ray_count, set->rays);
        return true;
    case RAY_SET_ROWS:
        ray_set_primary(&camera, 1, run->ray_count, set->rays);
        return true;
    case RAY_SET_CLOSE:
        move_close(&camera);
        ray_set_primary(&camera, TILE, run->ray_count, set->rays);
        return true;
    case RAY_SET_SHADOW:
        return ray_set_shadow(&camera, primary, run->primary, run->ray_count, set->rays);
    case RAY_SET_BOUNCE:
        return ray_set_diffuse(primary, run->primary, INFINITY, run->ray_count, set->rays);
    case RAY_SET_OCCLUSION:
        return ray_set_diffuse(primary, run->primary, (float)(OCCLUSION_MAX * diagonal), run->ray_count, set->rays);
    case RAY_SET_INCOHERENT:
        ray_set_incoherent(low, high, run->ray_count, set->rays);
        return true;
    case RAY_SET_THROUGH:
        return ray_set_through(run->sets[RAY_SET_INCOHERENT].rays, run->ours, run->ray_count, set->rays);
    case RAY_SET_MISSES:
        ray_set_misses(low, high, run->ray_count, set->rays);
        return true;
    case RAY_SETS:
        break;
    }
    return false;
}

static int make_sets(ray_run *run)
{
    static const char *const names[RAY_SETS] = {
        [RAY_SET_PRIMARY] = "primary",       [RAY_SET_ROWS] = "primary, by rows",
        [RAY_SET_CLOSE] = "close up",        [RAY_SET_SHADOW] = "shadow",
        [RAY_SET_BOUNCE] = "diffuse bounce", [RAY_SET_OCCLUSION] = "ambient occlusion",
        [RAY_SET_INCOHERENT] = "incoherent", [RAY_SET_THROUGH] = "misses through the box",
        [RAY_SET_MISSES] = "misses"};
    const size_t count = run->ray_count;
    bool there = true;
    for (int k = 0; k < RAY_SETS; ++k) {
        run->sets[k].name = names[k];
        run->sets[k].any = k == RAY_SET_SHADOW || k == RAY_SET_OCCLUSION;
        run->sets[k].rays = calloc(count, sizeof(svo_ray));
        there = there && run->sets[k].rays != NULL;
    }
    run->ours = calloc(count, sizeof(svo_hit));
    run->primary = calloc(count, sizeof(svo_hit));
    run->theirs = calloc(count, sizeof(svo_hit));
    run->spare = calloc(count, sizeof(svo_hit));
    run->device_rays = make_buffer(run, count * sizeof(svo_ray));
    run->device_hits = make_buffer(run, count * sizeof(svo_hit));
    return there && run->ours != NULL && run->primary != NULL && run->theirs != NULL && run->spare != NULL &&
                   run->device_rays != NULL && run->device_hits != NULL
               ? PROGRAM_DONE
               : program_fail(run->state, PROGRAM_FAILED, "out of memory for %zu rays", count);
}

/* ---- rivals ---- */

static void list_rivals(const ray_run *run, ray_set *set)
{
    set->rival_count = 0;
    if (run->grid != NULL) {
        set->rivals[set->rival_count++] = (ray_rival){.build = ""};
    }
    for (size_t i = 0; i < RAY_CALLS && run->peers[0] != NULL; ++i) {
        set->rivals[set->rival_count++] =
            (ray_rival){.build = builds[0].name, .peer = run->peers[0], .width = widths[i]};
    }
    for (size_t i = 1; i < RAY_BUILDS && run->peers[0] != NULL; ++i) {
        set->rivals[set->rival_count++] = (ray_rival){.build = builds[i].name, .peer = run->peers[i]};
    }
}

void ray_rival_call(const ray_rival *rival, char *text, size_t text_bytes)
{
    if (rival->peer == NULL) {
        (void)snprintf(text, text_bytes, "grid");
    } else {
        (void)snprintf(text, text_bytes, "rtc%s%u", rival->call.any ? "Occluded" : "Intersect", rival->call.width);
    }
}

/* ---- measuring ---- */

/* One pass of svocl, from the call to completion; below 0 on failure. */
static double trace_ours(const ray_run *run, const ray_set *set)
{
    const session *opened = &run->work.opened;
    cl_event event = NULL;
    const double start_ms = input_now_ms();
    if (svo_trace_triangles(svo_tree_target(run->work.result.tree), svo_in_buffer(run->device_rays),
                            svo_in_buffer(run->device_hits), run->ray_count,
                            set->any ? SVO_TRACE_ANY : SVO_TRACE_CLOSEST,
                            &(svo_submit){.queue = opened->queue, .event = &event}) != SVO_OK) {
        return -1.0;
    }
    const cl_int error = clWaitForEvents(1, &event);
    const double ms = input_now_ms() - start_ms;
    clReleaseEvent(event);
    return error == CL_SUCCESS ? ms : -1.0;
}

static double trace_theirs(const ray_run *run, const ray_set *set, const ray_rival *rival)
{
    return rival->peer == NULL
               ? grid_rays_trace(run->grid, run->device_rays, run->grid_hits, run->ray_count)
               : embree_trace(rival->peer, rival->call, set->rays, rival == &set->rivals[0] ? run->theirs : run->spare,
                              run->ray_count, run->threads);
}

/* Chooses the call of a rival: what it declares of the rays' coherence, and the width unless that is given. False on
   failure. */
static bool choose_call(const ray_run *run, const ray_set *set, ray_rival *rival)
{
    embree_call best = {.width = 0};
    double best_ms = HUGE_VAL;
    for (size_t i = 0; i < (size_t)2 * RAY_CALLS && rival->peer != NULL; ++i) {
        rival->call = (embree_call){.width = widths[i / 2], .any = set->any, .coherent = i % 2 != 0};
        const bool is_asked = rival->width == 0 || rival->width == rival->call.width;
        const double ms = is_asked ? trace_theirs(run, set, rival) : HUGE_VAL;
        if (ms < 0) {
            return false;
        }
        best = ms < best_ms ? rival->call : best;
        best_ms = fmin(ms, best_ms);
    }
    rival->call = best;
    return rival->peer != NULL || trace_theirs(run, set, rival) >= 0;
}

/* Reads back the hits of what ran on the device. */
static bool read_hits(const ray_run *run)
{
    const size_t bytes = run->ray_count * sizeof(svo_hit);
    cl_command_queue queue = run->work.opened.queue;
    return clEnqueueReadBuffer(queue, run->device_hits, CL_TRUE, 0, bytes, run->ours, 0, NULL, NULL) == CL_SUCCESS &&
           (run->grid == NULL ||
            clEnqueueReadBuffer(queue, run->grid_hits, CL_TRUE, 0, bytes, run->theirs, 0, NULL, NULL) == CL_SUCCESS);
}

/* Rounds of svocl and each rival in turn. Each timed run follows one of the same that does not count: threads that
   slept while another ran wake up on a processor that is still busy, and caches hold the other's data. times: svocl's,
   then those of each rival and their ratios to svocl's. */
static bool run_rounds(const ray_run *run, ray_set *set, double *times)
{
    bool worked = trace_ours(run, set) >= 0;
    for (size_t i = 0; i < set->rival_count && worked; ++i) {
        worked = choose_call(run, set, &set->rivals[i]);
    }
    for (size_t round = 0; round < run->repeats && worked; ++round) {
        const double ours = trace_ours(run, set) >= 0 ? trace_ours(run, set) : -1.0;
        worked = ours >= 0;
        times[round] = ours;
        for (size_t i = 0; i < set->rival_count && worked; ++i) {
            double *of_rival = times + (1 + 2 * i) * run->repeats;
            const ray_rival *rival = &set->rivals[i];
            const double theirs = trace_theirs(run, set, rival) >= 0 ? trace_theirs(run, set, rival) : -1.0;
            worked = theirs >= 0;
            of_rival[round] = theirs;
            of_rival[run->repeats + round] = theirs / ours;
        }
    }
    return worked;
}

static void summarize(const ray_run *run, ray_set *set, double *times)
{
    set->ours_ms = spread_of(times, run->repeats);
    set->best = 0;
    for (size_t i = 0; i < set->rival_count; ++i) {
        double *of_rival = times + (1 + 2 * i) * run->repeats;
        set->rivals[i].ms = spread_of(of_rival, run->repeats);
        set->rivals[i].ratio = spread_of(of_rival + run->repeats, run->repeats);
        if (set->rivals[i].width != 0 && set->rivals[i].ms.median < set->rivals[set->best].ms.median) {
            set->best = i;
        }
    }
    set->is_measured = true;
}

static int measure_set(ray_run *run, ray_set *set)
{
    const size_t bytes = run->ray_count * sizeof(svo_ray);
    double *times = calloc((1 + 2 * RAY_RIVALS_MAX) * run->repeats, sizeof *times);
    list_rivals(run, set);
    bool worked = times != NULL && clEnqueueWriteBuffer(run->work.opened.queue, run->device_rays, CL_TRUE, 0, bytes,
                                                        set->rays, 0, NULL, NULL) == CL_SUCCESS;
    worked = worked && run_rounds(run, set, times) && read_hits(run);
    if (worked) {
        summarize(run, set, times);
    }
    free(times);
    return worked ? PROGRAM_DONE : program_fail_library(run->state, svo_device_message(run->work.opened.device));
}

static void judge_set(ray_run *run, ray_set *set)
{
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    const svo_tree_info *info = &run->work.result.info;
    svo_tree_get_arrays(run->work.result.tree, &arrays);
    const oracle_ray_scene snapped = {.vertices = arrays.vertices,
                                      .indices = arrays.indices,
                                      .triangle_count = (size_t)info->list_triangle_count,
                                      .origin = {info->origin[0], info->origin[1], info->origin[2]},
                                      .scale = info->scale};
    const svo_hit *theirs = ray_run_has_rivals(run) ? run->theirs : NULL;
    if (set->any) {
        set->verdict = ray_judge_occlusion(&snapped, set->rays, run->ours, theirs, run->ray_count);
        return;
    }
    for (size_t i = 0; theirs != NULL && i < run->ray_count; ++i) { /* its indices do not count refused triangles */
        const uint32_t triangle = run->theirs[i].triangle;
        run->theirs[i].triangle = triangle != SVO_NO_TRIANGLE ? arrays.triangle_ids[triangle] : triangle;
    }
    set->verdict = ray_judge(&snapped, arrays.triangle_ids, set->rays, run->ours, theirs, run->ray_count);
}

double ray_run_rate(const ray_run *run, double ms)
{
    return ms > 0 ? (double)run->ray_count / ms * 1e-3 : 0.0;
}

/* ---- the run ---- */

static int prepare(ray_run *run)
{
    program *state = run->state;
    int exit_code = input_open(state, &run->work.source);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = session_open(state, &run->work.opened);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = snap_mesh(run);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = job_build(state, SVO_NEED_RAYS, &run->work);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = open_rivals(run);
    return exit_code != PROGRAM_DONE ? exit_code : make_sets(run);
}

/* The grid knows closest hits inside its bounds alone. */
static bool is_asked(const ray_run *run, ray_set_kind kind)
{
    return run->grid == NULL || kind == RAY_SET_PRIMARY || kind == RAY_SET_INCOHERENT;
}

int ray_run_all(ray_run *run)
{
    int exit_code = prepare(run);
    for (int k = 0; k < RAY_SETS && exit_code == PROGRAM_DONE; ++k) {
        progress_step(run->state->progress, "tracing rays");
        if (!is_asked(run, (ray_set_kind)k) || !fill_set(run, (ray_set_kind)k, &run->sets[k])) {
            continue;
        }
        exit_code = measure_set(run, &run->sets[k]);
        if (exit_code == PROGRAM_DONE && k == RAY_SET_PRIMARY) {
            memcpy(run->primary, run->ours, run->ray_count * sizeof *run->primary);
        }
        if (exit_code == PROGRAM_DONE) {
            judge_set(run, &run->sets[k]);
        }
    }
    return exit_code;
}

void ray_run_release(ray_run *run)
{
    cl_mem buffers[] = {run->device_rays, run->device_hits, run->grid_hits};
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        if (buffers[i] != NULL) {
            clReleaseMemObject(buffers[i]);
        }
    }
    for (int k = 0; k < RAY_SETS; ++k) {
        free(run->sets[k].rays);
    }
    for (int i = 0; i < RAY_BUILDS; ++i) {
        embree_destroy(&run->peers[i]);
    }
    free(run->ours);
    free(run->primary);
    free(run->theirs);
    free(run->spare);
    grid_rays_destroy(&run->grid);
    job_release(&run->work);
    free(run->positions);
}
