/* SPDX-License-Identifier: MIT */
/*
 * What mesh files rarely have: PLY's small and signed types, lists of floats, textures of vertices and of corners;
 * several material libraries and texture transforms of OBJ; names without a suffix; and a mistake in each place where a
 * reader looks for one.
 */
#define _XOPEN_SOURCE 700
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "support/import_check.h"
#include "support/suite.h"
#include "support/work_folder.h"

#define PLY_ASCII_BEGIN "ply\nformat ascii 1.0\n"
#define PLY_XYZ         "property float x\nproperty float y\nproperty float z\n"
#define PLY_FACES(n)    "element face " #n "\nproperty list uchar int vertex_indices\n"
#define PLY_TRIANGLE    "0 0 0\n1 0 0\n0 1 0\n"
/* A pentagon whose sides cross, so that no corner of it can be cut off. */
#define CROSSED "4 1 0\n3 4 0\n3 1 0\n3 2 0\n4 2 0\n"

static void write_picture(const char *name)
{
    write_text(name, "P6\n2 1\n255\nabcdef");
}

static void expect_color(const svo_mesh *mesh, size_t corner, uint8_t red, uint8_t green, uint8_t blue)
{
    const uint8_t expected[4] = {red, green, blue, 255};
    assert_non_null(mesh->colors);
    assert_memory_equal(mesh->colors + 4 * (size_t)mesh->indices[corner], expected, 4);
}

static void expect_uv(const svo_mesh *mesh, size_t corner, float u, float v)
{
    assert_non_null(mesh->uvs);
    const float *uv = mesh->uvs + 2 * (size_t)mesh->indices[corner];
    if (uv[0] != u || uv[1] != v) {
        fail_msg("corner %zu has uv %.9g %.9g, expected %.9g %.9g", corner, (double)uv[0], (double)uv[1], (double)u,
                 (double)v);
    }
}

/* ---- PLY ---- */

/* char: -127 .. 127 are 0 .. 254 of 255; short: -32767 .. 32767 are 0 .. 65534 of 65535. */
static void test_ply_signed_colors(void **unused)
{
    (void)unused;
    svo_import *import = import_text(
        "signed.ply", PLY_ASCII_BEGIN
        "element vertex 3\n" PLY_XYZ "property char red\nproperty short green\nproperty uchar blue\n" PLY_FACES(
            1) "end_header\n0 0 0 -127 -32767 7\n1 0 0 127 32767 8\n0 1 0 0 0 9\n3 0 1 2\n");
    const svo_mesh *mesh = svo_import_mesh(import);
    expect_color(mesh, 0, 0, 0, 7);
    expect_color(mesh, 1, 254, 255, 8);
    expect_color(mesh, 2, 127, 127, 9);
    expect_no_warning();
    svo_import_destroy(&import);
}

/* Each type of index, in binary files: 2, 0, 1. */
static void test_ply_types_of_indices(void **unused)
{
    (void)unused;
    static const struct {
        const char *type;
        uint8_t bytes[24];
        size_t byte_count;
    } rows[] = {{"char", {2, 0, 1}, 3},
                {"short", {2, 0, 0, 0, 1, 0}, 6},
                {"ushort", {2, 0, 0, 0, 1, 0}, 6},
                {"uint", {2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0}, 12},
                {"float", {0, 0, 0, 0x40, 0, 0, 0, 0, 0, 0, 0x80, 0x3f}, 12},
                {"double", {0, 0, 0, 0, 0, 0, 0, 0x40, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f}, 24}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        uint8_t bytes[512];
        static const uint8_t positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
        size_t used = (size_t)snprintf((char *)bytes, sizeof bytes,
                                       "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty uchar x\n"
                                       "property uchar y\nproperty uchar z\nelement face 1\n"
                                       "property list uchar %s vertex_indices\nend_header and more\n",
                                       rows[i].type);
        memcpy(bytes + used, positions, sizeof positions);
        used += sizeof positions;
        bytes[used++] = 3;
        memcpy(bytes + used, rows[i].bytes, rows[i].byte_count);
        used += rows[i].byte_count;
        write_bytes("types.ply", bytes, used);
        svo_import *import = import_named("types.ply");
        const svo_mesh *mesh = svo_import_mesh(import);
        assert_int_equal(mesh->triangle_count, 1);
        assert_memory_equal(mesh->positions + 3 * (size_t)mesh->indices[0], ((const float[]){0, 1, 0}), 12);
        assert_memory_equal(mesh->positions + 3 * (size_t)mesh->indices[2], ((const float[]){1, 0, 0}), 12);
        expect_no_warning();
        svo_import_destroy(&import);
        bytes[used] = 0;
        write_bytes("types.ply", bytes, used + 1);
        import = import_named("types.ply");
        expect_warning("1 bytes follow after the elements that are declared");
        svo_import_destroy(&import);
    }
}

