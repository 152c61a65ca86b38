/* SPDX-License-Identifier: MIT */
/*
 * OpenGL drivers that lose the context, run out of memory or return nonsense, at every point where svocl can notice.
 * Each failure ends in a status with a message, nothing crashes, and the same handles work again after the driver
 * recovers.
 *
 * A context with a modified function table plays such a driver.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "core/device.h"
#include "support/fixture.h"
#include "support/machine.h"
#include "support/meshes.h"
#include "support/suite.h"

enum { TRIANGLES = 60, DEPTH = 6, POINTS_MAX = 1000 };

#define RESET_STATUS 0x8253 /* GL_GUILTY_CONTEXT_RESET */

/* The original functions of the context with the bad driver, and its faults. The replaced functions have no user
   pointer, so this is global. */
static svo_i_gl_functions honest;
static GLenum error_told;
static unsigned errors_spared;

static void spoil(svo_gl_context *context)
{
    honest = context->functions;
}

static void mend(svo_gl_context *context)
{
    context->functions = honest;
}

/* GL_NO_ERROR this many times, then the error forever, like a lost context. */
static GLenum APIENTRY tell_error(void)
{
    const GLenum real = honest.GetError();
    if (errors_spared == 0) {
        return error_told;
    }
    --errors_spared;
    return real;
}

static GLenum APIENTRY tell_reset(void)
{
    return errors_spared-- == 0 ? RESET_STATUS : GL_NO_ERROR;
}

typedef struct bad_setup {
    fixture opened; /* gl is NULL where a test creates its own */
    owned_mesh made;
    svo_plan *plan;
} bad_setup;

static void open_setup(svo_gl_share share, bad_setup *out)
{
    *out = (bad_setup){0};
    fixture_open(&(fixture_options){.share = share}, &out->opened);
    random_mesh(11, TRIANGLES, 0.0, &out->made);
    if (svo_plan_create(out->opened.device, &out->made.mesh, DEPTH, NULL, &out->plan) != SVO_OK) {
        fail_msg("%s", svo_device_message(out->opened.device));
    }
}

static svo_status build(const bad_setup *setup)
{
    svo_tree *tree = NULL;
    const svo_status status =
        svo_build(setup->plan, svo_gl_frontend(setup->opened.gl), setup->opened.queue, &tree, NULL);
    assert_int_equal(status == SVO_OK, tree != NULL);
    svo_tree_destroy(&tree);
    return status;
}

/* Checks that the handles still work. */
static void close_setup(bad_setup *setup)
{
    if (build(setup) != SVO_OK) {
        fail_msg("%s", svo_device_message(setup->opened.device));
    }
    svo_plan_destroy(&setup->plan);
    fixture_close(&setup->opened);
    owned_mesh_free(&setup->made);
}

static void assert_words(const bad_setup *setup, const char *words)
{
    const char *message = svo_device_message(setup->opened.device);
    if (strstr(message, words) == NULL) {
        fail_msg("'%s' does not contain '%s'", message, words);
    }
}

/* Builds with the error at each point in succession, until a build succeeds before it reaches the point. */
static void fail_everywhere(svo_gl_share share, GLenum error, svo_status expected, const char *words)
{
    bad_setup setup;
    unsigned point = 0;
    open_setup(share, &setup);
    assert_int_equal(build(&setup), SVO_OK); /* shaders are compiled */
    for (; point < POINTS_MAX; ++point) {
        spoil(setup.opened.context);
        setup.opened.context->functions.GetError = tell_error;
        error_told = error;
        errors_spared = point;
        const svo_status status = build(&setup);
        mend(setup.opened.context);
        if (status == SVO_OK) {
            break;
        }
        assert_int_equal(status, expected);
        assert_words(&setup, words);
    }
    print_message("%s at %u points\n", words, point);
    assert_in_range(point, 5, POINTS_MAX - 1);
    close_setup(&setup);
}

static void lost_context_is_a_status_everywhere(void **state)
{
    (void)state;
    fail_everywhere(SVO_GL_SHARE_AUTO, GL_CONTEXT_LOST, SVO_GL_ERROR, "GL_CONTEXT_LOST");
    fail_everywhere(SVO_GL_SHARE_COPY, GL_CONTEXT_LOST, SVO_GL_ERROR, "GL_CONTEXT_LOST");
}

