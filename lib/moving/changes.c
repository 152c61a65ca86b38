/* SPDX-License-Identifier: MIT */
/* svo_moving_get_changes. Bounds are kept with the objects, so that noting them cannot fail. */
#include "moving/changes.h"

#include <math.h>

#include "core/device.h"
#include "plan/device_grid.h"
#include "plan/update.h"

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

/* Whether the mesh of what is shown is open; false without projected areas, which do not ask then. */
static bool is_open(const svo_moving *moving)
{
    svo_i_edge_sums sums = {{0}};
    for (uint32_t i = 0; svo_i_moving_has_areas(moving) && i < moving->object_count; ++i) {
        const svo_i_moving_object *object = &moving->objects[i];
        for (unsigned word = 0; word < 2 && svo_i_moving_shows(object); ++word) {
            sums.words[word] += object->plan->update->edge_sums.words[word];
        }
    }
    return svo_i_edges_are_open(&sums);
}

void svo_i_moving_note_changes(svo_moving *moving)
{
    const bool was_open = moving->is_open;
    moving->is_open = is_open(moving);
    moving->areas_changed = moving->is_open != was_open;
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
    moving->areas_changed = false;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        moving->objects[i].change_count = 0;
    }
}

/* The grid, and what has changed beside it. */
static svo_box bound_all(const svo_moving *moving)
{
    svo_box box;
    for (int axis = 0; axis < 3; ++axis) {
        box.low[axis] = moving->options.origin[axis];
        box.high[axis] = moving->options.origin[axis] + moving->options.edge;
    }
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        for (uint32_t k = 0; k < moving->objects[i].change_count; ++k) {
            add_vertex(&box, moving->objects[i].changes[k].low);
            add_vertex(&box, moving->objects[i].changes[k].high);
        }
    }
    return box;
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
    if (moving->areas_changed) {
        *count = 1;
        if (capacity > 0) {
            boxes[0] = bound_all(moving);
        }
        return SVO_OK;
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
