/* SPDX-License-Identifier: MIT */
/*
 * The only file that uses Embree. It opens the library when it is first asked for, so that a program that was built
 * with its headers needs it for nothing else. Without it the functions say so and fail.
 */
#include "measure/embree.h"

#ifdef SVOCL_EMBREE

#include <dlfcn.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if SVOCL_EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include "path/threads.h"
#include "support/input.h"

#define RAYS_PER_CHUNK 4096u
#define VERSION_BYTES  32
#define CONFIG_BYTES   32
#define GREATEST       0x1p60f /* of a ray's numbers; Embree refuses more than 1.8e18 */

/* ---- the library ---- */

/* What differs between versions 3 and 4: names, and what a query takes beside its rays. QUERY_WITH puts both in order;
   kind is intersect or occluded. */
#if SVOCL_EMBREE >= 4
#define LIBRARY "libembree4.so.4"
#define PACKAGE "libembree4-4"

typedef struct query_arguments {
    struct RTCIntersectArguments intersect;
    struct RTCOccludedArguments occluded;
} query_arguments;

#define QUERY_WITH(arguments, kind, query) (query), &(arguments)->kind

static query_arguments make_arguments(bool coherent)
{
    query_arguments made;
    rtcInitIntersectArguments(&made.intersect);
    rtcInitOccludedArguments(&made.occluded);
    made.intersect.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    made.occluded.flags = made.intersect.flags;
    return made;
}
#else
#define LIBRARY "libembree3.so.3"
#define PACKAGE "libembree3-3"

typedef struct query_arguments {
    struct RTCIntersectContext context;
} query_arguments;

#define QUERY_WITH(arguments, kind, query) &(arguments)->context, (query)

static query_arguments make_arguments(bool coherent)
{
    query_arguments made;
    rtcInitIntersectContext(&made.context);
    made.context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    return made;
}
#endif

#define FUNCTIONS(X)                \
    X(rtcNewDevice)                 \
    X(rtcReleaseDevice)             \
    X(rtcGetDeviceProperty)         \
    X(rtcGetDeviceError)            \
    X(rtcNewScene)                  \
    X(rtcReleaseScene)              \
    X(rtcCommitScene)               \
    X(rtcSetSceneFlags)             \
    X(rtcSetSceneBuildQuality)      \
    X(rtcNewGeometry)               \
    X(rtcReleaseGeometry)           \
    X(rtcCommitGeometry)            \
    X(rtcAttachGeometry)            \
    X(rtcSetNewGeometryBuffer)      \
    X(rtcSetGeometryInstancedScene) \
    X(rtcSetGeometryTransform)      \
    X(rtcIntersect1)                \
    X(rtcIntersect8)                \
    X(rtcIntersect16)               \
    X(rtcOccluded1)                 \
    X(rtcOccluded8)                 \
    X(rtcOccluded16)

static struct {
    bool is_tried;
    void *library; /* NULL: it cannot be opened, or lacks a function */
#define MEMBER(name) __typeof__ (&(name))(name);
    FUNCTIONS(MEMBER)
#undef MEMBER
} api;

static void look_up(void **function, const char *name)
{
    *function = api.library != NULL ? dlsym(api.library, name) : NULL;
    if (*function == NULL) {
        api.library = NULL;
    }
}

bool embree_is_there(void)
{
    if (!api.is_tried) {
        api.is_tried = true;
        api.library = dlopen(LIBRARY, RTLD_NOW | RTLD_LOCAL);
#define LOOK_UP(name) look_up((void **)&api.name, #name);
        FUNCTIONS(LOOK_UP)
#undef LOOK_UP
    }
    return api.library != NULL;
}

const char *embree_lack(void)
{
    return embree_is_there() ? "" : LIBRARY " cannot be opened (apt install " PACKAGE ")";
}

struct embree {
    RTCDevice device;
    RTCScene scene;
    RTCScene placed; /* whose instances scene holds; NULL: none */
    double build_ms;
    char version[VERSION_BYTES];
};

/* ---- subnormal numbers ---- */

/* Embree asks its callers to flush them to zero, for speed. Returns what restore_subnormals takes. */
static uint32_t flush_subnormals(void)
{
#if defined(__SSE__)
    const uint32_t state = _mm_getcsr();
    _mm_setcsr(state | 0x8040u); /* flush to zero, subnormals are zero */
    return state;
#else
    return 0;
#endif
}

static void restore_subnormals(uint32_t state)
{
#if defined(__SSE__)
    _mm_setcsr(state);
#else
    (void)state;
#endif
}

/* ---- scenes ---- */

