/* SPDX-License-Identifier: MIT */
/* Events to changes of the state. */
#include "view/input.h"

#include <math.h>
#include <stdlib.h>

#include "view/camera.h"
#include "view/dialogs.h"
#include "view/edit.h"
#include "view/history.h"

/* Pixels of a plain display that the mouse may move in a click. */
#define CLICK_PIXELS 3.0F
/* Of a key of exposure: a third of a stop. */
#define EXPOSURE_STEP 1.26F

input_binding input_describe(size_t index)
{
    static const input_binding bindings[] = {{"drag", "turn"},
                                             {"right drag", "pan"},
                                             {"wheel", "nearer, or faster"},
                                             {"click", "pick"},
                                             {"Ctrl+drag", "move the light"},
                                             {"W S A D", "move; R F up, down"},
                                             {"C", "orbit or fly"},
                                             {"Home", "first view"},
                                             {"Z", "up: y or z"},
                                             {"V", "clip"},
                                             {"X", "ground grid"},
                                             {"1-9, 0", "views"},
                                             {"L, Shift+L", "level up, down"},
                                             {"G", "indirect light"},
                                             {"P", "photons"},
                                             {"B", "faces, bricks, voxels"},
                                             {"+, -, E", "exposure, automatic"},
                                             {"T", "look through probes"},
                                             {"O, M", "spheres, a map"},
                                             {", and .", "another probe"},
                                             {"Space", "play, pause"},
                                             {"Left, Right", "a frame back, on"},
                                             {"Up, Down", "play faster, slower"},
                                             {"K", "panel Motion"},
                                             {"I", "edit instances"},
                                             {"N, Delete", "add, remove one"},
                                             {"Shift+drag", "move it"},
                                             {"U", "brush; J its panel"},
                                             {"drag, Shift+drag", "draw, turn"},
                                             {"Shift+click", "take its color"},
                                             {"Q, Shift+Q", "its tool, its shape"},
                                             {"[ and ]", "smaller, larger"},
                                             {"Ctrl+S, R", "save, load again"},
                                             {"Ctrl+O, drop", "open a file"},
                                             {"Ctrl+P", "a picture as PNG"},
                                             {"Ctrl+Shift+P", "with the panels"},
                                             {"Ctrl+Z, Y", "undo, redo"},
                                             {"Esc", "drop the selection"},
                                             {"Tab", "panels"},
                                             {"F1-F10, F12", "one panel"},
                                             {"F11", "full screen"},
                                             {"Ctrl+Q", "quit"}};
    return index < sizeof bindings / sizeof bindings[0] ? bindings[index] : (input_binding){NULL, NULL};
}

/* ---- keys ---- */

static bool hold_motion(const view_event *event, view_state *state)
{
    static const int keys[VIEW_MOTIONS] = {'w', 's', 'a', 'd', 'r', 'f'};
    for (int i = 0; i < VIEW_MOTIONS; ++i) {
        if (event->key == keys[i]) {
            state->camera.held[i] = event->is_down && !event->control;
            return true;
        }
    }
    return false;
}

static void change_camera_mode(view_state *state)
{
    state->camera.mode = state->camera.mode == VIEW_ORBIT ? VIEW_FLY : VIEW_ORBIT;
    view_log(state, "camera: %s", state->camera.mode == VIEW_ORBIT ? "orbit" : "fly");
}

static void change_up(view_state *state)
{
    double up[3];
    camera_up(state, up);
    const bool was_y = up[1] > 0.5;
    camera_choose_up(state, (const float[3]){0, was_y ? 0 : 1, was_y ? 1 : 0});
    view_log(state, "up: %s", was_y ? "z" : "y");
}

static void change_form(view_state *state)
{
    view_choose_form(state, (svo_light_form)(((int)state->shown.form + 1) % ((int)SVO_LIGHT_VOXELS + 1)));
    view_log(state, "light is stored as %s", svo_name(SVO_NAME_LIGHT_FORM, state->shown.form));
}

static void edit_instances(view_state *state, bool is_added)
{
    if (!state->is_scene) {
        view_log(state, "key I begins to edit instances");
    } else if (is_added) {
        (void)scene_edit_add(state);
    } else {
        scene_edit_remove(state);
    }
}

/* Keys of probes; false: it is none of them. */
static bool press_for_probes(int key, view_state *state)
{
    switch (key) {
    case 't':
        view_choose_through(state, !state->shown.through);
        return true;
    case 'o':
        state->probes.has_spheres = !state->probes.has_spheres;
        return true;
    case 'm':
        state->probes.has_map = !state->probes.has_map;
        return true;
    case ',':
    case '.':
        view_choose_probe(state, (int64_t)state->probes.chosen + (key == '.' ? 1 : -1));
        return true;
    default:
        return false;
    }
}

