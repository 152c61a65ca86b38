/* SPDX-License-Identifier: MIT */
/* Scenarios of test_faults: OpenGL. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "core/message.h"
#include "faults_scenario.h"
#include "raster/raster.h"
#include "raster/selftest.h"
#include "support/gl_contexts.h"
#include "support/info_of.h"

#define GL_BUFFER_BYTES 64

/*
 * Scenarios: OpenGL.
 */

static svo_status run_context(subject *of)
{
    svo_gl_context *context = NULL;
    svo_device *device = NULL;
    svo_status status = context_of_kind(SVO_GL_SURFACELESS, 0, &context, &of->message);
    if (status == SVO_OK) {
        svo_gl_context_info info = SVO_GL_CONTEXT_INFO_INIT;
        svo_gl_context_get_info(context, &info);
        digest(of, info.renderer, strlen(info.renderer));
        status = svo_gl_device_create(context, info_of_device(world.device).device, NULL, &device, &of->message);
    }
    svo_device_destroy(&device);
    svo_gl_context_destroy(&context);
    return status;
}

/* Each EGL device is tried, and OSMesa, and what suits the device. */
static svo_status run_other_contexts(subject *of)
{
    svo_gl_context *context = NULL;
    svo_gl_context_info info = SVO_GL_CONTEXT_INFO_INIT;
    char name[5] = "";
    svo_gl_context_get_info(world.context, &info);
    (void)snprintf(name, sizeof name, "%.4s", info.renderer);
    SVO_I_TRY(context_of_name(name, &context, &of->message));
    svo_gl_context_destroy(&context);
    SVO_I_TRY(context_of_kind(SVO_GL_OSMESA, 0, &context, &of->message));
    svo_gl_context_destroy(&context);
    const svo_status status = context_for_device(world.device, &context, &of->message);
    svo_gl_context_destroy(&context);
    return status;
}

/* The self-test is for hardware; it finds nothing wrong with expanded triangles. */
static svo_status run_selftest(subject *of)
{
    svo_i_raster *raster = NULL;
    char reason[200] = "";
    TRY_TOLD(svo_i_raster_create(world.device, world.context, SVO_I_CONSERVATIVE_EXPAND, false, &raster));
    svo_i_raster_selftest(world.device, world.context, raster, reason, sizeof reason);
    svo_i_raster_destroy(&raster);
    return reason[0] == '\0' ? SVO_OK : svo_i_fail(&of->message, SVO_UNSUPPORTED, "svo_gl_create: %s", reason);
}

static svo_status run_gl(subject *of)
{
    svo_gl *gl = NULL;
    const svo_status status = svo_gl_create(world.device, world.context, NULL, &gl);
    svo_gl_destroy(&gl);
    return told(of, world.device, status);
}

static svo_status run_gl_build_host(subject *of)
{
    return build_and_digest(of, svo_gl_frontend(world.host));
}

static svo_status run_gl_build_copy(subject *of)
{
    return build_and_digest(of, svo_gl_frontend(world.copy));
}

static void prepare_wrapped(subject *of)
{
    prepare_plan(of);
    own_context_bind(&world.own, true);
    of->state = nondefault_state_set(false);
}

static void cleanup_wrapped(subject *of)
{
    destroy_all(of);
    nondefault_state_destroy(&of->state);
    own_context_bind(&world.own, false);
}

static svo_gl_function find_function(void *user, const char *name)
{
    const svo_gl_function real = own_context_function(user, name);
    void *found = NULL;
    memcpy(&found, &real, sizeof found);
    found = faults_hook(name, found);
    svo_gl_function hooked = NULL;
    memcpy(&hooked, &found, sizeof hooked);
    return hooked;
}

/* A query that failed must not change the caller's state. What sets state cannot restore it where it fails. */
static void check_state(const subject *of)
{
    const char *name = faults_failed().name;
    if (name != NULL && (strncmp(name, "glGet", 5) == 0 || strncmp(name, "glIs", 4) == 0)) {
        faults_spare(true);
        nondefault_state_assert(of->state, name);
        faults_spare(false);
    }
}

