/* SPDX-License-Identifier: MIT */
/* Opens devices and contexts and runs small kernels. Every failure fails the running test. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "machine.h"
#include "support/gl_contexts.h"
#include "support/info_of.h"

svo_device *machine_device_or_skip(void)
{
    svo_message message = {""};
    svo_device *device = NULL;
    const svo_status status = svo_device_create_default(NULL, &device, &message);
    if (status == SVO_NO_DEVICE) {
        print_message("skipped: %s\n", message.text);
        skip();
    }
    if (status != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return device;
}

svo_gl_context *machine_context_or_null(svo_gl_context_kind kind)
{
    svo_message message = {""};
    svo_gl_context *context = NULL;
    if (kind == SVO_GL_EGL_DEVICE && svo_gl_egl_device_count() == 0) {
        print_message("skipped: no EGL device\n");
        return NULL;
    }
    const svo_status status = context_of_kind(kind, 0, &context, &message);
    const bool absent = strstr(message.text, "cannot open shared object file") != NULL ||
                        strstr(message.text, "EGL does not list") != NULL;
    if (status == SVO_NO_GL && absent) {
        print_message("skipped: %s\n", message.text);
        return NULL;
    }
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_GL_CONTEXT_KIND, kind), message.text);
    }
    return context;
}

svo_gl_context *machine_any_context_or_skip(void)
{
    for (int kind = 0; kind < SVO_GL_CONTEXT_KINDS; ++kind) {
        svo_gl_context *context = machine_context_or_null((svo_gl_context_kind)kind);
        if (context != NULL) {
            return context;
        }
    }
    skip();
    return NULL;
}

static uint32_t group_count(const machine_job *job)
{
    return (job->item_count + MACHINE_GROUP_ITEMS - 1) / MACHINE_GROUP_ITEMS;
}

static cl_program build_program(const svo_device *device, const char *source, const char *options)
{
    const cl_device_id id = info_of_device(device).device;
    cl_int error = CL_SUCCESS;
    cl_program program = clCreateProgramWithSource(info_of_device(device).context, 1, &source, NULL, &error);
    assert_int_equal(error, CL_SUCCESS);
    if (clBuildProgram(program, 1, &id, options, NULL, NULL) != CL_SUCCESS) {
        char log[8192] = "";
        clGetProgramBuildInfo(program, id, CL_PROGRAM_BUILD_LOG, sizeof log - 1, log, NULL);
        fail_msg("%s: %s", options, log);
    }
    return program;
}

static cl_mem make_buffer(const svo_device *device, size_t bytes)
{
    cl_int error = CL_SUCCESS;
    cl_mem buffer = clCreateBuffer(info_of_device(device).context, CL_MEM_READ_WRITE, bytes, NULL, &error);
    assert_int_equal(error, CL_SUCCESS);
    return buffer;
}

static void launch(cl_command_queue queue, cl_kernel kernel, const machine_job *job, cl_mem input, cl_mem output)
{
    const cl_uint item_count = job->item_count;
    const size_t local = MACHINE_GROUP_ITEMS;
    const size_t global = group_count(job) * local;
    assert_int_equal(clEnqueueWriteBuffer(queue, input, CL_TRUE, 0, job->input_bytes, job->input, 0, NULL, NULL), 0);
    assert_int_equal(clEnqueueWriteBuffer(queue, output, CL_TRUE, 0, job->output_bytes, job->output, 0, NULL, NULL), 0);
    assert_int_equal(clSetKernelArg(kernel, 0, sizeof(cl_mem), &input), CL_SUCCESS);
    assert_int_equal(clSetKernelArg(kernel, 1, sizeof(cl_mem), &output), CL_SUCCESS);
    assert_int_equal(clSetKernelArg(kernel, 2, sizeof item_count, &item_count), CL_SUCCESS);
    assert_int_equal(clEnqueueNDRangeKernel(queue, kernel, 1, NULL, &global, &local, 0, NULL, NULL), CL_SUCCESS);
    assert_int_equal(clEnqueueReadBuffer(queue, output, CL_TRUE, 0, job->output_bytes, job->output, 0, NULL, NULL), 0);
}

void machine_run_kernel(const svo_device *device, const char *source, const char *options, const char *kernel_name,
                        const machine_job *job)
{
    cl_int error = CL_SUCCESS;
    cl_program program = build_program(device, source, options);
    cl_kernel kernel = clCreateKernel(program, kernel_name, &error);
    assert_int_equal(error, CL_SUCCESS);
    cl_command_queue queue =
        clCreateCommandQueue(info_of_device(device).context, info_of_device(device).device, 0, &error);
    assert_int_equal(error, CL_SUCCESS);
    cl_mem input = make_buffer(device, job->input_bytes);
    cl_mem output = make_buffer(device, job->output_bytes);
    memset(job->output, 0, job->output_bytes);
    launch(queue, kernel, job, input, output);
    clReleaseMemObject(input);
    clReleaseMemObject(output);
    clReleaseCommandQueue(queue);
    clReleaseKernel(kernel);
    clReleaseProgram(program);
}

static GLuint compile_shader(const svo_i_gl_functions *gl, const char *prologue, const char *source)
{
    const char *texts[] = {"#version 430 core\n", prologue, source};
    const GLuint shader = gl->CreateShader(GL_COMPUTE_SHADER);
    gl->ShaderSource(shader, 3, texts, NULL);
    gl->CompileShader(shader);
    GLint compiled = GL_FALSE;
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled != GL_TRUE) {
        char log[4096] = "";
        gl->GetShaderInfoLog(shader, sizeof log, NULL, log);
        fail_msg("%s: %s%s", gl->renderer, prologue, log);
    }
    return shader;
}

static GLuint link_program(const svo_i_gl_functions *gl, GLuint shader)
{
    const GLuint program = gl->CreateProgram();
    gl->AttachShader(program, shader);
    gl->LinkProgram(program);
    GLint linked = GL_FALSE;
    gl->GetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked != GL_TRUE) {
        char log[4096] = "";
        gl->GetProgramInfoLog(program, sizeof log, NULL, log);
        fail_msg("%s: %s", gl->renderer, log);
    }
    return program;
}

static void dispatch(const svo_i_gl_functions *gl, GLuint program, const machine_job *job)
{
    GLuint buffers[2] = {0, 0};
    const void *data[2] = {job->input, job->output};
    const size_t bytes[2] = {job->input_bytes, job->output_bytes};
    gl->GenBuffers(2, buffers);
    for (GLuint i = 0; i < 2; ++i) {
        gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffers[i]);
        gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)bytes[i], data[i], GL_STATIC_DRAW);
        gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, i, buffers[i]);
    }
    gl->UseProgram(program);
    gl->Uniform1ui(gl->GetUniformLocation(program, "item_count"), job->item_count);
    gl->DispatchCompute(group_count(job), 1, 1);
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffers[1]);
    gl->GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)bytes[1], job->output);
    gl->UseProgram(0);
    gl->DeleteBuffers(2, buffers);
}

void machine_run_shader(svo_gl_context *context, const char *prologue, const char *source, const machine_job *job)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(context);
    svo_message message = {""};
    if (svo_i_gl_context_make_current(context, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    const GLuint shader = compile_shader(gl, prologue, source);
    const GLuint program = link_program(gl, shader);
    memset(job->output, 0, job->output_bytes);
    dispatch(gl, program, job);
    gl->DeleteProgram(program);
    gl->DeleteShader(shader);
    const svo_status status = svo_i_gl_check(gl, "machine_run_shader", "running a shader", &message);
    svo_i_gl_context_release_current(context);
    if (status != SVO_OK) {
        fail_msg("%s", message.text);
    }
}
