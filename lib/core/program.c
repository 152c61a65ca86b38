/* SPDX-License-Identifier: MIT */
/* Compiles the embedded kernels; a device handle keeps the programs. */
#include "core/program.h"

#include <stdio.h>
#include <string.h>

#include "core/opencl.h"

/* A program that was compiled, attached to its device. */
typedef struct compiled_program {
    svo_i_attachment attachment;
    svo_i_program_kind kind;
    char defines[SVO_I_PROGRAM_DEFINES_BYTES];
    cl_program program;
    bool is_fresh; /* loaded, and not used yet */
} compiled_program;

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_builtins[];
extern const char svo_i_source_subdivide[];
extern const char svo_i_source_sort[];
extern const char svo_i_source_pack[];
extern const char svo_i_source_filter[];
extern const char svo_i_source_voxelize[];
extern const char svo_i_source_plan[];
extern const char svo_i_source_cast[];
extern const char svo_i_source_bvh[];
extern const char svo_i_source_trace[];
extern const char svo_i_source_view[];
extern const char svo_i_source_trace_voxels[];
extern const char svo_i_source_minimize[];
extern const char svo_i_source_compact[];
extern const char svo_i_source_expand[];
extern const char svo_i_source_scene_build[];
extern const char svo_i_source_scene_bounds[];
extern const char svo_i_source_scene_trace[];
extern const char svo_i_source_scene_cast[];
extern const char svo_i_source_solid[];
extern const char svo_i_source_gather[];
extern const char svo_i_source_kept_photons[];
extern const char svo_i_source_photons[];
extern const char svo_i_source_light_picture[];
extern const char svo_i_source_light_shade[];
extern const char svo_i_source_probes[];
extern const char svo_i_source_probe_filter[];
extern const char svo_i_source_probe_trace[];
extern const char svo_i_source_probe_gather[];
extern const char svo_i_source_light[];
extern const char svo_i_source_moving[];

static void release_program(svo_i_attachment *attachment)
{
    compiled_program *entry = (compiled_program *)attachment;
    clReleaseProgram(entry->program);
    svo_i_free(entry);
}

const char *svo_i_program_kind_name(svo_i_program_kind kind)
{
    static const char *const names[SVO_I_PROGRAM_KINDS] = {[SVO_I_PROGRAM_SUBDIVIDE] = "subdivide",
                                                           [SVO_I_PROGRAM_SORT] = "sort",
                                                           [SVO_I_PROGRAM_PACK] = "pack",
                                                           [SVO_I_PROGRAM_FILTER] = "filter",
                                                           [SVO_I_PROGRAM_VOXELIZE] = "voxelize",
                                                           [SVO_I_PROGRAM_PLAN] = "plan",
                                                           [SVO_I_PROGRAM_CAST] = "cast",
                                                           [SVO_I_PROGRAM_BVH] = "bvh",
                                                           [SVO_I_PROGRAM_TRACE] = "trace",
                                                           [SVO_I_PROGRAM_VIEW] = "view",
                                                           [SVO_I_PROGRAM_TRACE_VOXELS] = "trace_voxels",
                                                           [SVO_I_PROGRAM_COMPACT] = "compact",
                                                           [SVO_I_PROGRAM_EXPAND] = "expand",
                                                           [SVO_I_PROGRAM_SCENE_BUILD] = "scene_build",
                                                           [SVO_I_PROGRAM_SCENE_BOUNDS] = "scene_bounds",
                                                           [SVO_I_PROGRAM_SCENE_TRACE] = "scene_trace",
                                                           [SVO_I_PROGRAM_SCENE_CAST] = "scene_cast",
                                                           [SVO_I_PROGRAM_MINIMIZE] = "minimize",
                                                           [SVO_I_PROGRAM_SOLID] = "solid",
                                                           [SVO_I_PROGRAM_GATHER] = "gather",
                                                           [SVO_I_PROGRAM_KEPT_PHOTONS] = "kept_photons",
                                                           [SVO_I_PROGRAM_PHOTONS] = "photons",
                                                           [SVO_I_PROGRAM_LIGHT_PICTURE] = "light_picture",
                                                           [SVO_I_PROGRAM_LIGHT_SHADE] = "light_shade",
                                                           [SVO_I_PROGRAM_PROBES] = "probes",
                                                           [SVO_I_PROGRAM_PROBE_FILTER] = "probe_filter",
                                                           [SVO_I_PROGRAM_PROBE_TRACE] = "probe_trace",
                                                           [SVO_I_PROGRAM_PROBE_GATHER] = "probe_gather",
                                                           [SVO_I_PROGRAM_LIGHT] = "light",
                                                           [SVO_I_PROGRAM_MOVING] = "moving"};
    return names[kind];
}

