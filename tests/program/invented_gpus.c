/* SPDX-License-Identifier: MIT */
/* Invents devices, contexts and front ends, and notes when each is opened and closed. */
#include "invented_gpus.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <CL/cl_gl.h>
#include <cmocka.h>

#include "commands/frontend.h"
#include "context/context.h"
#include "core/device.h"
#include "svocl/svocl.h"

enum { WORD_BYTES = 32, OPENCL_DEVICES = 2 };

/* A context's place, which is also its display, its platform's own context and the mark of OpenCL contexts. */
typedef struct place {
    char word[WORD_BYTES];
    const invented_renderer *renderer;
    svo_gl_context *open; /* NULL: none */
    unsigned joined; /* OpenCL contexts against it */
} place;

static struct {
    const invented_gpus *machine;
    char log[INVENTED_LOG_BYTES];
    place egl[INVENTED_EGL_MAX], surfaceless, osmesa;
    unsigned devices, queues, front_ends, opencl_contexts, current;
    svo_frontend cl, gl;
} now;

/* What OpenCL handles point to: the first is the machine's, the other one is of a GPU that nobody asks for. */
static char opencl_devices[OPENCL_DEVICES];

/* ---- notes ---- */

static void note(const char *sign, const char *word)
{
    const size_t used = strlen(now.log);
    const int written = snprintf(now.log + used, sizeof now.log - used, "%s%s%s", used > 0 ? " " : "", sign, word);
    assert_true(written > 0 && (size_t)written < sizeof now.log - used);
}

static void name_place(place *out, const char *word, unsigned index, const invented_renderer *renderer)
{
    *out = (place){.renderer = renderer};
    (void)snprintf(out->word, sizeof out->word, word, index);
}

void invented_begin(const invented_gpus *machine)
{
    memset(&now, 0, sizeof now);
    now.machine = machine;
    for (unsigned i = 0; i < machine->egl_count; ++i) {
        name_place(&now.egl[i], "egl%u", i, &machine->egl[i]);
    }
    name_place(&now.surfaceless, "surfaceless", 0, &machine->surfaceless);
    name_place(&now.osmesa, "osmesa", 0, &machine->osmesa);
}

const char *invented_log(void)
{
    return now.log;
}

void invented_forget_log(void)
{
    now.log[0] = '\0';
}

void invented_check_closed(void)
{
    assert_int_equal(now.devices + now.queues + now.front_ends + now.opencl_contexts + now.current, 0);
    assert_null(now.surfaceless.open);
    assert_null(now.osmesa.open);
    for (unsigned i = 0; i < now.machine->egl_count; ++i) {
        assert_null(now.egl[i].open);
    }
}

/* NOLINTBEGIN(readability-identifier-naming) */

/* ---- OpenGL contexts ---- */

svo_status __wrap_svo_i_egl_find_software(bool *software, uint32_t room, uint32_t *count, svo_message *message);
svo_status __wrap_svo_i_egl_count_devices(uint32_t *count, svo_message *message);
int __wrap_svo_gl_egl_is_software(void);
svo_status __wrap_svo_i_gl_context_open(svo_gl_context_kind kind, uint32_t device_index, const svo_i_memory *memory,
                                        svo_gl_context **out, svo_message *message);
void __wrap_svo_gl_context_destroy(svo_gl_context **context);
svo_status __wrap_svo_i_gl_context_make_current(svo_gl_context *context, svo_message *message);
void __wrap_svo_i_gl_context_release_current(svo_gl_context *context);

svo_status __wrap_svo_i_egl_find_software(bool *software, uint32_t room, uint32_t *count, svo_message *message)
{
    (void)message;
    *count = now.machine->egl_count;
    for (uint32_t i = 0; i < *count && i < room; ++i) {
        software[i] = now.machine->egl[i].says_software;
    }
    return SVO_OK;
}

svo_status __wrap_svo_i_egl_count_devices(uint32_t *count, svo_message *message)
{
    (void)message;
    *count = now.machine->egl_count;
    return SVO_OK;
}

int __wrap_svo_gl_egl_is_software(void)
{
    bool all = now.machine->egl_count > 0;
    for (unsigned i = 0; i < now.machine->egl_count; ++i) {
        all = all && now.machine->egl[i].says_software;
    }
    return all;
}

