/* SPDX-License-Identifier: MIT */
/* Changes of the viewer's state. */
#include "view/state.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void view_state_begin(view_state *state)
{
    const view_probe_grid grid = {.counts = {4, 4, 4}, .resolution = 128, .field_size = 64, .max_mib = 1024};
    *state = (view_state){.shown = {.photons = true, .gi = true, .exposure = 1.0F, .probes = grid},
                          .exposure_is_automatic = true,
                          .film = {.loops = true},
                          .scale = 1,
                          .probes = {.asked = grid},
                          .brush = {.radius = 4, .color = {0.8F, 0.3F, 0.2F}}};
    state->selection.instance = SVO_NO_INSTANCE;
    state->settings = (view_settings){.width = 1280,
                                      .height = 800,
                                      .panels = true,
                                      .open = {[VIEW_PANEL_FRAMES] = true, [VIEW_PANEL_PICTURE] = true},
                                      .turn_speed = 3.0F,
                                      .move_speed = 0.25F,
                                      .goal_ms = 40.0F,
                                      .text_scale = 0.0F,
                                      .axes = true};
}

void view_state_end(view_state *state)
{
    free(state->sources);
    free(state->instances);
    free(state->movers);
    free(state->share_reason);
    for (size_t i = 0; i < VIEW_LOG_LINES; ++i) {
        free(state->log[i]);
        state->log[i] = NULL;
    }
    state->share_reason = NULL;
    for (size_t i = 0; i < state->open.name_count; ++i) {
        free(state->open.names[i]);
    }
    free(state->open.names);
    state->open = (view_open){.is_shown = false};
    state->sources = NULL;
    state->instances = NULL;
    state->movers = NULL;
    state->source_count = 0;
    state->instance_count = 0;
    state->mover_count = 0;
}

void view_state_renew(const view_state *before, view_state *fresh)
{
    view_state_begin(fresh);
    fresh->renderer = before->renderer;
    fresh->share = before->share;
    fresh->share_reason = before->share_reason != NULL ? strdup(before->share_reason) : NULL;
    fresh->width = before->width;
    fresh->height = before->height;
    fresh->scale = before->scale;
    fresh->seconds = before->seconds;
    memcpy(fresh->frames, before->frames, sizeof fresh->frames);
    fresh->frame_count = before->frame_count;
    for (size_t i = 0; i < VIEW_LOG_LINES; ++i) {
        fresh->log[i] = before->log[i] != NULL ? strdup(before->log[i]) : NULL;
    }
    fresh->log_count = before->log_count;
    fresh->settings = before->settings;
    fresh->brush.tool = before->brush.tool;
    fresh->brush.shape = before->brush.shape;
    fresh->brush.radius = before->brush.radius;
    fresh->brush.material = before->brush.material;
    memcpy(fresh->brush.color, before->brush.color, sizeof fresh->brush.color);
}

bool view_is_moderate(const float *numbers, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        if (!(numbers[i] >= -1e9F && numbers[i] <= 1e9F)) {
            return false;
        }
    }
    return true;
}

/* ---- names ---- */

const char *view_picture_name(view_picture picture)
{
    static const char *const names[VIEW_PICTURES] = {"shaded", "normal", "depth", "steps", "level",   "triangles",
                                                     "ao",     "direct", "gi",    "full",  "specular"};
    return (unsigned)picture < VIEW_PICTURES ? names[picture] : "unknown picture";
}

const char *view_stage_name(view_stage stage)
{
    static const char *const names[VIEW_STAGES] = {"events", "tree", "picture", "upload", "panels", "show"};
    return (unsigned)stage < VIEW_STAGES ? names[stage] : "unknown stage";
}

const char *view_panel_name(view_panel panel)
{
    static const char *const names[VIEW_PANELS] = {"help",   "frames",    "memory",    "view",     "camera",
                                                   "lights", "selection", "instances", "settings", "log",
                                                   "probes", "motion",    "brush"};
    return (unsigned)panel < VIEW_PANELS ? names[panel] : "unknown panel";
}

const char *view_map_name(view_map map)
{
    static const char *const names[VIEW_MAPS] = {"radiance", "normal", "distance"};
    return (unsigned)map < VIEW_MAPS ? names[map] : "unknown map";
}

/* ---- log ---- */

static __attribute__((format(printf, 2, 0))) void set_text(char **text, const char *format, va_list arguments)
{
    va_list again;
    va_copy(again, arguments);
    const int length = vsnprintf(NULL, 0, format, again);
    va_end(again);
    char *made = length >= 0 ? malloc((size_t)length + 1) : NULL;
    if (made != NULL) {
        (void)vsnprintf(made, (size_t)length + 1, format, arguments);
    }
    free(*text);
    *text = made;
}

void view_set_text(char **text, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    set_text(text, format, arguments);
    va_end(arguments);
}

void view_log(view_state *state, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    set_text(&state->log[state->log_count % VIEW_LOG_LINES], format, arguments);
    va_end(arguments);
    ++state->log_count;
}

