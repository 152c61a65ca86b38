/* SPDX-License-Identifier: MIT */
/* Pictures from OpenCL to OpenGL by svo_gl_buffer; pictures and lines by OpenGL. */
#include "view/canvas.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- pixels from OpenCL ---- */

static int fail_device(const pixel_buffer *which, const svo_device *device)
{
    return program_fail_library(which->running, svo_device_message(device));
}

/* How pictures travel, and why not by cl_khr_gl_sharing. */
static void describe(const pixel_buffer *which, view_state *state)
{
    static const char *const ways[] = {"", "shared by both", "OpenCL draws into OpenGL's memory", "copied"};
    const svo_gl_share share = which->info.share;
    const char *reason = svo_gl_buffer_share_reason(which->buffer, SVO_GL_SHARE_INTEROP);
    state->share = svo_name(SVO_NAME_GL_SHARE, share);
    view_set_text(&state->share_reason, "%s%s%s", ways[share], reason[0] != '\0' ? "; " : "", reason);
    view_log(state, "pictures: %s, %s%s%s", state->share, ways[share], reason[0] != '\0' ? "; " : "", reason);
}

static int make(pixel_buffer *which, svo_device *device, size_t bytes, view_state *state)
{
    pixel_buffer_drop(which);
    which->info = (svo_gl_buffer_info)SVO_GL_BUFFER_INFO_INIT;
    if (svo_gl_buffer_create(device, which->context, bytes, SVO_GL_SHARE_AUTO, &which->buffer) != SVO_OK ||
        svo_gl_buffer_get_info(which->buffer, &which->info) != SVO_OK) {
        return fail_device(which, device);
    }
    if (which->device != device) {
        describe(which, state);
    }
    which->device = device;
    return PROGRAM_DONE;
}

int pixel_buffer_begin(pixel_buffer *which, svo_device *device, cl_command_queue queue, size_t bytes, view_state *state)
{
    const bool fits = which->buffer != NULL && which->device == device && which->info.bytes >= bytes;
    const int exit_code = fits ? PROGRAM_DONE : make(which, device, bytes, state);
    which->queue = queue;
    return exit_code != PROGRAM_DONE || svo_gl_buffer_to_cl(which->buffer, queue) == SVO_OK
               ? exit_code
               : fail_device(which, device);
}

int pixel_buffer_finish(pixel_buffer *which, size_t used_bytes, cl_event drawn)
{
    const svo_status status = svo_gl_buffer_to_gl(which->buffer, used_bytes, which->queue, 1, &drawn);
    clReleaseEvent(drawn);
    return status == SVO_OK ? PROGRAM_DONE : fail_device(which, which->device);
}

void pixel_buffer_drop(pixel_buffer *which)
{
    svo_gl_buffer_destroy(&which->buffer);
}

/* ---- the canvas ---- */

/* A texture of colors. */
typedef struct image {
    GLuint name;
    unsigned width, height; /* 0: it has no pixels yet */
} image;

struct canvas {
    const view_gl *gl;
    image picture, map;
    image larger; /* takes the place of the picture when it is enlarged */
    GLuint picture_program, line_program;
    GLuint picture_vertices, line_vertices; /* vertex arrays; the first one is empty */
    GLuint line_buffer;
    GLuint frame, frame_texture; /* what is drawn, before the window has it */
    unsigned frame_width, frame_height; /* 0: not made yet */
    GLuint pair[2]; /* of the picture and the larger one, to copy between them */
};

/* A triangle that covers the window, and the picture from its upper row on. */
static const char picture_vertex[] = "#version 430 core\n"
                                     "out vec2 place;\n"
                                     "void main()\n"
                                     "{\n"
                                     "    vec2 corner = vec2(gl_VertexID == 1 ? 2.0 : 0.0, gl_VertexID == 2 ? 2.0 : "
                                     "0.0);\n"
                                     "    place = vec2(corner.x, 1.0 - corner.y);\n"
                                     "    gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);\n"
                                     "}\n";
