/* SPDX-License-Identifier: MIT */
/* Compiles the embedded kernels; a device handle keeps the programs, and what their tests have shown. */
#include "core/program.h"

#include <stdio.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/opencl.h"

/* A program that was compiled or loaded, attached to its device. */
typedef struct compiled_program {
    svo_i_attachment attachment;
    const svo_i_program *program; /* NULL: no room has asked for it since it was loaded */
    svo_i_program_entry entry;
    bool is_fresh; /* not used yet */
    bool is_tested;
    const char *wrong; /* a kernel that the test has found to be compiled wrongly; NULL: none */
} compiled_program;

extern const svo_i_kernel_text svo_i_text_shared_builtins_clh;

/* The first line of a program's text; the files come without their comments. */
#define LICENSE "/* SPDX-License-Identifier: MIT */\n"

static void release_program(svo_i_attachment *attachment)
{
    compiled_program *compiled = (compiled_program *)attachment;
    clReleaseProgram(compiled->entry.program);
    svo_i_free(compiled);
}

void svo_i_program_options(const svo_device *device, const char *defines, char options[SVO_I_PROGRAM_OPTIONS_BYTES])
{
    (void)snprintf(options, SVO_I_PROGRAM_OPTIONS_BYTES, "-cl-std=CL1.2%s%s",
                   device->rounds_quotients ? " -cl-fp32-correctly-rounded-divide-sqrt" : "", defines);
}

/* The hash of a program's text, which is not put together for it. */
static void hash_source(const svo_i_program *program, char text[SVO_I_HASH_BYTES])
{
    svo_i_kernel_texts texts;
    XXH3_state_t state;
    svo_i_kernel_texts_list(program->files, &texts);
    XXH3_128bits_reset(&state);
    for (size_t i = 0; i < texts.count; ++i) {
        XXH3_128bits_update(&state, texts.files[i]->text, strlen(texts.files[i]->text));
    }
    const XXH128_hash_t hash = XXH3_128bits_digest(&state);
    (void)snprintf(text, SVO_I_HASH_BYTES, "%016llx%016llx", (unsigned long long)hash.high64,
                   (unsigned long long)hash.low64);
}

/* Whether it is the program of a room. A loaded one is, if it was compiled from the same source. */
static bool is_of(compiled_program *compiled, const svo_i_program *program)
{
    if (compiled->program == NULL && strcmp(compiled->entry.name, program->name) == 0) {
        char source[SVO_I_HASH_BYTES];
        hash_source(program, source);
        compiled->program = strcmp(compiled->entry.source, source) == 0 ? program : NULL;
    }
    return compiled->program == program;
}

static compiled_program *find_program(const svo_device *device, const svo_i_program *program, const char *defines)
{
    svo_i_attachment *at = svo_i_attachment_find(device->attachments, release_program);
    while (at != NULL) {
        compiled_program *compiled = (compiled_program *)at;
        if (strcmp(compiled->entry.defines, defines) == 0 && is_of(compiled, program)) {
            return compiled;
        }
        at = svo_i_attachment_find(at->next, release_program);
    }
    return NULL;
}

/* Puts a program's text together. The caller frees it. */
static svo_status assemble(svo_device *device, const char *function, const svo_i_program *program, char **out)
{
    svo_i_kernel_texts texts;
    size_t bytes = sizeof LICENSE;
    svo_i_kernel_texts_list(program->files, &texts);
    if (texts.is_cut) {
        return svo_i_device_fail(device, SVO_INTERNAL, "%s: program %s has more than %d files", function, program->name,
                                 SVO_I_KERNEL_TEXTS_MAX);
    }
    for (size_t i = 0; i < texts.count; ++i) {
        bytes += strlen(texts.files[i]->text);
    }
    *out = svo_i_alloc(&device->memory, bytes);
    if (*out == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the text of program %s", function,
                                 program->name);
    }
    memcpy(*out, LICENSE, sizeof LICENSE);
    size_t used = sizeof LICENSE - 1;
    for (size_t i = 0; i < texts.count; ++i) {
        const size_t length = strlen(texts.files[i]->text);
        memcpy(*out + used, texts.files[i]->text, length + 1);
        used += length;
    }
    return SVO_OK;
}

