/* SPDX-License-Identifier: MIT */
/* Reads meshes from OpenGL buffers to the host; lib/core/mesh.c packs them. */
#include "context/context.h"
#include "core/device.h"
#include "core/mesh.h"
#include "core/message.h"

#define FUNCTION "svo_gl_mesh_read"
/* No draw reads from this binding point; state.c restores it. */
#define WORK_TARGET GL_COPY_READ_BUFFER

static bool has_name(const svo_mesh_view *view)
{
    return view->gl_buffer != 0;
}

/* For a name that is no buffer, glBindBuffer fails in a core profile and creates one in other profiles. */
static svo_status bind_view(const svo_i_gl_functions *gl, const svo_mesh_view *view, svo_message *message)
{
    const bool is_buffer = gl->IsBuffer(view->gl_buffer) == GL_TRUE;
    SVO_I_TRY(svo_i_gl_check(gl, FUNCTION, "glIsBuffer", message));
    if (!is_buffer) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, FUNCTION ": %u is no buffer of the context", view->gl_buffer);
    }
    gl->BindBuffer(WORK_TARGET, view->gl_buffer);
    return svo_i_gl_check(gl, FUNCTION, "glBindBuffer", message);
}

static svo_status buffer_size(void *self, const char *name, const svo_mesh_view *view, size_t *bytes,
                              svo_message *message)
{
    (void)name;
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(self);
    GLint64 held_bytes = 0;
    SVO_I_TRY(bind_view(gl, view, message));
    gl->GetBufferParameteri64v(WORK_TARGET, GL_BUFFER_SIZE, &held_bytes);
    *bytes = held_bytes > 0 ? (size_t)held_bytes : 0;
    return svo_i_gl_check(gl, FUNCTION, "glGetBufferParameteri64v", message);
}

static svo_status read_buffer(void *self, const svo_mesh_view *view, size_t offset_bytes, size_t bytes, void *to,
                              svo_message *message)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(self);
    SVO_I_TRY(bind_view(gl, view, message));
    gl->GetBufferSubData(WORK_TARGET, (GLintptr)offset_bytes, (GLsizeiptr)bytes, to);
    return svo_i_gl_check(gl, FUNCTION, "glGetBufferSubData", message);
}

/* One by one: the host waits, so the events may be of different contexts. */
static svo_status wait_for(cl_uint num_wait, const cl_event *wait, svo_message *message)
{
    cl_int error = CL_SUCCESS;
    if ((num_wait > 0) != (wait != NULL)) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, FUNCTION ": num_wait and wait disagree");
    }
    for (cl_uint i = 0; i < num_wait && error == CL_SUCCESS; ++i) {
        error = clWaitForEvents(1, &wait[i]);
    }
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_fail(message, SVO_CL_ERROR, FUNCTION ": clWaitForEvents failed with %s (%d)",
                                            svo_i_cl_error_name(error), error);
}

static svo_status read_current(const svo_mesh_buffers *buffers, svo_gl_context *context, svo_mesh_copy **out,
                               svo_message *message)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(context);
    const svo_i_mesh_reader reader = {
        .function = FUNCTION, .self = context, .has = has_name, .size = buffer_size, .read = read_buffer};
    svo_i_gl_clear_errors(gl);
    /* Makes writes by shaders visible. */
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    return svo_i_mesh_read(buffers, &reader, out, message);
}

svo_status svo_gl_mesh_read(const svo_mesh_buffers *buffers, svo_gl_context *context, cl_uint num_wait,
                            const cl_event *wait, svo_mesh_copy **out, svo_message *message)
{
    if (buffers == NULL || context == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, FUNCTION ": %s is NULL",
                          buffers == NULL   ? "buffers"
                          : context == NULL ? "context"
                                            : "out");
    }
    SVO_I_TRY(wait_for(num_wait, wait, message));
    SVO_I_TRY(svo_i_gl_context_make_current(context, message));
    const svo_status status = read_current(buffers, context, out, message);
    svo_i_gl_context_release_current(context);
    return status;
}
