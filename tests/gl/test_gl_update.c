/* SPDX-License-Identifier: MIT */
/*
 * Meshes that OpenGL moves: a plan updated from buffers that OpenGL has written makes the tree of one updated from the
 * host, on each way and each kind of queue. With cl_khr_gl_sharing, which is that of a fake driver, no call waits.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/fixture.h"
#include "support/gl_interop_shim.h"
#include "support/info_of.h"
#include "support/machine.h"
#include "support/suite.h"

enum { DEPTH = 5, TRIANGLES = 200, VERTICES = TRIANGLES * 3, NUMBERS = VERTICES * 3, BYTES = NUMBERS * 4, MOVES = 3 };

static unsigned waits;
static unsigned map_failures; /* that many next calls fail */
/* PoCL aborts where an event fails that commands wait for, so one is said to have failed. */
static cl_event said_to_have_failed;
static cl_event waited_for[16]; /* by markers */
static size_t waited_count;

/* NOLINTBEGIN(readability-identifier-naming) */
cl_int __real_clWaitForEvents(cl_uint count, const cl_event *events);
cl_int __wrap_clWaitForEvents(cl_uint count, const cl_event *events);

cl_int __wrap_clWaitForEvents(cl_uint count, const cl_event *events)
{
    ++waits;
    return __real_clWaitForEvents(count, events);
}

void *__real_clEnqueueMapBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, cl_map_flags access,
                                size_t offset, size_t bytes, cl_uint num_wait, const cl_event *wait, cl_event *event,
                                cl_int *error);
void *__wrap_clEnqueueMapBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, cl_map_flags access,
                                size_t offset, size_t bytes, cl_uint num_wait, const cl_event *wait, cl_event *event,
                                cl_int *error);

void *__wrap_clEnqueueMapBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, cl_map_flags access,
                                size_t offset, size_t bytes, cl_uint num_wait, const cl_event *wait, cl_event *event,
                                cl_int *error)
{
    if (map_failures > 0) {
        --map_failures;
        *error = CL_MAP_FAILURE;
        return NULL;
    }
    return __real_clEnqueueMapBuffer(queue, buffer, blocking, access, offset, bytes, num_wait, wait, event, error);
}

cl_int __real_clGetEventInfo(cl_event event, cl_event_info name, size_t bytes, void *value, size_t *needed);
cl_int __wrap_clGetEventInfo(cl_event event, cl_event_info name, size_t bytes, void *value, size_t *needed);

cl_int __wrap_clGetEventInfo(cl_event event, cl_event_info name, size_t bytes, void *value, size_t *needed)
{
    const cl_int error = __real_clGetEventInfo(event, name, bytes, value, needed);
    if (error == CL_SUCCESS && event == said_to_have_failed && name == CL_EVENT_COMMAND_EXECUTION_STATUS) {
        *(cl_int *)value = CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST;
    }
    return error;
}

cl_int __real_clEnqueueMarkerWithWaitList(cl_command_queue queue, cl_uint count, const cl_event *wait, cl_event *event);
cl_int __wrap_clEnqueueMarkerWithWaitList(cl_command_queue queue, cl_uint count, const cl_event *wait, cl_event *event);

cl_int __wrap_clEnqueueMarkerWithWaitList(cl_command_queue queue, cl_uint count, const cl_event *wait, cl_event *event)
{
    for (cl_uint i = 0; i < count && waited_count < sizeof waited_for / sizeof waited_for[0]; ++i) {
        waited_for[waited_count++] = wait[i];
    }
    return __real_clEnqueueMarkerWithWaitList(queue, count, wait, event);
}
/* NOLINTEND(readability-identifier-naming) */

/* ---- a mesh that moves ---- */

static float positions[NUMBERS], normals[NUMBERS];

static void move(uint32_t seed)
{
    uint32_t state = seed * 2654435761u + 1;
    for (size_t i = 0; i < NUMBERS; ++i) {
        state = state * 1664525u + 1013904223u;
        /* Small triangles: the corners of one lie beside its first. */
        const float own = (float)(state >> 8) / 16777216.0F;
        positions[i] = i % 9 < 3 ? 0.05F + own * 0.8F : positions[i - i % 9 + i % 3] + own * 0.1F;
        normals[i] = own - 0.5F;
    }
}

