/* SPDX-License-Identifier: MIT */
/*
 * Buffers that OpenCL writes and OpenGL reads: a picture gets from the library into a texture of the caller's context
 * with every byte, on every way; the way that was taken is told, and why the others were not; the caller's OpenGL state
 * stays. cl_khr_gl_sharing is that of a fake driver.
 */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scenes.h"
#include "support/fixture.h"
#include "support/gl_contexts.h"
#include "support/gl_interop_shim.h"
#include "support/info_of.h"
#include "support/machine.h"
#include "support/nondefault_state.h"
#include "support/own_context.h"
#include "support/suite.h"

#define DEPTH         5
#define WIDTH         52
#define HEIGHT        37
#define PICTURE_BYTES ((size_t)WIDTH * HEIGHT * 4)
/* More than a picture, and no multiple of anything. */
#define BUFFER_BYTES (PICTURE_BYTES + 1237)

/* The caller's functions of OpenGL, and what the library draws. */
typedef struct application {
    own_context own;
    svo_gl_context *context;
    fixture opened; /* without OpenGL */
    built made;
    svo_render_options options;
    bool has_shim;
    PFNGLGENTEXTURESPROC GenTextures;
    PFNGLDELETETEXTURESPROC DeleteTextures;
    PFNGLBINDTEXTUREPROC BindTexture;
    PFNGLBINDBUFFERPROC BindBuffer;
    PFNGLTEXIMAGE2DPROC TexImage2D;
    PFNGLTEXSUBIMAGE2DPROC TexSubImage2D;
    PFNGLGETTEXIMAGEPROC GetTexImage;
} application;

