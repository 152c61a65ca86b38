/* SPDX-License-Identifier: MIT */
/* Their size follows the grid: neighbors never touch. */
#include "view/probe_spheres.h"

#include <math.h>

#include "view/camera.h"

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