/* A float that is no index: NaN and what is beyond any file. */
static void test_ply_floats_that_are_no_index(void **unused)
{
    (void)unused;
    static const char header[] = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty uchar x\n"
                                 "property uchar y\nproperty uchar z\nelement face 2\n"
                                 "property list uchar float vertex_indices\nend_header\n";
    uint8_t bytes[sizeof header + 64] = {0};
    const float indices[2][3] = {{0, 1, 2}, {0, 1, 1e30F}};
    memcpy(bytes, header, sizeof header - 1);
    size_t used = sizeof header - 1;
    bytes[used + 3] = bytes[used + 7] = 1;
    used += 9;
    for (size_t i = 0; i < 2; ++i) {
        bytes[used] = 3;
        memcpy(bytes + used + 1, indices[i], 12);
        used += 13;
    }
    write_bytes("beyond.ply", bytes, used);
    svo_import *import = import_named("beyond.ply");
    assert_int_equal(svo_import_mesh(import)->triangle_count, 2);
    expect_warning("1 of 2 faces name a vertex that does not exist; the first is face 1");
    svo_import_destroy(&import);
}

/* v = 0 is PLY's last row and svo_texture's first. */
static void test_ply_with_a_texture(void **unused)
{
    (void)unused;
    write_picture("ply.ppm");
    svo_import *import = import_text("vertices.ply", PLY_ASCII_BEGIN
                                     "comment TextureFile ply.ppm\n\nelement vertex 3\n" PLY_XYZ
                                     "property float s\nproperty float t\n" PLY_FACES(
                                         1) "end_header\n0 0 0 0 0.25\n1 0 0 1 0.25\n\n0 1 0 0.5 1\n3 0 1 2\n");
    const svo_mesh *mesh = svo_import_mesh(import);
    expect_uv(mesh, 0, 0, 0.75F);
    expect_uv(mesh, 2, 0.5F, 0);
    assert_int_equal(mesh->texture_count, 1);
    assert_int_equal(mesh->textures[0].width, 2);
    expect_no_warning();
    svo_import_destroy(&import);
    /* By corners: vertex 0 has two. */
    import = import_text("corners.ply",
                         PLY_ASCII_BEGIN "comment TextureFile ply.ppm\nelement vertex 4\n" PLY_XYZ
                                         "element face 2\nproperty list uchar int vertex_indices\n"
                                         "property list uchar float texcoord\nend_header\n" PLY_TRIANGLE "0 0 1\n"
                                         "3 0 1 2 6 0 0 1 0 0.5 1\n3 0 3 1 6 0.25 0 1 0 0.5 1\n");
    mesh = svo_import_mesh(import);
    assert_int_equal(mesh->triangle_count, 2);
    expect_uv(mesh, 0, 0, 1);
    expect_uv(mesh, 2, 0.5F, 0);
    expect_uv(mesh, 3, 0.25F, 1);
    expect_no_warning();
    svo_import_destroy(&import);
}

static void test_ply_and_off_without_a_suffix(void **unused)
{
    (void)unused;
    svo_import_info info = SVO_IMPORT_INFO_INIT;
    svo_import *import = import_text("some_mesh", PLY_ASCII_BEGIN
                                     "element vertex 3\n" PLY_XYZ PLY_FACES(1) "end_header\n" PLY_TRIANGLE "3 0 1 2\n");
    assert_int_equal(svo_import_get_info(import, &info), SVO_OK);
    assert_string_equal(info.reader, "ply");
    svo_import_destroy(&import);
    import = import_text("some_other", "OFF\n3 1 0\n" PLY_TRIANGLE "3 0 1 2\n");
    assert_int_equal(svo_import_get_info(import, &info), SVO_OK);
    assert_string_equal(info.reader, "off");
    svo_import_destroy(&import);
}

/* ---- OBJ and MTL ---- */