static bool add_mesh(embree *made, RTCScene into, const float *vertices, size_t vertex_count, const uint32_t *indices,
                     size_t triangle_count)
{
    RTCGeometry geometry = api.rtcNewGeometry(made->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *points = api.rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                3 * sizeof(float), vertex_count);
    uint32_t *corners = api.rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                    3 * sizeof(uint32_t), triangle_count);
    const bool there = points != NULL && corners != NULL;
    if (there) {
        memcpy(points, vertices, vertex_count * 3 * sizeof(float));
        memcpy(corners, indices, triangle_count * 3 * sizeof(uint32_t));
        const double start_ms = input_now_ms();
        api.rtcCommitGeometry(geometry);
        api.rtcAttachGeometry(into, geometry);
        api.rtcCommitScene(into);
        made->build_ms = input_now_ms() - start_ms;
    }
    api.rtcReleaseGeometry(geometry);
    return there && api.rtcGetDeviceError(made->device) == RTC_ERROR_NONE;
}

/* A device and an empty scene; NULL on failure. */
static embree *open_peer(const embree_options *asked)
{
    static const enum RTCBuildQuality qualities[] = {[EMBREE_LOW] = RTC_BUILD_QUALITY_LOW,
                                                     [EMBREE_MEDIUM] = RTC_BUILD_QUALITY_MEDIUM,
                                                     [EMBREE_HIGH] = RTC_BUILD_QUALITY_HIGH};
    char config[CONFIG_BYTES] = "";
    embree *made = embree_is_there() ? calloc(1, sizeof *made) : NULL;
    if (made == NULL) {
        return NULL;
    }
    if (asked->isa != NULL) {
        snprintf(config, sizeof config, "isa=%s", asked->isa);
    }
    made->device = api.rtcNewDevice(config);
    if (made->device != NULL) {
        snprintf(made->version, sizeof made->version, "%d.%d.%d",
                 (int)api.rtcGetDeviceProperty(made->device, RTC_DEVICE_PROPERTY_VERSION_MAJOR),
                 (int)api.rtcGetDeviceProperty(made->device, RTC_DEVICE_PROPERTY_VERSION_MINOR),
                 (int)api.rtcGetDeviceProperty(made->device, RTC_DEVICE_PROPERTY_VERSION_PATCH));
        made->scene = api.rtcNewScene(made->device);
        api.rtcSetSceneFlags(made->scene, asked->robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
        api.rtcSetSceneBuildQuality(made->scene, qualities[asked->quality]);
    }
    if (made->scene == NULL) {
        embree_destroy(&made);
    }
    return made;
}

embree *embree_create(const float *vertices, size_t vertex_count, const uint32_t *indices, size_t triangle_count,
                      const embree_options *asked)
{
    static const embree_options defaults = {.robust = false};
    embree *made = open_peer(asked != NULL ? asked : &defaults);
    if (made != NULL && !add_mesh(made, made->scene, vertices, vertex_count, indices, triangle_count)) {
        embree_destroy(&made);
    }
    return made;
}

static void add_instances(embree *made, const float (*matrices)[12], size_t matrix_count)
{
    const double start_ms = input_now_ms();
    for (size_t i = 0; i < matrix_count; ++i) {
        RTCGeometry instance = api.rtcNewGeometry(made->device, RTC_GEOMETRY_TYPE_INSTANCE);
        api.rtcSetGeometryInstancedScene(instance, made->placed);
        api.rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, matrices[i]);
        api.rtcCommitGeometry(instance);
        api.rtcAttachGeometry(made->scene, instance);
        api.rtcReleaseGeometry(instance);
    }
    api.rtcCommitScene(made->scene);
    made->build_ms = input_now_ms() - start_ms;
}