static void out_of_memory_is_a_status_everywhere(void **state)
{
    (void)state;
    fail_everywhere(SVO_GL_SHARE_AUTO, GL_OUT_OF_MEMORY, SVO_OUT_OF_DEVICE_MEMORY, "GL_OUT_OF_MEMORY");
    fail_everywhere(SVO_GL_SHARE_COPY, GL_OUT_OF_MEMORY, SVO_OUT_OF_DEVICE_MEMORY, "GL_OUT_OF_MEMORY");
}

static void reset_is_noticed(void **state)
{
    (void)state;
    bad_setup setup;
    open_setup(SVO_GL_SHARE_COPY, &setup);
    for (unsigned point = 0; point < 5; ++point) {
        spoil(setup.opened.context);
        setup.opened.context->functions.GetGraphicsResetStatus = tell_reset;
        errors_spared = point;
        assert_int_equal(build(&setup), SVO_GL_ERROR);
        mend(setup.opened.context);
        assert_words(&setup, "the context was lost");
    }
    close_setup(&setup);
}

/* The first creation of objects and shaders fails. */
static void failure_while_starting_is_a_status(void **state)
{
    (void)state;
    static const GLenum errors[] = {GL_CONTEXT_LOST, GL_OUT_OF_MEMORY};
    bad_setup setup;
    open_setup(SVO_GL_SHARE_COPY, &setup);
    for (unsigned point = 0; point < 40; ++point) {
        fixture *opened = &setup.opened;
        svo_gl_destroy(&opened->gl);
        spoil(opened->context);
        opened->context->functions.GetError = tell_error;
        error_told = errors[point % 2];
        errors_spared = point / 2;
        svo_status status = svo_gl_create(opened->device, opened->context, NULL, &opened->gl);
        if (status == SVO_OK) {
            (void)build(&setup);
        } else {
            assert_true(status == SVO_GL_ERROR || status == SVO_OUT_OF_DEVICE_MEMORY);
            assert_null(opened->gl);
        }
        mend(opened->context);
    }
    svo_gl_destroy(&setup.opened.gl);
    assert_int_equal(svo_gl_create(setup.opened.device, setup.opened.context, NULL, &setup.opened.gl), SVO_OK);
    close_setup(&setup);
}

/*
 * Functions that return nonsense.
 */

static void *APIENTRY map_nothing(GLenum target, GLintptr offset, GLsizeiptr length, GLbitfield access)
{
    (void)target;
    (void)offset;
    (void)length;
    (void)access;
    return NULL;
}

static GLboolean APIENTRY unmap_lost(GLenum target)
{
    (void)honest.UnmapBuffer(target);
    return GL_FALSE;
}

static GLenum APIENTRY never_complete(GLenum target)
{
    (void)target;
    return GL_FRAMEBUFFER_UNSUPPORTED;
}

static GLuint counter_value;

static void APIENTRY read_nonsense(GLenum target, GLintptr offset, GLsizeiptr bytes, void *data)
{
    (void)target;
    (void)offset;
    for (GLsizeiptr i = 0; i + 4 <= bytes; i += 4) {
        memcpy((char *)data + i, &counter_value, 4);
    }
}

static void mapping_that_fails_is_a_status(void **state)
{
    (void)state;
    bad_setup setup;
    open_setup(SVO_GL_SHARE_COPY, &setup);
    spoil(setup.opened.context);
    setup.opened.context->functions.MapBufferRange = map_nothing;
    assert_int_equal(build(&setup), SVO_GL_ERROR);
    assert_words(&setup, "glMapBufferRange returned NULL");
    mend(setup.opened.context);
    setup.opened.context->functions.UnmapBuffer = unmap_lost;
    assert_int_equal(build(&setup), SVO_GL_ERROR);
    assert_words(&setup, "glUnmapBuffer reports that the content was lost");
    mend(setup.opened.context);
    setup.opened.context->functions.CheckFramebufferStatus = never_complete;
    assert_int_equal(build(&setup), SVO_GL_ERROR);
    assert_words(&setup, "is not complete");
    mend(setup.opened.context);
    close_setup(&setup);
}

/* Damages the list on its way through the host. */
static uint32_t list[1 << 20];

static void *APIENTRY map_list(GLenum target, GLintptr offset, GLsizeiptr bytes, GLbitfield access)
{
    (void)target;
    (void)offset;
    (void)access;
    return (size_t)bytes <= sizeof list ? list : NULL;
}

