/* SPDX-License-Identifier: MIT */
/* Turning, moving and projecting, in double: a camera is turned many thousand times. Probes are seen as spheres, whose
   size follows the grid: neighbors never touch. */
#include "view/camera.h"

#include <math.h>
#include <string.h>

/* Least angle between the line of sight and up, radians. */
#define POLE_ANGLE 0.02
#define WHEEL_STEP 1.15
/* Nearest to the eye, in distances of the target. */
#define NEAR_SHARE 1e-3

/* An orthonormal frame: to the right, up in the picture, along the line of sight; and the distance of the target. */
typedef struct frame {
    double right[3], above[3], sight[3];
    double distance;
} frame;

/* ---- vectors ---- */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        const int next = (axis + 1) % 3;
        const int last = (axis + 2) % 3;
        out[axis] = a[next] * b[last] - a[last] * b[next];
    }
}

/* Returns the length that it had. */
static double normalize(double a[3])
{
    const double length = sqrt(dot(a, a));
    for (int axis = 0; axis < 3 && length > 0; ++axis) {
        a[axis] /= length;
    }
    return length;
}

/* Turns a vector around a unit axis (Rodrigues' formula). */
static void turn(double vector[3], const double axis[3], double angle)
{
    double across[3];
    const double along = dot(axis, vector) * (1 - cos(angle));
    cross(axis, vector, across);
    for (int i = 0; i < 3; ++i) {
        vector[i] = vector[i] * cos(angle) + across[i] * sin(angle) + axis[i] * along;
    }
}

static void unit_up(const svo_camera *camera, double up[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        up[axis] = (double)camera->up[axis];
    }
    (void)normalize(up);
}

void camera_up(const view_state *state, double up[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        up[axis] = (double)state->camera.up[axis];
    }
    if (!(normalize(up) > 0)) {
        unit_up(&state->camera.at, up);
    }
}

static frame frame_of(const svo_camera *camera)
{
    frame out;
    double up[3];
    for (int axis = 0; axis < 3; ++axis) {
        out.sight[axis] = (double)camera->target[axis] - (double)camera->eye[axis];
    }
    unit_up(camera, up);
    out.distance = normalize(out.sight);
    cross(out.sight, up, out.right);
    (void)normalize(out.right);
    cross(out.right, out.sight, out.above);
    return out;
}

/* ---- turning ---- */

/* The angle by which the line of sight may turn towards up, of what is wanted. */
static double limit_angle(const double sight[3], const double up[3], double wanted)
{
    const double cosine = dot(sight, up);
    const double now = acos(cosine > 1 ? 1 : cosine < -1 ? -1 : cosine); /* from up */
    const double least = POLE_ANGLE - now;
    const double most = acos(-1.0) - POLE_ANGLE - now;
    const double asked = -wanted; /* away from up */
    return -(asked < least ? least : asked > most ? most : asked);
}

void camera_turn(view_state *state, float right, float down)
{
    svo_camera *camera = &state->camera.at;
    const double radians = (double)state->settings.turn_speed / (double)state->width;
    const bool orbits = state->camera.mode == VIEW_ORBIT;
    const double sign = orbits ? -1 : 1; /* dragging to the right turns the scene, or the head, to the right */
    frame at = frame_of(camera);
    double up[3];
    camera_up(state, up);
    turn(at.sight, at.right, limit_angle(at.sight, up, -(double)down * radians));
    turn(at.sight, up, (orbits ? sign : -sign) * (double)right * radians);
    for (int axis = 0; axis < 3; ++axis) {
        const double way = at.sight[axis] * at.distance;
        camera->up[axis] = (float)up[axis];
        if (orbits) {
            camera->eye[axis] = (float)((double)camera->target[axis] - way);
        } else {
            camera->target[axis] = (float)((double)camera->eye[axis] + way);
        }
    }
}

/* ---- moving ---- */

static void shift(svo_camera *camera, const double by[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        camera->eye[axis] = (float)((double)camera->eye[axis] + by[axis]);
        camera->target[axis] = (float)((double)camera->target[axis] + by[axis]);
    }
}

void camera_pan(view_state *state, float right, float down)
{
    const frame at = frame_of(&state->camera.at);
    const double pixel = 2 * at.distance * tan((double)state->camera.at.vertical_fov / 2) / (double)state->height;
    double by[3];
    for (int axis = 0; axis < 3; ++axis) {
        by[axis] = pixel * ((double)down * at.above[axis] - (double)right * at.right[axis]);
    }
    shift(&state->camera.at, by);
}

void camera_wheel(view_state *state, float steps)
{
    svo_camera *camera = &state->camera.at;
    const double factor = pow(WHEEL_STEP, (double)steps);
    if (state->camera.mode == VIEW_FLY) {
        state->camera.speed = (float)((double)state->camera.speed * factor);
        return;
    }
    for (int axis = 0; axis < 3; ++axis) {
        const double away = (double)camera->eye[axis] - (double)camera->target[axis];
        camera->eye[axis] = (float)((double)camera->target[axis] + away / factor);
    }
}

