/* SPDX-License-Identifier: MIT */
/*
 * The share path `interop` on a fake driver: the whole path gives the same tree, and each failing step is reported with
 * a reason of its own. `auto` then takes another path to the same tree, and forcing `interop` is an error.
 */
#define _POSIX_C_SOURCE 200809L
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
#include "support/machine.h"
#include "support/meshes.h"
#include "support/suite.h"

#include "share/interop.h" /* after svocl's headers, which choose OpenCL's version */

enum { DEPTH = 7, TRIANGLES = 300, REASON_BYTES = SVO_MESSAGE_BYTES };

static const svo_plan_options everything = {.need = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS};

/* An OpenGL context with the fake driver, a device created for it, and the expected tree. */
typedef struct shared_pair {
    fixture opened; /* gl is NULL at first */
    owned_mesh mesh;
    char hash[SVO_HASH_TEXT_BYTES];
} shared_pair;

static svo_gl_context *egl_context_or_skip(void)
{
    svo_gl_context *context = machine_context_or_null(SVO_GL_SURFACELESS);
    if (context == NULL) {
        context = machine_context_or_null(SVO_GL_EGL_DEVICE);
    }
    if (context == NULL) {
        skip();
    }
    return context;
}

static svo_status create_gl(fixture *opened, svo_gl_share share)
{
    svo_gl_destroy(&opened->gl);
    const svo_gl_options options = {.struct_size = sizeof options, .share = share};
    const svo_status status = svo_gl_create(opened->device, opened->context, &options, &opened->gl);
    opened->frontend = opened->gl != NULL ? svo_gl_frontend(opened->gl) : NULL;
    return status;
}

static void build_hash(const shared_pair *pair, const svo_plan_options *options, const char *share,
                       char hash[SVO_HASH_TEXT_BYTES])
{
    built finished;
    fixture_build(&pair->opened, &pair->mesh.mesh, DEPTH, options, &finished);
    assert_string_equal(finished.report.share, share);
    assert_string_equal(finished.report.renderer, pair->opened.context->functions.renderer);
    memcpy(hash, finished.hash, SVO_HASH_TEXT_BYTES);
    built_destroy(&finished);
}

/* Opens the device and a queue on the device's OpenCL context. */
static void take_device(fixture *opened, svo_device *device, cl_command_queue_properties properties)
{
    cl_int error = CL_SUCCESS;
    opened->device = device;
    opened->queue =
        clCreateCommandQueue(info_of_device(device).context, info_of_device(device).device, properties, &error);
    assert_int_equal(error, CL_SUCCESS);
}

