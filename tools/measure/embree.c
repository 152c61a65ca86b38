/* SPDX-License-Identifier: MIT */
/* The only file that uses Embree. Without the library its functions say so and fail. */
#include "measure/embree.h"

#ifdef SVOCL_EMBREE

#include <embree3/rtcore.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "measure/threads.h"
#include "support/input.h"

#define RAYS_PER_CHUNK 4096u
#define VERSION_BYTES  32

struct embree {
    RTCDevice device;
    RTCScene scene;
    RTCScene placed; /* whose instances scene holds; NULL: none */
    double build_ms;
    char version[VERSION_BYTES];
};

bool embree_is_there(void)
{
    return true;
}

static bool add_mesh(embree *made, RTCScene into, const float *vertices, size_t vertex_count, const uint32_t *indices,
                     size_t triangle_count)
{
    RTCGeometry geometry = rtcNewGeometry(made->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *points = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                            vertex_count);
    uint32_t *corners = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                3 * sizeof(uint32_t), triangle_count);
    const bool there = points != NULL && corners != NULL;
    if (there) {
        memcpy(points, vertices, vertex_count * 3 * sizeof(float));
        memcpy(corners, indices, triangle_count * 3 * sizeof(uint32_t));
        const double start_ms = input_now_ms();
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(into, geometry);
        rtcCommitScene(into);
        made->build_ms = input_now_ms() - start_ms;
    }
    rtcReleaseGeometry(geometry);
    return there && rtcGetDeviceError(made->device) == RTC_ERROR_NONE;
}