static svo_i_gl_handles handles_of(void *native)
{
    return (svo_i_gl_handles){.system = SVO_I_GL_SYSTEM_EGL, .context = native, .display = native};
}

/* clGetGLContextInfoKHR: the OpenCL devices of the GPU that draws. */
static cl_int CL_API_CALL list_devices(const cl_context_properties *properties, cl_gl_context_info what, size_t bytes,
                                       void *value, size_t *value_bytes)
{
    const place *at = (const place *)(uintptr_t)properties[3];
    const bool is_ours = at->renderer->gpu == now.machine->gpu;
    const cl_device_id found = (cl_device_id)(uintptr_t)&opencl_devices[is_ours ? 0 : 1];
    assert_int_equal(what, CL_DEVICES_FOR_GL_CONTEXT_KHR);
    assert_int_equal(properties[2], CL_GL_CONTEXT_KHR);
    assert_int_equal(now.current, 1);
    assert_true(bytes >= sizeof(cl_device_id));
    memcpy(value, &found, sizeof(cl_device_id));
    *value_bytes = sizeof(cl_device_id);
    return CL_SUCCESS;
}

/* The functions that sharing needs; the others are only looked for. */
static void *CL_API_CALL find_function(cl_platform_id platform, const char *name)
{
    void *address = NULL;
    cl_int (*const listed)(const cl_context_properties *, cl_gl_context_info, size_t, void *, size_t *) = list_devices;
    (void)platform;
    assert_non_null(name);
    memcpy(&address, &listed, sizeof address);
    return address;
}

cl_int __wrap_clGetDeviceInfo(cl_device_id device, cl_device_info what, size_t bytes, void *value, size_t *needed);
cl_int __wrap_clGetContextInfo(cl_context context, cl_context_info what, size_t bytes, void *value, size_t *needed);
cl_context __wrap_clCreateContext(const cl_context_properties *properties, cl_uint count, const cl_device_id *devices,
                                  void(CL_CALLBACK *notify)(const char *, const void *, size_t, void *), void *user,
                                  cl_int *error);
cl_int __wrap_clReleaseContext(cl_context context);

static const svo_i_gl_platform platform = {.handles = handles_of};
static const svo_i_opencl opencl = {.GetDeviceInfo = __wrap_clGetDeviceInfo,
                                    .GetContextInfo = __wrap_clGetContextInfo,
                                    .CreateContext = __wrap_clCreateContext,
                                    .GetExtensionFunctionAddressForPlatform = find_function};

static place *place_of(svo_gl_context_kind kind, uint32_t device_index)
{
    assert_true(kind != SVO_GL_EGL_DEVICE || device_index < now.machine->egl_count);
    return kind == SVO_GL_EGL_DEVICE ? &now.egl[device_index] : kind == SVO_GL_OSMESA ? &now.osmesa : &now.surfaceless;
}

svo_status __wrap_svo_i_gl_context_open(svo_gl_context_kind kind, uint32_t device_index, const svo_i_memory *memory,
                                        svo_gl_context **out, svo_message *message)
{
    place *at = place_of(kind, device_index);
    (void)memory;
    note("", at->word);
    if (at->renderer->name == NULL) {
        return svo_i_fail(message, SVO_NO_GL, "svo_gl_context_create: none here");
    }
    svo_gl_context *context = calloc(1, sizeof *context);
    assert_non_null(context);
    assert_null(at->open);
    *context = (svo_gl_context){
        .kind = kind, .device_index = device_index, .platform = &platform, .native = at, .opencl = &opencl};
    context->functions.renderer = at->renderer->name;
    at->open = context;
    *out = context;
    return SVO_OK;
}

void __wrap_svo_gl_context_destroy(svo_gl_context **context)
{
    if (*context == NULL) {
        return;
    }
    place *at = (*context)->native;
    note("-", at->word);
    assert_ptr_equal(at->open, *context);
    assert_int_equal(at->joined, 0); /* what was made against it ends first */
    at->open = NULL;
    free(*context);
    *context = NULL;
}

svo_status __wrap_svo_i_gl_context_make_current(svo_gl_context *context, svo_message *message)
{
    (void)message;
    assert_non_null(((const place *)context->native)->open);
    ++now.current;
    return SVO_OK;
}