static void load(application *of)
{
#define LOAD(name)                                                            \
    do {                                                                      \
        const svo_gl_function found = own_context_function(NULL, "gl" #name); \
        assert_non_null(found);                                               \
        memcpy(&of->name, &found, sizeof found);                              \
    } while (0)
    LOAD(GenTextures);
    LOAD(DeleteTextures);
    LOAD(BindTexture);
    LOAD(BindBuffer);
    LOAD(TexImage2D);
    LOAD(TexSubImage2D);
    LOAD(GetTexImage);
#undef LOAD
}

/* faults: NULL for the driver as it is. */
static void open_application(const shim_faults *faults, application *out)
{
    svo_message message = {""};
    struct scene *knot = fixture_scene("knot:500");
    *out = (application){.has_shim = faults != NULL};
    own_context_make_or_skip(false, &out->own);
    load(out);
    if (context_wrap(own_context_function, &out->context, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    if (faults != NULL) {
        shim_install(out->context, faults);
    }
    if (svo_gl_device_create(out->context, NULL, NULL, &out->opened.device, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    out->opened.queue = clCreateCommandQueue(info_of_device(out->opened.device).context,
                                             info_of_device(out->opened.device).device, 0, NULL);
    assert_int_equal(svo_frontend_create_cl(out->opened.device, &out->opened.cl), SVO_OK);
    out->opened.frontend = out->opened.cl;
    fixture_build(&out->opened, scene_mesh(knot), DEPTH, NULL, &out->made);
    out->options = (svo_render_options){.struct_size = sizeof out->options, .width = WIDTH, .height = HEIGHT};
    (void)svo_camera_fit(svo_tree_target(out->made.tree), (float)WIDTH / HEIGHT, &out->options.camera);
    scene_destroy(&knot);
}

static void close_application(application *of)
{
    built_destroy(&of->made);
    if (of->has_shim) {
        shim_end(of->context);
    }
    fixture_close(&of->opened);
    svo_gl_context_destroy(&of->context);
    own_context_destroy(&of->own);
}

static void succeed(const application *of, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(of->opened.device));
    }
}

static svo_gl_buffer *make_buffer(const application *of, svo_gl_share share)
{
    svo_gl_buffer *made = NULL;
    succeed(of, svo_gl_buffer_create(of->opened.device, of->context, BUFFER_BYTES, share, &made));
    return made;
}

static svo_gl_buffer_info info_of(const svo_gl_buffer *buffer)
{
    svo_gl_buffer_info info = SVO_GL_BUFFER_INFO_INIT;
    assert_int_equal(svo_gl_buffer_get_info(buffer, &info), SVO_OK);
    return info;
}

/* From the library into the buffer, and from there into a texture. */
static void bring_picture(const application *of, svo_gl_buffer *buffer, GLuint texture)
{
    const svo_gl_buffer_info info = info_of(buffer);
    const uintptr_t begin = (uintptr_t)info.offset_bytes;
    const void *offset = NULL; /* OpenGL takes an offset in the buffer for a pointer */
    cl_event drawn = NULL;
    succeed(of, svo_gl_buffer_to_cl(buffer, of->opened.queue));
    succeed(of, svo_render(svo_tree_target(of->made.tree), &of->options, svo_in_buffer(info.memory),
                           &(svo_submit){.queue = of->opened.queue, .event = &drawn}));
    succeed(of, svo_gl_buffer_to_gl(buffer, PICTURE_BYTES, of->opened.queue, 1, &drawn));
    clReleaseEvent(drawn);
    of->BindTexture(GL_TEXTURE_2D, texture);
    of->BindBuffer(GL_PIXEL_UNPACK_BUFFER, info.name);
    memcpy(&offset, &begin, sizeof offset);
    of->TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, WIDTH, HEIGHT, GL_RGBA, GL_UNSIGNED_BYTE, offset);
    of->BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
}

/* Each view replaces the one before, so a stale buffer is noticed. */
static void compare_pictures(application *of, svo_gl_share asked, svo_gl_share expected)
{
    static const svo_render_view views[] = {SVO_VIEW_SHADED, SVO_VIEW_NORMAL, SVO_VIEW_LEVEL};
    static uint8_t drawn[PICTURE_BYTES];
    static uint8_t shown[PICTURE_BYTES];
    GLuint texture = 0;
    svo_gl_buffer *buffer = make_buffer(of, asked);
    assert_int_equal(info_of(buffer).share, expected);
    assert_string_equal(svo_gl_buffer_share_reason(buffer, expected), "");
    assert_int_equal(info_of(buffer).bytes, BUFFER_BYTES);
    of->GenTextures(1, &texture);
    of->BindTexture(GL_TEXTURE_2D, texture);
    of->TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, WIDTH, HEIGHT, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    for (size_t i = 0; i < sizeof views / sizeof views[0]; ++i) {
        of->options.view = views[i];
        succeed(of, svo_render(svo_tree_target(of->made.tree), &of->options, svo_in_host(drawn),
                               &(svo_submit){.queue = of->opened.queue}));
        bring_picture(of, buffer, texture);
        of->GetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_UNSIGNED_BYTE, shown);
        assert_memory_equal(shown, drawn, PICTURE_BYTES);
    }
    of->DeleteTextures(1, &texture);
    svo_gl_buffer_destroy(&buffer);
    assert_null(buffer);
}

/* ---- ways ---- */

static void pictures_are_copied(void **state)
{
    (void)state;
    application of;
    open_application(NULL, &of);
    compare_pictures(&of, SVO_GL_SHARE_COPY, SVO_GL_SHARE_COPY);
    close_application(&of);
}

/* OpenCL's pictures lie in memory of OpenGL. */
static void pictures_stay_in_mapped_memory(void **state)
{
    (void)state;
    application of;
    open_application(NULL, &of);
    svo_gl_buffer *copied = make_buffer(&of, SVO_GL_SHARE_COPY);
    const char *reason = svo_gl_buffer_share_reason(copied, SVO_GL_SHARE_HOST);
    const bool works = reason[0] == '\0';
    if (!works) {
        print_message("skipped: host: %s\n", reason);
    }
    svo_gl_buffer_destroy(&copied);
    if (works) {
        compare_pictures(&of, SVO_GL_SHARE_HOST, SVO_GL_SHARE_HOST);
    }
    close_application(&of);
    if (!works) {
        skip();
    }
}

static void pictures_are_shared(void **state)
{
    (void)state;
    static const shim_faults drivers[] = {{.extensions = NULL}, {.extensions = "cl_khr_gl_sharing"}};
    for (size_t i = 0; i < sizeof drivers / sizeof drivers[0]; ++i) {
        application of;
        open_application(&drivers[i], &of);
        compare_pictures(&of, SVO_GL_SHARE_INTEROP, SVO_GL_SHARE_INTEROP);
        compare_pictures(&of, SVO_GL_SHARE_AUTO, SVO_GL_SHARE_INTEROP);
        close_application(&of);
    }
}

/* Without the extension, AUTO takes another way, and words say why. */
static void the_way_has_its_reason(void **state)
{
    (void)state;
    application of;
    svo_gl_buffer *refused = NULL;
    open_application(&(shim_faults){.extensions = "cl_khr_fp64"}, &of);
    svo_gl_buffer *buffer = make_buffer(&of, SVO_GL_SHARE_AUTO);
    assert_true(info_of(buffer).share == SVO_GL_SHARE_HOST || info_of(buffer).share == SVO_GL_SHARE_COPY);
    assert_non_null(
        strstr(svo_gl_buffer_share_reason(buffer, SVO_GL_SHARE_INTEROP), "does not list cl_khr_gl_sharing"));
    assert_string_equal(svo_gl_buffer_share_reason(buffer, (svo_gl_share)9), "unknown");
    assert_int_equal(svo_gl_buffer_create(of.opened.device, of.context, BUFFER_BYTES, SVO_GL_SHARE_INTEROP, &refused),
                     SVO_UNSUPPORTED);
    assert_null(refused);
    assert_non_null(
        strstr(svo_device_message(of.opened.device), "svo_gl_buffer_create: share interop does not work: "));
    svo_gl_buffer_destroy(&buffer);
    close_application(&of);
}

/* A driver whose release brings nothing back is found out by the self-test. */
static void stale_pictures_are_found_out(void **state)
{
    (void)state;
    application of;
    open_application(&(shim_faults){.releases_nothing = true}, &of);
    svo_gl_buffer *buffer = make_buffer(&of, SVO_GL_SHARE_AUTO);
    assert_int_not_equal(info_of(buffer).share, SVO_GL_SHARE_INTEROP);
    assert_non_null(
        strstr(svo_gl_buffer_share_reason(buffer, SVO_GL_SHARE_INTEROP), "the self-test failed: OpenGL reads 0x"));
    svo_gl_buffer_destroy(&buffer);
    close_application(&of);
}

/* ---- failures ---- */

static void a_failing_call_is_a_status_and_the_next_works(void **state)
{
    (void)state;
    application of;
    open_application(&(shim_faults){.extensions = NULL}, &of);
    svo_gl_buffer *buffer = make_buffer(&of, SVO_GL_SHARE_INTEROP);
    shim_set_faults(&(shim_faults){.acquire_error = CL_INVALID_GL_OBJECT});
    assert_int_equal(svo_gl_buffer_to_cl(buffer, of.opened.queue), SVO_CL_ERROR);
    assert_string_equal(svo_device_message(of.opened.device),
                        "svo_gl_buffer_to_cl: clEnqueueAcquireGLObjects failed with CL_INVALID_GL_OBJECT (-60)");
    shim_set_faults(&(shim_faults){.extensions = NULL});
    svo_gl_buffer_destroy(&buffer);
    compare_pictures(&of, SVO_GL_SHARE_INTEROP, SVO_GL_SHARE_INTEROP);
    close_application(&of);
}

static void expect_refused(const application *of, svo_status status, const char *words)
{
    assert_int_equal(status, SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(of->opened.device), words);
}

static void wrong_arguments_are_refused(void **state)
{
    (void)state;
    application of;
    svo_gl_buffer *none = NULL;
    open_application(NULL, &of);
    svo_device *device = of.opened.device;
    svo_gl_buffer *buffer = make_buffer(&of, SVO_GL_SHARE_COPY);
    assert_int_equal(svo_gl_buffer_create(NULL, of.context, 4, SVO_GL_SHARE_AUTO, &none), SVO_INVALID_ARGUMENT);
    expect_refused(&of, svo_gl_buffer_create(device, NULL, 4, SVO_GL_SHARE_AUTO, &none),
                   "svo_gl_buffer_create: context is NULL");
    expect_refused(&of, svo_gl_buffer_create(device, of.context, 4, SVO_GL_SHARE_AUTO, NULL),
                   "svo_gl_buffer_create: out is NULL");
    expect_refused(&of, svo_gl_buffer_create(device, of.context, 0, SVO_GL_SHARE_COPY, &none),
                   "svo_gl_buffer_create: bytes is 0");
    expect_refused(&of, svo_gl_buffer_create(device, of.context, 4, (svo_gl_share)4, &none),
                   "svo_gl_buffer_create: share 4 is not in 0 .. 3");
    assert_int_equal(svo_gl_buffer_create(device, of.context, SIZE_MAX / 2, SVO_GL_SHARE_COPY, &none),
                     SVO_OUT_OF_DEVICE_MEMORY);
    assert_null(none);
    expect_refused(&of, svo_gl_buffer_get_info(buffer, NULL), "svo_gl_buffer_get_info: info is NULL");
    expect_refused(&of, svo_gl_buffer_to_gl(buffer, 4, of.opened.queue, 0, NULL),
                   "svo_gl_buffer_to_gl: svo_gl_buffer_to_cl was not called before");
    succeed(&of, svo_gl_buffer_to_cl(buffer, NULL));
    expect_refused(&of, svo_gl_buffer_to_gl(buffer, 4, NULL, 1, NULL),
                   "svo_gl_buffer_to_gl: num_wait and wait disagree");
    expect_refused(&of, svo_gl_buffer_to_gl(buffer, BUFFER_BYTES + 1, NULL, 0, NULL),
                   "svo_gl_buffer_to_gl: used_bytes 8934 is above the buffer's 8933");
    succeed(&of, svo_gl_buffer_to_gl(buffer, BUFFER_BYTES, NULL, 0, NULL));
    assert_int_equal(svo_gl_buffer_to_cl(NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_gl_buffer_to_gl(NULL, 0, NULL, 0, NULL), SVO_INVALID_ARGUMENT);
    svo_gl_buffer_destroy(&buffer);
    svo_gl_buffer_destroy(&buffer);
    svo_gl_buffer_destroy(NULL);
    close_application(&of);
}

/* ---- state ---- */

static void the_callers_state_stays(void **state)
{
    (void)state;
    application of;
    open_application(NULL, &of);
    nondefault_state *odd = nondefault_state_set(false);
    for (svo_gl_share share = SVO_GL_SHARE_AUTO; share <= SVO_GL_SHARE_COPY; ++share) {
        svo_gl_buffer *buffer = NULL;
        if (svo_gl_buffer_create(of.opened.device, of.context, BUFFER_BYTES, share, &buffer) != SVO_OK) {
            continue; /* this driver has no such way */
        }
        nondefault_state_assert(odd, "svo_gl_buffer_create");
        succeed(&of, svo_gl_buffer_to_cl(buffer, NULL));
        nondefault_state_assert(odd, "svo_gl_buffer_to_cl");
        succeed(&of, svo_gl_buffer_to_gl(buffer, BUFFER_BYTES, NULL, 0, NULL));
        nondefault_state_assert(odd, "svo_gl_buffer_to_gl");
        succeed(&of, svo_gl_buffer_to_cl(buffer, NULL));
        nondefault_state_assert(odd, "svo_gl_buffer_to_cl");
        svo_gl_buffer_destroy(&buffer);
        nondefault_state_assert(odd, "svo_gl_buffer_destroy");
    }
    nondefault_state_destroy(&odd);
    close_application(&of);
}

TEST_GROUP(gl_buffer)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_are_copied),          cmocka_unit_test(pictures_stay_in_mapped_memory),
        cmocka_unit_test(pictures_are_shared),          cmocka_unit_test(the_way_has_its_reason),
        cmocka_unit_test(stale_pictures_are_found_out), cmocka_unit_test(a_failing_call_is_a_status_and_the_next_works),
        cmocka_unit_test(wrong_arguments_are_refused),  cmocka_unit_test(the_callers_state_stays),
    };
    return cmocka_run_group_tests_name("gl_buffer", tests, NULL, NULL);
}