static svo_mesh host_mesh(void)
{
    return (svo_mesh){.struct_size = sizeof(svo_mesh),
                      .positions = positions,
                      .normals = normals,
                      .vertex_count = VERTICES,
                      .triangle_count = TRIANGLES};
}

/* ---- a device, a context and plans ---- */

typedef struct moved_pair {
    fixture opened;
    bool has_shim;
    svo_plan *from_gl, *from_host;
    svo_gl_buffer *positions, *normals;
} moved_pair;

static void succeed(const moved_pair *pair, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(pair->opened.device));
    }
}

static svo_plan *make_plan(const moved_pair *pair, uint32_t need, uint32_t updatable)
{
    const svo_mesh mesh = host_mesh();
    const svo_plan_options options = {
        .struct_size = sizeof options, .need = need, .edge = 1.0, .updatable = updatable, .max_area = 50.0};
    svo_plan *plan = NULL;
    succeed(pair, svo_plan_create(pair->opened.device, &mesh, DEPTH, &options, &plan));
    return plan;
}

static svo_gl_buffer *make_buffer(const moved_pair *pair, size_t bytes, svo_gl_share share)
{
    svo_gl_buffer *made = NULL;
    succeed(pair, svo_gl_buffer_create(pair->opened.device, pair->opened.context, bytes, share, &made));
    return made;
}

/* faults: NULL for the driver as it is. Skips the test where this machine has no such way. */
static void open_pair(const shim_faults *faults, cl_command_queue_properties properties, svo_gl_share share,
                      moved_pair *out)
{
    cl_int error = CL_SUCCESS;
    svo_message message = {""};
    *out = (moved_pair){.has_shim = faults != NULL};
    out->opened.context = machine_context_or_null(SVO_GL_SURFACELESS);
    if (out->opened.context == NULL) {
        skip();
    }
    if (faults != NULL) {
        shim_install(out->opened.context, faults);
    }
    if (svo_gl_device_create(out->opened.context, NULL, NULL, &out->opened.device, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    out->opened.queue = clCreateCommandQueue(info_of_device(out->opened.device).context,
                                             info_of_device(out->opened.device).device, properties, &error);
    assert_int_equal(error, CL_SUCCESS);
    assert_int_equal(svo_frontend_create_cl(out->opened.device, &out->opened.cl), SVO_OK);
    out->opened.frontend = out->opened.cl;
    move(0);
    out->from_gl = make_plan(out, SVO_NEED_NORMAL, 1);
    out->from_host = make_plan(out, SVO_NEED_NORMAL, 1);
    out->positions = make_buffer(out, BYTES + 12, share); /* more than needed */
    out->normals = make_buffer(out, BYTES, share);
}

static void close_pair(moved_pair *pair)
{
    svo_gl_buffer_destroy(&pair->positions);
    svo_gl_buffer_destroy(&pair->normals);
    svo_plan_destroy(&pair->from_gl);
    svo_plan_destroy(&pair->from_host);
    if (pair->has_shim) {
        shim_end(pair->opened.context);
    }
    fixture_close(&pair->opened);
}

/* By OpenGL's commands. */
static void write_buffer(const moved_pair *pair, const svo_gl_buffer *buffer, const float *numbers)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(pair->opened.context);
    svo_gl_buffer_info info = SVO_GL_BUFFER_INFO_INIT;
    GLuint own = 0;
    assert_int_equal(svo_gl_buffer_get_info(buffer, &info), SVO_OK);
    assert_int_equal(svo_i_gl_context_make_current(pair->opened.context, NULL), SVO_OK);
    gl->GenBuffers(1, &own);
    gl->BindBuffer(GL_COPY_READ_BUFFER, own);
    gl->BufferData(GL_COPY_READ_BUFFER, BYTES, numbers, GL_STREAM_COPY);
    gl->BindBuffer(GL_COPY_WRITE_BUFFER, info.name);
    gl->CopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, (GLintptr)info.offset_bytes, BYTES);
    gl->BindBuffer(GL_COPY_WRITE_BUFFER, 0);
    gl->BindBuffer(GL_COPY_READ_BUFFER, 0);
    gl->DeleteBuffers(1, &own);
    svo_i_gl_context_release_current(pair->opened.context);
}

