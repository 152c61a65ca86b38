/* SPDX-License-Identifier: MIT */
/*
 * svocl in a program with its own OpenGL: the mesh is in the program's vertex and index buffers, svocl rasterizes in
 * the program's context and restores its state, and the program copies the octree's child masks to a shader storage
 * buffer.
 */
#include <inttypes.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>

#include "svocl/gl.h"
#include "svocl/svocl.h"

/* Interleaved, as in many renderers. */
typedef struct vertex {
    float position[3];
    uint8_t color[4];
} vertex;

static const vertex vertices[8] = {{{0, 0, 0}, {0, 0, 0, 255}},     {{1, 0, 0}, {255, 0, 0, 255}},
                                   {{0, 1, 0}, {0, 255, 0, 255}},   {{1, 1, 0}, {255, 255, 0, 255}},
                                   {{0, 0, 1}, {0, 0, 255, 255}},   {{1, 0, 1}, {255, 0, 255, 255}},
                                   {{0, 1, 1}, {0, 255, 255, 255}}, {{1, 1, 1}, {255, 255, 255, 255}}};
static const uint16_t indices[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                     2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

/* The program's own OpenGL. */
typedef struct own_opengl {
    EGLDisplay display;
    EGLContext context;
    PFNGLGENBUFFERSPROC gen_buffers;
    PFNGLDELETEBUFFERSPROC delete_buffers;
    PFNGLBINDBUFFERPROC bind_buffer;
    PFNGLBUFFERDATAPROC buffer_data;
    PFNGLGETBUFFERSUBDATAPROC read_buffer;
    GLuint buffers[3]; /* vertices, indices, child masks */
} own_opengl;

static svo_gl_function find_function(void *user, const char *name)
{
    (void)user;
    return (svo_gl_function)eglGetProcAddress(name);
}

static bool open_opengl(own_opengl *own)
{
    static const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 3, EGL_NONE};
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    if (get_display == NULL)
        return false;
    own->display = get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
    if (own->display == EGL_NO_DISPLAY || !eglInitialize(own->display, NULL, NULL) || !eglBindAPI(EGL_OPENGL_API))
        return false;
    own->context = eglCreateContext(own->display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
    if (own->context == EGL_NO_CONTEXT || !eglMakeCurrent(own->display, EGL_NO_SURFACE, EGL_NO_SURFACE, own->context))
        return false;
    own->gen_buffers = (PFNGLGENBUFFERSPROC)eglGetProcAddress("glGenBuffers");
    own->delete_buffers = (PFNGLDELETEBUFFERSPROC)eglGetProcAddress("glDeleteBuffers");
    own->bind_buffer = (PFNGLBINDBUFFERPROC)eglGetProcAddress("glBindBuffer");
    own->buffer_data = (PFNGLBUFFERDATAPROC)eglGetProcAddress("glBufferData");
    own->read_buffer = (PFNGLGETBUFFERSUBDATAPROC)eglGetProcAddress("glGetBufferSubData");
    return true;
}

/* Puts the mesh into vertex and index buffers, as a renderer does. */
static svo_mesh_buffers make_mesh(own_opengl *own)
{
    own->gen_buffers(3, own->buffers);
    own->bind_buffer(GL_ARRAY_BUFFER, own->buffers[0]);
    own->buffer_data(GL_ARRAY_BUFFER, sizeof vertices, vertices, GL_STATIC_DRAW);
    own->bind_buffer(GL_ARRAY_BUFFER, own->buffers[1]);
    own->buffer_data(GL_ARRAY_BUFFER, sizeof indices, indices, GL_STATIC_DRAW);
    return (svo_mesh_buffers){
        .struct_size = sizeof(svo_mesh_buffers),
        .vertex_count = 8,
        .triangle_count = 12,
        .positions = {.gl_buffer = own->buffers[0], .stride_bytes = sizeof(vertex)},
        .colors = {.gl_buffer = own->buffers[0],
                   .offset_bytes = offsetof(vertex, color),
                   .stride_bytes = sizeof(vertex)},
        .indices = {.gl_buffer = own->buffers[1]},
        .index_bytes = 2,
    };
}

static void close_opengl(own_opengl *own)
{
    if (own->gen_buffers != NULL)
        own->delete_buffers(3, own->buffers);
    if (own->display != EGL_NO_DISPLAY) {
        eglMakeCurrent(own->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        eglDestroyContext(own->display, own->context);
        eglTerminate(own->display);
    }
}

/* What svocl holds while the tree is built. */
typedef struct builder {
    svo_gl_context *context;
    svo_device *device;
    cl_command_queue queue;
    svo_gl *gl;
    svo_mesh_copy *mesh;
    svo_plan *plan;
    svo_tree *tree;
    svo_message message;
} builder;

static bool build(builder *b, const svo_mesh_buffers *mesh)
{
    const svo_gl_context_options current = {
        .struct_size = sizeof current, .kind = SVO_GL_WRAPPED, .get_proc_address = find_function};
    svo_device_info on = SVO_DEVICE_INFO_INIT;
    bool done = svo_gl_context_create(&current, &b->context, &b->message) == SVO_OK &&
                svo_gl_device_create(b->context, NULL, NULL, &b->device, &b->message) == SVO_OK &&
                svo_gl_mesh_read(mesh, b->context, 0, NULL, &b->mesh, &b->message) == SVO_OK &&
                svo_gl_create(b->device, b->context, NULL, &b->gl) == SVO_OK &&
                svo_device_get_info(b->device, &on) == SVO_OK;
    if (done)
        b->queue = clCreateCommandQueue(on.context, on.device, 0, NULL);
    svo_build_report report = SVO_BUILD_REPORT_INIT;
    svo_tree_info info = SVO_TREE_INFO_INIT;
    done = b->queue != NULL && svo_plan_create(b->device, svo_mesh_copy_get(b->mesh), 7, NULL, &b->plan) == SVO_OK &&
           svo_build(b->plan, svo_gl_frontend(b->gl), b->queue, &b->tree, &report) == SVO_OK;
    if (done) {
        svo_tree_get_info(b->tree, &info);
        printf("%" PRIu64 " leaves by share %s on %s\n", info.leaf_count, report.share, report.renderer);
    } else {
        fprintf(stderr, "%s\n", b->message.text[0] != '\0' ? b->message.text : svo_device_message(b->device));
    }
    return done;
}

/* Everything but the queue; the OpenGL context is the program's and stays. */
static void release(builder *b)
{
    svo_tree_destroy(&b->tree);
    svo_plan_destroy(&b->plan);
    svo_mesh_copy_destroy(&b->mesh);
    svo_gl_destroy(&b->gl);
    svo_device_destroy(&b->device);
    svo_gl_context_destroy(&b->context);
}

/* Copies the tree's buffer, which was retained and outlives the tree, to an OpenGL buffer of the program. */
static bool take_masks(const own_opengl *own, cl_command_queue queue, cl_mem masks)
{
    size_t bytes = 0;
    uint8_t root = 0;
    clGetMemObjectInfo(masks, CL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    uint8_t *host = malloc(bytes);
    const bool done =
        host != NULL && clEnqueueReadBuffer(queue, masks, CL_TRUE, 0, bytes, host, 0, NULL, NULL) == CL_SUCCESS;
    if (done) {
        own->bind_buffer(GL_SHADER_STORAGE_BUFFER, own->buffers[2]);
        own->buffer_data(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)bytes, host, GL_STATIC_DRAW);
        own->read_buffer(GL_SHADER_STORAGE_BUFFER, 0, 1, &root);
        printf("%zu child masks in OpenGL, the root's is %02x\n", bytes, root);
    } else {
        fprintf(stderr, "the child masks cannot be read\n");
    }
    free(host);
    return done;
}

int main(void)
{
    own_opengl own = {.display = EGL_NO_DISPLAY};
    builder b = {0};
    if (!open_opengl(&own)) {
        fprintf(stderr, "no OpenGL 4.3 context on EGL's surfaceless platform\n");
        close_opengl(&own);
        return 1;
    }
    const svo_mesh_buffers mesh = make_mesh(&own);
    bool done = build(&b, &mesh);
    cl_mem masks = done ? svo_tree_get_buffer(b.tree, SVO_TREE_CHILD_MASK) : NULL;
    if (done)
        clRetainMemObject(masks);
    release(&b);
    done = done && take_masks(&own, b.queue, masks);
    if (masks != NULL)
        clReleaseMemObject(masks);
    if (b.queue != NULL)
        clReleaseCommandQueue(b.queue);
    close_opengl(&own);
    return done ? 0 : 1;
}