embree *embree_create_placed(const float *vertices, size_t vertex_count, const uint32_t *indices, size_t triangle_count,
                             const float (*matrices)[12], size_t matrix_count)
{
    static const embree_options defaults = {.robust = false};
    embree *made = open_peer(&defaults);
    if (made == NULL) {
        return NULL;
    }
    made->placed = api.rtcNewScene(made->device);
    if (made->placed == NULL || !add_mesh(made, made->placed, vertices, vertex_count, indices, triangle_count)) {
        embree_destroy(&made);
        return NULL;
    }
    add_instances(made, matrices, matrix_count);
    if (api.rtcGetDeviceError(made->device) != RTC_ERROR_NONE) {
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
        api.rtcReleaseScene((*peer)->scene);
    }
    if ((*peer)->placed != NULL) {
        api.rtcReleaseScene((*peer)->placed);
    }
    if ((*peer)->device != NULL) {
        api.rtcReleaseDevice((*peer)->device);
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

bool embree_is_native(const embree *peer, unsigned width)
{
    const enum RTCDeviceProperty property = width == 16  ? RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED
                                            : width == 8 ? RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED
                                                         : RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED;
    return width == 1 || api.rtcGetDeviceProperty(peer->device, property) != 0;
}

/* ---- rays, as packets ---- */

/* The rows of width numbers of struct RTCRayHit, RTCRayHit8 and RTCRayHit16. Embree 4 may have more behind them. */
enum {
    ROW_ORIGIN = 0,
    ROW_NEAR = 3,
    ROW_DIRECTION = 4,
    ROW_FAR = 8,
    ROW_MASK = 9,
    ROW_U = 15,
    ROW_V = 16,
    ROW_TRIANGLE = 17,
    ROW_GEOMETRY = 18,
    ROW_INSTANCE = 19,
    QUERY_ALIGNMENT = 64
};

_Static_assert(offsetof(struct RTCRayHit, hit.instID) == ROW_INSTANCE * sizeof(float), "no padding");
_Static_assert(offsetof(struct RTCRayHit16, hit.instID) == sizeof(float[ROW_INSTANCE][16]), "no padding");

/* How many rows a packet of a type and width has. */
#define ROWS(type, width) (sizeof(type) / ((width) * sizeof(float)))

static size_t rows_of(size_t width)
{
    return width == 16  ? ROWS(struct RTCRayHit16, 16)
           : width == 8 ? ROWS(struct RTCRayHit8, 8)
                        : ROWS(struct RTCRayHit, 1);
}

typedef struct ray_batch {
    const embree *peer;
    embree_call call;
    const svo_ray *rays;
    svo_hit *hits;
    size_t ray_count;
    float *queries; /* rows_of(call.width) rows for each packet, which Embree reads and writes in place */
    int *valid; /* for each ray: -1, or 0 where Embree refuses it or there is none */
} ray_batch;

static bool is_valid(const svo_ray *ray)
{
    bool valid = ray->t_min <= ray->t_max;
    for (int axis = 0; axis < 3; ++axis) {
        valid = valid && fabsf(ray->origin[axis]) < GREATEST && fabsf(ray->direction[axis]) < GREATEST;
    }
    return valid;
}

/* Where the numbers of a ray begin; they are as far apart as the call is wide. */
static float *lane_of(const ray_batch *batch, size_t index)
{
    const size_t width = batch->call.width;
    return batch->queries + index / width * width * rows_of(width) + index % width;
}

static void lay_out_ray(const ray_batch *batch, size_t index)
{
    const size_t width = batch->call.width;
    const svo_ray *ray = &batch->rays[index];
    float *lane = lane_of(batch, index);
    for (size_t axis = 0; axis < 3; ++axis) {
        lane[(ROW_ORIGIN + axis) * width] = ray->origin[axis];
        lane[(ROW_DIRECTION + axis) * width] = ray->direction[axis];
    }
    lane[ROW_NEAR * width] = ray->t_min;
    lane[ROW_FAR * width] = ray->t_max;
    memset(&lane[ROW_MASK * width], 0xff, sizeof(float));
    memset(&lane[ROW_GEOMETRY * width], 0xff, sizeof(float));
    memset(&lane[ROW_INSTANCE * width], 0xff, sizeof(float));
    batch->valid[index] = is_valid(ray) ? -1 : 0;
}

/* Aligned as Embree asks for, and zero. Widths are whole packets of QUERY_ALIGNMENT bytes or one ray, whose rows do not
   need it. */
static void *allocate_aligned(size_t bytes)
{
    const size_t whole = (bytes + QUERY_ALIGNMENT - 1) / QUERY_ALIGNMENT * QUERY_ALIGNMENT;
    void *made = aligned_alloc(QUERY_ALIGNMENT, whole);
    return made != NULL ? memset(made, 0, whole) : NULL;
}

static bool lay_out_rays(ray_batch *batch)
{
    const size_t width = batch->call.width;
    const size_t lanes = (batch->ray_count + width - 1) / width * width;
    batch->valid = allocate_aligned(lanes * sizeof *batch->valid);
    batch->queries = allocate_aligned(lanes * rows_of(width) * sizeof *batch->queries);
    const bool made = batch->queries != NULL && batch->valid != NULL;
    for (size_t i = 0; made && i < batch->ray_count; ++i) {
        lay_out_ray(batch, i);
    }
    return made;
}

/* rtcOccluded makes tfar of an occluded ray minus infinity. */
static void keep_hits(const ray_batch *batch)
{
    const size_t width = batch->call.width;
    for (size_t i = 0; i < batch->ray_count; ++i) {
        const float *lane = lane_of(batch, i);
        svo_hit *hit = &batch->hits[i];
        uint32_t triangle, geometry;
        memcpy(&triangle, &lane[ROW_TRIANGLE * width], sizeof triangle);
        memcpy(&geometry, &lane[ROW_GEOMETRY * width], sizeof geometry);
        const bool met = batch->call.any ? lane[ROW_FAR * width] < 0 : geometry != RTC_INVALID_GEOMETRY_ID;
        hit->t = !met ? INFINITY : batch->call.any ? 0 : lane[ROW_FAR * width];
        hit->triangle = met ? triangle : SVO_NO_TRIANGLE;
        hit->u = lane[ROW_U * width];
        hit->v = lane[ROW_V * width];
    }
}

/* ---- tracing ---- */

/* One function for each width: Embree's types and functions differ by a number. */
#define TRACE_PACKET(width)                                                                                  \
    static void trace_##width(const ray_batch *batch, query_arguments *arguments, size_t first)              \
    {                                                                                                        \
        void *packet = batch->queries + first * ROWS(struct RTCRayHit##width, width);                        \
        struct RTCRayHit##width *query = packet;                                                             \
        const int *valid = batch->valid + first;                                                             \
        if (batch->call.any) {                                                                               \
            api.rtcOccluded##width(valid, batch->peer->scene, QUERY_WITH(arguments, occluded, &query->ray)); \
        } else {                                                                                             \
            api.rtcIntersect##width(valid, batch->peer->scene, QUERY_WITH(arguments, intersect, query));     \
        }                                                                                                    \
    }

TRACE_PACKET(8)
TRACE_PACKET(16)

static void trace_1(const ray_batch *batch, query_arguments *arguments, size_t index)
{
    void *packet = batch->queries + index * ROWS(struct RTCRayHit, 1);
    struct RTCRayHit *query = packet;
    if (batch->valid[index] == 0) {
        return;
    }
    if (batch->call.any) {
        api.rtcOccluded1(batch->peer->scene, QUERY_WITH(arguments, occluded, &query->ray));
    } else {
        api.rtcIntersect1(batch->peer->scene, QUERY_WITH(arguments, intersect, query));
    }
}

/* Chunks begin at whole packets. */
static void trace_chunk(void *user, unsigned thread_index, size_t begin, size_t end)
{
    const ray_batch *batch = user;
    query_arguments arguments = make_arguments(batch->call.coherent);
    const uint32_t state = flush_subnormals();
    (void)thread_index;
    void (*const trace)(const ray_batch *, query_arguments *, size_t) = batch->call.width == 16  ? trace_16
                                                                        : batch->call.width == 8 ? trace_8
                                                                                                 : trace_1;
    for (size_t i = begin; i < end; i += batch->call.width) {
        trace(batch, &arguments, i);
    }
    restore_subnormals(state);
}

double embree_trace(const embree *peer, embree_call call, const svo_ray *rays, svo_hit *hits, size_t ray_count,
                    unsigned thread_count)
{
    ray_batch batch = {.peer = peer, .call = call, .rays = rays, .hits = hits, .ray_count = ray_count};
    double ms = -1.0;
    thread_count = thread_count < THREADS_MAX ? thread_count : THREADS_MAX;
    if (lay_out_rays(&batch)) {
        const double start_ms = input_now_ms();
        const unsigned took_part = threads_run(thread_count, ray_count, RAYS_PER_CHUNK, trace_chunk, &batch);
        ms = took_part == thread_count ? input_now_ms() - start_ms : -1.0;
        keep_hits(&batch);
    }
    free(batch.queries);
    free(batch.valid);
    return ms;
}

#else

bool embree_is_there(void)
{
    return false;
}

const char *embree_lack(void)
{
    return "this program was built without libembree-dev";
}

embree *embree_create(const float *vertices, size_t vertex_count, const uint32_t *indices, size_t triangle_count,
                      const embree_options *asked)
{
    (void)asked;
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
    return embree_create(vertices, vertex_count, indices, triangle_count, NULL);
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

bool embree_is_native(const embree *peer, unsigned width)
{
    (void)peer;
    return width == 1;
}

double embree_trace(const embree *peer, embree_call call, const svo_ray *rays, svo_hit *hits, size_t ray_count,
                    unsigned thread_count)
{
    (void)peer;
    (void)call;
    (void)rays;
    (void)hits;
    (void)ray_count;
    (void)thread_count;
    return -1.0;
}

#endif
