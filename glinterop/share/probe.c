/* SPDX-License-Identifier: MIT */
/*
 * Finds which share paths work on a pair of device and context, and why the others do not. Called once per svo_gl and
 * per svo_gl_buffer.
 *
 * A trial may end the process, so `interop` proceeds step by step, and each step runs only after the previous one has
 * shown that it is safe (interop.h). `host` is safe to try. Both end in a self-test.
 */
#include "share/probe.h"

#include <stdio.h>

#include "core/message.h"
#include "core/staging.h"
#include "share/interop.h"
#include "share/share.h"

enum { TEST_WORDS = 16 * 1024 + 3, TEST_BYTES = TEST_WORDS * 4, TEST_SPLIT_WORDS = 5003, TEST_ROUNDS = 2 };

/* Two regions with two values, so that a stale buffer or a wrong offset fails. */
static cl_uint test_word(unsigned round, unsigned word)
{
    return (word < TEST_SPLIT_WORDS ? 0x5eed0001u : 0xc0ffee02u) + round;
}

/* OpenGL copies the pattern from a buffer of its own: a copy depends on none of the caller's state. */
static svo_status write_pattern(const svo_i_share_buffer *buffer, unsigned round, cl_uint *words)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(buffer->context);
    GLuint own = 0;
    for (unsigned i = 0; i < TEST_WORDS; ++i) {
        words[i] = test_word(round, i);
    }
    svo_i_gl_clear_errors(gl);
    gl->GenBuffers(1, &own);
    gl->BindBuffer(GL_COPY_READ_BUFFER, own);
    gl->BufferData(GL_COPY_READ_BUFFER, TEST_BYTES, words, GL_STREAM_COPY);
    gl->BindBuffer(GL_COPY_WRITE_BUFFER, buffer->name);
    gl->CopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, (GLintptr)buffer->offset_bytes, TEST_BYTES);
    gl->BindBuffer(GL_COPY_WRITE_BUFFER, 0);
    gl->BindBuffer(GL_COPY_READ_BUFFER, 0);
    gl->DeleteBuffers(1, &own);
    return svo_i_gl_check(gl, "svo_i_share_probe", "glCopyBufferSubData", &buffer->device->message);
}

/* OpenGL copies what it sees to a buffer of its own and reads it there. */
static svo_status read_pattern(const svo_i_share_buffer *buffer, cl_uint *words)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(buffer->context);
    GLuint own = 0;
    svo_i_gl_clear_errors(gl);
    gl->GenBuffers(1, &own);
    gl->BindBuffer(GL_COPY_WRITE_BUFFER, own);
    gl->BufferData(GL_COPY_WRITE_BUFFER, TEST_BYTES, NULL, GL_STREAM_READ);
    gl->BindBuffer(GL_COPY_READ_BUFFER, buffer->name);
    gl->CopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, (GLintptr)buffer->offset_bytes, 0, TEST_BYTES);
    gl->GetBufferSubData(GL_COPY_WRITE_BUFFER, 0, TEST_BYTES, words);
    gl->BindBuffer(GL_COPY_READ_BUFFER, 0);
    gl->BindBuffer(GL_COPY_WRITE_BUFFER, 0);
    gl->DeleteBuffers(1, &own);
    return svo_i_gl_check(gl, "svo_i_share_probe", "glGetBufferSubData", &buffer->device->message);
}

/* The device copies the shared bytes to a buffer of its own, so the result is what kernels would see. */
static svo_status compare_pattern(const svo_i_share_buffer *buffer, unsigned round, cl_mem own, cl_command_queue queue,
                                  cl_uint *words)
{
    svo_device *device = buffer->device;
    cl_event copied = NULL;
    cl_int error = clEnqueueCopyBuffer(queue, buffer->memory, own, 0, 0, TEST_BYTES, 0, NULL, &copied);
    if (error == CL_SUCCESS) {
        error = clEnqueueReadBuffer(queue, own, CL_TRUE, 0, TEST_BYTES, words, 1, &copied, NULL);
        clReleaseEvent(copied);
    }
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(device, "svo_i_share_probe", "clEnqueueCopyBuffer", error);
    }
    for (unsigned i = 0; i < TEST_WORDS; ++i) {
        if (words[i] != test_word(round, i)) {
            return svo_i_device_fail(device, SVO_UNSUPPORTED,
                                     "OpenCL reads 0x%08x at word %u where OpenGL wrote 0x%08x", words[i], i,
                                     test_word(round, i));
        }
    }
    return SVO_OK;
}

