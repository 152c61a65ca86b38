/* SPDX-License-Identifier: MIT */
/* The panels' toolkit, whose events are whose, and what draws its triangles by OpenGL: one program, one buffer of
   vertices and one of indices, which each frame fills anew. */
#include "view/overlay.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "view/ui.h"

/* ---- painting ---- */

typedef struct painter {
    const view_gl *gl;
    GLuint program, glyphs, layout; /* layout: the vertex array */
    GLuint vertices, indices;
} painter;

static const char vertex_source[] = "#version 430 core\n"
                                    "layout(location = 0) in vec2 position;\n"
                                    "layout(location = 1) in vec2 texel;\n"
                                    "layout(location = 2) in vec4 vertex_color;\n"
                                    "layout(location = 0) uniform vec2 window;\n"
                                    "out vec2 place;\n"
                                    "out vec4 shade;\n"
                                    "void main()\n"
                                    "{\n"
                                    "    place = texel;\n"
                                    "    shade = vertex_color;\n"
                                    "    vec2 share = position / window;\n"
                                    "    gl_Position = vec4(2.0 * share.x - 1.0, 1.0 - 2.0 * share.y, 0.0, 1.0);\n"
                                    "}\n";
static const char fragment_source[] = "#version 430 core\n"
                                      "layout(binding = 0) uniform sampler2D picture;\n"
                                      "in vec2 place;\n"
                                      "in vec4 shade;\n"
                                      "out vec4 color;\n"
                                      "void main()\n"
                                      "{\n"
                                      "    color = shade * texture(picture, place);\n"
                                      "}\n";

/* Coverage becomes alpha of white. */
static void make_glyphs(painter *paint, const uint8_t *glyphs, unsigned width, unsigned height)
{
    const view_gl *gl = paint->gl;
    gl->GenTextures(1, &paint->glyphs);
    gl->BindTexture(GL_TEXTURE_2D, paint->glyphs);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_SWIZZLE_R, GL_ONE);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_SWIZZLE_G, GL_ONE);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_SWIZZLE_B, GL_ONE);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_SWIZZLE_A, GL_RED);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_R8, (GLsizei)width, (GLsizei)height, 0, GL_RED, GL_UNSIGNED_BYTE, glyphs);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
}

static void make_layout(painter *paint)
{
    const view_gl *gl = paint->gl;
    gl->GenVertexArrays(1, &paint->layout);
    gl->GenBuffers(1, &paint->vertices);
    gl->GenBuffers(1, &paint->indices);
    gl->BindVertexArray(paint->layout);
    gl->BindBuffer(GL_ARRAY_BUFFER, paint->vertices);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, paint->indices);
    gl->BindVertexBuffer(0, paint->vertices, 0, sizeof(ui_vertex));
    gl->VertexAttribFormat(0, 2, GL_FLOAT, GL_FALSE, offsetof(ui_vertex, x));
    gl->VertexAttribFormat(1, 2, GL_FLOAT, GL_FALSE, offsetof(ui_vertex, u));
    gl->VertexAttribFormat(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(ui_vertex, color));
    for (GLuint i = 0; i < 3; ++i) {
        gl->VertexAttribBinding(i, 0);
        gl->EnableVertexAttribArray(i);
    }
    gl->BindVertexArray(0);
}

static void destroy_painter(painter **paint)
{
    painter *gone = *paint;
    if (gone == NULL) {
        return;
    }
    const view_gl *gl = gone->gl;
    gl->DeleteProgram(gone->program);
    gl->DeleteTextures(1, &gone->glyphs);
    gl->DeleteVertexArrays(1, &gone->layout);
    gl->DeleteBuffers(1, &gone->vertices);
    gl->DeleteBuffers(1, &gone->indices);
    free(gone);
    *paint = NULL;
}

/* Makes the program and the texture of glyphs in the current context, whose functions must outlive it. NULL with a
   reason on failure. */
