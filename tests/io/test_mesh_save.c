/* SPDX-License-Identifier: MIT */
/* Saved meshes: read again with the same positions, triangles, normals and colors; the bytes of .glb; refusals. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/suite.h"
#include "support/work_folder.h"
#include "svocl/io.h"

/* A strip of triangles whose colors are all bytes. */
enum { VERTICES = 256, TRIANGLES = VERTICES - 2 };

typedef struct strip {
    float positions[3 * VERTICES];
    float normals[3 * VERTICES];
    uint8_t colors[4 * VERTICES];
    uint32_t indices[3 * TRIANGLES];
    svo_mesh mesh;
} strip;

static void make_strip(strip *made, bool with_alpha)
{
    for (size_t i = 0; i < VERTICES; ++i) {
        const double angle = 0.1 * (double)i;
        made->positions[3 * i] = (float)(cos(angle) / 3);
        made->positions[3 * i + 1] = (float)(1e-3 * (double)i - 0.05);
        made->positions[3 * i + 2] = (float)(i % 2) / 7.0F;
        made->normals[3 * i] = (float)cos(angle);
        made->normals[3 * i + 1] = 0.0F;
        made->normals[3 * i + 2] = (float)sin(angle);
        made->colors[4 * i] = (uint8_t)i;
        made->colors[4 * i + 1] = (uint8_t)(255 - i);
        made->colors[4 * i + 2] = (uint8_t)(i * 7);
        made->colors[4 * i + 3] = with_alpha ? (uint8_t)(i * 3) : 255;
    }
    for (uint32_t i = 0; i < TRIANGLES; ++i) {
        made->indices[3 * i] = i;
        made->indices[3 * i + 1] = i + 1 + i % 2;
        made->indices[3 * i + 2] = i + 2 - i % 2;
    }
    made->mesh = (svo_mesh){.struct_size = sizeof made->mesh,
                            .positions = made->positions,
                            .vertex_count = VERTICES,
                            .indices = made->indices,
                            .triangle_count = TRIANGLES,
                            .normals = made->normals,
                            .colors = made->colors};
}

