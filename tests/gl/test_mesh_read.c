/* SPDX-License-Identifier: MIT */
/*
 * Meshes in an application's buffers, of OpenCL and of OpenGL: packed or interleaved, with either width of indices,
 * written by commands that have not yet run. And the tree's buffers in the hands of the application.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <pthread.h>
#include <time.h>

#include "core/device.h"
#include "support/fixture.h"
#include "support/gl_contexts.h"
#include "support/info_of.h"
#include "support/machine.h"
#include "support/nondefault_state.h"
#include "support/own_context.h"
#include "support/suite.h"

enum { CUBE_VERTICES = 8, CUBE_TRIANGLES = 12, DEPTH = 6, DELAY_MS = 30, INDEX_OFFSET = 6, VERTEX_OFFSET = 20 };

static const float positions[CUBE_VERTICES * 3] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0,
                                                   0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
static const uint32_t indices[CUBE_TRIANGLES * 3] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                                     2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

/* An interleaved vertex, as renderers use it. */
typedef struct vertex {
    float position[3];
    float normal[3];
    float uv[2];
    uint8_t color[4];
    uint32_t unused;
} vertex;

typedef struct interleaved {
    unsigned char vertices[VERTEX_OFFSET + CUBE_VERTICES * sizeof(vertex)];
    unsigned char indices[INDEX_OFFSET + CUBE_TRIANGLES * 3 * sizeof(uint16_t)];
} interleaved;

static void make_interleaved(interleaved *out)
{
    memset(out, 0xee, sizeof *out);
    for (unsigned i = 0; i < CUBE_VERTICES; ++i) {
        const float value = (float)i;
        const vertex one = {{positions[i * 3], positions[i * 3 + 1], positions[i * 3 + 2]},
                            {1.0f, value, -value},
                            {value / 8.0f, 0.5f},
                            {(uint8_t)i, (uint8_t)(2 * i), (uint8_t)(3 * i), 255},
                            0xdeadbeef};
        memcpy(out->vertices + VERTEX_OFFSET + i * sizeof one, &one, sizeof one);
    }
    for (unsigned i = 0; i < CUBE_TRIANGLES * 3; ++i) {
        const uint16_t index = (uint16_t)indices[i];
        memcpy(out->indices + INDEX_OFFSET + i * sizeof index, &index, sizeof index);
    }
}

static svo_mesh_view view_of(const svo_mesh_view *buffer, size_t offset_bytes, size_t stride_bytes)
{
    svo_mesh_view view = *buffer;
    view.offset_bytes = offset_bytes;
    view.stride_bytes = stride_bytes;
    return view;
}

static svo_mesh_buffers interleaved_buffers(const svo_mesh_view *vertices, const svo_mesh_view *index_buffer)
{
    return (svo_mesh_buffers){
        .struct_size = sizeof(svo_mesh_buffers),
        .vertex_count = CUBE_VERTICES,
        .triangle_count = CUBE_TRIANGLES,
        .positions = view_of(vertices, VERTEX_OFFSET + offsetof(vertex, position), sizeof(vertex)),
        .normals = view_of(vertices, VERTEX_OFFSET + offsetof(vertex, normal), sizeof(vertex)),
        .uvs = view_of(vertices, VERTEX_OFFSET + offsetof(vertex, uv), sizeof(vertex)),
        .colors = view_of(vertices, VERTEX_OFFSET + offsetof(vertex, color), sizeof(vertex)),
        .indices = view_of(index_buffer, INDEX_OFFSET, 0),
        .index_bytes = 2,
    };
}

static void check_interleaved_copy(const svo_mesh_copy *copy)
{
    const svo_mesh *mesh = svo_mesh_copy_get(copy);
    assert_int_equal(mesh->vertex_count, CUBE_VERTICES);
    assert_int_equal(mesh->triangle_count, CUBE_TRIANGLES);
    assert_memory_equal(mesh->positions, positions, sizeof positions);
    assert_memory_equal(mesh->indices, indices, sizeof indices);
    for (unsigned i = 0; i < CUBE_VERTICES; ++i) {
        assert_true(mesh->normals[i * 3 + 1] == (float)i && mesh->normals[i * 3 + 2] == -(float)i);
        assert_true(mesh->uvs[i * 2] == (float)i / 8.0f && mesh->uvs[i * 2 + 1] == 0.5f);
        assert_int_equal(mesh->colors[i * 4 + 2], 3 * i);
    }
    assert_null(mesh->triangle_materials);
    assert_null(mesh->positions_double);
}