bool camera_is_moving(const view_state *state)
{
    bool is_moving = false;
    for (int i = 0; i < VIEW_MOTIONS; ++i) {
        is_moving = is_moving || state->camera.held[i];
    }
    return is_moving;
}

void camera_move(view_state *state, float seconds)
{
    const bool *held = state->camera.held;
    const frame at = frame_of(&state->camera.at);
    const double way = (double)state->camera.speed * (double)seconds;
    const double forward = (held[VIEW_FORWARD] ? 1 : 0) - (held[VIEW_BACK] ? 1 : 0);
    const double right = (held[VIEW_RIGHT] ? 1 : 0) - (held[VIEW_LEFT] ? 1 : 0);
    const double up = (held[VIEW_UP] ? 1 : 0) - (held[VIEW_DOWN] ? 1 : 0);
    double axis_up[3];
    double by[3];
    if (!camera_is_moving(state)) {
        return;
    }
    camera_up(state, axis_up);
    for (int axis = 0; axis < 3; ++axis) {
        by[axis] = way * (forward * at.sight[axis] + right * at.right[axis] + up * axis_up[axis]);
    }
    shift(&state->camera.at, by);
}

void camera_go_home(view_state *state)
{
    state->camera.at = state->camera.home;
}

/* ---- up ---- */

/* Turns a vector as one unit vector is turned to another. */
static void turn_along(double vector[3], const double from[3], const double to[3])
{
    double axis[3];
    cross(from, to, axis);
    if (normalize(axis) > 1e-6) {
        const double cosine = dot(from, to);
        turn(vector, axis, acos(cosine > 1 ? 1 : cosine < -1 ? -1 : cosine));
    } else if (dot(from, to) < 0) { /* upside down, around what is to the right of it */
        const double side[3] = {from[1], from[2], from[0]};
        cross(from, side, axis);
        (void)normalize(axis);
        turn(vector, axis, acos(-1.0));
    }
}

static void turn_camera(svo_camera *camera, const double from[3], const double to[3])
{
    double away[3];
    for (int axis = 0; axis < 3; ++axis) {
        away[axis] = (double)camera->eye[axis] - (double)camera->target[axis];
    }
    turn_along(away, from, to);
    for (int axis = 0; axis < 3; ++axis) {
        camera->eye[axis] = (float)((double)camera->target[axis] + away[axis]);
        camera->up[axis] = (float)to[axis];
    }
}

void camera_choose_up(view_state *state, const float up[3])
{
    double from[3];
    double to[3] = {(double)up[0], (double)up[1], (double)up[2]};
    camera_up(state, from);
    if (!(normalize(to) > 0)) {
        return;
    }
    turn_camera(&state->camera.at, from, to);
    turn_camera(&state->camera.home, from, to);
    for (int axis = 0; axis < 3; ++axis) {
        state->camera.up[axis] = (float)to[axis];
    }
}

void camera_look_along(view_state *state, int axis)
{
    svo_camera *camera = &state->camera.at;
    const frame at = frame_of(camera);
    double up[3];
    camera_up(state, up);
    const bool is_pole = fabs(up[axis]) > cos(POLE_ANGLE);
    const int above = axis == 1 ? 2 : 1;
    const float side = axis == 1 ? -1.0F : 1.0F;
    for (int i = 0; i < 3; ++i) {
        camera->eye[i] = (float)((double)camera->target[i] + (i == axis ? at.distance : 0));
        camera->up[i] = !is_pole ? (float)up[i] : i == above ? side : 0;
    }
}

/* ---- the window ---- */

bool camera_project(const view_state *state, const float point[3], float pixel[2])
{
    const svo_camera *camera = &state->camera.at;
    const frame at = frame_of(camera);
    double to[3];
    for (int axis = 0; axis < 3; ++axis) {
        to[axis] = (double)point[axis] - (double)camera->eye[axis];
    }
    const double depth = dot(to, at.sight);
    const double scale = (double)state->height / (2 * tan((double)camera->vertical_fov / 2));
    if (!(depth > NEAR_SHARE * at.distance)) {
        return false;
    }
    pixel[0] = (float)((double)state->width / 2 + scale * dot(to, at.right) / depth);
    pixel[1] = (float)((double)state->height / 2 - scale * dot(to, at.above) / depth);
    return true;
}

