/* SPDX-License-Identifier: MIT */
/*
 * Off-screen OpenGL contexts, their function tables, and the buffers shared with OpenCL.
 *
 * A kind of context whose library is not installed is skipped visibly. A kind that exists and fails is a failure.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <pthread.h>

#include "context/context.h"
#include "core/device.h"
#include "share/probe.h"
#include "share/share.h"
#include "support/gl_contexts.h"
#include "support/machine.h"
#include "support/suite.h"

enum { BUFFER_WORDS = 1000, THREAD_ROUNDS = 50, SHARE_WORDS = 100003, SHARE_ROUNDS = 3 };

static svo_gl_context *context_or_skip(svo_gl_context_kind kind)
{
    svo_gl_context *context = machine_context_or_null(kind);
    if (context == NULL) {
        skip();
    }
    return context;
}

static void make_current(svo_gl_context *context)
{
    svo_message message = {""};
    if (svo_i_gl_context_make_current(context, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
}

/* Creates a buffer, clears it to value and reads it back. Expects the context current. */
static bool buffer_works(const svo_gl_context *context, GLuint value)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(context);
    GLuint name = 0, words[BUFFER_WORDS] = {0};
    gl->GenBuffers(1, &name);
    gl->BindBuffer(GL_ARRAY_BUFFER, name);
    gl->BufferData(GL_ARRAY_BUFFER, sizeof words, NULL, GL_STATIC_DRAW);
    gl->ClearBufferData(GL_ARRAY_BUFFER, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &value);
    gl->GetBufferSubData(GL_ARRAY_BUFFER, 0, sizeof words, words);
    gl->DeleteBuffers(1, &name);
    bool equal = gl->GetError() == GL_NO_ERROR;
    for (int i = 0; i < BUFFER_WORDS; ++i) {
        equal = equal && words[i] == value;
    }
    return equal;
}

static void check_kind(svo_gl_context_kind kind)
{
    svo_gl_context *context = context_or_skip(kind);
    svo_gl_context_info info = SVO_GL_CONTEXT_INFO_INIT;
    svo_gl_context_get_info(context, &info);
    assert_int_equal(info.kind, kind);
    assert_int_equal(info.device_index, 0);
    assert_true(strlen(info.vendor) > 0);
    assert_true(strlen(info.renderer) > 0);
    assert_true(strlen(info.version) > 0);
    print_message("%s: %s, OpenGL %s\n", svo_name(SVO_NAME_GL_CONTEXT_KIND, kind), info.renderer, info.version);
    assert_int_equal(info.is_software != 0,
                     strstr(info.renderer, "llvmpipe") != NULL || strstr(info.renderer, "softpipe") != NULL);

    const svo_i_gl_functions *gl = svo_i_gl_context_functions(context);
    assert_true(gl->version >= SVO_I_GL_MINIMUM_VERSION);
    assert_true(gl->limits.storage_block_bytes >= 1 << 24); /* the minimum of OpenGL 4.3 */
    assert_true(gl->limits.fragment_storage_blocks >= 8);
    assert_true(gl->limits.framebuffer_width >= 16384);
    assert_true(gl->limits.viewport_width >= 1024);
    GLint subpixel_bits = 0;
    make_current(context);
    gl->GetIntegerv(GL_SUBPIXEL_BITS, &subpixel_bits);
    assert_true(subpixel_bits >= 4); /* the margin of shaders/raster.vert covers such a grid */
    assert_true(buffer_works(context, 7));
    svo_i_gl_context_release_current(context);
    assert_false(context->platform->is_current(context->native));
    svo_gl_context_destroy(&context);
    assert_null(context);
}

static void surfaceless_context_is_created(void **state)
{
    (void)state;
    check_kind(SVO_GL_SURFACELESS);
}

static void egl_device_context_is_created(void **state)
{
    (void)state;
    check_kind(SVO_GL_EGL_DEVICE);
}

static void osmesa_context_is_created(void **state)
{
    (void)state;
    check_kind(SVO_GL_OSMESA);
}

static void wrong_device_index_is_refused(void **state)
{
    (void)state;
    svo_message message = {""};
    svo_gl_context *context = NULL;
    assert_int_equal(context_of_kind(SVO_GL_EGL_DEVICE, 4000000000u, &context, &message), SVO_NO_GL);
    assert_null(context);
    if (svo_gl_egl_device_count() > 0) {
        assert_non_null(strstr(message.text, "4000000000"));
    }
}

