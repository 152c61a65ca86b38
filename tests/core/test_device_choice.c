/* SPDX-License-Identifier: MIT */
/*
 * Which device svo_device_create_default takes. The linker routes the loader's calls to invented platforms, so every
 * mix of devices is there; making a context fails, and says of which device it was to be.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "support/suite.h"
#include "svocl/svocl.h"

enum { DEVICES_MAX = 4, PLATFORMS_MAX = 2 };

typedef struct invented_device {
    const char *name;
    cl_device_type type;
    cl_uint compute_units;
    bool is_missing; /* not available */
    bool shares_memory;
    bool hides_memory; /* does not say whether it shares memory */
    bool is_broken; /* answers nothing */
} invented_device;

typedef struct invented_machine {
    const invented_device *devices[PLATFORMS_MAX][DEVICES_MAX]; /* NULL: no more */
    const char *wanted; /* svo_device_options.device_name */
    const invented_device *chosen;
} invented_machine;

static const invented_machine *machine;
static const invented_device *asked; /* for a context */

/* Handles of devices point to them, handles of platforms to their rows of the machine. */

/* NOLINTBEGIN(readability-identifier-naming) */
cl_int __wrap_clGetPlatformIDs(cl_uint room, cl_platform_id *platforms, cl_uint *count);
cl_int __wrap_clGetDeviceIDs(cl_platform_id platform, cl_device_type type, cl_uint room, cl_device_id *devices,
                             cl_uint *count);
cl_int __wrap_clGetPlatformInfo(cl_platform_id platform, cl_platform_info what, size_t bytes, void *value,
                                size_t *needed);
cl_int __wrap_clGetDeviceInfo(cl_device_id device, cl_device_info what, size_t bytes, void *value, size_t *needed);
cl_context __wrap_clCreateContext(const cl_context_properties *properties, cl_uint count, const cl_device_id *devices,
                                  void(CL_CALLBACK *notify)(const char *, const void *, size_t, void *), void *user,
                                  cl_int *error);

static cl_int answer(const void *from, size_t from_bytes, size_t bytes, void *value, size_t *needed)
{
    if (needed != NULL) {
        *needed = from_bytes;
    }
    if (value != NULL) {
        assert_true(bytes >= from_bytes);
        memcpy(value, from, from_bytes);
    }
    return CL_SUCCESS;
}

cl_int __wrap_clGetPlatformIDs(cl_uint room, cl_platform_id *platforms, cl_uint *count)
{
    for (cl_uint i = 0; platforms != NULL && i < room && i < PLATFORMS_MAX; ++i) {
        platforms[i] = (cl_platform_id)(uintptr_t)machine->devices[i];
    }
    if (count != NULL) {
        *count = PLATFORMS_MAX;
    }
    return CL_SUCCESS;
}

cl_int __wrap_clGetDeviceIDs(cl_platform_id platform, cl_device_type type, cl_uint room, cl_device_id *devices,
                             cl_uint *count)
{
    const invented_device *const *of_platform = (const invented_device *const *)(uintptr_t)platform;
    cl_uint there = 0;
    assert_true(type == CL_DEVICE_TYPE_ALL);
    for (; there < DEVICES_MAX && of_platform[there] != NULL; ++there) {
        if (devices != NULL && there < room) {
            devices[there] = (cl_device_id)(uintptr_t)of_platform[there];
        }
    }
    if (count != NULL) {
        *count = there;
    }
    return there > 0 ? CL_SUCCESS : CL_DEVICE_NOT_FOUND;
}

cl_int __wrap_clGetPlatformInfo(cl_platform_id platform, cl_platform_info what, size_t bytes, void *value,
                                size_t *needed)
{
    (void)platform;
    assert_int_equal(what, CL_PLATFORM_NAME);
    return answer("Invented", sizeof "Invented", bytes, value, needed);
}

cl_int __wrap_clGetDeviceInfo(cl_device_id device, cl_device_info what, size_t bytes, void *value, size_t *needed)
{
    const invented_device *of = (const invented_device *)(uintptr_t)device;
    const cl_bool available = of->is_missing ? CL_FALSE : CL_TRUE;
    const cl_bool shares = of->shares_memory ? CL_TRUE : CL_FALSE;
    const cl_platform_id platform = (cl_platform_id)(uintptr_t)machine->devices[0];
    if (of->is_broken || (of->hides_memory && what == CL_DEVICE_HOST_UNIFIED_MEMORY)) {
        return CL_INVALID_VALUE;
    }
    switch (what) {
    case CL_DEVICE_NAME:
        return answer(of->name, strlen(of->name) + 1, bytes, value, needed);
    case CL_DEVICE_TYPE:
        return answer(&of->type, sizeof of->type, bytes, value, needed);
    case CL_DEVICE_MAX_COMPUTE_UNITS:
        return answer(&of->compute_units, sizeof of->compute_units, bytes, value, needed);
    case CL_DEVICE_AVAILABLE:
        return answer(&available, sizeof available, bytes, value, needed);
    case CL_DEVICE_HOST_UNIFIED_MEMORY:
        return answer(&shares, sizeof shares, bytes, value, needed);
    case CL_DEVICE_PLATFORM:
        return answer(&platform, sizeof(cl_platform_id), bytes, value, needed);
    default:
        return CL_INVALID_VALUE;
    }
}