static cl_mem make_memory(const svo_device *device, const void *data, size_t bytes)
{
    cl_int error = CL_SUCCESS;
    cl_mem memory = clCreateBuffer(info_of_device(device).context, CL_MEM_READ_WRITE, bytes, NULL, &error);
    assert_int_equal(error, CL_SUCCESS);
    cl_command_queue queue =
        clCreateCommandQueue(info_of_device(device).context, info_of_device(device).device, 0, &error);
    assert_int_equal(clEnqueueWriteBuffer(queue, memory, CL_TRUE, 0, bytes, data, 0, NULL, NULL), CL_SUCCESS);
    clReleaseCommandQueue(queue);
    return memory;
}

static void interleaved_arrays_are_read_from_opencl(void **state)
{
    const fixture *opened = fixture_of_group(state);
    interleaved data;
    make_interleaved(&data);
    const svo_mesh_view vertices = {.memory = make_memory(opened->device, data.vertices, sizeof data.vertices)};
    const svo_mesh_view narrow = {.memory = make_memory(opened->device, data.indices, sizeof data.indices)};
    const svo_mesh_buffers buffers = interleaved_buffers(&vertices, &narrow);
    svo_message message = {""};
    svo_mesh_copy *copy = NULL;
    if (svo_mesh_read(&buffers, opened->queue, 0, NULL, &copy, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    check_interleaved_copy(copy);
    svo_mesh_copy_destroy(&copy);
    assert_null(copy);
    svo_mesh_copy_destroy(NULL);
    clReleaseMemObject(vertices.memory);
    clReleaseMemObject(narrow.memory);
}

static GLuint make_gl_buffer(const svo_i_gl_functions *gl, const void *data, size_t bytes)
{
    GLuint name = 0;
    gl->GenBuffers(1, &name);
    gl->BindBuffer(GL_ARRAY_BUFFER, name);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)bytes, data, GL_STATIC_DRAW);
    return name;
}

