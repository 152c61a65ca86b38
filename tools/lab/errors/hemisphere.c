/* SPDX-License-Identifier: MIT */
/* A cosine-weighted direction is a point of the unit disk, lifted onto the hemisphere. */
#include "errors/hemisphere.h"

#define PI 3.14159265358979323846

turned_frame frame_around(vector3 normal)
{
    const double x = fabs(normal.x);
    const double y = fabs(normal.y);
    const double z = fabs(normal.z);
    const vector3 axis = x <= y && x <= z ? vector(1, 0, 0) : y <= z ? vector(0, 1, 0) : vector(0, 0, 1);
    turned_frame frame = {.normal = normal};
    frame.side = vector_normalize(vector_cross(normal, axis));
    frame.other = vector_cross(normal, frame.side);
    return frame;
}

vector3 frame_direction(const turned_frame *frame, double sine, double turns)
{
    const double along = sine * cos(2 * PI * turns);
    const double across = sine * sin(2 * PI * turns);
    return vector_add(vector_scale(frame->normal, sqrt(1 - sine * sine)),
                      vector_add(vector_scale(frame->side, along), vector_scale(frame->other, across)));
}

turned_frame hemisphere_frame(const svo_gather_point *point)
{
    return frame_around(vector((double)point->normal[0], (double)point->normal[1], (double)point->normal[2]));
}

svo_ray hemisphere_ray(const hemisphere_set *set, const svo_gather_point *point, vector3 direction)
{
    svo_ray ray = {.t_min = 0, .t_max = (float)set->length};
    for (int axis = 0; axis < 3; ++axis) {
        ray.origin[axis] = (float)((double)point->position[axis] + set->lift * (double)point->normal[axis]);
    }
    ray.direction[0] = (float)direction.x;
    ray.direction[1] = (float)direction.y;
    ray.direction[2] = (float)direction.z;
    return ray;
}

void hemisphere_rays(const hemisphere_set *set, const svo_gather_point *points, size_t point_count, svo_ray *rays)
{
    random_stream stream = {.state = set->seed};
    const unsigned per_point = set->strata * set->strata;
    for (size_t i = 0; i < point_count * per_point; ++i) {
        const svo_gather_point *point = &points[i / per_point];
        const unsigned stratum = (unsigned)(i % per_point);
        const turned_frame frame = hemisphere_frame(point);
        const double squared =
            (stratum / set->strata + random_between(&stream, 0, 1)) / set->strata; /* NOLINT: a row */
        const double turns = (stratum % set->strata + random_between(&stream, 0, 1)) / set->strata;
        rays[i] = hemisphere_ray(set, point, frame_direction(&frame, sqrt(squared), turns));
    }
}
