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
    *state = (view_state){.shown = {.photons = true, .gi = true, .cones = 16, .exposure = 1.0F, .probes = grid},
                          .film = {.loops = true},
                          .probes = {.asked = grid}};
    state->selection.instance = SVO_NO_INSTANCE;
    state->settings = (view_settings){.width = 1280,
                                      .height = 800,
                                      .panels = true,
                                      .open = {[VIEW_PANEL_FRAMES] = true, [VIEW_PANEL_PICTURE] = true},
                                      .turn_speed = 3.0F,
                                      .move_speed = 0.25F,
                                      .goal_ms = 40.0F,
                                      .text_scale = 0.0F};
}

void view_state_end(view_state *state)
{
    free(state->sources);
    free(state->instances);
    free(state->movers);
    state->sources = NULL;
    state->instances = NULL;
    state->movers = NULL;
    state->source_count = 0;
    state->instance_count = 0;
    state->mover_count = 0;
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
    static const char *const names[VIEW_PANELS] = {"help",      "frames",    "memory",   "view", "camera", "lights",
                                                   "selection", "instances", "settings", "log",  "probes", "motion"};
    return (unsigned)panel < VIEW_PANELS ? names[panel] : "unknown panel";
}

const char *view_map_name(view_map map)
{
    static const char *const names[VIEW_MAPS] = {"radiance", "normal", "distance"};
    return (unsigned)map < VIEW_MAPS ? names[map] : "unknown map";
}

/* ---- log ---- */

void view_log(view_state *state, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(state->log[state->log_count % VIEW_LOG_LINES], VIEW_LINE_BYTES, format, arguments);
    va_end(arguments);
    ++state->log_count;
}

/* ---- what is saved ---- */

bool view_is_unsaved(const view_state *state)
{
    return state->unsaved[VIEW_SCENE] || state->unsaved[VIEW_LIGHTS];
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
}

