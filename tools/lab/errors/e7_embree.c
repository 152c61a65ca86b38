/* SPDX-License-Identifier: MIT */
/*
 * Cosine-weighted rays from the points of a scene: those of ambient occlusion, which any hit within the range ends, and
 * those of one bounce, which find what is nearest. Both libraries get them in their own layout, before the clock
 * starts: svocl in device buffers, Embree as single rays or in packets, whichever takes it the least time.
 */
#include "errors/e7_embree.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "errors/hemisphere.h"
#include "measure/spread.h"
#include "support/info_of.h"
#include "support/input.h"

#define STRATA  16u /* 256 rays a point */
#define SEED    4u
#define LIFT    0x1p-18 /* of origins above their surface, in widths of the grid */
#define WIDTHS  3u
#define KINDS   2u
#define METHODS (1 + WIDTHS)

static const unsigned widths[WIDTHS] = {1, 8, 16};

typedef struct peer_rays {
    const error_run *run;
    const cone_truth *truth;
    const embree *peer;
    bool any;
    size_t count;
    svo_ray *rays;
    svo_hit *ours, *theirs;
    cl_mem device_rays, device_hits;
} peer_rays;

typedef struct peer_method {
    peer_rays *work;
    unsigned width; /* of Embree's packets; 0: svocl */
} peer_method;

void e7_embree_begin(const error_run *run)
{
    result_table *table = result_add_table(run->results, "e7-embree", "E7: rays of light, beside Embree", "");
    result_set_note(table,
                    "%u cosine-weighted, stratified rays from each point, made beforehand, the same for both. AO: any "
                    "hit within a quarter of the grid's width ends a ray. One bounce: the nearest hit. svocl has rays "
                    "and hits in device buffers. Embree traces single rays or packets of 8 or 16, whichever is the "
                    "fastest, on %u threads. Differ: rays that only one of the two ends. Ratio: svocl's time to "
                    "Embree's. %s; methods run interleaved.",
                    STRATA * STRATA, run->threads, run->rounds_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "rays", "");
    result_add_column(table, "packets", "");
    result_add_column(table, "differ", "%");
    result_add_column(table, "svocl", "ns/ray");
    result_add_column(table, "Embree", "ns/ray");
    result_add_column(table, "svocl, point", "µs");
    result_add_column(table, "Embree, point", "µs");
    result_add_column(table, "ratio", "");
}

static double trace(void *user)
{
    const peer_method *method = user;
    const peer_rays *work = method->work;
    if (method->width > 0) {
        const embree_call call = {.width = method->width, .any = work->any};
        return embree_trace(work->peer, call, work->rays, work->theirs, work->count, work->run->threads);
    }
    cl_event event = NULL;
    const double started_ms = input_now_ms();
    if (svo_trace_triangles(svo_tree_target(work->truth->tree), svo_in_buffer(work->device_rays),
                            svo_in_buffer(work->device_hits), work->count,
                            work->any ? SVO_TRACE_ANY : SVO_TRACE_CLOSEST,
                            &(svo_submit){.queue = work->run->opened.queue, .event = &event}) != SVO_OK) {
        return -1.0;
    }
    const cl_int error = clWaitForEvents(1, &event);
    const double ms = input_now_ms() - started_ms;
    clReleaseEvent(event);
    return error == CL_SUCCESS ? ms : -1.0;
}

static cl_mem make_buffer(const peer_rays *work, size_t bytes)
{
    cl_int error = CL_SUCCESS;
    const cl_context context = info_of_device(work->run->opened.device).context;
    cl_mem made = clCreateBuffer(context, CL_MEM_READ_WRITE, bytes, NULL, &error);
    return error == CL_SUCCESS ? made : NULL;
}

