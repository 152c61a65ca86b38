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

static int check(program *state, const svo_camera *camera)
{
    double sight[3];
    double up[3];
    for (int axis = 0; axis < 3; ++axis) {
        sight[axis] = (double)camera->target[axis] - (double)camera->eye[axis];
        up[axis] = (double)camera->up[axis];
    }
    const double across[3] = {sight[1] * up[2] - sight[2] * up[1], sight[2] * up[0] - sight[0] * up[2],
                              sight[0] * up[1] - sight[1] * up[0]};
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

int viewpoint_apply(program *state, bool frames, svo_camera *camera)
{
    const options *given = &state->options;
    const double standing = frames && given->eye.is_given ? STANDING_FOV : 0;
    const double degrees = given->fov > 0 ? given->fov : standing;
    take(&given->eye, camera->eye);
    take(&given->look_at, camera->target);
    take(&given->up, camera->up);
    camera->vertical_fov = degrees > 0 ? (float)(degrees * DEGREE) : camera->vertical_fov;
    return check(state, camera);
}

void viewpoint_turn(const svo_camera *start, unsigned frame, unsigned frame_count, svo_camera *out)
{
    double up[3];
    double away[3]; /* from the target to the eye */
    double along = 0;
    *out = *start;
    for (int axis = 0; axis < 3; ++axis) {
        up[axis] = (double)start->up[axis];
        away[axis] = (double)start->eye[axis] - (double)start->target[axis];
    }
    const double unit = length(up);
    for (int axis = 0; axis < 3; ++axis) {
        up[axis] /= unit;
        along += up[axis] * away[axis];
    }
    /* O. Rodrigues' formula. */
    const double angle = 360 * DEGREE * frame / frame_count;
    const double across[3] = {up[1] * away[2] - up[2] * away[1], up[2] * away[0] - up[0] * away[2],
                              up[0] * away[1] - up[1] * away[0]};
    for (int axis = 0; axis < 3 && frame > 0; ++axis) {
        out->eye[axis] = (float)((double)start->target[axis] + cos(angle) * away[axis] + sin(angle) * across[axis] +
                                 (1 - cos(angle)) * along * up[axis]);
    }
}
