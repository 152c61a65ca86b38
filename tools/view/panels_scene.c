/* SPDX-License-Identifier: MIT */
/* What stands in the scene: the sections Instances, Motion, Lights, of a tree or of a scene, and Probes. */
#include "view/panels_pages.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "support/table.h"
#include "view/camera.h"
#include "view/dialogs.h"
#include "view/edit.h"

/* ---- instances ---- */

#define INSTANCES_SHOWN 6

/* The chosen instance and those around it. */
static void list_instances(ui *toolkit, view_state *state)
{
    char text[VIEW_NAME_BYTES + 32];
    const size_t count = state->instance_count;
    size_t begin = state->instance > INSTANCES_SHOWN / 2 ? state->instance - INSTANCES_SHOWN / 2 : 0;
    begin = count > INSTANCES_SHOWN && begin > count - INSTANCES_SHOWN ? count - INSTANCES_SHOWN : begin;
    begin = count > INSTANCES_SHOWN ? begin : 0;
    for (size_t i = begin; i < count && i < begin + INSTANCES_SHOWN; ++i) {
        (void)snprintf(text, sizeof text, "%zu  %s", i, state->trees[state->instances[i].tree].name);
        ui_push(toolkit, (int)i);
        if (ui_item(toolkit, text, i == state->instance)) {
            state->instance = i;
        }
        ui_pop(toolkit);
    }
    if (count > INSTANCES_SHOWN) {
        int chosen = (int)state->instance;
        if (ui_slider_count(toolkit, "Of all", &chosen, 0, (int)count - 1)) {
            state->instance = (size_t)chosen;
        }
    }
}

static void choose_tree(ui *toolkit, view_state *state, svo_instance *instance)
{
    enum { TREES_SHOWN = 64 };
    const char *names[TREES_SHOWN];
    const size_t count = state->tree_count < TREES_SHOWN ? state->tree_count : TREES_SHOWN;
    int chosen = (int)instance->tree;
    for (size_t i = 0; i < count; ++i) {
        names[i] = state->trees[i].name;
    }
    if (ui_choice(toolkit, "Tree", names, (int)count, &chosen)) {
        instance->tree = (uint32_t)chosen;
        view_instances_changed(state);
    }
}

/* One number for a scale that is the same along all axes. */
static bool edit_scale(ui *toolkit, float scale[3])
{
    const bool is_even = scale[0] == scale[1] && scale[1] == scale[2];
    const bool changed = ui_numbers(toolkit, "Scale", scale, is_even ? 1 : 3, 0.01F, "%.3f");
    if (changed && is_even) {
        scale[1] = scale[2] = scale[0];
    }
    ui_tooltip(toolkit, "Before it is turned.");
    return changed;
}

static void edit_place(ui *toolkit, view_state *state)
{
    scene_place place;
    const bool is_place = scene_edit_place(state, state->instance, &place);
    const bool moved = ui_numbers(toolkit, "Move", place.translate, 3, 0.002F * camera_distance(state), "%.2f");
    ui_tooltip(toolkit, "Drag to move the instance along x, y and z.");
    if (!is_place) {
        ui_note(toolkit, "Its matrix shears: it can be moved alone.");
        if (moved) {
            scene_edit_move(state, state->instance, place.translate);
        }
        return;
    }
    bool changed = ui_numbers(toolkit, "Turn", place.rotate, 3, 0.5F, "%.0f");
    ui_tooltip(toolkit, "Degrees about x, then y, then z.");
    changed |= edit_scale(toolkit, place.scale);
    if (moved || changed) {
        (void)scene_edit_set(state, state->instance, &place);
    }
}

static void edit_file(ui *toolkit, view_state *state)
{
    static const char *const buttons[] = {"Save", "Load"};
    const bool entered = ui_field(toolkit, "File", state->scene_path, sizeof state->scene_path);
    ui_tooltip(toolkit, "A scene for svocl render and svocl view; Enter saves it.");
    const int pressed = ui_buttons(toolkit, buttons, 2);
    if (entered || pressed == 0) {
        question_save_as(state, VIEW_SCENE, state->scene_path);
    } else if (pressed == 1) {
        view_leave(state, &state->wants_load);
    }
    ui_tooltip(toolkit, "Trees, instances, camera and lights.");
}