cl_context __wrap_clCreateContext(const cl_context_properties *properties, cl_uint count, const cl_device_id *devices,
                                  void(CL_CALLBACK *notify)(const char *, const void *, size_t, void *), void *user,
                                  cl_int *error)
{
    (void)properties;
    (void)notify;
    (void)user;
    assert_int_equal(count, 1);
    asked = (const invented_device *)(uintptr_t)devices[0];
    *error = CL_DEVICE_NOT_AVAILABLE;
    return NULL;
}
/* NOLINTEND(readability-identifier-naming) */

static const invented_device
    cpu = {.name = "cpu", .type = CL_DEVICE_TYPE_CPU, .compute_units = 64, .shares_memory = true},
    small_cpu = {.name = "small", .type = CL_DEVICE_TYPE_CPU, .compute_units = 2, .shares_memory = true},
    integrated = {.name = "integrated", .type = CL_DEVICE_TYPE_GPU, .compute_units = 96, .shares_memory = true},
    discrete = {.name = "discrete", .type = CL_DEVICE_TYPE_GPU, .compute_units = 20},
    large = {.name = "large", .type = CL_DEVICE_TYPE_GPU, .compute_units = 132},
    twin = {.name = "twin", .type = CL_DEVICE_TYPE_GPU, .compute_units = 132},
    gone = {.name = "gone", .type = CL_DEVICE_TYPE_GPU, .compute_units = 132, .is_missing = true},
    broken = {.name = "broken", .type = CL_DEVICE_TYPE_GPU, .compute_units = 132, .is_broken = true},
    silent = {.name = "silent", .type = CL_DEVICE_TYPE_GPU, .compute_units = 16, .hides_memory = true};

static const invented_machine machines[] = {
    {{{&cpu}}, NULL, &cpu},
    {{{&cpu}, {&integrated}}, NULL, &integrated},
    /* Integrated GPUs count small units: their number decides only among equals. */
    {{{&integrated}, {&cpu, &discrete}}, NULL, &discrete},
    {{{&discrete, &integrated}}, NULL, &discrete},
    /* The largest of several, wherever it is listed; of equals the first. */
    {{{&discrete, &large, &twin}, {&discrete}}, NULL, &large},
    {{{&discrete}, {&twin, &large}}, NULL, &twin},
    {{{&small_cpu, &cpu}}, NULL, &cpu},
    /* What is not available is taken only where nothing else matches. */
    {{{&gone, &integrated}}, NULL, &integrated},
    {{{&cpu}, {&gone}}, NULL, &cpu},
    {{{&gone}, {&cpu}}, "gone", &gone},
    /* One that answers nothing is passed over; one that says nothing of its memory counts as having its own. */
    {{{&broken, &cpu}}, NULL, &cpu},
    {{{&integrated, &silent}}, NULL, &silent},
    /* Names and indices come before all of that. */
    {{{&discrete, &cpu}}, "CPU", &cpu},
    {{{&discrete}, {&cpu, &integrated}}, "1.0", &cpu},
    {{{&discrete, &gone}}, "0.1", &gone},
    {{{&integrated, &discrete}}, "Invented: ", &discrete},
};

static void the_best_device_is_taken(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof machines / sizeof machines[0]; ++i) {
        const svo_device_options options = {.struct_size = sizeof options, .device_name = machines[i].wanted};
        svo_device *device = NULL;
        svo_message message = {""};
        machine = &machines[i];
        asked = NULL;
        assert_int_equal(svo_device_create_default(&options, &device, &message), SVO_CL_ERROR);
        if (asked != machines[i].chosen) {
            fail_msg("machine %zu: %s, expected %s; \"%s\"", i, asked != NULL ? asked->name : "none",
                     machines[i].chosen->name, message.text);
            return;
        }
    }
}

TEST_GROUP(device_choice)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_best_device_is_taken)};
    return cmocka_run_group_tests_name("device_choice", tests, NULL, NULL);
}