const char *svo_i_program_source(svo_i_program_kind kind)
{
    const char *const sources[SVO_I_PROGRAM_KINDS] = {[SVO_I_PROGRAM_SUBDIVIDE] = svo_i_source_subdivide,
                                                      [SVO_I_PROGRAM_SORT] = svo_i_source_sort,
                                                      [SVO_I_PROGRAM_PACK] = svo_i_source_pack,
                                                      [SVO_I_PROGRAM_FILTER] = svo_i_source_filter,
                                                      [SVO_I_PROGRAM_VOXELIZE] = svo_i_source_voxelize,
                                                      [SVO_I_PROGRAM_PLAN] = svo_i_source_plan,
                                                      [SVO_I_PROGRAM_CAST] = svo_i_source_cast,
                                                      [SVO_I_PROGRAM_BVH] = svo_i_source_bvh,
                                                      [SVO_I_PROGRAM_TRACE] = svo_i_source_trace,
                                                      [SVO_I_PROGRAM_VIEW] = svo_i_source_view,
                                                      [SVO_I_PROGRAM_TRACE_VOXELS] = svo_i_source_trace_voxels,
                                                      [SVO_I_PROGRAM_COMPACT] = svo_i_source_compact,
                                                      [SVO_I_PROGRAM_EXPAND] = svo_i_source_expand,
                                                      [SVO_I_PROGRAM_SCENE_BUILD] = svo_i_source_scene_build,
                                                      [SVO_I_PROGRAM_SCENE_BOUNDS] = svo_i_source_scene_bounds,
                                                      [SVO_I_PROGRAM_SCENE_TRACE] = svo_i_source_scene_trace,
                                                      [SVO_I_PROGRAM_SCENE_CAST] = svo_i_source_scene_cast,
                                                      [SVO_I_PROGRAM_MINIMIZE] = svo_i_source_minimize,
                                                      [SVO_I_PROGRAM_SOLID] = svo_i_source_solid,
                                                      [SVO_I_PROGRAM_GATHER] = svo_i_source_gather,
                                                      [SVO_I_PROGRAM_KEPT_PHOTONS] = svo_i_source_kept_photons,
                                                      [SVO_I_PROGRAM_PHOTONS] = svo_i_source_photons,
                                                      [SVO_I_PROGRAM_LIGHT_PICTURE] = svo_i_source_light_picture,
                                                      [SVO_I_PROGRAM_LIGHT_SHADE] = svo_i_source_light_shade,
                                                      [SVO_I_PROGRAM_PROBES] = svo_i_source_probes,
                                                      [SVO_I_PROGRAM_PROBE_FILTER] = svo_i_source_probe_filter,
                                                      [SVO_I_PROGRAM_PROBE_TRACE] = svo_i_source_probe_trace,
                                                      [SVO_I_PROGRAM_PROBE_GATHER] = svo_i_source_probe_gather,
                                                      [SVO_I_PROGRAM_LIGHT] = svo_i_source_light,
                                                      [SVO_I_PROGRAM_MOVING] = svo_i_source_moving};
    return sources[kind];
}

void svo_i_program_options(const char *defines, char options[SVO_I_PROGRAM_OPTIONS_BYTES])
{
    (void)snprintf(options, SVO_I_PROGRAM_OPTIONS_BYTES, "-cl-std=CL1.2%s", defines);
}

static compiled_program *find_program(const svo_device *device, svo_i_program_kind kind, const char *defines)
{
    svo_i_attachment *at = svo_i_attachment_find(device->attachments, release_program);
    while (at != NULL) {
        compiled_program *entry = (compiled_program *)at;
        if (entry->kind == kind && strcmp(entry->defines, defines) == 0) {
            return entry;
        }
        at = svo_i_attachment_find(at->next, release_program);
    }
    return NULL;
}

