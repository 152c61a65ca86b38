/* SPDX-License-Identifier: MIT */
/*
 * Pictures of svocl view on their way from OpenCL to OpenGL: shared with a fake driver that has cl_khr_gl_sharing, by
 * another way without it; every byte arrives, and the state says which way and why.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/fixture.h"
#include "support/gl_contexts.h"
#include "support/gl_interop_shim.h"
#include "support/info_of.h"
#include "support/own_context.h"
#include "support/suite.h"
#include "view/canvas.h"

#define SMALL_BYTES 4096
#define LARGE_BYTES 12345

/* The program's, for messages. */
static char failure[256];

int program_fail_library(program *state, const char *message)
{
    (void)state;
    (void)snprintf(failure, sizeof failure, "%s", message);
    return PROGRAM_FAILED;
}

typedef struct window_pair {
    own_context own;
    svo_gl_context *context;
    svo_device *device;
    cl_command_queue queue;
    view_state *state;
    pixel_buffer pixels;
} window_pair;

static window_pair open_pair(const shim_faults *faults)
{
    window_pair made = {.state = calloc(1, sizeof *made.state)};
    assert_non_null(made.state);
    own_context_make_or_skip(false, &made.own);
    assert_int_equal(context_wrap(own_context_function, &made.context, NULL), SVO_OK);
    shim_install(made.context, faults);
    assert_int_equal(svo_gl_device_create(made.context, NULL, NULL, &made.device, NULL), SVO_OK);
    made.queue = clCreateCommandQueue(info_of_device(made.device).context, info_of_device(made.device).device, 0, NULL);
    assert_non_null(made.queue);
    made.pixels.context = made.context;
    return made;
}

static void close_pair(window_pair *pair)
{
    shim_counts counts;
    pixel_buffer_drop(&pair->pixels);
    assert_null(pair->pixels.buffer);
    shim_get_counts(&counts);
    if (counts.violations != 0) {
        fail_msg("%u violations, the last: %s", counts.violations, counts.last_violation);
    }
    shim_remove(pair->context);
    clReleaseCommandQueue(pair->queue);
    svo_device_destroy(&pair->device);
    svo_gl_context_destroy(&pair->context);
    own_context_destroy(&pair->own);
    view_state_end(pair->state);
    free(pair->state);
}

static void read_in_gl(const svo_gl_buffer_info *info, size_t bytes, uint8_t *out)
{
    PFNGLBINDBUFFERPROC bind = (PFNGLBINDBUFFERPROC)own_context_function(NULL, "glBindBuffer");
    PFNGLGETBUFFERSUBDATAPROC get = (PFNGLGETBUFFERSUBDATAPROC)own_context_function(NULL, "glGetBufferSubData");
    bind(GL_PIXEL_UNPACK_BUFFER, info->name);
    get(GL_PIXEL_UNPACK_BUFFER, (GLintptr)info->offset_bytes, (GLsizeiptr)bytes, out);
    bind(GL_PIXEL_UNPACK_BUFFER, 0);
}

/* Three pictures, of which the last one needs more room. */
static void bring_pictures(window_pair *pair)
{
    static const size_t sizes[] = {SMALL_BYTES, SMALL_BYTES / 2, LARGE_BYTES};
    static uint8_t drawn[LARGE_BYTES];
    static uint8_t shown[LARGE_BYTES];
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
        cl_event done = NULL;
        assert_int_equal(pixel_buffer_begin(&pair->pixels, pair->device, pair->queue, sizes[i], pair->state),
                         PROGRAM_DONE);
        assert_true(pair->pixels.info.bytes >= sizes[i]);
        memset(drawn, 17 + (int)i, sizes[i]);
        assert_int_equal(
            clEnqueueWriteBuffer(pair->queue, pair->pixels.info.memory, CL_TRUE, 0, sizes[i], drawn, 0, NULL, &done),
            CL_SUCCESS);
        assert_int_equal(pixel_buffer_finish(&pair->pixels, sizes[i], done), PROGRAM_DONE);
        read_in_gl(&pair->pixels.info, sizes[i], shown);
        assert_memory_equal(shown, drawn, sizes[i]);
    }
    assert_int_equal(pair->state->log_count, 1); /* a larger buffer travels as the one before */
}

static void pictures_are_shared(void **unused)
{
    (void)unused;
    window_pair pair = open_pair(&(shim_faults){.extensions = NULL});
    bring_pictures(&pair);
    assert_string_equal(pair.state->share, "interop");
    assert_string_equal(pair.state->share_reason, "shared by both");
    assert_string_equal(pair.state->log[0], "pictures: interop, shared by both");
    close_pair(&pair);
}

static void another_way_has_its_reason(void **unused)
{
    (void)unused;
    window_pair pair = open_pair(&(shim_faults){.extensions = "cl_khr_fp64"});
    bring_pictures(&pair);
    assert_true(strcmp(pair.state->share, "host") == 0 || strcmp(pair.state->share, "copy") == 0);
    assert_non_null(strstr(pair.state->share_reason, "does not list cl_khr_gl_sharing"));
    assert_non_null(strstr(pair.state->log[0], pair.state->share_reason));
    close_pair(&pair);
}

static void failures_have_words(void **unused)
{
    (void)unused;
    window_pair pair = open_pair(&(shim_faults){.extensions = NULL});
    bring_pictures(&pair);
    shim_set_faults(&(shim_faults){.acquire_error = CL_INVALID_GL_OBJECT});
    assert_int_equal(pixel_buffer_begin(&pair.pixels, pair.device, pair.queue, SMALL_BYTES, pair.state),
                     PROGRAM_FAILED);
    assert_non_null(strstr(failure, "clEnqueueAcquireGLObjects failed with CL_INVALID_GL_OBJECT"));
    close_pair(&pair);
}

TEST_GROUP(view_pixels)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_are_shared),
        cmocka_unit_test(another_way_has_its_reason),
        cmocka_unit_test(failures_have_words),
    };
    return cmocka_run_group_tests_name("view_pixels", tests, NULL, NULL);
}