static const char picture_fragment[] = "#version 430 core\n"
                                       "layout(binding = 0) uniform sampler2D picture;\n"
                                       "in vec2 place;\n"
                                       "out vec4 color;\n"
                                       "void main()\n"
                                       "{\n"
                                       "    color = vec4(texture(picture, place).rgb, 1.0);\n"
                                       "}\n";
static const char line_vertex[] = "#version 430 core\n"
                                  "layout(location = 0) in vec2 position;\n"
                                  "layout(location = 1) in vec4 vertex_color;\n"
                                  "out vec4 shade;\n"
                                  "void main()\n"
                                  "{\n"
                                  "    shade = vertex_color;\n"
                                  "    gl_Position = vec4(position, 0.0, 1.0);\n"
                                  "}\n";
static const char line_fragment[] = "#version 430 core\n"
                                    "in vec4 shade;\n"
                                    "out vec4 color;\n"
                                    "void main()\n"
                                    "{\n"
                                    "    color = shade;\n"
                                    "}\n";

/* ---- making ---- */

static void make_frame(canvas *which)
{
    which->gl->GenFramebuffers(1, &which->frame);
    which->gl->GenTextures(1, &which->frame_texture);
    which->gl->GenFramebuffers(2, which->pair);
}

static void make_texture(const view_gl *gl, image *out)
{
    gl->GenTextures(1, &out->name);
    gl->BindTexture(GL_TEXTURE_2D, out->name);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

static void make_vertices(canvas *which)
{
    const view_gl *gl = which->gl;
    gl->GenVertexArrays(1, &which->picture_vertices);
    gl->GenVertexArrays(1, &which->line_vertices);
    gl->GenBuffers(1, &which->line_buffer);
    gl->BindVertexArray(which->line_vertices);
    gl->BindBuffer(GL_ARRAY_BUFFER, which->line_buffer);
    gl->BindVertexBuffer(0, which->line_buffer, 0, sizeof(canvas_vertex));
    gl->VertexAttribFormat(0, 2, GL_FLOAT, GL_FALSE, offsetof(canvas_vertex, x));
    gl->VertexAttribFormat(1, 4, GL_FLOAT, GL_FALSE, offsetof(canvas_vertex, color));
    for (GLuint i = 0; i < 2; ++i) {
        gl->VertexAttribBinding(i, 0);
        gl->EnableVertexAttribArray(i);
    }
    gl->BindVertexArray(0);
}

canvas *canvas_create(const view_gl *gl, svo_message *why)
{
    canvas *made = calloc(1, sizeof *made);
    if (made == NULL) {
        (void)snprintf(why->text, sizeof why->text, "out of memory for the window");
        return NULL;
    }
    made->gl = gl;
    make_frame(made);
    make_texture(gl, &made->picture);
    make_texture(gl, &made->larger);
    make_texture(gl, &made->map);
    make_vertices(made);
    if (!view_gl_program(gl, picture_vertex, picture_fragment, &made->picture_program, why) ||
        !view_gl_program(gl, line_vertex, line_fragment, &made->line_program, why) ||
        !view_gl_check(gl, "the window was prepared", why)) {
        canvas_destroy(&made);
    }
    return made;
}

void canvas_destroy(canvas **which)
{
    canvas *gone = *which;
    if (gone == NULL) {
        return;
    }
    const view_gl *gl = gone->gl;
    gl->DeleteProgram(gone->picture_program);
    gl->DeleteProgram(gone->line_program);
    gl->DeleteVertexArrays(1, &gone->picture_vertices);
    gl->DeleteVertexArrays(1, &gone->line_vertices);
    gl->DeleteBuffers(1, &gone->line_buffer);
    gl->DeleteTextures(1, &gone->picture.name);
    gl->DeleteTextures(1, &gone->larger.name);
    gl->DeleteTextures(1, &gone->map.name);
    gl->DeleteFramebuffers(1, &gone->frame);
    gl->DeleteFramebuffers(2, gone->pair);
    gl->DeleteTextures(1, &gone->frame_texture);
    free(gone);
    *which = NULL;
}

/* ---- pictures ---- */

/* Makes room in a texture that has another size. pixels: in host memory, or NULL. */
static void resize(const view_gl *gl, image *out, unsigned width, unsigned height, const uint8_t *pixels)
{
    gl->BindTexture(GL_TEXTURE_2D, out->name);
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, (GLsizei)width, (GLsizei)height, 0, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
    out->width = width;
    out->height = height;
}

bool canvas_take_rows(canvas *which, const canvas_rows *rows, svo_message *why)
{
    const view_gl *gl = which->gl;
    const uintptr_t begin = rows->offset_bytes + (uintptr_t)rows->first_row * rows->width * 4;
    const void *in_buffer = NULL; /* OpenGL takes an offset in the buffer for a pointer */
    if (rows->width != which->picture.width || rows->height != which->picture.height) {
        resize(gl, &which->picture, rows->width, rows->height, NULL);
    }
    memcpy(&in_buffer, &begin, sizeof in_buffer);
    gl->BindTexture(GL_TEXTURE_2D, which->picture.name);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, rows->buffer);
    gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, (GLint)rows->first_row, (GLsizei)rows->width, (GLsizei)rows->row_count,
                      GL_RGBA, GL_UNSIGNED_BYTE, in_buffer);
    gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    return view_gl_check(gl, "taking a picture", why);
}

