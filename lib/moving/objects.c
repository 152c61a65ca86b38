/* SPDX-License-Identifier: MIT */
/*
 * Adding, moving, hiding and removing objects: copies of their meshes, transforms in double, and bounds of what
 * changes, which are kept with the objects, so that noting them cannot fail. The scene's list and tree follow with the
 * next update.
 */
#include "moving/objects.h"

#include <math.h>
#include <string.h>

#include "core/struct_size.h"
#include "plan/update.h"

static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/* ---- transforms ---- */

/* The matrix of cofactors of the linear part, which turns normals: rows. */
static void cofactors(const double m[12], double out[9])
{
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            const int i1 = (i + 1) % 3;
            const int i2 = (i + 2) % 3;
            const int k1 = (k + 1) % 3;
            const int k2 = (k + 2) % 3;
            out[3 * i + k] = m[4 * i1 + k1] * m[4 * i2 + k2] - m[4 * i1 + k2] * m[4 * i2 + k1];
        }
    }
}

/* Refuses a transform that is not finite or is flat. object: its number, for the message. */
static svo_status check_transform(svo_device *device, const char *function, uint32_t object, const double transform[12])
{
    double normals[9];
    double size = SVO_MOVING_DETERMINANT_MIN;
    for (int i = 0; i < 12; ++i) {
        if (!isfinite(transform[i])) {
            return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: the transform of object %u is not finite",
                                     function, object);
        }
    }
    for (int k = 0; k < 3; ++k) {
        size *= sqrt(transform[k] * transform[k] + transform[4 + k] * transform[4 + k] +
                     transform[8 + k] * transform[8 + k]);
    }
    cofactors(transform, normals);
    const double determinant = transform[0] * normals[0] + transform[1] * normals[1] + transform[2] * normals[2];
    return fabs(determinant) > size
               ? SVO_OK
               : svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                   "%s: the transform of object %u is flat: determinant %g, its size is not above %g",
                                   function, object, determinant, size);
}

static double row_of(const double m[4], const double p[3])
{
    return ((m[0] * p[0] + m[1] * p[1]) + m[2] * p[2]) + m[3];
}

static void place_vertex(svo_i_moving_object *object, size_t vertex)
{
    double p[3];
    for (size_t k = 0; k < 3; ++k) {
        const size_t at = vertex * 3 + k;
        p[k] = object->given.floats != NULL ? (double)object->given.floats[at] : object->given.doubles[at];
    }
    for (size_t k = 0; k < 3; ++k) {
        const double moved = row_of(object->transform + 4 * k, p);
        if (object->world.floats != NULL) {
            object->world.floats[vertex * 3 + k] = (float)moved;
        } else {
            object->world.doubles[vertex * 3 + k] = moved;
        }
    }
}

static void turn_normal(const svo_i_moving_object *object, const double turn[9], size_t vertex)
{
    const float *n = object->given.normals + vertex * 3;
    for (size_t k = 0; k < 3; ++k) {
        const double *row = turn + 3 * k;
        object->world.normals[vertex * 3 + k] =
            (float)((row[0] * (double)n[0] + row[1] * (double)n[1]) + row[2] * (double)n[2]);
    }
}

/* Makes the object's vertices in the world. */
static void place_in_world(svo_i_moving_object *object)
{
    double turn[9];
    cofactors(object->transform, turn);
    for (size_t vertex = 0; vertex < object->mesh.vertex_count; ++vertex) {
        place_vertex(object, vertex);
        if (object->given.normals != NULL) {
            turn_normal(object, turn, vertex);
        }
    }
}

/* ---- copies ---- */

/* A new array with a copy_array of another; NULL for NULL. *fits becomes false when out of memory. */
static void *copy_array(const svo_device *device, const void *from, size_t count, size_t bytes, bool *fits)
{
    size_t all = 0;
    void *made = NULL;
    if (from == NULL) {
        return NULL;
    }
    if (svo_i_mul_size(count, bytes, &all)) {
        made = svo_i_alloc(&device->memory, all);
    }
    if (made != NULL) {
        memcpy(made, from, all);
    }
    *fits = *fits && made != NULL;
    return made;
}

static svo_i_vertices copy_vertices(const svo_device *device, const svo_mesh *mesh, bool *fits)
{
    const size_t vertices = mesh->vertex_count;
    return (svo_i_vertices){.floats = copy_array(device, mesh->positions, vertices, 12, fits),
                            .doubles = copy_array(device, mesh->positions_double, vertices, 24, fits),
                            .normals = copy_array(device, mesh->normals, vertices, 12, fits)};
}