static svo_status update(const moved_pair *pair, cl_event *event)
{
    return svo_gl_plan_update(pair->from_gl, pair->positions, pair->normals,
                              &(svo_submit){.queue = pair->opened.queue, .event = event});
}

static void hash_of(const moved_pair *pair, svo_plan *plan, char hash[SVO_HASH_TEXT_BYTES])
{
    svo_tree *tree = NULL;
    succeed(pair, svo_build(plan, pair->opened.frontend, pair->opened.queue, &tree, NULL));
    succeed(pair, svo_tree_download(tree, pair->opened.queue));
    succeed(pair, svo_tree_hash(tree, SVO_HASH_ALL, hash));
    svo_tree_destroy(&tree);
}

/* The mesh of a move gets into the plan, over one that nobody builds. */
static void check_move(const moved_pair *pair, uint32_t seed)
{
    char actual[SVO_HASH_TEXT_BYTES], expected[SVO_HASH_TEXT_BYTES];
    const svo_mesh mesh = host_mesh();
    move(seed + 100);
    write_buffer(pair, pair->positions, positions);
    succeed(pair, update(pair, NULL));
    move(seed);
    write_buffer(pair, pair->positions, positions);
    write_buffer(pair, pair->normals, normals);
    cl_event updated = NULL;
    succeed(pair, update(pair, &updated));
    assert_int_equal(__real_clWaitForEvents(1, &updated), CL_SUCCESS);
    clReleaseEvent(updated);
    succeed(pair, svo_plan_update(pair->from_host, &mesh, NULL));
    hash_of(pair, pair->from_gl, actual);
    hash_of(pair, pair->from_host, expected);
    assert_string_equal(actual, expected);
}

static void check_way(const shim_faults *faults, cl_command_queue_properties properties, svo_gl_share share)
{
    moved_pair pair;
    char before[SVO_HASH_TEXT_BYTES], after[SVO_HASH_TEXT_BYTES];
    open_pair(faults, properties, share, &pair);
    hash_of(&pair, pair.from_host, before);
    for (uint32_t seed = 1; seed <= MOVES; ++seed) {
        check_move(&pair, seed);
    }
    hash_of(&pair, pair.from_host, after);
    assert_string_not_equal(after, before);
    close_pair(&pair);
}

/* ---- ways ---- */

static const cl_command_queue_properties queues[] = {0, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE};
enum { QUEUES = sizeof queues / sizeof queues[0] };

static void shared_vertices_move_the_mesh(void **state)
{
    (void)state;
    for (size_t i = 0; i < QUEUES; ++i) {
        check_way(&(shim_faults){.extensions = NULL}, queues[i], SVO_GL_SHARE_INTEROP);
        check_way(&(shim_faults){.extensions = "cl_khr_gl_sharing"}, queues[i], SVO_GL_SHARE_INTEROP);
    }
}

static void mapped_vertices_move_the_mesh(void **state)
{
    (void)state;
    for (size_t i = 0; i < QUEUES; ++i) {
        check_way(NULL, queues[i], SVO_GL_SHARE_HOST);
    }
}

static void copied_vertices_move_the_mesh(void **state)
{
    (void)state;
    for (size_t i = 0; i < QUEUES; ++i) {
        check_way(NULL, queues[i], SVO_GL_SHARE_COPY);
    }
}

