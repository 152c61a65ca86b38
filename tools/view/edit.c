/* SPDX-License-Identifier: MIT */
/*
 * Changes of what is edited: lists that grow and shrink; lights by the mouse and as angles; placements of instances;
 * and motions, frames by seconds.
 */
#include "view/edit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/camera.h"

#define PI 3.14159265F

/* What a step of the wheel multiplies a light's distance by. */
#define PUSH_STEP 1.1F
/* Notches that follow each other within this time are one edit. */
#define WHEEL_SECONDS 0.5

/* Of scales, without sign: a scene refuses what is flat. */
#define SCALE_MIN 1e-6F

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

/* ---- the camera's view of them ---- */

/* Unit: right, up, away. */
typedef struct camera_frame {
    float right[3], up[3], away[3];
} camera_frame;

static camera_frame frame_of(const view_state *state)
{
    camera_frame seen = {{0}, {0}, {0}};
    camera_axes(state, seen.right, seen.up, seen.away);
    return seen;
}

/* ---- lights ---- */

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const float a[3], const float b[3], float out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void normalize(float vector[3])
{
    const float length = sqrtf(dot(vector, vector));
    for (int i = 0; i < 3 && length > 0; ++i) {
        vector[i] /= length;
    }
}

/* Half way to the target, and a quarter of the way above the line of sight: in the open for most views. Intensities are
   such that the target gets about as much light as from a sun. */
bool light_edit_add(view_state *state, uint32_t kind)
{
    const svo_camera *camera = &state->camera.at;
    const camera_frame seen = frame_of(state);
    const float away = camera_distance(state);
    const float value = kind == SVO_SOURCE_DIRECTIONAL ? 2 : 0.6F * away * away;
    svo_light_source source = {.kind = kind, .value = {value, 0.95F * value, 0.88F * value}};
    for (int i = 0; i < 3; ++i) {
        source.position[i] = camera->eye[i] + 0.5F * away * seen.away[i] + 0.25F * away * seen.up[i];
        source.direction[i] = kind >= SVO_SOURCE_SPOT ? camera->target[i] - source.position[i]
                                                      : 0.4F * seen.away[i] - 0.3F * seen.right[i] - seen.up[i];
    }
    source.inner_angle = kind == SVO_SOURCE_SPOT ? 0.35F : 0;
    source.outer_angle = kind == SVO_SOURCE_SPOT ? 0.5F : 0;
    source.radius = kind == SVO_SOURCE_DISK ? 0.05F * away : 0;
    return view_add_source(state, &source);
}

static void turn_direction(view_state *state, const camera_frame *seen, float right, float down, float direction[3])
{
    const float step = 2 * PI / (float)(state->width > 0 ? state->width : 1);
    normalize(direction);
    for (int i = 0; i < 3; ++i) {
        direction[i] -= step * (right * seen->right[i] - down * seen->up[i]);
    }
    normalize(direction);
}

void light_edit_drag(view_state *state, float right, float down)
{
    const camera_frame seen = frame_of(state);
    if (state->is_scene && state->scene_light < state->scene_light_count) {
        /* Towards the light, so the other way round. */
        turn_direction(state, &seen, -right, -down, state->scene_lights[state->scene_light].direction);
        view_lights_changed(state);
    } else if (!state->is_scene && state->source < state->source_count) {
        svo_light_source *source = &state->sources[state->source];
        if (source->kind == SVO_SOURCE_DIRECTIONAL) {
            turn_direction(state, &seen, right, down, source->direction);
        } else {
            camera_drag_point(state, right, down, source->position);
        }
        view_lights_changed(state);
    }
}

void light_edit_push(view_state *state, float steps)
{
    if (state->is_scene || state->source >= state->source_count ||
        state->sources[state->source].kind == SVO_SOURCE_DIRECTIONAL) {
        return;
    }
    float *position = state->sources[state->source].position;
    const float *eye = state->camera.at.eye;
    const float factor = powf(PUSH_STEP, steps);
    for (int i = 0; i < 3; ++i) {
        position[i] = eye[i] + factor * (position[i] - eye[i]);
    }
    state->wheel_rests = state->seconds + WHEEL_SECONDS;
    view_lights_changed(state);
}