/* In the caller's context: its state is saved and restored. */
static svo_status run_wrapped(subject *of)
{
    svo_gl *gl = NULL;
    svo_gl_context *context = NULL;
    const svo_gl_options options = {.struct_size = sizeof options, .share = SVO_GL_SHARE_COPY};
    svo_status status = context_wrap(find_function, &context, &of->message);
    if (status == SVO_OK) {
        status = told(of, world.device, svo_gl_create(world.device, context, &options, &gl));
    }
    if (status == SVO_OK) {
        status = build_and_digest(of, svo_gl_frontend(gl));
    }
    svo_gl_destroy(&gl);
    svo_gl_context_destroy(&context);
    check_state(of);
    return status;
}

static svo_status run_gl_mesh_read(subject *of)
{
    svo_mesh_copy *copy = NULL;
    const svo_mesh_buffers buffers = {.struct_size = sizeof buffers,
                                      .vertex_count = RAYS,
                                      .triangle_count = RAYS / 3,
                                      .positions = {.gl_buffer = world.gl_buffer},
                                      .indices = {.gl_buffer = world.gl_buffer}};
    const svo_status status = svo_gl_mesh_read(&buffers, world.context, 0, NULL, &copy, &of->message);
    if (status == SVO_OK) {
        const svo_mesh *read = svo_mesh_copy_get(copy);
        digest(of, read->positions, read->vertex_count * 12);
        digest(of, read->indices, read->triangle_count * 12);
    }
    svo_mesh_copy_destroy(&copy);
    return status;
}

/* Gives the buffer to OpenCL, writes it, and gives it to OpenGL. */
static svo_status pass_bytes(subject *of, svo_gl_buffer *buffer, int content)
{
    uint8_t bytes[GL_BUFFER_BYTES];
    svo_gl_buffer_info info = SVO_GL_BUFFER_INFO_INIT;
    memset(bytes, content, sizeof bytes);
    TRY_TOLD(svo_gl_buffer_get_info(buffer, &info));
    TRY_TOLD(svo_gl_buffer_to_cl(buffer, world.queue));
    faults_spare(true);
    assert_int_equal(clEnqueueWriteBuffer(world.queue, info.memory, CL_TRUE, 0, sizeof bytes, bytes, 0, NULL, NULL),
                     CL_SUCCESS);
    faults_spare(false);
    digest(of, &info.bytes, sizeof info.bytes);
    return told(of, world.device, svo_gl_buffer_to_gl(buffer, sizeof bytes, world.queue, 0, NULL));
}

/* To OpenGL, back, and there again. */
static svo_status use_gl_buffer(subject *of, svo_gl_share share)
{
    svo_gl_buffer *buffer = NULL;
    svo_status status = SVO_OK;
    TRY_TOLD(svo_gl_buffer_create(world.device, world.context, GL_BUFFER_BYTES, share, &buffer));
    SVO_I_TRY_CLEANUP(pass_bytes(of, buffer, 1));
    SVO_I_TRY_CLEANUP(pass_bytes(of, buffer, 2));

cleanup:
    svo_gl_buffer_destroy(&buffer);
    return status;
}

static svo_status run_gl_buffer(subject *of)
{
    SVO_I_TRY(use_gl_buffer(of, SVO_GL_SHARE_AUTO));
    return use_gl_buffer(of, SVO_GL_SHARE_COPY);
}

