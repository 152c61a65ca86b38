/* SPDX-License-Identifier: MIT */
/*
 * Which share path works on a pair of device and context, and why the others do not. Called once per svo_gl.
 *
 * Never by trial where a trial can end the process: some OpenCL drivers abort inside clCreateFromGLBuffer when the
 * extension is not there, so `sharing` goes by the device's extension list alone. `host` is safe to try and is tried.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "message.h"
#include "share.h"

enum { TEST_WORDS = 16 * 1024 + 3, TEST_BYTES = TEST_WORDS * 4, TEST_SPLIT_WORDS = 5003, TEST_ROUNDS = 2 };

static bool device_has_extension(const svo_device *device, const char *extension)
{
    size_t bytes = 0;
    if (clGetDeviceInfo(device->device, CL_DEVICE_EXTENSIONS, 0, NULL, &bytes) != CL_SUCCESS) {
        return false;
    }
    char *list = calloc(bytes + 1, 1);
    if (list == NULL) {
        return false;
    }
    bool found = clGetDeviceInfo(device->device, CL_DEVICE_EXTENSIONS, bytes, list, NULL) == CL_SUCCESS &&
                 svo_i_list_has_token(list, extension);
    free(list);
    return found;
}

static void probe_sharing(const svo_device *device, char *reason, size_t reason_bytes)
{
    if (!device_has_extension(device, "cl_khr_gl_sharing")) {
        (void)snprintf(reason, reason_bytes, "%s does not list cl_khr_gl_sharing", device->name);
        return;
    }
    (void)snprintf(reason, reason_bytes, "cl_khr_gl_sharing is not supported by this version of svocl");
}

/* Two regions with two values, so that neither a stale buffer nor a wrong offset passes. */
static cl_uint test_word(unsigned round, unsigned word)
{
    return (word < TEST_SPLIT_WORDS ? 0x5eed0001u : 0xc0ffee02u) + round;
}

static void clear_words(const svo_i_share_buffer *buffer, unsigned round, unsigned first_word, unsigned word_count)
{
    GLuint value = test_word(round, first_word);
    svo_i_gl_context_functions(buffer->context)
        ->ClearBufferSubData(GL_COPY_READ_BUFFER, GL_R32UI, (GLintptr)(buffer->offset_bytes + (size_t)first_word * 4),
                             (GLsizeiptr)word_count * 4, GL_RED_INTEGER, GL_UNSIGNED_INT, &value);
}

static svo_status write_pattern(const svo_i_share_buffer *buffer, unsigned round)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(buffer->context);
    svo_i_gl_clear_errors(gl);
    gl->BindBuffer(GL_COPY_READ_BUFFER, buffer->name);
    clear_words(buffer, round, 0, TEST_SPLIT_WORDS);
    clear_words(buffer, round, TEST_SPLIT_WORDS, TEST_WORDS - TEST_SPLIT_WORDS);
    gl->BindBuffer(GL_COPY_READ_BUFFER, 0);
    return svo_i_gl_check(gl, "svo_i_share_probe", "glClearBufferSubData", &buffer->device->message);
}

/* The device itself copies the shared bytes to a buffer of its own; what arrives there is what kernels would see. */
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

static svo_status run_rounds(svo_i_share_buffer *buffer, cl_mem own, cl_command_queue queue, cl_uint *words)
{
    svo_status status = SVO_OK;
    for (unsigned round = 0; round < TEST_ROUNDS && status == SVO_OK; ++round) {
        status = svo_i_share_buffer_to_gl(buffer, queue);
        if (status == SVO_OK) {
            status = write_pattern(buffer, round);
        }
        if (status == SVO_OK) {
            status = svo_i_share_buffer_to_cl(buffer, TEST_BYTES, queue);
        }
        if (status == SVO_OK) {
            status = compare_pattern(buffer, round, own, queue, words);
        }
    }
    return status;
}

/* OpenGL writes, OpenCL reads, twice. Expects the context current; the reason is left in the device's message. */
static svo_status round_trip(svo_device *device, svo_gl_context *context, svo_gl_share share)
{
    svo_i_share_buffer buffer = {0};
    cl_mem own = NULL;
    cl_int error = CL_SUCCESS;
    cl_uint *words = malloc(TEST_BYTES);
    cl_command_queue queue = clCreateCommandQueue(device->context, device->device, 0, &error);
    svo_status status = SVO_OK;
    if (words == NULL) {
        status = svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "no %d bytes for the self-test", (int)TEST_BYTES);
    } else if (error != CL_SUCCESS) {
        status = svo_i_device_fail_cl(device, "svo_i_share_probe", "clCreateCommandQueue", error);
    }
    if (status == SVO_OK) {
        status = svo_i_device_buffer(device, "svo_i_share_probe", "self-test", CL_MEM_READ_WRITE, TEST_BYTES, &own);
    }
    if (status == SVO_OK) {
        status = svo_i_share_buffer_create(device, context, share, TEST_BYTES, &buffer);
    }
    if (status == SVO_OK) {
        status = run_rounds(&buffer, own, queue, words);
    }
    svo_i_share_buffer_destroy(&buffer);
    if (own != NULL) {
        clReleaseMemObject(own);
    }
    if (queue != NULL) {
        clReleaseCommandQueue(queue);
    }
    free(words);
    return status;
}

static void probe_host(svo_device *device, svo_gl_context *context, char *reason, size_t reason_bytes)
{
    if (!device->is_cpu) {
        (void)snprintf(reason, reason_bytes, "%s is not a CPU device", device->name);
        return;
    }
    if (svo_i_gl_context_functions(context)->BufferStorage == NULL) {
        (void)snprintf(reason, reason_bytes, "the context has neither OpenGL 4.4 nor GL_ARB_buffer_storage");
        return;
    }
    svo_message before = device->message;
    svo_status status = svo_i_gl_context_make_current(context, &device->message);
    if (status == SVO_OK) {
        status = round_trip(device, context, SVO_GL_SHARE_HOST);
        svo_i_gl_context_release_current(context);
    }
    if (status != SVO_OK) {
        (void)snprintf(reason, reason_bytes, "the self-test failed: %s", device->message.text);
    }
    device->message = before;
}

void svo_i_share_probe(svo_device *device, svo_gl_context *context, svo_gl_share share, char *reason,
                       size_t reason_bytes)
{
    reason[0] = '\0';
    switch (share) {
    case SVO_GL_SHARE_SHARING:
        probe_sharing(device, reason, reason_bytes);
        break;
    case SVO_GL_SHARE_HOST:
        probe_host(device, context, reason, reason_bytes);
        break;
    case SVO_GL_SHARE_COPY: /* needs nothing that the front end does not need itself */
        break;
    case SVO_GL_SHARE_AUTO:
        (void)snprintf(reason, reason_bytes, "auto is not a share path");
        break;
    }
}