const char *view_log_line(const view_state *state, size_t back)
{
    const size_t kept = state->log_count < VIEW_LOG_LINES ? state->log_count : VIEW_LOG_LINES;
    const char *line = back < kept ? state->log[(state->log_count - 1 - back) % VIEW_LOG_LINES] : "";
    return line != NULL ? line : "no memory for this line";
}

/* ---- files ---- */

void view_open_file(view_state *state, const char *path)
{
    if (strlen(path) >= sizeof state->open_path) {
        view_log(state, "a path is longer than %zu bytes", sizeof state->open_path - 1);
    } else if (path[0] != '\0') {
        (void)snprintf(state->open_path, sizeof state->open_path, "%s", path);
        view_leave(state, &state->wants_open);
    }
}

void view_remember_file(view_state *state, const char *path)
{
    char(*recent)[VIEW_PATH_BYTES] = state->settings.recent;
    size_t last = 0;
    if (strlen(path) >= sizeof *recent) {
        return;
    }
    while (last + 1 < VIEW_RECENT_MAX && recent[last][0] != '\0' && strcmp(recent[last], path) != 0) {
        ++last;
    }
    memmove(recent[1], recent[0], last * sizeof *recent);
    (void)snprintf(recent[0], sizeof *recent, "%s", path);
}

void view_notice(view_state *state, const char *text)
{
    (void)snprintf(state->notice, sizeof state->notice, "%s", text);
    view_log(state, "%s", text);
}

/* ---- what is saved ---- */

bool view_is_unsaved(const view_state *state)
{
    const bool is_newer = state->history != NULL && (state->looked.lights != state->revisions.lights ||
                                                     state->looked.instances != state->revisions.instances ||
                                                     state->looked.strokes != state->revisions.strokes);
    return is_newer || state->unsaved[VIEW_SCENE] || state->unsaved[VIEW_LIGHTS] || state->unsaved[VIEW_VOXELS];
}

void view_leave(view_state *state, bool *wish)
{
    if (view_is_unsaved(state)) {
        state->question = (view_question){.asking = VIEW_ASKS_TO_SAVE, .wish = wish, .is_new = true};
    } else {
        *wish = true;
    }
}

/* ---- what is shown ---- */

void view_choose_picture(view_state *state, view_picture picture)
{
    if (state->shown.through && picture > VIEW_STEPS) {
        view_log(state, "view %s is not drawn through probes; key T looks at the tree", view_picture_name(picture));
    } else if (state->shown.through && state->is_scene && picture == VIEW_SHADED) {
        view_log(state, "probes of a scene hold no light: normal, depth and steps alone");
    } else if (state->is_scene && !state->shown.through && picture != VIEW_SHADED) {
        view_log(state, "view %s does not apply to a scene", view_picture_name(picture));
    } else if (view_shows_film(state) && picture > VIEW_TRIANGLES) {
        view_log(state, "view %s is not drawn of what moves; key I looks at the instances", view_picture_name(picture));
    } else if (picture == VIEW_TRIANGLES && !state->has_triangles) {
        view_log(state, "view triangles: the tree holds no triangles");
    } else if ((unsigned)picture < VIEW_PICTURES) {
        state->shown.picture = picture;
    }
}

void view_choose_level(view_state *state, int level)
{
    const int first = (int)state->level_min;
    const int last = (int)state->level_max;
    state->shown.level = (unsigned)(level < first ? first : level > last ? last : level);
}

void view_choose_form(view_state *state, svo_light_form form)
{
    state->shown.form = form;
}

void view_choose_gi(view_state *state, bool is_on)
{
    state->shown.gi = is_on;
}

void view_choose_photons(view_state *state, bool is_on)
{
    state->shown.photons = is_on;
}

void view_choose_exposure(view_state *state, float exposure)
{
    const float least = 1.0F / VIEW_EXPOSURE_MAX;
    state->shown.exposure = exposure < least ? least : exposure > VIEW_EXPOSURE_MAX ? VIEW_EXPOSURE_MAX : exposure;
    state->exposure_is_automatic = false;
}

void view_choose_automatic_exposure(view_state *state, bool is_on)
{
    state->exposure_is_automatic = is_on;
}

void view_toggle_panel(view_state *state, view_panel panel)
{
    if ((unsigned)panel < VIEW_PANELS) {
        state->settings.open[panel] = !state->settings.open[panel];
    }
}

bool view_shows_film(const view_state *state)
{
    return !state->is_scene && state->mover_count > 0;
}

/* ---- clipping ---- */

void view_clip_range(const view_state *state, const float normal[3], float range[2])
{
    range[0] = 0;
    range[1] = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const float low = normal[axis] * state->low[axis];
        const float high = normal[axis] * state->high[axis];
        range[0] += low < high ? low : high;
        range[1] += low < high ? high : low;
    }
}