void panels_instances(ui *toolkit, view_state *state)
{
    static const char *const buttons[] = {"Add", "Remove"};
    bool is_scene = state->is_scene;
    if (ui_checkbox(toolkit, "Edit", &is_scene)) {
        view_choose_scene(state, is_scene);
    }
    ui_tooltip(toolkit, state->mover_count > 0
                            ? "Shows the instances, those that move at their first keys; else what moves."
                            : "Shows the tree as the first instance of a scene, which more can be added to.");
    if (!state->is_scene) {
        return;
    }
    const int pressed = ui_buttons(toolkit, buttons, 2);
    if (pressed == 0) {
        (void)scene_edit_add(state);
    } else if (pressed == 1) {
        scene_edit_remove(state);
    }
    list_instances(toolkit, state);
    if (state->instance < state->instance_count) {
        choose_tree(toolkit, state, &state->instances[state->instance]);
        edit_place(toolkit, state);
    }
    edit_file(toolkit, state);
}

/* ---- motions ---- */

static void choose_speed(ui *toolkit, view_state *state)
{
    static const char *const names[2 * VIEW_SPEED_MAX + 1] = {"1/16", "1/8", "1/4", "1/2", "1", "2", "4", "8", "16"};
    int chosen = state->film.speed_log2 + VIEW_SPEED_MAX;
    if (ui_choice(toolkit, "Speed", names, 2 * VIEW_SPEED_MAX + 1, &chosen)) {
        play_choose_speed(state, chosen - VIEW_SPEED_MAX);
    }
    ui_tooltip(toolkit, "Of the motions' time, in a second. Keys Up and Down.");
}

void panels_motion(ui *toolkit, view_state *state)
{
    view_film *film = &state->film;
    const char *const buttons[] = {"Back", film->is_playing ? "Pause" : "Play", "Next"};
    if (state->mover_count == 0) {
        ui_note(toolkit, "Nothing moves. Instances of a scene's file may have a 'motion'.");
        return;
    }
    const int pressed = ui_buttons(toolkit, buttons, 3);
    if (pressed == 1) {
        play_toggle(state);
    } else if (pressed >= 0) {
        play_step(state, pressed - 1);
    }
    ui_tooltip(toolkit, "Space plays and pauses; Left and Right step by a frame.");
    int frame = (int)film->frame;
    if (ui_slider_count(toolkit, "Frame", &frame, 0, (int)film->frame_count - 1)) {
        play_seek(state, (uint64_t)frame);
    }
    ui_tooltip(toolkit, "As svocl render --animate numbers them.");
    ui_value(toolkit, "Time", "%.3f of %.3g .. %.3g", film->time, (double)film->first_time, (double)film->last_time);
    choose_speed(toolkit, state);
    ui_checkbox(toolkit, "Loop", &film->loops);
    ui_tooltip(toolkit, "The first frame follows the last one; otherwise that stays.");
    if (state->is_scene) {
        ui_note(toolkit, "Instances are edited at their first keys.");
    }
}

/* ---- sources ---- */

#define PI 3.14159265F

/* The lowest and highest elevation: straight down has no direction around. */
#define STEEP 89.5F

static const char *const kinds[] = {"sun", "point", "spot", "disk"};

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
    if (!ui_choice(toolkit, "Kind", kinds, 4, &kind)) {
        return false;
    }
    source->kind = (uint32_t)kind;
    source->radius = 0;
    if (source->direction[0] == 0 && source->direction[1] == 0 && source->direction[2] == 0) {
        source->direction[1] = -1;
    }
    if (!(source->outer_angle > source->inner_angle)) {
        source->inner_angle = 0.35F;
        source->outer_angle = 0.5F;
    }
    return true;
}

