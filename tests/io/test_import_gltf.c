/* SPDX-License-Identifier: MIT */
/*
 * glTF files written here are imported as the specification has them: accessors of every kind, nodes and instances,
 * colors, alpha and textures. What is not read is refused or named, and what contradicts itself is refused.
 */
#define _XOPEN_SOURCE 700
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <stb/stb_image_write.h>

#include "support/import_check.h"
#include "support/work_folder.h"

#include "io/import_gltf.h"
#include "io/import_stream.h"
#include "io/srgb.h"
#include "support/suite.h"

/* Defined in the library, but not declared in its header. The result is released by free. */
unsigned char *stbi_write_png_to_mem(const unsigned char *pixels, int stride_bytes, int x, int y, int n, int *out_len);

#define TEXT_BYTES 32768
#define BYTE       5120
#define UBYTE      5121
#define SHORT      5122
#define USHORT     5123
#define FLOAT      5126

/* 2 x 2 texels; their alpha is 255, 200, 100, 0. */
static const uint8_t picture[16] = {255, 0, 0, 255, 0, 255, 0, 200, 0, 0, 255, 100, 255, 255, 255, 0};

static const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

/* A file that is being put together: buffer, views and accessors. */
static struct {
    uint8_t bytes[8192];
    size_t byte_count;
    char views[4096], accessors[4096];
    int accessor_count;
} made;

static void begin(void)
{
    memset(&made, 0, sizeof made);
}

static void append(char *text, size_t text_bytes, const char *format, ...)
{
    va_list arguments;
    const size_t used = strlen(text);
    va_start(arguments, format);
    (void)vsnprintf(text + used, text_bytes - used, format, arguments);
    va_end(arguments);
    assert_true(strlen(text) + 1 < text_bytes);
}

/* Adds an accessor with a view of its own; more: other properties, stride: of the view, 0 is none. */
static int add_strided(const void *bytes, size_t byte_count, int component, const char *type, int count, int stride,
                       const char *more)
{
    while (made.byte_count % 4 != 0) {
        ++made.byte_count;
    }
    assert_true(made.byte_count + byte_count <= sizeof made.bytes);
    memcpy(made.bytes + made.byte_count, bytes, byte_count);
    append(made.views, sizeof made.views, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu",
           made.accessor_count > 0 ? "," : "", made.byte_count, byte_count);
    if (stride > 0) {
        append(made.views, sizeof made.views, ",\"byteStride\":%d", stride);
    }
    append(made.views, sizeof made.views, "}");
    append(made.accessors, sizeof made.accessors,
           "%s{\"bufferView\":%d,\"componentType\":%d,\"count\":%d,\"type\":\"%s\"%s}",
           made.accessor_count > 0 ? "," : "", made.accessor_count, component, count, type, more);
    made.byte_count += byte_count;
    return made.accessor_count++;
}

static int add(const void *bytes, size_t byte_count, int component, const char *type, int count, const char *more)
{
    return add_strided(bytes, byte_count, component, type, count, 0, more);
}

/* Writes NAME.gltf and NAME.bin; body: the rest of the JSON. */
static void finish_with(const char *name, const char *accessors, const char *body)
{
    static char text[TEXT_BYTES];
    char file[64];
    (void)snprintf(file, sizeof file, "%s.bin", name);
    write_bytes(file, made.bytes, made.byte_count);
    (void)snprintf(text, sizeof text,
                   "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],%s,\"accessors\":[%s],"
                   "\"bufferViews\":[%s],\"buffers\":[{\"byteLength\":%zu,\"uri\":\"%s\"}]}",
                   body, accessors, made.views, made.byte_count, file);
    (void)snprintf(file, sizeof file, "%s.gltf", name);
    write_text(file, text);
}

static svo_import *finish(const char *name, const char *body)
{
    char file[64];
    finish_with(name, made.accessors, body);
    (void)snprintf(file, sizeof file, "%s.gltf", name);
    return import_named(file);
}

/* Corner c of triangle t, in an attribute of width floats per vertex. */
static const float *corner(const svo_mesh *mesh, const float *attribute, size_t t, size_t c, size_t width)
{
    assert_non_null(attribute);
    const uint32_t vertex = mesh->indices[3 * t + c];
    assert_true(vertex < mesh->vertex_count);
    return attribute + width * vertex;
}

static void expect_near(const float *vector, double x, double y, double z)
{
    const double expected[3] = {x, y, z};
    for (int i = 0; i < 3; ++i) {
        if (!(fabs((double)vector[i] - expected[i]) < 1e-5)) {
            fail_msg("(%.9g, %.9g, %.9g), expected about (%.9g, %.9g, %.9g)", (double)vector[0], (double)vector[1],
                     (double)vector[2], x, y, z);
        }
    }
}

static void expect_vector(const float *vector, double x, double y, double z)
{
    if (vector[0] != (float)x || vector[1] != (float)y || vector[2] != (float)z) {
        fail_msg("(%.9g, %.9g, %.9g), expected (%.9g, %.9g, %.9g)", (double)vector[0], (double)vector[1],
                 (double)vector[2], (double)(float)x, (double)(float)y, (double)(float)z);
    }
}

static void expect_uv(const svo_mesh *mesh, size_t t, size_t c, double u, double v)
{
    const float *uv = corner(mesh, mesh->uvs, t, c, 2);
    if (fabs((double)uv[0] - u) > 1e-6 || fabs((double)uv[1] - v) > 1e-6) {
        fail_msg("uv (%.9g, %.9g), expected (%.9g, %.9g)", (double)uv[0], (double)uv[1], u, v);
    }
}

