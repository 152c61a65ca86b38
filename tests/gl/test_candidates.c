/* SPDX-License-Identifier: MIT */
/*
 * Which OpenGL context a program gets for an OpenCL device, over invented machines: what is tried in which order, what
 * is taken, what is not even tried, and which EGL devices promise a GPU.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "share/candidates.h"
#include "support/suite.h"

enum { DEVICES_MAX = 4, TRIED_BYTES = 64 };

/*
 * What contexts on a machine would be: - there is none, c a CPU draws, g a GPU, n one of the device's name, x one that
 * OpenCL says is the device. C: EGL says of its device, without a context, that a CPU draws.
 */
typedef struct invented_machine {
    const char *name;
    const char *egl_devices; /* by index */
    char surfaceless, osmesa;
    char most; /* of the OpenCL device: x it lists cl_khr_gl_sharing, n it is another GPU, g it is a CPU */
    const char *tried; /* in this order: device indices, s for surfaceless, o for OSMesa */
    const char *chosen; /* one of them, or "" */
} invented_machine;

static const invented_machine machines[] = {
    {"llvmpipe alone", "C", 'c', 'c', 'g', "s", "s"},
    {"llvmpipe without its surfaceless platform", "C", '-', 'c', 'g', "s0", "0"},
    {"OSMesa alone", "", '-', 'c', 'g', "so", "o"},
    {"no OpenGL", "", '-', '-', 'x', "so", ""},
    {"an EGL that does not list devices", "", 'g', 'c', 'g', "s", "s"},
    {"a driver beside Mesa's", "Cx", 'c', 'c', 'x', "1", "1"},
    {"the same without sharing", "nC", 'c', 'c', 'n', "0", "0"},
    {"the same where sharing is listed but fails", "nC", 'c', 'c', 'x', "0s", "0"},
    {"two GPUs, the second is the device", "gxn", 'c', 'c', 'x', "01", "1"},
    {"two GPUs of other names than the device's", "gg", 'g', 'c', 'n', "01s", "0"},
    {"a name decides where nothing is shared", "gn", 'g', 'c', 'x', "01s", "1"},
    {"a CPU device takes the first GPU", "Cgg", 'c', 'c', 'g', "1", "1"},
    {"a GPU whose node cannot be opened", "-C", 'c', 'c', 'x', "0s", "s"},
    {"software that EGL does not own up to", "cg", 'c', 'c', 'g', "01", "1"},
    {"a GPU on Mesa's platform alone", "-", 'g', 'c', 'n', "0s", "s"},
};

static svo_i_fit fit_of(char letter)
{
    static const char letters[] = "-cgnx"; /* in the order of svo_i_fit */
    const char *at = strchr(letters, letter == 'C' ? 'c' : letter);
    assert_non_null(at);
    return (svo_i_fit)(at - letters);
}

typedef struct run {
    const invented_machine *machine;
    svo_i_candidate candidates[SVO_I_CANDIDATES_MAX];
    char tried[TRIED_BYTES];
} run;

static char letter_of(const svo_i_candidate *candidate)
{
    return candidate->kind == SVO_GL_SURFACELESS ? 's'
           : candidate->kind == SVO_GL_OSMESA    ? 'o'
                                                 : (char)('0' + candidate->device_index);
}

static svo_i_fit fit(void *user, size_t index)
{
    run *r = user;
    const svo_i_candidate *tried = &r->candidates[index];
    const size_t used = strlen(r->tried);
    assert_true(used + 1 < TRIED_BYTES);
    r->tried[used] = letter_of(tried);
    return fit_of(tried->kind == SVO_GL_SURFACELESS ? r->machine->surfaceless
                  : tried->kind == SVO_GL_OSMESA    ? r->machine->osmesa
                                                    : r->machine->egl_devices[tried->device_index]);
}

static void the_best_context_is_taken(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof machines / sizeof machines[0]; ++i) {
        run r = {.machine = &machines[i]};
        bool software[DEVICES_MAX] = {false};
        const uint32_t device_count = (uint32_t)strlen(r.machine->egl_devices);
        for (uint32_t d = 0; d < device_count; ++d) {
            software[d] = r.machine->egl_devices[d] == 'C';
        }
        const size_t count = svo_i_candidates_list(software, device_count, r.candidates);
        const size_t best = svo_i_candidates_choose(r.candidates, count, fit_of(r.machine->most), fit, &r);
        assert_int_equal(count, device_count + 2);
        const char chosen[2] = {best < count ? letter_of(&r.candidates[best]) : '\0', '\0'};
        if (strcmp(r.tried, r.machine->tried) != 0 || strcmp(chosen, r.machine->chosen) != 0) {
            fail_msg("%s: tried \"%s\" and took \"%s\", expected \"%s\" and \"%s\"", r.machine->name, r.tried, chosen,
                     r.machine->tried, r.machine->chosen);
            return;
        }
    }
}

static void there_is_room_for_all(void **state)
{
    (void)state;
    bool software[SVO_I_EGL_DEVICES_MAX + 1] = {false};
    svo_i_candidate candidates[SVO_I_CANDIDATES_MAX];
    assert_int_equal(svo_i_candidates_list(software, SVO_I_EGL_DEVICES_MAX + 1, candidates), SVO_I_CANDIDATES_MAX);
    assert_int_equal(candidates[SVO_I_EGL_DEVICES_MAX].kind, SVO_GL_SURFACELESS);
    assert_int_equal(candidates[SVO_I_CANDIDATES_MAX - 1].kind, SVO_GL_OSMESA);
}

/* EGL devices by what drivers list of them. */
static void extensions_tell_gpus_from_software(void **state)
{
    (void)state;
    static const struct {
        const char *extensions;
        bool is_software, is_gpu;
    } rows[] = {
        {NULL, false, false},
        {"", false, false},
        {"EGL_MESA_device_software", true, false},
        {"EGL_MESA_device_software EGL_EXT_device_drm EGL_EXT_device_drm_render_node", true, false},
        {"EGL_EXT_device_drm EGL_EXT_device_drm_render_node", false, true},
        {"EGL_NV_device_cuda EGL_EXT_device_query_name", false, true},
        {"EGL_EXT_device_persistent_id EGL_EXT_device_drm", false, true},
        {"EGL_EXT_device_drm_render_node", false, false}, /* other words that begin alike */
        {"EGL_NV_device_cuda_more XEGL_EXT_device_drm", false, false},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        const bool is_software = svo_i_egl_device_is_software(rows[i].extensions);
        const bool is_gpu = svo_i_egl_device_is_gpu(rows[i].extensions);
        if (is_software != rows[i].is_software || is_gpu != rows[i].is_gpu) {
            fail_msg("row %zu: software %d, GPU %d; expected %d and %d", i, is_software, is_gpu, rows[i].is_software,
                     rows[i].is_gpu);
            return;
        }
    }
}

TEST_GROUP(candidates)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_best_context_is_taken),
        cmocka_unit_test(there_is_room_for_all),
        cmocka_unit_test(extensions_tell_gpus_from_software),
    };
    return cmocka_run_group_tests_name("candidates", tests, NULL, NULL);
}