/* Of a sun an angle, of others that of a ball. */
static bool edit_size(ui *toolkit, svo_light_source *source)
{
    if (source->kind != SVO_SOURCE_DIRECTIONAL) {
        const bool changed = ui_numbers(toolkit, "Radius", &source->radius, 1, 0.01F, "%.2f");
        ui_tooltip(toolkit, "Of a ball around the position, or of the disk. Shadows have a soft edge.");
        source->radius = fmaxf(source->radius, 0);
        return changed;
    }
    float degrees = source->radius * 180 / PI;
    const bool changed = ui_slider(toolkit, "Radius", &degrees, 0, 30, "%.2f \xC2\xB0");
    ui_tooltip(toolkit, "Degrees of the disk in the sky, .27 for the sun. Its shadows have a soft edge.");
    source->radius = changed ? degrees * PI / 180 : source->radius;
    return changed;
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
    changed |= edit_size(toolkit, source);
    changed |= ui_color(toolkit, "Color", source->value);
    ui_tooltip(toolkit, "Linear red, green and blue: irradiance of a sun, intensity of others.");
    if (!view_is_moderate(source->position, 3) || !view_is_moderate(source->value, 3) ||
        !view_is_moderate(&source->radius, 1)) {
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
        (void)snprintf(text, sizeof text, "%zu  %s", i, kinds[kind < 4 ? kind : 0]);
        ui_push(toolkit, (int)i);
        if (ui_item(toolkit, text, i == state->source)) {
            state->source = i;
        }
        ui_pop(toolkit);
    }
}

static void describe_sky(ui *toolkit, view_state *state)
{
    if (state->sky_map != NULL) {
        const sky_file *map = state->sky_map;
        ui_text(toolkit, "Sky: a %s", map->path != NULL ? "picture" : "gradient");
        ui_tooltip(toolkit, "By direction, as the file of lights has it.");
        return;
    }
    float sky[3] = {state->sky[0], state->sky[1], state->sky[2]};
    if (ui_color(toolkit, "Sky", sky) && view_is_moderate(sky, 3)) {
        memcpy(state->sky, sky, sizeof sky);
        view_lights_changed(state);
    }
    ui_tooltip(toolkit, "Radiance from outside, linear red, green and blue.");
}

static void describe_sources(ui *toolkit, view_state *state)
{
    static const char *const added[] = {"+ sun", "+ point", "+ spot", "+ disk"};
    static const char *const removed[] = {"Remove"};
    const int add = ui_buttons(toolkit, added, 4);
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
    describe_sky(toolkit, state);
}

/* ---- lights of scenes ---- */

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

/* ---- pictures through probes ---- */

#define CHOICES 6 /* of numbers */

static void look_through(ui *toolkit, view_state *state)
{
    const float *found = state->probes.found;
    bool through = state->shown.through;
    if (ui_checkbox(toolkit, "Look through them", &through)) {
        view_choose_through(state, through);
    }
    ui_tooltip(toolkit, "Camera rays meet what probes have stored: green is a miss, red unknown. Key T.");
    if (state->shown.through) {
        ui_value(toolkit, "Unknown", "%.2f %%", (double)found[SVO_PROBE_UNKNOWN]);
        ui_tooltip(toolkit, "Rays that went where no probe saw.");
        ui_value(toolkit, "Hit, miss", "%.1f %%, %.1f %%", (double)found[SVO_PROBE_HIT], (double)found[SVO_PROBE_MISS]);
    }
}

/* ---- spheres of probes ---- */