static void interleaved_arrays_are_read_from_opengl(void **state)
{
    (void)state;
    own_context own;
    interleaved data;
    svo_message message = {""};
    svo_gl_context *context = NULL;
    svo_mesh_copy *copy = NULL;
    make_interleaved(&data);
    own_context_make_or_skip(false, &own);
    assert_int_equal(context_wrap(own_context_function, &context, NULL), SVO_OK);
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(context);
    const svo_mesh_view vertices = {.gl_buffer = make_gl_buffer(gl, data.vertices, sizeof data.vertices)};
    const svo_mesh_view narrow = {.gl_buffer = make_gl_buffer(gl, data.indices, sizeof data.indices)};
    const svo_mesh_buffers buffers = interleaved_buffers(&vertices, &narrow);
    nondefault_state *odd = nondefault_state_set(false);
    if (svo_gl_mesh_read(&buffers, context, 0, NULL, &copy, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    nondefault_state_assert(odd, "svo_gl_mesh_read");
    check_interleaved_copy(copy);
    svo_mesh_copy_destroy(&copy);

    svo_mesh_buffers wrong = buffers;
    wrong.normals.gl_buffer = 4000000000u;
    assert_int_equal(svo_gl_mesh_read(&wrong, context, 0, NULL, &copy, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_gl_mesh_read: 4000000000 is no buffer of the context");
    wrong = buffers;
    wrong.vertex_count = CUBE_VERTICES + 1;
    assert_int_equal(svo_gl_mesh_read(&wrong, context, 0, NULL, &copy, &message), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "svo_gl_mesh_read: positions ends at byte"));
    nondefault_state_assert(odd, "reads that fail");
    nondefault_state_destroy(&odd);
    svo_gl_context_destroy(&context);
    own_context_destroy(&own);
}

static void wrong_buffers_are_refused(void **state)
{
    const fixture *opened = fixture_of_group(state);
    svo_message message = {""};
    svo_mesh_copy *copy = NULL;
    const svo_mesh_buffers right = {
        .struct_size = sizeof right,
        .vertex_count = CUBE_VERTICES,
        .triangle_count = CUBE_TRIANGLES,
        .positions = {.memory = make_memory(opened->device, positions, sizeof positions)},
        .indices = {.memory = make_memory(opened->device, indices, sizeof indices)},
    };
    struct {
        svo_mesh_buffers buffers;
        const char *words;
    } cases[7];
    for (size_t i = 0; i < 7; ++i) {
        cases[i].buffers = right;
    }
    cases[0].buffers.struct_size = 1;
    cases[0].words = "buffers.struct_size is 1";
    cases[1].buffers.positions.memory = NULL;
    cases[1].words = "buffers.positions names no buffer";
    cases[2].buffers.positions.stride_bytes = 8;
    cases[2].words = "positions.stride_bytes 8 is below the 12 of an element";
    cases[3].buffers.indices.offset_bytes = 4;
    cases[3].words = "indices ends at byte 148 of a buffer of 144 bytes";
    cases[4].buffers.index_bytes = 3;
    cases[4].words = "index_bytes 3 is none of";
    cases[5].buffers.positions.stride_bytes = SIZE_MAX / 2;
    cases[5].words = "positions does not fit the address space";
    cases[6].buffers.triangle_count = UINT32_MAX;
    cases[6].words = "not below 2^32 - 1";
    for (size_t i = 0; i < 7; ++i) {
        assert_int_equal(svo_mesh_read(&cases[i].buffers, opened->queue, 0, NULL, &copy, &message),
                         SVO_INVALID_ARGUMENT);
        if (strstr(message.text, cases[i].words) == NULL || strstr(message.text, "svo_mesh_read: ") != message.text) {
            fail_msg("'%s' does not contain '%s'", message.text, cases[i].words);
        }
    }
    assert_int_equal(svo_mesh_read(&right, NULL, 0, NULL, &copy, &message), SVO_INVALID_ARGUMENT);
    assert_null(copy);
    clReleaseMemObject(right.positions.memory);
    clReleaseMemObject(right.indices.memory);
}

/* Completes events one after the other, after a delay. */
typedef struct releaser {
    cl_event events[2];
    unsigned count;
    cl_int status;
    atomic_bool released;
} releaser;

static void *release_later(void *pointer)
{
    releaser *self = pointer;
    const struct timespec delay = {0, DELAY_MS * 1000000L};
    for (unsigned i = 0; i < self->count; ++i) {
        nanosleep(&delay, NULL);
        self->released = i + 1 == self->count;
        clSetUserEventStatus(self->events[i], self->status);
    }
    return NULL;
}

static cl_event user_event(const svo_device *device)
{
    cl_int error = CL_SUCCESS;
    cl_event event = clCreateUserEvent(info_of_device(device).context, &error);
    assert_int_equal(error, CL_SUCCESS);
    return event;
}

/* The cube's arrays in OpenCL buffers, each written by a command that waits for a user event of its own. */
typedef struct delayed_cube {
    svo_mesh_buffers buffers;
    cl_event written[2];
    releaser later;
    pthread_t thread;
} delayed_cube;

static void delay_cube(const svo_device *device, cl_command_queue queue, delayed_cube *out)
{
    static const unsigned char zeros[sizeof indices];
    *out = (delayed_cube){.later = {.count = 2, .status = CL_COMPLETE}};
    out->buffers = (svo_mesh_buffers){
        .struct_size = sizeof out->buffers, .vertex_count = CUBE_VERTICES, .triangle_count = CUBE_TRIANGLES};
    out->buffers.positions.memory = make_memory(device, zeros, sizeof positions);
    out->buffers.indices.memory = make_memory(device, zeros, sizeof indices);
    out->later.events[0] = user_event(device);
    out->later.events[1] = user_event(device);
    assert_int_equal(clEnqueueWriteBuffer(queue, out->buffers.positions.memory, CL_FALSE, 0, sizeof positions,
                                          positions, 1, &out->later.events[0], &out->written[0]),
                     CL_SUCCESS);
    assert_int_equal(clEnqueueWriteBuffer(queue, out->buffers.indices.memory, CL_FALSE, 0, sizeof indices, indices, 1,
                                          &out->later.events[1], &out->written[1]),
                     CL_SUCCESS);
    assert_int_equal(clFlush(queue), CL_SUCCESS);
}

static void forget_cube(delayed_cube *cube)
{
    assert_int_equal(pthread_join(cube->thread, NULL), 0);
    for (int i = 0; i < 2; ++i) {
        clReleaseEvent(cube->written[i]);
        clReleaseEvent(cube->later.events[i]);
    }
    clReleaseMemObject(cube->buffers.positions.memory);
    clReleaseMemObject(cube->buffers.indices.memory);
}

/* On an out-of-order queue, only the wait list orders the reads after the writes. */
static void inputs_that_come_late_are_waited_for(void **state)
{
    (void)state;
    fixture opened;
    delayed_cube cube;
    svo_mesh_copy *copy = NULL;
    fixture_open(&(fixture_options){.queue_properties = CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE}, &opened);
    for (int swapped = 0; swapped < 2; ++swapped) { /* either input completes last */
        built finished;
        delay_cube(opened.device, opened.queue, &cube);
        if (swapped) {
            const cl_event first = cube.later.events[0];
            cube.later.events[0] = cube.later.events[1];
            cube.later.events[1] = first;
        }
        assert_int_equal(pthread_create(&cube.thread, NULL, release_later, &cube.later), 0);
        assert_int_equal(svo_mesh_read(&cube.buffers, opened.queue, 2, cube.written, &copy, NULL), SVO_OK);
        assert_true(cube.later.released);
        fixture_build(&opened, svo_mesh_copy_get(copy), DEPTH, NULL, &finished);
        assert_int_equal(finished.info.leaf_count, 64 * 64 * 64 - 62 * 62 * 62);
        built_destroy(&finished);
        svo_mesh_copy_destroy(&copy);
        forget_cube(&cube);
    }
    fixture_close(&opened);
}

static void opengl_waits_for_events_of_opencl(void **state)
{
    const fixture *opened = fixture_of_group(state);
    svo_gl_context *context = opened->context;
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(context);
    releaser later = {.events = {user_event(opened->device)}, .count = 1, .status = CL_COMPLETE};
    pthread_t thread;
    svo_mesh_copy *copy = NULL;
    assert_int_equal(svo_i_gl_context_make_current(context, NULL), SVO_OK);
    GLuint name = make_gl_buffer(gl, positions, sizeof positions);
    svo_i_gl_context_release_current(context);
    const svo_mesh_buffers buffers = {
        .struct_size = sizeof buffers, .vertex_count = CUBE_VERTICES, .positions = {.gl_buffer = name}};
    assert_int_equal(pthread_create(&thread, NULL, release_later, &later), 0);
    assert_int_equal(svo_gl_mesh_read(&buffers, context, 1, later.events, &copy, NULL), SVO_OK);
    assert_true(later.released);
    assert_memory_equal(svo_mesh_copy_get(copy)->positions, positions, sizeof positions);
    assert_null(svo_mesh_copy_get(copy)->indices);
    svo_mesh_copy_destroy(&copy);
    assert_int_equal(pthread_join(thread, NULL), 0);
    clReleaseEvent(later.events[0]);
    assert_int_equal(svo_i_gl_context_make_current(context, NULL), SVO_OK);
    gl->DeleteBuffers(1, &name);
    svo_i_gl_context_release_current(context);
}

/* An input event that fails ends in a status. */
static void failed_events_are_a_status(void **state)
{
    const fixture *opened = fixture_of_group(state);
    svo_message message = {""};
    svo_mesh_copy *copy = NULL;
    cl_event failed = user_event(opened->device);
    assert_int_equal(clSetUserEventStatus(failed, CL_OUT_OF_RESOURCES), CL_SUCCESS);
    const svo_mesh_buffers buffers = {
        .struct_size = sizeof buffers, .vertex_count = CUBE_VERTICES, .positions = {.gl_buffer = 1}};
    assert_int_equal(svo_gl_mesh_read(&buffers, opened->context, 1, &failed, &copy, &message), SVO_CL_ERROR);
    assert_non_null(strstr(message.text, "clWaitForEvents failed with CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST"));
    assert_null(copy);
    clReleaseEvent(failed);
}

/* A tree's buffer that the application retains outlives tree, plan, front end and device handle. */
static void retained_buffers_outlive_the_tree(void **state)
{
    (void)state;
    fixture opened;
    built finished;
    const svo_mesh cube = {.struct_size = sizeof cube,
                           .positions = positions,
                           .vertex_count = CUBE_VERTICES,
                           .indices = indices,
                           .triangle_count = CUBE_TRIANGLES};
    fixture_open(&(fixture_options){0}, &opened);
    fixture_build(&opened, &cube, DEPTH, NULL, &finished);
    cl_mem mask = svo_tree_get_buffer(finished.tree, SVO_TREE_CHILD_MASK);
    cl_command_queue queue = opened.queue;
    assert_int_equal(clRetainMemObject(mask), CL_SUCCESS);
    assert_int_equal(clRetainCommandQueue(queue), CL_SUCCESS);
    const size_t bytes = (size_t)finished.info.inner_count;
    uint8_t *expected = malloc(bytes), *actual = malloc(bytes);
    assert_non_null(expected);
    assert_non_null(actual);
    memcpy(expected, finished.arrays.child_mask, bytes);
    built_destroy(&finished);
    fixture_close(&opened);

    assert_int_equal(clEnqueueReadBuffer(queue, mask, CL_TRUE, 0, bytes, actual, 0, NULL, NULL), CL_SUCCESS);
    assert_memory_equal(actual, expected, bytes);
    cl_uint references = 0;
    clGetMemObjectInfo(mask, CL_MEM_REFERENCE_COUNT, sizeof references, &references, NULL);
    assert_int_equal(references, 1);
    clReleaseMemObject(mask);
    clReleaseCommandQueue(queue);
    free(expected);
    free(actual);
}

TEST_GROUP(mesh_read)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(interleaved_arrays_are_read_from_opencl),
        cmocka_unit_test(interleaved_arrays_are_read_from_opengl),
        cmocka_unit_test(wrong_buffers_are_refused),
        cmocka_unit_test(inputs_that_come_late_are_waited_for),
        cmocka_unit_test(opengl_waits_for_events_of_opencl),
        cmocka_unit_test(failed_events_are_a_status),
        cmocka_unit_test(retained_buffers_outlive_the_tree),
    };
    return cmocka_run_group_tests_name("mesh_read", tests, fixture_group_setup, fixture_group_teardown);
}