/* Where EGL says so without a context, contexts say so too. */
static void software_is_known_without_a_context(void **state)
{
    (void)state;
    const int is_software = svo_gl_egl_is_software();
    uint32_t in_software = 0;
    uint32_t made = 0;
    for (uint32_t i = 0; i < svo_gl_egl_device_count(); ++i) {
        svo_gl_context *context = NULL;
        svo_gl_context_info info = SVO_GL_CONTEXT_INFO_INIT;
        if (context_of_kind(SVO_GL_EGL_DEVICE, i, &context, NULL) == SVO_OK) {
            svo_gl_context_get_info(context, &info);
            in_software += info.is_software;
            ++made;
        }
        svo_gl_context_destroy(&context);
    }
    if (is_software != 0) {
        assert_true(svo_gl_egl_device_count() > 0);
        assert_int_equal(in_software, made);
    } else if (made > 0) {
        assert_true(in_software < svo_gl_egl_device_count());
    }
}

/* A part of the renderer's name, in the other case. */
static void part_of_name(const char *renderer, char part[9])
{
    for (int i = 0; i < 8; ++i) {
        const char c = renderer[i];
        part[i] = (char)(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
    }
    part[8] = '\0';
}

static void egl_devices_are_found_by_name(void **state)
{
    (void)state;
    svo_message message = {""};
    svo_gl_context_info first, found;
    char part[9];
    svo_gl_context *context = context_or_skip(SVO_GL_EGL_DEVICE);
    first = (svo_gl_context_info)SVO_GL_CONTEXT_INFO_INIT;
    svo_gl_context_get_info(context, &first);
    part_of_name(first.renderer, part);
    svo_gl_context_destroy(&context);
    static const char by_index[] = "0";
    const char *const names[] = {by_index, part};
    for (size_t i = 0; i < 2; ++i) {
        if (context_of_name(names[i], &context, &message) != SVO_OK) {
            fail_msg("%s", message.text);
        }
        found = (svo_gl_context_info)SVO_GL_CONTEXT_INFO_INIT;
        svo_gl_context_get_info(context, &found);
        assert_int_equal(found.kind, SVO_GL_EGL_DEVICE);
        assert_int_equal(found.device_index, 0);
        svo_gl_context_destroy(&context);
    }
    assert_int_equal(context_of_name("no such renderer", &context, &message), SVO_NO_GL);
    assert_non_null(strstr(message.text, "no EGL device matches \"no such renderer\"; found: 0: "));
    assert_int_equal(context_of_name("4000000", &context, &message), SVO_NO_GL);
    assert_int_equal(context_of_name("", &context, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(context_of_name("gpu", NULL, &message), SVO_INVALID_ARGUMENT);
    assert_null(context);
}

/* "gpu" finds a GPU or lists what exists. It never selects a software renderer. */
static void gpu_is_never_a_processor(void **state)
{
    (void)state;
    svo_message message = {""};
    svo_gl_context *context = NULL;
    const svo_status status = context_of_name("GPU", &context, &message);
    if (status == SVO_OK) {
        svo_gl_context_info info = SVO_GL_CONTEXT_INFO_INIT;
        svo_gl_context_get_info(context, &info);
        assert_int_equal(info.is_software, 0);
        svo_gl_context_destroy(&context);
        return;
    }
    print_message("%s\n", message.text);
    assert_int_equal(status, SVO_NO_GL);
    assert_non_null(strstr(message.text, "no EGL device matches \"GPU\""));
}

/* Where EGL lists GPUs alone, the context is on one; where a CPU draws everything, it is the first that works. */
static void context_for_a_device_is_the_best(void **state)
{
    (void)state;
    svo_message message = {""};
    svo_gl_context *context = NULL;
    svo_gl_context_info info = SVO_GL_CONTEXT_INFO_INIT;
    svo_device *device = machine_device_or_skip();
    const svo_status status = context_for_device(device, &context, &message);
    if (status == SVO_OK) {
        svo_gl_context *gpu = NULL;
        svo_gl_context_get_info(context, &info);
        assert_int_equal(info.is_software, context_of_name("gpu", &gpu, NULL) != SVO_OK);
        svo_gl_context_destroy(&gpu);
    } else {
        assert_int_equal(status, SVO_NO_GL);
        assert_non_null(strstr(message.text, "svo_gl_context_create: no OpenGL context: "));
    }
    svo_gl_context_destroy(&context);
    assert_int_equal(context_for_device(device, NULL, &message), SVO_INVALID_ARGUMENT);
    svo_device_destroy(&device);
}

static bool promise(void *native)
{
    (void)native;
    return true;
}

/* Simulates Mesa with a GPU whose device node cannot be opened. */
static void software_in_place_of_a_gpu_is_refused(void **state)
{
    (void)state;
    svo_message message = {""};
    svo_gl_context *context = machine_any_context_or_skip();
    const svo_i_gl_platform *honest = context->platform;
    const svo_i_gl_functions functions = context->functions;
    svo_i_gl_platform promising = *honest;
    promising.promises_gpu = promise;
    assert_int_equal(svo_i_gl_context_check_promise(context, &message), SVO_OK);
    context->platform = &promising;
    context->functions.renderer = "zink (llvmpipe (LLVM 15.0.6, 256 bits))";
    assert_int_equal(svo_i_gl_context_check_promise(context, &message), SVO_NO_GL);
    assert_string_equal(message.text, "svo_gl_context_create: EGL device 0 is a GPU, but zink (llvmpipe (LLVM 15.0.6, "
                                      "256 bits)) renders for it");
    context->functions.renderer = "NVIDIA H200/PCIe/SSE2";
    assert_int_equal(svo_i_gl_context_check_promise(context, &message), SVO_OK);
    context->functions = functions;
    context->platform = honest;
    svo_gl_context_destroy(&context);
}

static svo_gl_function no_function(void *user, const char *name)
{
    (void)user;
    (void)name;
    return NULL;
}

/* Whatever device is, it is not looked at. */
static void contradicting_options_are_refused(void **state)
{
    (void)state;
    const svo_device *device = (const svo_device *)state;
    const struct {
        svo_gl_context_options options;
        const char *words;
    } rows[] = {
        {{.device = device, .device_name = "gpu"}, "options.device and options.device_name"},
        {{.device = device, .device_index = 1}, "options.device and options.device_index"},
        {{.device = device, .kind = SVO_GL_OSMESA}, "options.device and options.kind"},
        {{.device_name = "gpu", .device_index = 1}, "options.device_name and options.device_index"},
        {{.device_name = "gpu", .kind = SVO_GL_OSMESA}, "options.device_name and options.kind"},
        {{.device_index = 1}, "options.device_index and options.kind"},
        {{.device_index = 1, .kind = SVO_GL_OSMESA}, "options.device_index and options.kind"},
        {{.device_name = ""}, "options.device_name is empty"},
        {{.kind = SVO_GL_WRAPPED}, "options.get_proc_address is NULL with kind \"wrapped\""},
        {{.get_proc_address = no_function}, "options.get_proc_address is given with kind \"surfaceless\""},
        {{.device_name = "gpu", .get_proc_address = no_function}, "options.get_proc_address is given"},
        {{.device = device, .get_proc_address = no_function}, "options.get_proc_address is given"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        svo_gl_context_options options = rows[i].options;
        svo_gl_context *context = NULL;
        svo_message message = {""};
        options.struct_size = sizeof options;
        assert_int_equal(svo_gl_context_create(&options, &context, &message), SVO_INVALID_ARGUMENT);
        assert_null(context);
        if (strstr(message.text, rows[i].words) == NULL) {
            fail_msg("row %zu: %s", i, message.text);
        }
    }
}

/* Without options the context is surfaceless. */
static void no_options_are_the_defaults(void **state)
{
    (void)state;
    svo_gl_context *context = context_or_skip(SVO_GL_SURFACELESS);
    svo_gl_context_info info = SVO_GL_CONTEXT_INFO_INIT;
    svo_gl_context_destroy(&context);
    assert_int_equal(svo_gl_context_create(NULL, &context, NULL), SVO_OK);
    svo_gl_context_get_info(context, &info);
    assert_int_equal(info.kind, SVO_GL_SURFACELESS);
    svo_gl_context_destroy(&context);
}

static void wrong_arguments_are_refused(void **state)
{
    (void)state;
    svo_message message = {""};
    svo_gl_context *context = NULL;
    assert_int_equal(context_of_kind(SVO_GL_CONTEXT_KINDS, 0, &context, &message), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "svo_gl_context_create: options.kind"));
    assert_int_equal(context_of_kind(SVO_GL_SURFACELESS, 0, NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_null(context);
    svo_gl_context_destroy(&context);
    svo_gl_context_destroy(NULL);
}

/* Calls test for every ordered pair of kinds on this machine, with two different contexts. */
static void for_each_pair(void (*test)(svo_gl_context **first, svo_gl_context **second))
{
    int pair_count = 0;
    for (int a = 0; a < SVO_GL_CONTEXT_KINDS; ++a) {
        for (int b = 0; b < SVO_GL_CONTEXT_KINDS; ++b) {
            svo_gl_context *first = machine_context_or_null((svo_gl_context_kind)a);
            svo_gl_context *second = machine_context_or_null((svo_gl_context_kind)b);
            if (first != NULL && second != NULL) {
                test(&first, &second);
                ++pair_count;
            }
            svo_gl_context_destroy(&first);
            svo_gl_context_destroy(&second);
        }
    }
    if (pair_count == 0) {
        skip();
    }
}

static void destroy_first_use_second(svo_gl_context **first, svo_gl_context **second)
{
    svo_gl_context_destroy(first);
    make_current(*second);
    assert_true(buffer_works(*second, 8));
    svo_i_gl_context_release_current(*second);
}

static void contexts_outlive_each_other(void **state)
{
    (void)state;
    for_each_pair(destroy_first_use_second);
}

static GLint bound_buffer(const svo_gl_context *context)
{
    GLint name = 0;
    svo_i_gl_context_functions(context)->GetIntegerv(GL_ARRAY_BUFFER_BINDING, &name);
    return name;
}

/* Leaves the last of count new buffers bound: its name tells contexts apart. */
static void bind_nth_buffer(const svo_gl_context *context, GLint count)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(context);
    GLuint names[8] = {0};
    gl->GenBuffers(count, names);
    gl->BindBuffer(GL_ARRAY_BUFFER, names[count - 1]);
    assert_int_equal(bound_buffer(context), names[count - 1]);
}

static void nest_second_in_first(svo_gl_context **first, svo_gl_context **second)
{
    make_current(*first);
    bind_nth_buffer(*first, 3);
    GLint first_name = bound_buffer(*first);
    make_current(*second);
    bind_nth_buffer(*second, 5);
    GLint second_name = bound_buffer(*second);
    assert_int_not_equal(first_name, second_name);

    make_current(*first); /* not in nesting order */
    assert_int_equal(bound_buffer(*first), first_name);
    make_current(*first); /* already current */
    svo_i_gl_context_release_current(*first);
    assert_int_equal(bound_buffer(*first), first_name);
    svo_i_gl_context_release_current(*first);

    assert_true((*second)->platform->is_current((*second)->native));
    assert_int_equal(bound_buffer(*second), second_name);
    svo_i_gl_context_release_current(*second);
    assert_true((*first)->platform->is_current((*first)->native));
    assert_int_equal(bound_buffer(*first), first_name);
    svo_i_gl_context_release_current(*first);
    assert_false((*first)->platform->is_current((*first)->native));
    assert_false((*second)->platform->is_current((*second)->native));
}

static void release_restores_what_was_current(void **state)
{
    (void)state;
    for_each_pair(nest_second_in_first);
}

static void nesting_has_a_limit(void **state)
{
    (void)state;
    svo_message message = {""};
    svo_gl_context *context = machine_any_context_or_skip();
    for (int i = 0; i < SVO_I_GL_NESTING_LIMIT; ++i) {
        make_current(context);
    }
    assert_int_equal(svo_i_gl_context_make_current(context, &message), SVO_INTERNAL);
    for (int i = 0; i < SVO_I_GL_NESTING_LIMIT; ++i) {
        assert_true(context->platform->is_current(context->native));
        svo_i_gl_context_release_current(context);
    }
    assert_false(context->platform->is_current(context->native));
    svo_gl_context_destroy(&context);
}

/* One thread's work. cmocka's asserts work in the main thread only, so this counts failures. */
typedef struct worker {
    svo_gl_context_kind kind;
    int rounds_done;
} worker;

static void *work(void *pointer)
{
    worker *self = pointer;
    for (int round = 0; round < THREAD_ROUNDS; ++round) {
        svo_gl_context *context = NULL;
        if (context_of_kind(self->kind, 0, &context, NULL) != SVO_OK) {
            break;
        }
        bool works = svo_i_gl_context_make_current(context, NULL) == SVO_OK;
        works = works && buffer_works(context, (GLuint)round);
        svo_i_gl_context_release_current(context);
        svo_gl_context_destroy(&context);
        self->rounds_done += works;
    }
    return NULL;
}

static void two_threads_with_own_contexts(svo_gl_context **first, svo_gl_context **second)
{
    worker workers[2] = {{(*first)->kind, 0}, {(*second)->kind, 0}};
    pthread_t threads[2];
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(pthread_create(&threads[i], NULL, work, &workers[i]), 0);
    }
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(pthread_join(threads[i], NULL), 0);
    }
    assert_int_equal(workers[0].rounds_done, THREAD_ROUNDS);
    assert_int_equal(workers[1].rounds_done, THREAD_ROUNDS);
}

static void threads_do_not_disturb_each_other(void **state)
{
    (void)state;
    for_each_pair(two_threads_with_own_contexts);
}

static void extensions_are_compared_as_whole_words(void **state)
{
    (void)state;
    char names[] = "GL_NV_x_y GL_ARB_z GL_EXT_a ";
    svo_i_gl_functions gl = {.extensions = names};
    assert_true(svo_i_gl_has_extension(&gl, "GL_NV_x_y"));
    assert_true(svo_i_gl_has_extension(&gl, "GL_ARB_z"));
    assert_true(svo_i_gl_has_extension(&gl, "GL_EXT_a"));
    assert_false(svo_i_gl_has_extension(&gl, "GL_NV_x"));
    assert_false(svo_i_gl_has_extension(&gl, "NV_x_y"));
    assert_false(svo_i_gl_has_extension(&gl, "GL_ARB_z2"));
    assert_false(svo_i_gl_has_extension(&gl, ""));
    assert_true(svo_i_list_has_token("cl_khr_gl_sharing_x cl_khr_gl_sharing", "cl_khr_gl_sharing"));
    assert_false(svo_i_list_has_token("cl_khr_gl_sharing_x xcl_khr_gl_sharing", "cl_khr_gl_sharing"));
    assert_false(svo_i_list_has_token(NULL, "cl_khr_gl_sharing"));
}

/* Wraps a real context's loader and replaces one function by NULL or another function. */
typedef struct changed_loader {
    svo_gl_context *context;
    const char *name;
    svo_i_function replacement;
} changed_loader;

static svo_i_function get_changed(void *user, const char *name)
{
    const changed_loader *loader = user;
    if (strcmp(name, loader->name) == 0) {
        return loader->replacement;
    }
    svo_i_function function = loader->context->platform->get_proc_address(loader->context->native, name);
    return function;
}

static svo_i_function get_nothing(void *user, const char *name)
{
    (void)user;
    (void)name;
    return NULL;
}

static void APIENTRY report_old_version(GLenum name, GLint *value)
{
    *value = name == GL_MAJOR_VERSION || name == GL_MINOR_VERSION ? 3 : 0;
}

static void APIENTRY report_4_3_without_extensions(GLenum name, GLint *value)
{
    *value = name == GL_MAJOR_VERSION ? 4 : name == GL_MINOR_VERSION ? 3 : 0;
}

static void missing_function_is_named(void **state)
{
    (void)state;
    svo_message message = {""};
    svo_i_gl_functions gl;
    svo_gl_context *context = machine_any_context_or_skip();
    make_current(context);
    changed_loader loader = {context, "glBindBufferRange", NULL};
    assert_int_equal(svo_i_gl_load(&gl, get_changed, &loader, NULL, &message), SVO_NO_GL);
    assert_non_null(strstr(message.text, "glBindBufferRange"));
    assert_null(gl.GetError);
    assert_int_equal(svo_i_gl_load(&gl, get_nothing, NULL, NULL, &message), SVO_NO_GL);
    assert_non_null(strstr(message.text, "no function gl"));
    svo_i_gl_unload(&gl);
    svo_i_gl_context_release_current(context);
    svo_gl_context_destroy(&context);
}

static void old_version_is_refused(void **state)
{
    (void)state;
    svo_message message = {""};
    svo_i_gl_functions gl;
    svo_gl_context *context = machine_any_context_or_skip();
    make_current(context);
    changed_loader loader = {context, "glGetIntegerv", (svo_i_function)report_old_version};
    assert_int_equal(svo_i_gl_load(&gl, get_changed, &loader, NULL, &message), SVO_NO_GL);
    assert_non_null(strstr(message.text, "below 4.3"));
    svo_i_gl_context_release_current(context);
    svo_gl_context_destroy(&context);
}

/* The loader returns the functions, but neither version nor extensions promise them. */
static void optional_functions_need_a_promise(void **state)
{
    (void)state;
    svo_message message = {""};
    svo_i_gl_functions gl;
    svo_gl_context *context = machine_any_context_or_skip();
    make_current(context);
    changed_loader loader = {context, "glGetIntegerv", (svo_i_function)report_4_3_without_extensions};
    assert_int_equal(svo_i_gl_load(&gl, get_changed, &loader, NULL, &message), SVO_OK);
    assert_int_equal(gl.version, 43);
    assert_null(gl.BufferStorage);
    svo_i_gl_unload(&gl);

    loader = (changed_loader){context, "glConservativeRasterParameteriNV", (svo_i_function)report_old_version};
    assert_int_equal(svo_i_gl_load(&gl, get_changed, &loader, NULL, &message), SVO_OK);
    assert_int_equal(gl.ConservativeRasterParameteriNV != NULL,
                     svo_i_gl_has_extension(&gl, "GL_NV_conservative_raster_pre_snap_triangles"));
    svo_i_gl_unload(&gl);
    svo_i_gl_context_release_current(context);
    svo_gl_context_destroy(&context);
}

static void errors_are_named_once(void **state)
{
    (void)state;
    svo_message message = {""};
    svo_gl_context *context = machine_any_context_or_skip();
    make_current(context);
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(context);
    gl->Enable(0xdead);
    assert_int_equal(svo_i_gl_check(gl, "svo_x", "glEnable", &message), SVO_GL_ERROR);
    assert_string_equal(message.text, "svo_x: glEnable: GL_INVALID_ENUM (0x0500)");
    assert_int_equal(svo_i_gl_check(gl, "svo_x", "glEnable", &message), SVO_OK);
    svo_i_gl_context_release_current(context);
    svo_gl_context_destroy(&context);
}

/* A device, a context and a queue, for the tests of shared buffers. */
typedef struct pair {
    svo_device *device;
    svo_gl_context *context;
    cl_command_queue queue;
} pair;

static void pair_make(pair *out, svo_gl_context_kind kind)
{
    cl_int error = CL_SUCCESS;
    out->context = context_or_skip(kind);
    out->device = machine_device_or_skip();
    out->queue = clCreateCommandQueue(out->device->context, out->device->device, 0, &error);
    assert_int_equal(error, CL_SUCCESS);
}

static void pair_make_any(pair *out)
{
    svo_gl_context *context = machine_any_context_or_skip();
    svo_gl_context_kind kind = context->kind;
    svo_gl_context_destroy(&context);
    pair_make(out, kind);
}

static void pair_release(pair *dying)
{
    clReleaseCommandQueue(dying->queue);
    svo_device_destroy(&dying->device);
    svo_gl_context_destroy(&dying->context);
}

static void share_paths_are_probed_with_reasons(void **state)
{
    (void)state;
    pair on;
    char reason[SVO_MESSAGE_BYTES];
    pair_make_any(&on);
    (void)svo_i_device_fail(on.device, SVO_OK, "what was said before");

    svo_i_share_probe(on.device, on.context, SVO_GL_SHARE_INTEROP, reason, sizeof reason);
    print_message("sharing: %s\n", reason);
    assert_non_null(strstr(reason, "cl_khr_gl_sharing"));
    svo_i_share_probe(on.device, on.context, SVO_GL_SHARE_COPY, reason, sizeof reason);
    assert_string_equal(reason, "");
    svo_i_share_probe(on.device, on.context, SVO_GL_SHARE_HOST, reason, sizeof reason);
    print_message("host: %s\n", reason);
    bool possible =
        on.device->is_cpu && on.device->cpu_path && svo_i_gl_context_functions(on.context)->BufferStorage != NULL;
    assert_int_equal(reason[0] == '\0', possible);
    assert_string_equal(svo_device_message(on.device), "what was said before");
    pair_release(&on);
}

static void host_share_needs_a_cpu_and_buffer_storage(void **state)
{
    (void)state;
    pair on;
    char reason[SVO_MESSAGE_BYTES];
    pair_make_any(&on);
    bool is_cpu = on.device->is_cpu;
    bool cpu_path = on.device->cpu_path;
    on.device->is_cpu = false;
    svo_i_share_probe(on.device, on.context, SVO_GL_SHARE_HOST, reason, sizeof reason);
    assert_non_null(strstr(reason, "is not a CPU device"));
    on.device->is_cpu = true;
    on.device->cpu_path = false;
    svo_i_share_probe(on.device, on.context, SVO_GL_SHARE_HOST, reason, sizeof reason);
    assert_non_null(strstr(reason, "takes the path of GPUs"));
    on.device->cpu_path = true;
    on.context->functions.BufferStorage = NULL;
    svo_i_share_probe(on.device, on.context, SVO_GL_SHARE_HOST, reason, sizeof reason);
    assert_non_null(strstr(reason, "GL_ARB_buffer_storage"));
    svo_i_share_buffer buffer = {0};
    assert_int_equal(svo_i_share_buffer_create(on.device, on.context, SVO_GL_SHARE_HOST, 64, &buffer), SVO_UNSUPPORTED);
    on.device->is_cpu = is_cpu;
    on.device->cpu_path = cpu_path;
    pair_release(&on);
}

/* A compute program that writes a value computed from index and salt to each word of storage block 0. */
static GLuint pattern_program(const svo_i_gl_functions *gl)
{
    static const char *const source = "#version 430 core\n"
                                      "layout(local_size_x = 64) in;\n"
                                      "layout(std430, binding = 0) writeonly buffer Words { uint words[]; };\n"
                                      "uniform uint salt;\n"
                                      "void main() {\n"
                                      "    uint i = gl_GlobalInvocationID.x;\n"
                                      "    if (i < uint(words.length())) words[i] = (i ^ salt) * 2654435761u;\n"
                                      "}\n";
    GLuint shader = gl->CreateShader(GL_COMPUTE_SHADER), program = gl->CreateProgram();
    GLint linked = 0;
    gl->ShaderSource(shader, 1, &source, NULL);
    gl->CompileShader(shader);
    gl->AttachShader(program, shader);
    gl->LinkProgram(program);
    gl->DeleteShader(shader);
    gl->GetProgramiv(program, GL_LINK_STATUS, &linked);
    assert_true(linked);
    return program;
}

static void check_pattern(cl_command_queue queue, cl_mem memory, cl_uint salt)
{
    cl_uint *words = malloc(SHARE_WORDS * sizeof *words);
    assert_non_null(words);
    assert_int_equal(clEnqueueReadBuffer(queue, memory, CL_TRUE, 0, SHARE_WORDS * sizeof *words, words, 0, NULL, NULL),
                     CL_SUCCESS);
    for (cl_uint i = 0; i < SHARE_WORDS; ++i) {
        if (words[i] != (i ^ salt) * 2654435761u) {
            fail_msg("salt %u, word %u is 0x%08x and should be 0x%08x", salt, i, words[i], (i ^ salt) * 2654435761u);
        }
    }
    free(words);
}

static void check_round_trips(const pair *on, svo_gl_share share)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(on->context);
    svo_i_share_buffer buffer = {0};
    size_t bytes = SHARE_WORDS * sizeof(cl_uint);
    if (svo_i_share_buffer_create(on->device, on->context, share, bytes, &buffer) != SVO_OK) {
        fail_msg("%s", svo_device_message(on->device));
    }
    make_current(on->context);
    GLuint program = pattern_program(gl);
    for (cl_uint salt = 1; salt <= SHARE_ROUNDS; ++salt) {
        assert_int_equal(svo_i_share_buffer_to_gl(&buffer, on->queue), SVO_OK);
        gl->UseProgram(program);
        gl->Uniform1ui(gl->GetUniformLocation(program, "salt"), salt);
        svo_i_share_buffer_bind(&buffer, 0);
        gl->DispatchCompute((SHARE_WORDS + 63) / 64, 1, 1);
        if (svo_i_share_buffer_to_cl(&buffer, bytes, on->queue) != SVO_OK) {
            fail_msg("%s", svo_device_message(on->device));
        }
        check_pattern(on->queue, buffer.memory, salt);
    }
    gl->DeleteProgram(program);
    svo_i_gl_context_release_current(on->context);
    svo_i_share_buffer_destroy(&buffer);
}

static void check_kind_shares(svo_gl_context_kind kind)
{
    pair on;
    char reason[SVO_MESSAGE_BYTES];
    pair_make(&on, kind);
    check_round_trips(&on, SVO_GL_SHARE_COPY);
    svo_i_share_probe(on.device, on.context, SVO_GL_SHARE_HOST, reason, sizeof reason);
    if (reason[0] == '\0') {
        check_round_trips(&on, SVO_GL_SHARE_HOST);
    } else {
        print_message("no host share: %s\n", reason);
    }
    pair_release(&on);
}

static void surfaceless_shares_bytes_with_opencl(void **state)
{
    (void)state;
    check_kind_shares(SVO_GL_SURFACELESS);
}

static void egl_device_shares_bytes_with_opencl(void **state)
{
    (void)state;
    check_kind_shares(SVO_GL_EGL_DEVICE);
}

static void osmesa_shares_bytes_with_opencl(void **state)
{
    (void)state;
    check_kind_shares(SVO_GL_OSMESA);
}

static void shared_buffer_above_a_limit_is_refused(void **state)
{
    (void)state;
    pair on;
    svo_i_share_buffer buffer = {0};
    pair_make_any(&on);
    on.context->functions.limits.storage_block_bytes = 4096;
    assert_int_equal(svo_i_share_buffer_create(on.device, on.context, SVO_GL_SHARE_COPY, 4097, &buffer),
                     SVO_OUT_OF_DEVICE_MEMORY);
    assert_non_null(strstr(svo_device_message(on.device), "4097 bytes are above OpenGL's storage block limit of 4096"));
    assert_int_equal(svo_i_share_limit_bytes(on.device, on.context), 4096);
    on.device->max_allocation_bytes = 1024;
    assert_int_equal(svo_i_share_buffer_create(on.device, on.context, SVO_GL_SHARE_COPY, 1025, &buffer),
                     SVO_OUT_OF_DEVICE_MEMORY);
    assert_non_null(strstr(svo_device_message(on.device), "1025 bytes are above OpenCL's allocation limit of 1024"));
    assert_int_equal(svo_i_share_limit_bytes(on.device, on.context), 1024);
    assert_int_equal(svo_i_share_buffer_create(on.device, on.context, SVO_GL_SHARE_COPY, 0, &buffer),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_i_share_buffer_create(on.device, on.context, SVO_GL_SHARE_INTEROP, 64, &buffer),
                     SVO_UNSUPPORTED);
    assert_int_equal(buffer.name, 0);
    pair_release(&on);
}

static void shared_buffer_is_handed_over_in_turns(void **state)
{
    (void)state;
    pair on;
    char reason[SVO_MESSAGE_BYTES];
    svo_i_share_buffer buffer = {0};
    pair_make_any(&on);
    svo_i_share_probe(on.device, on.context, SVO_GL_SHARE_HOST, reason, sizeof reason);
    if (reason[0] != '\0') {
        print_message("skipped: no host share: %s\n", reason);
        pair_release(&on);
        skip();
    }
    assert_int_equal(svo_i_share_buffer_create(on.device, on.context, SVO_GL_SHARE_HOST, 1000, &buffer), SVO_OK);
    assert_int_equal(svo_i_share_buffer_to_cl(&buffer, 1000, on.queue), SVO_INTERNAL);
    assert_int_equal(svo_i_share_buffer_to_gl(&buffer, on.queue), SVO_OK);
    assert_int_equal(svo_i_share_buffer_to_cl(&buffer, 1001, on.queue), SVO_INTERNAL);
    assert_int_equal(svo_i_share_buffer_to_gl(&buffer, on.queue), SVO_OK);
    svo_i_share_buffer_destroy(&buffer); /* while OpenGL has it */
    svo_i_share_buffer_destroy(&buffer);
    pair_release(&on);
}

TEST_GROUP(context)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaceless_context_is_created),
        cmocka_unit_test(egl_device_context_is_created),
        cmocka_unit_test(osmesa_context_is_created),
        cmocka_unit_test(wrong_device_index_is_refused),
        cmocka_unit_test(software_is_known_without_a_context),
        cmocka_unit_test(egl_devices_are_found_by_name),
        cmocka_unit_test(context_for_a_device_is_the_best),
        cmocka_unit_test(gpu_is_never_a_processor),
        cmocka_unit_test(software_in_place_of_a_gpu_is_refused),
        cmocka_unit_test(contradicting_options_are_refused),
        cmocka_unit_test(no_options_are_the_defaults),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(contexts_outlive_each_other),
        cmocka_unit_test(release_restores_what_was_current),
        cmocka_unit_test(nesting_has_a_limit),
        cmocka_unit_test(threads_do_not_disturb_each_other),
        cmocka_unit_test(extensions_are_compared_as_whole_words),
        cmocka_unit_test(missing_function_is_named),
        cmocka_unit_test(old_version_is_refused),
        cmocka_unit_test(optional_functions_need_a_promise),
        cmocka_unit_test(errors_are_named_once),
        cmocka_unit_test(share_paths_are_probed_with_reasons),
        cmocka_unit_test(host_share_needs_a_cpu_and_buffer_storage),
        cmocka_unit_test(surfaceless_shares_bytes_with_opencl),
        cmocka_unit_test(egl_device_shares_bytes_with_opencl),
        cmocka_unit_test(osmesa_shares_bytes_with_opencl),
        cmocka_unit_test(shared_buffer_above_a_limit_is_refused),
        cmocka_unit_test(shared_buffer_is_handed_over_in_turns),
    };
    return cmocka_run_group_tests_name("context", tests, NULL, NULL);
}