void view_toggle_panel(view_state *state, view_panel panel)
{
    if ((unsigned)panel < VIEW_PANELS) {
        state->settings.open[panel] = !state->settings.open[panel];
    }
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

void view_choose_probe_choice(view_state *state, svo_probe_choice choice)
{
    state->shown.choice = choice;
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

/* ---- lists ---- */

/* Makes room for one more element. */
static void *grow(void *list, size_t count, size_t *capacity, size_t element_bytes)
{
    if (count < *capacity) {
        return list;
    }
    const size_t wanted = *capacity > 0 ? 2 * *capacity : 8;
    void *larger = realloc(list, wanted * element_bytes);
    if (larger != NULL) {
        *capacity = wanted;
    }
    return larger;
}

void view_lights_changed(view_state *state)
{
    ++state->revisions.lights;
}

bool view_add_source(view_state *state, const svo_light_source *source)
{
    svo_light_source *sources =
        grow(state->sources, state->source_count, &state->source_capacity, sizeof *state->sources);
    if (sources == NULL) {
        view_log(state, "out of memory for another light");
        return false;
    }
    state->sources = sources;
    state->source = state->source_count;
    state->sources[state->source_count++] = *source;
    view_lights_changed(state);
    return true;
}

void view_remove_source(view_state *state, size_t index)
{
    if (index < state->source_count) {
        svo_light_source *gone = &state->sources[index];
        memmove(gone, gone + 1, (--state->source_count - index) * sizeof *gone);
        state->source = state->source > 0 && state->source >= index ? state->source - 1 : state->source;
        view_lights_changed(state);
    }
}

void view_instances_changed(view_state *state)
{
    state->selection.is_hit = false; /* what was picked may be elsewhere */
    ++state->revisions.instances;
}

bool view_add_instance(view_state *state, const svo_instance *instance)
{
    svo_instance *instances =
        grow(state->instances, state->instance_count, &state->instance_capacity, sizeof *state->instances);
    if (instances == NULL) {
        view_log(state, "out of memory for another instance");
        return false;
    }
    state->instances = instances;
    state->instance = state->instance_count;
    state->instances[state->instance_count++] = *instance;
    view_instances_changed(state);
    return true;
}

view_mover *view_mover_of(const view_state *state, size_t instance)
{
    size_t low = 0;
    size_t high = state->mover_count;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (state->movers[middle].instance < instance) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < state->mover_count && state->movers[low].instance == instance ? &state->movers[low] : NULL;
}

scene_place view_mover_key(const view_mover *mover, size_t key)
{
    const scene_place *first = &mover->motion->keys[0].place;
    scene_place place = mover->motion->keys[key].place;
    for (int axis = 0; axis < 3; ++axis) {
        place.translate[axis] += mover->first.translate[axis] - first->translate[axis];
        place.rotate[axis] += mover->first.rotate[axis] - first->rotate[axis];
        place.scale[axis] *= mover->first.scale[axis] / first->scale[axis];
    }
    return key == 0 ? mover->first : place;
}

bool view_add_mover(view_state *state, const view_mover *mover)
{
    view_mover *movers = grow(state->movers, state->mover_count, &state->mover_capacity, sizeof *state->movers);
    if (movers == NULL) {
        view_log(state, "out of memory for another motion");
        return false;
    }
    state->movers = movers;
    state->movers[state->mover_count++] = *mover;
    return true;
}

/* Of an instance that is gone; those above it have moved down. */
static void remove_mover(view_state *state, size_t instance)
{
    size_t kept = 0;
    for (size_t i = 0; i < state->mover_count; ++i) {
        view_mover mover = state->movers[i];
        if (mover.instance != instance) {
            mover.instance -= mover.instance > instance ? 1 : 0;
            state->movers[kept++] = mover;
        }
    }
    state->mover_count = kept;
}

void view_remove_instance(view_state *state, size_t index)
{
    if (index < state->instance_count) {
        svo_instance *gone = &state->instances[index];
        memmove(gone, gone + 1, (--state->instance_count - index) * sizeof *gone);
        remove_mover(state, index);
        state->instance = state->instance > 0 && state->instance >= index ? state->instance - 1 : state->instance;
        view_instances_changed(state);
    }
}

/* ---- scenes ---- */

void view_choose_scene(view_state *state, bool is_scene)
{
    static const svo_instance first = {.transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    if (!is_scene && state->scene_form != NULL && state->mover_count == 0) {
        view_log(state, "a scene from a file has no tree to show alone");
    } else if (is_scene && state->tree_count == 0) {
        view_log(state, "trees that came through a pipe cannot be placed");
    } else if (!is_scene || state->instance_count > 0 || view_add_instance(state, &first)) {
        state->is_scene = is_scene;
        state->film.is_playing = state->film.is_playing && !is_scene;
        state->selection.is_hit = state->selection.is_hit && state->mover_count == 0; /* what moves is elsewhere */
        state->shown.picture = VIEW_SHADED;
        state->shown.through = false;
        state->probes.map = is_scene ? VIEW_MAP_NORMAL : state->probes.map;
    }
}

bool view_shows_film(const view_state *state)
{
    return !state->is_scene && state->mover_count > 0;
}

void view_add_scene_light(view_state *state)
{
    if (state->scene_light_count == SVO_SCENE_LIGHTS_MAX) {
        view_log(state, "a scene has at most %u lights", SVO_SCENE_LIGHTS_MAX);
        return;
    }
    state->scene_light = state->scene_light_count;
    state->scene_lights[state->scene_light_count++] =
        (svo_scene_light){.direction = {0.5F, 0.7F, 0.4F}, .shadows = 1, .color = {1, 1, 1}};
    view_lights_changed(state);
}

void view_remove_scene_light(view_state *state, size_t index)
{
    if (index < state->scene_light_count) {
        svo_scene_light *gone = &state->scene_lights[index];
        memmove(gone, gone + 1, (--state->scene_light_count - index) * sizeof *gone);
        state->scene_light =
            state->scene_light > 0 && state->scene_light >= index ? state->scene_light - 1 : state->scene_light;
        view_lights_changed(state);
    }
}
