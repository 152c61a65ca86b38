/* SPDX-License-Identifier: MIT */
/* Emulates cl_khr_gl_sharing by copies. */
#define _POSIX_C_SOURCE 200809L
#include "gl_interop_shim.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

enum { OBJECTS_MAX = 256, CONTEXTS_MAX = 16, PROPERTIES_MAX = 8 };

typedef struct shared_object {
    cl_mem memory;
    GLuint name;
    size_t bytes;
    bool acquired, acquired_before;
} shared_object;

typedef struct joined_context {
    cl_context context;
    cl_context_properties properties[PROPERTIES_MAX];
    size_t bytes;
} joined_context;

/* The driver's state. */
static struct {
    svo_gl_context *context;
    svo_i_gl_functions honest; /* the context's original functions */
    const svo_i_gl_platform *honest_platform;
    svo_i_gl_platform platform; /* the same, by its own account of GLX */
    shim_faults faults;
    shim_counts counts;
    bool finished; /* glFinish since the last acquire */
    shared_object objects[OBJECTS_MAX];
    joined_context contexts[CONTEXTS_MAX];
    unsigned context_count;
} shim;

static void violate(const char *what)
{
    ++shim.counts.violations;
    shim.counts.last_violation = what;
}

static void expect_current(void)
{
    if (!shim.context->platform->is_current(shim.context->native)) {
        violate("the OpenGL context is not current");
    }
}

static cl_int give_bytes(const void *from, size_t from_bytes, size_t bytes, void *value, size_t *value_bytes)
{
    if (value_bytes != NULL) {
        *value_bytes = from_bytes;
    }
    if (value != NULL && bytes < from_bytes) {
        return CL_INVALID_VALUE;
    }
    if (value != NULL) {
        memcpy(value, from, from_bytes);
    }
    return CL_SUCCESS;
}

static cl_int CL_API_CALL get_device_info(cl_device_id device, cl_device_info what, size_t bytes, void *value,
                                          size_t *value_bytes)
{
    if (what != CL_DEVICE_EXTENSIONS) {
        return clGetDeviceInfo(device, what, bytes, value, value_bytes);
    }
    const char *list =
        shim.faults.extensions != NULL ? shim.faults.extensions : "cl_khr_fp64 cl_khr_gl_sharing cl_khr_gl_event";
    return give_bytes(list, strlen(list) + 1, bytes, value, value_bytes);
}

/* The value of a context property, or 0. */
static cl_context_properties property_of(const cl_context_properties *properties, cl_context_properties key)
{
    for (; properties != NULL && *properties != 0; properties += 2) {
        if (properties[0] == key) {
            return properties[1];
        }
    }
    return 0;
}

static bool names_the_context(const cl_context_properties *properties)
{
    const svo_i_gl_handles handles = shim.context->platform->handles(shim.context->native);
    const bool is_glx = handles.system == SVO_I_GL_SYSTEM_GLX;
    return property_of(properties, CL_GL_CONTEXT_KHR) == (cl_context_properties)handles.context &&
           property_of(properties, is_glx ? CL_GLX_DISPLAY_KHR : CL_EGL_DISPLAY_KHR) ==
               (cl_context_properties)handles.display &&
           property_of(properties, is_glx ? CL_EGL_DISPLAY_KHR : CL_GLX_DISPLAY_KHR) == 0;
}

static cl_int CL_API_CALL get_context_info(cl_context context, cl_context_info what, size_t bytes, void *value,
                                           size_t *value_bytes)
{
    for (unsigned i = 0; i < shim.context_count && what == CL_CONTEXT_PROPERTIES; ++i) {
        if (shim.contexts[i].context == context) {
            return give_bytes(shim.contexts[i].properties, shim.contexts[i].bytes, bytes, value, value_bytes);
        }
    }
    return clGetContextInfo(context, what, bytes, value, value_bytes);
}

