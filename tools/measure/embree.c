/* SPDX-License-Identifier: MIT */
/* The only file that knows Embree. Built without it, there is no rival to measure against. */
#include "measure/embree.h"

#ifdef SVOCL_EMBREE

#include <embree3/rtcore.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/input.h"

/* Rays a thread takes at a time. */
#define PORTION       4096u
#define THREADS_MAX   256u
#define VERSION_BYTES 32

struct embree {
    RTCDevice device;
    RTCScene scene;
    double build_ms;
    char version[VERSION_BYTES];
};

bool embree_is_there(void)
{
    return true;
}

static bool add_mesh(embree *made, const float *vertices, size_t vertex_count, const uint32_t *indices,
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
        rtcAttachGeometry(made->scene, geometry);
        rtcCommitScene(made->scene);
        made->build_ms = input_now_ms() - start_ms;
    }
    rtcReleaseGeometry(geometry);
    return there && rtcGetDeviceError(made->device) == RTC_ERROR_NONE;
}

embree *embree_create(const float *vertices, size_t vertex_count, const uint32_t *indices, size_t triangle_count,
                      bool robust)
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
    if (made->scene == NULL || !add_mesh(made, vertices, vertex_count, indices, triangle_count)) {
        embree_destroy(&made);
    }
    return made;
}

void embree_destroy(embree **rival)
{
    if (*rival == NULL) {
        return;
    }
    if ((*rival)->scene != NULL) {
        rtcReleaseScene((*rival)->scene);
    }
    if ((*rival)->device != NULL) {
        rtcReleaseDevice((*rival)->device);
    }
    free(*rival);
    *rival = NULL;
}

double embree_build_ms(const embree *rival)
{
    return rival->build_ms;
}

const char *embree_version(const embree *rival)
{
    return rival->version;
}

typedef struct crew {
    const embree *rival;
    const svo_ray *rays;
    svo_hit *hits;
    size_t ray_count;
    atomic_size_t next;
} crew;

static void trace_one(RTCScene tree, struct RTCIntersectContext *context, const svo_ray *ray, svo_hit *hit)
{
    struct RTCRayHit query = {.ray = {.org_x = ray->origin[0],
                                      .org_y = ray->origin[1],
                                      .org_z = ray->origin[2],
                                      .tnear = ray->t_min,
                                      .dir_x = ray->direction[0],
                                      .dir_y = ray->direction[1],
                                      .dir_z = ray->direction[2],
                                      .tfar = ray->t_max,
                                      .mask = UINT32_MAX},
                              .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
    rtcIntersect1(tree, context, &query);
    const bool met = query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    hit->t = met ? query.ray.tfar : INFINITY;
    hit->triangle = met ? query.hit.primID : SVO_NO_TRIANGLE;
    hit->u = query.hit.u;
    hit->v = query.hit.v;
}

static void *work(void *shared)
{
    crew *all = shared;
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (;;) {
        const size_t first = atomic_fetch_add(&all->next, PORTION);
        if (first >= all->ray_count) {
            return NULL;
        }
        const size_t end = first + PORTION < all->ray_count ? first + PORTION : all->ray_count;
        for (size_t i = first; i < end; ++i) {
            trace_one(all->rival->scene, &context, &all->rays[i], &all->hits[i]);
        }
    }
}

double embree_trace(const embree *rival, const svo_ray *rays, svo_hit *hits, size_t ray_count, unsigned thread_count)
{
    crew all = {.rival = rival, .rays = rays, .hits = hits, .ray_count = ray_count};
    pthread_t threads[THREADS_MAX];
    unsigned started = 0;
    atomic_init(&all.next, 0);
    thread_count = thread_count < THREADS_MAX ? thread_count : THREADS_MAX;
    const double start_ms = input_now_ms();
    while (started + 1 < thread_count && pthread_create(&threads[started], NULL, work, &all) == 0) {
        ++started;
    }
    work(&all);
    for (unsigned i = 0; i < started; ++i) {
        pthread_join(threads[i], NULL);
    }
    return started + 1 == thread_count ? input_now_ms() - start_ms : -1.0;
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

void embree_destroy(embree **rival)
{
    *rival = NULL;
}

double embree_build_ms(const embree *rival)
{
    (void)rival;
    return -1.0;
}

const char *embree_version(const embree *rival)
{
    (void)rival;
    return "";
}

double embree_trace(const embree *rival, const svo_ray *rays, svo_hit *hits, size_t ray_count, unsigned thread_count)
{
    (void)rival;
    (void)rays;
    (void)hits;
    (void)ray_count;
    (void)thread_count;
    return -1.0;
}

#endif
