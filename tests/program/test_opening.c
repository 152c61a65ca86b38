/* SPDX-License-Identifier: MIT */
/*
 * What the program opens, in which order, over invented machines: the OpenCL device, then contexts of OpenGL only where
 * they may be needed, GPUs of EGL first and what draws on a CPU last, then the device again on an OpenCL context that
 * shares with the GPU that clGetGLContextInfoKHR says is the device.
 */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "invented_gpus.h"
#include "support/session.h"
#include "support/suite.h"
#include "support/work_folder.h"

/* How the builds of a command get their front end. */
typedef enum choice { BY_OPTIONS, FOR_SMALL_PLAN, FOR_LARGE_PLAN, OPENGL_IF_ANY, WITH_BOTH } choice;

typedef struct opening {
    const char *name;
    const invented_gpus *machine;
    choice how;
    options given; /* context 0 is SVO_GL_SURFACELESS, so is_forced says whether it counts */
    bool is_forced, has_devices; /* has_devices: the program makes handles of devices itself, as the viewer does */
    const char *log;
    const char *context; /* of the builds; NULL: the command fails */
} opening;

#define LLVMPIPE "llvmpipe (LLVM 15.0.6, 256 bits)"
#define SOFTWARE          \
    {                     \
        LLVMPIPE, 0, true \
    }
#define NONE           \
    {                  \
        NULL, 0, false \
    }

static const invented_gpus
    /* PoCL and llvmpipe. */
    plain = {.egl = {SOFTWARE},
             .egl_count = 1,
             .surfaceless = {LLVMPIPE, 0, false},
             .osmesa = {LLVMPIPE, 0, false},
             .device = "cpu"},
    no_opengl = {.egl = {NONE}, .egl_count = 0, .surfaceless = NONE, .osmesa = NONE, .device = "cpu"},
    /* A driver beside Mesa's, whose surfaceless platform draws on the CPU. */
    one_gpu = {.egl = {SOFTWARE, {"RTX/PCIe", 'A', false}},
               .egl_count = 2,
               .surfaceless = {LLVMPIPE, 0, false},
               .osmesa = {LLVMPIPE, 0, false},
               .device = "RTX",
               .gpu = 'A',
               .lists_sharing = true},
    without_sharing = {.egl = {SOFTWARE, {"RTX/PCIe", 'A', false}},
                       .egl_count = 2,
                       .surfaceless = {LLVMPIPE, 0, false},
                       .osmesa = {LLVMPIPE, 0, false},
                       .device = "RTX",
                       .gpu = 'A'},
    /* Two of one name, of which OpenCL has taken the second. */
    twins = {.egl = {{"RTX/PCIe", 'A', false}, {"RTX/PCIe", 'B', false}, SOFTWARE},
             .egl_count = 3,
             .surfaceless = {"RTX/PCIe", 'A', false},
             .osmesa = {LLVMPIPE, 0, false},
             .device = "RTX",
             .gpu = 'B',
             .lists_sharing = true},
    three = {.egl = {{"Arc", 'A', false}, {"Radeon", 'B', false}, {"RTX/PCIe", 'C', false}},
             .egl_count = 3,
             .surfaceless = {"Arc", 'A', false},
             .osmesa = NONE,
             .device = "RTX",
             .gpu = 'C'},
    /* A GPU for computing alone beside one that draws. */
    elsewhere = {.egl = {{"Arc", 'A', false}, SOFTWARE},
                 .egl_count = 2,
                 .surfaceless = {"Arc", 'A', false},
                 .osmesa = {LLVMPIPE, 0, false},
                 .device = "H200",
                 .gpu = 'C',
                 .lists_sharing = true},
    refuses = {.egl = {{"RTX/PCIe", 'A', false}},
               .egl_count = 1,
               .surfaceless = NONE,
               .osmesa = NONE,
               .device = "RTX",
               .gpu = 'A',
               .lists_sharing = true,
               .refuses_context = true},
    broken = {.egl = {{"RTX/PCIe", 'A', false}},
              .egl_count = 1,
              .surfaceless = NONE,
              .osmesa = NONE,
              .device = "RTX",
              .gpu = 'A',
              .lists_sharing = true,
              .refuses_front_end = true};

