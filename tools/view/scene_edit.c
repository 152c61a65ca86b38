/* SPDX-License-Identifier: MIT */
/* Placements and lists of instances. */
#include "view/scene_edit.h"

#include <math.h>
#include <string.h>

#include "view/camera.h"

/* Of scales, without sign: a scene refuses what is flat. */
#define SCALE_MIN 1e-6F

/* Angles are not unique, so what a hand turned is remembered as long as it gives the instance's matrix. */
bool scene_edit_place(const view_state *state, size_t index, scene_place *out)
{
    const float *transform = state->instances[index].transform;
    const view_mover *mover = view_mover_of(state, index);
    if (mover != NULL) {
        *out = mover->first;
        return true;
    }
    if (scene_place_is_exact(&state->edited, transform)) {
        *out = state->edited;
        return true;
    }
    *out = (scene_place){.scale = {1, 1, 1}};
    const bool is_found = scene_place_find(transform, out);
    for (int axis = 0; axis < 3; ++axis) {
        out->translate[axis] = transform[4 * axis + 3];
    }
    return is_found;
}

static bool is_usable(const scene_place *place)
{
    bool usable = view_is_moderate(place->translate, 3) && view_is_moderate(place->rotate, 3) &&
                  view_is_moderate(place->scale, 3);
    for (int i = 0; i < 3; ++i) {
        usable = usable && fabsf(place->scale[i]) >= SCALE_MIN;
    }
    return usable;
}

/* Moves all keys with the first; what is not a number for one of them changes none. */
static bool move_keys(view_state *state, size_t index, const scene_place *place)
{
    view_mover *mover = view_mover_of(state, index);
    if (mover == NULL) {
        return true;
    }
    view_mover moved = *mover;
    moved.first = *place;
    for (size_t i = 0; i < moved.motion->key_count; ++i) {
        const scene_place key = view_mover_key(&moved, i);
        if (!view_is_moderate(key.translate, 3) || !view_is_moderate(key.rotate, 3) ||
            !view_is_moderate(key.scale, 3)) {
            return false;
        }
    }
    *mover = moved;
    return true;
}

bool scene_edit_set(view_state *state, size_t index, const scene_place *place)
{
    if (index >= state->instance_count || !is_usable(place) || !move_keys(state, index, place)) {
        return false;
    }
    state->edited = *place;
    scene_place_compose(place, state->instances[index].transform);
    view_instances_changed(state);
    return true;
}

void scene_edit_move(view_state *state, size_t index, const float translate[3])
{
    if (index >= state->instance_count || !view_is_moderate(translate, 3)) {
        return;
    }
    const view_mover *mover = view_mover_of(state, index);
    if (mover != NULL) {
        scene_place place = mover->first;
        memcpy(place.translate, translate, sizeof place.translate);
        if (!move_keys(state, index, &place)) {
            return;
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        state->instances[index].transform[4 * axis + 3] = translate[axis];
    }
    view_instances_changed(state);
}

/* Where an instance was picked is what the mouse holds, else its origin. The picked point moves along. */
void scene_edit_drag(view_state *state, float right, float down)
{
    if (state->instance >= state->instance_count) {
        return;
    }
    float *transform = state->instances[state->instance].transform;
    const bool is_picked = state->selection.instance == state->instance;
    float held[3];
    float moved[3];
    float translate[3];
    for (int axis = 0; axis < 3; ++axis) {
        held[axis] = is_picked ? state->selection.point[axis] : transform[4 * axis + 3];
        moved[axis] = held[axis];
    }
    camera_drag_point(state, right, down, moved);
    for (int axis = 0; axis < 3; ++axis) {
        translate[axis] = transform[4 * axis + 3] + moved[axis] - held[axis];
    }
    scene_edit_move(state, state->instance, translate);
    memcpy(state->selection.point, moved, sizeof moved);
}

/* The copy of an instance that moves does so too, from where it is. */
static bool copy_motion(view_state *state, size_t from, const svo_instance *added)
{
    const view_mover *mover = view_mover_of(state, from);
    if (mover == NULL) {
        return true;
    }
    view_mover copy = *mover;
    copy.instance = state->instance;
    for (int axis = 0; axis < 3; ++axis) {
        copy.first.translate[axis] = added->transform[4 * axis + 3];
    }
    return view_add_mover(state, &copy);
}

bool scene_edit_add(view_state *state)
{
    const size_t from = state->instance;
    svo_instance added = {.transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    if (state->instance < state->instance_count) {
        const float *eye = state->camera.at.eye;
        const float *target = state->camera.at.target;
        added = state->instances[state->instance];
        const float away = hypotf(hypotf(eye[0] - target[0], eye[1] - target[1]), eye[2] - target[2]);
        added.transform[3] += 0.25F * away;
    }
    if (!view_add_instance(state, &added)) {
        return false;
    }
    if (!copy_motion(state, from, &added)) {
        view_remove_instance(state, state->instance);
        return false;
    }
    view_log(state, "added instance %zu of %s", state->instance, state->trees[added.tree].name);
    return true;
}

void scene_edit_remove(view_state *state)
{
    if (state->instance_count < 2) {
        view_log(state, "a scene keeps its last instance");
        return;
    }
    view_log(state, "removed instance %zu", state->instance);
    view_remove_instance(state, state->instance);
}