/* Keys of motions; false: it is none of them. */
static bool press_for_motions(int key, view_state *state)
{
    switch (key) {
    case VIEW_KEY_SPACE:
        play_toggle(state);
        return true;
    case VIEW_KEY_LEFT:
    case VIEW_KEY_RIGHT:
        play_step(state, key == VIEW_KEY_RIGHT ? 1 : -1);
        return true;
    case VIEW_KEY_UP:
    case VIEW_KEY_DOWN:
        play_choose_speed(state, state->film.speed_log2 + (key == VIEW_KEY_UP ? 1 : -1));
        view_log(state, "a second of motions' time takes %g s", ldexp(1, -state->film.speed_log2));
        return true;
    case 'k':
        view_toggle_panel(state, VIEW_PANEL_MOTION);
        return true;
    default:
        return false;
    }
}

/* Keys of the brush; false: it is none of them. */
static bool press_for_brush(const view_event *event, view_state *state)
{
    view_brush *brush = &state->brush;
    switch (event->key) {
    case 'u':
        view_choose_brush(state, !brush->is_on);
        return true;
    case 'j':
        view_toggle_panel(state, VIEW_PANEL_BRUSH);
        return true;
    case 'q':
        if (event->shift) {
            brush->shape = (view_brush_shape)(((int)brush->shape + 1) % VIEW_BRUSH_SHAPES);
        } else {
            brush->tool = (view_brush_tool)(((int)brush->tool + 1) % VIEW_BRUSH_TOOLS);
        }
        view_log(state, "brush: %s %s", view_brush_tool_name(brush->tool), view_brush_shape_name(brush->shape));
        return true;
    case '[':
    case ']':
        view_choose_brush_radius(state, brush->radius + (event->key == ']' ? 0.5F : -0.5F));
        view_log(state, "brush: radius %g", (double)brush->radius);
        return true;
    default:
        return false;
    }
}

/* Keys with Control; false: it is none of them. */
static bool press_with_control(const view_event *event, view_state *state)
{
    if (!event->control || !event->is_down) {
        return false;
    }
    switch (event->key) {
    case 'q':
        view_leave(state, &state->is_done);
        return true;
    case 's':
        question_save(state);
        return true;
    case 'r':
        view_leave(state, &state->wants_load);
        return true;
    case 'z':
        if (event->shift) {
            history_redo(state);
        } else {
            history_undo(state);
        }
        return true;
    case 'y':
        history_redo(state);
        return true;
    case 'o':
        open_dialog_show(state);
        return true;
    case 'p':
        state->wants_shot = event->shift ? VIEW_SHOT_WINDOW : VIEW_SHOT_PICTURE;
        return true;
    default:
        return false;
    }
}

static void press_letter(const view_event *event, view_state *state)
{
    switch (event->key) {
    case 'g':
        view_choose_gi(state, !state->shown.gi);
        view_log(state, "indirect light: %s", state->shown.gi ? "on" : "off");
        break;
    case 'p':
        view_choose_photons(state, !state->shown.photons);
        view_log(state, "photons: %s", state->shown.photons ? "on" : "off");
        break;
    case 'b':
        change_form(state);
        break;
    case 'c':
        change_camera_mode(state);
        break;
    case 'l':
        view_choose_level(state, (int)state->shown.level + (event->shift ? 1 : -1));
        view_log(state, "level %u of %u", state->shown.level, state->level_max);
        break;
    case '+':
    case '=':
        view_choose_exposure(state, state->shown.exposure * EXPOSURE_STEP);
        break;
    case '-':
        view_choose_exposure(state, state->shown.exposure / EXPOSURE_STEP);
        break;
    case 'e':
        view_choose_automatic_exposure(state, !state->exposure_is_automatic);
        view_log(state, "automatic exposure: %s", state->exposure_is_automatic ? "on" : "off");
        break;
    case 'i':
        view_choose_scene(state, !state->is_scene);
        break;
    case 'n':
        edit_instances(state, true);
        break;
    case 'v':
        view_choose_clip(state, !state->shown.clip.is_on);
        break;
    case 'x':
        state->settings.grid = !state->settings.grid;
        break;
    case 'z':
        change_up(state);
        break;
    default:
        break;
    }
}

/* Of what can be closed, what was shown last. */
static void press_escape(view_state *state)
{
    if (state->notice[0] != '\0') {
        state->notice[0] = '\0';
    } else if (state->open.is_shown) {
        open_dialog_hide(state);
    } else {
        state->selection.is_hit = false;
    }
}