/* Probes see the whole scene. */
void view_clip_plane(const view_state *state, float plane[4])
{
    const view_clip *clip = &state->shown.clip;
    const bool is_on = clip->is_on && !state->shown.through;
    for (int axis = 0; axis < 3; ++axis) {
        plane[axis] = is_on ? clip->normal[axis] : 0;
    }
    plane[3] = is_on ? -clip->offset : 0;
}

void view_choose_clip(view_state *state, bool is_on)
{
    const svo_camera *at = &state->camera.at;
    view_clip *clip = &state->shown.clip;
    float range[2];
    float most = 0;
    if (is_on && state->shown.through) {
        view_log(state, "pictures through probes are not clipped");
        return;
    }
    clip->is_on = is_on;
    if (!is_on) {
        return;
    }
    memset(clip->normal, 0, sizeof clip->normal);
    for (int axis = 0; axis < 3; ++axis) {
        const float along = at->target[axis] - at->eye[axis];
        if (along > most || -along > most) {
            most = along > 0 ? along : -along;
            memset(clip->normal, 0, sizeof clip->normal);
            clip->normal[axis] = along > 0 ? 1.0F : -1.0F;
        }
    }
    view_clip_range(state, clip->normal, range);
    clip->offset = 0.5F * (range[0] + range[1]);
}

/* ---- the brush ---- */

const char *view_brush_tool_name(view_brush_tool tool)
{
    static const char *const names[VIEW_BRUSH_TOOLS] = {"set", "clear", "paint"};
    return (unsigned)tool < VIEW_BRUSH_TOOLS ? names[tool] : "unknown tool";
}

const char *view_brush_shape_name(view_brush_shape shape)
{
    static const char *const names[VIEW_BRUSH_SHAPES] = {"sphere", "box"};
    return (unsigned)shape < VIEW_BRUSH_SHAPES ? names[shape] : "unknown shape";
}

void view_choose_brush(view_state *state, bool is_on)
{
    if (is_on && (state->is_scene || view_shows_film(state))) {
        view_log(state, "the brush draws on a tree alone, not on instances");
        return;
    }
    if (is_on) {
        view_hide_probes(state);
        state->shown.picture = VIEW_SHADED;
        state->selection.is_hit = false;
        state->settings.open[VIEW_PANEL_BRUSH] = true;
    }
    state->brush.is_on = is_on;
    state->brush.is_down = state->brush.is_over = false;
    view_log(state, "brush: %s", is_on ? "on" : "off");
}

void view_choose_brush_radius(view_state *state, float radius)
{
    state->brush.radius = !(radius > 0) ? 0 : radius < VIEW_BRUSH_MAX ? radius : VIEW_BRUSH_MAX;
}

void view_brush_press(view_state *state, int x, int y)
{
    view_brush *brush = &state->brush;
    brush->is_down = brush->begins = true;
    brush->is_beside = false;
    brush->place_count = 0;
    view_brush_move(state, x, y);
}

/* A hand that is faster than frames keeps its last place; what lies between is a line. */
void view_brush_move(view_state *state, int x, int y)
{
    view_brush *brush = &state->brush;
    const size_t last = VIEW_BRUSH_PLACES - 1;
    const size_t index = brush->place_count < last ? brush->place_count : last;
    brush->places[index][0] = (float)x + 0.5F;
    brush->places[index][1] = (float)y + 0.5F;
    brush->place_count = index + 1;
}

/* ---- probes ---- */

void view_choose_through(view_state *state, bool is_on)
{
    view_shown *shown = &state->shown;
    if (is_on && view_shows_film(state)) {
        view_refuse_probes(state);
        return;
    }
    shown->through = is_on;
    if (state->is_scene) {
        shown->picture = is_on ? VIEW_NORMAL : VIEW_SHADED;
    } else if (is_on && shown->picture > VIEW_STEPS) {
        shown->picture = VIEW_SHADED;
    }
}

bool view_grid_differs(const view_probe_grid *a, const view_probe_grid *b)
{
    return memcmp(a->counts, b->counts, sizeof a->counts) != 0 || a->resolution != b->resolution ||
           a->field_size != b->field_size || a->max_mib != b->max_mib;
}

void view_make_probes(view_state *state)
{
    state->shown.probes = state->probes.asked;
}

void view_choose_probe(view_state *state, int64_t index)
{
    const int64_t last = (int64_t)state->probes.made.probe_count - 1;
    const int64_t most = index > last ? last : index;
    state->probes.chosen = (uint32_t)(most < 0 ? 0 : most);
}

bool view_shows_probes(const view_state *state)
{
    return state->shown.through || state->probes.has_spheres || state->probes.has_map;
}

void view_hide_probes(view_state *state)
{
    if (state->shown.through) {
        view_choose_through(state, false);
    }
    state->probes.has_spheres = false;
    state->probes.has_map = false;
}

void view_refuse_probes(view_state *state)
{
    view_hide_probes(state);
    view_log(state, "what moves has no probes; key I looks at the instances");
}
