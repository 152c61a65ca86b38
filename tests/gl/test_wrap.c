/* SPDX-License-Identifier: MIT */
/*
 * An application's own OpenGL context: the tree does not depend on its state, the state stays unchanged, the context is
 * used only while it is current, and meshes are read from its buffers.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <pthread.h>

#include "core/device.h"
#include "support/fixture.h"
#include "support/gl_contexts.h"
#include "support/gl_interop_shim.h"
#include "support/info_of.h"
#include "support/machine.h"
#include "support/meshes.h"
#include "support/nondefault_state.h"
#include "support/own_context.h"
#include "support/suite.h"

enum { TRIANGLES = 150 };

static const svo_plan_options everything = {.need = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS, .edge = 1.0};
/* Points, small and large triangles; codes of 30 and 48 bits. */
static const struct {
    unsigned depth;
    size_t triangles;
} cases[] = {{2, 400}, {7, 100}, {11, 2}};

static svo_gl_context *wrap(void)
{
    svo_message message = {""};
    svo_gl_context *context = NULL;
    if (context_wrap(own_context_function, &context, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return context;
}

/* The same tree by a context that svocl created. */
static void expected_hash(const svo_mesh *mesh, unsigned depth, char hash[SVO_HASH_TEXT_BYTES])
{
    fixture opened;
    built finished;
    fixture_open(&(fixture_options){0}, &opened);
    fixture_build(&opened, mesh, depth, &everything, &finished);
    memcpy(hash, finished.hash, SVO_HASH_TEXT_BYTES);
    built_destroy(&finished);
    fixture_close(&opened);
}

static void open_wrapped(svo_gl_share share, fixture *out)
{
    *out = (fixture){0};
    cl_int error = CL_SUCCESS;
    out->device = machine_device_or_skip();
    out->queue =
        clCreateCommandQueue(info_of_device(out->device).context, info_of_device(out->device).device, 0, &error);
    assert_int_equal(error, CL_SUCCESS);
    out->context = wrap();
    const svo_gl_options options = {.struct_size = sizeof options, .share = share};
    if (svo_gl_create(out->device, out->context, &options, &out->gl) != SVO_OK) {
        fail_msg("%s", svo_device_message(out->device));
    }
    out->frontend = svo_gl_frontend(out->gl);
}

static void check_build(const fixture *opened, const nondefault_state *odd, unsigned depth, size_t triangle_count)
{
    owned_mesh made;
    char hash[SVO_HASH_TEXT_BYTES];
    built finished;
    random_mesh(3, triangle_count, 0.1, &made);
    expected_hash(&made.mesh, depth, hash);
    nondefault_state_assert(odd, "a build in a context of svocl's");
    fixture_build(opened, &made.mesh, depth, &everything, &finished);
    nondefault_state_assert(odd, "svo_build");
    assert_string_equal(finished.hash, hash);
    built_destroy(&finished);
    if (svo_gl_build_reason(opened->gl, everything.need)[0] == '\0') {
        fixture_build_in_gl(opened, &made.mesh, depth, &everything, &finished);
        nondefault_state_assert(odd, "svo_gl_build");
        assert_string_equal(finished.hash, hash);
        built_destroy(&finished);
    }
    owned_mesh_free(&made);
}

static void check_state_stays(bool compatibility, svo_gl_share share)
{
    own_context own;
    fixture opened;
    own_context_make_or_skip(compatibility, &own);
    nondefault_state *odd = nondefault_state_set(compatibility);
    open_wrapped(share, &opened);
    if (opened.device->is_cpu) { /* the self-test works in any state too */
        assert_string_equal(svo_gl_share_reason(opened.gl, SVO_GL_SHARE_HOST), "");
    }
    nondefault_state_assert(odd, "svo_gl_create");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        check_build(&opened, odd, cases[i].depth, cases[i].triangles);
    }
    fixture_close(&opened);
    nondefault_state_assert(odd, "the destruction of all handles");
    nondefault_state_destroy(&odd);
    own_context_destroy(&own);
}

static void state_of_a_core_context_stays_and_spoils_nothing(void **state)
{
    (void)state;
    check_state_stays(false, SVO_GL_SHARE_AUTO);
    check_state_stays(false, SVO_GL_SHARE_COPY);
}

static void state_of_a_compatibility_context_stays_and_spoils_nothing(void **state)
{
    (void)state;
    check_state_stays(true, SVO_GL_SHARE_AUTO);
}

static void info_says_that_it_is_wrapped(void **state)
{
    (void)state;
    own_context own;
    svo_gl_context_info info = SVO_GL_CONTEXT_INFO_INIT;
    own_context_make_or_skip(false, &own);
    svo_gl_context *context = wrap();
    svo_gl_context_get_info(context, &info);
    assert_int_equal(info.kind, SVO_GL_WRAPPED);
    assert_string_equal(svo_name(SVO_NAME_GL_CONTEXT_KIND, info.kind), "wrapped");
    assert_true(strlen(info.renderer) > 0);
    svo_gl_context_destroy(&context);
    assert_null(context);
    own_context_destroy(&own);
}

static svo_gl_function no_function(void *user, const char *name)
{
    (void)user;
    (void)name;
    return NULL;
}

static void wrapping_nothing_is_refused(void **state)
{
    (void)state;
    svo_message message = {""};
    svo_gl_context *context = NULL;
    own_context own;
    assert_int_equal(context_wrap(NULL, &context, &message), SVO_INVALID_ARGUMENT);
    own_context_make_or_skip(false, &own);
    assert_int_equal(context_wrap(own_context_function, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(context_wrap(no_function, &context, &message), SVO_NO_GL);
    assert_non_null(strstr(message.text, "svo_gl_context_create: the context has no function gl"));
    own_context_bind(&own, false);
    assert_int_equal(context_wrap(own_context_function, &context, &message), SVO_NO_GL);
    assert_non_null(strstr(message.text, "is it current on this thread?"));
    assert_null(context);
    own_context_destroy(&own);
}

static void *build_elsewhere(void *pointer)
{
    const fixture *opened = pointer;
    static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static svo_status status;
    const svo_mesh mesh = {.struct_size = sizeof mesh, .positions = corners, .vertex_count = 3, .triangle_count = 1};
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    status = svo_plan_create(opened->device, &mesh, 4, NULL, &plan);
    if (status == SVO_OK) {
        status = svo_build(plan, svo_gl_frontend(opened->gl), opened->queue, &tree, NULL);
    }
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    return &status;
}

static void context_must_be_current(void **state)
{
    (void)state;
    own_context own;
    fixture opened;
    pthread_t thread;
    void *result = NULL;
    own_context_make_or_skip(false, &own);
    open_wrapped(SVO_GL_SHARE_COPY, &opened);
    own_context_bind(&own, false);
    assert_int_equal(*(svo_status *)build_elsewhere(&opened), SVO_NO_GL);
    assert_non_null(strstr(svo_device_message(opened.device), "is not current on this thread"));
    own_context_bind(&own, true);
    assert_int_equal(*(svo_status *)build_elsewhere(&opened), SVO_OK);
    assert_int_equal(pthread_create(&thread, NULL, build_elsewhere, &opened), 0);
    assert_int_equal(pthread_join(thread, &result), 0);
    assert_int_equal(*(svo_status *)result, SVO_NO_GL);

    /* A context of svocl that is current is not mistaken for the application's. */
    svo_gl_context *other = machine_any_context_or_skip();
    own_context_bind(&own, false);
    assert_int_equal(svo_i_gl_context_make_current(other, NULL), SVO_OK);
    assert_int_equal(*(svo_status *)build_elsewhere(&opened), SVO_NO_GL);
    assert_true(other->platform->is_current(other->native));
    svo_i_gl_context_release_current(other);
    svo_gl_context_destroy(&other);

    own_context_bind(&own, true);
    fixture_close(&opened);
    own_context_destroy(&own);
}

static void wrapped_context_shares_with_opencl(void **state)
{
    (void)state;
    own_context own;
    owned_mesh made;
    fixture opened = {0};
    built finished;
    char hash[SVO_HASH_TEXT_BYTES];
    random_mesh(5, TRIANGLES, 0.0, &made);
    expected_hash(&made.mesh, 7, hash);
    own_context_make_or_skip(false, &own);
    nondefault_state *odd = nondefault_state_set(false);
    opened.context = wrap();
    shim_install(opened.context, &(shim_faults){0});
    assert_int_equal(svo_gl_device_create(opened.context, NULL, NULL, &opened.device, NULL), SVO_OK);
    opened.queue =
        clCreateCommandQueue(info_of_device(opened.device).context, info_of_device(opened.device).device, 0, NULL);
    const svo_gl_options options = {.struct_size = sizeof options, .share = SVO_GL_SHARE_INTEROP};
    if (svo_gl_create(opened.device, opened.context, &options, &opened.gl) != SVO_OK) {
        fail_msg("%s", svo_device_message(opened.device));
    }
    opened.frontend = svo_gl_frontend(opened.gl);
    fixture_build(&opened, &made.mesh, 7, &everything, &finished);
    assert_string_equal(finished.hash, hash);
    assert_string_equal(finished.report.share, "interop");
    built_destroy(&finished);
    shim_remove(opened.context);
    fixture_close(&opened);
    nondefault_state_assert(odd, "a build that shares");
    nondefault_state_destroy(&odd);
    own_context_destroy(&own);
    owned_mesh_free(&made);
}

TEST_GROUP(wrap)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(state_of_a_core_context_stays_and_spoils_nothing),
        cmocka_unit_test(state_of_a_compatibility_context_stays_and_spoils_nothing),
        cmocka_unit_test(info_says_that_it_is_wrapped),
        cmocka_unit_test(wrapping_nothing_is_refused),
        cmocka_unit_test(context_must_be_current),
        cmocka_unit_test(wrapped_context_shares_with_opencl),
    };
    return cmocka_run_group_tests_name("wrap", tests, NULL, NULL);
}
