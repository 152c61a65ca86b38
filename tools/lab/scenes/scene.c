/* SPDX-License-Identifier: MIT */
/* The list of scenes, the parser of NAME[:triangles[:seed]], and the scene handle. */
#include "scenes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "builder.h"
#include "fail.h"
#include "list.h"

struct scene {
    scene_builder builder;
    svo_mesh mesh;
    uint32_t seed;
};

typedef struct scene_kind {
    scene_description description;
    void (*generate)(scene_builder *builder, const scene_request *request);
} scene_kind;

static const scene_kind kinds[] = {
    {{"atrium", "a two-storeyed arcaded court, cut open to the front: columns, arches, vaults, banners, plants", 70000},
     scene_atrium},
    {{"statue", "a winged figure in a draped robe on a pedestal, polygonized from an implicit surface", 120000},
     scene_statue},
    {{"knot", "a tube along a torus knot, colored along its length", 40000}, scene_knot},
    {{"terrain", "fractal mountains around a lake, colored by height and slope", 100000}, scene_terrain},
    {{"needles", "slivers a hundred to a million times longer than wide, in all directions", 20000}, scene_needles},
    {{"dust", "a spiral of triangles far below a voxel, many to a cell and very many to some cells", 200000},
     scene_dust},
    {{"cornell", "the Cornell box: red and green walls, two boxes, a sphere and a lamp", 5000}, scene_cornell},
    {{"cube", "a cube with a color to each face", 12}, scene_cube},
};
#define KIND_COUNT (sizeof kinds / sizeof kinds[0])

const scene_description *scene_describe(size_t index)
{
    return index < KIND_COUNT ? &kinds[index].description : NULL;
}

static const scene_kind *find_kind(const char *name, size_t name_bytes)
{
    for (size_t k = 0; k < KIND_COUNT; ++k) {
        if (strlen(kinds[k].description.name) == name_bytes &&
            memcmp(kinds[k].description.name, name, name_bytes) == 0) {
            return &kinds[k];
        }
    }
    return NULL;
}

static svo_status fail_name(svo_message *message, const char *name, size_t name_bytes)
{
    char names[256] = "";
    size_t length = 0;
    for (size_t k = 0; k < KIND_COUNT && length < sizeof names; ++k) {
        length += (size_t)snprintf(names + length, sizeof names - length, "%s%s", k == 0 ? "" : ", ",
                                   kinds[k].description.name);
    }
    return scene_fail(message, SVO_INVALID_ARGUMENT, "scene_create: unknown scene '%.*s'; there are %s",
                      (int)(name_bytes < 64 ? name_bytes : 64), name, names);
}

/* Reads a decimal number up to the end of the text or the next colon; false if there is none or it is above limit. */
static bool read_number(const char **text, uint32_t limit, uint32_t *out)
{
    const char *c = *text;
    uint64_t value = 0;
    for (; *c >= '0' && *c <= '9' && value <= limit; ++c) {
        value = value * 10 + (uint64_t)(*c - '0');
    }
    if (c == *text || value > limit || (*c != '\0' && *c != ':')) {
        return false;
    }
    *text = c;
    *out = (uint32_t)value;
    return true;
}

/* Reads what follows the name into request, which holds the defaults. */
static svo_status read_request(const char *rest, const char *spec, scene_request *request, svo_message *message)
{
    if (*rest == ':') {
        ++rest;
        if (!read_number(&rest, SCENE_TRIANGLES_MAX, &request->triangles) || request->triangles == 0) {
            return scene_fail(message, SVO_INVALID_ARGUMENT,
                              "scene_create: the triangle count in '%.64s' is not a whole number from 1 to %u", spec,
                              SCENE_TRIANGLES_MAX);
        }
    }
    if (*rest == ':') {
        ++rest;
        if (!read_number(&rest, UINT32_MAX, &request->seed)) {
            return scene_fail(message, SVO_INVALID_ARGUMENT,
                              "scene_create: the seed in '%.64s' is not a whole number from 0 to %u", spec, UINT32_MAX);
        }
    }
    if (*rest != '\0') {
        return scene_fail(message, SVO_INVALID_ARGUMENT, "scene_create: '%.64s' is not NAME[:triangles[:seed]]", spec);
    }
    return SVO_OK;
}

/* Borrows the builder's arrays. */
static void fill_mesh(const scene_builder *builder, svo_mesh *mesh)
{
    mesh->struct_size = sizeof *mesh;
    mesh->positions = builder->positions;
    mesh->vertex_count = builder->vertex_count;
    mesh->indices = builder->indices;
    mesh->triangle_count = builder->triangle_count;
    mesh->normals = builder->normals;
    mesh->colors = builder->colors;
    if (builder->material_count > 0) {
        mesh->triangle_materials = builder->triangle_materials;
        mesh->materials = builder->materials;
        mesh->material_count = builder->material_count;
    }
}

svo_status scene_create(const char *spec, scene **out, svo_message *message)
{
    const size_t name_bytes = strcspn(spec, ":");
    const scene_kind *kind = find_kind(spec, name_bytes);
    if (kind == NULL) {
        return fail_name(message, spec, name_bytes);
    }
    scene_request request = {.triangles = kind->description.default_triangles, .seed = SCENE_DEFAULT_SEED};
    const svo_status status = read_request(spec + name_bytes, spec, &request, message);
    if (status != SVO_OK) {
        return status;
    }
    scene *made = calloc(1, sizeof *made);
    if (made != NULL) {
        kind->generate(&made->builder, &request);
    }
    if (made == NULL || made->builder.out_of_memory) {
        scene_destroy(&made);
        return scene_fail(message, SVO_OUT_OF_HOST_MEMORY, "scene_create: no memory for %u triangles of '%s'",
                          request.triangles, kind->description.name);
    }
    fill_mesh(&made->builder, &made->mesh);
    made->seed = request.seed;
    *out = made;
    return SVO_OK;
}

void scene_destroy(scene **scene_handle)
{
    if (scene_handle == NULL || *scene_handle == NULL) {
        return;
    }
    builder_release(&(*scene_handle)->builder);
    free(*scene_handle);
    *scene_handle = NULL;
}

const svo_mesh *scene_mesh(const scene *scene_handle)
{
    return &scene_handle->mesh;
}

uint32_t scene_seed(const scene *scene_handle)
{
    return scene_handle->seed;
}