void camera_drag_point(const view_state *state, float right, float down, float point[3])
{
    const svo_camera *camera = &state->camera.at;
    const frame at = frame_of(camera);
    double to[3];
    for (int axis = 0; axis < 3; ++axis) {
        to[axis] = (double)point[axis] - (double)camera->eye[axis];
    }
    const double depth = fmax(dot(to, at.sight), NEAR_SHARE * at.distance);
    const double pixel = 2 * depth * tan((double)camera->vertical_fov / 2) / (double)state->height;
    for (int axis = 0; axis < 3; ++axis) {
        const double way = pixel * ((double)right * at.right[axis] - (double)down * at.above[axis]);
        point[axis] = (float)((double)point[axis] + way);
    }
}

void camera_ray(const view_state *state, float x, float y, float direction[3])
{
    const svo_camera *camera = &state->camera.at;
    const frame at = frame_of(camera);
    const double pixel = 2 * tan((double)camera->vertical_fov / 2) / (double)state->height;
    const double right = ((double)x - (double)state->width / 2) * pixel;
    const double above = ((double)state->height / 2 - (double)y) * pixel;
    double ray[3];
    for (int axis = 0; axis < 3; ++axis) {
        ray[axis] = at.sight[axis] + right * at.right[axis] + above * at.above[axis];
    }
    (void)normalize(ray);
    for (int axis = 0; axis < 3; ++axis) {
        direction[axis] = (float)ray[axis];
    }
}

float camera_distance(const view_state *state)
{
    const float *eye = state->camera.at.eye;
    const float *target = state->camera.at.target;
    return hypotf(hypotf(target[0] - eye[0], target[1] - eye[1]), target[2] - eye[2]);
}

void camera_axes(const view_state *state, float right[3], float above[3], float sight[3])
{
    const frame at = frame_of(&state->camera.at);
    for (int axis = 0; axis < 3; ++axis) {
        right[axis] = (float)at.right[axis];
        above[axis] = (float)at.above[axis];
        sight[axis] = (float)at.sight[axis];
    }
}

void camera_clip_ray(const view_state *state, svo_ray *ray)
{
    float plane[4];
    view_clip_plane(state, plane);
    double height = (double)plane[3];
    double along = 0;
    for (int axis = 0; axis < 3; ++axis) {
        height += (double)plane[axis] * (double)ray->origin[axis];
        along += (double)plane[axis] * (double)ray->direction[axis];
    }
    const float crossing = (float)(along != 0 ? -height / along : 0);
    if (height >= 0) {
        ray->t_max = along < 0 ? fminf(ray->t_max, crossing) : ray->t_max;
    } else {
        ray->t_min = along > 0 ? crossing : 0;
        ray->t_max = along > 0 ? ray->t_max : -1;
    }
}

void camera_pick_ray(const view_state *state, float x, float y, svo_ray *ray)
{
    *ray = (svo_ray){.t_max = INFINITY};
    memcpy(ray->origin, state->camera.at.eye, sizeof ray->origin);
    camera_ray(state, x, y, ray->direction);
    camera_clip_ray(state, ray);
}

/* ---- probes as spheres ---- */

#define RADIUS_OF_MEAN  0.06F /* of the mean of the steps between probes along the axes */
#define RADIUS_OF_LEAST 0.25F /* of the least step, at most */
#define RADIUS_PIXELS   2.5F /* at least */

static float distance_along_sight(const svo_camera *camera, const float point[3])
{
    float along = 0;
    float squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const float sight = camera->target[axis] - camera->eye[axis];
        along += sight * (point[axis] - camera->eye[axis]);
        squared += sight * sight;
    }
    return along / sqrtf(squared);
}

bool probe_sphere_project(const view_state *state, uint32_t index, probe_sphere *out)
{
    const svo_probe *probe = &state->probes.places[index];
    const float *step = state->probes.made.step;
    const float radius = fminf(RADIUS_OF_MEAN * (step[0] + step[1] + step[2]) / 3,
                               RADIUS_OF_LEAST * fminf(fminf(step[0], step[1]), step[2]));
    out->index = index;
    if (!camera_project(state, probe->position, out->pixel)) {
        return false;
    }
    out->away = distance_along_sight(&state->camera.at, probe->position);
    const float scale = (float)state->height / (2 * tanf(state->camera.at.vertical_fov / 2) * out->away);
    out->radius = fmaxf(radius * scale, RADIUS_PIXELS);
    return true;
}

bool probe_sphere_at(const view_state *state, float x, float y, uint32_t *index)
{
    const bool are_shown = state->probes.has_spheres && state->probes.places != NULL;
    const uint32_t count = are_shown ? state->probes.made.probe_count : 0;
    float nearest = INFINITY;
    for (uint32_t i = 0; i < count; ++i) {
        probe_sphere sphere;
        if (probe_sphere_project(state, i, &sphere) && sphere.away < nearest &&
            hypotf(x - sphere.pixel[0], y - sphere.pixel[1]) <= sphere.radius) {
            nearest = sphere.away;
            *index = i;
        }
    }
    return nearest < INFINITY;
}
