/* SPDX-License-Identifier: MIT */
/* The panels' toolkit, what draws it, and whose events are whose. */
#include "view/overlay.h"

#include <stdio.h>
#include <stdlib.h>

#include "view/ui.h"
#include "view/ui_paint.h"

struct overlay {
    ui *toolkit;
    ui_paint *paint;
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
    made->paint = ui_paint_create(gl, glyphs, width, height, why);
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
        ui_paint_destroy(&(*which)->paint);
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
    return ui_paint_draw(which->paint, drawing, width, height, which->scale, why);
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
