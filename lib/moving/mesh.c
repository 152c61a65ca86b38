/* SPDX-License-Identifier: MIT */
/* Meshes of objects: copies, transforms in double, and the scene's mesh. */
#include "moving/mesh.h"

#include <math.h>
#include <string.h>

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

svo_status svo_i_moving_check_transform(svo_device *device, const char *function, uint32_t object,
                                        const double transform[12])
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

void svo_i_moving_place(svo_i_moving_object *object)
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

/* A new array with a copy of another; NULL for NULL. *fits becomes false when out of memory. */
static void *copy(const svo_device *device, const void *from, size_t count, size_t bytes, bool *fits)
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
    return (svo_i_vertices){.floats = copy(device, mesh->positions, vertices, 12, fits),
                            .doubles = copy(device, mesh->positions_double, vertices, 24, fits),
                            .normals = copy(device, mesh->normals, vertices, 12, fits)};
}

svo_status svo_i_moving_copy_mesh(svo_device *device, const char *function, const svo_mesh *mesh,
                                  svo_i_moving_object *object)
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
    object->mesh.indices = copy(device, mesh->indices, triangles, 12, &fits);
    object->mesh.colors = copy(device, mesh->colors, vertices, 4, &fits);
    object->mesh.uvs = copy(device, mesh->uvs, vertices, 8, &fits);
    object->mesh.triangle_materials = copy(device, mesh->triangle_materials, triangles, 2, &fits);
    return fits ? SVO_OK
                : svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu vertices and %zu triangles",
                                    function, vertices, triangles);
}

void svo_i_moving_copy_vertices(const svo_mesh *mesh, svo_i_moving_object *object)
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

void svo_i_moving_free_mesh(svo_i_moving_object *object)
{
    svo_i_free(object->given.floats);
    svo_i_free(object->given.doubles);
    svo_i_free(object->given.normals);
    free_arrays(&object->mesh);
    object->given = (svo_i_vertices){.floats = NULL};
    object->world = (svo_i_vertices){.floats = NULL};
}

/* ---- the scene's mesh ---- */

void svo_i_moving_forget_mesh(svo_moving *moving)
{
    free_arrays(&moving->mesh);
}

/* An array of the scene's mesh: those of the objects, one after the other. */
typedef struct joined {
    const svo_moving *moving;
    size_t offset; /* of the array's pointer in svo_mesh */
    size_t element_bytes;
    bool of_triangles;
} joined;

static const void *array_of(const svo_mesh *mesh, size_t offset)
{
    const void *array = NULL;
    memcpy(&array, (const char *)mesh + offset, sizeof array);
    return array;
}

static size_t elements_of(const svo_mesh *mesh, const joined *j)
{
    return j->of_triangles ? mesh->triangle_count : mesh->vertex_count;
}

/* Makes an array of the scene's mesh; elements of objects without one are 0. */
static bool join(const joined *j, bool wanted, svo_mesh *to)
{
    unsigned char *bytes = NULL;
    size_t at = 0;
    if (!wanted) {
        return true;
    }
    bytes = svo_i_alloc_zeroed(&j->moving->device->memory, elements_of(to, j), j->element_bytes);
    memcpy((char *)to + j->offset, &bytes, sizeof bytes);
    for (uint32_t i = 0; i < j->moving->object_count && bytes != NULL; ++i) {
        const svo_i_moving_object *object = &j->moving->objects[i];
        const void *from = array_of(&object->mesh, j->offset);
        const size_t part = svo_i_moving_shows(object) ? elements_of(&object->mesh, j) * j->element_bytes : 0;
        if (part > 0 && from != NULL) {
            memcpy(bytes + at, from, part);
        }
        at += part;
    }
    return bytes != NULL;
}

/* The indices of all objects; those out of range become such in the scene's mesh. */
static bool join_indices(const svo_moving *moving, svo_mesh *to)
{
    uint32_t *indices = svo_i_alloc_zeroed(&moving->device->memory, to->triangle_count, 3 * sizeof *indices);
    uint32_t *at = indices;
    size_t vertex = 0;
    to->indices = indices;
    for (uint32_t i = 0; i < moving->object_count && indices != NULL; ++i) {
        const svo_mesh *mesh = &moving->objects[i].mesh;
        const size_t corners = svo_i_moving_shows(&moving->objects[i]) ? mesh->triangle_count * 3 : 0;
        for (size_t k = 0; k < corners; ++k) {
            const size_t index = mesh->indices != NULL ? mesh->indices[k] : k;
            *at++ = index < mesh->vertex_count ? (uint32_t)(vertex + index) : UINT32_MAX;
        }
        vertex += corners > 0 ? mesh->vertex_count : 0;
    }
    return indices != NULL;
}

static bool join_all(const svo_moving *moving, svo_mesh *to)
{
    const svo_mesh *first = &moving->objects[0].mesh;
    bool materials = false;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        const svo_i_moving_object *object = &moving->objects[i];
        if (svo_i_moving_shows(object)) {
            to->vertex_count += object->mesh.vertex_count;
            to->triangle_count += object->mesh.triangle_count;
            materials = materials || object->mesh.triangle_materials != NULL;
        }
    }
    const struct {
        joined array;
        bool wanted;
    } all[] = {{{moving, offsetof(svo_mesh, positions), 12, false}, first->positions != NULL},
               {{moving, offsetof(svo_mesh, positions_double), 24, false}, first->positions_double != NULL},
               {{moving, offsetof(svo_mesh, normals), 12, false}, first->normals != NULL},
               {{moving, offsetof(svo_mesh, colors), 4, false}, first->colors != NULL},
               {{moving, offsetof(svo_mesh, uvs), 8, false}, first->uvs != NULL},
               {{moving, offsetof(svo_mesh, triangle_materials), 2, true}, materials}};
    bool fits = join_indices(moving, to);
    for (size_t i = 0; i < sizeof all / sizeof all[0]; ++i) {
        fits = fits && join(&all[i].array, all[i].wanted, to);
    }
    return fits;
}

svo_status svo_moving_get_mesh(svo_moving *moving, svo_mesh *mesh)
{
    if (moving == NULL || mesh == NULL) {
        return svo_i_device_fail(moving != NULL ? moving->device : NULL, SVO_INVALID_ARGUMENT,
                                 "svo_moving_get_mesh: %s is NULL", moving == NULL ? "moving" : "mesh");
    }
    const svo_mesh *first = &moving->objects[0].mesh;
    if (moving->mesh.vertex_count == 0 && !join_all(moving, &moving->mesh)) {
        svo_i_moving_forget_mesh(moving);
        return svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "svo_moving_get_mesh: no memory for the mesh");
    }
    *mesh = moving->mesh;
    mesh->struct_size = sizeof *mesh;
    mesh->materials = first->materials;
    mesh->material_count = first->material_count;
    mesh->textures = first->textures;
    mesh->texture_count = first->texture_count;
    mesh->finishes = first->finishes;
    return SVO_OK;
}