/* The other way round: the device writes, and OpenGL copies to a buffer of its own. */
static svo_status return_pattern(svo_i_share_buffer *buffer, unsigned round, cl_command_queue queue, cl_uint *words)
{
    svo_device *device = buffer->device;
    SVO_I_TRY(svo_i_share_buffer_begin_cl(buffer, queue));
    for (unsigned i = 0; i < TEST_WORDS; ++i) {
        words[i] = test_word(round, i);
    }
    SVO_I_TRY(svo_i_device_write(device, "svo_i_share_probe", queue, buffer->memory, 0, words, TEST_BYTES));
    SVO_I_TRY(svo_i_share_buffer_end_cl(buffer, TEST_BYTES, queue));
    SVO_I_TRY(read_pattern(buffer, words));
    for (unsigned i = 0; i < TEST_WORDS; ++i) {
        if (words[i] != test_word(round, i)) {
            return svo_i_device_fail(device, SVO_UNSUPPORTED,
                                     "OpenGL reads 0x%08x at word %u where OpenCL wrote 0x%08x", words[i], i,
                                     test_word(round, i));
        }
    }
    return SVO_OK;
}

static svo_status run_rounds(svo_i_share_buffer *buffer, cl_mem own, cl_command_queue queue, cl_uint *words)
{
    for (unsigned round = 0; round < TEST_ROUNDS; ++round) {
        SVO_I_TRY(svo_i_share_buffer_to_gl(buffer, queue));
        SVO_I_TRY(write_pattern(buffer, round, words));
        SVO_I_TRY(svo_i_share_buffer_to_cl(buffer, TEST_BYTES, queue));
        SVO_I_TRY(compare_pattern(buffer, round, own, queue, words));
    }
    for (unsigned round = TEST_ROUNDS; round < 2 * TEST_ROUNDS; ++round) {
        SVO_I_TRY(return_pattern(buffer, round, queue, words));
    }
    return SVO_OK;
}

/* OpenGL writes and OpenCL reads, twice; then the other way round. Expects the context current; the device's message
   says why it fails. */
static svo_status round_trip(svo_device *device, svo_gl_context *context, svo_gl_share share)
{
    svo_i_share_buffer buffer = {0};
    cl_mem own = NULL;
    cl_int error = CL_SUCCESS;
    cl_uint *words = svo_i_alloc(&device->memory, TEST_BYTES);
    cl_command_queue queue = clCreateCommandQueue(device->context, device->device, 0, &error);
    svo_status status = SVO_OK;
    if (words == NULL) {
        status = svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "no %d bytes for the self-test", (int)TEST_BYTES);
        goto cleanup;
    }
    if (error != CL_SUCCESS) {
        status = svo_i_device_fail_cl(device, "svo_i_share_probe", "clCreateCommandQueue", error);
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(
        svo_i_device_buffer(device, "svo_i_share_probe", "self-test", CL_MEM_READ_WRITE, TEST_BYTES, &own));
    SVO_I_TRY_CLEANUP(svo_i_share_buffer_create(device, context, share, TEST_BYTES, &buffer));
    SVO_I_TRY_CLEANUP(run_rounds(&buffer, own, queue, words));
cleanup:
    svo_i_share_buffer_destroy(&buffer);
    if (own != NULL) {
        clReleaseMemObject(own);
    }
    if (queue != NULL) {
        clReleaseCommandQueue(queue);
    }
    svo_i_free(words);
    return status;
}

