/* SPDX-License-Identifier: MIT */
/*
 * The start-up test of hardware-conservative rasterization. Drivers differ on needles, on triangles smaller than a
 * pixel, and on positions far from the corner of a large viewport; a driver that misses a voxel here is not used.
 */
#include "raster/selftest.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/message.h"
#include "plan/chunking.h"
#include "plan/estimate.h"
#include "shared/overlap.clh"

#define TRIANGLES_MAX 96u
#define EXTENTS       4u

/* A test mesh: how far its triangles extend along each axis, in turn, in units of 2^-20 of the grid. */
typedef struct test_mesh {
    unsigned depth;
    uint32_t triangle_count;
    int32_t extents[EXTENTS][3];
} test_mesh;

/* The largest viewport is that of depth 13; above, there are several, and needles that cross them. */
static const test_mesh test_meshes[] = {
    {6, TRIANGLES_MAX, {{12000, 12000, 12000}, {900, 900, 900}, {300000, 300000, 300000}, {60000, 60000, 60000}}},
    {SVO_I_VIEW_LOG2, 48, {{4000, 4000, 4000}, {60, 60, 60}, {400000, 300, 200}, {200, 400000, 300}}},
    {SVO_I_VIEW_LOG2 + 1, 24, {{2000, 2000, 2000}, {30, 30, 30}, {300, 100, 400000}, {400000, 200, 100}}},
};

static uint32_t next_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u; /* Numerical Recipes, 2nd ed., section 7.1 */
    return *state >> 8;
}

/* Integer coordinates on a grid of 2^20 units: a mix of small triangles, needles, slivers of one unit and large ones.
   */
static void make_vertices(const test_mesh *test, double *positions)
{
    uint32_t random = 12345;
    for (uint32_t t = 0; t < test->triangle_count; ++t) {
        double *v = positions + (size_t)t * 9;
        for (unsigned axis = 0; axis < 3; ++axis) {
            const int32_t extent = test->extents[t % EXTENTS][axis];
            const int32_t low = (int32_t)(next_random(&random) % (uint32_t)((1 << 20) - extent - 1));
            const int32_t a = low + (int32_t)(next_random(&random) % (uint32_t)extent);
            const int32_t b = low + (int32_t)(next_random(&random) % (uint32_t)extent);
            const int32_t c = low + (int32_t)(next_random(&random) % (uint32_t)extent);
            const bool sliver = t % 3 == 1;
            v[axis] = a;
            v[3 + axis] = b;
            v[6 + axis] = sliver ? (a + b) / 2 + (int32_t)(t % 5) * 400 % extent / 8 : c;
        }
    }
}

static int32_t smallest(int32_t a, int32_t b, int32_t c)
{
    return a < b ? (a < c ? a : c) : (b < c ? b : c);
}

static int32_t largest(int32_t a, int32_t b, int32_t c)
{
    return a > b ? (a > c ? a : c) : (b > c ? b : c);
}

static uint64_t interleave(const int32_t voxel[3])
{
    uint64_t code = 0;
    for (unsigned bit = 0; bit < 16; ++bit) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            code |= (uint64_t)((uint32_t)voxel[axis] >> bit & 1u) << (3 * bit + axis);
        }
    }
    return code;
}

/* A growing array of fragments. */
typedef struct walk {
    const svo_plan *plan;
    uint32_t *words;
    uint64_t count, capacity;
} walk;

static bool append(walk *w, const int32_t voxel[3], uint32_t triangle)
{
    const uint32_t per_fragment = svo_i_plan_fragment_bytes(w->plan) / 4;
    if (w->count == w->capacity) {
        const uint64_t capacity = w->capacity * 2 + 1024;
        uint32_t *words = svo_i_grow(&w->plan->device->memory, w->words, (size_t)capacity * per_fragment * 4);
        if (words == NULL) {
            return false;
        }
        w->words = words;
        w->capacity = capacity;
    }
    uint32_t *fragment = w->words + w->count++ * per_fragment;
    const uint64_t code = interleave(voxel);
    fragment[0] = (uint32_t)code;
    fragment[1] = (uint32_t)(code >> 32);
    fragment[per_fragment - 1] = triangle;
    return true;
}

