/* SPDX-License-Identifier: MIT */
/*
 * Meshes are imported as their files define them: positions bit for bit, node transforms, normals, colors, texture
 * coordinates and textures, from OBJ, PLY and STL files written here. Any failure of the reading process becomes
 * a status and a one-line message.
 */
#define _XOPEN_SOURCE 700
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <stb/stb_image_write.h>

#include "sanitizer.h"
#include "support/work_folder.h"

#include "io/import.h"
#include "io/import_stream.h"
#include "support/suite.h"
#include "svocl/io.h"

/* Defined in the library, but not declared in its header. The result is released by free. */
unsigned char *stbi_write_png_to_mem(const unsigned char *pixels, int stride_bytes, int x, int y, int n, int *out_len);

#define TEXT_BYTES  16384
#define SELF        "/proc/self/exe" /* as the child program */
#define MISBEHAVIOR "SVOCL_TEST_MISBEHAVIOR" /* how this program misbehaves when it is started as a child */

static char last_warning[SVO_MESSAGE_BYTES];

/* 2 x 2: red and green in the upper row, blue and white in the lower. */
static const uint8_t picture[16] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255};

static void write_picture(const char *name)
{
    assert_int_not_equal(stbi_write_png(path_of(name), 2, 2, 4, picture, 8), 0);
    work_folder_remember(name);
}

static void keep_warning(void *user, svo_log_level level, const char *text)
{
    (void)user;
    assert_int_equal(level, SVO_LOG_WARNING);
    (void)snprintf(last_warning, sizeof last_warning, "%s", text);
}