static void expect_color(const svo_mesh *mesh, size_t t, size_t c, const uint8_t expected[4])
{
    assert_non_null(mesh->colors);
    const uint8_t *color = mesh->colors + 4 * (size_t)mesh->indices[3 * t + c];
    if (memcmp(color, expected, 4) != 0) {
        fail_msg("color %d %d %d %d, expected %d %d %d %d", color[0], color[1], color[2], color[3], expected[0],
                 expected[1], expected[2], expected[3]);
    }
}

static const svo_material *material_of(const svo_mesh *mesh, size_t t)
{
    assert_non_null(mesh->triangle_materials);
    assert_true(mesh->triangle_materials[t] < mesh->material_count);
    return &mesh->materials[mesh->triangle_materials[t]];
}

static void append_base64(char *text, const uint8_t *bytes, size_t byte_count)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    size_t end = strlen(text);
    for (size_t i = 0; i < byte_count; i += 3) {
        const size_t left = byte_count - i;
        const uint32_t group = (uint32_t)bytes[i] << 16 | (uint32_t)(left > 1 ? bytes[i + 1] : 0) << 8 |
                               (uint32_t)(left > 2 ? bytes[i + 2] : 0);
        assert_true(end + 5 < TEXT_BYTES);
        for (size_t k = 0; k < 4; ++k) {
            text[end++] = k <= left ? digits[group >> (18 - 6 * k) & 63] : '=';
        }
        text[end] = '\0';
    }
}

/* One triangle with normals, uvs and colors, an embedded image, and the given nodes as JSON. */
static void write_gltf(const char *name, const char *nodes, const char *texture_extension)
{
    static const struct {
        float positions[9], normals[9], uvs[6], colors[12];
        uint16_t indices[4];
    } buffer = {{0, 0, 0, 1, 0, 0, 0, 1, 0},
                {0, 0.6f, 0.8f, 0, 0, 1, 0, 0, 1},
                {0, 0, 1, 0, 1, 1},
                {1, 0, 0, 1, 0, 0.5f, 0, 1, 0, 0, 1, 0.25f},
                {0, 1, 2, 0}};
    static char text[TEXT_BYTES];
    int image_bytes = 0;
    unsigned char *image = stbi_write_png_to_mem(picture, 8, 2, 2, 4, &image_bytes);
    assert_non_null(image);
    (void)snprintf(
        text, sizeof text,
        "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"KHR_texture_transform\"],\"scene\":0,"
        "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[%s],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":2,"
        "\"COLOR_0\":3},\"indices\":4,\"material\":0}]}],"
        "\"materials\":[{\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0.5,0.25,0.5],"
        "\"baseColorTexture\":{\"index\":0%s}},\"emissiveFactor\":[0.5,0.25,1]}],"
        "\"textures\":[{\"source\":0,\"sampler\":0}],\"samplers\":[{\"wrapS\":33648,\"wrapT\":33071}],"
        "\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
        "{\"bufferView\":2,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"},"
        "{\"bufferView\":3,\"componentType\":5126,\"count\":3,\"type\":\"VEC4\"},"
        "{\"bufferView\":4,\"componentType\":5123,\"count\":3,\"type\":\"SCALAR\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":36},"
        "{\"buffer\":0,\"byteOffset\":36,\"byteLength\":36},"
        "{\"buffer\":0,\"byteOffset\":72,\"byteLength\":24},"
        "{\"buffer\":0,\"byteOffset\":96,\"byteLength\":48},"
        "{\"buffer\":0,\"byteOffset\":144,\"byteLength\":6}],"
        "\"buffers\":[{\"byteLength\":%zu,\"uri\":\"data:application/octet-stream;base64,",
        nodes, texture_extension, sizeof buffer);
    append_base64(text, (const uint8_t *)&buffer, sizeof buffer);
    append(text, sizeof text, "\"}],\"images\":[{\"uri\":\"data:image/png;base64,");
    append_base64(text, image, (size_t)image_bytes);
    append(text, sizeof text, "\"}]}");
    free(image);
    write_text(name, text);
}

static void test_gltf_attributes(void **unused)
{
    (void)unused;
    write_gltf("one.gltf", "{\"mesh\":0}", "");
    svo_import *import = import_named("one.gltf");
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_int_equal(mesh->triangle_count, 1);
    expect_vector(corner(mesh, mesh->positions, 0, 1, 3), 1, 0, 0);
    expect_vector(corner(mesh, mesh->normals, 0, 0, 3), 0, 0.6f, 0.8f);
    expect_uv(mesh, 0, 0, 0, 0); /* glTF counts v from the first row, as svo_texture does */
    expect_uv(mesh, 0, 2, 1, 1);
    expect_color(mesh, 0, 1, (const uint8_t[]){0, 188, 0, 255});
    expect_color(mesh, 0, 2, (const uint8_t[]){0, 0, 255, 64});
    const svo_material *material = material_of(mesh, 0);
    assert_memory_equal(material->rgba, ((const uint8_t[]){255, 188, 137, 128}), 4);
    const svo_texture *texture = &mesh->textures[material->texture_index];
    assert_int_equal(texture->width, 2);
    assert_memory_equal(texture->rgba, picture, sizeof picture);
    assert_int_equal(texture->wrap_u, SVO_WRAP_MIRROR);
    assert_int_equal(texture->wrap_v, SVO_WRAP_CLAMP);
    assert_non_null(mesh->finishes);
    expect_vector(mesh->finishes[mesh->triangle_materials[0]].emission, 0.5f, 0.25f, 1);
    svo_import_destroy(&import);
}