void __wrap_svo_i_gl_context_release_current(svo_gl_context *context)
{
    (void)context;
    --now.current;
}

/* ---- OpenCL: a context is the place that it shares with, or the machine ---- */

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

cl_int __wrap_clGetDeviceInfo(cl_device_id device, cl_device_info what, size_t bytes, void *value, size_t *needed)
{
    static const char with[] = "cl_khr_fp64 cl_khr_gl_sharing";
    static const char without[] = "cl_khr_fp64 cl_khr_gl_sharing_more";
    const cl_platform_id platform_id = (cl_platform_id)(uintptr_t)&opencl_devices[1];
    assert_ptr_equal(device, &opencl_devices[0]);
    if (what == CL_DEVICE_PLATFORM) {
        return answer(&platform_id, sizeof(cl_platform_id), bytes, value, needed);
    }
    if (what == CL_DRIVER_VERSION) {
        return answer("1.2", sizeof "1.2", bytes, value, needed);
    }
    assert_int_equal(what, CL_DEVICE_EXTENSIONS);
    return now.machine->lists_sharing ? answer(with, sizeof with, bytes, value, needed)
                                      : answer(without, sizeof without, bytes, value, needed);
}

static place *shared_by(cl_context context)
{
    return (void *)context == (const void *)now.machine ? NULL : (place *)(void *)context;
}

cl_int __wrap_clGetContextInfo(cl_context context, cl_context_info what, size_t bytes, void *value, size_t *needed)
{
    const place *at = shared_by(context);
    const cl_context_properties none[] = {0};
    const cl_context_properties shared[] = {CL_GL_CONTEXT_KHR, (cl_context_properties)(uintptr_t)at, 0};
    assert_int_equal(what, CL_CONTEXT_PROPERTIES);
    return at != NULL ? answer(shared, sizeof shared, bytes, value, needed)
                      : answer(none, sizeof none, bytes, value, needed);
}

cl_context __wrap_clCreateContext(const cl_context_properties *properties, cl_uint count, const cl_device_id *devices,
                                  void(CL_CALLBACK *notify)(const char *, const void *, size_t, void *), void *user,
                                  cl_int *error)
{
    place *at = properties != NULL ? (place *)(uintptr_t)properties[3] : NULL;
    (void)notify;
    (void)user;
    assert_int_equal(count, 1);
    assert_ptr_equal(devices[0], &opencl_devices[0]);
    if (at != NULL && now.machine->refuses_context) {
        *error = CL_INVALID_GL_SHAREGROUP_REFERENCE_KHR;
        return NULL;
    }
    ++now.opencl_contexts;
    *error = CL_SUCCESS;
    return at != NULL ? (cl_context)(void *)at : (cl_context)(uintptr_t)now.machine;
}

cl_int __wrap_clReleaseContext(cl_context context)
{
    (void)context;
    --now.opencl_contexts;
    return CL_SUCCESS;
}

/* ---- handles of the OpenCL device ---- */

svo_status __wrap_svo_device_create(cl_context context, cl_device_id id, const svo_device_options *options,
                                    svo_device **out, svo_message *message);
svo_status __wrap_svo_device_create_default(const svo_device_options *options, svo_device **out, svo_message *message);
void __wrap_svo_device_destroy(svo_device **device);
cl_command_queue __wrap_clCreateCommandQueue(cl_context context, cl_device_id device,
                                             cl_command_queue_properties properties, cl_int *error);
cl_int __wrap_clReleaseCommandQueue(cl_command_queue queue);

static void note_device(const char *sign, const place *at)
{
    char word[WORD_BYTES * 2];
    (void)snprintf(word, sizeof word, "device%s%s", at != NULL ? "@" : "", at != NULL ? at->word : "");
    note(sign, word);
}

svo_status __wrap_svo_device_create(cl_context context, cl_device_id id, const svo_device_options *options,
                                    svo_device **out, svo_message *message)
{
    static char name[64];
    place *at = shared_by(context);
    svo_device *device = calloc(1, sizeof *device);
    (void)options;
    (void)message;
    assert_non_null(device);
    note_device("", at);
    (void)snprintf(name, sizeof name, "Invented: %s", now.machine->device);
    *device = (svo_device){.context = context, .device = id, .name = name, .is_cpu = now.machine->gpu == 0};
    now.devices += 1;
    if (at != NULL) {
        ++at->joined;
    }
    *out = device;
    return SVO_OK;
}