static painter *create_painter(const view_gl *gl, const uint8_t *glyphs, unsigned width, unsigned height,
                               svo_message *why)
{
    painter *paint = calloc(1, sizeof *paint);
    if (paint == NULL) {
        (void)snprintf(why->text, sizeof why->text, "out of memory for the panels");
        return NULL;
    }
    paint->gl = gl;
    if (!view_gl_program(gl, vertex_source, fragment_source, &paint->program, why)) {
        destroy_painter(&paint);
        return NULL;
    }
    make_glyphs(paint, glyphs, width, height);
    make_layout(paint);
    if (!view_gl_check(gl, "the panels were prepared", why)) {
        destroy_painter(&paint);
    }
    return paint;
}

static void upload(const painter *paint, const ui_drawing *drawing)
{
    const view_gl *gl = paint->gl;
    const size_t vertex_bytes = drawing->vertex_count * sizeof *drawing->vertices;
    const size_t index_bytes = drawing->index_count * sizeof *drawing->indices;
    gl->BindVertexArray(paint->layout);
    gl->BindBuffer(GL_ARRAY_BUFFER, paint->vertices);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)vertex_bytes, drawing->vertices, GL_STREAM_DRAW);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)index_bytes, drawing->indices, GL_STREAM_DRAW);
}

static int clamp(int value, int low, int high)
{
    return value < low ? low : value > high ? high : value;
}

/* A clip in pixels of the screen. */
static int low_pixel(int clip, float scale)
{
    return (int)floorf((float)clip * scale);
}

static int high_pixel(int clip, float scale)
{
    return (int)ceilf((float)clip * scale);
}

/* OpenGL counts rows from the bottom. */
static void draw_batch(const painter *paint, const ui_batch *batch, int width, int height, float scale)
{
    const view_gl *gl = paint->gl;
    const uintptr_t begin = batch->index_begin * sizeof(uint32_t); /* in the buffer; OpenGL takes it for a pointer */
    const void *indices = NULL;
    const int left = clamp(low_pixel(batch->clip[0], scale), 0, width);
    const int top = clamp(low_pixel(batch->clip[1], scale), 0, height);
    const int right = clamp(high_pixel(batch->clip[2], scale), left, width);
    const int bottom = clamp(high_pixel(batch->clip[3], scale), top, height);
    if (batch->index_count == 0 || right == left || bottom == top) {
        return;
    }
    gl->Scissor(left, height - bottom, right - left, bottom - top);
    gl->BindTexture(GL_TEXTURE_2D, batch->texture == UI_TEXTURE_GLYPHS ? paint->glyphs : batch->texture);
    memcpy(&indices, &begin, sizeof indices);
    gl->DrawElements(GL_TRIANGLES, (GLsizei)batch->index_count, GL_UNSIGNED_INT, indices);
}

/* Draws over what is there, in a window of so many pixels. False on failure. */
static bool paint_drawing(painter *paint, const ui_drawing *drawing, unsigned width, unsigned height, float scale,
                          svo_message *why)
{
    const view_gl *gl = paint->gl;
    upload(paint, drawing);
    gl->UseProgram(paint->program);
    gl->Uniform2f(0, (float)width / scale, (float)height / scale);
    gl->ActiveTexture(GL_TEXTURE0);
    gl->Viewport(0, 0, (GLsizei)width, (GLsizei)height);
    gl->Enable(GL_BLEND);
    gl->BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    gl->Enable(GL_SCISSOR_TEST);
    for (size_t i = 0; i < drawing->batch_count; ++i) {
        draw_batch(paint, &drawing->batches[i], (int)width, (int)height, scale);
    }
    gl->Disable(GL_SCISSOR_TEST);
    gl->Disable(GL_BLEND);
    gl->BindVertexArray(0);
    gl->UseProgram(0);
    return view_gl_check(gl, "drawing the panels", why);
}

/* ---- the toolkit ---- */

struct overlay {
    ui *toolkit;
    painter *paint;
    ui_events events;
    float scale;
    bool large; /* text, as it was last */
    bool picture_holds[3]; /* buttons that went down on the picture */
};