/* The outer node is translated. The inner node scales x by 2, then rotates about z by a quarter turn. Both nodes have
   the mesh. */
static void test_gltf_nested_nodes(void **unused)
{
    (void)unused;
    write_gltf("nested.gltf",
               "{\"mesh\":0,\"translation\":[10,20,30],\"children\":[1]},"
               "{\"mesh\":0,\"rotation\":[0,0,0.70710678118,0.70710678118],\"scale\":[2,1,1]}",
               "");
    svo_import *import = import_named("nested.gltf");
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_int_equal(mesh->triangle_count, 2);
    expect_vector(corner(mesh, mesh->positions, 0, 1, 3), 11, 20, 30);
    expect_vector(corner(mesh, mesh->normals, 0, 0, 3), 0, 0.6f, 0.8f);
    expect_near(corner(mesh, mesh->positions, 1, 0, 3), 10, 20, 30);
    expect_near(corner(mesh, mesh->positions, 1, 1, 3), 10, 22, 30);
    expect_near(corner(mesh, mesh->positions, 1, 2, 3), 9, 20, 30);
    /* Up to scale, the normal is the inverse transpose of diag(2, 1, 1), rotated, times the determinant 2. */
    expect_near(corner(mesh, mesh->normals, 1, 0, 3), -1.2f, 0, 1.6f);
    svo_import_destroy(&import);
}

/* A mirrored triangle and its normal must still face the same side. */
static void test_gltf_mirrored_node(void **unused)
{
    (void)unused;
    write_gltf("mirror.gltf", "{\"mesh\":0,\"scale\":[1,1,-1]}", "");
    svo_import *import = import_named("mirror.gltf");
    const svo_mesh *mesh = svo_import_mesh(import);
    expect_vector(corner(mesh, mesh->positions, 0, 0, 3), 0, 0, 0);
    expect_vector(corner(mesh, mesh->positions, 0, 1, 3), 0, 1, 0);
    expect_vector(corner(mesh, mesh->positions, 0, 2, 3), 1, 0, 0);
    expect_near(corner(mesh, mesh->normals, 0, 0, 3), 0, 0.6f, -0.8f);
    svo_import_destroy(&import);
}

static void test_gltf_texture_transform(void **unused)
{
    (void)unused;
    write_gltf("transform.gltf", "{\"mesh\":0}",
               ",\"extensions\":{\"KHR_texture_transform\":{\"offset\":[0.5,0.125],\"scale\":[0.5,0.25]}}");
    svo_import *import = import_named("transform.gltf");
    const svo_mesh *mesh = svo_import_mesh(import);
    expect_uv(mesh, 0, 0, 0.5f, 0.125f);
    expect_uv(mesh, 0, 2, 1, 0.375f);
    svo_import_destroy(&import);
}

/* Turned by a quarter, counterclockwise as seen, where v points down. */
static void test_gltf_texture_rotation(void **unused)
{
    (void)unused;
    write_gltf("rotation.gltf", "{\"mesh\":0}",
               ",\"extensions\":{\"KHR_texture_transform\":{\"offset\":[0,1],\"rotation\":1.57079632679}}");
    svo_import *import = import_named("rotation.gltf");
    const svo_mesh *mesh = svo_import_mesh(import);
    expect_uv(mesh, 0, 0, 0, 1);
    expect_uv(mesh, 0, 1, 0, 0);
    expect_uv(mesh, 0, 2, 1, 0);
    expect_no_warning();
    svo_import_destroy(&import);
}

/* ---- accessors ---- */

/* What optimizers write: integers in place of floats, in interleaved views. */
static void test_quantized_attributes(void **unused)
{
    (void)unused;
    static const struct {
        int16_t position[4];
        int8_t normal[4];
        uint16_t uv[2];
    } vertices[3] = {{{-32768, 0, 100, 0}, {0, 0, 127, 0}, {0, 65535}},
                     {{32767, 1, 2, 0}, {-128, 0, 0, 0}, {32768, 0}},
                     {{3, 20000, -7, 0}, {0, 64, 0, 0}, {1, 2}}};
    const char *body = "\"extensionsUsed\":[\"KHR_mesh_quantization\"],"
                       "\"extensionsRequired\":[\"KHR_mesh_quantization\"],\"nodes\":[{\"mesh\":0}],"
                       "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":2},"
                       "\"material\":0}]}],\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":"
                       "{\"index\":0}}}],\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"two%20words.png\"}]";
    assert_int_not_equal(stbi_write_png(path_of("two words.png"), 2, 2, 4, picture, 8), 0);
    work_folder_remember("two words.png");
    for (int normalized = 0; normalized < 2; ++normalized) {
        const char *more = normalized != 0 ? ",\"normalized\":true" : "";
        begin();
        add_strided(&vertices[0].position, sizeof vertices, SHORT, "VEC3", 3, sizeof vertices[0], more);
        add_strided(&vertices[0].normal, sizeof vertices - 8, BYTE, "VEC3", 3, sizeof vertices[0],
                    ",\"normalized\":true");
        add_strided(&vertices[0].uv, sizeof vertices - 12, USHORT, "VEC2", 3, sizeof vertices[0],
                    ",\"normalized\":true");
        svo_import *import = finish("quantized", body);
        const svo_mesh *mesh = svo_import_mesh(import);
        const double unit = normalized != 0 ? 32767 : 1;
        expect_no_warning();
        expect_vector(corner(mesh, mesh->positions, 0, 0, 3), normalized != 0 ? -1 : -32768, 0, 100 / unit);
        expect_vector(corner(mesh, mesh->positions, 0, 1, 3), 32767 / unit, 1 / unit, 2 / unit);
        expect_vector(corner(mesh, mesh->positions, 0, 2, 3), 3 / unit, 20000 / unit, -7 / unit);
        expect_vector(corner(mesh, mesh->normals, 0, 1, 3), -1, 0, 0);
        expect_vector(corner(mesh, mesh->normals, 0, 2, 3), 0, 64 / 127.0, 0);
        expect_uv(mesh, 0, 0, 0, 1);
        expect_uv(mesh, 0, 1, 32768 / 65535.0, 0);
        svo_import_info info = SVO_IMPORT_INFO_INIT;
        assert_int_equal(svo_import_get_info(import, &info), SVO_OK);
        assert_string_equal(info.reader, "gltf");
        svo_import_destroy(&import);
    }
}

