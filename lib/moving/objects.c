/* SPDX-License-Identifier: MIT */
/* Adding, moving, hiding and removing objects. The scene's list and tree follow with the next update. */
#include "moving/objects.h"

#include <string.h>

#include "core/struct_size.h"
#include "moving/mesh.h"
#include "plan/update.h"

static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/* ---- making ---- */

/* Reads a caller's mesh; it must have the vertices' arrays that another has. */
static svo_status read_mesh(const svo_moving *moving, const char *function, const svo_mesh *given, svo_mesh *mesh)
{
    svo_device *device = moving->device;
    if (given == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: mesh is NULL", function);
    }
    return svo_i_struct_read(&device->message, function, "mesh", given, mesh,
                             SVO_I_STRUCT_SIZES(svo_mesh, texture_count));
}

static svo_status check_array(svo_device *device, const char *function, const char *name, const void *has,
                              const void *expected, const char *of)
{
    return (has != NULL) == (expected != NULL)
               ? SVO_OK
               : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: mesh.%s is %s, and that of %s is %s", function,
                                   name, has != NULL ? "given" : "NULL", of, expected != NULL ? "given" : "NULL");
}

static svo_status check_vertex_arrays(const svo_moving *moving, const char *function, const svo_mesh *mesh,
                                      const svo_mesh *like, const char *of)
{
    svo_device *device = moving->device;
    SVO_I_TRY(check_array(device, function, "positions", mesh->positions, like->positions, of));
    SVO_I_TRY(check_array(device, function, "positions_double", mesh->positions_double, like->positions_double, of));
    return check_array(device, function, "normals", mesh->normals, like->normals, of);
}

static svo_status check_arrays(const svo_moving *moving, const char *function, const svo_mesh *mesh)
{
    static const char of[] = "the static mesh";
    const svo_mesh *like = &moving->objects[0].mesh;
    SVO_I_TRY(check_vertex_arrays(moving, function, mesh, like, of));
    SVO_I_TRY(check_array(moving->device, function, "colors", mesh->colors, like->colors, of));
    return check_array(moving->device, function, "uvs", mesh->uvs, like->uvs, of);
}

void svo_i_moving_release_object(svo_i_moving_object *object)
{
    svo_plan_destroy(&object->plan);
    svo_i_moving_free_mesh(object);
    object->visible = false;
}

static svo_status make_plan(svo_moving *moving, const char *function, svo_i_moving_object *object)
{
    const svo_status status =
        svo_plan_create(moving->device, &object->mesh, moving->depth, &moving->options, &object->plan);
    if (status != SVO_OK) {
        svo_i_message_rename(&moving->device->message, function);
        return status;
    }
    object->plan->update->sums_edges = object->plan->update->edges != NULL;
    return SVO_OK;
}

svo_status svo_i_moving_make_object(svo_moving *moving, const char *function, uint32_t index, const svo_mesh *mesh,
                                    const double transform[12])
{
    svo_status status = SVO_OK;
    svo_i_moving_object made = {.visible = true, .stale = true, .listed = moving->objects[index].listed};
    made.fragments = moving->objects[index].fragments;
    made.part = moving->objects[index].part;
    made.identity = ++moving->serial;
    made.box = moving->objects[index].box;
    memcpy(made.transform, transform != NULL ? transform : identity, sizeof made.transform);
    SVO_I_TRY_CLEANUP(svo_i_moving_copy_mesh(moving->device, function, mesh, &made));
    if (transform != NULL) {
        svo_i_moving_place(&made);
    }
    SVO_I_TRY_CLEANUP(make_plan(moving, function, &made));
    moving->objects[index] = made;
    return SVO_OK;
cleanup:
    svo_i_moving_release_object(&made);
    return status;
}

/* ---- the caller's objects ---- */

svo_status svo_i_moving_check_still(const svo_moving *moving, const char *function)
{
    return moving->flight == NULL
               ? SVO_OK
               : svo_i_device_fail(moving->device, SVO_INVALID_ARGUMENT,
                                   "%s: an update is in flight; call svo_moving_finish first", function);
}

/* The object of that number; NULL, with a message, where there is none, no handle, or an update in flight. */
static svo_i_moving_object *find(svo_moving *moving, const char *function, uint32_t number)
{
    if (moving == NULL || svo_i_moving_check_still(moving, function) != SVO_OK) {
        return NULL;
    }
    if (number >= SVO_MOVING_OBJECTS_MAX || number + 1 >= moving->object_count ||
        moving->objects[number + 1].plan == NULL) {
        (void)svo_i_device_fail(moving->device, SVO_INVALID_ARGUMENT, "%s: there is no object %u", function, number);
        return NULL;
    }
    return &moving->objects[number + 1];
}

/* The least free index, for which there is room. */
static svo_status find_free(svo_moving *moving, const char *function, uint32_t *out)
{
    uint32_t index = 1;
    while (index < moving->object_count && moving->objects[index].plan != NULL) {
        ++index;
    }
    if (index == SVO_I_MOVING_OBJECTS) {
        return svo_i_device_fail(moving->device, SVO_CAPACITY_EXCEEDED, "%s: there are %d objects, the most of a scene",
                                 function, SVO_MOVING_OBJECTS_MAX);
    }
    if (index == moving->object_capacity) {
        const uint32_t capacity = moving->object_capacity * 2;
        svo_i_moving_object *grown =
            svo_i_grow(&moving->device->memory, moving->objects, capacity * sizeof *moving->objects);
        if (grown == NULL) {
            return svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u objects", function,
                                     capacity);
        }
        moving->objects = grown;
        moving->object_capacity = capacity;
    }
    if (index == moving->object_count) {
        moving->objects[index] = (svo_i_moving_object){.plan = NULL};
    }
    *out = index;
    return SVO_OK;
}

