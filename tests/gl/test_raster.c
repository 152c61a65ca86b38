/* SPDX-License-Identifier: MIT */
/*
 * The choices of the raster front end: which hardware method a context has, whether the self-test detects a driver that
 * breaks its promise, whether forced choices are kept or rejected with a reason, and whether both kinds of integers in
 * the shaders give the same tree.
 *
 * No software rasterizer has the hardware extensions. A context with a modified function table plays a driver that
 * lists an extension, accepts all its calls, and rasterizes as before.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "raster/raster.h"
#include "raster/selftest.h"
#include "support/compare_tree.h"
#include "support/fixture.h"
#include "support/gl_contexts.h"
#include "support/machine.h"
#include "support/meshes.h"
#include "support/suite.h"

#define NV          "GL_NV_conservative_raster"
#define NV_PRE_SNAP "GL_NV_conservative_raster_pre_snap_triangles"
#define INTEL       "GL_INTEL_conservative_rasterization"

enum { REASON_BYTES = SVO_MESSAGE_BYTES };

static void APIENTRY ignore_parameter(GLenum name, GLint value)
{
    (void)name;
    (void)value;
}

static void hardware_method_follows_from_extensions(void **state)
{
    (void)state;
    static const struct {
        const char *extensions;
        bool has_function;
        svo_i_conservative method;
        const char *reason; /* part of it */
    } cases[] = {
        {"", false, SVO_I_CONSERVATIVE_EXPAND, "neither " NV " nor " INTEL},
        {"GL_ARB_one GL_ARB_two ", true, SVO_I_CONSERVATIVE_EXPAND, "neither"},
        {NV " " NV_PRE_SNAP " ", true, SVO_I_CONSERVATIVE_NV, ""},
        {"GL_ARB_one " NV_PRE_SNAP " GL_ARB_two " NV, true, SVO_I_CONSERVATIVE_NV, ""},
        {NV " " NV_PRE_SNAP " ", false, SVO_I_CONSERVATIVE_EXPAND, "without"},
        {NV " ", true, SVO_I_CONSERVATIVE_EXPAND, "without " NV_PRE_SNAP},
        {NV_PRE_SNAP " ", true, SVO_I_CONSERVATIVE_EXPAND, "neither"},
        {NV "_dilate X" NV " " NV_PRE_SNAP " ", true, SVO_I_CONSERVATIVE_EXPAND, "neither"},
        {INTEL " ", false, SVO_I_CONSERVATIVE_INTEL, ""},
        {INTEL "_more X" INTEL " ", false, SVO_I_CONSERVATIVE_EXPAND, "neither"},
        {NV " " NV_PRE_SNAP "_more " INTEL " ", true, SVO_I_CONSERVATIVE_INTEL, ""},
        {INTEL " " NV " " NV_PRE_SNAP " ", true, SVO_I_CONSERVATIVE_NV, ""},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char extensions[REASON_BYTES];
        (void)snprintf(extensions, sizeof extensions, "%s", cases[i].extensions);
        const svo_i_gl_functions gl = {.extensions = extensions,
                                       .ConservativeRasterParameteriNV =
                                           cases[i].has_function ? ignore_parameter : NULL};
        const char *reason = NULL;
        const svo_i_conservative method = svo_i_raster_hardware(&gl, &reason);
        if (method != cases[i].method || (cases[i].reason[0] == '\0') != (reason[0] == '\0') ||
            strstr(reason, cases[i].reason) == NULL) {
            fail_msg("'%s': method %d, reason '%s', not %d, '%s'", extensions, (int)method, reason,
                     (int)cases[i].method, cases[i].reason);
        }
    }
}