/* With cl_khr_gl_event the commands of both APIs are ordered by themselves. */
static void shared_vertices_are_not_waited_for(void **state)
{
    (void)state;
    static const struct {
        const char *extensions;
        svo_gl_share share;
        bool is_waited_for;
    } ways[] = {{NULL, SVO_GL_SHARE_INTEROP, false},
                {"cl_khr_gl_sharing", SVO_GL_SHARE_INTEROP, true},
                {NULL, SVO_GL_SHARE_COPY, true}};
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; ++i) {
        moved_pair pair;
        shim_counts before, after;
        open_pair(&(shim_faults){.extensions = ways[i].extensions}, 0, ways[i].share, &pair);
        write_buffer(&pair, pair.positions, positions);
        write_buffer(&pair, pair.normals, normals);
        for (int round = 0; round < 2; ++round) {
            shim_get_counts(&before);
            waits = 0;
            succeed(&pair, update(&pair, NULL));
            shim_get_counts(&after);
            assert_int_equal(waits > 0, ways[i].is_waited_for);
            assert_int_equal(after.finishes > before.finishes, ways[i].is_waited_for);
            assert_int_equal(after.acquired - before.acquired, ways[i].share == SVO_GL_SHARE_INTEROP ? 2 : 0);
            assert_int_equal(after.released - before.released, after.acquired - before.acquired);
        }
        close_pair(&pair);
    }
}

/* ---- failures ---- */

static void a_failing_call_is_a_status_and_the_next_works(void **state)
{
    (void)state;
    static const struct {
        shim_faults faults;
        const char *words;
    } cases[] = {
        {{.acquire_error = CL_INVALID_GL_OBJECT}, "clEnqueueAcquireGLObjects failed with CL_INVALID_GL_OBJECT"},
        {{.release_error = CL_INVALID_OPERATION}, "clEnqueueReleaseGLObjects failed with CL_INVALID_OPERATION"},
    };
    moved_pair pair;
    open_pair(&(shim_faults){.extensions = NULL}, 0, SVO_GL_SHARE_INTEROP, &pair);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        shim_set_faults(&cases[i].faults);
        assert_int_equal(update(&pair, NULL), SVO_CL_ERROR);
        assert_non_null(strstr(svo_device_message(pair.opened.device), "svo_gl_plan_update: cl"));
        assert_non_null(strstr(svo_device_message(pair.opened.device), cases[i].words));
        shim_set_faults(&(shim_faults){.extensions = NULL});
        check_move(&pair, (uint32_t)i + 1);
    }
    close_pair(&pair);
}

static bool is_waited_for(cl_event event)
{
    for (size_t i = 0; i < waited_count; ++i) {
        if (waited_for[i] == event) {
            return true;
        }
    }
    return false;
}

/* Later updates from its buffers do not wait for one that failed, as after an event of the caller's that did. They wait
   for the one before it. */
static void nothing_waits_for_a_failed_update(void **state)
{
    (void)state;
    moved_pair pair;
    cl_event first = NULL;
    cl_event failed = NULL;
    open_pair(&(shim_faults){.extensions = NULL}, 0, SVO_GL_SHARE_INTEROP, &pair);
    succeed(&pair, update(&pair, &first));
    waited_count = 0;
    succeed(&pair, update(&pair, &failed));
    assert_true(is_waited_for(first));
    said_to_have_failed = failed;
    waited_count = 0;
    succeed(&pair, update(&pair, NULL));
    assert_true(is_waited_for(first));
    assert_false(is_waited_for(failed));
    check_move(&pair, 1);
    said_to_have_failed = NULL;
    clReleaseEvent(first);
    clReleaseEvent(failed);
    close_pair(&pair);
}

/* The one buffer stays OpenCL's until svo_gl_buffer_to_gl; the other, if it can be mapped, is OpenGL's. */
static void buffers_that_cannot_be_mapped_stay_with_opencl(void **state)
{
    (void)state;
    moved_pair pair;
    open_pair(NULL, 0, SVO_GL_SHARE_HOST, &pair);
    for (unsigned failures = 1; failures <= 2; ++failures) {
        map_failures = failures;
        assert_int_equal(update(&pair, NULL), SVO_CL_ERROR);
        assert_int_equal(map_failures, 0);
        assert_non_null(strstr(svo_device_message(pair.opened.device),
                               "svo_gl_plan_update: clEnqueueMapBuffer failed with CL_MAP_FAILURE"));
        assert_int_equal(update(&pair, NULL), SVO_INVALID_ARGUMENT);
        assert_non_null(strstr(svo_device_message(pair.opened.device), "positions is OpenCL's"));
        succeed(&pair, svo_gl_buffer_to_gl(pair.positions, 0, pair.opened.queue, 0, NULL));
        if (failures > 1) {
            succeed(&pair, svo_gl_buffer_to_gl(pair.normals, 0, pair.opened.queue, 0, NULL));
        }
        check_move(&pair, failures);
    }
    close_pair(&pair);
}

