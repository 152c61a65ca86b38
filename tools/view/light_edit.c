/* SPDX-License-Identifier: MIT */
/* Positions and directions of lights. */
#include "view/light_edit.h"

#include <math.h>
#include <string.h>

#include "view/camera.h"

#define PI 3.14159265F

/* What a step of the wheel multiplies a light's distance by. */
#define PUSH_STEP 1.1F

/* The camera's axes, unit: right, up, away. */
typedef struct frame {
    float right[3], up[3], away[3];
} frame;

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

static frame find_frame(const svo_camera *camera)
{
    frame found;
    for (int i = 0; i < 3; ++i) {
        found.away[i] = camera->target[i] - camera->eye[i];
    }
    normalize(found.away);
    cross(found.away, camera->up, found.right);
    normalize(found.right);
    cross(found.right, found.away, found.up);
    return found;
}

static float distance_to_target(const svo_camera *camera)
{
    return hypotf(hypotf(camera->target[0] - camera->eye[0], camera->target[1] - camera->eye[1]),
                  camera->target[2] - camera->eye[2]);
}

/* Half way to the target, and a quarter of the way above the line of sight: in the open for most views. Intensities are
   such that the target gets about as much light as from a sun. */
bool light_edit_add(view_state *state, uint32_t kind)
{
    const svo_camera *camera = &state->camera.at;
    const frame axes = find_frame(camera);
    const float away = distance_to_target(camera);
    const float value = kind == SVO_SOURCE_DIRECTIONAL ? 2 : 0.6F * away * away;
    svo_light_source source = {.kind = kind, .value = {value, 0.95F * value, 0.88F * value}};
    for (int i = 0; i < 3; ++i) {
        source.position[i] = camera->eye[i] + 0.5F * away * axes.away[i] + 0.25F * away * axes.up[i];
        source.direction[i] = kind == SVO_SOURCE_SPOT ? camera->target[i] - source.position[i]
                                                      : 0.4F * axes.away[i] - 0.3F * axes.right[i] - axes.up[i];
    }
    source.inner_angle = kind == SVO_SOURCE_SPOT ? 0.35F : 0;
    source.outer_angle = kind == SVO_SOURCE_SPOT ? 0.5F : 0;
    return view_add_source(state, &source);
}

static void turn_direction(view_state *state, const frame *axes, float right, float down, float direction[3])
{
    const float step = 2 * PI / (float)(state->width > 0 ? state->width : 1);
    normalize(direction);
    for (int i = 0; i < 3; ++i) {
        direction[i] -= step * (right * axes->right[i] - down * axes->up[i]);
    }
    normalize(direction);
}

void light_edit_drag(view_state *state, float right, float down)
{
    const frame axes = find_frame(&state->camera.at);
    if (state->is_scene && state->scene_light < state->scene_light_count) {
        /* Towards the light, so the other way round. */
        turn_direction(state, &axes, -right, -down, state->scene_lights[state->scene_light].direction);
        view_lights_changed(state);
    } else if (!state->is_scene && state->source < state->source_count) {
        svo_light_source *source = &state->sources[state->source];
        if (source->kind == SVO_SOURCE_DIRECTIONAL) {
            turn_direction(state, &axes, right, down, source->direction);
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
