/* SPDX-License-Identifier: MIT */
/*
 * Callers compiled against other headers: an older caller's structs are shorter, a newer caller's longer. The bytes
 * after each struct must not change.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#ifdef HAVE_GL
#include "svocl/gl.h"
#endif
#ifdef HAVE_IO
#include "svocl/io.h"
#endif
#include "support/gl_contexts.h"
#include "support/info_of.h"
#include "support/suite.h"
#include "svocl/svocl.h"

#define CANARY       0xa5
#define CANARY_BYTES 64
#define STRUCT_BYTES 4096 /* enough for the largest struct and a newer caller's additions */

static svo_device *device;
static svo_plan *plan;
static svo_tree *tree;
static cl_command_queue queue;
static svo_frontend *frontend;

static const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

/* A struct of the size that its caller declares, with canaries after it. */
typedef struct foreign {
    union {
        size_t struct_size;
        unsigned char bytes[STRUCT_BYTES + CANARY_BYTES];
    } memory;
    size_t bytes;
} foreign;

static foreign foreign_output(size_t bytes)
{
    foreign made = {.bytes = bytes};
    memset(&made.memory, CANARY, sizeof made.memory);
    made.memory.struct_size = bytes;
    return made;
}

static foreign foreign_input(const void *ours, size_t our_bytes, size_t bytes)
{
    foreign made = foreign_output(bytes);
    memset(made.memory.bytes, 0, bytes);
    memcpy(made.memory.bytes, ours, our_bytes < bytes ? our_bytes : bytes);
    made.memory.struct_size = bytes;
    return made;
}

static void assert_canaries(const foreign *checked, size_t from)
{
    for (size_t i = from; i < sizeof checked->memory; ++i) {
        assert_int_equal(checked->memory.bytes[i], CANARY);
    }
}

/* ---- outputs ---- */

typedef svo_status (*get_output)(void *to);

static svo_status get_device_info(void *to)
{
    return svo_device_get_info(device, to);
}

static svo_status get_plan_info(void *to)
{
    return svo_plan_get_info(plan, to);
}

static svo_status get_buffer_info(void *to)
{
    return svo_plan_get_buffer(plan, 0, to);
}

static svo_status get_kernels_info(void *to)
{
    return svo_plan_get_kernels(plan, 0, to);
}

static svo_status get_left_out(void *to)
{
    return svo_plan_get_left_out(plan, 0, to);
}

static svo_status get_tree_info(void *to)
{
    return svo_tree_get_info(tree, to);
}

static svo_status get_tree_arrays(void *to)
{
    return svo_tree_get_arrays(tree, to);
}

static svo_status get_workspace_info(void *to)
{
    return svo_workspace_measure(plan, frontend, to);
}

static svo_status get_report(void *to)
{
    svo_tree *built = NULL;
    const svo_status status = svo_build(plan, NULL, NULL, &built, to);
    svo_tree_destroy(&built);
    return status;
}

#ifdef HAVE_GL
static svo_status get_context_info(void *to)
{
    svo_gl_context *context = NULL;
    assert_int_equal(context_of_kind(SVO_GL_SURFACELESS, 0, &context, NULL), SVO_OK);
    const svo_status status = svo_gl_context_get_info(context, to);
    svo_gl_context_destroy(&context);
    return status;
}
#endif

typedef struct output_case {
    get_output get;
    size_t bytes; /* current size */
    size_t older_bytes; /* up to a field in the middle */
    size_t compared_bytes; /* equal in repeated calls */
} output_case;

#define END_OF(type, field) (offsetof(type, field) + sizeof(((type *)NULL)->field))
#define OUTPUT(type, get, last, bytes)               \
    {                                                \
        get, sizeof(type), END_OF(type, last), bytes \
    }
#define STEADY(type, get, last) OUTPUT(type, get, last, sizeof(type))

