/* SPDX-License-Identifier: MIT */
/* Sources of light and the sky; in scenes the lights that their pictures have. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "view/light_edit.h"
#include "view/panels_pages.h"

#define PI 3.14159265F

/* The lowest and highest elevation: straight down has no direction around. */
#define STEEP 89.5F

static const char *const kinds[] = {"sun", "point", "spot"};

static bool edit_direction(ui *toolkit, const view_state *state, float direction[3])
{
    float angles[2];
    light_edit_angles(state, direction, angles);
    bool changed = ui_slider(toolkit, "Around", &angles[0], -180, 180, "%.0f \xC2\xB0");
    ui_tooltip(toolkit, "Where the light comes from, around what is up. Control and drag moves it too.");
    changed |= ui_slider(toolkit, "Height", &angles[1], -STEEP, STEEP, "%.0f \xC2\xB0");
    ui_tooltip(toolkit, "Where the light comes from, above the horizon.");
    if (changed) {
        light_edit_direction(state, angles, direction);
    }
    return changed;
}

static bool edit_cone(ui *toolkit, svo_light_source *source)
{
    float inner = source->inner_angle * 180 / PI;
    float outer = source->outer_angle * 180 / PI;
    bool changed = ui_slider(toolkit, "Outer", &outer, 2, 85, "%.0f \xC2\xB0");
    ui_tooltip(toolkit, "Degrees from its axis at which the spot ends.");
    changed |= ui_slider(toolkit, "Inner", &inner, 0, 84, "%.0f \xC2\xB0");
    ui_tooltip(toolkit, "Degrees from its axis up to which it is full.");
    if (changed) {
        inner = fminf(inner, outer - 1);
        source->inner_angle = inner * PI / 180;
        source->outer_angle = outer * PI / 180;
    }
    return changed;
}

/* A source that becomes another kind gets what that kind needs. */
static bool edit_kind(ui *toolkit, svo_light_source *source)
{
    int kind = (int)source->kind;
    if (!ui_choice(toolkit, "Kind", kinds, 3, &kind)) {
        return false;
    }
    source->kind = (uint32_t)kind;
    if (source->direction[0] == 0 && source->direction[1] == 0 && source->direction[2] == 0) {
        source->direction[1] = -1;
    }
    if (!(source->outer_angle > source->inner_angle)) {
        source->inner_angle = 0.35F;
        source->outer_angle = 0.5F;
    }
    return true;
}

static void edit_source(ui *toolkit, view_state *state, svo_light_source *source)
{
    const svo_light_source before = *source;
    bool changed = edit_kind(toolkit, source);
    if (source->kind != SVO_SOURCE_DIRECTIONAL) {
        changed |= ui_numbers(toolkit, "Position", source->position, 3, 0.01F, "%.2f");
        ui_tooltip(toolkit, "In the world. Control and drag moves it in the picture, with the wheel away and back.");
    }
    if (source->kind != SVO_SOURCE_POINT) {
        changed |= edit_direction(toolkit, state, source->direction);
    }
    if (source->kind == SVO_SOURCE_SPOT) {
        changed |= edit_cone(toolkit, source);
    }
    changed |= ui_color(toolkit, "Color", source->value);
    ui_tooltip(toolkit, "Linear red, green and blue: irradiance of a sun, intensity of others.");
    if (!view_is_moderate(source->position, 3) || !view_is_moderate(source->value, 3)) {
        *source = before;
    } else if (changed) {
        view_lights_changed(state);
    }
}

static void list_sources(ui *toolkit, view_state *state)
{
    char text[64];
    for (size_t i = 0; i < state->source_count; ++i) {
        const uint32_t kind = state->sources[i].kind;
        (void)snprintf(text, sizeof text, "%zu  %s", i, kinds[kind < 3 ? kind : 0]);
        ui_push(toolkit, (int)i);
        if (ui_item(toolkit, text, i == state->source)) {
            state->source = i;
        }
        ui_pop(toolkit);
    }
}

static void describe_sources(ui *toolkit, view_state *state)
{
    static const char *const added[] = {"+ sun", "+ point", "+ spot"};
    static const char *const removed[] = {"Remove"};
    const int add = ui_buttons(toolkit, added, 3);
    if (add >= 0) {
        (void)light_edit_add(state, (uint32_t)add);
    }
    list_sources(toolkit, state);
    if (state->source < state->source_count) {
        edit_source(toolkit, state, &state->sources[state->source]);
        if (ui_buttons(toolkit, removed, 1) == 0) {
            view_remove_source(state, state->source);
        }
    }
    float sky[3] = {state->sky[0], state->sky[1], state->sky[2]};
    if (ui_color(toolkit, "Sky", sky) && view_is_moderate(sky, 3)) {
        memcpy(state->sky, sky, sizeof sky);
        view_lights_changed(state);
    }
    ui_tooltip(toolkit, "Radiance from outside, linear red, green and blue.");
}

/* ---- scenes ---- */

static void list_scene_lights(ui *toolkit, view_state *state)
{
    char text[64];
    for (size_t i = 0; i < state->scene_light_count; ++i) {
        (void)snprintf(text, sizeof text, "%zu  sun", i);
        ui_push(toolkit, (int)i);
        if (ui_item(toolkit, text, i == state->scene_light)) {
            state->scene_light = i;
        }
        ui_pop(toolkit);
    }
}

static void edit_scene_light(ui *toolkit, view_state *state, svo_scene_light *light)
{
    const float before[3] = {light->color[0], light->color[1], light->color[2]};
    float away[3] = {-light->direction[0], -light->direction[1], -light->direction[2]};
    bool shadows = light->shadows != 0;
    bool changed = false;
    if (edit_direction(toolkit, state, away)) {
        changed = true;
        for (int i = 0; i < 3; ++i) {
            light->direction[i] = -away[i];
        }
    }
    changed |= ui_color(toolkit, "Color", light->color);
    ui_tooltip(toolkit, "Linear red, green and blue; 1 lights a white surface that faces the light fully.");
    if (ui_checkbox(toolkit, "Shadows", &shadows)) {
        light->shadows = shadows ? 1 : 0;
        changed = true;
    }
    if (!view_is_moderate(light->color, 3)) {
        memcpy(light->color, before, sizeof before);
    } else if (changed) {
        view_lights_changed(state);
    }
}

static void describe_scene_lights(ui *toolkit, view_state *state)
{
    static const char *const buttons[] = {"+ sun", "Remove"};
    const int pressed = ui_buttons(toolkit, buttons, 2);
    if (pressed == 0) {
        view_add_scene_light(state);
    } else if (pressed == 1) {
        view_remove_scene_light(state, state->scene_light);
    }
    list_scene_lights(toolkit, state);
    if (state->scene_light < state->scene_light_count) {
        edit_scene_light(toolkit, state, &state->scene_lights[state->scene_light]);
    } else {
        ui_note(toolkit, "Without lights the scene has the light of svocl render.");
    }
}

void panels_lights(ui *toolkit, view_state *state)
{
    if (view_shows_film(state)) {
        ui_note(toolkit, "What moves has the light of svocl render.");
    } else if (state->is_scene) {
        describe_scene_lights(toolkit, state);
    } else {
        describe_sources(toolkit, state);
    }
}