/* The self-test's reason for a method of rasterization. */
static void selftest_reason(svo_device *device, svo_gl_context *context, svo_i_conservative method, bool no_int64,
                            char reason[REASON_BYTES])
{
    svo_i_raster *raster = NULL;
    if (svo_i_raster_create(device, context, method, no_int64, &raster) != SVO_OK) {
        fail_msg("%s", svo_device_message(device));
    }
    svo_i_raster_selftest(device, context, raster, reason, REASON_BYTES);
    svo_i_raster_destroy(&raster);
}

static void expansion_passes_the_selftest_everywhere(void **state)
{
    (void)state;
    svo_device *device = machine_device_or_skip();
    int tested = 0;
    for (int kind = 0; kind < SVO_GL_CONTEXT_KINDS; ++kind) {
        svo_gl_context *context = machine_context_or_null((svo_gl_context_kind)kind);
        for (int no_int64 = 0; no_int64 < 2 && context != NULL; ++no_int64, ++tested) {
            char reason[REASON_BYTES] = "not run";
            selftest_reason(device, context, SVO_I_CONSERVATIVE_EXPAND, no_int64 != 0, reason);
            if (reason[0] != '\0') {
                fail_msg("%s, no_int64 %d: %s", svo_name(SVO_NAME_GL_CONTEXT_KIND, (svo_gl_context_kind)kind), no_int64,
                         reason);
            }
        }
        svo_gl_context_destroy(&context);
    }
    svo_device_destroy(&device);
    if (tested == 0) {
        skip();
    }
}

/* A driver that lists extensions it does not implement.
 */

/* The original functions of that context. Its wrappers have no user pointer, so this is global. */
static svo_i_gl_functions honest;

static bool is_conservative_capability(GLenum capability)
{
    return capability == 0x9346 /* GL_CONSERVATIVE_RASTERIZATION_NV */ ||
           capability == 0x83fe /* GL_CONSERVATIVE_RASTERIZATION_INTEL */;
}

static void APIENTRY enable_honest(GLenum capability)
{
    if (!is_conservative_capability(capability)) {
        honest.Enable(capability);
    }
}

static void APIENTRY disable_honest(GLenum capability)
{
    if (!is_conservative_capability(capability)) {
        honest.Disable(capability);
    }
}

/* Makes the context list the extensions without implementing them. */
static void start_lying(svo_gl_context *context, const char *extensions)
{
    honest = context->functions;
    const size_t bytes = strlen(honest.extensions) + strlen(extensions) + 1;
    char *all = malloc(bytes);
    assert_non_null(all);
    (void)snprintf(all, bytes, "%s%s", honest.extensions, extensions);
    context->functions.extensions = all;
    context->functions.Enable = enable_honest;
    context->functions.Disable = disable_honest;
    context->functions.ConservativeRasterParameteriNV = ignore_parameter;
}

static void stop_lying(svo_gl_context *context)
{
    free(context->functions.extensions);
    context->functions = honest;
}

typedef struct lie {
    svo_i_conservative method;
    const char *extensions;
} lie;

static lie lies[] = {{SVO_I_CONSERVATIVE_NV, NV " " NV_PRE_SNAP " "}, {SVO_I_CONSERVATIVE_INTEL, INTEL " "}};

static void selftest_finds_what_a_lying_driver_misses(void **state)
{
    const lie *told = *state;
    svo_device *device = machine_device_or_skip();
    svo_gl_context *context = machine_any_context_or_skip();
    start_lying(context, told->extensions);
    for (int no_int64 = 0; no_int64 < 2; ++no_int64) {
        char reason[REASON_BYTES] = "";
        unsigned found = 0;
        unsigned expected = 0;
        selftest_reason(device, context, told->method, no_int64 != 0, reason);
        if (sscanf(reason, "the self-test found %u fragments, not %u", &found, &expected) != 2 || found >= expected) {
            fail_msg("%s: '%s'", told->extensions, reason);
        }
    }
    stop_lying(context);
    svo_gl_context_destroy(&context);
    svo_device_destroy(&device);
}

