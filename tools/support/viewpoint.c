/* SPDX-License-Identifier: MIT */
/* Places the camera. */
#include "support/viewpoint.h"

#include <math.h>

#define DEGREE 0.017453292519943295
/* Of a camera that stands somewhere. */
#define STANDING_FOV 60.0
/* The least sine between up and the line of sight: what the library takes, and the rounding of floats. */
#define SINE_MIN 2e-6

static void take(const option_vector *given, float out[3])
{
    for (int axis = 0; axis < 3 && given->is_given; ++axis) {
        out[axis] = (float)given->at[axis];
    }
}

static double length(const double a[3])
{
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void widen(const float in[3], double out[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = (double)in[axis];
    }
}

/* False for a vector without a direction. */
static bool normalize(double vector[3])
{
    const double whole = length(vector);
    for (int axis = 0; axis < 3 && whole > 0; ++axis) {
        vector[axis] /= whole;
    }
    return whole > 0;
}

/* Turns a vector about a unit one: O. Rodrigues' formula. */
static void rotate(const double about[3], double sine, double cosine, const double vector[3], double out[3])
{
    double across[3];
    cross(about, vector, across);
    const double along = dot(about, vector);
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = cosine * vector[axis] + sine * across[axis] + (1 - cosine) * along * about[axis];
    }
}

static int check(program *state, const svo_camera *camera)
{
    double sight[3];
    double up[3];
    double across[3];
    for (int axis = 0; axis < 3; ++axis) {
        sight[axis] = (double)camera->target[axis] - (double)camera->eye[axis];
    }
    widen(camera->up, up);
    cross(sight, up, across);
    if (!(length(sight) > 0)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--%s %g,%g,%g is where the camera %s",
                            state->options.eye.is_given ? "eye" : "at", (double)camera->eye[0], (double)camera->eye[1],
                            (double)camera->eye[2], state->options.eye.is_given ? "looks at" : "stands");
    }
    if (!(length(up) > 0) || !(length(across) > SINE_MIN * length(sight) * length(up))) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "--up %g,%g,%g is along the line of sight from %g,%g,%g to %g,%g,%g, or zero",
                            (double)camera->up[0], (double)camera->up[1], (double)camera->up[2], (double)camera->eye[0],
                            (double)camera->eye[1], (double)camera->eye[2], (double)camera->target[0],
                            (double)camera->target[1], (double)camera->target[2]);
    }
    return PROGRAM_DONE;
}

/* ---- directions ---- */

/* The side that --from names, where y is up and the front faces z, turned to the camera's up by the least rotation, as
   svo_camera_fit turns its own. */
static void face_side(const program *state, svo_camera *camera)
{
    /* From above and below the eye is a little in front, so that up stays what the light takes it for; in the picture
       it then points away from the front, and towards it. */
    static const double sides[][3] = {{0, 0, 1},     {-1, 0, 0},     {1, 0, 0}, {0, 0, -1},
                                      {0, 1, 0.001}, {0, -1, 0.001}, {1, 1, 1}};
    static const double y[3] = {0, 1, 0};
    double up[3];
    double about[3];
    double side[3];
    widen(camera->up, up);
    if (!normalize(up)) {
        return; /* check() says so */
    }
    cross(y, up, about);
    const double sine = length(about);
    if (!normalize(about)) {
        about[2] = 1;
    }
    rotate(about, sine, up[1], sides[state->options.from_side - 1], side);
    for (int axis = 0; axis < 3; ++axis) {
        camera->eye[axis] = (float)side[axis];
        camera->target[axis] = 0;
    }
}

/* ---- framing ---- */

static void fit(const viewpoint_subject *of, svo_camera *camera)
{
    (void)svo_camera_fit(of->target, of->aspect, camera);
}

/* The least distance from a target from which all is in view that a fitted camera sees, in the same direction: its
   pyramid lies inside the other's if its eye does. */
static double distance_for(const svo_camera *fitted, const double target[3], float aspect)
{
    const double tangent = tan(0.5 * (double)fitted->vertical_fov);
    double eye[3];
    double away[3];
    double up[3];
    double right[3];
    widen(fitted->eye, eye);
    widen(fitted->target, away);
    widen(fitted->up, up);
    for (int axis = 0; axis < 3; ++axis) {
        away[axis] = eye[axis] - away[axis];
        eye[axis] -= target[axis];
    }
    (void)normalize(away);
    cross(up, away, right);
    (void)normalize(right);
    cross(away, right, up);
    return dot(eye, away) + fmax(fabs(dot(eye, right)) / (tangent * (double)aspect), fabs(dot(eye, up)) / tangent);
}