/* A plan of one triangle that OpenGL moves. */
static void prepare_gl_update(subject *of)
{
    static const float corners[9] = {0.1F, 0.1F, 0.1F, 0.9F, 0.1F, 0.1F, 0.1F, 0.9F, 0.1F};
    const svo_mesh mesh = {.struct_size = sizeof mesh, .positions = corners, .vertex_count = 3, .triangle_count = 1};
    const svo_plan_options options = {.struct_size = sizeof options, .edge = 1.0, .updatable = 1};
    if (svo_plan_create(world.device, &mesh, 4, &options, &of->plan) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
}

static svo_status update_from(subject *of, svo_gl_share share)
{
    svo_gl_buffer *buffer = NULL;
    svo_status status = SVO_OK;
    TRY_TOLD(svo_gl_buffer_create(world.device, world.context, GL_BUFFER_BYTES, share, &buffer));
    SVO_I_TRY_CLEANUP(pass_bytes(of, buffer, 1)); /* numbers beside 0 */
    SVO_I_TRY_CLEANUP(
        told(of, world.device, svo_gl_plan_update(of->plan, buffer, NULL, &(svo_submit){.queue = world.queue})));
    SVO_I_TRY_CLEANUP(build_and_digest(of, world.cl));

cleanup:
    svo_gl_buffer_destroy(&buffer);
    return status;
}

static svo_status run_gl_update(subject *of)
{
    SVO_I_TRY(update_from(of, SVO_GL_SHARE_AUTO));
    return update_from(of, SVO_GL_SHARE_COPY);
}

static svo_status build_in_gl(subject *of, svo_gl *gl)
{
    svo_tree *tree = NULL;
    svo_status status = svo_gl_build(gl, of->plan, world.queue, &tree, NULL);
    if (status == SVO_OK) {
        status = digest_tree(of, tree);
    }
    svo_tree_destroy(&tree);
    return told(of, world.device, status);
}

static svo_status run_gl_builder(subject *of)
{
    return build_in_gl(of, world.copy);
}

static void open_new_handle(subject *of)
{
    const svo_gl_options options = {.struct_size = sizeof options, .share = SVO_GL_SHARE_COPY};
    if (svo_gl_create(world.device, world.context, &options, &of->gl) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
}

/* With a new handle: shaders are compiled. */
static void prepare_gl(subject *of)
{
    prepare_plan(of);
    open_new_handle(of);
}

static svo_status run_gl_first_build(subject *of)
{
    return build_and_digest(of, svo_gl_frontend(of->gl));
}

static svo_status run_gl_first_builder(subject *of)
{
    return build_in_gl(of, of->gl);
}

static void prepare_gl_light(subject *of)
{
    prepare_tree(of);
    open_new_handle(of);
}

static svo_status run_gl_light(subject *of)
{
    const svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0.3F, -1, 0.2F}, .value = {1, 2, 3}};
    const svo_light_setup setup = {
        .struct_size = sizeof setup, .sources = &sun, .source_count = 1, .view_resolution = 16};
    char hash[SVO_HASH_TEXT_BYTES];
    svo_light *light = NULL;
    TRY_TOLD(svo_light_create(of->tree, NULL, world.queue, &light));
    svo_status status = svo_gl_light_set_sources(of->gl, light, &setup, world.queue);
    if (status == SVO_OK) {
        status = svo_light_hash(light, world.queue, hash);
    }
    svo_light_destroy(&light);
    TRY_TOLD(status);
    digest(of, hash, sizeof hash);
    return SVO_OK;
}

static const scenario rows[] = {
    {"gl_context", true, false, prepare_nothing, run_context, NULL, destroy_all},
    {"gl_contexts", true, false, prepare_nothing, run_other_contexts, NULL, destroy_all},
    {"gl_selftest", true, false, prepare_nothing, run_selftest, NULL, destroy_all},
    {"gl_wrapped", true, false, prepare_wrapped, run_wrapped, NULL, cleanup_wrapped},
    {"gl_mesh_read", true, false, prepare_nothing, run_gl_mesh_read, NULL, destroy_all},
    {"gl_buffer", true, false, prepare_nothing, run_gl_buffer, NULL, destroy_all},
    {"gl_update", true, false, prepare_gl_update, run_gl_update, NULL, destroy_all},
    {"gl_create", true, false, prepare_nothing, run_gl, NULL, destroy_all},
    {"gl_build_host", true, false, prepare_plan, run_gl_build_host, NULL, destroy_all},
    {"gl_build_copy", true, false, prepare_plan, run_gl_build_copy, NULL, destroy_all},
    {"gl_builder", true, false, prepare_plan, run_gl_builder, NULL, destroy_all},
    {"gl_first_build", true, false, prepare_gl, run_gl_first_build, NULL, destroy_all},
    {"gl_first_builder", true, false, prepare_gl, run_gl_first_builder, NULL, destroy_all},
    {"gl_light", true, false, prepare_gl_light, run_gl_light, NULL, destroy_all},
};
const scenario_list opengl_scenarios = {rows, sizeof rows / sizeof rows[0]};