/* The axes around the world's up: for y they are x, y and z. */
static void find_world(const view_state *state, float axes[3][3])
{
    double up[3];
    camera_up(state, up);
    const bool is_z = fabs(up[2]) > 0.9;
    const float helper[3] = {0, is_z ? -1.0F : 0, is_z ? 0 : 1.0F};
    for (int i = 0; i < 3; ++i) {
        axes[1][i] = (float)up[i];
    }
    cross(axes[1], helper, axes[0]);
    normalize(axes[0]);
    cross(axes[0], axes[1], axes[2]);
}

void light_edit_angles(const view_state *state, const float direction[3], float angles[2])
{
    float axes[3][3];
    find_world(state, axes);
    const float seen[3] = {dot(axes[0], direction), dot(axes[1], direction), dot(axes[2], direction)};
    angles[0] = atan2f(-seen[0], -seen[2]) * 180 / PI;
    angles[1] = atan2f(-seen[1], hypotf(seen[0], seen[2])) * 180 / PI;
}

void light_edit_direction(const view_state *state, const float angles[2], float direction[3])
{
    float axes[3][3];
    const float around = angles[0] * PI / 180;
    const float above = angles[1] * PI / 180;
    const float seen[3] = {-sinf(around) * cosf(above), -sinf(above), -cosf(around) * cosf(above)};
    find_world(state, axes);
    for (int i = 0; i < 3; ++i) {
        direction[i] = seen[0] * axes[0][i] + seen[1] * axes[1][i] + seen[2] * axes[2][i];
    }
}

/* ---- instances ---- */

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
        added = state->instances[state->instance];
        added.transform[3] += 0.25F * camera_distance(state);
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

/* ---- motions ---- */

/* Frames in a second; 0: there is one frame alone, or all have one time. */
static double rate(const view_film *film)
{
    const double span = (double)film->last_time - (double)film->first_time;
    return span > 0 ? ldexp((double)(film->frame_count - 1) / span, film->speed_log2) : 0;
}

/* Whether there is something to play, which is shown then. */
static bool show_film(view_state *state)
{
    if (state->mover_count == 0) {
        view_log(state, "nothing moves: no instance has a 'motion'");
        return false;
    }
    if (!view_shows_film(state)) {
        view_choose_scene(state, false);
    }
    return true;
}

static void show_frame(view_film *film, double position)
{
    film->position = position;
    film->frame = (uint64_t)position;
}

void play_toggle(view_state *state)
{
    view_film *film = &state->film;
    if (show_film(state)) {
        film->is_playing = !film->is_playing;
        if (film->is_playing && !film->loops && film->frame + 1 >= film->frame_count) {
            show_frame(film, 0);
        }
    }
}

void play_seek(view_state *state, uint64_t frame)
{
    if (show_film(state)) {
        const uint64_t last = state->film.frame_count - 1;
        state->film.is_playing = false;
        show_frame(&state->film, (double)(frame < last ? frame : last));
    }
}

void play_step(view_state *state, int direction)
{
    const view_film *film = &state->film;
    const uint64_t end = direction > 0 ? film->frame_count - 1 : 0;
    const uint64_t beyond = film->loops ? film->frame_count - 1 - end : end;
    play_seek(state, film->frame == end ? beyond : direction > 0 ? film->frame + 1 : film->frame - 1);
}

void play_choose_speed(view_state *state, int speed_log2)
{
    const int most = speed_log2 < VIEW_SPEED_MAX ? speed_log2 : VIEW_SPEED_MAX;
    state->film.speed_log2 = most > -VIEW_SPEED_MAX ? most : -VIEW_SPEED_MAX;
}

void play_advance(view_state *state, double seconds)
{
    view_film *film = &state->film;
    if (!film->is_playing) {
        return;
    }
    const double count = (double)film->frame_count;
    const double position = film->position + seconds * rate(film);
    if (position < count) {
        show_frame(film, position);
    } else if (film->loops) {
        show_frame(film, fmod(position, count));
    } else {
        play_seek(state, film->frame_count - 1);
    }
}