static const output_case outputs[] = {
    STEADY(svo_device_info, get_device_info, compile_ms),
    STEADY(svo_plan_info, get_plan_info, edge),
    STEADY(svo_buffer_info, get_buffer_info, count),
    STEADY(svo_kernels_info, get_kernels_info, name),
    STEADY(svo_left_out, get_left_out, what),
    STEADY(svo_tree_info, get_tree_info, level_begin),
    STEADY(svo_tree_arrays, get_tree_arrays, normals),
    STEADY(svo_workspace_info, get_workspace_info, tree_bytes),
    OUTPUT(svo_build_report, get_report, renderer, offsetof(svo_build_report, stage_times)),
#ifdef HAVE_GL
    OUTPUT(svo_gl_context_info, get_context_info, device_index, offsetof(svo_gl_context_info, vendor)),
#endif
};
#define OUTPUTS (sizeof outputs / sizeof outputs[0])

/* svo_buffer_info and others end with padding, which is not compared. */
static void assert_same(const foreign *actual, const foreign *expected, size_t bytes)
{
    const size_t head = sizeof(size_t);
    assert_memory_equal(actual->memory.bytes + head, expected->memory.bytes + head, bytes - head);
}

static void outputs_fill_only_the_fields_the_caller_knows(void **state)
{
    (void)state;
    for (size_t i = 0; i < OUTPUTS; ++i) {
        const output_case *c = &outputs[i];
        foreign today = foreign_output(c->bytes);
        foreign older = foreign_output(c->older_bytes);
        foreign newer = foreign_output(c->bytes + 40);
        assert_true(c->older_bytes <= c->bytes && newer.bytes <= STRUCT_BYTES);
        assert_int_equal(c->get(&today.memory), SVO_OK);
        assert_int_equal(c->get(&older.memory), SVO_OK);
        assert_int_equal(c->get(&newer.memory), SVO_OK);
        assert_int_equal(older.memory.struct_size, c->older_bytes);
        assert_int_equal(newer.memory.struct_size, c->bytes + 40);
        assert_same(&older, &today, c->compared_bytes < c->older_bytes ? c->compared_bytes : c->older_bytes);
        assert_same(&newer, &today, c->compared_bytes);
        for (size_t at = c->bytes; at < newer.bytes; ++at) {
            assert_int_equal(newer.memory.bytes[at], 0);
        }
        assert_canaries(&today, today.bytes);
        assert_canaries(&older, older.bytes);
        assert_canaries(&newer, newer.bytes);
    }
}