/* Bytes and unsigned types, with the scale of a node that undoes the quantization: rounded once. */
static void test_quantized_types(void **unused)
{
    (void)unused;
    static const uint8_t ubytes[12] = {0, 0, 0, 0, 255, 3, 0, 0, 0, 254, 0, 0};
    static const int8_t bytes[12] = {-128, 0, 0, 0, 127, 3, 0, 0, 0, -127, 0, 0};
    static const uint16_t ushorts[12] = {0, 0, 0, 0, 65535, 3, 0, 0, 0, 65534, 0, 0};
    static const struct {
        const void *values;
        int component, stride;
        double first, unit;
    } cases[] = {{ubytes, UBYTE, 4, 0, 255}, {bytes, BYTE, 4, -1, 127}, {ushorts, USHORT, 8, 0, 65535}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        begin();
        add_strided(cases[i].values, (size_t)cases[i].stride * 3, cases[i].component, "VEC3", 3, cases[i].stride,
                    ",\"normalized\":true");
        svo_import *import = finish("types", "\"nodes\":[{\"mesh\":0,\"scale\":[3,3,3],\"translation\":[5,0,0]}],"
                                             "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]");
        const svo_mesh *mesh = svo_import_mesh(import);
        expect_vector(corner(mesh, mesh->positions, 0, 0, 3), 5 + 3 * cases[i].first, 0, 0);
        expect_vector(corner(mesh, mesh->positions, 0, 1, 3), 8, 3 / cases[i].unit * 3, 0);
        svo_import_destroy(&import);
    }
}

static void test_sparse_accessors(void **unused)
{
    (void)unused;
    static const uint8_t places[4] = {2, 0};
    static const float values[6] = {7, 8, 9, -1, -2, -3};
    char accessors[512];
    for (int viewless = 0; viewless < 2; ++viewless) {
        begin();
        add(triangle, sizeof triangle, FLOAT, "VEC3", 3, "");
        add(places, sizeof places, UBYTE, "SCALAR", 2, "");
        add(values, sizeof values, FLOAT, "VEC3", 2, "");
        (void)snprintf(accessors, sizeof accessors,
                       "{%s\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"sparse\":{\"count\":2,"
                       "\"indices\":{\"bufferView\":1,\"componentType\":5121},\"values\":{\"bufferView\":2}}}",
                       viewless != 0 ? "" : "\"bufferView\":0,");
        finish_with("sparse", accessors,
                    "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":"
                    "{\"POSITION\":0}}]}]");
        svo_import *import = import_named("sparse.gltf");
        const svo_mesh *mesh = svo_import_mesh(import);
        expect_vector(corner(mesh, mesh->positions, 0, 0, 3), -1, -2, -3);
        expect_vector(corner(mesh, mesh->positions, 0, 1, 3), viewless != 0 ? 0 : 1, 0, 0);
        expect_vector(corner(mesh, mesh->positions, 0, 2, 3), 7, 8, 9);
        svo_import_destroy(&import);
    }
}