static void open_pair(const shim_faults *faults, cl_command_queue_properties properties, shared_pair *out)
{
    *out = (shared_pair){0};
    svo_message message = {""};
    svo_device *device = NULL;
    out->opened.context = egl_context_or_skip();
    random_mesh(7, TRIANGLES, 0.0, &out->mesh);
    shim_install(out->opened.context, faults);
    if (svo_gl_device_create(out->opened.context, NULL, NULL, &device, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    take_device(&out->opened, device, properties);
    assert_int_equal(create_gl(&out->opened, SVO_GL_SHARE_COPY), SVO_OK);
    build_hash(out, &everything, "copy", out->hash);
}

/* Checks that no call violated the specification and that all objects are released. */
static void close_pair(shared_pair *pair)
{
    svo_gl_destroy(&pair->opened.gl);
    shim_end(pair->opened.context);
    fixture_close(&pair->opened);
    owned_mesh_free(&pair->mesh);
}

static void assert_same_hash(const shared_pair *pair, const svo_plan_options *options, const char *share)
{
    char hash[SVO_HASH_TEXT_BYTES];
    build_hash(pair, options, share, hash);
    assert_string_equal(hash, pair->hash);
}

static void check_whole_path(const char *extensions, cl_command_queue_properties properties)
{
    shared_pair pair;
    open_pair(&(shim_faults){.extensions = extensions}, properties, &pair);
    assert_int_equal(create_gl(&pair.opened, SVO_GL_SHARE_AUTO), SVO_OK);
    assert_string_equal(svo_gl_share_reason(pair.opened.gl, SVO_GL_SHARE_INTEROP), "");
    assert_int_equal(chosen_share(pair.opened.gl), SVO_GL_SHARE_INTEROP);
    assert_same_hash(&pair, &everything, "interop");
    svo_plan_options in_chunks = everything;
    in_chunks.chunk_bytes = 65536;
    assert_same_hash(&pair, &in_chunks, "interop");
    in_chunks.fragment_capacity = 1; /* reruns */
    assert_same_hash(&pair, &in_chunks, "interop");
    assert_int_equal(create_gl(&pair.opened, SVO_GL_SHARE_INTEROP), SVO_OK);
    assert_same_hash(&pair, &everything, "interop");
    close_pair(&pair);
}

static void shared_buffers_give_the_same_tree(void **state)
{
    (void)state;
    check_whole_path(NULL, 0);
    check_whole_path(NULL, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE | CL_QUEUE_PROFILING_ENABLE);
}

/* Kernels add to the list that OpenGL has drawn, in the same buffer. */
static void both_front_ends_fill_one_buffer(void **state)
{
    static const uint32_t columns[] = {1, 12, 64};
    (void)state;
    for (size_t i = 0; i < sizeof columns / sizeof columns[0]; ++i) {
        shared_pair pair;
        open_pair(&(shim_faults){0}, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, &pair);
        svo_gl_destroy(&pair.opened.gl);
        const svo_gl_options options = {.struct_size = sizeof options,
                                        .raster = SVO_GL_RASTER_HYBRID,
                                        .share = SVO_GL_SHARE_INTEROP,
                                        .hybrid_columns = columns[i]};
        assert_int_equal(svo_gl_create(pair.opened.device, pair.opened.context, &options, &pair.opened.gl), SVO_OK);
        pair.opened.frontend = svo_gl_frontend(pair.opened.gl);
        assert_same_hash(&pair, &everything, "interop");
        close_pair(&pair);
    }
}

static void without_gl_event_opengl_is_finished_first(void **state)
{
    (void)state;
    check_whole_path("cl_khr_gl_sharing", CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
}

/* A failing step and its reason. */
typedef struct failing_step {
    shim_faults faults;
    const char *reason; /* part of it */
    unsigned creations; /* the most shared buffers created: nothing unproven is called */
} failing_step;

static const failing_step failing_steps[] = {
    {{.extensions = "cl_khr_fp64"}, "does not list cl_khr_gl_sharing", 0},
    {{.extensions = ""}, "does not list cl_khr_gl_sharing", 0},
    {{.extensions = "cl_khr_gl_sharing_more xcl_khr_gl_sharing"}, "does not list cl_khr_gl_sharing", 0},
    {{.missing_function = "clGetGLContextInfoKHR"}, "has no function clGetGLContextInfoKHR", 0},
    {{.missing_function = "clCreateFromGLBuffer"}, "has no function clCreateFromGLBuffer", 0},
    {{.missing_function = "clEnqueueAcquireGLObjects"}, "has no function clEnqueueAcquireGLObjects", 0},
    {{.missing_function = "clEnqueueReleaseGLObjects"}, "has no function clEnqueueReleaseGLObjects", 0},
    {{.info_error = CL_INVALID_GL_SHAREGROUP_REFERENCE_KHR},
     "clGetGLContextInfoKHR failed with CL_INVALID_GL_SHAREGROUP_REFERENCE_KHR (-1000)",
     0},
    {{.lists_no_device = true}, "clGetGLContextInfoKHR does not list", 0},
    {{.context_error = CL_INVALID_PROPERTY}, "clCreateContext against the OpenGL context of", 0},
    {{.create_error = CL_INVALID_GL_OBJECT}, "clCreateFromGLBuffer failed with CL_INVALID_GL_OBJECT", 1},
    {{.acquire_error = CL_INVALID_OPERATION}, "clEnqueueAcquireGLObjects failed with CL_INVALID_OPERATION", 1},
    {{.acquire_error = CL_OUT_OF_RESOURCES, .spared_calls = 1}, "clEnqueueAcquireGLObjects failed with CL_OUT_OF", 1},
    {{.release_error = CL_OUT_OF_HOST_MEMORY}, "clEnqueueReleaseGLObjects failed with CL_OUT_OF_HOST_MEMORY", 1},
    {{.corrupts = true}, "the self-test failed: OpenCL reads 0x", 1},
    {{.acquires_nothing = true}, "the self-test failed: OpenCL reads 0x", 1},
};

static void check_step(const failing_step *step)
{
    shared_pair pair;
    shim_counts counts;
    char reason[REASON_BYTES];
    open_pair(&step->faults, 0, &pair);
    assert_int_equal(create_gl(&pair.opened, SVO_GL_SHARE_AUTO), SVO_OK);
    (void)snprintf(reason, sizeof reason, "%s", svo_gl_share_reason(pair.opened.gl, SVO_GL_SHARE_INTEROP));
    print_message("%s\n", reason);
    if (strstr(reason, step->reason) == NULL) {
        fail_msg("'%s' does not contain '%s'", reason, step->reason);
    }
    /* The answer for programs that ask the device before they start OpenGL is the same. */
    assert_int_equal(svo_i_interop_is_listed(pair.opened.device, pair.opened.context->opencl),
                     strstr(step->reason, "does not list cl_khr_gl_sharing") == NULL);
    const svo_gl_share chosen = chosen_share(pair.opened.gl);
    assert_true(chosen == SVO_GL_SHARE_HOST || chosen == SVO_GL_SHARE_COPY);
    assert_same_hash(&pair, &everything, svo_name(SVO_NAME_GL_SHARE, chosen));
    shim_get_counts(&counts);
    assert_true(counts.created <= 2 * step->creations); /* open_pair's and this function's probe */

    assert_int_equal(create_gl(&pair.opened, SVO_GL_SHARE_INTEROP), SVO_UNSUPPORTED);
    assert_null(pair.opened.gl);
    const char *message = svo_device_message(pair.opened.device);
    assert_non_null(strstr(message, "svo_gl_create: share interop does not work: "));
    assert_non_null(strstr(message, step->reason));
    close_pair(&pair);
}

static void each_failing_step_has_its_reason_and_the_same_tree(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof failing_steps / sizeof failing_steps[0]; ++i) {
        check_step(&failing_steps[i]);
    }
}

/* A call may fail after a successful probe: the build returns a status, and the next build works. */
static void failure_during_a_build_ends_in_a_status(void **state)
{
    (void)state;
    static const struct {
        shim_faults faults;
        svo_status status;
        const char *call;
    } cases[] = {
        {{.create_error = CL_MEM_OBJECT_ALLOCATION_FAILURE}, SVO_OUT_OF_DEVICE_MEMORY, "clCreateFromGLBuffer"},
        {{.acquire_error = CL_INVALID_GL_OBJECT}, SVO_CL_ERROR, "clEnqueueAcquireGLObjects"},
    };
    shared_pair pair;
    open_pair(&(shim_faults){0}, 0, &pair);
    assert_int_equal(create_gl(&pair.opened, SVO_GL_SHARE_INTEROP), SVO_OK);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        svo_plan *plan = NULL;
        svo_tree *tree = NULL;
        shim_set_faults(&cases[i].faults);
        assert_int_equal(svo_plan_create(pair.opened.device, &pair.mesh.mesh, DEPTH, NULL, &plan), SVO_OK);
        assert_int_equal(svo_build(plan, svo_gl_frontend(pair.opened.gl), pair.opened.queue, &tree, NULL),
                         cases[i].status);
        assert_non_null(strstr(svo_device_message(pair.opened.device), cases[i].call));
        svo_plan_destroy(&plan);
        shim_set_faults(&(shim_faults){0});
        assert_same_hash(&pair, &everything, "interop");
    }
    close_pair(&pair);
}

/* What the installed driver says, of any handle. */
static void sharing_is_possible_where_the_device_lists_it(void **state)
{
    (void)state;
    static char extensions[65536];
    svo_device *device = machine_device_or_skip();
    assert_int_equal(
        clGetDeviceInfo(info_of_device(device).device, CL_DEVICE_EXTENSIONS, sizeof extensions - 1, extensions, NULL),
        CL_SUCCESS);
    assert_int_equal(svo_gl_device_may_share(device) != 0, strstr(extensions, "cl_khr_gl_sharing") != NULL);
    svo_device_destroy(&device);
}

/* A device that is already chosen gets a second handle that can share. */
static void chosen_device_is_joined(void **state)
{
    (void)state;
    shared_pair pair;
    open_pair(&(shim_faults){0}, 0, &pair);
    svo_device *joined = NULL;
    const cl_device_id chosen = info_of_device(pair.opened.device).device;
    assert_int_equal(svo_gl_device_create(pair.opened.context, chosen, NULL, &joined, NULL), SVO_OK);
    assert_ptr_equal(info_of_device(joined).device, chosen);
    svo_gl *gl = NULL;
    const svo_gl_options forced = {.struct_size = sizeof forced, .share = SVO_GL_SHARE_INTEROP};
    assert_int_equal(svo_gl_create(joined, pair.opened.context, &forced, &gl), SVO_OK);
    svo_gl_destroy(&gl);
    svo_device_destroy(&joined);
    assert_int_equal(svo_gl_device_create(NULL, chosen, NULL, &joined, NULL), SVO_INVALID_ARGUMENT);
    assert_null(joined);
    close_pair(&pair);
}

/* An OpenCL context not created against the OpenGL context uses another path, and the reason says what would help. */
static void plain_opencl_context_is_told_apart(void **state)
{
    (void)state;
    shared_pair pair;
    open_pair(&(shim_faults){0}, 0, &pair);
    svo_gl_destroy(&pair.opened.gl);
    clReleaseCommandQueue(pair.opened.queue);
    svo_device_destroy(&pair.opened.device);
    take_device(&pair.opened, machine_device_or_skip(), 0);
    assert_int_equal(create_gl(&pair.opened, SVO_GL_SHARE_AUTO), SVO_OK);
    assert_non_null(strstr(svo_gl_share_reason(pair.opened.gl, SVO_GL_SHARE_INTEROP), "svo_gl_device_create"));
    const svo_gl_share chosen = chosen_share(pair.opened.gl);
    assert_true(chosen == SVO_GL_SHARE_HOST || chosen == SVO_GL_SHARE_COPY);
    assert_same_hash(&pair, &everything, svo_name(SVO_NAME_GL_SHARE, chosen));
    assert_int_equal(create_gl(&pair.opened, SVO_GL_SHARE_INTEROP), SVO_UNSUPPORTED);
    close_pair(&pair);
}

/* An OpenCL context that the application created against the OpenGL context and gives to svo_device_create. */
static void integrators_opencl_context_is_shared(void **state)
{
    (void)state;
    shared_pair pair;
    open_pair(&(shim_faults){0}, 0, &pair);
    const svo_gl_context *context = pair.opened.context;
    const svo_i_gl_handles handles = context->platform->handles(context->native);
    const cl_device_id device = info_of_device(pair.opened.device).device;
    const cl_context_properties properties[] = {CL_GL_CONTEXT_KHR, (cl_context_properties)handles.context,
                                                CL_EGL_DISPLAY_KHR, (cl_context_properties)handles.display, 0};
    cl_int error = CL_SUCCESS;
    assert_int_equal(svo_i_gl_context_make_current(pair.opened.context, NULL), SVO_OK);
    cl_context own = context->opencl->CreateContext(properties, 1, &device, NULL, NULL, &error);
    svo_i_gl_context_release_current(pair.opened.context);
    assert_int_equal(error, CL_SUCCESS);

    svo_gl_destroy(&pair.opened.gl);
    clReleaseCommandQueue(pair.opened.queue);
    svo_device_destroy(&pair.opened.device);
    svo_device *handle = NULL;
    assert_int_equal(svo_device_create(own, device, NULL, &handle, NULL), SVO_OK);
    clReleaseContext(own);
    take_device(&pair.opened, handle, 0);
    assert_int_equal(create_gl(&pair.opened, SVO_GL_SHARE_INTEROP), SVO_OK);
    assert_same_hash(&pair, &everything, "interop");
    close_pair(&pair);
}

/* OpenCL is told of a GLX context by the properties of GLX, and by none of EGL. */
static void contexts_of_glx_are_shared(void **state)
{
    (void)state;
    shared_pair pair;
    open_pair(&(shim_faults){.is_glx = true}, 0, &pair);
    assert_int_equal(create_gl(&pair.opened, SVO_GL_SHARE_INTEROP), SVO_OK);
    assert_same_hash(&pair, &everything, "interop");
    cl_context_properties properties[8] = {0};
    size_t bytes = 0;
    const svo_gl_context *context = pair.opened.context;
    assert_int_equal(context->opencl->GetContextInfo(info_of_device(pair.opened.device).context, CL_CONTEXT_PROPERTIES,
                                                     sizeof properties, properties, &bytes),
                     CL_SUCCESS);
    const svo_i_gl_handles handles = context->platform->handles(context->native);
    assert_int_equal(bytes, 7 * sizeof properties[0]);
    assert_int_equal(properties[0], CL_CONTEXT_PLATFORM);
    assert_int_equal(properties[2], CL_GL_CONTEXT_KHR);
    assert_true(properties[3] == (cl_context_properties)handles.context);
    assert_int_equal(properties[4], CL_GLX_DISPLAY_KHR);
    assert_true(properties[5] == (cl_context_properties)handles.display);
    close_pair(&pair);
}

static void osmesa_cannot_be_named_to_opencl(void **state)
{
    (void)state;
    svo_device *device = machine_device_or_skip();
    svo_gl_context *context = machine_context_or_null(SVO_GL_OSMESA);
    if (context == NULL) {
        svo_device_destroy(&device);
        skip();
    }
    shim_install(context, &(shim_faults){0});
    svo_gl *gl = NULL;
    assert_int_equal(svo_gl_create(device, context, NULL, &gl), SVO_OK);
    assert_non_null(strstr(svo_gl_share_reason(gl, SVO_GL_SHARE_INTEROP), "EGL and GLX"));
    svo_gl_destroy(&gl);
    shim_remove(context);
    svo_gl_context_destroy(&context);
    svo_device_destroy(&device);
}

TEST_GROUP(interop)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shared_buffers_give_the_same_tree),
        cmocka_unit_test(both_front_ends_fill_one_buffer),
        cmocka_unit_test(without_gl_event_opengl_is_finished_first),
        cmocka_unit_test(each_failing_step_has_its_reason_and_the_same_tree),
        cmocka_unit_test(failure_during_a_build_ends_in_a_status),
        cmocka_unit_test(sharing_is_possible_where_the_device_lists_it),
        cmocka_unit_test(chosen_device_is_joined),
        cmocka_unit_test(plain_opencl_context_is_told_apart),
        cmocka_unit_test(integrators_opencl_context_is_shared),
        cmocka_unit_test(contexts_of_glx_are_shared),
        cmocka_unit_test(osmesa_cannot_be_named_to_opencl),
    };
    return cmocka_run_group_tests_name("interop", tests, NULL, NULL);
}