static void lying_driver_is_not_used(void **state)
{
    const lie *told = *state;
    svo_device *device = machine_device_or_skip();
    svo_gl_context *context = machine_any_context_or_skip();
    start_lying(context, told->extensions);
    svo_gl *gl = NULL;
    const svo_gl_options forced = {.struct_size = sizeof forced, .raster = SVO_GL_RASTER_HW};
    assert_int_equal(svo_gl_create(device, context, &forced, &gl), SVO_UNSUPPORTED);
    assert_null(gl);
    assert_non_null(strstr(svo_device_message(device), "svo_gl_create: gl-hw does not work: the self-test found"));

    assert_int_equal(svo_gl_create(device, context, NULL, &gl), SVO_OK);
    assert_int_equal(chosen_raster(gl), SVO_GL_RASTER_EXPAND);
    assert_non_null(strstr(svo_gl_raster_reason(gl, SVO_GL_RASTER_HW), "the self-test found"));
    assert_string_equal(svo_gl_raster_reason(gl, SVO_GL_RASTER_EXPAND), "");
    svo_gl_destroy(&gl);
    stop_lying(context);
    svo_gl_context_destroy(&context);
    svo_device_destroy(&device);
}

/*
 * A driver that does what the extensions' texts say. It rasterizes triangles conservatively by way of the vertex
 * shader, whose margin it widens by half a pixel, while the capability is on; it drops triangles that are drawn while
 * it is off. Points in the mode of INTEL are an error and are not drawn. Those in NV's come twice.
 */

static struct {
    bool on;
    svo_i_conservative method;
    GLenum error; /* until it is read */
    unsigned conservative_draws, point_draws;
} strict;

static void APIENTRY enable_strict(GLenum capability)
{
    strict.on = strict.on || is_conservative_capability(capability);
    enable_honest(capability);
}

static void APIENTRY disable_strict(GLenum capability)
{
    strict.on = strict.on && !is_conservative_capability(capability);
    disable_honest(capability);
}

static void APIENTRY draw_strict(GLenum mode, GLint first, GLsizei count)
{
    if (mode == GL_POINTS) {
        ++strict.point_draws;
        if (strict.on && strict.method == SVO_I_CONSERVATIVE_INTEL) {
            strict.error = GL_INVALID_OPERATION;
            return;
        }
        if (strict.on) {
            honest.DrawArrays(mode, first, count);
        }
    } else {
        strict.conservative_draws += strict.on;
    }
    honest.DrawArrays(mode, first, mode == GL_POINTS || strict.on ? count : 0);
}

static GLenum APIENTRY get_error_strict(void)
{
    const GLenum error = strict.error;
    strict.error = GL_NO_ERROR;
    return error != GL_NO_ERROR ? error : honest.GetError();
}

static void APIENTRY source_strict(GLuint shader, GLsizei count, const GLchar *const *texts, const GLint *lengths)
{
    const GLchar *widened[16];
    assert_true(count <= 16 && lengths == NULL);
    for (GLsizei i = 0; i < count; ++i) {
        const bool is_margin = strcmp(texts[i], "#define SVO_REACH 0.0625\n") == 0;
        widened[i] = is_margin ? "#define SVO_REACH 0.5625\n" : texts[i];
    }
    honest.ShaderSource(shader, count, widened, NULL);
}

static void start_strictly(svo_gl_context *context, const lie *listed)
{
    start_lying(context, listed->extensions);
    memset(&strict, 0, sizeof strict);
    strict.method = listed->method;
    context->functions.Enable = enable_strict;
    context->functions.Disable = disable_strict;
    context->functions.DrawArrays = draw_strict;
    context->functions.GetError = get_error_strict;
    context->functions.ShaderSource = source_strict;
}