/* How many probes there are of each state, beside the color of their spheres. */
static void draw_legend(ui *toolkit, const svo_probe_info *made)
{
    const uint32_t colors[3] = {UI_COLOR_PROBE_IN_PLACE, UI_COLOR_PROBE_MOVED, UI_COLOR_PROBE_OFF};
    const char *const names[3] = {"on", "moved", "off"};
    const uint32_t counts[3] = {made->probe_count - made->moved - made->off, made->moved, made->off};
    const float height = ui_row_height(toolkit) - UI_GAP;
    ui_place place;
    char text[48];
    (void)ui_canvas(toolkit, "states", height, &place, NULL);
    for (int i = 0; i < 3; ++i) {
        const float x = roundf(place.x);
        (void)snprintf(text, sizeof text, "%u %s", counts[i], names[i]);
        ui_fill(toolkit, (ui_place){x, roundf(place.y + height / 2) - 4, 8, 8}, colors[i]);
        ui_fill_text(toolkit, x + 12, place.y + UI_INSET_Y, UI_COLOR_TEXT, text);
        place.x += 12 + ui_text_width(toolkit, text) + UI_PADDING;
    }
    ui_tooltip(toolkit, "Probes where the grid has them, moved to see more, and switched off: inside of something.");
}

static void describe_made(ui *toolkit, view_state *state)
{
    const svo_probe_info *made = &state->probes.made;
    ui_checkbox(toolkit, "Spheres", &state->probes.has_spheres);
    ui_tooltip(toolkit, "At the places of the probes, by color; a click chooses one. Key O.");
    if (made->probe_count > 0) {
        draw_legend(toolkit, made);
        ui_value(toolkit, "Made", "%s, %u x %u", figure_bytes(made->total_bytes).text, made->resolution,
                 made->resolution);
        ui_tooltip(toolkit, "Bytes on the device, and texels of a map.");
    }
}

/* ---- the map of a probe ---- */

/* The texel below the mouse; NULL: it is elsewhere. */
static const uint32_t *find_texel(const view_probes *shown, const float mouse[2])
{
    const float edge = (float)shown->made.resolution;
    const size_t column = (size_t)fminf(fmaxf(mouse[0] * edge, 0), edge - 1);
    const size_t row = (size_t)fminf(fmaxf(mouse[1] * edge, 0), edge - 1);
    return mouse[0] < 0 ? NULL : shown->texels + 2 * (row * shown->made.resolution + column);
}

static void write_vector(char text[40], const char *format, const float vector[3])
{
    int length = 0;
    for (int i = 0; i < 3; ++i) {
        length += snprintf(text + length, 40 - (size_t)length, format, (double)vector[i]);
    }
}

static void describe_texel(ui *toolkit, const svo_probe_info *made, const uint32_t *texel)
{
    char distance[40] = "-";
    char normal[40] = "-";
    char radiance[40] = "-";
    if (texel != NULL) {
        const uint32_t code = texel[0] & SVO_PROBE_NOTHING;
        float numbers[3];
        svo_probe_normal(texel[0], numbers);
        write_vector(normal, "%.2f ", numbers);
        svo_probe_radiance(texel[1], numbers);
        write_vector(radiance, "%.2g ", numbers);
        (void)snprintf(distance, sizeof distance, "%.4g", svo_probe_distance(made, code));
    }
    ui_value(toolkit, "Distance", "%s", distance);
    ui_value(toolkit, "Normal", "%s", normal);
    ui_value(toolkit, "Radiance", "%s", radiance);
}

/* As wide as the panel, and square. */
static void draw_map(ui *toolkit, const view_probes *shown)
{
    static const float whole[4] = {0, 0, 1, 1};
    ui_place place;
    float mouse[2];
    (void)ui_canvas(toolkit, "above", 1, &place, NULL);
    (void)ui_canvas(toolkit, "map", floorf(place.width), &place, mouse);
    ui_fill_image(toolkit, place, shown->texture, whole);
    describe_texel(toolkit, &shown->made, find_texel(shown, mouse));
}

