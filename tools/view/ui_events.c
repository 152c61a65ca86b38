/* SPDX-License-Identifier: MIT */
/* Events of a frame, gathered. */
#include "view/ui_events.h"

#include <string.h>

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