static bool allocate(peer_rays *work)
{
    work->rays = calloc(work->count, sizeof *work->rays);
    work->ours = calloc(work->count, sizeof *work->ours);
    work->theirs = calloc(work->count, sizeof *work->theirs);
    work->device_rays = make_buffer(work, work->count * sizeof *work->rays);
    work->device_hits = make_buffer(work, work->count * sizeof *work->ours);
    return work->rays != NULL && work->ours != NULL && work->theirs != NULL && work->device_rays != NULL &&
           work->device_hits != NULL;
}

static void release(peer_rays *work)
{
    free(work->rays);
    free(work->ours);
    free(work->theirs);
    if (work->device_rays != NULL) {
        clReleaseMemObject(work->device_rays);
    }
    if (work->device_hits != NULL) {
        clReleaseMemObject(work->device_hits);
    }
}

static bool set_rays(peer_rays *work, bool any)
{
    const cone_truth *truth = work->truth;
    const hemisphere_set set = {
        .strata = STRATA, .seed = SEED, .lift = LIFT * truth->edge, .length = any ? truth->range : (double)INFINITY};
    work->any = any;
    hemisphere_rays(&set, truth->points, truth->count, work->rays);
    return clEnqueueWriteBuffer(work->run->opened.queue, work->device_rays, CL_TRUE, 0,
                                work->count * sizeof *work->rays, work->rays, 0, NULL, NULL) == CL_SUCCESS;
}

/* The share of rays that end for one of the two alone, of the last runs; below 0 on failure. */
static double share_that_differs(const peer_rays *work)
{
    size_t differing = 0;
    if (clEnqueueReadBuffer(work->run->opened.queue, work->device_hits, CL_TRUE, 0, work->count * sizeof *work->ours,
                            work->ours, 0, NULL, NULL) != CL_SUCCESS) {
        return -1.0;
    }
    for (size_t i = 0; i < work->count; ++i) {
        differing += (work->ours[i].triangle == SVO_NO_TRIANGLE) != (work->theirs[i].triangle == SVO_NO_TRIANGLE);
    }
    return 100.0 * (double)differing / (double)work->count;
}

static void add_row(const peer_rays *work, const interleaved_method methods[METHODS], double differing)
{
    result_table *table = result_find(work->run->results, "e7-embree");
    size_t best = 1;
    for (size_t i = 2; i < METHODS; ++i) {
        best = methods[i].median_ms < methods[best].median_ms ? i : best;
    }
    const double ns[2] = {methods[0].median_ms * 1e6 / (double)work->count,
                          methods[best].median_ms * 1e6 / (double)work->count};
    result_add_text(table, "%s", work->truth->name);
    result_add_text(table, "%s", work->any ? "AO" : "one bounce");
    result_add_number(table, widths[best - 1]);
    result_add_number(table, differing);
    for (size_t i = 0; i < 2; ++i) {
        result_add_number(table, ns[i]);
    }
    for (size_t i = 0; i < 2; ++i) {
        result_add_number(table, ns[i] * 1e-3 * STRATA * STRATA);
    }
    result_add_number(table, ns[0] / ns[1]);
}

static bool measure_kind(peer_rays *work, bool any)
{
    peer_method runs[METHODS];
    interleaved_method methods[METHODS];
    for (size_t i = 0; i < METHODS; ++i) {
        runs[i] = (peer_method){.work = work, .width = i > 0 ? widths[i - 1] : 0};
        methods[i] = (interleaved_method){.work_ms = trace, .user = &runs[i]};
    }
    if (!set_rays(work, any) || !interleave_measure(methods, METHODS, work->run->rounds)) {
        return false;
    }
    const double differing = share_that_differs(work);
    add_row(work, methods, differing);
    return differing >= 0;
}

bool e7_embree_measure(const error_run *run, const cone_truth *truth, const embree *peer)
{
    peer_rays work = {.run = run, .truth = truth, .peer = peer, .count = truth->count * STRATA * STRATA};
    bool worked = peer == NULL || allocate(&work);
    for (unsigned kind = 0; kind < KINDS && worked && peer != NULL; ++kind) {
        worked = measure_kind(&work, kind == 0);
    }
    release(&work);
    return worked;
}