/* SVO_OK if the pair can share and the device's OpenCL context was created for it. */
static svo_status check_interop(svo_device *device, svo_gl_context *context)
{
    svo_i_interop interop;
    cl_context joined = NULL;
    SVO_I_TRY(svo_i_interop_find(device, context, &interop, &device->message));
    if (svo_i_interop_is_joined(device, context)) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_interop_create_context(device, context, &joined, &device->message));
    clReleaseContext(joined);
    return svo_i_device_fail(device, SVO_UNSUPPORTED,
                             "the device's OpenCL context was not created against the OpenGL context "
                             "(svo_gl_device_create does that)");
}

static svo_status check_host(svo_device *device, const svo_gl_context *context)
{
    if (!device->is_cpu) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED, "%s is not a CPU device", device->name);
    }
    if (!device->cpu_path) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED, "%s takes the path of GPUs, which have memory of their own",
                                 device->name);
    }
    if (svo_i_gl_context_functions(context)->BufferStorage == NULL) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED,
                                 "the context has neither OpenGL 4.4 nor GL_ARB_buffer_storage");
    }
    return SVO_OK;
}

/* Expects the context current. */
static void probe_current(svo_device *device, svo_gl_context *context, svo_gl_share share, char *reason,
                          size_t reason_bytes)
{
    const svo_status possible =
        share == SVO_GL_SHARE_HOST ? check_host(device, context) : check_interop(device, context);
    if (possible != SVO_OK) {
        (void)snprintf(reason, reason_bytes, "%s", device->message.text);
    } else if (round_trip(device, context, share) != SVO_OK) {
        (void)snprintf(reason, reason_bytes, "the self-test failed: %s", device->message.text);
    }
}

/* The steps report through the device's message, which is restored. */
static void probe(svo_device *device, svo_gl_context *context, svo_gl_share share, char *reason, size_t reason_bytes)
{
    const svo_message before = device->message;
    if (svo_i_gl_context_make_current(context, &device->message) != SVO_OK) {
        (void)snprintf(reason, reason_bytes, "%s", device->message.text);
    } else {
        probe_current(device, context, share, reason, reason_bytes);
        svo_i_gl_context_release_current(context);
    }
    device->message = before;
}

void svo_i_share_probe(svo_device *device, svo_gl_context *context, svo_gl_share share, char *reason,
                       size_t reason_bytes)
{
    reason[0] = '\0';
    switch (share) {
    case SVO_GL_SHARE_INTEROP:
    case SVO_GL_SHARE_HOST:
        probe(device, context, share, reason, reason_bytes);
        break;
    case SVO_GL_SHARE_COPY: /* needs nothing beyond the front end's own requirements */
        break;
    case SVO_GL_SHARE_AUTO:
        (void)snprintf(reason, reason_bytes, "auto is not a share path");
        break;
    }
}

svo_status svo_i_share_choose(svo_device *device, svo_gl_context *context, const char *function, svo_gl_share asked,
                              svo_i_share_reasons *reasons, svo_gl_share *choice)
{
    for (svo_gl_share share = SVO_GL_SHARE_INTEROP; share <= SVO_GL_SHARE_COPY; ++share) {
        svo_i_share_probe(device, context, share, reasons->text[share], sizeof reasons->text[share]);
    }
    for (svo_gl_share share = SVO_GL_SHARE_INTEROP; share <= SVO_GL_SHARE_COPY; ++share) {
        const bool works = reasons->text[share][0] == '\0';
        if (asked == share && !works) {
            return svo_i_device_fail(device, SVO_UNSUPPORTED, "%s: share %s does not work: %s", function,
                                     svo_name(SVO_NAME_GL_SHARE, share), reasons->text[share]);
        }
        if (works && (asked == share || asked == SVO_GL_SHARE_AUTO)) {
            *choice = share;
            return SVO_OK;
        }
    }
    return svo_i_device_fail(device, SVO_UNSUPPORTED, "%s: no share path works: %s", function,
                             reasons->text[SVO_GL_SHARE_COPY]);
}