/* Strips and fans with indices of each type, and without; points and lines are named. */
static void test_modes(void **unused)
{
    (void)unused;
    static const float points[15] = {0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 4, 0, 0};
    static const uint8_t narrow[5] = {0, 1, 2, 3, 4};
    static const uint32_t wide[5] = {4, 3, 2, 1, 9};
    begin();
    add(points, sizeof points, FLOAT, "VEC3", 5, "");
    add(narrow, sizeof narrow, UBYTE, "SCALAR", 5, "");
    add(wide, sizeof wide, 5125, "SCALAR", 5, "");
    svo_import *import = finish("modes", "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":["
                                         "{\"mode\":5,\"attributes\":{\"POSITION\":0},\"indices\":1},"
                                         "{\"mode\":6,\"attributes\":{\"POSITION\":0}},"
                                         "{\"mode\":4,\"attributes\":{\"POSITION\":0},\"indices\":2},"
                                         "{\"mode\":5,\"attributes\":{\"POSITION\":0},\"indices\":2},"
                                         "{\"mode\":0,\"attributes\":{\"POSITION\":0}},"
                                         "{\"mode\":1,\"attributes\":{\"POSITION\":0}},"
                                         "{\"mode\":2,\"attributes\":{\"POSITION\":0}},"
                                         "{\"mode\":3,\"attributes\":{\"POSITION\":0}}]}]");
    const svo_mesh *mesh = svo_import_mesh(import);
    static const float expected[][3] = {{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {0, 1, 2}, {0, 2, 3},
                                        {0, 3, 4}, {4, 3, 2}, {4, 3, 2}, {2, 3, 1}};
    assert_int_equal(mesh->triangle_count, 10); /* the last one has a vertex that does not exist */
    for (size_t t = 0; t < 9; ++t) {
        for (size_t c = 0; c < 3; ++c) {
            assert_true(corner(mesh, mesh->positions, t, c, 3)[0] == expected[t][c]);
        }
    }
    assert_true(mesh->indices[29] >= mesh->vertex_count);
    expect_warning("16 points and lines are left out");
    expect_warning("2 corners are too few for a triangle");
    expect_warning("1 triangles name a vertex that does not exist");
    svo_import_destroy(&import);
}

/* ---- instances ---- */

static void test_instances(void **unused)
{
    (void)unused;
    static const float moves[9] = {0, 0, 0, 10, 0, 0, 0, 20, 0};
    static const int16_t turns[12] = {0, 0, 0, 32767, 0, 0, 23170, 23170, 0, 0, 0, 32767};
    static const float scales[9] = {1, 1, 1, 2, 2, 2, 1, 1, -1};
    begin();
    add(triangle, sizeof triangle, FLOAT, "VEC3", 3, "");
    add(moves, sizeof moves, FLOAT, "VEC3", 3, "");
    add(turns, sizeof turns, SHORT, "VEC4", 3, ",\"normalized\":true");
    add(scales, sizeof scales, FLOAT, "VEC3", 3, "");
    svo_import *import =
        finish("instances", "\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"],"
                            "\"extensionsRequired\":[\"EXT_mesh_gpu_instancing\"],"
                            "\"nodes\":[{\"mesh\":0,\"translation\":[100,0,0],\"children\":[1],\"extensions\":"
                            "{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":1,\"ROTATION\":2,"
                            "\"SCALE\":3,\"_ID\":1}}}},{\"mesh\":0}],"
                            "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]");
    const svo_mesh *mesh = svo_import_mesh(import);
    expect_no_warning();
    assert_int_equal(mesh->triangle_count, 4); /* three instances; the child has none of its own */
    expect_vector(corner(mesh, mesh->positions, 0, 1, 3), 101, 0, 0);
    expect_near(corner(mesh, mesh->positions, 1, 0, 3), 110, 0, 0);
    expect_near(corner(mesh, mesh->positions, 1, 1, 3), 110, 2, 0);
    expect_near(corner(mesh, mesh->positions, 1, 2, 3), 108, 0, 0);
    expect_near(corner(mesh, mesh->positions, 2, 0, 3), 100, 20, 0);
    expect_near(corner(mesh, mesh->positions, 2, 1, 3), 100, 21, 0); /* mirrored: the other way round */
    expect_near(corner(mesh, mesh->positions, 2, 2, 3), 101, 20, 0);
    expect_vector(corner(mesh, mesh->positions, 3, 1, 3), 101, 0, 0);
    svo_import_destroy(&import);
    finish_with("uneven", made.accessors,
                "\"nodes\":[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":"
                "{\"TRANSLATION\":1,\"ROTATION\":3}}}}],\"meshes\":[{\"primitives\":[{\"attributes\":"
                "{\"POSITION\":0}}]}]");
    expect_refused("uneven.gltf", NULL, "accessor 3 does not fit the other attributes of the instances");
}

/* ---- extensions ---- */

static void write_extension(const char *list, const char *name)
{
    char body[512];
    begin();
    add(triangle, sizeof triangle, FLOAT, "VEC3", 3, "");
    (void)snprintf(body, sizeof body,
                   "\"%s\":[\"%s\"],\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":"
                   "{\"POSITION\":0}}]}]",
                   list, name);
    finish_with("extension", made.accessors, body);
}

static void test_extensions(void **unused)
{
    (void)unused;
    static const char *const refused[] = {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_texture_basisu",
                                          "KHR_materials_transmission", "ACME_of_tomorrow"};
    static const char *const silent[] = {"KHR_materials_clearcoat", "KHR_materials_ior", "KHR_lights_punctual",
                                         "EXT_meshopt_compression", "KHR_mesh_quantization"};
    static const char *const named[] = {"KHR_materials_transmission", "KHR_node_visibility", "ACME_of_tomorrow"};
    const svo_import_options strict = {.struct_size = sizeof strict, .strict = 1};
    char text[128];
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; ++i) {
        write_extension("extensionsRequired", refused[i]);
        (void)snprintf(text, sizeof text, "the file needs the glTF extension %s, which is not read", refused[i]);
        expect_refused("extension.gltf", NULL, text);
    }
    for (size_t i = 0; i < sizeof silent / sizeof silent[0]; ++i) {
        write_extension("extensionsUsed", silent[i]);
        svo_import *import = import_named("extension.gltf");
        expect_no_warning();
        svo_import_destroy(&import);
    }
    for (size_t i = 0; i < sizeof named / sizeof named[0]; ++i) {
        write_extension("extensionsUsed", named[i]);
        (void)snprintf(text, sizeof text, "the glTF extension %s is not read", named[i]);
        svo_import *import = import_named("extension.gltf");
        expect_warning(text);
        svo_import_destroy(&import);
        expect_refused("extension.gltf", &strict, text);
    }
}

/* ---- colors ---- */

