/* SPDX-License-Identifier: MIT */
/* Meshes as OBJ, MTL and PLY, for other programs and for tests of the importer. */
#include "scenes.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "fail.h"

static const uint8_t *base_color(const svo_mesh *mesh, size_t triangle)
{
    static const uint8_t white[4] = {255, 255, 255, 255};
    if (mesh->material_count == 0) {
        return white;
    }
    return mesh->materials[mesh->triangle_materials == NULL ? 0 : mesh->triangle_materials[triangle]].rgba;
}

static uint32_t corner_index(const svo_mesh *mesh, size_t corner)
{
    return mesh->indices == NULL ? (uint32_t)corner : mesh->indices[corner];
}

static svo_status check_mesh(const svo_mesh *mesh, svo_message *message)
{
    if (mesh->positions == NULL || mesh->normals == NULL || mesh->colors == NULL || mesh->texture_count > 0) {
        return scene_fail(message, SVO_UNSUPPORTED,
                          "scene_write: the mesh needs float positions, normals and colors and no textures");
    }
    return SVO_OK;
}

/* ---- OBJ ---- */

static void put_obj_vertices(FILE *stream, const svo_mesh *mesh)
{
    for (size_t vertex = 0; vertex < mesh->vertex_count; ++vertex) {
        const float *p = mesh->positions + 3 * vertex;
        const uint8_t *c = mesh->colors + 4 * vertex;
        (void)fprintf(stream, "v %.9g %.9g %.9g %.5f %.5f %.5f\n", (double)p[0], (double)p[1], (double)p[2],
                      c[0] / 255.0, c[1] / 255.0, c[2] / 255.0);
    }
    for (size_t vertex = 0; vertex < mesh->vertex_count; ++vertex) {
        const float *n = mesh->normals + 3 * vertex;
        (void)fprintf(stream, "vn %.9g %.9g %.9g\n", (double)n[0], (double)n[1], (double)n[2]);
    }
}

static void put_obj_faces(FILE *stream, const svo_mesh *mesh)
{
    unsigned current = UINT32_MAX;
    for (size_t triangle = 0; triangle < mesh->triangle_count; ++triangle) {
        const unsigned material = mesh->triangle_materials == NULL ? 0 : mesh->triangle_materials[triangle];
        if (mesh->material_count > 0 && material != current) {
            (void)fprintf(stream, "usemtl material_%u\n", material);
            current = material;
        }
        const unsigned a = corner_index(mesh, 3 * triangle) + 1;
        const unsigned b = corner_index(mesh, 3 * triangle + 1) + 1;
        const unsigned c = corner_index(mesh, 3 * triangle + 2) + 1;
        (void)fprintf(stream, "f %u//%u %u//%u %u//%u\n", a, a, b, b, c, c);
    }
}

svo_status scene_write_obj(const svo_mesh *mesh, const char *library_name, FILE *stream, svo_message *message)
{
    const svo_status status = check_mesh(mesh, message);
    if (status != SVO_OK) {
        return status;
    }
    (void)fprintf(stream, "# svocl scene: %zu vertices, %zu triangles\n", mesh->vertex_count, mesh->triangle_count);
    if (mesh->material_count > 0) {
        (void)fprintf(stream, "mtllib %s\n", library_name);
    }
    put_obj_vertices(stream, mesh);
    put_obj_faces(stream, mesh);
    return SVO_OK;
}

void scene_write_mtl(const svo_mesh *mesh, FILE *stream)
{
    for (size_t k = 0; k < mesh->material_count; ++k) {
        const uint8_t *c = mesh->materials[k].rgba;
        (void)fprintf(stream, "newmtl material_%zu\nKd %.5f %.5f %.5f\nd %.5f\nillum 1\n", k, c[0] / 255.0,
                      c[1] / 255.0, c[2] / 255.0, c[3] / 255.0);
    }
}

/* ---- PLY ---- */

static void store_word(uint8_t bytes[4], uint32_t word)
{
    for (int k = 0; k < 4; ++k) {
        bytes[k] = (uint8_t)(word >> (8 * k));
    }
}

static void store_floats(uint8_t *bytes, const float values[3])
{
    for (size_t k = 0; k < 3; ++k) {
        uint32_t word;
        memcpy(&word, &values[k], sizeof word);
        store_word(bytes + 4 * k, word);
    }
}

/* Vertex colors times base colors, rounded half up as mesh.h says; NULL without memory. *shared: whether triangles of
   different base colors share a vertex. */
static uint8_t *baked_colors(const svo_mesh *mesh, bool *shared)
{
    const uint8_t **bases = calloc(mesh->vertex_count + 1, sizeof *bases);
    uint8_t *baked = malloc(4 * mesh->vertex_count + 1);
    *shared = false;
    for (size_t corner = 0; bases != NULL && baked != NULL && corner < 3 * mesh->triangle_count; ++corner) {
        const uint32_t vertex = corner_index(mesh, corner);
        const uint8_t *base = base_color(mesh, corner / 3);
        *shared = *shared || (bases[vertex] != NULL && memcmp(bases[vertex], base, 4) != 0);
        bases[vertex] = base;
    }
    for (size_t k = 0; bases != NULL && baked != NULL && k < 4 * mesh->vertex_count; ++k) {
        const unsigned base = bases[k / 4] == NULL ? 255u : bases[k / 4][k % 4];
        baked[k] = (uint8_t)((2u * mesh->colors[k] * base + 255u) / 510u);
    }
    if (bases == NULL) {
        free(baked);
        baked = NULL;
    }
    free((void *)bases);
    return baked;
}

static void put_ply(FILE *stream, const svo_mesh *mesh, const uint8_t *colors)
{
    (void)fprintf(stream,
                  "ply\nformat binary_little_endian 1.0\ncomment svocl scene\nelement vertex %zu\n"
                  "property float x\nproperty float y\nproperty float z\n"
                  "property float nx\nproperty float ny\nproperty float nz\n"
                  "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n"
                  "element face %zu\nproperty list uchar uint vertex_indices\nend_header\n",
                  mesh->vertex_count, mesh->triangle_count);
    for (size_t vertex = 0; vertex < mesh->vertex_count; ++vertex) {
        uint8_t record[28];
        store_floats(record, mesh->positions + 3 * vertex);
        store_floats(record + 12, mesh->normals + 3 * vertex);
        memcpy(record + 24, colors + 4 * vertex, 4);
        (void)fwrite(record, sizeof record, 1, stream);
    }
    for (size_t triangle = 0; triangle < mesh->triangle_count; ++triangle) {
        uint8_t record[13] = {3};
        for (size_t k = 0; k < 3; ++k) {
            store_word(record + 1 + 4 * k, corner_index(mesh, 3 * triangle + k));
        }
        (void)fwrite(record, sizeof record, 1, stream);
    }
}

svo_status scene_write_ply(const svo_mesh *mesh, FILE *stream, svo_message *message)
{
    bool shared = false;
    const svo_status status = check_mesh(mesh, message);
    if (status != SVO_OK) {
        return status;
    }
    uint8_t *colors = baked_colors(mesh, &shared);
    if (colors == NULL) {
        return scene_fail(message, SVO_OUT_OF_HOST_MEMORY, "scene_write_ply: no memory for %zu colors",
                          mesh->vertex_count);
    }
    if (shared) {
        free(colors);
        return scene_fail(
            message, SVO_UNSUPPORTED,
            "scene_write_ply: triangles of different base colors share a vertex, which a .ply file cannot "
            "store; write an .obj file");
    }
    put_ply(stream, mesh, colors);
    free(colors);
    return SVO_OK;
}
