/* SPDX-License-Identifier: MIT */
/*
 * What panels need besides Dear ImGui: lists of triangles that grow, and stay as they are after memory ran out; texts
 * that fit; and the events of a frame, gathered.
 */
#include "view/ui.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- drawings ---- */

void ui_drawing_clear(ui_drawing *drawing)
{
    drawing->vertex_count = 0;
    drawing->index_count = 0;
    drawing->batch_count = 0;
}

void ui_drawing_free(ui_drawing *drawing)
{
    free(drawing->vertices);
    free(drawing->indices);
    free(drawing->batches);
    *drawing = (ui_drawing){.vertices = NULL};
}

/* Makes room for more elements behind count; false when memory runs out. */
static bool reserve(ui_drawing *drawing, void **elements, size_t *capacity, size_t count, size_t element_bytes)
{
    if (drawing->failed || count <= *capacity) {
        return !drawing->failed;
    }
    const size_t enough = count + count / 2 + 64;
    void *larger = realloc(*elements, enough * element_bytes);
    if (larger == NULL) {
        drawing->failed = true;
        return false;
    }
    *elements = larger;
    *capacity = enough;
    return true;
}

void ui_drawing_batch(ui_drawing *drawing, uint32_t texture, const int clip[4])
{
    if (drawing->batch_count > 0) {
        ui_batch *last = &drawing->batches[drawing->batch_count - 1];
        if (last->texture == texture && memcmp(last->clip, clip, sizeof last->clip) == 0) {
            return;
        }
        if (last->index_count == 0) {
            --drawing->batch_count;
        }
    }
    void *batches = drawing->batches;
    const bool enough =
        reserve(drawing, &batches, &drawing->batch_capacity, drawing->batch_count + 1, sizeof *drawing->batches);
    drawing->batches = batches;
    if (enough) {
        ui_batch *added = &drawing->batches[drawing->batch_count++];
        *added = (ui_batch){.index_begin = (uint32_t)drawing->index_count, .texture = texture};
        memcpy(added->clip, clip, sizeof added->clip);
    }
}

uint32_t ui_drawing_vertices(ui_drawing *drawing, const ui_vertex *vertices, size_t count)
{
    const size_t first = drawing->vertex_count;
    void *room = drawing->vertices;
    const bool enough = reserve(drawing, &room, &drawing->vertex_capacity, first + count, sizeof *vertices);
    drawing->vertices = room;
    if (enough && count > 0) {
        memcpy(drawing->vertices + first, vertices, count * sizeof *vertices);
        drawing->vertex_count += count;
    }
    return (uint32_t)first;
}

void ui_drawing_triangles(ui_drawing *drawing, uint32_t first, const uint16_t *indices, size_t count)
{
    void *room = drawing->indices;
    const bool enough =
        reserve(drawing, &room, &drawing->index_capacity, drawing->index_count + count, sizeof *drawing->indices);
    drawing->indices = room;
    if (!enough || drawing->batch_count == 0) {
        return;
    }
    for (size_t i = 0; i < count; ++i) {
        drawing->indices[drawing->index_count++] = first + indices[i];
    }
    drawing->batches[drawing->batch_count - 1].index_count += (uint32_t)count;
}

/* ---- texts ---- */

static bool is_rest_of_character(char byte)
{
    return ((unsigned char)byte & 0xC0U) == 0x80;
}

bool ui_fit(const ui *toolkit, const char *text, float width, char *out, size_t out_bytes)
{
    static const char dots[] = "...";
    size_t length = strlen(text);
    if (length < out_bytes && ui_text_width(toolkit, text) <= width) {
        memcpy(out, text, length + 1);
        return true;
    }
    const size_t most = out_bytes - sizeof dots;
    length = length < most ? length : most;
    bool is_word = true;
    do {
        size_t end = length;
        while (end > 0 && text[end - 1] != ' ') {
            --end;
        }
        is_word = is_word && end > 1;
        /* A word that is too wide alone is cut between characters. */
        length = is_word ? end - 1 : length > 0 ? length - 1 : 0;
        while (length > 0 && is_rest_of_character(text[length])) {
            --length;
        }
        (void)snprintf(out, out_bytes, "%.*s%s", (int)length, text, dots);
    } while (length > 0 && ui_text_width(toolkit, out) > width);
    return false;
}

/* ---- events ---- */

static const int keys[UI_KEY_COUNT] = {VIEW_KEY_BACKSPACE,
                                       VIEW_KEY_DELETE,
                                       VIEW_KEY_LEFT,
                                       VIEW_KEY_RIGHT,
                                       VIEW_KEY_HOME,
                                       VIEW_KEY_END,
                                       VIEW_KEY_ENTER,
                                       VIEW_KEY_ESCAPE,
                                       VIEW_KEY_TAB,
                                       VIEW_KEY_UP,
                                       VIEW_KEY_DOWN,
                                       'a',
                                       'c',
                                       'v',
                                       'x'};

void ui_events_begin(ui_events *events)
{
    *events = (ui_events){.next = {.mouse = {-1, -1}}};
}

static void take_key(ui_events *events, const view_event *event)
{
    for (int i = 0; i < UI_KEY_COUNT; ++i) {
        if (keys[i] == event->key) {
            events->keys[i] = event->is_down;
            events->next.keys[i] |= event->is_down;
        }
    }
}

static void take_text(ui_events *events, const char *text)
{
    const size_t length = strlen(events->next.typed);
    if (length + strlen(text) < sizeof events->next.typed) {
        memcpy(events->next.typed + length, text, strlen(text) + 1);
    }
}

void ui_events_take(ui_events *events, const view_event *event)
{
    ui_input *next = &events->next;
    next->control = event->control;
    next->shift = event->shift;
    if (event->kind == VIEW_EVENT_KEY) {
        take_key(events, event);
    } else if (event->kind == VIEW_EVENT_TEXT) {
        take_text(events, event->text);
    } else if (event->kind == VIEW_EVENT_MOVE || event->kind == VIEW_EVENT_BUTTON || event->kind == VIEW_EVENT_WHEEL) {
        next->mouse[0] = (float)event->x;
        next->mouse[1] = (float)event->y;
    }
    if (event->kind == VIEW_EVENT_WHEEL) {
        next->wheel += event->steps;
    }
    if (event->kind == VIEW_EVENT_BUTTON && event->button >= 0 && event->button < 3) {
        events->buttons[event->button] = event->is_down;
        next->buttons[event->button] |= event->is_down;
    }
}

ui_input ui_events_frame(ui_events *events, unsigned width, unsigned height, float seconds)
{
    ui_input input = events->next;
    input.width = (float)width;
    input.height = (float)height;
    input.seconds = seconds > 0 ? seconds : 1e-4F;
    for (int i = 0; i < 3; ++i) {
        input.buttons[i] |= events->buttons[i];
    }
    for (int i = 0; i < UI_KEY_COUNT; ++i) {
        input.keys[i] |= events->keys[i];
    }
    events->next =
        (ui_input){.mouse = {input.mouse[0], input.mouse[1]}, .control = input.control, .shift = input.shift};
    return input;
}
