/* SPDX-License-Identifier: MIT */
/* Generates scenes, and variants of them: without attributes, textured, damaged, in double. */
#include "meshes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scenes.h"

static svo_status make_bare(case_mesh *kept)
{
    svo_mesh *mesh = &kept->mesh;
    mesh->normals = NULL;
    mesh->colors = NULL;
    mesh->triangle_materials = NULL;
    mesh->materials = NULL;
    mesh->material_count = 0;
    return SVO_OK;
}

/* Texels that differ from all their neighbors. */
static void fill_texture(case_mesh *kept)
{
    for (size_t i = 0; i < sizeof kept->texels; ++i) {
        kept->texels[i] = (uint8_t)(i * 97 + i / 64 * 31);
    }
    kept->texture = (svo_texture){.rgba = kept->texels,
                                  .width = MESH_TEXTURE_EDGE,
                                  .height = MESH_TEXTURE_EDGE,
                                  .wrap_u = SVO_WRAP_REPEAT,
                                  .wrap_v = SVO_WRAP_MIRROR};
    kept->materials[0] = (svo_material){{255, 200, 100, 255}, 0};
    kept->materials[1] = (svo_material){{90, 160, 255, 128}, SVO_NO_TEXTURE};
}

static svo_status make_textured(case_mesh *kept)
{
    svo_mesh *mesh = &kept->mesh;
    float *uvs = calloc(mesh->vertex_count * 2, sizeof *uvs);
    uint16_t *materials = calloc(mesh->triangle_count, sizeof *materials);
    kept->arrays[0] = uvs;
    kept->arrays[1] = materials;
    if (uvs == NULL || materials == NULL) {
        return SVO_OUT_OF_HOST_MEMORY;
    }
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        uvs[i * 2] = mesh->positions[i * 3] * 1.5f;
        uvs[i * 2 + 1] = mesh->positions[i * 3 + 1] - mesh->positions[i * 3 + 2];
    }
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        materials[i] = i % 3 == 0;
    }
    fill_texture(kept);
    mesh->uvs = uvs;
    mesh->triangle_materials = materials;
    mesh->materials = kept->materials;
    mesh->material_count = 2;
    mesh->textures = &kept->texture;
    mesh->texture_count = 1;
    return SVO_OK;
}

static svo_status make_broken(case_mesh *kept)
{
    const size_t count = kept->mesh.triangle_count * 3;
    uint32_t *indices = calloc(count, sizeof *indices);
    kept->arrays[0] = indices;
    if (indices == NULL) {
        return SVO_OUT_OF_HOST_MEMORY;
    }
    memcpy(indices, kept->mesh.indices, count * sizeof *indices);
    for (size_t i = 0; i < count; i += 21) {
        indices[i] = UINT32_MAX;
    }
    kept->mesh.indices = indices;
    return SVO_OK;
}

static svo_status make_doubles(case_mesh *kept)
{
    svo_mesh *mesh = &kept->mesh;
    const size_t count = mesh->triangle_count * 3;
    double *positions = calloc(count * 3, sizeof *positions);
    kept->arrays[0] = positions;
    if (positions == NULL) {
        return SVO_OUT_OF_HOST_MEMORY;
    }
    for (size_t i = 0; i < count * 3; ++i) {
        positions[i] = (double)mesh->positions[(size_t)mesh->indices[i / 3] * 3 + i % 3] * (1.0 + 0x1p-30);
    }
    *mesh = (svo_mesh){
        .struct_size = sizeof *mesh, .positions_double = positions, .vertex_count = count, .triangle_count = count / 3};
    return SVO_OK;
}

static svo_status make(case_mesh *kept, svo_message *message)
{
    static svo_status (*const change[MESH_VARIANT_COUNT])(case_mesh *) = {
        [MESH_BARE] = make_bare,
        [MESH_TEXTURED] = make_textured,
        [MESH_BROKEN] = make_broken,
        [MESH_DOUBLES] = make_doubles,
    };
    const svo_status status = scene_create(kept->scene, &kept->made, message);
    if (status != SVO_OK) {
        return status;
    }
    kept->mesh = *scene_mesh(kept->made);
    if (change[kept->variant] == NULL) {
        return SVO_OK;
    }
    (void)snprintf(message->text, sizeof message->text, "no memory for a variant of %s", kept->scene);
    return change[kept->variant](kept);
}

const svo_mesh *case_mesh_get(case_mesh *kept, const request *wanted, svo_message *message)
{
    if (kept->scene != NULL && strcmp(kept->scene, wanted->scene) == 0 && kept->variant == wanted->variant) {
        return &kept->mesh;
    }
    case_mesh_release(kept);
    kept->scene = wanted->scene;
    kept->variant = wanted->variant;
    if (make(kept, message) != SVO_OK) {
        case_mesh_release(kept);
        return NULL;
    }
    return &kept->mesh;
}

void case_mesh_release(case_mesh *kept)
{
    for (size_t i = 0; i < sizeof kept->arrays / sizeof kept->arrays[0]; ++i) {
        free(kept->arrays[i]);
    }
    scene_destroy(&kept->made);
    *kept = (case_mesh){0};
}