overlay *overlay_create(const view_gl *gl, float scale, const ui_clipboard *clipboard, svo_message *why)
{
    unsigned width = 0;
    unsigned height = 0;
    overlay *made = calloc(1, sizeof *made);
    if (made != NULL) {
        made->scale = scale;
        made->large = true;
        made->toolkit = ui_create(scale);
    }
    if (made == NULL || made->toolkit == NULL) {
        (void)snprintf(why->text, sizeof why->text, "out of memory for the panels");
        free(made);
        return NULL;
    }
    ui_set_clipboard(made->toolkit, clipboard);
    const uint8_t *glyphs = ui_glyphs(made->toolkit, &width, &height);
    made->paint = create_painter(gl, glyphs, width, height, why);
    if (made->paint == NULL) {
        overlay_destroy(&made);
        return NULL;
    }
    ui_events_begin(&made->events);
    return made;
}

void overlay_destroy(overlay **which)
{
    if (*which != NULL) {
        destroy_painter(&(*which)->paint);
        ui_destroy(&(*which)->toolkit);
        free(*which);
        *which = NULL;
    }
}

static bool picture_holds_any(const overlay *which)
{
    return which->picture_holds[0] || which->picture_holds[1] || which->picture_holds[2];
}

static bool take_button(overlay *which, const view_event *event)
{
    if (event->button < 0 || event->button > 2) {
        return false;
    }
    bool *held = &which->picture_holds[event->button];
    const bool was_held = *held;
    *held = event->is_down && !ui_wants_mouse(which->toolkit);
    return event->is_down ? !*held : !was_held;
}

bool overlay_take(overlay *which, const view_event *event)
{
    const bool is_dragged = picture_holds_any(which);
    bool is_theirs = false;
    switch (event->kind) {
    case VIEW_EVENT_KEY:
        is_theirs = event->is_down && ui_wants_keys(which->toolkit);
        break;
    case VIEW_EVENT_TEXT:
        is_theirs = ui_wants_keys(which->toolkit);
        break;
    case VIEW_EVENT_BUTTON:
        is_theirs = take_button(which, event);
        break;
    case VIEW_EVENT_MOVE:
    case VIEW_EVENT_WHEEL:
        is_theirs = !is_dragged && ui_wants_mouse(which->toolkit);
        break;
    case VIEW_EVENT_RESIZE:
    case VIEW_EVENT_DROP:
    case VIEW_EVENT_QUIT:
        break;
    }
    /* Panels do not see a drag of the picture: it would light up what it passes. */
    if (event->kind != VIEW_EVENT_BUTTON || is_theirs) {
        ui_events_take(&which->events, event);
    }
    return is_theirs;
}

bool overlay_types(const overlay *which)
{
    return ui_wants_keys(which->toolkit);
}

void overlay_release(overlay *which)
{
    ui_events_begin(&which->events);
    for (int i = 0; i < 3; ++i) {
        which->picture_holds[i] = false;
    }
}

/* Begins a frame of the toolkit, whose pixels are those of a plain display. */
static void begin(overlay *which, unsigned width, unsigned height, float seconds)
{
    ui_input input = ui_events_frame(&which->events, width, height, seconds);
    input.large = which->large;
    input.width /= which->scale;
    input.height /= which->scale;
    input.mouse[0] /= which->scale;
    input.mouse[1] /= which->scale;
    if (picture_holds_any(which)) {
        input.mouse[0] = input.mouse[1] = -1;
    }
    ui_begin(which->toolkit, &input);
}

static bool end(overlay *which, unsigned width, unsigned height, svo_message *why)
{
    const ui_drawing *drawing = ui_end(which->toolkit);
    if (drawing == NULL) {
        (void)snprintf(why->text, sizeof why->text, "out of memory for the panels");
        return false;
    }
    return paint_drawing(which->paint, drawing, width, height, which->scale, why);
}

bool overlay_draw(overlay *which, view_state *state, float seconds, svo_message *why)
{
    which->large = panels_text_is_large(state);
    begin(which, state->width, state->height, seconds);
    panels_describe(which->toolkit, state);
    return end(which, state->width, state->height, why);
}

bool overlay_draw_work(overlay *which, const panels_work *work, unsigned width, unsigned height, svo_message *why)
{
    begin(which, width, height, 0);
    panels_describe_work(which->toolkit, work, (float)width / which->scale, (float)height / which->scale);
    return end(which, width, height, why);
}