/* The first line of a log that has an error, which names the file and the line; its end where none has. */
static const char *first_error(const char *log)
{
    const char *error = strstr(log, "error");
    if (error == NULL) {
        return log + strlen(log);
    }
    while (error > log && error[-1] != '\n') {
        --error;
    }
    return error;
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
    const char *error = log != NULL ? first_error(log) : "";
    svo_i_device_fail(device, SVO_COMPILE_FAILED, "%s: kernels do not compile on %s with %s: %.*s", function,
                      device->name, options, (int)strcspn(error, "\n"), error);
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
    const char *texts[] = {svo_i_text_shared_builtins_clh.text, source};
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

static svo_status compile_text(svo_device *device, const char *function, const char *source, const char *defines,
                               cl_program *out)
{
    const char *call = NULL;
    char options[SVO_I_PROGRAM_OPTIONS_BYTES];
    svo_i_program_options(device, defines, options);
    if (build_short(device, source, options, out)) {
        return SVO_OK;
    }
    cl_program program = NULL;
    const cl_int error = build_texts(device, 1, &source, options, &program, &call);
    if (error == CL_SUCCESS) {
        *out = program;
        return SVO_OK;
    }
    svo_status status = svo_i_device_check_compiler(device, function); /* without memory, no text compiles */
    if (status == SVO_OK) {
        status = error == CL_BUILD_PROGRAM_FAILURE ? fail_build(device, function, program, options)
                                                   : svo_i_device_fail_cl(device, function, call, error);
    }
    if (program != NULL) {
        clReleaseProgram(program);
    }
    return status;
}

static svo_status compile(svo_device *device, const char *function, const svo_i_program *program, const char *defines,
                          cl_program *out)
{
    char *source = NULL;
    SVO_I_TRY(assemble(device, function, program, &source));
    const svo_status status = compile_text(device, function, source, defines, out);
    svo_i_free(source);
    return status;
}

/* Attaches a program to its device, which owns it from then on; after a failure the caller still does. program: NULL
   for one that was loaded. out: NULL allowed. */
static svo_status attach(svo_device *device, const char *function, const svo_i_program *program,
                         const svo_i_program_entry *entry, compiled_program **out)
{
    compiled_program *compiled = svo_i_alloc_zeroed(&device->memory, 1, sizeof *compiled);
    if (compiled == NULL) {
        (void)svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a program", function);
        return SVO_OUT_OF_HOST_MEMORY;
    }
    compiled->program = program;
    compiled->entry = *entry;
    compiled->is_fresh = true;
    compiled->attachment.destroy = release_program;
    svo_i_attachment_add(&device->attachments, &compiled->attachment);
    if (out != NULL) {
        *out = compiled;
    }
    return SVO_OK;
}

/* Describes a program that is not compiled yet. */
static svo_status describe(svo_device *device, const char *function, const svo_i_program *program, const char *defines,
                           svo_i_program_entry *out)
{
    if (strlen(defines) >= sizeof out->defines || strlen(program->name) >= sizeof out->name) {
        return svo_i_device_fail(device, SVO_INTERNAL, "%s: the name or the defines of program %s are too long",
                                 function, program->name);
    }
    memcpy(out->name, program->name, strlen(program->name) + 1);
    memcpy(out->defines, defines, strlen(defines) + 1);
    hash_source(program, out->source);
    return SVO_OK;
}

/* Compiles a program and attaches it. */
static svo_status make_program(svo_device *device, const char *function, const svo_i_program *program,
                               const char *defines, compiled_program **out)
{
    svo_i_program_entry made = {.program = NULL};
    SVO_I_TRY(describe(device, function, program, defines, &made));
    SVO_I_TRY(svo_i_device_check_compiler(device, function));
    const double start_ms = svo_i_now_ms();
    svo_status status = compile(device, function, program, defines, &made.program);
    device->compile_ms += svo_i_now_ms() - start_ms;
    SVO_I_TRY(status);
    device->has_compiled = true;
    status = attach(device, function, program, &made, out);
    if (status != SVO_OK) {
        clReleaseProgram(made.program);
    }
    return status;
}

static svo_status fail_wrong(svo_device *device, const char *function, const char *kernel)
{
    char *driver = NULL;
    SVO_I_TRY(
        svo_i_device_text(device->device, CL_DRIVER_VERSION, function, &device->memory, &driver, &device->message));
    svo_i_device_fail(device, SVO_DEVICE_UNRELIABLE, "%s: kernel %s gives wrong results on %s, driver %s", function,
                      kernel, device->name, driver);
    svo_i_free(driver);
    return SVO_DEVICE_UNRELIABLE;
}

/* Tests a program that has a test, once. */
static svo_status test_program(svo_device *device, const char *function, compiled_program *compiled)
{
    svo_i_prover *const prove = compiled->program->prove;
    if (prove == NULL || compiled->is_tested || !device->tests_programs) {
        return SVO_OK;
    }
    const double start_ms = svo_i_now_ms();
    compiled->is_tested = true; /* so that the test gets the program */
    const svo_status status = prove(device, function, &compiled->entry, &compiled->wrong);
    compiled->is_tested = status == SVO_OK || status == SVO_DEVICE_UNRELIABLE;
    device->compile_ms += svo_i_now_ms() - start_ms;
    return status == SVO_DEVICE_UNRELIABLE ? SVO_OK : status;
}

svo_status svo_i_program_get(svo_device *device, const char *function, const svo_i_program *program,
                             const char *defines, cl_program *out, bool *fresh)
{
    compiled_program *known = find_program(device, program, defines);
    if (known == NULL) {
        SVO_I_TRY(make_program(device, function, program, defines, &known));
    }
    SVO_I_TRY(test_program(device, function, known));
    if (known->wrong != NULL) {
        return fail_wrong(device, function, known->wrong);
    }
    *out = known->entry.program;
    if (fresh != NULL) {
        *fresh = known->is_fresh;
    }
    known->is_fresh = false;
    return SVO_OK;
}

bool svo_i_program_known(const svo_device *device, const svo_i_program *program, const char *defines)
{
    return find_program(device, program, defines) != NULL;
}

bool svo_i_program_wrong(const svo_device *device, const svo_i_program *program, const char *defines)
{
    const compiled_program *known = find_program(device, program, defines);
    return known != NULL && known->wrong != NULL;
}

const svo_i_program_entry *svo_i_program_at(const svo_device *device, size_t index)
{
    svo_i_attachment *at = svo_i_attachment_find(device->attachments, release_program);
    for (; at != NULL && index > 0; --index) {
        at = svo_i_attachment_find(at->next, release_program);
    }
    return at != NULL ? &((compiled_program *)at)->entry : NULL;
}

svo_status svo_i_program_add(svo_device *device, const char *function, const svo_i_program_entry *loaded)
{
    return attach(device, function, NULL, loaded, NULL);
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
