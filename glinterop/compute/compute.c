/* SPDX-License-Identifier: MIT */
/* Buffers, launches and times of compute shaders, below the stages of the GL compute builder (build.c). */
#include "compute/compute.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Nothing in svocl draws from this binding point. */
#define WORK_TARGET GL_COPY_READ_BUFFER
/* Groups in a row of a launch; every context allows 65535. */
#define ROW_GROUPS 16384u

static svo_status check(svo_i_compute *compute, const char *step)
{
    return svo_i_gl_check(compute->gl, SVO_I_GL_BUILD, step, &compute->device->message);
}

static bool has_int64(const svo_i_gl_functions *gl, bool no_int64)
{
    return !no_int64 && svo_i_gl_has_extension(gl, "GL_ARB_gpu_shader_int64");
}

/* llvmpipe's timer queries leave out work and begin with nonsense. */
static bool believes_timer(const svo_i_gl_functions *gl)
{
    return strstr(gl->renderer, "llvmpipe") == NULL;
}

svo_status svo_i_compute_create(svo_device *device, svo_gl_context *context, bool no_int64, svo_i_compute **out)
{
    svo_i_compute *compute = calloc(1, sizeof *compute);
    if (compute == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, SVO_I_GL_BUILD ": no memory for the builder");
    }
    compute->device = device;
    compute->context = context;
    compute->gl = svo_i_gl_context_functions(context);
    compute->int64 = has_int64(compute->gl, no_int64);
    compute->has_timer = believes_timer(compute->gl);
    svo_status status = svo_i_gl_context_make_current(context, &device->message);
    if (status == SVO_OK) {
        svo_i_gl_clear_errors(compute->gl);
        compute->gl->GenQueries(2, compute->queries);
        status = svo_i_compute_alloc_zero(compute, "exhausted", 4, &compute->exhausted);
        svo_i_gl_context_release_current(context);
    }
    if (status != SVO_OK) {
        svo_i_compute_destroy(&compute);
        return status;
    }
    *out = compute;
    return SVO_OK;
}

void svo_i_compute_destroy(svo_i_compute **compute)
{
    svo_i_compute *dying = *compute;
    if (dying == NULL) {
        return;
    }
    if (svo_i_gl_context_make_current(dying->context, NULL) == SVO_OK) {
        svo_i_compute_programs_destroy(dying);
        dying->gl->DeleteQueries(2, dying->queries);
        svo_i_compute_free(dying, &dying->exhausted);
        svo_i_gl_context_release_current(dying->context);
    }
    free(dying);
    *compute = NULL;
}

void svo_i_compute_reason(const svo_gl_context *context, bool no_int64, uint32_t need, char *reason,
                          size_t reason_bytes)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(context);
    const bool payload = (need & SVO_I_NEED_PAYLOAD) != 0;
    const int blocks = payload ? SVO_I_COMPUTE_BINDINGS : 6; /* SVO_I_ENTRY_SORT_LONG has the most of the others */
    const int has = gl->limits.compute_storage_blocks < gl->limits.storage_bindings ? gl->limits.compute_storage_blocks
                                                                                    : gl->limits.storage_bindings;
    reason[0] = '\0';
    if (gl->limits.compute_group_invocations < SVO_GROUP_ITEMS) {
        (void)snprintf(reason, reason_bytes, "%s has groups of %d invocations, below %d", gl->renderer,
                       gl->limits.compute_group_invocations, SVO_GROUP_ITEMS);
    } else if (has < blocks) {
        (void)snprintf(reason, reason_bytes, "%s has %d storage blocks for compute shaders, %sneeds %d", gl->renderer,
                       has, payload ? "payload " : "it ", blocks);
    } else if (payload && !has_int64(gl, no_int64)) {
        (void)snprintf(reason, reason_bytes, "payload needs GL_ARB_gpu_shader_int64, which %s does not have%s",
                       gl->renderer, no_int64 ? " by svo_gl_options.no_int64" : "");
    }
}

static svo_status alloc(svo_i_compute *compute, const char *name, uint64_t bytes, const void *data, GLuint *out)
{
    const svo_i_gl_functions *gl = compute->gl;
    /* Whole words, and one more: shaders look at words beside the last one. */
    const uint64_t padded = (bytes + 3) / 4 * 4 + 4;
    if (padded > (uint64_t)gl->limits.storage_block_bytes) {
        return svo_i_device_fail(compute->device, SVO_UNSUPPORTED,
                                 SVO_I_GL_BUILD ": %s needs %llu bytes, above the storage block limit of %lld of %s",
                                 name, (unsigned long long)padded, (long long)gl->limits.storage_block_bytes,
                                 gl->renderer);
    }
    gl->GenBuffers(1, out);
    gl->BindBuffer(WORK_TARGET, *out);
    gl->BufferData(WORK_TARGET, (GLsizeiptr)padded, NULL, GL_DYNAMIC_COPY);
    if (data != NULL && bytes > 0) {
        gl->BufferSubData(WORK_TARGET, 0, (GLsizeiptr)bytes, data);
    }
    gl->BindBuffer(WORK_TARGET, 0);
    return check(compute, name);
}

svo_status svo_i_compute_alloc(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out)
{
    return alloc(compute, name, bytes, NULL, out);
}

svo_status svo_i_compute_alloc_zero(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out)
{
    const svo_status status = alloc(compute, name, bytes, NULL, out);
    if (status == SVO_OK) {
        svo_i_compute_fill_zero(compute, *out);
    }
    return status;
}

svo_status svo_i_compute_upload(svo_i_compute *compute, const char *name, const void *data, uint64_t bytes, GLuint *out)
{
    return alloc(compute, name, bytes, data, out);
}