static void describe_map(ui *toolkit, view_state *state)
{
    const char *names[VIEW_MAPS];
    view_probes *shown = &state->probes;
    int probe = (int)shown->chosen;
    int map = (int)shown->map;
    ui_checkbox(toolkit, "Map of a probe", &shown->has_map);
    ui_tooltip(toolkit,
               "What one probe sees of all directions, on an octahedron: +z is the middle, -z the corners, x to "
               "the right, y down. Green: nothing is there. Key M.");
    if (shown->texels == NULL) {
        return;
    }
    if (ui_slider_count(toolkit, "Probe", &probe, 0, (int)shown->made.probe_count - 1)) {
        view_choose_probe(state, probe);
    }
    ui_tooltip(toolkit, "Counted along x, then y, then z. Keys comma and period, or a click on a sphere.");
    for (int i = 0; i < VIEW_MAPS; ++i) {
        names[i] = view_map_name((view_map)i);
    }
    if (ui_tabs(toolkit, names, VIEW_MAPS, &map)) {
        shown->map = (view_map)map;
    }
    draw_map(toolkit, shown);
}

/* ---- the grid of probes ---- */

static void choose_counts(ui *toolkit, view_probe_grid *asked)
{
    static const char *const names[3] = {"Along x", "Along y", "Along z"};
    for (int axis = 0; axis < 3; ++axis) {
        int count = (int)asked->counts[axis];
        if (ui_slider_count(toolkit, names[axis], &count, 1, (int)VIEW_PROBES_AXIS)) {
            asked->counts[axis] = (uint32_t)count;
        }
        ui_tooltip(toolkit, "Probes along this axis.");
    }
}

/* One of a few numbers; of another one that was given the next lower is shown. */
static void choose_number(ui *toolkit, const char *label, const char *unit, const uint32_t numbers[CHOICES],
                          uint32_t *value)
{
    char texts[CHOICES][24];
    const char *names[CHOICES];
    int chosen = 0;
    for (int i = 0; i < CHOICES; ++i) {
        (void)snprintf(texts[i], sizeof texts[i], "%u%s", numbers[i], unit);
        names[i] = numbers[i] > 0 ? texts[i] : "by budget";
        chosen = numbers[i] <= *value ? i : chosen;
    }
    if (ui_choice(toolkit, label, names, CHOICES, &chosen)) {
        *value = numbers[chosen];
    }
}

static void describe_grid(ui *toolkit, view_state *state)
{
    static const uint32_t resolutions[] = {0, 64, 128, 256, 512, 1024};
    static const uint32_t fields[] = {16, 32, 64, 96, 128, 256};
    static const uint32_t budgets[] = {16, 64, 256, 512, 1024, 4096};
    static const char *const make[] = {"Make"};
    view_probes *shown = &state->probes;
    ui_heading(toolkit, "Grid");
    choose_counts(toolkit, &shown->asked);
    choose_number(toolkit, "Texels", "", resolutions, &shown->asked.resolution);
    ui_tooltip(toolkit, "Along a side of a probe's map; by budget: 256, or the most that fits.");
    choose_number(toolkit, "Field", "", fields, &shown->asked.field_size);
    ui_tooltip(toolkit, "Cells along an axis, each with a list of the probes that see it.");
    choose_number(toolkit, "Budget", " MiB", budgets, &shown->asked.max_mib);
    ui_tooltip(toolkit, "For the texels of all probes.");
    if (shown->planned.probe_count > 0) {
        ui_value(toolkit, "Planned", "%s, %u x %u", figure_bytes(shown->planned.total_bytes).text,
                 shown->planned.resolution, shown->planned.resolution);
        ui_value(toolkit, "Rays", "%s", figure_count(shown->planned.rays).text);
    } else {
        ui_note(toolkit, "%s", shown->refusal);
    }
    ui_enable(toolkit, shown->planned.probe_count > 0);
    if (ui_buttons(toolkit, make, 1) == 0) {
        view_make_probes(state);
    }
    ui_tooltip(toolkit, "Shows probes of this grid from now on.");
    ui_enable(toolkit, true);
}

void panels_probes(ui *toolkit, view_state *state)
{
    if (view_shows_film(state)) {
        ui_note(toolkit, "What moves has no probes.");
        return;
    }
    look_through(toolkit, state);
    describe_made(toolkit, state);
    describe_map(toolkit, state);
    describe_grid(toolkit, state);
    if (state->is_scene) {
        ui_note(toolkit, "Probes of a scene hold no light.");
    }
}