static void selftest_passes_on_a_strict_driver(void **state)
{
    const lie *listed = *state;
    svo_device *device = machine_device_or_skip();
    svo_gl_context *context = machine_any_context_or_skip();
    start_strictly(context, listed);
    for (int no_int64 = 0; no_int64 < 2; ++no_int64) {
        char reason[REASON_BYTES] = "not run";
        selftest_reason(device, context, listed->method, no_int64 != 0, reason);
        assert_string_equal(reason, "");
    }
    assert_true(strict.point_draws > 0 && strict.conservative_draws > 0);
    assert_false(strict.on);
    svo_gl *gl = NULL;
    assert_int_equal(svo_gl_create(device, context, NULL, &gl), SVO_OK);
    assert_int_equal(chosen_raster(gl), SVO_GL_RASTER_HW);
    svo_gl_destroy(&gl);
    stop_lying(context);
    svo_gl_context_destroy(&context);
    svo_device_destroy(&device);
}

/* Extension state that an application may have set, kept in variables by the fake driver. */
static GLboolean conservative_on;
static GLint conservative_mode;

static void APIENTRY enable_kept(GLenum capability)
{
    if (is_conservative_capability(capability)) {
        conservative_on = GL_TRUE;
    } else {
        honest.Enable(capability);
    }
}

static void APIENTRY disable_kept(GLenum capability)
{
    if (is_conservative_capability(capability)) {
        conservative_on = GL_FALSE;
    } else {
        honest.Disable(capability);
    }
}

static GLboolean APIENTRY is_enabled_kept(GLenum capability)
{
    return is_conservative_capability(capability) ? conservative_on : honest.IsEnabled(capability);
}

static void APIENTRY set_mode_kept(GLenum name, GLint value)
{
    (void)name;
    conservative_mode = value;
}

static void APIENTRY get_integer_kept(GLenum name, GLint *value)
{
    if (name == 0x954d /* GL_CONSERVATIVE_RASTER_MODE_NV */) {
        *value = conservative_mode;
    } else {
        honest.GetIntegerv(name, value);
    }
}

static void conservative_state_is_off_and_comes_back(void **state)
{
    const lie *told = *state;
    svo_i_gl_state saved;
    svo_gl_context *context = machine_any_context_or_skip();
    start_lying(context, told->extensions);
    svo_i_gl_functions *gl = &context->functions;
    gl->Enable = enable_kept;
    gl->Disable = disable_kept;
    gl->IsEnabled = is_enabled_kept;
    gl->ConservativeRasterParameteriNV = set_mode_kept;
    gl->GetIntegerv = get_integer_kept;
    assert_int_equal(svo_i_gl_context_make_current(context, NULL), SVO_OK);
    conservative_on = GL_TRUE;
    conservative_mode = 0x954e; /* GL_CONSERVATIVE_RASTER_MODE_POST_SNAP_NV */
    svo_i_gl_state_save(gl, &saved);
    svo_i_gl_state_set_plain(gl);
    assert_int_equal(conservative_on, GL_FALSE);
    if (told->method == SVO_I_CONSERVATIVE_NV) {
        conservative_mode = 0x954f; /* what gl-hw sets */
    }
    svo_i_gl_state_restore(gl, &saved);
    assert_int_equal(conservative_on, GL_TRUE);
    assert_int_equal(conservative_mode, 0x954e);
    svo_i_gl_context_release_current(context);
    stop_lying(context);
    svo_gl_context_destroy(&context);
}

/*
 * Triangles of every class on the caller's grid [0, 1)^3.
 */

enum { MIXED_TRIANGLES = 64, MIXED_NEEDLES = 6 };

typedef struct mixed_mesh {
    double positions[MIXED_TRIANGLES * 9];
    svo_mesh mesh;
} mixed_mesh;

static const svo_plan_options unit_grid = {.struct_size = sizeof unit_grid, .edge = 1.0, .need = SVO_NEED_RAYS};

static double random_between(uint64_t *random, double low, double high)
{
    return low + (high - low) * random_unit(random);
}