static cl_context CL_API_CALL create_context(const cl_context_properties *properties, cl_uint device_count,
                                             const cl_device_id *devices,
                                             void(CL_CALLBACK *notify)(const char *, const void *, size_t, void *),
                                             void *user, cl_int *error)
{
    *error = shim.faults.context_error;
    if (*error == CL_SUCCESS && !names_the_context(properties)) {
        *error = CL_INVALID_GL_SHAREGROUP_REFERENCE_KHR;
    }
    if (*error != CL_SUCCESS) {
        return NULL;
    }
    expect_current();
    cl_context created = clCreateContext(NULL, device_count, devices, notify, user, error);
    assert_true(shim.context_count < CONTEXTS_MAX);
    joined_context *joined = &shim.contexts[shim.context_count++];
    joined->context = created;
    for (joined->bytes = sizeof *properties; *properties != 0; properties += 2) {
        const size_t count = joined->bytes / sizeof *properties - 1;
        assert_true(count + 3 <= PROPERTIES_MAX);
        memcpy(joined->properties + count, properties, 2 * sizeof *properties);
        joined->bytes += 2 * sizeof *properties;
    }
    return created;
}

static cl_int CL_API_CALL get_gl_context_info(const cl_context_properties *properties, cl_gl_context_info what,
                                              size_t bytes, void *value, size_t *value_bytes)
{
    if (shim.faults.info_error != CL_SUCCESS) {
        return shim.faults.info_error;
    }
    if (what != CL_DEVICES_FOR_GL_CONTEXT_KHR) {
        return CL_INVALID_VALUE;
    }
    if (!names_the_context(properties)) {
        return CL_INVALID_GL_SHAREGROUP_REFERENCE_KHR;
    }
    cl_device_id devices[8];
    cl_uint count = 0;
    const cl_platform_id platform = (cl_platform_id)property_of(properties, CL_CONTEXT_PLATFORM);
    assert_int_equal(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 8, devices, &count), CL_SUCCESS);
    count = shim.faults.lists_no_device ? 0 : count < 8 ? count : 8;
    return give_bytes(devices, count * sizeof devices[0], bytes, value, value_bytes);
}

static void CL_CALLBACK forget_object(cl_mem memory, void *user)
{
    shared_object *object = user;
    if (object->memory == memory) {
        if (object->acquired) {
            violate("released while acquired");
        }
        *object = (shared_object){0};
        --shim.counts.objects;
    }
}

static bool is_joined(cl_context context)
{
    for (unsigned i = 0; i < shim.context_count; ++i) {
        if (shim.contexts[i].context == context) {
            return true;
        }
    }
    return false;
}

/* The call's injected error, after the spared calls. */
static cl_int fault(cl_int error, unsigned earlier_calls)
{
    return earlier_calls >= shim.faults.spared_calls ? error : CL_SUCCESS;
}

static size_t gl_buffer_bytes(GLuint name)
{
    GLint64 bytes = 0;
    shim.honest.BindBuffer(GL_COPY_WRITE_BUFFER, name);
    shim.honest.GetBufferParameteri64v(GL_COPY_WRITE_BUFFER, GL_BUFFER_SIZE, &bytes);
    shim.honest.BindBuffer(GL_COPY_WRITE_BUFFER, 0);
    return (size_t)bytes;
}

static cl_mem CL_API_CALL create_from_gl_buffer(cl_context context, cl_mem_flags flags, cl_GLuint name, cl_int *error)
{
    expect_current();
    *error = is_joined(context) ? fault(shim.faults.create_error, shim.counts.created++) : CL_INVALID_CONTEXT;
    if (*error != CL_SUCCESS) {
        return NULL;
    }
    shared_object *object = shim.objects;
    while (object->memory != NULL) {
        ++object;
        assert_true(object < shim.objects + OBJECTS_MAX);
    }
    *object = (shared_object){.name = name, .bytes = gl_buffer_bytes(name)};
    object->memory = clCreateBuffer(context, flags, object->bytes, NULL, error);
    if (*error == CL_SUCCESS) {
        ++shim.counts.objects;
        assert_int_equal(clSetMemObjectDestructorCallback(object->memory, forget_object, object), CL_SUCCESS);
    }
    return object->memory;
}

