/* SPDX-License-Identifier: MIT */
/* svo_moving_get_changes. Bounds are kept with the objects, so that noting them cannot fail. */
#include "moving/changes.h"

#include <math.h>

#include "core/device.h"

/* Adds a vertex to bounds; those that are not finite are corners of refused triangles alone. */
static void add_vertex(svo_box *box, const double vertex[3])
{
    if (!isfinite(vertex[0]) || !isfinite(vertex[1]) || !isfinite(vertex[2])) {
        return;
    }
    for (int axis = 0; axis < 3; ++axis) {
        box->low[axis] = vertex[axis] < box->low[axis] ? vertex[axis] : box->low[axis];
        box->high[axis] = vertex[axis] > box->high[axis] ? vertex[axis] : box->high[axis];
    }
}

static svo_box find_bounds(const svo_mesh *mesh)
{
    svo_box box = {.low = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, .high = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        double vertex[3];
        for (size_t axis = 0; axis < 3; ++axis) {
            vertex[axis] =
                mesh->positions != NULL ? (double)mesh->positions[3 * i + axis] : mesh->positions_double[3 * i + axis];
        }
        add_vertex(&box, vertex);
    }
    return box;
}

static void note(svo_i_moving_object *object)
{
    if (object->box.low[0] <= object->box.high[0]) {
        object->changes[object->change_count++] = object->box;
    }
}

void svo_i_moving_note_changes(svo_moving *moving)
{
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        svo_i_moving_object *object = &moving->objects[i];
        object->change_count = 0;
        if (svo_i_moving_stays(object)) {
            continue;
        }
        if (object->listed) {
            note(object);
        }
        if (svo_i_moving_shows(object)) {
            object->box = find_bounds(&object->mesh);
            note(object);
        }
    }
}

void svo_i_moving_forget_changes(svo_moving *moving)
{
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        moving->objects[i].change_count = 0;
    }
}

svo_status svo_moving_get_changes(const svo_moving *moving, svo_box *boxes, size_t capacity, size_t *count)
{
    if (moving == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (count == NULL || (boxes == NULL && capacity > 0)) {
        return svo_i_device_fail(moving->device, SVO_INVALID_ARGUMENT, "svo_moving_get_changes: %s is NULL",
                                 count == NULL ? "count" : "boxes");
    }
    size_t found = 0;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        const svo_i_moving_object *object = &moving->objects[i];
        for (uint32_t k = 0; k < object->change_count; ++k) {
            if (found < capacity) {
                boxes[found] = object->changes[k];
            }
            ++found;
        }
    }
    *count = found;
    return SVO_OK;
}