svo_status svo_moving_add(svo_moving *moving, const svo_mesh *mesh, const double transform[12], uint32_t *object)
{
    static const char function[] = "svo_moving_add";
    svo_mesh copy = {.struct_size = 0};
    uint32_t index = 0;
    if (moving == NULL || object == NULL) {
        return svo_i_device_fail(moving != NULL ? moving->device : NULL, SVO_INVALID_ARGUMENT, "%s: %s is NULL",
                                 function, moving == NULL ? "moving" : "object");
    }
    SVO_I_TRY(svo_i_moving_check_still(moving, function));
    SVO_I_TRY(read_mesh(moving, function, mesh, &copy));
    SVO_I_TRY(check_arrays(moving, function, &copy));
    SVO_I_TRY(find_free(moving, function, &index));
    SVO_I_TRY(transform != NULL ? svo_i_moving_check_transform(moving->device, function, index - 1, transform)
                                : SVO_OK);
    const svo_mesh *first = &moving->objects[0].mesh;
    copy.materials = first->materials;
    copy.material_count = first->material_count;
    copy.textures = first->textures;
    copy.texture_count = first->texture_count;
    copy.finishes = NULL;
    SVO_I_TRY(svo_i_moving_make_object(moving, function, index, &copy, transform));
    svo_i_free(moving->objects[index].plan->texels); /* the scene has them once */
    moving->objects[index].plan->texels = NULL;
    svo_i_moving_forget_mesh(moving);
    moving->object_count = index == moving->object_count ? index + 1 : moving->object_count;
    *object = index - 1;
    return SVO_OK;
}

/* The vertices of an object have changed. */
static void place(svo_moving *moving, svo_i_moving_object *object)
{
    svo_i_moving_place(object);
    object->moved = true;
    object->stale = true;
    svo_i_moving_forget_mesh(moving);
}

svo_status svo_moving_set_transform(svo_moving *moving, uint32_t object, const double transform[12])
{
    static const char function[] = "svo_moving_set_transform";
    svo_i_moving_object *found = find(moving, function, object);
    if (found == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (transform == NULL) {
        return svo_i_device_fail(moving->device, SVO_INVALID_ARGUMENT, "%s: transform of object %u is NULL", function,
                                 object);
    }
    SVO_I_TRY(svo_i_moving_check_transform(moving->device, function, object, transform));
    memcpy(found->transform, transform, sizeof found->transform);
    place(moving, found);
    return SVO_OK;
}

svo_status svo_moving_set_vertices(svo_moving *moving, uint32_t object, const svo_mesh *mesh)
{
    static const char function[] = "svo_moving_set_vertices";
    svo_i_moving_object *found = find(moving, function, object);
    svo_mesh copy = {.struct_size = 0};
    if (found == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(read_mesh(moving, function, mesh, &copy));
    if (copy.vertex_count != found->mesh.vertex_count || copy.triangle_count != found->mesh.triangle_count) {
        return svo_i_device_fail(moving->device, SVO_INVALID_ARGUMENT,
                                 "%s: mesh has %zu vertices and %zu triangles, object %u has %zu and %zu", function,
                                 copy.vertex_count, copy.triangle_count, object, found->mesh.vertex_count,
                                 found->mesh.triangle_count);
    }
    SVO_I_TRY(check_vertex_arrays(moving, function, &copy, &found->mesh, "the object"));
    svo_i_moving_copy_vertices(&copy, found);
    place(moving, found);
    return SVO_OK;
}

svo_status svo_moving_show(svo_moving *moving, uint32_t object, int visible)
{
    svo_i_moving_object *found = find(moving, "svo_moving_show", object);
    if (found == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (found->visible != (visible != 0)) {
        found->visible = visible != 0;
        found->stale = true;
        svo_i_moving_forget_mesh(moving);
    }
    return SVO_OK;
}

svo_status svo_moving_remove(svo_moving *moving, uint32_t object)
{
    svo_i_moving_object *found = find(moving, "svo_moving_remove", object);
    if (found == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    svo_i_moving_release_object(found);
    svo_i_moving_forget_mesh(moving);
    return SVO_OK;
}

#define SIZES_OF_OBJECT SVO_I_STRUCT_SIZES(svo_moving_object, visible)

svo_status svo_moving_get_object(const svo_moving *moving, uint32_t object, svo_moving_object *info)
{
    static const char function[] = "svo_moving_get_object";
    if (moving == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (object >= SVO_MOVING_OBJECTS_MAX || object + 1 >= moving->object_count ||
        moving->objects[object + 1].plan == NULL) {
        return svo_i_device_fail(moving->device, SVO_INVALID_ARGUMENT, "%s: there is no object %u", function, object);
    }
    const svo_i_moving_object *found = &moving->objects[object + 1];
    svo_moving_object made = {.triangles = found->plan->info.triangles,
                              .refused_triangles = found->plan->info.refused_triangles,
                              .outside_triangles = found->plan->info.outside_triangles,
                              .fragments = found->fragments,
                              .visible = found->visible ? 1 : 0};
    for (uint32_t i = 0; i <= object; ++i) {
        const svo_i_moving_object *before = &moving->objects[i];
        made.first_triangle += svo_i_moving_shows(before) ? (uint32_t)before->mesh.triangle_count : 0;
    }
    return svo_i_struct_write(&moving->device->message, function, "info", &made, info, SIZES_OF_OBJECT);
}