/* Light to bytes as the curve says, by its formula in other functions. */
static void test_linear_colors_become_srgb(void **unused)
{
    (void)unused;
    for (int i = 0; i <= 100000; ++i) {
        const double linear = i / 100000.0;
        const double coded = linear < 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
        const double byte = svo_i_srgb_byte(linear);
        if (fabs(byte - coded * 255) > 0.5 + 1e-9) {
            fail_msg("%.9g became %g, expected about %.9g", linear, byte, coded * 255);
        }
    }
    assert_int_equal(svo_i_srgb_byte(0.5), 188);
    assert_int_equal(svo_i_srgb_byte(-1), 0);
    assert_int_equal(svo_i_srgb_byte(NAN), 0);
    assert_int_equal(svo_i_srgb_byte(7), 255);
    for (int i = 0; i < 256; ++i) {
        assert_int_equal(svo_i_srgb_byte((double)(float)svo_i_srgb_linear((uint8_t)i)), i);
    }
}

/* Three components have no alpha, of whatever type; a mode that ignores alpha ignores that of each source. */
static void test_alpha(void **unused)
{
    (void)unused;
    static const float rgb[9] = {1, 0, 0, 0, 0.5f, 0, 0, 0, 1};
    static const uint16_t rgba[12] = {65535, 0, 0, 13107, 0, 65535, 0, 32768, 0, 0, 65535, 65535};
    static const struct {
        const char *mode;
        uint8_t base, corners[3], texels[4];
    } cases[] = {{"", 255, {255, 255, 255}, {255, 255, 255, 255}},
                 {"\"alphaMode\":\"OPAQUE\",", 255, {255, 255, 255}, {255, 255, 255, 255}},
                 {"\"alphaMode\":\"BLEND\",", 204, {51, 128, 255}, {255, 200, 100, 0}},
                 {"\"alphaMode\":\"MASK\",", 255, {0, 0, 255}, {255, 255, 0, 0}},
                 {"\"alphaMode\":\"MASK\",\"alphaCutoff\":0.3,", 255, {0, 255, 255}, {255, 255, 255, 0}},
                 {"\"alphaMode\":\"MASK\",\"alphaCutoff\":0.9,", 0, {0, 0, 0}, {0, 0, 0, 0}}};
    char body[1024];
    assert_int_not_equal(stbi_write_png(path_of("alpha.png"), 2, 2, 4, picture, 8), 0);
    work_folder_remember("alpha.png");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        begin();
        add(triangle, sizeof triangle, FLOAT, "VEC3", 3, "");
        add(rgb, sizeof rgb, FLOAT, "VEC3", 3, "");
        add(rgba, sizeof rgba, USHORT, "VEC4", 3, ",\"normalized\":true");
        add(triangle, 24, FLOAT, "VEC2", 3, "");
        (void)snprintf(body, sizeof body,
                       "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":["
                       "{\"attributes\":{\"POSITION\":0,\"COLOR_0\":1},\"material\":0},"
                       "{\"attributes\":{\"POSITION\":0,\"COLOR_0\":2,\"TEXCOORD_0\":3},\"material\":0}]}],"
                       "\"materials\":[{%s\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0.5,0,0.8],"
                       "\"baseColorTexture\":{\"index\":0}}}],\"textures\":[{\"source\":0}],"
                       "\"images\":[{\"uri\":\"alpha.png\"}]",
                       cases[i].mode);
        svo_import *import = finish("alpha", body);
        const svo_mesh *mesh = svo_import_mesh(import);
        const uint8_t last = cases[i].corners[2];
        expect_color(mesh, 0, 0, (const uint8_t[]){255, 0, 0, last});
        expect_color(mesh, 0, 1, (const uint8_t[]){0, 188, 0, last});
        expect_color(mesh, 1, 0, (const uint8_t[]){255, 0, 0, cases[i].corners[0]});
        expect_color(mesh, 1, 1, (const uint8_t[]){0, 255, 0, cases[i].corners[1]});
        expect_color(mesh, 1, 2, (const uint8_t[]){0, 0, 255, last});
        const svo_material *material = material_of(mesh, 1);
        assert_memory_equal(material->rgba, ((const uint8_t[]){255, 188, 0, cases[i].base}), 4);
        for (size_t k = 0; k < 4; ++k) {
            assert_int_equal(mesh->textures[material->texture_index].rgba[4 * k + 3], cases[i].texels[k]);
        }
        assert_int_equal(material_of(mesh, 0)->texture_index, SVO_NO_TEXTURE);
        svo_import_destroy(&import);
    }
}

static void test_emission_and_gloss(void **unused)
{
    (void)unused;
    begin();
    add(triangle, sizeof triangle, FLOAT, "VEC3", 3, "");
    svo_import *import =
        finish("finish", "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},"
                         "\"material\":0}]}],\"materials\":[{\"emissiveFactor\":[1,0.5,0],\"extensions\":{"
                         "\"KHR_materials_emissive_strength\":{\"emissiveStrength\":4},"
                         "\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseFactor\":[0.5,0,0,1],"
                         "\"specularFactor\":[0.25,0.25,0.25],\"glossinessFactor\":0.5}}}]");
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_memory_equal(material_of(mesh, 0)->rgba, ((const uint8_t[]){188, 0, 0, 255}), 4);
    expect_vector(mesh->finishes[0].emission, 4, 2, 0);
    expect_vector(mesh->finishes[0].specular, 0.25, 0.25, 0.25);
    assert_true(mesh->finishes[0].exponent == 500);
    svo_import_destroy(&import);
}