static void outputs_without_a_size_are_refused(void **state)
{
    (void)state;
    for (size_t i = 0; i < OUTPUTS; ++i) {
        foreign unset = foreign_output(0);
        assert_int_equal(outputs[i].get(&unset.memory), SVO_INVALID_ARGUMENT);
        assert_canaries(&unset, sizeof(size_t));
    }
    assert_int_equal(svo_device_get_info(device, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_plan_get_info(plan, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_get_info(tree, NULL), SVO_INVALID_ARGUMENT);
}

/* ---- inputs ---- */

typedef svo_status (*use_input)(const void *from, svo_message *message);

/* Functions with a handle store the message there. */
static svo_status with_message(svo_status status, svo_message *message)
{
    (void)snprintf(message->text, sizeof message->text, "%s", svo_device_message(device));
    return status;
}

static svo_status use_device_options(const void *from, svo_message *message)
{
    svo_device *made = NULL;
    const svo_status status =
        svo_device_create(info_of_device(device).context, info_of_device(device).device, from, &made, message);
    svo_device_destroy(&made);
    return status;
}

static const svo_mesh triangle = {
    .struct_size = sizeof triangle, .positions = corners, .vertex_count = 3, .triangle_count = 1};

static svo_status use_mesh(const void *from, svo_message *message)
{
    svo_plan *made = NULL;
    const svo_status status = svo_plan_create(device, from, 4, NULL, &made);
    svo_plan_destroy(&made);
    return with_message(status, message);
}

static svo_status use_plan_options(const void *from, svo_message *message)
{
    svo_plan *made = NULL;
    const svo_status status = svo_plan_create(device, &triangle, 4, from, &made);
    svo_plan_destroy(&made);
    return with_message(status, message);
}

static svo_status use_workspace_options(const void *from, svo_message *message)
{
    svo_workspace *made = NULL;
    const svo_status status = svo_workspace_create(plan, frontend, queue, from, &made);
    svo_workspace_destroy(&made);
    return with_message(status, message);
}

static svo_status use_render_options(const void *from, svo_message *message)
{
    uint8_t rgba[4];
    return with_message(svo_render(svo_tree_target(tree), from, svo_in_host(rgba), &(svo_submit){.queue = queue}),
                        message);
}

static svo_status use_mesh_buffers(const void *from, svo_message *message)
{
    svo_mesh_copy *made = NULL;
    const svo_status status = svo_mesh_read(from, queue, 0, NULL, &made, message);
    svo_mesh_copy_destroy(&made);
    return status;
}

#ifdef HAVE_GL
static svo_status use_context_options(const void *from, svo_message *message)
{
    svo_gl_context *made = NULL;
    const svo_status status = svo_gl_context_create(from, &made, message);
    svo_gl_context_destroy(&made);
    return status;
}

static svo_status use_gl_options(const void *from, svo_message *message)
{
    svo_gl_context *context = NULL;
    svo_gl *made = NULL;
    assert_int_equal(context_of_kind(SVO_GL_SURFACELESS, 0, &context, NULL), SVO_OK);
    const svo_status status = svo_gl_create(device, context, from, &made);
    svo_gl_destroy(&made);
    svo_gl_context_destroy(&context);
    return with_message(status, message);
}
#endif

#ifdef HAVE_IO
static svo_status use_save_options(const void *from, svo_message *message)
{
    const svo_status status = svo_tree_save(tree, svo_to_path("older_caller.svo"), from, message);
    (void)remove("older_caller.svo");
    return status;
}

/* The file does not exist; this error comes after the size was accepted. */
static svo_status use_load_options(const void *from, svo_message *message)
{
    svo_tree *made = NULL;
    const svo_status status = svo_tree_load(svo_from_path("/nonexistent/tree.svo"), from, &made, message);
    return status == SVO_FILE_ERROR ? SVO_OK : status;
}

/* As above. */
static svo_status use_import_options(const void *from, svo_message *message)
{
    svo_import *made = NULL;
    const svo_status status = svo_import_file("/nonexistent/mesh.obj", from, NULL, NULL, &made, message);
    return status == SVO_FILE_ERROR ? SVO_OK : status;
}
#endif

static const svo_render_options picture = {.struct_size = sizeof picture,
                                           .width = 1,
                                           .height = 1,
                                           .camera = {.eye = {0, 0, 5}, .up = {0, 1, 0}, .vertical_fov = 1}};
static const svo_device_options device_options = SVO_DEVICE_OPTIONS_INIT;
static const svo_plan_options plan_options = SVO_PLAN_OPTIONS_INIT;
static const svo_workspace_options workspace_options = SVO_WORKSPACE_OPTIONS_INIT;
static const svo_mesh_buffers mesh_buffers = SVO_MESH_BUFFERS_INIT;
#ifdef HAVE_GL
static const svo_gl_options gl_options = SVO_GL_OPTIONS_INIT;
static const svo_gl_context_options context_options = SVO_GL_CONTEXT_OPTIONS_INIT;
#endif
#ifdef HAVE_IO
static const svo_save_options save_options = SVO_SAVE_OPTIONS_INIT;
static const svo_import_options import_options = SVO_IMPORT_OPTIONS_INIT;
static const svo_load_options load_options = SVO_LOAD_OPTIONS_INIT;
#endif

typedef struct input_case {
    const char *argument;
    use_input use;
    const void *ours;
    size_t bytes; /* current size */
    size_t older_bytes; /* of the first release, as a literal, since its callers pass this value */
    svo_status expected;
} input_case;

static const input_case inputs[] = {
    {"options", use_device_options, &device_options, sizeof device_options, 24, SVO_OK},
    {"mesh", use_mesh, &triangle, sizeof triangle, 48, SVO_OK},
    {"options", use_plan_options, &plan_options, sizeof plan_options, 16, SVO_OK},
    {"options", use_workspace_options, &workspace_options, sizeof workspace_options, 16, SVO_OK},
    {"options", use_render_options, &picture, sizeof picture, 56, SVO_OK},
    {"buffers", use_mesh_buffers, &mesh_buffers, sizeof mesh_buffers, 88, SVO_OK},
#ifdef HAVE_GL
    {"options", use_gl_options, &gl_options, sizeof gl_options, 16, SVO_OK},
    {"options", use_context_options, &context_options, sizeof context_options, 16, SVO_OK},
#endif
#ifdef HAVE_IO
    {"options", use_save_options, &save_options, sizeof save_options, 8, SVO_OK},
    {"options", use_import_options, &import_options, sizeof import_options, 24, SVO_OK},
    {"options", use_load_options, &load_options, sizeof load_options, 16, SVO_OK},
#endif
};
#define INPUTS (sizeof inputs / sizeof inputs[0])

static void assert_size_refused(const input_case *c, size_t bytes)
{
    const foreign given = foreign_input(c->ours, c->bytes, bytes);
    svo_message message = {""};
    assert_int_equal(c->use(&given.memory, &message), SVO_INVALID_ARGUMENT);
    char words[80];
    (void)snprintf(words, sizeof words, "%s.struct_size is %zu, not in %zu .. %zu", c->argument, bytes, c->older_bytes,
                   c->bytes);
    if (strstr(message.text, words) == NULL) {
        fail_msg("'%s' lacks '%s'", message.text, words);
    }
}

static void older_inputs_are_accepted_and_newer_ones_refused(void **state)
{
    (void)state;
    for (size_t i = 0; i < INPUTS; ++i) {
        const input_case *c = &inputs[i];
        const size_t accepted[] = {c->older_bytes, c->bytes};
        for (int k = 0; k < 2; ++k) {
            const foreign given = foreign_input(c->ours, c->bytes, accepted[k]);
            svo_message message = {""};
            if (c->use(&given.memory, &message) != c->expected) {
                fail_msg("case %zu, %zu bytes: %s", i, accepted[k], message.text);
            }
        }
        assert_size_refused(c, c->bytes + 8);
        assert_size_refused(c, c->older_bytes - 8);
    }
}

/* ---- stages ---- */

static void stages_are_read_by_index(void **state)
{
    (void)state;
    svo_build_report report = SVO_BUILD_REPORT_INIT;
    svo_tree *built = NULL;
    assert_int_equal(svo_build(plan, NULL, NULL, &built, &report), SVO_OK);
    assert_int_equal(svo_build_report_stage(&report, 0, NULL), SVO_STAGE_COUNT);
    svo_stage_time time = {.ms = -1, .clock = ""};
    svo_build_report_stage(&report, SVO_STAGE_GRID, &time);
    assert_string_equal(time.clock, "wall");
    svo_build_report_stage(&report, SVO_STAGE_COUNT, &time);
    assert_null(time.clock);
    report.struct_size = offsetof(svo_build_report, stage_times); /* a caller without stage times */
    time.clock = "";
    svo_build_report_stage(&report, SVO_STAGE_GRID, &time);
    assert_null(time.clock);
    svo_tree_destroy(&built);
}

static int set_up(void **state)
{
    (void)state;
    svo_message message = {""};
    if (svo_device_create_default(NULL, &device, &message) != SVO_OK) {
        print_error("%s\n", message.text);
        return -1;
    }
    queue = clCreateCommandQueue(info_of_device(device).context, info_of_device(device).device, 0, NULL);
    return svo_frontend_create_cl(device, &frontend) == SVO_OK &&
                   svo_plan_create(device, &triangle, 4, NULL, &plan) == SVO_OK &&
                   svo_build(plan, NULL, NULL, &tree, NULL) == SVO_OK && svo_tree_download(tree, NULL) == SVO_OK
               ? 0
               : -1;
}

static int tear_down(void **state)
{
    (void)state;
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    svo_frontend_destroy(&frontend);
    clReleaseCommandQueue(queue);
    svo_device_destroy(&device);
    return 0;
}

TEST_GROUP(older_caller)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(outputs_fill_only_the_fields_the_caller_knows),
        cmocka_unit_test(outputs_without_a_size_are_refused),
        cmocka_unit_test(older_inputs_are_accepted_and_newer_ones_refused),
        cmocka_unit_test(stages_are_read_by_index),
    };
    return cmocka_run_group_tests_name("older_caller", tests, set_up, tear_down);
}