/* Reports a failed build: one line in the message, all of the log to the callback. */
static svo_status fail_build(svo_device *device, const char *function, cl_program program, const char *options)
{
    size_t bytes = 0;
    clGetProgramBuildInfo(program, device->device, CL_PROGRAM_BUILD_LOG, 0, NULL, &bytes);
    char *log = svo_i_alloc_zeroed(&device->memory, bytes + 1, 1);
    if (log != NULL && bytes > 0) {
        clGetProgramBuildInfo(program, device->device, CL_PROGRAM_BUILD_LOG, bytes, log, NULL);
        svo_i_device_log(device, SVO_LOG_ERROR, log);
    }
    const char *error = log != NULL ? strstr(log, "error") : NULL;
    const int length = error != NULL ? (int)strcspn(error, "\n") : 0;
    svo_i_device_fail(device, SVO_COMPILE_FAILED, "%s: kernels do not compile on %s with %s: %.*s", function,
                      device->name, options, length, error != NULL ? error : "");
    svo_i_free(log);
    return SVO_COMPILE_FAILED;
}

/* Whether the driver puts clang's opencl-c.h before each program's text and preprocesses it at every start, whatever
   its cache holds: PoCL 3. That takes 15 ms of a program's 22, and 80 of 95 when the cache is empty. */
static bool includes_opencl_c_h(const svo_device *device)
{
    char *driver = NULL;
    const bool is_pocl = strncmp(device->name, "Portable Computing Language", 27) == 0;
    const bool is_known =
        is_pocl && svo_i_device_text(device->device, CL_DRIVER_VERSION, "", &device->memory, &driver, NULL) == SVO_OK;
    const bool is_pocl_3 = is_known && strncmp(driver, "3.", 2) == 0;
    svo_i_free(driver);
    return is_pocl_3;
}

/* Makes a program of some texts and builds it. out: also after a failed build, for its log; NULL without a program.
   call: receives the name of the call that failed. */
static cl_int build_texts(const svo_device *device, cl_uint count, const char **texts, const char *options,
                          cl_program *out, const char **call)
{
    cl_int error = CL_SUCCESS;
    *call = "clCreateProgramWithSource";
    *out = clCreateProgramWithSource(device->context, count, texts, NULL, &error);
    if (error != CL_SUCCESS) {
        *out = NULL;
        return error;
    }
    *call = "clBuildProgram";
    return clBuildProgram(*out, 1, &device->device, options, NULL, NULL);
}

#define GUARD " -D_OPENCL_H_"

/* The program without clang's header, after our own declarations (shared/builtins.clh). False where that fails: the
   driver's header then serves. */
static bool build_short(const svo_device *device, const char *source, const char *options, cl_program *out)
{
    const char *texts[] = {svo_i_source_builtins, source};
    const char *call = NULL;
    char with_guard[SVO_I_PROGRAM_OPTIONS_BYTES + sizeof GUARD];
    if (!includes_opencl_c_h(device)) {
        return false;
    }
    (void)snprintf(with_guard, sizeof with_guard, "%s" GUARD, options);
    const cl_int error = build_texts(device, 2, texts, with_guard, out, &call);
    if (error != CL_SUCCESS && *out != NULL) {
        clReleaseProgram(*out);
    }
    return error == CL_SUCCESS;
}

static svo_status compile(svo_device *device, const char *function, svo_i_program_kind kind, const char *defines,
                          cl_program *out)
{
    const char *source = svo_i_program_source(kind);
    const char *call = NULL;
    char options[SVO_I_PROGRAM_OPTIONS_BYTES];
    svo_i_program_options(defines, options);
    if (build_short(device, source, options, out)) {
        return SVO_OK;
    }
    cl_program program = NULL;
    const cl_int error = build_texts(device, 1, &source, options, &program, &call);
    if (error == CL_SUCCESS) {
        *out = program;
        return SVO_OK;
    }
    const svo_status status = error == CL_BUILD_PROGRAM_FAILURE ? fail_build(device, function, program, options)
                                                                : svo_i_device_fail_cl(device, function, call, error);
    if (program != NULL) {
        clReleaseProgram(program);
    }
    return status;
}