static GLboolean APIENTRY unmap_nothing(GLenum target)
{
    (void)target;
    return GL_TRUE;
}

static void spoil_list_for_cl(svo_i_gl_functions *functions)
{
    functions->MapBufferRange = map_list;
    functions->UnmapBuffer = unmap_nothing;
}

/* Damages the list before a launch: the first decides what rasterization left undecided, the next builds the tree. */
enum { LAUNCH_DECIDE, LAUNCH_MARK };
static unsigned launches, launch_spoilt;

static void APIENTRY dispatch_on_list(GLuint columns, GLuint rows, GLuint layers)
{
    GLint chunk = 0;
    GLint64 bytes = 0;
    if (launches++ == launch_spoilt) {
        honest.GetIntegeri_v(GL_SHADER_STORAGE_BUFFER_BINDING, 0, &chunk);
        honest.BindBuffer(GL_COPY_WRITE_BUFFER, (GLuint)chunk);
        honest.GetBufferParameteri64v(GL_COPY_WRITE_BUFFER, GL_BUFFER_SIZE, &bytes);
        assert_in_range(bytes, 8, sizeof list);
        honest.BufferSubData(GL_COPY_WRITE_BUFFER, 0, (GLsizeiptr)bytes, list);
    }
    honest.DispatchCompute(columns, rows, layers);
}

static void spoil_list_in_gl(svo_i_gl_functions *functions)
{
    launches = 0;
    launch_spoilt = LAUNCH_MARK;
    functions->DispatchCompute = dispatch_on_list;
}

static svo_status build_in_gl(const bad_setup *setup)
{
    svo_tree *tree = NULL;
    const svo_status status = svo_gl_build(setup->opened.gl, setup->plan, setup->opened.queue, &tree, NULL);
    svo_tree_destroy(&tree);
    return status;
}

/* A builder, and the function that damages its list. */
typedef struct method {
    svo_builder builder;
    const char *function;
    svo_status (*build)(const bad_setup *setup);
    void (*spoil_list)(svo_i_gl_functions *functions);
} method;

/* Fragments without a triangle or outside the grid, alone or among valid ones: no read or write follows them. */
static void expect_nonsense_noticed(const method *by)
{
    static const uint32_t values[] = {0xffffffffu, 0x80000000u, TRIANGLES};
    bad_setup setup;
    open_setup(SVO_GL_SHARE_COPY, &setup);
    svo_plan_destroy(&setup.plan);
    const svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_ALL, .builder = by->builder};
    assert_int_equal(svo_plan_create(setup.opened.device, &setup.made.mesh, DEPTH, &options, &setup.plan), SVO_OK);
    assert_int_equal(by->build(&setup), SVO_OK); /* shaders are compiled */
    for (size_t i = 0; i < 2 * sizeof values / sizeof values[0]; ++i) {
        memset(list, 0, sizeof list);
        for (size_t word = i % 2; word < sizeof list / sizeof list[0]; word += i < 3 ? 2 : 502) {
            list[word] = values[i / 2];
        }
        list[1] = i == 5 ? TRIANGLES : list[1];
        spoil(setup.opened.context);
        by->spoil_list(&setup.opened.context->functions);
        const svo_status status = by->build(&setup);
        mend(setup.opened.context);
        if (i == 4) { /* a code inside the grid */
            assert_int_equal(status, SVO_OK);
            continue;
        }
        assert_int_equal(status, SVO_INTERNAL);
        assert_words(&setup, by->function);
        assert_words(&setup, "made a fragment outside the grid or of no triangle");
    }
    close_setup(&setup);
}

static void nonsense_fragments_are_a_status(void **state)
{
    (void)state;
    expect_nonsense_noticed(&(method){SVO_BUILDER_CL, "svo_build: ", build, spoil_list_for_cl});
    expect_nonsense_noticed(&(method){SVO_BUILDER_SORTED, "svo_build: ", build, spoil_list_for_cl});
    expect_nonsense_noticed(&(method){SVO_BUILDER_CL, "svo_gl_build: ", build_in_gl, spoil_list_in_gl});
}