/* Normal textures with a scale; one whose coordinates are those of another set than the color's is left out. */
static void test_normal_textures(void **unused)
{
    (void)unused;
    static const svo_import_options with_maps = {.struct_size = sizeof with_maps, .normal_maps = 1};
    static const float uvs[6] = {0, 0, 1, 0, 1, 1};
    static const char materials[] = "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":["
                                    "{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"material\":0},"
                                    "{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"material\":1}]}],"
                                    "\"materials\":[{\"normalTexture\":{\"index\":0,\"scale\":0.5}},"
                                    "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}},"
                                    "\"normalTexture\":{\"index\":0,\"texCoord\":1}}],"
                                    "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"data:image/png;base64,";
    char body[4096];
    int image_bytes = 0;
    unsigned char *image = stbi_write_png_to_mem(picture, 8, 2, 2, 4, &image_bytes);
    assert_non_null(image);
    begin();
    add(triangle, sizeof triangle, FLOAT, "VEC3", 3, "");
    add(uvs, sizeof uvs, FLOAT, "VEC2", 3, "");
    (void)snprintf(body, sizeof body, "%s", materials);
    append_base64(body, image, (size_t)image_bytes);
    free(image);
    append(body, sizeof body, "\"}]");
    finish_with("maps", made.accessors, body);
    svo_import *import = import_with("maps.gltf", &with_maps);
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_non_null(mesh->normal_maps);
    assert_true(mesh->normal_maps[0].scale == 0.5F);
    assert_memory_equal(mesh->textures[mesh->normal_maps[0].texture_index].rgba, picture, sizeof picture);
    assert_int_equal(mesh->normal_maps[1].texture_index, SVO_NO_TEXTURE);
    expect_uv(mesh, 0, 2, 1, 1);
    expect_warning("a normal map lies otherwise than the color and is left out");
    svo_import_destroy(&import);
}

/* ---- files ---- */

/* Binary glTF by its suffix, and by its first bytes where a name says nothing. */
static void test_binary_files(void **unused)
{
    (void)unused;
    static const char json[] =
        "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,"
        "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
        "\"buffers\":[{\"byteLength\":36}]}   ";
    const uint32_t json_bytes = (uint32_t)(sizeof json - 1) / 4 * 4;
    const uint32_t words[5] = {0x46546c67, 2, 28 + json_bytes + 36, json_bytes, 0x4e4f534a};
    const uint32_t chunk[2] = {36, 0x004e4942};
    uint8_t bytes[1024];
    memcpy(bytes, words, 20);
    memcpy(bytes + 20, json, json_bytes);
    memcpy(bytes + 20 + json_bytes, chunk, 8);
    memcpy(bytes + 28 + json_bytes, triangle, 36);
    static const char *const names[] = {"binary.glb", "binary.model"};
    for (size_t i = 0; i < 2; ++i) {
        write_bytes(names[i], bytes, words[2]);
        svo_import *import = import_named(names[i]);
        expect_vector(corner(svo_import_mesh(import), svo_import_mesh(import)->positions, 0, 1, 3), 1, 0, 0);
        svo_import_destroy(&import);
    }
    write_bytes("cut.glb", bytes, words[2] - 1);
    expect_refused("cut.glb", NULL, "a chunk of 36 bytes in a file of");
}

/* glTF 1.0 is another format, which assimp knows. */
static void test_older_files(void **unused)
{
    (void)unused;
    write_bytes("older.bin", triangle, sizeof triangle);
    svo_import *import =
        import_text("older.gltf",
                    "{\"asset\":{\"version\":\"1.0\"},\"scene\":\"s\",\"scenes\":{\"s\":{\"nodes\":[\"n\"]}},"
                    "\"nodes\":{\"n\":{\"meshes\":[\"m\"]}},\"meshes\":{\"m\":{\"primitives\":[{\"attributes\":"
                    "{\"POSITION\":\"a\"},\"mode\":4}]}},\"accessors\":{\"a\":{\"bufferView\":\"v\",\"byteOffset\":0,"
                    "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}},\"bufferViews\":{\"v\":{\"buffer\":\"b\","
                    "\"byteOffset\":0,\"byteLength\":36}},\"buffers\":{\"b\":{\"uri\":\"older.bin\",\"byteLength\":36,"
                    "\"type\":\"arraybuffer\"}}}");
    svo_import_info info = SVO_IMPORT_INFO_INIT;
    assert_int_equal(svo_import_get_info(import, &info), SVO_OK);
    assert_string_equal(info.reader, "assimp");
    assert_int_equal(info.triangles, 1);
    svo_import_destroy(&import);
}

/* The child says how much it reads besides the file, and how much that becomes: buffer, image, texels. */
static void test_other_files_are_announced(void **unused)
{
    (void)unused;
    static const uint8_t texels[64 * 32 * 4];
    stream_work announced = {0, 0};
    int image_bytes = 0;
    unsigned char *image = stbi_write_png_to_mem(texels, 256, 64, 32, 4, &image_bytes);
    assert_non_null(image);
    write_bytes("large.png", image, (size_t)image_bytes);
    free(image);
    begin();
    add(triangle, sizeof triangle, FLOAT, "VEC3", 3, "");
    add(triangle, 24, FLOAT, "VEC2", 3, "");
    svo_import *import =
        finish("announced", "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,"
                            "\"TEXCOORD_0\":1},\"material\":0}]}],\"materials\":[{\"pbrMetallicRoughness\":"
                            "{\"baseColorTexture\":{\"index\":0}}}],\"textures\":[{\"source\":0}],"
                            "\"images\":[{\"uri\":\"large.png\"}]");
    for (size_t at = STREAM_GREETING_BYTES; at + sizeof(stream_frame) <= import->byte_count;) {
        stream_frame frame;
        stream_work work;
        memcpy(&frame, import->bytes + at, sizeof frame);
        if (frame.kind == STREAM_WORK) {
            memcpy(&work, import->bytes + at + sizeof frame, sizeof work);
            svo_i_stream_add(&announced, &work);
        }
        at += sizeof frame + (frame.payload_bytes + 7) / 8 * 8;
    }
    assert_int_equal(announced.read_bytes, 60 + (uint64_t)image_bytes);
    assert_int_equal(announced.made_bytes, sizeof texels);
    svo_import_destroy(&import);
}

/* What contradicts itself is refused with the place and the values. */
static void test_damaged_files(void **unused)
{
    (void)unused;
    static const struct {
        const char *accessors, *nodes, *primitive, *text;
    } cases[] = {
        {"", "", "", "accessor 0: 36 bytes from 4 on are beyond the 36 of bufferView 0"},
        {",\"count\":3", "", "", "accessor 0 has no bufferView"},
        {",\"bufferView\":9", "", "", "bufferView 9 is none of the 1 bufferViews"},
        {",\"bufferView\":0,\"byteOffset\":-4", "", "", "byteOffset -4 is no whole number"},
        {",\"bufferView\":0,\"count\":1e300", "", "", "count 1e+300 is no whole number"},
        {NULL, "{\"mesh\":3}", "", "mesh 3 is none of the 1 meshes"},
        {NULL, "{\"mesh\":0,\"children\":[0]}", "", "node 0 has two parents, or is below itself"},
        {NULL, "{\"mesh\":0,\"scale\":[1,1]}", "", "scale is not 3 numbers"},
        {NULL, "{\"mesh\":0}", ",\"mode\":7", "mode 7 of a primitive is not in 0 .. 6"},
        {NULL, "{\"mesh\":0}", ",\"indices\":0", "accessor 0 is used as indices and has no unsigned integers"},
        {NULL, "{\"mesh\":0}", ",\"material\":0", "material 0 is none of the 0 materials"},
        {NULL, "{}", "", "no triangles"},
    };
    static const char plain[] = "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}";
    char accessors[256], body[512];
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        begin();
        add(triangle, sizeof triangle, FLOAT, "VEC3", 3, "");
        (void)snprintf(accessors, sizeof accessors, "{\"componentType\":5126,\"type\":\"VEC3\"%s}",
                       cases[i].accessors != NULL && cases[i].accessors[0] != '\0'
                           ? cases[i].accessors
                           : ",\"bufferView\":0,\"byteOffset\":4,\"count\":3");
        (void)snprintf(body, sizeof body,
                       "\"nodes\":[%s],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}%s}]}]",
                       cases[i].nodes[0] != '\0' ? cases[i].nodes : "{\"mesh\":0}", cases[i].primitive);
        finish_with("damaged", cases[i].accessors != NULL ? accessors : plain, body);
        expect_refused("damaged.gltf", NULL, cases[i].text);
    }
    write_text("text.gltf", "{\"asset\":{\"version\":\"2.0\"}, oops}");
    expect_refused("text.gltf", NULL, "of its JSON: not understood");
    write_text("third.gltf", "{\"asset\":{\"version\":\"3.0\"}}");
    expect_refused("third.gltf", NULL, "glTF of version 3.0; 2.0 is read");
}

