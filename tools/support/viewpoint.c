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

/* As the options of the camera want it; where it cannot stand, check() says why. */
static void frame(const program *state, const viewpoint_subject *of, svo_camera *camera)
{
    const options *given = &state->options;
    *camera = (svo_camera){.up = {0, 1, 0}, .vertical_fov = (float)(given->fov * DEGREE)};
    take(&given->up, camera->up);
    if (of->scene != NULL) {
        (void)svo_scene_camera_fit(of->scene, of->aspect, camera);
    } else {
        (void)svo_camera_fit(of->tree, of->aspect, camera);
    }
    take(&given->up, camera->up); /* also one of zeros, which counts as none there */
    if (given->eye.is_given && !(given->fov > 0)) {
        camera->vertical_fov = (float)(STANDING_FOV * DEGREE);
    }
}

int viewpoint_place(program *state, const viewpoint_subject *of, svo_camera *camera)
{
    const options *given = &state->options;
    if (of->camera != NULL) {
        *camera = *of->camera;
        take(&given->up, camera->up);
        camera->vertical_fov = given->fov > 0 ? (float)(given->fov * DEGREE) : camera->vertical_fov;
    } else {
        frame(state, of, camera);
    }
    take(&given->eye, camera->eye);
    take(&given->look_at, camera->target);
    return check(state, camera);
}

float viewpoint_aspect(const program *state)
{
    return (float)state->options.width / (float)state->options.height;
}