/* Needles that cross the grid and extend far outside on both sides. */
static void make_needle(uint64_t *random, double *corners)
{
    for (int axis = 0; axis < 3; ++axis) {
        const double through = random_between(random, 0.1, 0.9);
        const double reach = random_between(random, -200.0, 200.0);
        corners[axis] = through - reach;
        corners[3 + axis] = through + reach;
        corners[6 + axis] = through + random_between(random, -0.001, 0.001);
    }
}

/* A cycle of four: smaller than a voxel, narrow, regular, and across a face of the grid. */
static void make_mixed(uint64_t seed, mixed_mesh *out)
{
    static const double widths[4] = {0.0001, 0.01, 0.3, 0.05};
    uint64_t random = seed;
    for (int t = 0; t < MIXED_TRIANGLES; ++t) {
        double *corners = out->positions + (size_t)t * 9;
        if (t < MIXED_NEEDLES) {
            make_needle(&random, corners);
            continue;
        }
        const double width = widths[t % 4];
        const int outside_axis = t % 4 == 3 ? (int)random_below(&random, 3) : -1;
        for (int axis = 0; axis < 3; ++axis) {
            const double face = random_below(&random, 2);
            const double center = axis == outside_axis ? face : random_between(&random, 0.1 + width, 0.9 - width);
            for (int i = 0; i < 3; ++i) {
                corners[3 * i + axis] = center + random_between(&random, -width, width);
            }
        }
    }
    out->mesh = (svo_mesh){.struct_size = sizeof out->mesh,
                           .positions_double = out->positions,
                           .vertex_count = MIXED_TRIANGLES * 3,
                           .triangle_count = MIXED_TRIANGLES};
}

static svo_plan *plan_mixed(svo_device *device, const mixed_mesh *mixed, unsigned depth)
{
    svo_plan *plan = NULL;
    if (svo_plan_create(device, &mixed->mesh, depth, &unit_grid, &plan) != SVO_OK) {
        fail_msg("%s", svo_device_message(device));
    }
    for (int c = 0; c < SVO_I_CLASS_COUNT; ++c) {
        /* Below depth 8 all triangles are narrow enough. */
        if (plan->class_begin[c] == plan->class_begin[c + 1] && (depth >= 8 || c != SVO_I_CLASS_REGULAR)) {
            fail_msg("depth %u: no triangle of class %d", depth, c);
        }
    }
    return plan;
}

static void check_shaders_compile(svo_gl_context *context, svo_plan *plan, svo_i_conservative method, bool no_int64)
{
    svo_i_raster *raster = NULL;
    assert_int_equal(svo_i_raster_create(plan->device, context, method, no_int64, &raster), SVO_OK);
    assert_int_equal(svo_i_gl_context_make_current(context, NULL), SVO_OK);
    const svo_status status = svo_i_raster_prepare(raster, plan);
    svo_i_gl_context_release_current(context);
    svo_i_raster_destroy(&raster);
    if (status != SVO_OK) {
        fail_msg("method %d, no_int64 %d: %s", (int)method, no_int64, svo_device_message(plan->device));
    }
}

static void shaders_of_every_way_compile(void **state)
{
    (void)state;
    svo_device *device = machine_device_or_skip();
    svo_gl_context *context = machine_any_context_or_skip();
    mixed_mesh mixed;
    make_mixed(1, &mixed);
    for (unsigned depth = 8; depth <= 11; depth += 3) { /* codes of 30 and of 48 bits */
        svo_plan *plan = plan_mixed(device, &mixed, depth);
        for (size_t i = 0; i < sizeof lies / sizeof lies[0]; ++i) {
            start_lying(context, lies[i].extensions);
            check_shaders_compile(context, plan, lies[i].method, false);
            check_shaders_compile(context, plan, lies[i].method, true);
            stop_lying(context);
        }
        svo_plan_destroy(&plan);
    }
    svo_gl_context_destroy(&context);
    svo_device_destroy(&device);
}

