/* SPDX-License-Identifier: MIT */
/* What was picked, the instances of a scene, and their motions: what plays, its time, and how fast. */
#include "view/panels.h"

#include <stdio.h>

#include "support/table.h"
#include "view/camera.h"
#include "view/dialogs.h"
#include "view/edit.h"

#define LIST_SHOWN      8
#define INSTANCES_SHOWN 6

/* ---- what was picked ---- */

static void describe_payload(ui *toolkit, const view_selection *selection)
{
    if (selection->has_color) {
        const uint8_t *color = selection->color;
        ui_value(toolkit, "Color", "%u %u %u, %u", color[0], color[1], color[2], color[3]);
        ui_tooltip(toolkit, "Red, green, blue and alpha of the node, 0 to 255.");
    }
    if (selection->has_normal) {
        const float *normal = selection->normal;
        ui_value(toolkit, "Normal", "%.2f %.2f %.2f", (double)normal[0], (double)normal[1], (double)normal[2]);
    }
    if (selection->has_material) {
        ui_value(toolkit, "Material", "%u", selection->material);
    }
    if (selection->has_fill) {
        ui_value(toolkit, "Fill", "%u", selection->fill);
        ui_tooltip(toolkit, "How much surface the node holds.");
    }
}

static void describe_list(ui *toolkit, const view_selection *selection)
{
    ui_value(toolkit, "In the leaf", "%s", figure_count(selection->list_count).text);
    ui_tooltip(toolkit, "Triangles that touch the leaf; the picture shows them.");
    const size_t shown = selection->list_kept < LIST_SHOWN ? selection->list_kept : LIST_SHOWN;
    char text[16 * LIST_SHOWN] = "";
    size_t used = 0;
    for (size_t i = 0; i < shown; ++i) {
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%u", i > 0 ? ", " : "", selection->list[i]);
    }
    if (shown > 0) {
        ui_note(toolkit, "%s%s", text, selection->list_count > shown ? " ..." : "");
    }
}

void panels_selection(ui *toolkit, view_state *state)
{
    const view_selection *selection = &state->selection;
    if (!selection->is_hit) {
        ui_note(toolkit, "Click on the picture.");
        return;
    }
    const float *point = selection->point;
    if (selection->triangle != SVO_NO_TRIANGLE) {
        ui_value(toolkit, "Triangle", "%u", selection->triangle);
        ui_tooltip(toolkit, "Its position in the mesh.");
    }
    ui_value(toolkit, "t", "%.5g", (double)selection->t);
    ui_tooltip(toolkit, "World units from the eye.");
    ui_value(toolkit, "At", "%.4g %.4g %.4g", (double)point[0], (double)point[1], (double)point[2]);
    if (selection->instance != SVO_NO_INSTANCE) {
        ui_value(toolkit, "Instance", "%u", selection->instance);
    }
    if (selection->node != SVO_NO_NODE) {
        ui_value(toolkit, selection->level == state->shown.level ? "Leaf" : "Node", "%u", selection->node);
        ui_value(toolkit, "Level", "%u", selection->level);
        describe_payload(toolkit, selection);
    }
    if (selection->list_count > 0) {
        describe_list(toolkit, selection);
    }
}

/* ---- instances ---- */

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