static const opening openings[] = {
    /* OpenGL is not started where OpenCL is sure to be faster. */
    {.name = "a CPU, no plan yet", .machine = &plain, .how = BY_OPTIONS, .log = "device queue cl", .context = "none"},
    {.name = "a CPU, a small plan",
     .machine = &plain,
     .how = FOR_SMALL_PLAN,
     .log = "device queue cl",
     .context = "none"},
    {.name = "a CPU, a large plan",
     .machine = &plain,
     .how = FOR_LARGE_PLAN,
     .log = "device queue cl",
     .context = "none"},
    {.name = "--frontend cl on a GPU",
     .machine = &one_gpu,
     .how = FOR_LARGE_PLAN,
     .given = {.frontend = OPTION_FRONTEND_CL},
     .log = "device queue cl",
     .context = "none"},
    {.name = "a GPU that cannot share, a small plan",
     .machine = &without_sharing,
     .how = FOR_SMALL_PLAN,
     .log = "device queue cl",
     .context = "none"},
    /* Software where nothing else is, and OSMesa after it. */
    {.name = "--frontend gl-expand on a CPU",
     .machine = &plain,
     .how = BY_OPTIONS,
     .given = {.frontend = OPTION_FRONTEND_GL_EXPAND},
     .log = "device queue surfaceless gl",
     .context = "surfaceless"},
    {.name = "OpenGL if any, on a CPU",
     .machine = &plain,
     .how = OPENGL_IF_ANY,
     .log = "device queue cl surfaceless gl",
     .context = "surfaceless"},
    {.name = "--context osmesa",
     .machine = &one_gpu,
     .how = BY_OPTIONS,
     .is_forced = true,
     .given = {.context = SVO_GL_OSMESA},
     .log = "device queue osmesa device -device gl",
     .context = "osmesa"},
    {.name = "--gl-device 0 where 1 is the device",
     .machine = &one_gpu,
     .how = BY_OPTIONS,
     .given = {.gl_device = "0", .frontend = OPTION_FRONTEND_GL_EXPAND},
     .log = "device queue egl0 device -device gl",
     .context = "egl-device"},
    /* What may share is opened before anything is made on the device. */
    {.name = "a GPU beside llvmpipe",
     .machine = &one_gpu,
     .how = FOR_LARGE_PLAN,
     .log = "device queue egl1 device device@egl1 -device -queue -device queue cl gl",
     .context = "egl-device"},
    {.name = "a GPU beside llvmpipe, a small plan",
     .machine = &one_gpu,
     .how = FOR_SMALL_PLAN,
     .log = "device queue egl1 device device@egl1 -device -queue -device queue cl",
     .context = "none"},
    {.name = "--frontend gl-hw",
     .machine = &one_gpu,
     .how = BY_OPTIONS,
     .given = {.frontend = OPTION_FRONTEND_GL_HW},
     .log = "device queue egl1 device device@egl1 -device -queue -device queue gl",
     .context = "egl-device"},
    {.name = "the second of two",
     .machine = &twins,
     .how = WITH_BOTH,
     .log = "device queue egl0 egl1 -egl0 device device@egl1 -device -queue -device queue gl cl",
     .context = "egl-device"},
    {.name = "the second of two, for a large plan",
     .machine = &twins,
     .how = FOR_LARGE_PLAN,
     .log = "device queue egl0 egl1 -egl0 device device@egl1 -device -queue -device queue cl gl",
     .context = "egl-device"},
    /* The viewer's device is on the window's context already. */
    {.name = "the viewer",
     .machine = &twins,
     .how = FOR_SMALL_PLAN,
     .has_devices = true,
     .log = "device queue cl",
     .context = "none"},
    /* Without sharing a name decides, and the device stays as it is. */
    {.name = "a GPU of three, by its name",
     .machine = &three,
     .how = FOR_LARGE_PLAN,
     .log = "device queue cl egl0 egl1 egl2 -egl0 -egl1 gl",
     .context = "egl-device"},
    {.name = "no context of this GPU",
     .machine = &elsewhere,
     .how = FOR_LARGE_PLAN,
     .log = "device queue egl0 surfaceless -surfaceless device -device cl gl",
     .context = "egl-device"},
    {.name = "a driver that then refuses",
     .machine = &refuses,
     .how = FOR_LARGE_PLAN,
     .log = "device queue egl0 device -device cl gl",
     .context = "egl-device"},
    /* Failures: of what was asked for, an error; else OpenCL alone. */
    {.name = "no OpenGL",
     .machine = &no_opengl,
     .how = OPENGL_IF_ANY,
     .log = "device queue cl surfaceless osmesa",
     .context = "none"},
    {.name = "no OpenGL, and both",
     .machine = &no_opengl,
     .how = WITH_BOTH,
     .log = "device queue surfaceless osmesa cl",
     .context = "none"},
    {.name = "no OpenGL, and --frontend gl-expand",
     .machine = &no_opengl,
     .how = BY_OPTIONS,
     .given = {.frontend = OPTION_FRONTEND_GL_EXPAND},
     .log = "device queue surfaceless osmesa -queue -device"},
    {.name = "no front end of OpenGL works",
     .machine = &broken,
     .how = FOR_LARGE_PLAN,
     .log = "device queue egl0 device device@egl0 -device -queue -device queue cl gl",
     .context = "none"},
    {.name = "no front end of OpenGL works, and --frontend gl-hw",
     .machine = &broken,
     .how = BY_OPTIONS,
     .given = {.frontend = OPTION_FRONTEND_GL_HW},
     .log = "device queue egl0 device device@egl0 -device -queue -device queue gl -queue -device@egl0 -egl0"},
};

