/* SPDX-License-Identifier: MIT */
/*
 * Meshes as OBJ and PLY files, for other programs and for tests of the importer. Files are written to a temporary name
 * in the same folder, flushed to disk and renamed, so that a reader never sees half a file.
 */
#define _POSIX_C_SOURCE 200809L
#include "scenes.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "fail.h"

/* A file that is not yet renamed to its final name. */
typedef struct pending_file {
    FILE *stream;
    char *path;
    char *temporary_path;
} pending_file;

static char *join_text(const char *head, size_t head_bytes, const char *tail)
{
    const size_t tail_bytes = strlen(tail);
    char *text = malloc(head_bytes + tail_bytes + 1);
    if (text != NULL) {
        memcpy(text, head, head_bytes);
        memcpy(text + head_bytes, tail, tail_bytes + 1);
    }
    return text;
}

static svo_status fail_file(svo_message *message, const char *path, const char *step)
{
    return scene_fail(message, SVO_FILE_ERROR, "scene_write: cannot %s '%s': %s", step, path, strerror(errno));
}

static svo_status pending_open(pending_file *file, const char *path, svo_message *message)
{
    char suffix[32];
    (void)snprintf(suffix, sizeof suffix, ".%ld.tmp", (long)getpid());
    file->path = join_text(path, strlen(path), "");
    file->temporary_path = join_text(path, strlen(path), suffix);
    if (file->path == NULL || file->temporary_path == NULL) {
        return scene_fail(message, SVO_OUT_OF_HOST_MEMORY, "scene_write: no memory for a file name");
    }
    const int descriptor = open(file->temporary_path, O_WRONLY | O_CREAT | O_EXCL, 0666);
    if (descriptor >= 0) {
        file->stream = fdopen(descriptor, "wb");
        if (file->stream == NULL) {
            close(descriptor);
            unlink(file->temporary_path);
        }
    }
    return file->stream != NULL ? SVO_OK : fail_file(message, path, "create");
}

/* Flushes everything to disk, still under the temporary name. */
static svo_status pending_flush(pending_file *file, svo_message *message)
{
    if (ferror(file->stream) != 0 || fflush(file->stream) != 0 || fsync(fileno(file->stream)) != 0) {
        return fail_file(message, file->path, "write");
    }
    return SVO_OK;
}

static svo_status pending_rename(pending_file *file, svo_message *message)
{
    const int closed = fclose(file->stream);
    file->stream = NULL;
    if (closed != 0 || rename(file->temporary_path, file->path) != 0) {
        const svo_status status = fail_file(message, file->path, "write");
        unlink(file->temporary_path);
        return status;
    }
    return SVO_OK;
}

static svo_status pending_commit(pending_file *file, svo_message *message)
{
    const svo_status status = pending_flush(file, message);
    return status != SVO_OK ? status : pending_rename(file, message);
}

/* Removes the temporary file unless it was renamed. */
static void pending_release(pending_file *file)
{
    if (file->stream != NULL) {
        (void)fclose(file->stream);
        unlink(file->temporary_path);
    }
    free(file->path);
    free(file->temporary_path);
}

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

static void put_mtl(FILE *stream, const svo_mesh *mesh)
{
    for (size_t k = 0; k < mesh->material_count; ++k) {
        const uint8_t *c = mesh->materials[k].rgba;
        (void)fprintf(stream, "newmtl material_%zu\nKd %.5f %.5f %.5f\nd %.5f\nillum 1\n", k, c[0] / 255.0,
                      c[1] / 255.0, c[2] / 255.0, c[3] / 255.0);
    }
}

static void put_obj(FILE *stream, const svo_mesh *mesh, const char *library_path)
{
    (void)fprintf(stream, "# svocl scene: %zu vertices, %zu triangles\n", mesh->vertex_count, mesh->triangle_count);
    if (mesh->material_count > 0) {
        const char *slash = strrchr(library_path, '/');
        (void)fprintf(stream, "mtllib %s\n", slash == NULL ? library_path : slash + 1);
    }
    put_obj_vertices(stream, mesh);
    put_obj_faces(stream, mesh);
}