/* Copies a mesh to an object, whose arrays are NULL. After a failure free_mesh releases what there is. */
static svo_status copy_mesh(svo_device *device, const char *function, const svo_mesh *mesh, svo_i_moving_object *object)
{
    bool fits = true;
    const size_t vertices = mesh->vertex_count;
    const size_t triangles = mesh->triangle_count;
    object->given = copy_vertices(device, mesh, &fits);
    object->world = copy_vertices(device, mesh, &fits);
    object->mesh = *mesh;
    object->mesh.struct_size = sizeof object->mesh;
    object->mesh.positions = object->world.floats;
    object->mesh.positions_double = object->world.doubles;
    object->mesh.normals = object->world.normals;
    object->mesh.indices = copy_array(device, mesh->indices, triangles, 12, &fits);
    object->mesh.colors = copy_array(device, mesh->colors, vertices, 4, &fits);
    object->mesh.uvs = copy_array(device, mesh->uvs, vertices, 8, &fits);
    object->mesh.triangle_materials = copy_array(device, mesh->triangle_materials, triangles, 2, &fits);
    return fits ? SVO_OK
                : svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu vertices and %zu triangles",
                                    function, vertices, triangles);
}

/* Copies vertices of the same counts and kinds. */
static void replace_vertices(const svo_mesh *mesh, svo_i_moving_object *object)
{
    const size_t vertices = object->mesh.vertex_count;
    if (object->given.floats != NULL) {
        memcpy(object->given.floats, mesh->positions, vertices * 12);
    } else {
        memcpy(object->given.doubles, mesh->positions_double, vertices * 24);
    }
    if (object->given.normals != NULL) {
        memcpy(object->given.normals, mesh->normals, vertices * 12);
    }
}

static void free_array(const void *array)
{
    void *block = NULL;
    memcpy(&block, &array, sizeof block); /* meshes have pointers to const */
    svo_i_free(block);
}

/* Releases the arrays of a mesh that owns them. */
static void free_arrays(svo_mesh *mesh)
{
    const void *arrays[] = {mesh->positions, mesh->positions_double,  mesh->normals, mesh->indices, mesh->colors,
                            mesh->uvs,       mesh->triangle_materials};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; ++i) {
        free_array(arrays[i]);
    }
    *mesh = (svo_mesh){.vertex_count = 0};
}

static void free_mesh(svo_i_moving_object *object)
{
    svo_i_free(object->given.floats);
    svo_i_free(object->given.doubles);
    svo_i_free(object->given.normals);
    free_arrays(&object->mesh);
    object->given = (svo_i_vertices){.floats = NULL};
    object->world = (svo_i_vertices){.floats = NULL};
}

void svo_i_moving_forget_mesh(svo_moving *moving)
{
    free_arrays(&moving->mesh);
}

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
    free_mesh(object);
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
    SVO_I_TRY_CLEANUP(copy_mesh(moving->device, function, mesh, &made));
    if (transform != NULL) {
        place_in_world(&made);
    }
    SVO_I_TRY_CLEANUP(make_plan(moving, function, &made));
    moving->objects[index] = made;
    return SVO_OK;
cleanup:
    svo_i_moving_release_object(&made);
    return status;
}

/* ---- the caller's objects ---- */

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
    SVO_I_TRY(transform != NULL ? check_transform(moving->device, function, index - 1, transform) : SVO_OK);
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
static void place_anew(svo_moving *moving, svo_i_moving_object *object)
{
    place_in_world(object);
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
    SVO_I_TRY(check_transform(moving->device, function, object, transform));
    memcpy(found->transform, transform, sizeof found->transform);
    place_anew(moving, found);
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
    replace_vertices(&copy, found);
    place_anew(moving, found);
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

/* ---- changes ---- */

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

/* Whether the scene's mesh is open, for projected areas. */
static bool is_open(const svo_moving *moving)
{
    svo_i_edge_sums sums = {{0}};
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        const svo_i_moving_object *object = &moving->objects[i];
        for (unsigned word = 0; word < 2 && svo_i_moving_shows(object); ++word) {
            sums.words[word] += object->plan->update->edge_sums.words[word];
        }
    }
    return svo_i_edges_are_open(&sums);
}

/* A mesh that opens or closes changes the areas of all leaves. The static mesh has no other changes then. */
static void note_opening(svo_moving *moving)
{
    const bool was_open = moving->is_open;
    svo_i_moving_object *fixed = &moving->objects[0];
    moving->is_open = is_open(moving);
    if (moving->tree != NULL && moving->is_open != was_open) {
        for (int axis = 0; axis < 3; ++axis) {
            fixed->changes[0].low[axis] = moving->options.origin[axis];
            fixed->changes[0].high[axis] = moving->options.origin[axis] + moving->options.edge;
        }
        fixed->change_count = 1;
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
    note_opening(moving);
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