/* Moves a framed camera to where it sees all of its subject on its way round it. */
static void fit_turn(const viewpoint_subject *of, unsigned frame_count, svo_camera *camera)
{
    double target[3] = {0, 0, 0};
    double away[3];
    double distance = 0;
    svo_camera turned;
    for (unsigned frame = 0; frame < frame_count; ++frame) {
        viewpoint_turn(camera, frame, frame_count, &turned);
        fit(of, &turned);
        for (int axis = 0; axis < 3; ++axis) {
            target[axis] += (double)turned.target[axis] / frame_count;
        }
    }
    for (unsigned frame = 0; frame < frame_count; ++frame) {
        viewpoint_turn(camera, frame, frame_count, &turned);
        fit(of, &turned);
        distance = fmax(distance, distance_for(&turned, target, of->aspect));
    }
    for (int axis = 0; axis < 3; ++axis) {
        away[axis] = (double)camera->eye[axis] - (double)camera->target[axis];
    }
    (void)normalize(away);
    for (int axis = 0; axis < 3; ++axis) {
        camera->target[axis] = (float)target[axis];
        camera->eye[axis] = (float)(target[axis] + distance * away[axis]);
    }
}

/* As the options of the camera want it; where it cannot stand, check() says why. */
static void frame(const program *state, const viewpoint_subject *of, svo_camera *camera)
{
    const options *given = &state->options;
    *camera = (svo_camera){.up = {0, 1, 0}, .vertical_fov = (float)(given->fov * DEGREE)};
    take(&given->up, camera->up);
    if (given->from_side > 0) {
        face_side(state, camera);
    }
    fit(of, camera);
    take(&given->up, camera->up); /* also one of zeros, which counts as none there */
    if (given->eye.is_given && !(given->fov > 0)) {
        camera->vertical_fov = (float)(STANDING_FOV * DEGREE);
    }
}

int viewpoint_place(program *state, const viewpoint_subject *of, svo_camera *camera)
{
    const options *given = &state->options;
    const bool stands = given->eye.is_given || given->look_at.is_given;
    const bool framed = of->camera == NULL || given->from_side > 0;
    if (given->from_side > 0 && stands) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--from frames all of INPUT, which --%s does not",
                            given->eye.is_given ? "eye" : "at");
    }
    if (framed) {
        frame(state, of, camera);
    } else {
        *camera = *of->camera;
        take(&given->up, camera->up);
        camera->vertical_fov = given->fov > 0 ? (float)(given->fov * DEGREE) : camera->vertical_fov;
    }
    take(&given->eye, camera->eye);
    take(&given->look_at, camera->target);
    const int exit_code = check(state, camera);
    if (exit_code == PROGRAM_DONE && framed && !stands && given->turntable > 1) {
        fit_turn(of, (unsigned)given->turntable, camera);
    }
    return exit_code;
}

float viewpoint_aspect(const program *state)
{
    return (float)state->options.width / (float)state->options.height;
}

static uint32_t shrink(uint32_t side, uint32_t from, uint32_t to)
{
    const uint32_t shrunk = (uint32_t)(((uint64_t)side * to + from / 2) / from);
    return shrunk > 0 ? shrunk : 1;
}

void viewpoint_shrink(uint32_t longer, uint32_t *width, uint32_t *height)
{
    const uint32_t from = *width > *height ? *width : *height;
    *width = shrink(*width, from, longer);
    *height = shrink(*height, from, longer);
}

void viewpoint_turn(const svo_camera *start, unsigned frame, unsigned frame_count, svo_camera *out)
{
    const double angle = 360 * DEGREE * frame / frame_count;
    double up[3];
    double away[3]; /* from the target to the eye */
    double turned[3];
    *out = *start;
    widen(start->up, up);
    for (int axis = 0; axis < 3; ++axis) {
        away[axis] = (double)start->eye[axis] - (double)start->target[axis];
    }
    if (frame == 0 || !normalize(up)) {
        return;
    }
    rotate(up, sin(angle), cos(angle), away, turned);
    for (int axis = 0; axis < 3; ++axis) {
        out->eye[axis] = (float)((double)start->target[axis] + turned[axis]);
    }
}