/* Attaches a program to its device, which owns it from then on; after a failure the caller still does. */
static svo_status attach(svo_device *device, const char *function, const svo_i_program_entry *made, bool is_fresh)
{
    compiled_program *entry = svo_i_alloc_zeroed(&device->memory, 1, sizeof *entry);
    if (entry == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a program", function);
    }
    memcpy(entry->defines, made->defines, strlen(made->defines) + 1);
    entry->kind = made->kind;
    entry->program = made->program;
    entry->is_fresh = is_fresh;
    entry->attachment.destroy = release_program;
    svo_i_attachment_add(&device->attachments, &entry->attachment);
    return SVO_OK;
}

static svo_status check_defines(svo_device *device, const char *function, const char *defines)
{
    return strlen(defines) < SVO_I_PROGRAM_DEFINES_BYTES
               ? SVO_OK
               : svo_i_device_fail(device, SVO_INTERNAL, "%s: defines take %zu bytes, above %d", function,
                                   strlen(defines), SVO_I_PROGRAM_DEFINES_BYTES - 1);
}

/* Compiles a program and attaches it. */
static svo_status make_program(svo_device *device, const char *function, svo_i_program_kind kind, const char *defines,
                               cl_program *out)
{
    svo_i_program_entry made = {.kind = kind, .defines = defines};
    SVO_I_TRY(check_defines(device, function, defines));
    const double start_ms = svo_i_now_ms();
    svo_status status = compile(device, function, kind, defines, &made.program);
    device->compile_ms += svo_i_now_ms() - start_ms;
    SVO_I_TRY(status);
    status = attach(device, function, &made, false);
    if (status != SVO_OK) {
        clReleaseProgram(made.program);
        return status;
    }
    *out = made.program;
    return SVO_OK;
}

svo_status svo_i_program_get(svo_device *device, const char *function, svo_i_program_kind kind, const char *defines,
                             cl_program *out, bool *fresh)
{
    compiled_program *known = find_program(device, kind, defines);
    if (known == NULL) {
        SVO_I_TRY(make_program(device, function, kind, defines, out));
        if (fresh != NULL) {
            *fresh = true;
        }
        return SVO_OK;
    }
    *out = known->program;
    if (fresh != NULL) {
        *fresh = known->is_fresh;
        known->is_fresh = false;
    }
    return SVO_OK;
}

bool svo_i_program_at(const svo_device *device, size_t index, svo_i_program_entry *entry)
{
    svo_i_attachment *at = svo_i_attachment_find(device->attachments, release_program);
    for (; at != NULL && index > 0; --index) {
        at = svo_i_attachment_find(at->next, release_program);
    }
    const compiled_program *found = (const compiled_program *)at;
    if (found != NULL) {
        *entry = (svo_i_program_entry){found->kind, found->defines, found->program};
    }
    return found != NULL;
}

bool svo_i_program_known(const svo_device *device, svo_i_program_kind kind, const char *defines)
{
    return find_program(device, kind, defines) != NULL;
}

svo_status svo_i_program_add(svo_device *device, const char *function, const svo_i_program_entry *loaded)
{
    SVO_I_TRY(check_defines(device, function, loaded->defines));
    return attach(device, function, loaded, true);
}

svo_status svo_i_kernel_create(svo_device *device, const char *function, cl_program program, const char *name,
                               cl_kernel *out)
{
    cl_int error = CL_SUCCESS;
    cl_kernel kernel = clCreateKernel(program, name, &error);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(device, function, name, error);
    }
    *out = kernel;
    return SVO_OK;
}

svo_status svo_i_kernel_set_from(svo_device *device, const char *function, cl_kernel kernel, cl_uint first_index,
                                 const svo_i_argument *arguments, cl_uint argument_count)
{
    for (cl_uint i = 0; i < argument_count; ++i) {
        const cl_int error = clSetKernelArg(kernel, first_index + i, arguments[i].bytes, arguments[i].value);
        if (error != CL_SUCCESS) {
            return svo_i_device_fail_cl(device, function, "clSetKernelArg", error);
        }
    }
    return SVO_OK;
}

svo_status svo_i_kernel_set(svo_device *device, const char *function, cl_kernel kernel, const svo_i_argument *arguments,
                            cl_uint argument_count)
{
    return svo_i_kernel_set_from(device, function, kernel, 0, arguments, argument_count);
}