static void expect_refused(const moved_pair *pair, svo_status status, const char *words)
{
    assert_int_equal(status, SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(pair->opened.device), words);
}

static void wrong_arguments_are_refused(void **state)
{
    (void)state;
#define NAME "svo_gl_plan_update: "
    moved_pair pair;
    open_pair(&(shim_faults){.extensions = NULL}, 0, SVO_GL_SHARE_INTEROP, &pair);
    cl_command_queue queue = pair.opened.queue;
    svo_plan *fixed = make_plan(&pair, SVO_NEED_NONE, 0);
    svo_gl_buffer *small = make_buffer(&pair, BYTES - 1, SVO_GL_SHARE_INTEROP);
    svo_gl_buffer *other = make_buffer(&pair, BYTES, SVO_GL_SHARE_COPY);
    assert_int_equal(svo_gl_plan_update(NULL, pair.positions, NULL, &(svo_submit){.queue = queue}),
                     SVO_INVALID_ARGUMENT);
    expect_refused(&pair, svo_gl_plan_update(pair.from_gl, NULL, NULL, &(svo_submit){.queue = queue}),
                   NAME "positions is NULL");
    expect_refused(&pair,
                   svo_gl_plan_update(pair.from_gl, pair.positions, pair.positions, &(svo_submit){.queue = queue}),
                   NAME "normals is positions");
    expect_refused(&pair, svo_gl_plan_update(pair.from_gl, small, NULL, &(svo_submit){.queue = queue}),
                   NAME "positions has 7199 bytes, the plan's vertices 7200");
    expect_refused(&pair, svo_gl_plan_update(pair.from_gl, pair.positions, other, &(svo_submit){.queue = queue}),
                   NAME "normals is shared by copy, positions by interop");
    expect_refused(&pair, svo_gl_plan_update(pair.from_gl, pair.positions, NULL, &(svo_submit){.queue = queue}),
                   NAME "the plan reads normals, mesh has none");
    expect_refused(&pair, svo_gl_plan_update(fixed, pair.positions, NULL, &(svo_submit){.queue = queue}),
                   NAME "plan is not updatable; see svo_plan_options");
    expect_refused(&pair,
                   svo_gl_plan_update(pair.from_gl, pair.positions, NULL,
                                      &(svo_submit){.queue = queue, .num_wait = 1, .wait = NULL}),
                   NAME "num_wait and wait disagree");
    succeed(&pair, svo_gl_buffer_to_cl(pair.positions, queue));
    expect_refused(&pair, update(&pair, NULL), NAME "positions is OpenCL's; see svo_gl_buffer_to_gl");
    succeed(&pair, svo_gl_buffer_to_gl(pair.positions, 0, queue, 0, NULL));
    check_move(&pair, 1);
    svo_gl_buffer_destroy(&small);
    svo_gl_buffer_destroy(&other);
    svo_plan_destroy(&fixed);
    close_pair(&pair);
#undef NAME
}

TEST_GROUP(gl_update)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shared_vertices_move_the_mesh),
        cmocka_unit_test(mapped_vertices_move_the_mesh),
        cmocka_unit_test(copied_vertices_move_the_mesh),
        cmocka_unit_test(shared_vertices_are_not_waited_for),
        cmocka_unit_test(a_failing_call_is_a_status_and_the_next_works),
        cmocka_unit_test(nothing_waits_for_a_failed_update),
        cmocka_unit_test(buffers_that_cannot_be_mapped_stay_with_opencl),
        cmocka_unit_test(wrong_arguments_are_refused),
    };
    return cmocka_run_group_tests_name("gl_update", tests, NULL, NULL);
}