/* The picture before is drawn into one beside it, and the two change places. */
bool canvas_enlarge(canvas *which, unsigned width, unsigned height, svo_message *why)
{
    const view_gl *gl = which->gl;
    const image small = which->picture;
    const GLint columns = (GLint)small.width;
    const GLint rows = (GLint)small.height;
    resize(gl, &which->larger, width, height, NULL);
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, which->pair[0]);
    gl->FramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, small.name, 0);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, which->pair[1]);
    gl->FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, which->larger.name, 0);
    gl->BlitFramebuffer(0, 0, columns, rows, 0, 0, 2 * columns, 2 * rows, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    which->picture = which->larger;
    which->larger = small;
    return view_gl_check(gl, "enlarging a picture", why);
}

bool canvas_take_map(canvas *which, const uint8_t *rgba, unsigned edge, svo_message *why)
{
    const view_gl *gl = which->gl;
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    resize(gl, &which->map, edge, edge, rgba);
    return view_gl_check(gl, "taking a picture", why);
}

uint32_t canvas_map(const canvas *which)
{
    return which->map.name;
}

/* A picture of the window's size is shown pixel by pixel; others are stretched. */
static void draw_picture(const canvas *which, unsigned width, unsigned height)
{
    const view_gl *gl = which->gl;
    const GLint filter = width == which->picture.width && height == which->picture.height ? GL_NEAREST : GL_LINEAR;
    gl->ActiveTexture(GL_TEXTURE0);
    gl->BindTexture(GL_TEXTURE_2D, which->picture.name);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    gl->UseProgram(which->picture_program);
    gl->BindVertexArray(which->picture_vertices);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
}

/* Positions are in pixels, OpenGL's from -1 to 1. */
static bool draw_lines(const canvas *which, unsigned width, unsigned height, const canvas_vertex *vertices,
                       size_t count)
{
    const view_gl *gl = which->gl;
    canvas_vertex *placed = malloc(count * sizeof *placed);
    if (placed == NULL) {
        return false;
    }
    for (size_t i = 0; i < count; ++i) {
        placed[i] = vertices[i];
        placed[i].x = 2.0F * vertices[i].x / (float)width - 1.0F;
        placed[i].y = 1.0F - 2.0F * vertices[i].y / (float)height;
    }
    gl->UseProgram(which->line_program);
    gl->BindVertexArray(which->line_vertices);
    gl->BindBuffer(GL_ARRAY_BUFFER, which->line_buffer);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(count * sizeof *placed), placed, GL_STREAM_DRAW);
    gl->Enable(GL_BLEND);
    gl->BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    gl->DrawArrays(GL_TRIANGLES, 0, (GLsizei)count);
    gl->Disable(GL_BLEND);
    free(placed);
    return true;
}