static svo_import *import_as(const char *name, const svo_import_options *options)
{
    svo_import *import = NULL;
    svo_message message = {""};
    last_warning[0] = '\0';
    if (svo_import_file(path_of(name), options, keep_warning, NULL, &import, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return import;
}

static svo_import *import_file(const char *name)
{
    return import_as(name, NULL);
}

static void expect_failure(const char *path, const svo_import_options *options, svo_status expected, const char *text)
{
    svo_import *import = NULL;
    svo_message message = {""};
    const svo_status status = svo_import_file(path, options, NULL, NULL, &import, &message);
    if (status != expected || strstr(message.text, text) == NULL || strstr(message.text, path) != message.text) {
        fail_msg("%s \"%s\", expected %s and \"%s: ... %s\"", svo_name(SVO_NAME_STATUS, status), message.text,
                 svo_name(SVO_NAME_STATUS, expected), path, text);
    }
    assert_null(import);
}

/* Corner c of triangle t, in an attribute of width floats per vertex. */
static const float *corner(const svo_mesh *mesh, const float *attribute, size_t t, size_t c, size_t width)
{
    assert_non_null(attribute);
    const uint32_t vertex = mesh->indices[3 * t + c];
    assert_true(vertex < mesh->vertex_count);
    return attribute + width * vertex;
}

static void expect_vector(const float *vector, float x, float y, float z)
{
    if (vector[0] != x || vector[1] != y || vector[2] != z) {
        fail_msg("(%.9g, %.9g, %.9g), expected (%.9g, %.9g, %.9g)", (double)vector[0], (double)vector[1],
                 (double)vector[2], (double)x, (double)y, (double)z);
    }
}

static void expect_uv(const svo_mesh *mesh, size_t t, size_t c, float u, float v)
{
    const float *uv = corner(mesh, mesh->uvs, t, c, 2);
    if (fabsf(uv[0] - u) > 1e-6f || fabsf(uv[1] - v) > 1e-6f) {
        fail_msg("uv (%.9g, %.9g), expected (%.9g, %.9g)", (double)uv[0], (double)uv[1], (double)u, (double)v);
    }
}

static void expect_color(const svo_mesh *mesh, size_t t, size_t c, const uint8_t expected[4])
{
    assert_non_null(mesh->colors);
    assert_memory_equal(mesh->colors + 4 * mesh->indices[3 * t + c], expected, 4);
}

static const svo_material *material_of(const svo_mesh *mesh, size_t t)
{
    assert_non_null(mesh->triangle_materials);
    assert_true(mesh->triangle_materials[t] < mesh->material_count);
    return &mesh->materials[mesh->triangle_materials[t]];
}

static void expect_picture(const svo_texture *texture)
{
    assert_int_equal(texture->width, 2);
    assert_int_equal(texture->height, 2);
    assert_memory_equal(texture->rgba, picture, sizeof picture);
}

/* OBJ */

static void test_obj_with_material_and_texture(void **unused)
{
    (void)unused;
    write_picture("colors.png");
    write_text("quad.mtl", "newmtl painted\nKd 1 0.5 0.25\nd 0.5\nmap_Kd colors.png\n"
                           "newmtl clamped\nKd 0 0 1\nmap_Kd -clamp on colors.png\n");
    write_text("quad.obj", "mtllib quad.mtl\n"
                           "v 0.125 -3.5 1e3\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                           "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 0.75\nvn 0 0 1\n"
                           "usemtl painted\nf 1/1/1 2/2/1 3/3/1 4/4/1\n"
                           "usemtl clamped\nf 1/1/1 3/3/1 2/2/1\n");
    svo_import *import = import_file("quad.obj");
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_int_equal(mesh->struct_size, sizeof *mesh);
    assert_int_equal(mesh->triangle_count, 3);
    assert_int_equal(mesh->vertex_count, 4);
    expect_vector(corner(mesh, mesh->positions, 0, 0, 3), 0.125f, -3.5f, 1000);
    expect_vector(corner(mesh, mesh->normals, 0, 0, 3), 0, 0, 1);
    expect_uv(mesh, 2, 0, 0, 1); /* OBJ counts v from the last row, svo_texture from the first */
    expect_uv(mesh, 2, 1, 1, 0);
    expect_uv(mesh, 2, 2, 1, 1);
    const svo_material *painted = material_of(mesh, 0);
    assert_memory_equal(painted->rgba, ((const uint8_t[]){255, 128, 64, 128}), 4);
    expect_picture(&mesh->textures[painted->texture_index]);
    assert_int_equal(mesh->textures[painted->texture_index].wrap_u, SVO_WRAP_REPEAT);
    const svo_material *clamped = material_of(mesh, 2);
    assert_memory_equal(clamped->rgba, ((const uint8_t[]){0, 0, 255, 255}), 4);
    expect_picture(&mesh->textures[clamped->texture_index]);
    assert_int_equal(mesh->textures[clamped->texture_index].wrap_u, SVO_WRAP_CLAMP);
    assert_int_equal(mesh->textures[clamped->texture_index].wrap_v, SVO_WRAP_CLAMP);
    assert_string_equal(last_warning, "");
    /* What was read besides the file is known, each file once: programs that write must spare it. */
    assert_non_null(strstr(svo_import_file_path(import, 0), "quad.mtl"));
    assert_non_null(strstr(svo_import_file_path(import, 1), "colors.png"));
    assert_null(svo_import_file_path(import, 2));
    svo_import_destroy(&import);
    assert_null(import);
}

/* Heights of MTL become normals, normal maps stay, and "norm" goes first. A ramp along x rises by its steps, at its end
   by the fall to its begin; up in the image is up in the map. */
static void test_normal_maps_of_obj(void **unused)
{
    (void)unused;
    static const svo_import_options with_maps = {.struct_size = sizeof with_maps, .normal_maps = 1};
    static const uint8_t steps[4] = {0, 51, 102, 153};
    uint8_t heights[64];
    uint8_t normals[16];
    for (size_t i = 0; i < 16; ++i) {
        memset(heights + 4 * i, steps[i % 4], 3);
        heights[4 * i + 3] = 255;
    }
    for (size_t i = 0; i < 4; ++i) {
        memcpy(normals + 4 * i, ((const uint8_t[]){204, 128, 230, 255}), 4);
    }
    assert_int_not_equal(stbi_write_png(path_of("heights.png"), 4, 4, 4, heights, 16), 0);
    assert_int_not_equal(stbi_write_png(path_of("normals.png"), 2, 2, 4, normals, 8), 0);
    work_folder_remember("heights.png");
    work_folder_remember("normals.png");
    write_text("maps.mtl", "newmtl high\nbump -bm 2.5 heights.png\nnewmtl bent\nmap_Bump normals.png\n"
                           "newmtl both\nnorm heights.png\nbump normals.png\n"
                           "newmtl apart\nmap_Kd normals.png\nmap_Bump -s 2 2 normals.png\n");
    write_text("maps.obj", "mtllib maps.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
                           "usemtl high\nf 1/1 2/2 3/3\nusemtl bent\nf 1/1 2/2 3/3\n"
                           "usemtl both\nf 1/1 2/2 3/3\nusemtl apart\nf 1/1 2/2 3/3\n");
    svo_import *import = import_as("maps.obj", &with_maps);
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_non_null(mesh->normal_maps);
    const svo_normal_map *maps = mesh->normal_maps;
    assert_true(maps[0].scale == 2.5F);
    const svo_texture *made = &mesh->textures[maps[0].texture_index];
    for (size_t i = 0; i < 16; ++i) {
        const double rise = 2 * (steps[(i + 1) % 4] - steps[(i + 3) % 4]) / (2 * 255.0);
        const double length = sqrt(rise * rise + 1);
        assert_int_equal(made->rgba[4 * i], (int)(127.5 * -rise / length + 128));
        assert_int_equal(made->rgba[4 * i + 1], 128);
        assert_int_equal(made->rgba[4 * i + 2], (int)(127.5 / length + 128));
    }
    assert_memory_equal(mesh->textures[maps[1].texture_index].rgba, normals, sizeof normals);
    assert_memory_equal(mesh->textures[maps[2].texture_index].rgba, heights, sizeof heights);
    assert_int_equal(maps[3].texture_index, SVO_NO_TEXTURE);
    assert_non_null(strstr(last_warning, "material apart: the normal map normals.png lies otherwise"));
    assert_int_equal(material_of(mesh, 0)->texture_index, SVO_NO_TEXTURE);
    expect_uv(mesh, 0, 1, 1, 1);
    svo_import_destroy(&import);
    import = import_file("maps.obj");
    assert_null(svo_import_mesh(import)->normal_maps);
    assert_int_equal(svo_import_mesh(import)->texture_count, 1);
    assert_string_equal(last_warning, "");
    svo_import_destroy(&import);
}

static void test_a_missing_texture_is_a_warning(void **unused)
{
    (void)unused;
    write_text("lost.mtl", "newmtl lost\nKd 0 1 0\nmap_Kd folder\\nowhere.png\n");
    write_text("lost.obj", "mtllib lost.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl lost\nf 1/1 2/1 3/1\n");
    svo_import *import = import_file("lost.obj");
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_int_equal(mesh->texture_count, 0);
    assert_int_equal(material_of(mesh, 0)->texture_index, SVO_NO_TEXTURE);
    assert_null(mesh->uvs);
    assert_non_null(strstr(last_warning, "lost.obj: texture "));
    assert_non_null(strstr(last_warning, "nowhere.png cannot be read"));
    assert_non_null(strstr(last_warning, strerror(ENOENT)));
    svo_import_destroy(&import);
}

static void test_plain_obj_has_no_attributes(void **unused)
{
    (void)unused;
    write_text("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\nl 1 2\np 1\n");
    svo_import *import = import_file("plain.obj");
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_int_equal(mesh->triangle_count, 2);
    assert_int_equal(mesh->vertex_count, 4);
    assert_null(mesh->normals);
    assert_null(mesh->colors);
    assert_null(mesh->uvs);
    assert_null(mesh->triangle_materials);
    assert_int_equal(mesh->material_count, 0);
    assert_int_equal(mesh->texture_count, 0);
    svo_import_destroy(&import);
}

static void test_degenerate_triangles_are_kept(void **unused)
{
    (void)unused;
    write_text("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 0 0\nf 1 2 3\nf 1 1 2\nf 1 4 1\nf 2 2 2\n");
    svo_import *import = import_file("flat.obj");
    assert_int_equal(svo_import_mesh(import)->triangle_count, 4);
    svo_import_destroy(&import);
}

/* Close vertices are not equal: the two in the middle differ in the last bit. */
static void test_vertices_are_joined_only_when_equal(void **unused)
{
    (void)unused;
    write_text("close.obj", "v 0 0 0\nv 1 0 0\nv 1.00000012 0 0\nv 0 1 0\nv 0 0 0\nf 1 2 4\nf 5 3 4\n");
    svo_import *import = import_file("close.obj");
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_int_equal(mesh->vertex_count, 4);
    assert_int_equal(mesh->indices[0], mesh->indices[3]);
    assert_int_not_equal(mesh->indices[1], mesh->indices[4]);
    svo_import_destroy(&import);
}

static void test_missing_attributes_become_neutral(void **unused)
{
    (void)unused;
    write_text("mixed.obj", "o a\nv 0 0 0 1 0 nan\nv 1 0 0 0.5 2 -1\nv 0 1 0 0 0 0\nvn 0 1 0\nf 1//1 2//1 3//1\n"
                            "o b\nv 5 0 0 1 1 1\nv 6 0 0 1 1 1\nv 5 1 0 1 1 1\nf 4 5 6\n");
    svo_import *import = import_file("mixed.obj");
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_int_equal(mesh->triangle_count, 2);
    expect_vector(corner(mesh, mesh->normals, 0, 0, 3), 0, 1, 0);
    expect_vector(corner(mesh, mesh->normals, 1, 0, 3), 0, 0, 0);
    expect_color(mesh, 0, 0, (const uint8_t[]){255, 0, 0, 255});
    expect_color(mesh, 0, 1, (const uint8_t[]){128, 255, 0, 255});
    expect_color(mesh, 1, 0, (const uint8_t[]){255, 255, 255, 255});
    svo_import_destroy(&import);
}

/* Where the vertices of a file went: those that are equal to one, those that no face has to none. */
static void expect_file_vertices(const char *name, const char *text, size_t count, size_t unused_index)
{
    write_text(name, text);
    svo_import *import = import_file(name);
    const svo_mesh *mesh = svo_import_mesh(import);
    size_t found = 0;
    const uint32_t *vertices = svo_import_file_vertices(import, &found);
    assert_int_equal(found, count);
    for (size_t i = 0; i < count; ++i) {
        if (i == unused_index) {
            assert_int_equal(vertices[i], SVO_NO_VERTEX);
        } else { /* vertex i lies at (i, i * i, 0), but the last one where the first is */
            const float x = i + 1 == count ? 0 : (float)i;
            const float place[3] = {x, x * x, 0};
            assert_true(vertices[i] < mesh->vertex_count);
            assert_memory_equal(mesh->positions + 3 * (size_t)vertices[i], place, sizeof place);
        }
    }
    svo_import_destroy(&import);
}

static void test_vertices_of_files_are_found_again(void **unused)
{
    (void)unused;
    expect_file_vertices("map.obj", "v 0 0 0\nv 1 1 0\nv 2 4 0\nv 3 9 0\nv 0 0 0\nf 1 2 4\nf 5 4 2\n", 5, 2);
    expect_file_vertices("normals.obj",
                         "v 0 0 0\nv 1 1 0\nv 2 4 0\nv 3 9 0\nv 0 0 0\nvn 0 0 1\nvn 0 1 0\n"
                         "f 1//1 2//1 4//1\nf 5//2 4//2 2//1\n",
                         5, 2);
    expect_file_vertices("map.off", "OFF 5 2 0\n0 0 0\n1 1 0\n2 4 0\n3 9 0\n0 0 0\n3 0 1 3\n3 4 3 1\n", 5, 2);
    expect_file_vertices("map.ply",
                         "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
                         "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
                         "property list uchar float texcoord\nend_header\n0 0 0\n1 1 0\n2 4 0\n3 9 0\n0 0 0\n"
                         "3 0 1 3 6 0 0 1 0 1 1\n3 4 3 1 6 0 0 1 1 1 0\n",
                         5, 2);
    write_text("map.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                          "endloop\nendfacet\nendsolid a\n");
    svo_import *import = import_file("map.stl");
    size_t count = 1;
    assert_null(svo_import_file_vertices(import, &count));
    assert_int_equal(count, 0);
    svo_import_destroy(&import);
}

/* PLY and STL */

static void test_ply_with_colors_and_a_bad_index(void **unused)
{
    (void)unused;
    write_text("colored.ply", "ply\nformat ascii 1.0\nelement vertex 3\n"
                              "property float x\nproperty float y\nproperty float z\n"
                              "property float nx\nproperty float ny\nproperty float nz\n"
                              "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                              "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
                              "0.5 0.25 -8 0 0 1 255 0 0\n1 0 0 0 1 0 0 128 0\n0 1 nan 1 0 0 1 2 3\n"
                              "3 0 1 2\n3 0 1 77\n");
    svo_import *import = import_file("colored.ply");
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_int_equal(mesh->triangle_count, 2);
    expect_vector(corner(mesh, mesh->positions, 0, 0, 3), 0.5f, 0.25f, -8);
    expect_vector(corner(mesh, mesh->normals, 0, 1, 3), 0, 1, 0);
    expect_color(mesh, 0, 0, (const uint8_t[]){255, 0, 0, 255});
    expect_color(mesh, 0, 1, (const uint8_t[]){0, 128, 0, 255});
    expect_color(mesh, 0, 2, (const uint8_t[]){1, 2, 3, 255});
    assert_true(mesh->indices[5] >= mesh->vertex_count);
    svo_import_destroy(&import);
}

static void test_binary_stl(void **unused)
{
    (void)unused;
    uint8_t bytes[84 + 2 * 50] = {0};
    const uint32_t count = 2;
    memcpy(bytes + 80, &count, 4);
    const float facets[2][12] = {{0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 0}};
    memcpy(bytes + 84, facets[0], 48);
    memcpy(bytes + 134, facets[1], 48);
    write_bytes("two.stl", bytes, sizeof bytes);
    svo_import *import = import_file("two.stl");
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_int_equal(mesh->triangle_count, 2);
    assert_int_equal(mesh->vertex_count, 4);
    expect_vector(corner(mesh, mesh->positions, 1, 1, 3), 1, 1, 0);
    expect_vector(corner(mesh, mesh->normals, 1, 1, 3), 0, 0, 1);
    assert_int_equal(mesh->material_count, 0);
    svo_import_destroy(&import);
}

/* Files without a usable mesh */

static void test_unreadable_files(void **unused)
{
    (void)unused;
    expect_failure(path_of("missing.obj"), NULL, SVO_FILE_ERROR, strerror(ENOENT));
    expect_failure(work_folder(), NULL, SVO_FILE_ERROR, strerror(EISDIR));
    assert_int_equal(mkfifo(path_of("pipe.obj"), 0600), 0);
    work_folder_remember("pipe.obj");
    expect_failure(path_of("pipe.obj"), NULL, SVO_FILE_ERROR, "not a regular file");
    svo_message message = {""};
    svo_import *import = NULL;
    assert_int_equal(svo_import_file(NULL, NULL, NULL, NULL, &import, &message), SVO_INVALID_ARGUMENT);
    const svo_import_options wrong = {.struct_size = 1};
    assert_int_equal(svo_import_file("x", &wrong, NULL, NULL, &import, &message), SVO_INVALID_ARGUMENT);
}

static void test_files_without_a_mesh(void **unused)
{
    (void)unused;
    write_text("empty.obj", "");
    write_text("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n# no face at all, only vertices\n");
    write_text("garbage.xyzzy", "\x01\x02\x03 garbage that no reader knows");
    write_text("garbage.ply", "not a ply file");
    expect_failure(path_of("empty.obj"), NULL, SVO_IMPORT_FAILED, "");
    expect_failure(path_of("points.obj"), NULL, SVO_IMPORT_FAILED, "no triangles");
    expect_failure(path_of("garbage.xyzzy"), NULL, SVO_IMPORT_FAILED, "no mesh format that assimp knows");
    expect_failure(path_of("garbage.ply"), NULL, SVO_IMPORT_FAILED, "");
}

/* Children that misbehave */

static void write_plain(void)
{
    write_text("child.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
}

static void expect_misbehavior(const char *kind, const svo_import_options *options, const char *text)
{
    write_plain();
    assert_int_equal(setenv(MISBEHAVIOR, kind, 1), 0);
    expect_failure(path_of("child.obj"), options, SVO_IMPORT_FAILED, text);
    assert_int_equal(unsetenv(MISBEHAVIOR), 0);
}

static void test_children_that_misbehave(void **unused)
{
    (void)unused;
    const svo_import_options self = {.struct_size = sizeof self, .child_program = SELF};
    const svo_import_options second = {.struct_size = sizeof second, .time_limit_seconds = 1, .child_program = SELF};
    const svo_import_options small = {
        .struct_size = sizeof small, .memory_limit_bytes = 3 << 20, .child_program = SELF};
    expect_misbehavior("crash", &self, "the reader crashed (signal 11)");
    expect_misbehavior("silence", &self, "the reader ended without an answer, exit code 3");
    expect_misbehavior("nonsense", &self, "the reader's answer is damaged: it is not from an import child");
    expect_misbehavior("half", &self, "the reader's answer is damaged: it ends too early");
    expect_misbehavior("flood", &small, "the mesh needs more than 3.0 MiB");
    expect_misbehavior("hang", &second, "reading took longer than 1 s");
    expect_misbehavior("hang deaf", &second, "reading took longer than 1 s");
    expect_misbehavior("again", &self, "svo_import_child_main must come first");
}

/* Stops at its third call. */
static int stop_at_third(void *user, uint64_t byte_count)
{
    unsigned *calls = user;
    assert_true(byte_count == 0);
    return ++*calls == 3;
}

static int go_on(void *user, uint64_t byte_count)
{
    uint64_t *last = user;
    assert_true(byte_count >= *last);
    *last = byte_count;
    return 0;
}

static void test_the_progress_callback_stops_a_reader_that_hangs(void **unused)
{
    (void)unused;
    static const char *const kinds[] = {"hang", "hang deaf"};
    for (int i = 0; i < 2; ++i) {
        unsigned calls = 0;
        const svo_import_options asked = {
            .struct_size = sizeof asked, .child_program = SELF, .progress = stop_at_third, .progress_user = &calls};
        write_plain();
        assert_int_equal(setenv(MISBEHAVIOR, kinds[i], 1), 0);
        expect_failure(path_of("child.obj"), &asked, SVO_CANCELED, "the progress callback stopped the import");
        assert_int_equal(unsetenv(MISBEHAVIOR), 0);
        assert_int_equal(calls, 3);
    }
}

static void test_an_import_with_progress_reads_the_same(void **unused)
{
    (void)unused;
    uint64_t last = 0;
    svo_import *import = NULL;
    svo_message message = {""};
    const svo_import_options asked = {
        .struct_size = sizeof asked, .child_program = SELF, .progress = go_on, .progress_user = &last};
    write_plain();
    if (svo_import_file(path_of("child.obj"), &asked, NULL, NULL, &import, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    assert_true(svo_import_mesh(import)->triangle_count > 0);
    assert_true(last > 0);
    svo_import_destroy(&import);
}

/* 5 s, and 1 s for each 10^6 bytes of the file. A child repeats the limit that it was given. */
static void test_the_time_limit_grows_with_the_file(void **unused)
{
    (void)unused;
    const svo_import_options self = {.struct_size = sizeof self, .child_program = SELF};
    const size_t byte_count = 3000000;
    uint8_t *bytes = calloc(byte_count, 1);
    assert_non_null(bytes);
    expect_misbehavior("tell limit", &self, "limit 5");
    assert_int_equal(setenv(MISBEHAVIOR, "tell limit", 1), 0);
    write_bytes("long.obj", bytes, byte_count);
    expect_failure(path_of("long.obj"), &self, SVO_IMPORT_FAILED, "limit 8");
    write_bytes("long.obj", bytes, byte_count - 1);
    expect_failure(path_of("long.obj"), &self, SVO_IMPORT_FAILED, "limit 7");
    const svo_import_options given = {.struct_size = sizeof given, .time_limit_seconds = 77, .child_program = SELF};
    expect_failure(path_of("long.obj"), &given, SVO_IMPORT_FAILED, "limit 77");
    assert_int_equal(unsetenv(MISBEHAVIOR), 0);
    free(bytes);
}

/* 1 GiB, and 64 bytes for each of the file. */
static void test_the_memory_limit_grows_with_the_file(void **unused)
{
    (void)unused;
    const svo_import_options self = {.struct_size = sizeof self, .child_program = SELF};
    const svo_import_options given = {
        .struct_size = sizeof given, .memory_limit_bytes = 123456789, .child_program = SELF};
    expect_misbehavior("tell memory", &self, "limit 1073743872 grows"); /* of 32 bytes */
    expect_misbehavior("tell memory", &given, "limit 123456789 fixed");
    uint8_t *bytes = calloc(1000000, 1);
    assert_non_null(bytes);
    write_bytes("long.obj", bytes, 1000000);
    free(bytes);
    assert_int_equal(setenv(MISBEHAVIOR, "tell memory", 1), 0);
    expect_failure(path_of("long.obj"), &self, SVO_IMPORT_FAILED, "limit 1137741824 grows");
    assert_int_equal(unsetenv(MISBEHAVIOR), 0);
}

/* Of what unfolds, a small file may declare any number. */
static void test_the_memory_of_what_unfolds_has_an_end(void **unused)
{
    (void)unused;
    stream_work sum = {0, 0};
    assert_true(svo_i_stream_memory(&(stream_work){10, 0}) == 640);
    assert_true(svo_i_stream_memory(&(stream_work){10, 100}) == 640 + 1600);
    assert_true(svo_i_stream_memory(&(stream_work){10, UINT64_C(1) << 29}) == 640 + (UINT64_C(8) << 30));
    assert_true(svo_i_stream_memory(&(stream_work){10, (UINT64_C(1) << 29) + 1}) == 640 + (UINT64_C(8) << 30));
    assert_true(svo_i_stream_memory(&(stream_work){UINT64_MAX, UINT64_MAX}) == UINT64_MAX / 4 + (UINT64_C(8) << 30));
    svo_i_stream_add(&sum, &(stream_work){7, UINT64_MAX - 1});
    svo_i_stream_add(&sum, &(stream_work){8, 1});
    svo_i_stream_add(&sum, &(stream_work){9, 1});
    assert_true(sum.read_bytes == 24 && sum.made_bytes == UINT64_MAX);
}

/* Work that the child announces gives it more time: the first child is silent for longer than the limit, the second one
   hangs, and the third one's limit is of the file as a whole. */
static void test_the_time_limit_grows_with_announced_work(void **unused)
{
    (void)unused;
    static const struct {
        const char *kind;
        bool time_grows;
        svo_status expected;
        const char *text;
    } cases[] = {{"work", true, SVO_OK, ""},
                 {"work and hang", true, SVO_IMPORT_FAILED, "reading took longer than 2 s"},
                 {"work", false, SVO_IMPORT_FAILED, "reading took longer than 1 s"}};
    const svo_import_options options = {.struct_size = sizeof options,
                                        .memory_limit_bytes = UINT64_C(1) << 30,
                                        .time_limit_seconds = 1,
                                        .child_program = SELF};
    write_plain();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        svo_import import = {.byte_count = 0};
        svo_message message = {""};
        assert_int_equal(setenv(MISBEHAVIOR, cases[i].kind, 1), 0);
        const svo_status status = svo_i_import_run_child(
            path_of("child.obj"), &options, (import_growth){cases[i].time_grows, false}, &import, &message);
        assert_int_equal(unsetenv(MISBEHAVIOR), 0);
        svo_i_free(import.bytes);
        if (status != cases[i].expected || strstr(message.text, cases[i].text) == NULL) {
            fail_msg("%s: %s \"%s\", expected %s \"%s\"", cases[i].kind, svo_name(SVO_NAME_STATUS, status),
                     message.text, svo_name(SVO_NAME_STATUS, cases[i].expected), cases[i].text);
        }
    }
}

/* Without a child program the helper reads, and not the calling program, which may lack svo_import_child_main. */
static void test_the_helper_reads_by_default(void **unused)
{
    (void)unused;
    char helper[4096];
    svo_message message = {""};
    write_plain();
    assert_int_equal(setenv(MISBEHAVIOR, "crash", 1), 0);
    svo_import *import = import_file("child.obj");
    assert_int_equal(unsetenv(MISBEHAVIOR), 0);
    assert_int_equal(svo_import_mesh(import)->triangle_count, 1);
    svo_import_destroy(&import);
    assert_int_equal(svo_import_helper(helper, sizeof helper, &message), SVO_OK);
    assert_non_null(strstr(helper, "/libexec/svocl/svocl-import"));
    assert_int_equal(svo_import_helper(helper, 4, &message), SVO_FILE_ERROR);
    assert_non_null(strstr(message.text, "svocl-import"));
    assert_int_equal(svo_import_helper(NULL, 0, &message), SVO_INVALID_ARGUMENT);
}

static void test_a_child_that_cannot_start(void **unused)
{
    (void)unused;
    write_plain();
    const svo_import_options options = {.struct_size = sizeof options, .child_program = "/nonexistent/program"};
    expect_failure(path_of("child.obj"), &options, SVO_IMPORT_FAILED, "/nonexistent/program cannot be started");
}

/* A file that takes more than 24 MB to read: an OBJ of 6 MB. */
static void write_large(void)
{
    const size_t count = 200000;
    char *text = malloc(count * 128);
    assert_non_null(text);
    size_t end = 0;
    for (size_t i = 0; i < count; ++i) {
        end += (size_t)sprintf(text + end, "v %zu 0 1\n", i);
    }
    (void)sprintf(text + end, "f 1 2 3\n");
    write_text("large.obj", text);
    free(text);
}

/* A small OBJ, whose material library of 7 MB takes more than 34 MiB to read. */
static void write_many_materials(void)
{
    const size_t count = 60000;
    char *text = malloc(count * 128);
    assert_non_null(text);
    size_t end = 0;
    for (size_t i = 0; i < count; ++i) {
        end += (size_t)sprintf(text + end, "newmtl m%0100zu\nKd 1 0.5 0\n", i);
    }
    write_text("many.mtl", text);
    free(text);
    write_text("many.obj", "mtllib many.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n");
}

/* Builds with the address sanitizer cannot be limited. */
static void test_a_child_out_of_memory(void **unused)
{
    (void)unused;
    if (WITH_ADDRESS_SANITIZER) {
        skip();
    }
    write_large();
    const svo_import_options options = {.struct_size = sizeof options, .memory_limit_bytes = (uint64_t)16 << 20};
    expect_failure(path_of("large.obj"), &options, SVO_IMPORT_FAILED, "reading needs more than 16.0 MiB of memory");
}

/* What the child announces of other files gives it more memory, unless the limit is of the file as a whole. */
static void test_the_memory_limit_grows_with_announced_work(void **unused)
{
    (void)unused;
    if (WITH_ADDRESS_SANITIZER) {
        skip();
    }
    const svo_import_options options = {.struct_size = sizeof options,
                                        .memory_limit_bytes = UINT64_C(34) << 20,
                                        .time_limit_seconds = 60,
                                        .child_program = SELF};
    write_many_materials();
    for (int grows = 0; grows < 2; ++grows) {
        svo_message message = {""};
        svo_import import = {.byte_count = 0};
        svo_status status = svo_i_import_run_child(path_of("many.obj"), &options, (import_growth){false, grows != 0},
                                                   &import, &message);
        if (status == SVO_OK) {
            status = svo_i_stream_parse(&import, "many.obj", false, NULL, NULL, &message);
        }
        svo_i_free((void *)import.files);
        svo_i_free(import.bytes);
        if (status != (grows ? SVO_OK : SVO_IMPORT_FAILED) ||
            (!grows &&
             strstr(message.text, "reading needs more than 34.0 MiB of memory (memory_limit_bytes)") == NULL)) {
            fail_msg("%d: %s \"%s\"", grows, svo_name(SVO_NAME_STATUS, status), message.text);
        }
    }
}

/* A limit of the calling process that is lower holds for the child, and the message says whose it is. */
static void test_the_limit_of_the_process_holds(void **unused)
{
    (void)unused;
    if (WITH_ADDRESS_SANITIZER) {
        skip();
    }
    char helper[4096], script[4352], path[4096];
    svo_import *import = NULL;
    svo_message message = {""};
    assert_int_equal(svo_import_helper(helper, sizeof helper, &message), SVO_OK);
    (void)snprintf(script, sizeof script, "#!/bin/sh\nulimit -v 24000\nexec %s \"$@\"\n", helper);
    write_text("limited", script);
    (void)snprintf(path, sizeof path, "%s", path_of("limited"));
    assert_int_equal(chmod(path, 0700), 0);
    write_large();
    const svo_import_options options = {.struct_size = sizeof options, .child_program = path};
    const svo_status status = svo_import_file(path_of("large.obj"), &options, NULL, NULL, &import, &message);
    svo_import_destroy(&import);
    if (status != SVO_OUT_OF_HOST_MEMORY || strstr(message.text, "out of memory") == NULL ||
        strstr(message.text, "RLIMIT_AS (ulimit -v) is 23.4 MiB") == NULL) {
        fail_msg("%s \"%s\"", svo_name(SVO_NAME_STATUS, status), message.text);
    }
}

/* The caller's own handling of child processes must not matter. */
static void test_ignored_child_signals(void **unused)
{
    (void)unused;
    write_plain();
    void (*const handler)(int) = signal(SIGCHLD, SIG_IGN);
    svo_import *import = import_file("child.obj");
    assert_int_equal(svo_import_mesh(import)->triangle_count, 1);
    svo_import_destroy(&import);
    (void)signal(SIGCHLD, handler);
}

/* A damaged answer is either refused or gives a mesh whose arrays all lie inside it. A sanitizer proves the latter. */
static void test_damaged_answers(void **unused)
{
    (void)unused;
    write_picture("colors.png");
    write_text("shiny.mtl", "newmtl shiny\nKd 1 0.5 0.25\nKs 1 1 1\nNs 2\nmap_Kd colors.png\n");
    write_text("shiny.obj", "mtllib shiny.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl shiny\n"
                            "f 1/1/1 2/1/1 3/1/1\n");
    svo_import *good = import_file("shiny.obj");
    for (size_t i = 0; i < good->byte_count; ++i) {
        svo_import part = {.bytes = malloc(i + 1), .byte_count = i};
        assert_non_null(part.bytes);
        memcpy(part.bytes, good->bytes, i);
        assert_int_equal(svo_i_stream_parse(&part, "name", false, NULL, NULL, NULL), SVO_IMPORT_FAILED);
        svo_i_free(part.textures);
        free(part.bytes);
    }
    size_t refused = 0;
    for (size_t i = 0; i < 8 * good->byte_count; ++i) {
        svo_import flipped = {.bytes = malloc(good->byte_count), .byte_count = good->byte_count};
        assert_non_null(flipped.bytes);
        memcpy(flipped.bytes, good->bytes, good->byte_count);
        flipped.bytes[i / 8] ^= (uint8_t)(1u << (i % 8));
        svo_message message = {""};
        if (svo_i_stream_parse(&flipped, "name", false, NULL, NULL, &message) != SVO_OK) {
            assert_true(strncmp(message.text, "name: ", 6) == 0);
            ++refused;
        }
        svo_i_free(flipped.textures);
        free(flipped.bytes);
    }
    assert_true(refused > 0);
    svo_import_destroy(&good);
}

static void answer(const void *bytes, size_t byte_count)
{
    if (write(IMPORT_CHILD_STREAM, bytes, byte_count) < 0) {
        _exit(9);
    }
}

/* Runs this program as a child that misbehaves in the given way. */
static int misbehave(const char *kind, char **arguments)
{
    if (strcmp(kind, "crash") == 0) {
        (void)signal(SIGSEGV, SIG_DFL);
        (void)raise(SIGSEGV);
    } else if (strcmp(kind, "nonsense") == 0) {
        answer("nonsense, but long enough", 25);
    } else if (strcmp(kind, "half") == 0) {
        answer(STREAM_GREETING, STREAM_GREETING_BYTES);
    } else if (strcmp(kind, "flood") == 0) {
        static const uint8_t block[65536];
        for (;;) {
            answer(block, sizeof block);
        }
    } else if (strncmp(kind, "hang", 4) == 0) {
        if (kind[4] != '\0') {
            close(IMPORT_CHILD_STREAM);
        }
        pause();
    } else if (strncmp(kind, "work", 4) == 0) {
        const struct timespec silence = {.tv_sec = 1, .tv_nsec = 500000000};
        answer(STREAM_GREETING, STREAM_GREETING_BYTES);
        svo_i_stream_work(IMPORT_CHILD_STREAM, NULL,
                          kind[4] == '\0' ? (stream_work){900000000, 100000000} : (stream_work){400000, 600000});
        if (kind[4] != '\0') {
            pause();
        }
        nanosleep(&silence, NULL);
    } else if (strcmp(kind, "tell limit") == 0) {
        answer(STREAM_GREETING, STREAM_GREETING_BYTES);
        (void)svo_i_stream_text(IMPORT_CHILD_STREAM, STREAM_FAILURE, "limit %s", arguments[4]);
    } else if (strcmp(kind, "tell memory") == 0) {
        answer(STREAM_GREETING, STREAM_GREETING_BYTES);
        (void)svo_i_stream_text(IMPORT_CHILD_STREAM, STREAM_FAILURE, "limit %s %s", arguments[3], arguments[6]);
    } else if (strcmp(kind, "again") == 0) {
        /* Emulates a program without svo_import_child_main: it imports, and its child would do the same. */
        svo_message message = {""};
        svo_import *import = NULL;
        (void)svo_import_file(arguments[2], NULL, NULL, NULL, &import, &message);
        answer(STREAM_GREETING, STREAM_GREETING_BYTES);
        (void)svo_i_stream_text(IMPORT_CHILD_STREAM, STREAM_FAILURE, "%s", message.text);
    }
    return 3;
}

TEST_GROUP(import)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_obj_with_material_and_texture),
        cmocka_unit_test(test_normal_maps_of_obj),
        cmocka_unit_test(test_a_missing_texture_is_a_warning),
        cmocka_unit_test(test_plain_obj_has_no_attributes),
        cmocka_unit_test(test_degenerate_triangles_are_kept),
        cmocka_unit_test(test_vertices_are_joined_only_when_equal),
        cmocka_unit_test(test_missing_attributes_become_neutral),
        cmocka_unit_test(test_vertices_of_files_are_found_again),
        cmocka_unit_test(test_ply_with_colors_and_a_bad_index),
        cmocka_unit_test(test_binary_stl),
        cmocka_unit_test(test_unreadable_files),
        cmocka_unit_test(test_files_without_a_mesh),
        cmocka_unit_test(test_children_that_misbehave),
        cmocka_unit_test(test_the_progress_callback_stops_a_reader_that_hangs),
        cmocka_unit_test(test_an_import_with_progress_reads_the_same),
        cmocka_unit_test(test_the_time_limit_grows_with_the_file),
        cmocka_unit_test(test_the_time_limit_grows_with_announced_work),
        cmocka_unit_test(test_the_memory_limit_grows_with_the_file),
        cmocka_unit_test(test_the_memory_of_what_unfolds_has_an_end),
        cmocka_unit_test(test_the_memory_limit_grows_with_announced_work),
        cmocka_unit_test(test_the_limit_of_the_process_holds),
        cmocka_unit_test(test_the_helper_reads_by_default),
        cmocka_unit_test(test_a_child_that_cannot_start),
        cmocka_unit_test(test_a_child_out_of_memory),
        cmocka_unit_test(test_ignored_child_signals),
        cmocka_unit_test(test_damaged_answers),
    };
    return cmocka_run_group_tests_name("import", tests, work_folder_make, work_folder_remove);
}

/* The program is its own child that reads. */
int main(int argc, char **argv)
{
    const char *misbehavior = getenv(MISBEHAVIOR);
    if (misbehavior != NULL && argc == IMPORT_CHILD_ARGUMENT_COUNT) {
        return misbehave(misbehavior, argv);
    }
    int exit_code = 0;
    if (svo_import_child_main(argc, argv, &exit_code)) {
        return exit_code;
    }
    return suite_run(argc, argv);
}