/* A device and an empty scene; NULL on failure. */
static embree *open_peer(bool robust)
{
    embree *made = calloc(1, sizeof *made);
    if (made == NULL) {
        return NULL;
    }
    made->device = rtcNewDevice(NULL);
    if (made->device != NULL) {
        snprintf(made->version, sizeof made->version, "%d.%d.%d",
                 (int)rtcGetDeviceProperty(made->device, RTC_DEVICE_PROPERTY_VERSION_MAJOR),
                 (int)rtcGetDeviceProperty(made->device, RTC_DEVICE_PROPERTY_VERSION_MINOR),
                 (int)rtcGetDeviceProperty(made->device, RTC_DEVICE_PROPERTY_VERSION_PATCH));
        made->scene = rtcNewScene(made->device);
        rtcSetSceneFlags(made->scene, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    }
    if (made->scene == NULL) {
        embree_destroy(&made);
    }
    return made;
}

embree *embree_create(const float *vertices, size_t vertex_count, const uint32_t *indices, size_t triangle_count,
                      bool robust)
{
    embree *made = open_peer(robust);
    if (made != NULL && !add_mesh(made, made->scene, vertices, vertex_count, indices, triangle_count)) {
        embree_destroy(&made);
    }
    return made;
}

static void add_instances(embree *made, const float (*matrices)[12], size_t matrix_count)
{
    const double start_ms = input_now_ms();
    for (size_t i = 0; i < matrix_count; ++i) {
        RTCGeometry instance = rtcNewGeometry(made->device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(instance, made->placed);
        rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, matrices[i]);
        rtcCommitGeometry(instance);
        rtcAttachGeometry(made->scene, instance);
        rtcReleaseGeometry(instance);
    }
    rtcCommitScene(made->scene);
    made->build_ms = input_now_ms() - start_ms;
}

embree *embree_create_placed(const float *vertices, size_t vertex_count, const uint32_t *indices, size_t triangle_count,
                             const float (*matrices)[12], size_t matrix_count)
{
    embree *made = open_peer(false);
    if (made == NULL) {
        return NULL;
    }
    made->placed = rtcNewScene(made->device);
    if (made->placed == NULL || !add_mesh(made, made->placed, vertices, vertex_count, indices, triangle_count)) {
        embree_destroy(&made);
        return NULL;
    }
    add_instances(made, matrices, matrix_count);
    if (rtcGetDeviceError(made->device) != RTC_ERROR_NONE) {
        embree_destroy(&made);
    }
    return made;
}

void embree_destroy(embree **peer)
{
    if (*peer == NULL) {
        return;
    }
    if ((*peer)->scene != NULL) {
        rtcReleaseScene((*peer)->scene);
    }
    if ((*peer)->placed != NULL) {
        rtcReleaseScene((*peer)->placed);
    }
    if ((*peer)->device != NULL) {
        rtcReleaseDevice((*peer)->device);
    }
    free(*peer);
    *peer = NULL;
}

double embree_build_ms(const embree *peer)
{
    return peer->build_ms;
}

const char *embree_version(const embree *peer)
{
    return peer->version;
}

typedef struct ray_batch {
    const embree *peer;
    const svo_ray *rays;
    svo_hit *hits;
} ray_batch;

static struct RTCRay ray_query(const svo_ray *ray)
{
    return (struct RTCRay){.org_x = ray->origin[0],
                           .org_y = ray->origin[1],
                           .org_z = ray->origin[2],
                           .tnear = ray->t_min,
                           .dir_x = ray->direction[0],
                           .dir_y = ray->direction[1],
                           .dir_z = ray->direction[2],
                           .tfar = ray->t_max,
                           .mask = UINT32_MAX};
}

static void trace_one(RTCScene tree, struct RTCIntersectContext *context, const svo_ray *ray, svo_hit *hit)
{
    struct RTCRayHit query = {.ray = ray_query(ray), .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
    rtcIntersect1(tree, context, &query);
    const bool met = query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    hit->t = met ? query.ray.tfar : INFINITY;
    hit->triangle = met ? query.hit.primID : SVO_NO_TRIANGLE;
    hit->u = query.hit.u;
    hit->v = query.hit.v;
}

static void trace_chunk(void *user, unsigned thread_index, size_t begin, size_t end)
{
    const ray_batch *batch = user;
    struct RTCIntersectContext context;
    (void)thread_index;
    rtcInitIntersectContext(&context);
    for (size_t i = begin; i < end; ++i) {
        trace_one(batch->peer->scene, &context, &batch->rays[i], &batch->hits[i]);
    }
}

/* rtcOccluded1 makes tfar of an occluded ray minus infinity. */
static void occlude_chunk(void *user, unsigned thread_index, size_t begin, size_t end)
{
    const ray_batch *batch = user;
    struct RTCIntersectContext context;
    (void)thread_index;
    rtcInitIntersectContext(&context);
    for (size_t i = begin; i < end; ++i) {
        struct RTCRay query = ray_query(&batch->rays[i]);
        rtcOccluded1(batch->peer->scene, &context, &query);
        const bool met = query.tfar < 0;
        batch->hits[i] = (svo_hit){.t = met ? 0 : INFINITY, .triangle = met ? 0 : SVO_NO_TRIANGLE};
    }
}

/* The milliseconds, below 0 on failure. */
static double run_batch(ray_batch *batch, size_t ray_count, unsigned thread_count, threads_work *chunk)
{
    const double start_ms = input_now_ms();
    thread_count = thread_count < THREADS_MAX ? thread_count : THREADS_MAX;
    const unsigned took_part = threads_run(thread_count, ray_count, RAYS_PER_CHUNK, chunk, batch);
    return took_part == thread_count ? input_now_ms() - start_ms : -1.0;
}

double embree_trace(const embree *peer, const svo_ray *rays, svo_hit *hits, size_t ray_count, unsigned thread_count)
{
    ray_batch batch = {.peer = peer, .rays = rays, .hits = hits};
    return run_batch(&batch, ray_count, thread_count, trace_chunk);
}

double embree_occluded(const embree *peer, const svo_ray *rays, svo_hit *hits, size_t ray_count, unsigned thread_count)
{
    ray_batch batch = {.peer = peer, .rays = rays, .hits = hits};
    return run_batch(&batch, ray_count, thread_count, occlude_chunk);
}

#else

bool embree_is_there(void)
{
    return false;
}

embree *embree_create(const float *vertices, size_t vertex_count, const uint32_t *indices, size_t triangle_count,
                      bool robust)
{
    (void)robust;
    (void)vertices;
    (void)vertex_count;
    (void)indices;
    (void)triangle_count;
    return NULL;
}

embree *embree_create_placed(const float *vertices, size_t vertex_count, const uint32_t *indices, size_t triangle_count,
                             const float (*matrices)[12], size_t matrix_count)
{
    (void)matrices;
    (void)matrix_count;
    return embree_create(vertices, vertex_count, indices, triangle_count, false);
}

void embree_destroy(embree **peer)
{
    *peer = NULL;
}

double embree_build_ms(const embree *peer)
{
    (void)peer;
    return -1.0;
}

const char *embree_version(const embree *peer)
{
    (void)peer;
    return "";
}

double embree_trace(const embree *peer, const svo_ray *rays, svo_hit *hits, size_t ray_count, unsigned thread_count)
{
    (void)peer;
    (void)rays;
    (void)hits;
    (void)ray_count;
    (void)thread_count;
    return -1.0;
}

double embree_occluded(const embree *peer, const svo_ray *rays, svo_hit *hits, size_t ray_count, unsigned thread_count)
{
    return embree_trace(peer, rays, hits, ray_count, thread_count);
}

#endif
