/* SPDX-License-Identifier: MIT */
/* Creates, fills, reads and frees storage blocks for the stages. */
#include "compute/buffer.h"

/* svocl draws nothing from this binding point. */
#define WORK_TARGET GL_COPY_READ_BUFFER

svo_status svo_i_compute_check(svo_i_compute *compute, const char *step)
{
    return svo_i_gl_check(compute->gl, SVO_I_GL_BUILD, step, &compute->device->message);
}

static svo_status alloc(svo_i_compute *compute, const char *name, uint64_t bytes, const void *data, GLuint *out)
{
    const svo_i_gl_functions *gl = compute->gl;
    /* Whole words plus one: shaders read one word past the last. */
    const uint64_t padded = (bytes + 3) / 4 * 4 + 4;
    if (padded > (uint64_t)gl->limits.storage_block_bytes) {
        return svo_i_device_fail(compute->device, SVO_UNSUPPORTED,
                                 SVO_I_GL_BUILD ": %s needs %llu bytes, above the storage block limit of %lld of %s",
                                 name, (unsigned long long)padded, (long long)gl->limits.storage_block_bytes,
                                 gl->renderer);
    }
    gl->GenBuffers(1, out);
    gl->BindBuffer(WORK_TARGET, *out);
    gl->BufferData(WORK_TARGET, (GLsizeiptr)padded, NULL, GL_STATIC_COPY); /* in the GPU's memory */
    if (data != NULL && bytes > 0) {
        gl->BufferSubData(WORK_TARGET, 0, (GLsizeiptr)bytes, data);
    }
    gl->BindBuffer(WORK_TARGET, 0);
    return svo_i_compute_check(compute, name);
}

svo_status svo_i_compute_alloc(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out)
{
    return alloc(compute, name, bytes, NULL, out);
}

svo_status svo_i_compute_alloc_zero(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out)
{
    SVO_I_TRY(alloc(compute, name, bytes, NULL, out));
    svo_i_compute_fill_zero(compute, *out);
    return SVO_OK;
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
    return svo_i_compute_check(compute, "reading a buffer");
}

/* Expects the buffer bound to WORK_TARGET. */
static svo_status copy_bound_to_cl(svo_i_compute *compute, svo_i_build *build, const char *name, uint64_t offset,
                                   uint64_t bytes, cl_mem *out)
{
    const svo_i_gl_functions *gl = compute->gl;
    const void *mapped = gl->MapBufferRange(WORK_TARGET, (GLintptr)offset, (GLsizeiptr)bytes, GL_MAP_READ_BIT);
    SVO_I_TRY(svo_i_compute_check(compute, "glMapBufferRange"));
    if (mapped == NULL) {
        return svo_i_device_fail(compute->device, SVO_GL_ERROR, SVO_I_GL_BUILD ": glMapBufferRange returned NULL");
    }
    const svo_status status = svo_i_commands_upload(&build->commands, name, mapped, bytes, out);
    const bool intact = gl->UnmapBuffer(WORK_TARGET) == GL_TRUE;
    SVO_I_TRY(status);
    if (!intact) {
        return svo_i_device_fail(compute->device, SVO_GL_ERROR,
                                 SVO_I_GL_BUILD ": glUnmapBuffer reports that the content of %s was lost", name);
    }
    return SVO_OK;
}

svo_status svo_i_compute_to_cl(svo_i_compute *compute, svo_i_build *build, GLuint buffer, const char *name,
                               uint64_t offset, uint64_t bytes, cl_mem *out)
{
    const svo_i_gl_functions *gl = compute->gl;
    if (bytes == 0) {
        return svo_i_commands_alloc(&build->commands, name, bytes, out);
    }
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(WORK_TARGET, buffer);
    const svo_status status = copy_bound_to_cl(compute, build, name, offset, bytes, out);
    gl->BindBuffer(WORK_TARGET, 0);
    return status;
}