static input_wish press_key(const view_event *event, view_state *state)
{
    const int key = event->key;
    if (key >= '0' && key <= '9') {
        view_choose_picture(state, key == '0' ? VIEW_FULL : (view_picture)(key - '1'));
    } else if (key == VIEW_KEY_F12 - 1) {
        return INPUT_FULLSCREEN;
    } else if (key >= VIEW_KEY_F1 && key <= VIEW_KEY_F12) {
        view_toggle_panel(state, key == VIEW_KEY_F12 ? VIEW_PANEL_PROBES : (view_panel)(key - VIEW_KEY_F1));
    } else if (key == VIEW_KEY_TAB) {
        state->settings.panels = !state->settings.panels;
    } else if (key == VIEW_KEY_HOME) {
        camera_go_home(state);
    } else if (key == VIEW_KEY_DELETE) {
        edit_instances(state, false);
    } else if (key == VIEW_KEY_ESCAPE) {
        press_escape(state);
    } else if (!press_for_probes(key, state) && !press_for_motions(key, state) && !press_for_brush(event, state)) {
        press_letter(event, state);
    }
    return INPUT_NOTHING;
}

/* ---- the mouse ---- */

static void drag(const input_mouse *mouse, const view_event *event, view_state *state)
{
    const float right = (float)(event->x - mouse->x);
    const float down = (float)(event->y - mouse->y);
    if (mouse->held[VIEW_BUTTON_LEFT] && event->control) {
        light_edit_drag(state, right, down);
    } else if (mouse->held[VIEW_BUTTON_LEFT] && event->shift && state->is_scene) {
        scene_edit_drag(state, right, down);
    } else if (mouse->held[VIEW_BUTTON_LEFT] && state->brush.is_down && !state->brush.is_beside) {
        view_brush_move(state, event->x, event->y);
    } else if (mouse->held[VIEW_BUTTON_LEFT]) {
        camera_turn(state, right, down);
    } else if (mouse->held[VIEW_BUTTON_RIGHT] || mouse->held[VIEW_BUTTON_MIDDLE]) {
        camera_pan(state, right, down);
    }
}

static void move(input_mouse *mouse, const view_event *event, view_state *state)
{
    const int across = abs(event->x - mouse->press_x);
    const int along = abs(event->y - mouse->press_y);
    const int most = (int)(CLICK_PIXELS * state->scale);
    mouse->dragged = mouse->dragged || across > most || along > most;
    state->brush.mouse[0] = (float)event->x + 0.5F;
    state->brush.mouse[1] = (float)event->y + 0.5F;
    if (mouse->dragged) {
        drag(mouse, event, state);
    }
    mouse->x = event->x;
    mouse->y = event->y;
}

/* Strokes begin and end. Shift and a click take what the voxel has. */
static void press_with_brush(const input_mouse *mouse, const view_event *event, view_state *state)
{
    if (!event->is_down) {
        state->brush.takes = event->shift && !mouse->dragged;
        state->brush.is_down = false;
    } else if (!event->shift && !event->control) {
        view_brush_press(state, event->x, event->y);
    }
}

static input_wish press_button(input_mouse *mouse, const view_event *event, view_state *state)
{
    const bool was_held = mouse->held[event->button];
    mouse->held[event->button] = event->is_down;
    mouse->x = event->x;
    mouse->y = event->y;
    if (event->is_down) {
        mouse->press_x = event->x;
        mouse->press_y = event->y;
        mouse->dragged = false;
    }
    if (event->button == VIEW_BUTTON_LEFT && state->brush.is_on) {
        press_with_brush(mouse, event, state);
        return INPUT_NOTHING;
    }
    return event->button == VIEW_BUTTON_LEFT && was_held && !event->is_down && !mouse->dragged ? INPUT_PICK
                                                                                               : INPUT_NOTHING;
}

void input_release(input_mouse *mouse, view_state *state)
{
    *mouse = (input_mouse){.x = mouse->x, .y = mouse->y};
    state->brush.is_down = false;
    for (int i = 0; i < VIEW_MOTIONS; ++i) {
        state->camera.held[i] = false;
    }
}

input_wish input_take(input_mouse *mouse, const view_event *event, view_state *state)
{
    switch (event->kind) {
    case VIEW_EVENT_KEY:
        if (state->question.asking != VIEW_ASKS_NOTHING && event->is_down) {
            return INPUT_NOTHING;
        }
        return !press_with_control(event, state) && !hold_motion(event, state) && event->is_down
                   ? press_key(event, state)
                   : INPUT_NOTHING;
    case VIEW_EVENT_MOVE:
        move(mouse, event, state);
        return INPUT_NOTHING;
    case VIEW_EVENT_BUTTON:
        return press_button(mouse, event, state);
    case VIEW_EVENT_WHEEL:
        if (event->control) {
            light_edit_push(state, event->steps);
        } else {
            camera_wheel(state, event->steps);
        }
        return INPUT_NOTHING;
    case VIEW_EVENT_QUIT:
        view_leave(state, &state->is_done);
        return INPUT_NOTHING;
    case VIEW_EVENT_DROP:
        view_open_file(state, event->path);
        return INPUT_NOTHING;
    case VIEW_EVENT_TEXT:
    case VIEW_EVENT_RESIZE:
        return INPUT_NOTHING;
    }
    return INPUT_NOTHING;
}