static svo_import *import_saved(const char *name)
{
    const svo_import_options options = {.struct_size = sizeof options, .strict = 1};
    svo_import *import = NULL;
    svo_message message = {""};
    if (svo_import_file(path_of(name), &options, NULL, NULL, &import, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return import;
}

static void save(const svo_mesh *mesh, const char *name)
{
    svo_message message = {""};
    if (svo_mesh_save(mesh, svo_to_path(path_of(name)), SVO_MESH_FORMAT_AUTO, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
}

/* Compares corner by corner: vertices may have another order. alpha: whether the format keeps it. */
static void check_saved(const svo_mesh *mesh, const char *name, bool alpha)
{
    save(mesh, name);
    svo_import *import = import_saved(name);
    const svo_mesh *again = svo_import_mesh(import);
    assert_int_equal(again->triangle_count, mesh->triangle_count);
    assert_int_equal(again->colors != NULL, mesh->colors != NULL);
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const size_t from = mesh->indices != NULL ? mesh->indices[i] : i;
        const size_t to = again->indices[i];
        for (size_t axis = 0; axis < 3; ++axis) {
            const double position = again->positions_double != NULL ? again->positions_double[3 * to + axis]
                                                                    : (double)again->positions[3 * to + axis];
            assert_true((float)position == mesh->positions[3 * from + axis]);
            assert_true(mesh->normals == NULL ||
                        fabsf(again->normals[3 * to + axis] - mesh->normals[3 * from + axis]) < 1e-6F);
        }
        if (mesh->colors != NULL) {
            assert_memory_equal(again->colors + 4 * to, mesh->colors + 4 * from, 3);
            assert_int_equal(again->colors[4 * to + 3], alpha ? mesh->colors[4 * from + 3] : 255);
        }
    }
    svo_import_destroy(&import);
}

static void saved_meshes_come_back(void **state)
{
    (void)state;
    static const char *const names[] = {"a.ply", "a.obj", "a.GLB"};
    strip *made = malloc(sizeof *made);
    assert_non_null(made);
    for (size_t i = 0; i < 3; ++i) {
        work_folder_remember(names[i]);
        make_strip(made, true);
        check_saved(&made->mesh, names[i], i != 1);
        make_strip(made, false);
        check_saved(&made->mesh, names[i], true);
        made->mesh.normals = NULL;
        check_saved(&made->mesh, names[i], true);
        made->mesh.colors = NULL;
        check_saved(&made->mesh, names[i], true);
        made->mesh.indices = NULL;
        made->mesh.triangle_count = VERTICES / 3;
        made->mesh.vertex_count = VERTICES / 3 * 3;
        check_saved(&made->mesh, names[i], true);
    }
    free(made);
}

static int append(void *user, const void *bytes, size_t byte_count)
{
    char **end = user;
    memcpy(*end, bytes, byte_count);
    *end += byte_count;
    return 0;
}

static int refuse(void *user, const void *bytes, size_t byte_count)
{
    (void)user;
    (void)bytes;
    (void)byte_count;
    return 1;
}

/* Lengths of chunks, the bounds that glTF wants of positions, and a length for normals without one. */
static void glb_files_are_as_gltf_says(void **state)
{
    (void)state;
    static const float positions[9] = {0, 0, -2.5F, 1, 0, 0, 0, 0.1F, 0};
    static const float normals[9] = {0, 0, 0, 3, 0, 0, 0, 0, -1};
    const svo_mesh mesh = {
        .struct_size = sizeof mesh, .positions = positions, .vertex_count = 3, .triangle_count = 1, .normals = normals};
    char bytes[4096];
    char *end = bytes;
    uint32_t words[5];
    float stored[6];
    svo_message message = {""};
    assert_int_equal(svo_mesh_save(&mesh, svo_to_callback(append, &end), SVO_MESH_FORMAT_GLB, &message), SVO_OK);
    memcpy(words, bytes, sizeof words);
    assert_memory_equal(bytes, "glTF\2\0\0\0", 8);
    assert_int_equal(words[2], end - bytes);
    assert_int_equal(words[3] % 4, 0);
    assert_memory_equal(bytes + 16, "JSON{", 5);
    char *json = bytes + 20;
    const char *binary = json + words[3];
    assert_int_equal(binary + 8 + 3 * 12 + 3 * 12 + 3 * 4, end);
    assert_memory_equal(binary + 4, "BIN", 4);
    memcpy(stored, binary + 8 + 36, sizeof stored);
    assert_true(stored[2] == 1.0F && stored[3] == 1.0F && stored[4] == 0.0F);
    json[words[3] - 1] = '\0';
    assert_non_null(strstr(json, "\"min\":[0,0,-2.5],\"max\":[1,0.100000001,0]"));
    assert_non_null(strstr(json, "\"NORMAL\":1}"));
    assert_null(strstr(json, "COLOR_0"));
    assert_int_equal(svo_mesh_save(&mesh, svo_to_callback(refuse, NULL), SVO_MESH_FORMAT_GLB, &message),
                     SVO_FILE_ERROR);
}

static void expect_refusal(const svo_mesh *mesh, svo_mesh_format format, svo_status expected, const char *words)
{
    char byte = 0;
    char *end = &byte;
    svo_message message = {""};
    assert_int_equal(svo_mesh_save(mesh, svo_to_callback(append, &end), format, &message), expected);
    assert_ptr_equal(end, &byte);
    if (strstr(message.text, words) == NULL) {
        fail_msg("'%s' does not say '%s'", message.text, words);
    }
}

static void what_cannot_be_saved_is_refused(void **state)
{
    (void)state;
    float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, NAN};
    uint32_t indices[3] = {0, 1, 3};
    const svo_material material = {.texture_index = SVO_NO_TEXTURE};
    svo_mesh mesh = {
        .struct_size = sizeof mesh, .positions = positions, .vertex_count = 3, .indices = indices, .triangle_count = 1};
    expect_refusal(NULL, SVO_MESH_FORMAT_PLY, SVO_INVALID_ARGUMENT, "mesh is NULL");
    expect_refusal(&mesh, SVO_MESH_FORMAT_AUTO, SVO_INVALID_ARGUMENT, "format 0 is not in 1 .. 3");
    expect_refusal(&mesh, SVO_MESH_FORMAT_PLY, SVO_INVALID_ARGUMENT, "of vertex 2 is not finite");
    positions[8] = 0;
    expect_refusal(&mesh, SVO_MESH_FORMAT_PLY, SVO_INVALID_ARGUMENT, "vertex 3 of triangle 0 is not below 3");
    mesh.triangle_count = 0;
    expect_refusal(&mesh, SVO_MESH_FORMAT_GLB, SVO_INVALID_ARGUMENT, "3 vertices or 0 triangles are not in 1 ..");
    mesh.triangle_count = 1;
    mesh.materials = &material;
    mesh.material_count = 1;
    expect_refusal(&mesh, SVO_MESH_FORMAT_OBJ, SVO_UNSUPPORTED, "the mesh has materials or textures");
    mesh.positions = NULL;
    expect_refusal(&mesh, SVO_MESH_FORMAT_OBJ, SVO_UNSUPPORTED, "the mesh has no float positions");
    svo_message message = {""};
    assert_int_equal(svo_mesh_save(&mesh, svo_to_path(path_of("a.stl")), SVO_MESH_FORMAT_AUTO, &message),
                     SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "is not ply, obj or glb"));
}

TEST_GROUP(mesh_save)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(saved_meshes_come_back),
        cmocka_unit_test(glb_files_are_as_gltf_says),
        cmocka_unit_test(what_cannot_be_saved_is_refused),
    };
    return cmocka_run_group_tests_name("mesh_save", tests, work_folder_make, work_folder_remove);
}