static bool walk_triangle(walk *w, uint32_t triangle)
{
    const uint32_t *corners = w->plan->indices + (size_t)triangle * 3;
    const int32_t *a = w->plan->vertices + (size_t)corners[0] * 3;
    const int32_t *b = w->plan->vertices + (size_t)corners[1] * 3;
    const int32_t *c = w->plan->vertices + (size_t)corners[2] * 3;
    const uint32_t shift = w->plan->voxel_log2;
    const svo_overlap overlap = svo_make_overlap(svo_make_point(a[0], a[1], a[2]), svo_make_point(b[0], b[1], b[2]),
                                                 svo_make_point(c[0], c[1], c[2]), 1 << shift, 1, 2);
    int32_t low[3];
    int32_t high[3];
    for (unsigned axis = 0; axis < 3; ++axis) {
        low[axis] = smallest(a[axis], b[axis], c[axis]) >> shift;
        high[axis] = largest(a[axis], b[axis], c[axis]) >> shift;
    }
    for (int32_t x = low[0]; x <= high[0]; ++x) {
        for (int32_t y = low[1]; y <= high[1]; ++y) {
            for (int32_t z = low[2]; z <= high[2]; ++z) {
                if (svo_overlap_column(overlap, x << shift, y << shift) &&
                    svo_overlap_voxel(overlap, x << shift, y << shift, z << shift) &&
                    !append(w, (const int32_t[3]){x, y, z}, triangle)) {
                    return false;
                }
            }
        }
    }
    return true;
}

svo_status svo_i_walk(const svo_plan *plan, uint32_t **out, uint64_t *fragment_count)
{
    walk w = {.plan = plan};
    for (uint32_t t = 0; t < plan->triangle_count; ++t) {
        if (!walk_triangle(&w, t)) {
            svo_i_free(w.words);
            return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY,
                                     "svo_gl_create: no memory for %llu fragments", (unsigned long long)w.count);
        }
    }
    *out = w.words;
    *fragment_count = w.count;
    return SVO_OK;
}

static int compare_words(const uint32_t *a, const uint32_t *b, unsigned count)
{
    for (unsigned i = 0; i < count; ++i) {
        if (a[i] != b[i]) {
            return a[i] < b[i] ? -1 : 1;
        }
    }
    return 0;
}

static int compare_fragments_30(const void *left, const void *right)
{
    return compare_words(left, right, SVO_FRAGMENT_WORDS_30);
}

static int compare_fragments_48(const void *left, const void *right)
{
    return compare_words(left, right, SVO_FRAGMENT_WORDS_48);
}

/* Draws the plan into a buffer of its own and reads the fragments. words: room for capacity fragments. */
static svo_status draw(svo_device *device, const svo_i_gl_functions *gl, svo_i_raster *raster, const svo_plan *plan,
                       uint64_t capacity, uint32_t *words, uint64_t *needed)
{
    svo_i_chunking layout;
    svo_status status = SVO_OK;
    svo_i_raster_count counts = {0, 0};
    const size_t fragment_bytes = svo_i_plan_fragment_bytes(plan);
    const uint64_t bytes = capacity * fragment_bytes;
    SVO_I_TRY(svo_i_chunking_create(plan, UINT64_C(1) << 26, &layout));
    layout.chunks[0].capacity = capacity;
    GLuint buffer = 0;
    gl->GenBuffers(1, &buffer);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)bytes, NULL, GL_STREAM_READ);
    SVO_I_TRY_CLEANUP(svo_i_gl_check(gl, "svo_gl_create", "self-test", &device->message));
    SVO_I_TRY_CLEANUP(svo_i_raster_prepare(raster, plan));
    SVO_I_TRY_CLEANUP(svo_i_raster_upload(raster, plan, plan->items, plan->class_begin[SVO_I_CLASS_COUNT], 1));
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, SVO_I_RASTER_FRAGMENTS, buffer);
    SVO_I_TRY_CLEANUP(svo_i_raster_draw(raster, plan, &layout, 0));
    SVO_I_TRY_CLEANUP(svo_i_raster_finish(raster, 1, &counts));
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    gl->GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)bytes, words);
    SVO_I_TRY_CLEANUP(svo_i_gl_check(gl, "svo_gl_create", "self-test", &device->message));
    *needed = (uint64_t)counts.decided + counts.undecided;
    if (*needed <= capacity) {
        memmove((char *)words + counts.decided * fragment_bytes,
                (char *)words + (capacity - counts.undecided) * fragment_bytes, counts.undecided * fragment_bytes);
    }