static shared_object *find_object(cl_mem memory)
{
    for (unsigned i = 0; i < OBJECTS_MAX; ++i) {
        if (shim.objects[i].memory == memory) {
            return &shim.objects[i];
        }
    }
    return NULL;
}

static cl_int copy_to_cl(shared_object *object, cl_command_queue queue, cl_uint wait_count, const cl_event *wait,
                         cl_event *event)
{
    if (shim.faults.acquires_nothing && object->acquired_before) {
        return clEnqueueMarkerWithWaitList(queue, wait_count, wait, event);
    }
    cl_uint *words = malloc(object->bytes);
    assert_non_null(words);
    shim.honest.BindBuffer(GL_COPY_WRITE_BUFFER, object->name);
    shim.honest.GetBufferSubData(GL_COPY_WRITE_BUFFER, 0, (GLsizeiptr)object->bytes, words);
    shim.honest.BindBuffer(GL_COPY_WRITE_BUFFER, 0);
    if (shim.faults.corrupts) {
        words[object->bytes / 8] ^= 0x10000u;
    }
    const cl_int error =
        clEnqueueWriteBuffer(queue, object->memory, CL_TRUE, 0, object->bytes, words, wait_count, wait, event);
    free(words);
    return error;
}

/* Calls one for each object, each after the one before; event: of the last. */
static cl_int each_object(cl_command_queue queue, cl_uint count, const cl_mem *objects, cl_uint wait_count,
                          const cl_event *wait, cl_event *event,
                          cl_int (*one)(shared_object *, cl_command_queue, cl_uint, const cl_event *, cl_event *))
{
    cl_event last = NULL;
    cl_int error = count > 0 ? CL_SUCCESS : CL_INVALID_VALUE;
    for (cl_uint i = 0; i < count; ++i) {
        shared_object *object = find_object(objects[i]);
        cl_event next = NULL;
        const cl_int failed =
            object == NULL ? CL_INVALID_GL_OBJECT
                           : one(object, queue, last != NULL ? 1 : wait_count, last != NULL ? &last : wait, &next);
        error = error == CL_SUCCESS ? failed : error;
        if (last != NULL) {
            clReleaseEvent(last);
        }
        last = next;
    }
    if (event != NULL && error == CL_SUCCESS) {
        *event = last;
    } else if (last != NULL) {
        clReleaseEvent(last);
    }
    return error;
}

static cl_int acquire_one(shared_object *object, cl_command_queue queue, cl_uint wait_count, const cl_event *wait,
                          cl_event *event)
{
    if (object->acquired) {
        violate("acquired twice");
    }
    const cl_int copied = copy_to_cl(object, queue, wait_count, wait, event);
    object->acquired = object->acquired_before = true;
    return copied;
}

static cl_int CL_API_CALL acquire(cl_command_queue queue, cl_uint count, const cl_mem *objects, cl_uint wait_count,
                                  const cl_event *wait, cl_event *event)
{
    expect_current();
    if (!shim.finished && shim.faults.extensions != NULL && strstr(shim.faults.extensions, "gl_event") == NULL) {
        violate("acquired without glFinish");
    }
    shim.finished = false;
    const cl_int error = fault(shim.faults.acquire_error, shim.counts.acquired);
    shim.counts.acquired += count;
    if (error != CL_SUCCESS) {
        return error;
    }
    return each_object(queue, count, objects, wait_count, wait, event, acquire_one);
}

static cl_int copy_to_gl(const shared_object *object, cl_command_queue queue, cl_uint wait_count, const cl_event *wait,
                         cl_event *event)
{
    if (shim.faults.releases_nothing) {
        return clEnqueueMarkerWithWaitList(queue, wait_count, wait, event);
    }
    void *bytes = malloc(object->bytes);
    assert_non_null(bytes);
    const cl_int error =
        clEnqueueReadBuffer(queue, object->memory, CL_TRUE, 0, object->bytes, bytes, wait_count, wait, event);
    shim.honest.BindBuffer(GL_COPY_WRITE_BUFFER, object->name);
    shim.honest.BufferSubData(GL_COPY_WRITE_BUFFER, 0, (GLsizeiptr)object->bytes, bytes);
    shim.honest.BindBuffer(GL_COPY_WRITE_BUFFER, 0);
    free(bytes);
    return error;
}