/* Arrays of different lengths, and a stride below an element. */
static void test_arrays_that_do_not_fit(void **unused)
{
    (void)unused;
    begin();
    add(triangle, sizeof triangle, FLOAT, "VEC3", 3, "");
    add(triangle, 24, FLOAT, "VEC3", 2, "");
    add_strided(triangle, sizeof triangle, FLOAT, "VEC3", 3, 8, "");
    finish_with("normals", made.accessors,
                "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,"
                "\"NORMAL\":1}}]}]");
    expect_refused("normals.gltf", NULL, "NORMAL, accessor 1, has 2 elements for 3 vertices");
    finish_with("stride", made.accessors,
                "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":2}}]}]");
    expect_refused("stride.gltf", NULL, "accessor 2: byteStride 8 is below the 12 bytes of an element");
}

TEST_GROUP(import_gltf)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gltf_attributes),
        cmocka_unit_test(test_gltf_nested_nodes),
        cmocka_unit_test(test_gltf_mirrored_node),
        cmocka_unit_test(test_gltf_texture_transform),
        cmocka_unit_test(test_gltf_texture_rotation),
        cmocka_unit_test(test_quantized_attributes),
        cmocka_unit_test(test_quantized_types),
        cmocka_unit_test(test_sparse_accessors),
        cmocka_unit_test(test_modes),
        cmocka_unit_test(test_instances),
        cmocka_unit_test(test_extensions),
        cmocka_unit_test(test_linear_colors_become_srgb),
        cmocka_unit_test(test_alpha),
        cmocka_unit_test(test_emission_and_gloss),
        cmocka_unit_test(test_normal_textures),
        cmocka_unit_test(test_binary_files),
        cmocka_unit_test(test_older_files),
        cmocka_unit_test(test_other_files_are_announced),
        cmocka_unit_test(test_damaged_files),
        cmocka_unit_test(test_arrays_that_do_not_fit),
    };
    return cmocka_run_group_tests_name("import_gltf", tests, work_folder_make, work_folder_remove);
}