/* The same where a shader decides them. */
static void nonsense_undecided_fragments_are_a_status(void **state)
{
    (void)state;
    bad_setup setup;
    open_setup(SVO_GL_SHARE_COPY, &setup);
    memset(list, 0, sizeof list);
    assert_int_equal(build_in_gl(&setup), SVO_OK);
    for (int i = 0; i < 2; ++i) {
        for (size_t word = 1; word < sizeof list / sizeof list[0]; word += 2) {
            list[word] = i == 0 ? UINT32_MAX : TRIANGLES;
        }
        spoil(setup.opened.context);
        spoil_list_in_gl(&setup.opened.context->functions);
        launch_spoilt = LAUNCH_DECIDE;
        const svo_status status = build_in_gl(&setup);
        mend(setup.opened.context);
        assert_int_equal(status, SVO_GL_ERROR);
        assert_words(&setup, "of no triangle");
    }
    close_setup(&setup);
}

/* Counters that no scene can reach: a list of that size is impossible. */
static void nonsense_counters_are_a_status(void **state)
{
    (void)state;
    static const GLuint values[] = {0xffffffffu, 0x80000000u, 0x7fffffffu};
    bad_setup setup;
    open_setup(SVO_GL_SHARE_COPY, &setup);
    for (size_t i = 0; i < sizeof values / sizeof values[0]; ++i) {
        spoil(setup.opened.context);
        setup.opened.context->functions.GetBufferSubData = read_nonsense;
        counter_value = values[i];
        assert_int_not_equal(build(&setup), SVO_OK);
        mend(setup.opened.context);
        print_message("%08x: %s\n", values[i], svo_device_message(setup.opened.device));
    }
    close_setup(&setup);
}

static void nonsense_limits_are_a_status(void **state)
{
    (void)state;
    static const GLint values[] = {0, -1, 1, INT32_MIN};
    bad_setup setup;
    open_setup(SVO_GL_SHARE_COPY, &setup);
    svo_i_gl_functions *functions = &setup.opened.context->functions;
    for (size_t i = 0; i < sizeof values / sizeof values[0]; ++i) {
        fixture *opened = &setup.opened;
        svo_gl_destroy(&opened->gl);
        spoil(opened->context);
        functions->limits.storage_block_bytes = values[i];
        assert_int_equal(svo_gl_create(opened->device, opened->context, NULL, &opened->gl), SVO_UNSUPPORTED);
        assert_words(&setup, "storage block");
        functions->limits = honest.limits;
        functions->limits.vertex_storage_blocks = values[i];
        assert_int_equal(svo_gl_create(opened->device, opened->context, NULL, &opened->gl), SVO_UNSUPPORTED);
        functions->limits = honest.limits;
        assert_int_equal(svo_gl_create(opened->device, opened->context, NULL, &opened->gl), SVO_OK);
        functions->limits.framebuffer_width = values[i];
        assert_int_equal(build(&setup), SVO_UNSUPPORTED);
        functions->limits = honest.limits;
        functions->limits.storage_offset_alignment_bytes = values[i];
        assert_int_equal(build(&setup), SVO_OK);
        mend(opened->context);
    }
    close_setup(&setup);
}

/*
 * Compilers that fail.
 */

static GLuint APIENTRY make_no_shader(GLenum stage)
{
    (void)stage;
    return 0;
}

static GLuint APIENTRY make_no_program(void)
{
    return 0;
}

static void APIENTRY log_nothing(GLuint name, GLsizei bytes, GLsizei *length, GLchar *log)
{
    (void)name;
    if (length != NULL) {
        *length = 0;
    }
    if (bytes > 0) {
        *log = '\0';
    }
}

#define LONG_LOG 10000

static void APIENTRY refuse(GLuint shader, GLenum what, GLint *value)
{
    honest.GetShaderiv(shader, what, value);
    *value = what == GL_COMPILE_STATUS ? GL_FALSE : what == GL_INFO_LOG_LENGTH ? LONG_LOG + 1 : *value;
}

static void APIENTRY log_much(GLuint name, GLsizei bytes, GLsizei *length, GLchar *log)
{
    const size_t told = bytes > LONG_LOG ? LONG_LOG : (size_t)bytes - 1;
    (void)name;
    if (length != NULL) {
        *length = (GLsizei)told;
    }
    memset(log, 'x', told);
    log[told] = '\0';
}

static void keep_length(void *user, svo_log_level level, const char *text)
{
    (void)level;
    *(size_t *)user = strlen(text);
}