static void test_several_material_libraries(void **unused)
{
    (void)unused;
    write_text("one.mtl", "newmtl red\nKd 1 0 0\n");
    write_text("two.mtl", "newmtl gray\nKd 0.5\nd\nTr x\n");
    svo_import *import = import_text("two.obj", "mtllib one.mtl two.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
                                                "usemtl red\nf 1 2 3\nusemtl gray\nf 1 3 2\n");
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_int_equal(mesh->triangle_count, 2);
    assert_memory_equal(mesh->materials[mesh->triangle_materials[0]].rgba, ((const uint8_t[]){255, 0, 0, 255}), 4);
    assert_memory_equal(mesh->materials[mesh->triangle_materials[1]].rgba, ((const uint8_t[]){128, 128, 128, 255}), 4);
    expect_warning("two.mtl: 2 values are not read; the first is '");
    svo_import_destroy(&import);
    /* One of the names leads nowhere. */
    import = import_text("none.obj", "mtllib one.mtl nowhere.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n");
    expect_warning("line 1: material library one.mtl nowhere.mtl cannot be read");
    svo_import_destroy(&import);
    /* A folder is no library. */
    assert_int_equal(mkdir(path_of("folder.mtl"), 0700), 0);
    import = import_text("dir.obj", "mtllib folder.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    expect_warning("line 1: material library folder.mtl cannot be read");
    svo_import_destroy(&import);
    assert_int_equal(rmdir(path_of("folder.mtl")), 0);
}

/* Emission and the specular lobe; numbers that no light takes are tamed. */
static void test_finishes_of_materials(void **unused)
{
    (void)unused;
    write_text("lamp.mtl", "newmtl lamp\nKd 1 1 1\nKe 4 2.5 0.125\nKs 0.25\nNs 32\n"
                           "newmtl dull\nKd 1 1 1\nKe 0 0 0\nNs 96\n"
                           "newmtl odd\nKe -1 nan 1e39\nKs 2 -1 0.5\nNs -3\n");
    svo_import *import = import_text("lamp.obj", "mtllib lamp.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
                                                 "usemtl lamp\nf 1 2 3\nusemtl dull\nf 1 3 2\nusemtl odd\nf 2 1 3\n");
    const svo_mesh *mesh = svo_import_mesh(import);
    const svo_finish expected[3] = {{.emission = {4, 2.5F, 0.125F}, .specular = {0.25F, 0.25F, 0.25F}, .exponent = 32},
                                    {.exponent = 0},
                                    {.specular = {1, 0, 0.5F}}};
    assert_non_null(mesh->finishes);
    assert_int_equal(mesh->material_count, 3);
    for (size_t i = 0; i < 3; ++i) {
        assert_memory_equal(&mesh->finishes[mesh->triangle_materials[i]], &expected[i], sizeof expected[i]);
    }
    svo_import_destroy(&import);
    /* White lamps are materials still; without light and gloss they are none. */
    write_text("white.mtl", "newmtl white\nKd 1 1 1\nKe 1 1 1\n");
    import = import_text("white.obj", "mtllib white.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl white\nf 1 2 3\n");
    mesh = svo_import_mesh(import);
    assert_int_equal(mesh->material_count, 1);
    assert_true(mesh->finishes[0].emission[0] == 1.0F);
    svo_import_destroy(&import);
    write_text("white.mtl", "newmtl white\nKd 1 1 1\nNs 10\n");
    import = import_text("white.obj", "mtllib white.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl white\nf 1 2 3\n");
    mesh = svo_import_mesh(import);
    assert_int_equal(mesh->material_count, 0);
    assert_null(mesh->finishes);
    svo_import_destroy(&import);
}

/* As assimp writes it for a mesh without a material: white, as without one. */
static void test_the_default_material_is_none(void **unused)
{
    (void)unused;
    write_text("default.mtl", "newmtl DefaultMaterial\nKd 0.6 0.6 0.6\nnewmtl other\nKd 0.6 0.6 0.6\n");
    svo_import *import = import_text("default.obj", "mtllib default.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
                                                    "usemtl DefaultMaterial\nf 1 2 3\nusemtl other\nf 1 3 2\n");
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_memory_equal(mesh->materials[mesh->triangle_materials[0]].rgba, ((const uint8_t[]){255, 255, 255, 255}), 4);
    assert_memory_equal(mesh->materials[mesh->triangle_materials[1]].rgba, ((const uint8_t[]){153, 153, 153, 255}), 4);
    expect_no_warning();
    svo_import_destroy(&import);
}

/* The same corners in two materials whose textures lie otherwise are other vertices. */
static void test_texture_transforms_of_materials(void **unused)
{
    (void)unused;
    write_picture("obj.ppm");
    write_text("moved.mtl", "newmtl a\nmap_Kd -t 0.1 0.2 -mm 0 1 -bm 2 obj.ppm\n"
                            "newmtl b\nmap_Kd -o 0.25 0.5 0 -s 2 4 1 obj.ppm\n");
    svo_import *import = import_text("moved.obj", "mtllib moved.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
                                                  "vt 0 0\nvt 1 0\nvt 0 0.125\n"
                                                  "usemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1/1 2/2 3/3\n");
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_int_equal(mesh->vertex_count, 6);
    expect_uv(mesh, 0, 0, 1);
    expect_uv(mesh, 2, 0, 0.875F);
    expect_uv(mesh, 4, 2.25F, 0.5F);
    expect_uv(mesh, 5, 0.25F, 0);
    expect_no_warning();
    svo_import_destroy(&import);
}

static void test_a_backslash_within_a_line(void **unused)
{
    (void)unused;
    svo_import *import = import_text("slash.obj", "# C:\\temp\ng a\\b\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n#\\");
    assert_int_equal(svo_import_mesh(import)->triangle_count, 1);
    expect_no_warning();
    svo_import_destroy(&import);
}

/* ---- all ---- */

static void test_polygons_that_cross_themselves(void **unused)
{
    (void)unused;
    static const struct {
        const char *name, *text;
    } rows[] = {
        {"tie.obj", "v 4 1 0\nv 3 4 0\nv 3 1 0\nv 3 2 0\nv 4 2 0\nf 1 2 3 4 5\n"},
        {"tie.off", "OFF\n5 1 0\n" CROSSED "5 0 1 2 3 4\n"},
        {"tie.ply", PLY_ASCII_BEGIN "element vertex 5\n" PLY_XYZ PLY_FACES(1) "end_header\n" CROSSED "5 0 1 2 3 4\n"}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        svo_import *import = import_text(rows[i].name, rows[i].text);
        assert_int_equal(svo_import_mesh(import)->triangle_count, 3);
        expect_warning("1 polygons cross themselves; their triangles overlap");
        svo_import_destroy(&import);
    }
}

static void test_stl_leftovers(void **unused)
{
    (void)unused;
    uint8_t bytes[84 + 50 + 3] = {0};
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    bytes[80] = 1;
    memcpy(bytes + 84 + 12, corners, sizeof corners);
    write_bytes("left.stl", bytes, sizeof bytes);
    svo_import *import = import_named("left.stl");
    expect_warning("3 bytes follow after the 1 facets that are declared");
    svo_import_destroy(&import);
    /* Blank lines first; a facet of ten corners. */
    char text[1024] = "\n\n  solid a\nfacet normal 0 0 1\nouter loop\n";
    for (int i = 0; i < 10; ++i) {
        const size_t used = strlen(text);
        (void)snprintf(text + used, sizeof text - used, "vertex %d %d 0\n", i < 5 ? i : 9 - i, i < 5 ? i * i : 60 - i);
    }
    (void)strncat(text, "endloop\nendfacet\nendsolid a\n", sizeof text - strlen(text) - 1);
    import = import_text("loop.stl", text);
    assert_int_equal(svo_import_mesh(import)->triangle_count, 8);
    svo_import_destroy(&import);
}

static void test_small_faces_of_a_ply_are_a_warning(void **unused)
{
    (void)unused;
    svo_import *import = import_text("small.ply", PLY_ASCII_BEGIN "element vertex 3\n" PLY_XYZ PLY_FACES(
                                                      2) "end_header\n" PLY_TRIANGLE "2 0 1\n3 0 1 2\n");
    assert_int_equal(svo_import_mesh(import)->triangle_count, 1);
    expect_warning("1 of 2 faces have fewer than 3 corners");
    svo_import_destroy(&import);
}

static void test_mistakes(void **unused)
{
    (void)unused;
    static const char long_name[] = "property float "
                                    "a123456789a123456789a123456789a123456789a123456789a123456789a123";
    char long_header[256];
    (void)snprintf(long_header, sizeof long_header, "%selement vertex 1\n%s\n", PLY_ASCII_BEGIN, long_name);
    const struct {
        const char *name, *text, *error;
    } rows[] = {
        {"a.ply", PLY_ASCII_BEGIN "element vertex 0\n" PLY_XYZ "element vertex 0\n" PLY_XYZ "end_header\n",
         "element vertex is declared twice"},
        {"b.ply", PLY_ASCII_BEGIN "element vertex 3\nend_header\n", "element vertex has no property"},
        {"c.ply",
         PLY_ASCII_BEGIN "element vertex 1\n" PLY_XYZ "element tristrips 1\nproperty int a\nend_header\n0 0 0\n1\n",
         "element tristrips has no list vertex_indices"},
        {"d.ply", PLY_ASCII_BEGIN "element vertex 1\nproperty float \n",
         "line 4: a name of 0 bytes, which is not in 1 .. 63"},
        {"e.ply", long_header, "line 4: a name of 64 bytes, which is not in 1 .. 63"},
        {"f.ply", PLY_ASCII_BEGIN "property float x\n", "line 3: a property before the first element"},
        {"g.ply", PLY_ASCII_BEGIN "element face 1\nproperty list float int vertex_indices\n",
         "line 4: the length of list vertex_indices is no whole number"},
        {"h.ply", PLY_ASCII_BEGIN "element vertex 3\n" PLY_XYZ, "line 7: the file ends before end_header"},
        {"i.ply", PLY_ASCII_BEGIN "element vertex 2\n" PLY_XYZ "end_header\n0 0 0\n\n   \n \n    ",
         "the file ends in vertex 1 of 2"},
        {"j.ply",
         PLY_ASCII_BEGIN "element vertex 1\n" PLY_XYZ
                         "element other 1\nproperty list uchar int a\nend_header\n0 0 0\n3 1 2\n",
         "line 11: the line ends in other 0 of 1"},
        {"a.obj", "vn 1 2\n", "line 1: 'vn' with 2 numbers; 3 are needed"},
        {"b.obj", "v 0 0 0\nvt\n", "line 2: 'vt' with 0 numbers; 1 to 3 are needed"},
        {"a.off", "# nothing\n", "no OFF file: it is empty"},
        {"b.off", "COFFE\n", "line 1: 'COFFE' is none of the kinds [ST][C][N][4]OFF"},
        {"c.off", "OFF BINARY\n", "line 1: binary OFF is not read"},
        {"d.off", "OFF\n3 1 0\n0 0 0\n# and no more\n        ", "the file ends after 1 of 3 vertices"},
        {"e.off", "OFF\n3 1 0\n" PLY_TRIANGLE "3 0 1 x\n", "line 6: 'x' is no vertex index"},
        {"f.off", "OFF\n3 1 0\n" PLY_TRIANGLE "x 0 1 2\n", "line 6: 'x' is no number of corners"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        write_text(rows[i].name, rows[i].text);
        expect_refused(rows[i].name, NULL, rows[i].error);
    }
}

/* A binary file that ends within a list of an element that is skipped. */
static void test_a_skipped_list_that_ends_early(void **unused)
{
    (void)unused;
    static const char header[] = "ply\nformat binary_little_endian 1.0\nelement other 1\n"
                                 "property list uchar int a\nend_header\n";
    uint8_t bytes[sizeof header + 8] = {0};
    memcpy(bytes, header, sizeof header - 1);
    bytes[sizeof header - 1] = 2;
    write_bytes("skip.ply", bytes, sizeof header + 6);
    expect_refused("skip.ply", NULL, "the file ends in other 0 of 1");
}

static void test_limits_of_a_ply_header(void **unused)
{
    (void)unused;
    char text[8192] = PLY_ASCII_BEGIN;
    for (int i = 0; i < 33; ++i) {
        const size_t used = strlen(text);
        (void)snprintf(text + used, sizeof text - used, "element e%d 0\n", i);
    }
    write_text("elements.ply", text);
    expect_refused("elements.ply", NULL, "line 35: more than 32 elements");
    (void)snprintf(text, sizeof text, "%selement vertex 0\n", PLY_ASCII_BEGIN);
    for (int i = 0; i < 129; ++i) {
        const size_t used = strlen(text);
        (void)snprintf(text + used, sizeof text - used, "property float p%d\n", i);
    }
    write_text("properties.ply", text);
    expect_refused("properties.ply", NULL, "line 132: element vertex has more than 128 properties");
}

TEST_GROUP(import_unusual)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ply_signed_colors),
        cmocka_unit_test(test_ply_types_of_indices),
        cmocka_unit_test(test_ply_floats_that_are_no_index),
        cmocka_unit_test(test_ply_with_a_texture),
        cmocka_unit_test(test_ply_and_off_without_a_suffix),
        cmocka_unit_test(test_several_material_libraries),
        cmocka_unit_test(test_finishes_of_materials),
        cmocka_unit_test(test_the_default_material_is_none),
        cmocka_unit_test(test_texture_transforms_of_materials),
        cmocka_unit_test(test_a_backslash_within_a_line),
        cmocka_unit_test(test_polygons_that_cross_themselves),
        cmocka_unit_test(test_stl_leftovers),
        cmocka_unit_test(test_small_faces_of_a_ply_are_a_warning),
        cmocka_unit_test(test_mistakes),
        cmocka_unit_test(test_a_skipped_list_that_ends_early),
        cmocka_unit_test(test_limits_of_a_ply_header),
    };
    return cmocka_run_group_tests_name("import_unusual", tests, work_folder_make, work_folder_remove);
}