/* Draws into a frame of this size from now on. A window without a screen keeps the size that it was opened with, so
   what is drawn right there would be lost beyond it. */
static bool use_frame(canvas *which, unsigned width, unsigned height, svo_message *why)
{
    const view_gl *gl = which->gl;
    gl->BindFramebuffer(GL_FRAMEBUFFER, which->frame);
    if (width != which->frame_width || height != which->frame_height) {
        gl->BindTexture(GL_TEXTURE_2D, which->frame_texture);
        gl->TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, (GLsizei)width, (GLsizei)height, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
        gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, which->frame_texture, 0);
        if (gl->CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
            (void)snprintf(why->text, sizeof why->text, "OpenGL: no frame of %ux%u pixels", width, height);
            return false;
        }
        which->frame_width = width;
        which->frame_height = height;
    }
    return true;
}

bool canvas_draw(canvas *which, unsigned width, unsigned height, const canvas_vertex *vertices, size_t count,
                 svo_message *why)
{
    const view_gl *gl = which->gl;
    if (!use_frame(which, width, height, why)) {
        return false;
    }
    gl->Viewport(0, 0, (GLsizei)width, (GLsizei)height);
    gl->Disable(GL_DEPTH_TEST);
    gl->ClearColor(0.09F, 0.10F, 0.12F, 1.0F);
    gl->Clear(GL_COLOR_BUFFER_BIT);
    if (which->picture.width > 0) {
        draw_picture(which, width, height);
    }
    if (count > 0 && !draw_lines(which, width, height, vertices, count)) {
        (void)snprintf(why->text, sizeof why->text, "out of memory for %zu vertices", count);
        return false;
    }
    gl->BindVertexArray(0);
    gl->UseProgram(0);
    return view_gl_check(gl, "drawing the window", why);
}

bool canvas_continue(canvas *which, unsigned width, unsigned height, svo_message *why)
{
    return width == which->frame_width && height == which->frame_height
               ? use_frame(which, width, height, why)
               : canvas_draw(which, width, height, NULL, 0, why);
}

bool canvas_show(canvas *which, svo_message *why)
{
    const view_gl *gl = which->gl;
    const GLint width = (GLint)which->frame_width;
    const GLint height = (GLint)which->frame_height;
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    gl->BlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    return view_gl_check(gl, "showing the window", why);
}

/* ---- shots ---- */

static void flip_rows(uint8_t *rgba, size_t row_bytes, unsigned height)
{
    for (unsigned top = 0; top < height / 2; ++top) {
        uint8_t *const upper = rgba + top * row_bytes;
        uint8_t *const lower = rgba + (height - 1 - top) * row_bytes;
        for (size_t i = 0; i < row_bytes; ++i) {
            const uint8_t byte = upper[i];
            upper[i] = lower[i];
            lower[i] = byte;
        }
    }
}

bool canvas_read(canvas *which, unsigned width, unsigned height, uint8_t *rgba, svo_message *why)
{
    const view_gl *gl = which->gl;
    gl->PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl->ReadPixels(0, 0, (GLsizei)width, (GLsizei)height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    if (!view_gl_check(gl, "reading the window", why)) {
        return false;
    }
    flip_rows(rgba, (size_t)width * 4, height);
    for (size_t i = 0; i < (size_t)width * height; ++i) {
        rgba[4 * i + 3] = 255;
    }
    return true;
}