cleanup:
    gl->DeleteBuffers(1, &buffer);
    svo_i_chunking_destroy(&layout);
    return status;
}

/* Writes "" to reason when both arrays hold the same fragments in any order, else how they differ. Sorts both. */
static void report_difference(const svo_plan *plan, uint32_t *drawn, uint32_t *expected, uint64_t needed,
                              uint64_t count, char *reason, size_t reason_bytes)
{
    const unsigned depth = plan->info.depth;
    const size_t bytes = svo_i_plan_fragment_bytes(plan);
    if (needed != count) {
        (void)snprintf(reason, reason_bytes, "the self-test found %llu fragments, not %llu, at depth %u",
                       (unsigned long long)needed, (unsigned long long)count, depth);
        return;
    }
    int (*compare)(const void *, const void *) =
        depth <= SVO_CODE30_DEPTH_MAX ? compare_fragments_30 : compare_fragments_48;
    qsort(drawn, (size_t)count, bytes, compare);
    qsort(expected, (size_t)count, bytes, compare);
    if (memcmp(drawn, expected, (size_t)count * bytes) != 0) {
        (void)snprintf(reason, reason_bytes, "the self-test found other fragments than the walk at depth %u", depth);
    }
}

static svo_status draw_and_compare(svo_device *device, const svo_i_gl_functions *gl, svo_i_raster *raster,
                                   const svo_plan *plan, char *reason, size_t reason_bytes)
{
    svo_status status = SVO_OK;
    uint32_t *expected = NULL;
    uint32_t *drawn = NULL;
    uint64_t count = 0;
    uint64_t needed = 0;
    SVO_I_TRY_CLEANUP(svo_i_walk(plan, &expected, &count));
    drawn = svo_i_alloc(&device->memory, (size_t)(count + 1) * svo_i_plan_fragment_bytes(plan));
    if (drawn == NULL) {
        status = svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "svo_gl_create: no memory for %llu fragments",
                                   (unsigned long long)count);
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(draw(device, gl, raster, plan, count + 1, drawn, &needed));
    report_difference(plan, drawn, expected, needed, count, reason, reason_bytes);
cleanup:
    svo_i_free(expected);
    svo_i_free(drawn);
    return status;
}

/* Tests one mesh. A failure leaves its words in the device's message. */
static svo_status test_one(svo_device *device, const svo_i_gl_functions *gl, svo_i_raster *raster,
                           const test_mesh *test, char *reason, size_t reason_bytes)
{
    double positions[TRIANGLES_MAX * 9];
    make_vertices(test, positions);
    const svo_mesh mesh = {.struct_size = sizeof mesh,
                           .positions_double = positions,
                           .vertex_count = (size_t)test->triangle_count * 3,
                           .triangle_count = test->triangle_count};
    const svo_plan_options options = {.struct_size = sizeof options, .edge = (double)(1 << 20), .need = SVO_NEED_NONE};
    svo_plan *plan = NULL;
    SVO_I_TRY(svo_plan_create(device, &mesh, test->depth, &options, &plan));
    const svo_status status = draw_and_compare(device, gl, raster, plan, reason, reason_bytes);
    svo_plan_destroy(&plan);
    return status;
}

void svo_i_raster_selftest(svo_device *device, svo_gl_context *context, svo_i_raster *raster, char *reason,
                           size_t reason_bytes)
{
    const svo_message before = device->message;
    reason[0] = '\0';
    if (svo_i_gl_context_make_current(context, &device->message) != SVO_OK) {
        (void)snprintf(reason, reason_bytes, "the self-test could not start: %s", device->message.text);
    } else {
        const svo_i_gl_functions *gl = svo_i_gl_context_functions(context);
        for (size_t i = 0; i < sizeof test_meshes / sizeof test_meshes[0] && reason[0] == '\0'; ++i) {
            if (test_one(device, gl, raster, &test_meshes[i], reason, reason_bytes) != SVO_OK) {
                (void)snprintf(reason, reason_bytes, "the self-test failed: %s", device->message.text);
            }
        }
        svo_i_gl_context_release_current(context);
    }
    device->message = before;
}