/*
 * Forced choices.
 */

/* A forced choice that does not work is rejected with the reason. One that works is used. */
static void check_forced(svo_device *device, svo_gl_context *context, const svo_gl_options *forced, const char *reason)
{
    svo_gl *gl = NULL;
    const svo_status status = svo_gl_create(device, context, forced, &gl);
    if (reason[0] != '\0') {
        assert_int_equal(status, SVO_UNSUPPORTED);
        assert_null(gl);
        if (strstr(svo_device_message(device), reason) == NULL) {
            fail_msg("'%s' does not contain '%s'", svo_device_message(device), reason);
        }
        return;
    }
    assert_int_equal(status, SVO_OK);
    assert_true(forced->raster == SVO_GL_RASTER_AUTO || chosen_raster(gl) == forced->raster);
    assert_true(forced->share == SVO_GL_SHARE_AUTO || chosen_share(gl) == forced->share);
    svo_gl_destroy(&gl);
}

static void forced_choice_is_kept_or_refused(void **state)
{
    (void)state;
    svo_device *device = machine_device_or_skip();
    svo_gl_context *context = machine_any_context_or_skip();
    svo_gl *any = NULL;
    assert_int_equal(svo_gl_create(device, context, NULL, &any), SVO_OK);
    for (svo_gl_raster raster = SVO_GL_RASTER_EXPAND; raster <= SVO_GL_RASTER_HW; ++raster) {
        const svo_gl_options forced = {.struct_size = sizeof forced, .raster = raster};
        check_forced(device, context, &forced, svo_gl_raster_reason(any, raster));
    }
    for (svo_gl_share share = SVO_GL_SHARE_INTEROP; share <= SVO_GL_SHARE_COPY; ++share) {
        const svo_gl_options forced = {.struct_size = sizeof forced, .share = share};
        check_forced(device, context, &forced, svo_gl_share_reason(any, share));
    }
    svo_gl_destroy(&any);
    svo_gl_context_destroy(&context);
    svo_device_destroy(&device);
}

static void hardware_without_the_extension_is_refused(void **state)
{
    (void)state;
    svo_device *device = machine_device_or_skip();
    svo_gl_context *context = machine_any_context_or_skip();
    honest = context->functions;
    context->functions.extensions[0] = '\0';
    svo_gl *gl = NULL;
    const svo_gl_options forced = {.struct_size = sizeof forced, .raster = SVO_GL_RASTER_HW};
    assert_int_equal(svo_gl_create(device, context, &forced, &gl), SVO_UNSUPPORTED);
    assert_string_equal(svo_device_message(device),
                        "svo_gl_create: gl-hw does not work: the context lists neither " NV " nor " INTEL);
    svo_gl_context_destroy(&context);
    svo_device_destroy(&device);
}

/*
 * Where OpenGL keeps lists.
 */

static unsigned buffers_made;
static GLenum wrong_usage; /* of a buffer that shaders write; 0: none */

static void APIENTRY keep_usage(GLenum target, GLsizeiptr bytes, const void *data, GLenum usage)
{
    honest.BufferData(target, bytes, data, usage);
    if (data == NULL && target == GL_COPY_READ_BUFFER) {
        ++buffers_made;
        wrong_usage = usage != GL_STATIC_COPY ? usage : wrong_usage;
    }
}