void svo_i_compute_fill_zero(const svo_i_compute *compute, GLuint buffer)
{
    const svo_i_gl_functions *gl = compute->gl;
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(WORK_TARGET, buffer);
    gl->ClearBufferData(WORK_TARGET, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, NULL);
    gl->BindBuffer(WORK_TARGET, 0);
}

void svo_i_compute_free(const svo_i_compute *compute, GLuint *buffer)
{
    if (*buffer != 0) {
        compute->gl->DeleteBuffers(1, buffer);
        *buffer = 0;
    }
}

svo_status svo_i_compute_read(svo_i_compute *compute, GLuint buffer, void *to, size_t bytes)
{
    const svo_i_gl_functions *gl = compute->gl;
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(WORK_TARGET, buffer);
    gl->GetBufferSubData(WORK_TARGET, 0, (GLsizeiptr)bytes, to);
    gl->BindBuffer(WORK_TARGET, 0);
    return check(compute, "reading a buffer");
}

svo_status svo_i_compute_to_cl(svo_i_compute *compute, svo_i_build *build, GLuint buffer, const char *name,
                               uint64_t offset, uint64_t bytes, cl_mem *out)
{
    const svo_i_gl_functions *gl = compute->gl;
    if (bytes == 0) {
        return svo_i_build_alloc(build, name, bytes, out);
    }
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(WORK_TARGET, buffer);
    const void *mapped = gl->MapBufferRange(WORK_TARGET, (GLintptr)offset, (GLsizeiptr)bytes, GL_MAP_READ_BIT);
    svo_status status = check(compute, "glMapBufferRange");
    if (status == SVO_OK && mapped == NULL) {
        status = svo_i_device_fail(compute->device, SVO_GL_ERROR, SVO_I_GL_BUILD ": glMapBufferRange returned NULL");
    }
    if (status == SVO_OK) {
        status = svo_i_build_upload(build, name, mapped, bytes, out);
        if (gl->UnmapBuffer(WORK_TARGET) != GL_TRUE && status == SVO_OK) {
            status = svo_i_device_fail(compute->device, SVO_GL_ERROR,
                                       SVO_I_GL_BUILD ": glUnmapBuffer says that %s was lost", name);
        }
    }
    gl->BindBuffer(WORK_TARGET, 0);
    return status;
}

static void dispatch(const svo_i_gl_functions *gl, const svo_i_launch *launch)
{
    if (launch->indirect != 0) {
        gl->BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, launch->indirect);
        gl->DispatchComputeIndirect((GLintptr)launch->indirect_word * 4);
        return;
    }
    const uint64_t groups = (launch->items + SVO_GROUP_ITEMS - 1) / SVO_GROUP_ITEMS;
    const uint64_t columns = groups < ROW_GROUPS ? groups : ROW_GROUPS;
    gl->DispatchCompute((GLuint)columns, (GLuint)((groups + columns - 1) / columns), 1);
}

svo_status svo_i_compute_launch(svo_i_compute *compute, const svo_i_launch *launch)
{
    const svo_i_gl_functions *gl = compute->gl;
    svo_i_compute_program *program = NULL;
    if (launch->indirect == 0 && launch->items == 0) {
        return SVO_OK;
    }
    const svo_status status = svo_i_compute_program_get(compute, launch->entry, &program);
    if (status != SVO_OK) {
        return status;
    }
    for (GLuint binding = 0; binding < SVO_I_COMPUTE_BLOCKS; ++binding) {
        if (launch->buffers[binding] != 0) {
            gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, launch->buffers[binding]);
        }
    }
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, SVO_I_COMPUTE_EXHAUSTED, compute->exhausted);
    gl->UseProgram(program->name);
    svo_i_compute_program_set(compute, program, launch->params);
    gl->Uniform1ui(program->vertex_count, launch->vertex_count);
    gl->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT |
                      (launch->indirect != 0 ? GL_COMMAND_BARRIER_BIT : 0u));
    dispatch(gl, launch);
    return check(compute, "launching a compute shader");
}

svo_status svo_i_compute_exhausted(svo_i_compute *compute, bool *exhausted)
{
    uint32_t word = 0;
    const svo_status status = svo_i_compute_read(compute, compute->exhausted, &word, sizeof word);
    *exhausted = word != 0;
    if (*exhausted) {
        svo_i_compute_fill_zero(compute, compute->exhausted);
    }
    return status;
}

void svo_i_compute_stage_begin(svo_i_compute *compute)
{
    if (compute->has_timer) {
        compute->gl->QueryCounter(compute->queries[0], GL_TIMESTAMP);
    } else {
        compute->gl->Finish();
    }
    compute->stage_start_ms = svo_i_now_ms();
}

svo_status svo_i_compute_stage_end(svo_i_compute *compute, svo_i_build *build, svo_stage stage)
{
    const svo_i_gl_functions *gl = compute->gl;
    if (!compute->has_timer) {
        gl->Finish();
        svo_i_report_add(build->report, stage, svo_i_now_ms() - compute->stage_start_ms, "wall");
        return check(compute, svo_stage_name(stage));
    }
    GLuint64 begin_ns = 0;
    GLuint64 end_ns = 0;
    gl->QueryCounter(compute->queries[1], GL_TIMESTAMP);
    gl->GetQueryObjectui64v(compute->queries[0], GL_QUERY_RESULT, &begin_ns);
    gl->GetQueryObjectui64v(compute->queries[1], GL_QUERY_RESULT, &end_ns);
    svo_i_report_add(build->report, stage, (double)(end_ns - begin_ns) * 1e-6, "gl-timer");
    return check(compute, svo_stage_name(stage));
}