static svo_status make_device(void *user, const svo_device_options *device_options, svo_device **out,
                              svo_message *message)
{
    (void)user;
    return svo_device_create_default(device_options, out, message);
}

static int open_session(const opening *asked, session *opened)
{
    static char large_plan; /* of which nothing is read */
    program state = {.command = "test", .options = asked->given};
    if (!asked->is_forced) {
        state.options.context = OPTION_CONTEXT_AUTO;
    }
    if (asked->has_devices) {
        state.devices.create = make_device;
    }
    const int result = asked->how == WITH_BOTH ? session_open_both(&state, opened) : session_open(&state, opened);
    if (result == PROGRAM_DONE && (asked->how == FOR_SMALL_PLAN || asked->how == FOR_LARGE_PLAN)) {
        session_choose(&state, opened,
                       asked->how == FOR_LARGE_PLAN ? (const svo_plan *)(const void *)&large_plan : NULL);
        assert_non_null(opened->frontend);
    } else if (result == PROGRAM_DONE && asked->how == OPENGL_IF_ANY) {
        session_choose_opengl(&state, opened);
    }
    return result;
}

static void check(const opening *asked)
{
    session opened = {0};
    invented_begin(asked->machine);
    const int result = open_session(asked, &opened);
    if (strcmp(invented_log(), asked->log) != 0) {
        fail_msg("%s: \"%s\", expected \"%s\"", asked->name, invented_log(), asked->log);
        return;
    }
    assert_int_equal(result == PROGRAM_DONE, asked->context != NULL);
    if (result == PROGRAM_DONE) {
        if (strcmp(session_context(&opened), asked->context) != 0) {
            fail_msg("%s: %s, expected %s", asked->name, session_context(&opened), asked->context);
            return;
        }
        session_close(&opened);
    }
    invented_check_closed();
}

static void the_program_opens_what_it_needs_in_order(void **state)
{
    (void)state;
    unsetenv("XDG_CACHE_HOME"); /* no folder of saved kernels */
    unsetenv("HOME");
    for (size_t i = 0; i < sizeof openings / sizeof openings[0]; ++i) {
        check(&openings[i]);
    }
}

/* What --tune has kept for the pair decides; lines of other pairs, and what is none, do not. */
static void kept_thresholds_are_used(void **state)
{
    static const struct {
        const char *kept, *end;
    } cases[] = {
        {"64\tInvented: RTX\t1.2\tRTX/PCIe\n", " gl hybrid64"},
        {"8\tInvented: RTX\t1.1\tRTX/PCIe\n4096\tInvented: RTX\t1.2\tRTX/PCIe\n", " gl hybrid4096"},
        {"4294967295\tInvented: RTX\t1.2\tRTX/PCIe\n", " gl"},
        {"8\tInvented: RTX\t1.2\tRTX/PCIe of another\n\n\t\n-1\tInvented: RTX\t1.2\tRTX/PCIe\n", " gl"},
        {"0\tInvented: RTX\t1.2\tRTX/PCIe\n8 \tInvented: RTX\t1.2\tRTX/PCIe\n8\tInvented: RTX\t1.2\tRTX/PCIe", " gl"},
    };
    (void)state;
    assert_int_equal(setenv("XDG_CACHE_HOME", work_folder(), 1), 0);
    assert_int_equal(mkdir(path_of("svocl"), 0700), 0);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        session opened = {0};
        opening asked = {.machine = &one_gpu, .how = FOR_LARGE_PLAN};
        write_text("svocl/hybrid", cases[i].kept);
        invented_begin(asked.machine);
        assert_int_equal(open_session(&asked, &opened), PROGRAM_DONE);
        const char *log = invented_log();
        const char *front_ends = strstr(log, " cl");
        assert_non_null(front_ends);
        assert_string_equal(front_ends + 3, cases[i].end);
        assert_int_equal(opened.frontend == opened.cl, i == 2);
        session_close(&opened);
        invented_check_closed();
    }
    assert_int_equal(unlink(path_of("svocl/hybrid")), 0);
    assert_int_equal(rmdir(path_of("svocl")), 0);
}

TEST_GROUP(opening)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_program_opens_what_it_needs_in_order),
                                       cmocka_unit_test(kept_thresholds_are_used)};
    return cmocka_run_group_tests_name("opening", tests, work_folder_make, work_folder_remove);
}