svo_status __wrap_svo_device_create_default(const svo_device_options *options, svo_device **out, svo_message *message)
{
    return __wrap_svo_device_create((cl_context)(uintptr_t)now.machine, (cl_device_id)(void *)&opencl_devices[0],
                                    options, out, message);
}

void __wrap_svo_device_destroy(svo_device **device)
{
    if (*device == NULL) {
        return;
    }
    place *at = shared_by((*device)->context);
    note_device("-", at);
    now.devices -= 1;
    if (at != NULL) {
        --at->joined;
    }
    free(*device);
    *device = NULL;
}

cl_command_queue __wrap_clCreateCommandQueue(cl_context context, cl_device_id device,
                                             cl_command_queue_properties properties, cl_int *error)
{
    (void)context;
    (void)properties;
    assert_ptr_equal(device, &opencl_devices[0]);
    note("", "queue");
    ++now.queues;
    *error = CL_SUCCESS;
    return (cl_command_queue)(void *)&now.queues;
}

cl_int __wrap_clReleaseCommandQueue(cl_command_queue queue)
{
    assert_ptr_equal(queue, &now.queues);
    assert_true(now.devices > 0);
    note("-", "queue");
    --now.queues;
    return CL_SUCCESS;
}

/* ---- front ends ---- */

svo_status __wrap_svo_frontend_create_cl(svo_device *device, svo_frontend **out);
void __wrap_svo_frontend_destroy(svo_frontend **frontend);
int __wrap_svo_frontend_cl_suffices(const svo_plan *plan, svo_message *reason);
svo_status __wrap_svo_gl_create(svo_device *device, svo_gl_context *context, const svo_gl_options *options,
                                svo_gl **out);
void __wrap_svo_gl_destroy(svo_gl **gl);
svo_frontend *__wrap_svo_gl_frontend(svo_gl *gl);
svo_frontend *__wrap_svo_gl_prefer(svo_gl *gl, svo_frontend *cl, svo_message *reason);

svo_status __wrap_svo_frontend_create_cl(svo_device *device, svo_frontend **out)
{
    assert_non_null(device);
    note("", "cl");
    ++now.front_ends;
    *out = &now.cl;
    return SVO_OK;
}

void __wrap_svo_frontend_destroy(svo_frontend **frontend)
{
    if (*frontend != NULL) {
        note("-", "cl");
        --now.front_ends;
        *frontend = NULL;
    }
}

/* plan: NULL stands for a small one. */
int __wrap_svo_frontend_cl_suffices(const svo_plan *plan, svo_message *reason)
{
    (void)reason;
    return plan == NULL;
}

svo_status __wrap_svo_gl_create(svo_device *device, svo_gl_context *context, const svo_gl_options *options,
                                svo_gl **out)
{
    const place *shared = shared_by(device->context);
    char word[WORD_BYTES];
    const bool is_hybrid = options->raster == SVO_GL_RASTER_HYBRID;
    (void)snprintf(word, sizeof word, is_hybrid ? "hybrid%u" : "gl", (unsigned)options->hybrid_columns);
    assert_true(shared == NULL || shared == (const place *)context->native);
    note("", word);
    if (now.machine->refuses_front_end) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED, "svo_gl_create: none works");
    }
    ++now.front_ends;
    *out = (svo_gl *)(void *)&now.gl;
    return SVO_OK;
}

void __wrap_svo_gl_destroy(svo_gl **gl)
{
    if (*gl != NULL) {
        assert_true(now.devices > 0);
        note("-", "gl");
        --now.front_ends;
        *gl = NULL;
    }
}

svo_frontend *__wrap_svo_gl_frontend(svo_gl *gl)
{
    return (svo_frontend *)(void *)gl;
}

svo_frontend *__wrap_svo_gl_prefer(svo_gl *gl, svo_frontend *cl, svo_message *reason)
{
    (void)cl;
    (void)reason;
    return (svo_frontend *)(void *)gl;
}
/* NOLINTEND(readability-identifier-naming) */