static cl_int release_one(shared_object *object, cl_command_queue queue, cl_uint wait_count, const cl_event *wait,
                          cl_event *event)
{
    if (!object->acquired) {
        violate("released without being acquired");
    }
    object->acquired = false;
    ++shim.counts.released;
    return copy_to_gl(object, queue, wait_count, wait, event);
}

/* What a failed call has not given back is not acquired either, and may be destroyed. */
static cl_int fail_to_release_one(shared_object *object, cl_command_queue queue, cl_uint wait_count,
                                  const cl_event *wait, cl_event *event)
{
    (void)queue;
    (void)wait_count;
    (void)wait;
    (void)event;
    ++shim.counts.released;
    object->acquired = false;
    return shim.faults.release_error;
}

static cl_int CL_API_CALL release(cl_command_queue queue, cl_uint count, const cl_mem *objects, cl_uint wait_count,
                                  const cl_event *wait, cl_event *event)
{
    expect_current();
    const cl_int error = fault(shim.faults.release_error, shim.counts.released);
    return each_object(queue, count, objects, wait_count, wait, event,
                       error == CL_SUCCESS ? release_one : fail_to_release_one);
}

static void *CL_API_CALL get_function(cl_platform_id platform, const char *name)
{
    static const struct {
        const char *name;
        void (*function)(void);
    } functions[] = {{"clGetGLContextInfoKHR", (void (*)(void))get_gl_context_info},
                     {"clCreateFromGLBuffer", (void (*)(void))create_from_gl_buffer},
                     {"clEnqueueAcquireGLObjects", (void (*)(void))acquire},
                     {"clEnqueueReleaseGLObjects", (void (*)(void))release}};
    (void)platform;
    void *address = NULL;
    for (size_t i = 0; i < sizeof functions / sizeof functions[0]; ++i) {
        const bool missing = shim.faults.missing_function != NULL && strcmp(shim.faults.missing_function, name) == 0;
        if (strcmp(functions[i].name, name) == 0 && !missing) {
            memcpy(&address, &functions[i].function, sizeof address);
        }
    }
    return address;
}

static const svo_i_opencl shim_opencl = {
    .GetDeviceInfo = get_device_info,
    .GetContextInfo = get_context_info,
    .CreateContext = create_context,
    .GetExtensionFunctionAddressForPlatform = get_function,
};

static svo_i_gl_handles glx_handles(void *native)
{
    svo_i_gl_handles handles = shim.honest_platform->handles(native);
    handles.system = SVO_I_GL_SYSTEM_GLX;
    return handles;
}

static void APIENTRY note_finish(void)
{
    shim.finished = true;
    ++shim.counts.finishes;
    shim.honest.Finish();
}

void shim_install(svo_gl_context *context, const shim_faults *faults)
{
    memset(&shim, 0, sizeof shim);
    shim.context = context;
    shim.honest = context->functions;
    shim.faults = *faults;
    shim.honest_platform = context->platform;
    shim.platform = *context->platform;
    shim.platform.handles = faults->is_glx ? glx_handles : context->platform->handles;
    context->platform = &shim.platform;
    context->opencl = &shim_opencl;
    context->functions.Finish = note_finish;
}

void shim_set_faults(const shim_faults *faults)
{
    shim.faults = *faults;
}

void shim_get_counts(shim_counts *counts)
{
    *counts = shim.counts;
}

void shim_remove(svo_gl_context *context)
{
    context->platform = shim.honest_platform;
    context->opencl = &svo_i_opencl_installed;
    context->functions.Finish = shim.honest.Finish;
}

void shim_end(svo_gl_context *context)
{
    for (int i = 0; shim.counts.objects > 0 && i < 2000; ++i) { /* destroyed a moment after their last command */
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    }
    if (shim.counts.violations != 0) {
        fail_msg("%u violations, the last: %s", shim.counts.violations, shim.counts.last_violation);
    }
    assert_int_equal(shim.counts.objects, 0);
    shim_remove(context);
}