/* Drivers put buffers for the host to read, and some for it to change, into system memory. */
static void lists_are_in_the_gpus_memory(void **state)
{
    (void)state;
    svo_device *device = machine_device_or_skip();
    svo_gl_context *context = machine_any_context_or_skip();
    const svo_gl_options options = {.struct_size = sizeof options, .share = SVO_GL_SHARE_COPY};
    svo_gl *gl = NULL;
    mixed_mesh mixed;
    honest = context->functions;
    context->functions.BufferData = keep_usage;
    make_mixed(1, &mixed);
    assert_int_equal(svo_gl_create(device, context, &options, &gl), SVO_OK);
    for (int in_gl = 0; in_gl < 2; ++in_gl) {
        svo_plan *plan = plan_mixed(device, &mixed, 8);
        svo_tree *tree = NULL;
        buffers_made = 0;
        wrong_usage = 0;
        const svo_status status =
            in_gl ? svo_gl_build(gl, plan, NULL, &tree, NULL) : svo_build(plan, svo_gl_frontend(gl), NULL, &tree, NULL);
        if (status != SVO_OK) {
            fail_msg("%s", svo_device_message(device));
        }
        assert_true(buffers_made > 0);
        assert_int_equal(wrong_usage, 0);
        svo_tree_destroy(&tree);
        svo_plan_destroy(&plan);
    }
    svo_gl_destroy(&gl);
    context->functions = honest;
    svo_gl_context_destroy(&context);
    svo_device_destroy(&device);
}

/* 64-bit integers of GLSL, or of two words.
 */

/* Builds with a front end of its own and compares with the exact tree. */
static void check_mixed(uint32_t no_int64, const mixed_mesh *mixed, unsigned depth, char hash[SVO_HASH_TEXT_BYTES])
{
    fixture opened;
    built actual;
    fixture_open(&(fixture_options){.no_int64 = no_int64}, &opened);
    svo_plan *plan = plan_mixed(opened.device, mixed, depth);
    svo_plan_destroy(&plan);
    fixture_build(&opened, &mixed->mesh, depth, &unit_grid, &actual);
    assert_true(actual.info.leaf_count > 0);
    assert_build_is_exact(&mixed->mesh, &unit_grid, &actual);
    memcpy(hash, actual.hash, SVO_HASH_TEXT_BYTES);
    built_destroy(&actual);
    fixture_close(&opened);
}

static void kind_of_integers_leaves_no_trace(void **state)
{
    (void)state;
    static const unsigned depths[] = {5, 8, 11};
    for (size_t i = 0; i < sizeof depths / sizeof depths[0]; ++i) {
        mixed_mesh mixed;
        char with_int64[SVO_HASH_TEXT_BYTES];
        char with_two_words[SVO_HASH_TEXT_BYTES];
        make_mixed(i + 1, &mixed);
        check_mixed(0, &mixed, depths[i], with_int64);
        check_mixed(1, &mixed, depths[i], with_two_words);
        assert_string_equal(with_two_words, with_int64);
    }
}

TEST_GROUP(raster)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hardware_method_follows_from_extensions),
        cmocka_unit_test(expansion_passes_the_selftest_everywhere),
        cmocka_unit_test_prestate(selftest_finds_what_a_lying_driver_misses, &lies[0]),
        cmocka_unit_test_prestate(selftest_finds_what_a_lying_driver_misses, &lies[1]),
        cmocka_unit_test_prestate(lying_driver_is_not_used, &lies[0]),
        cmocka_unit_test_prestate(lying_driver_is_not_used, &lies[1]),
        cmocka_unit_test_prestate(selftest_passes_on_a_strict_driver, &lies[0]),
        cmocka_unit_test_prestate(selftest_passes_on_a_strict_driver, &lies[1]),
        cmocka_unit_test_prestate(conservative_state_is_off_and_comes_back, &lies[0]),
        cmocka_unit_test_prestate(conservative_state_is_off_and_comes_back, &lies[1]),
        cmocka_unit_test(shaders_of_every_way_compile),
        cmocka_unit_test(forced_choice_is_kept_or_refused),
        cmocka_unit_test(hardware_without_the_extension_is_refused),
        cmocka_unit_test(lists_are_in_the_gpus_memory),
        cmocka_unit_test(kind_of_integers_leaves_no_trace),
    };
    return cmocka_run_group_tests_name("raster", tests, NULL, NULL);
}