static void logs_of_compilers_are_whole(void **state)
{
    (void)state;
    bad_setup setup;
    open_setup(SVO_GL_SHARE_COPY, &setup);
    svo_i_gl_functions *functions = &setup.opened.context->functions;
    svo_device *device = setup.opened.device;
    const svo_log_callback log = device->log;
    void *log_user = device->log_user;
    size_t length = 0;
    device->log = keep_length;
    device->log_user = &length;
    spoil(setup.opened.context);
    functions->GetShaderiv = refuse;
    functions->GetShaderInfoLog = log_much;
    assert_int_equal(build(&setup), SVO_COMPILE_FAILED);
    assert_int_equal(length, LONG_LOG);
    mend(setup.opened.context);
    device->log = log;
    device->log_user = log_user;
    close_setup(&setup);
}

static void compilers_that_fail_are_a_status(void **state)
{
    (void)state;
    bad_setup setup;
    open_setup(SVO_GL_SHARE_COPY, &setup);
    svo_i_gl_functions *functions = &setup.opened.context->functions;
    spoil(setup.opened.context);
    functions->CreateShader = make_no_shader;
    functions->GetShaderInfoLog = log_nothing;
    assert_int_equal(build(&setup), SVO_COMPILE_FAILED);
    mend(setup.opened.context);
    functions->CreateProgram = make_no_program;
    functions->GetProgramInfoLog = log_nothing;
    assert_int_equal(build(&setup), SVO_COMPILE_FAILED);
    mend(setup.opened.context);
    close_setup(&setup);
}

/* Strings that are NULL and counts that are nonsense.
 */

static const GLubyte *APIENTRY say_nothing(GLenum name)
{
    (void)name;
    return NULL;
}

static const GLubyte *APIENTRY name_nothing(GLenum name, GLuint index)
{
    (void)name;
    (void)index;
    return NULL;
}

static void APIENTRY count_nonsense(GLenum name, GLint *value)
{
    honest.GetIntegerv(name, value);
    if (name == GL_NUM_EXTENSIONS) {
        *value = INT32_MAX;
    }
}

/* Wraps the context's own loader. */
typedef struct changed_loader {
    svo_gl_context *context;
    bool says_nothing;
} changed_loader;

static svo_i_function get_changed(void *user, const char *name)
{
    const changed_loader *loader = user;
    if (strcmp(name, "glGetString") == 0 && loader->says_nothing) {
        return (svo_i_function)say_nothing;
    }
    if (strcmp(name, "glGetStringi") == 0) {
        return (svo_i_function)name_nothing;
    }
    if (strcmp(name, "glGetIntegerv") == 0) {
        return (svo_i_function)count_nonsense;
    }
    svo_i_function function = loader->context->platform->get_proc_address(loader->context->native, name);
    return function;
}

static void strings_that_are_null_are_a_status(void **state)
{
    (void)state;
    svo_message message = {""};
    svo_i_gl_functions loaded;
    svo_gl_context *context = machine_any_context_or_skip();
    changed_loader loader = {context, true};
    assert_int_equal(svo_i_gl_context_make_current(context, NULL), SVO_OK);
    spoil(context);
    assert_int_equal(svo_i_gl_load(&loaded, get_changed, &loader, NULL, &message), SVO_NO_GL);
    loader.says_nothing = false;
    assert_int_equal(svo_i_gl_load(&loaded, get_changed, &loader, NULL, &message), SVO_OK);
    assert_false(svo_i_gl_has_extension(&loaded, "GL_ARB_buffer_storage"));
    svo_i_gl_unload(&loaded);
    svo_i_gl_context_release_current(context);
    svo_gl_context_destroy(&context);
}

TEST_GROUP(bad_driver)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lost_context_is_a_status_everywhere),
        cmocka_unit_test(out_of_memory_is_a_status_everywhere),
        cmocka_unit_test(reset_is_noticed),
        cmocka_unit_test(failure_while_starting_is_a_status),
        cmocka_unit_test(mapping_that_fails_is_a_status),
        cmocka_unit_test(nonsense_fragments_are_a_status),
        cmocka_unit_test(nonsense_undecided_fragments_are_a_status),
        cmocka_unit_test(nonsense_counters_are_a_status),
        cmocka_unit_test(nonsense_limits_are_a_status),
        cmocka_unit_test(compilers_that_fail_are_a_status),
        cmocka_unit_test(logs_of_compilers_are_whole),
        cmocka_unit_test(strings_that_are_null_are_a_status),
    };
    return cmocka_run_group_tests_name("bad_driver", tests, NULL, NULL);
}