static svo_status write_mtl(const svo_mesh *mesh, const char *path, svo_message *message)
{
    pending_file file = {NULL, NULL, NULL};
    svo_status status = pending_open(&file, path, message);
    if (status != SVO_OK) {
        goto cleanup;
    }
    put_mtl(file.stream, mesh);
    status = pending_commit(&file, message);

cleanup:
    pending_release(&file);
    return status;
}

static svo_status write_obj_and_mtl(const svo_mesh *mesh, const char *path, const char *library_path,
                                    svo_message *message)
{
    pending_file file = {NULL, NULL, NULL};
    svo_status status = pending_open(&file, path, message);
    if (status != SVO_OK) {
        goto cleanup;
    }
    put_obj(file.stream, mesh, library_path);
    status = pending_flush(&file, message);
    if (status != SVO_OK) {
        goto cleanup;
    }
    /* The library is renamed first: an object without its library would be half a result. */
    if (mesh->material_count > 0) {
        status = write_mtl(mesh, library_path, message);
        if (status != SVO_OK) {
            goto cleanup;
        }
    }
    status = pending_rename(&file, message);

cleanup:
    pending_release(&file);
    return status;
}

static svo_status write_obj(const svo_mesh *mesh, const char *path, svo_message *message)
{
    char *library_path = join_text(path, strlen(path) - strlen(".obj"), ".mtl");
    if (library_path == NULL) {
        return scene_fail(message, SVO_OUT_OF_HOST_MEMORY, "scene_write: no memory for a file name");
    }
    const svo_status status = write_obj_and_mtl(mesh, path, library_path, message);
    free(library_path);
    return status;
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

static svo_status write_ply(const svo_mesh *mesh, const char *path, svo_message *message)
{
    bool shared = false;
    pending_file file = {NULL, NULL, NULL};
    uint8_t *colors = baked_colors(mesh, &shared);
    if (colors == NULL) {
        return scene_fail(message, SVO_OUT_OF_HOST_MEMORY, "scene_write: no memory for %zu colors", mesh->vertex_count);
    }
    svo_status status = SVO_OK;
    if (shared) {
        status = scene_fail(message, SVO_UNSUPPORTED,
                            "scene_write: '%s': triangles of different base colors share a vertex, which a .ply file "
                            "cannot store; write an .obj file",
                            path);
        goto cleanup;
    }
    status = pending_open(&file, path, message);
    if (status != SVO_OK) {
        goto cleanup;
    }
    put_ply(file.stream, mesh, colors);
    status = pending_commit(&file, message);

cleanup:
    pending_release(&file);
    free(colors);
    return status;
}

static bool has_suffix(const char *path, const char *suffix)
{
    const size_t path_bytes = strlen(path);
    const size_t suffix_bytes = strlen(suffix);
    return path_bytes > suffix_bytes && strcasecmp(path + path_bytes - suffix_bytes, suffix) == 0;
}

svo_status scene_write(const svo_mesh *mesh, const char *path, svo_message *message)
{
    const bool is_obj = has_suffix(path, ".obj");
    if (!is_obj && !has_suffix(path, ".ply")) {
        return scene_fail(message, SVO_INVALID_ARGUMENT, "scene_write: '%s' does not end in .obj or .ply", path);
    }
    if (mesh->positions == NULL || mesh->normals == NULL || mesh->colors == NULL || mesh->texture_count > 0) {
        return scene_fail(message, SVO_UNSUPPORTED,
                          "scene_write: '%s': the mesh needs float positions, normals and colors and no textures",
                          path);
    }
    return is_obj ? write_obj(mesh, path, message) : write_ply(mesh, path, message);
}
