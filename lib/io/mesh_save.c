/* SPDX-License-Identifier: MIT */
/* svo_mesh_save: meshes as .ply, .obj and .glb, with normals and colors. */
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "core/struct_size.h"
#include "io/files.h"
#include "io/srgb.h"
#include "io/voxels_files.h"
#include "svocl/io.h"

#define BUFFER_BYTES    16384
#define TEXT_BYTES      2048
#define POSITION_DIGITS 9 /* give every float back */

/* Of glTF: what a component is, what a view is for, and the chunks of a binary file (specification, 3.6 and 4.4). */
#define GLB_FLOAT       5126
#define GLB_WORD        5125
#define GLB_SHORT       5123
#define GLB_VERTICES    34962
#define GLB_INDICES     34963
#define GLB_MAGIC       0x46546c67u
#define GLB_VERSION     2u
#define GLB_JSON        0x4e4f534au
#define GLB_BINARY      0x004e4942u
#define GLB_HEAD_BYTES  12u
#define GLB_CHUNK_BYTES 8u

static const char function[] = "svo_mesh_save";

typedef struct mesh_writer {
    const svo_mesh *mesh;
    svo_i_sink sink;
    uint8_t buffer[BUFFER_BYTES];
    size_t used;
    uint64_t written; /* bytes, with those in the buffer */
    uint16_t linear[256]; /* of sRGB bytes, 65535 = 1 */
} mesh_writer;

/* ---- bytes ---- */

static svo_status flush(mesh_writer *w)
{
    const size_t byte_count = w->used;
    w->used = 0;
    return byte_count == 0 || svo_i_sink_write(&w->sink, w->buffer, byte_count)
               ? SVO_OK
               : svo_i_fail(w->sink.message, SVO_FILE_ERROR,
                            "%s: %zu bytes before byte %" PRIu64 " could not be written", w->sink.name, byte_count,
                            w->written);
}

/* byte_count: at most BUFFER_BYTES */
static svo_status put(mesh_writer *w, const void *bytes, size_t byte_count)
{
    if (byte_count > BUFFER_BYTES - w->used) {
        SVO_I_TRY(flush(w));
    }
    memcpy(w->buffer + w->used, bytes, byte_count);
    w->used += byte_count;
    w->written += byte_count;
    return SVO_OK;
}

static svo_status put_text(mesh_writer *w, const char *format, ...) __attribute__((format(printf, 2, 3)));
static svo_status put_text(mesh_writer *w, const char *format, ...)
{
    char text[TEXT_BYTES];
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return put(w, text, (size_t)length);
}

/* Words, the lowest byte first. count: at most 4 */
static svo_status put_words(mesh_writer *w, const uint32_t *words, size_t count)
{
    uint8_t bytes[16];
    for (size_t i = 0; i < 4 * count; ++i) {
        bytes[i] = (uint8_t)(words[i / 4] >> 8 * (i % 4));
    }
    return put(w, bytes, 4 * count);
}

static svo_status put_vector(mesh_writer *w, const float vector[3])
{
    uint32_t words[3];
    memcpy(words, vector, sizeof words);
    return put_words(w, words, 3);
}

static void corners_of(const svo_mesh *mesh, size_t triangle, uint32_t corners[3])
{
    for (size_t i = 0; i < 3; ++i) {
        corners[i] = mesh->indices != NULL ? mesh->indices[3 * triangle + i] : (uint32_t)(3 * triangle + i);
    }
}

/* ---- .ply ---- */

static svo_status put_ply(mesh_writer *w)
{
    const svo_mesh *mesh = w->mesh;
    SVO_I_TRY(put_text(w,
                       "ply\nformat binary_little_endian 1.0\nelement vertex %zu\n"
                       "property float x\nproperty float y\nproperty float z\n%s%s"
                       "element face %zu\nproperty list uchar uint vertex_indices\nend_header\n",
                       mesh->vertex_count,
                       mesh->normals != NULL ? "property float nx\nproperty float ny\nproperty float nz\n" : "",
                       mesh->colors != NULL ? "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                                              "property uchar alpha\n"
                                            : "",
                       mesh->triangle_count));
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        SVO_I_TRY(put_vector(w, mesh->positions + 3 * i));
        SVO_I_TRY(mesh->normals != NULL ? put_vector(w, mesh->normals + 3 * i) : SVO_OK);
        SVO_I_TRY(mesh->colors != NULL ? put(w, mesh->colors + 4 * i, 4) : SVO_OK);
    }
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        static const uint8_t corner_count = 3;
        uint32_t corners[3];
        corners_of(mesh, i, corners);
        SVO_I_TRY(put(w, &corner_count, 1));
        SVO_I_TRY(put_words(w, corners, 3));
    }
    return SVO_OK;
}

/* ---- .obj ---- */

/* A line of numbers after a word, three of a vector and, unless it is NULL, a color. */
static svo_status put_line(mesh_writer *w, const char *word, const float vector[3], const uint8_t *color)
{
    char line[6 * VOXEL_NUMBER_BYTES + 16];
    size_t used = (size_t)snprintf(line, sizeof line, "%s", word);
    for (int i = 0; i < 3; ++i) {
        line[used++] = ' ';
        used += strlen(svo_i_voxel_number(line + used, (double)vector[i], POSITION_DIGITS));
    }
    for (int i = 0; i < 3 && color != NULL; ++i) {
        line[used++] = ' ';
        used += strlen(svo_i_voxel_number(line + used, color[i] / 255.0, POSITION_DIGITS));
    }
    line[used++] = '\n';
    return put(w, line, used);
}

static svo_status put_obj(mesh_writer *w)
{
    const svo_mesh *mesh = w->mesh;
    SVO_I_TRY(put_text(w, "# %zu vertices, %zu triangles%s\n", mesh->vertex_count, mesh->triangle_count,
                       mesh->colors != NULL ? "; v x y z red green blue" : ""));
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        SVO_I_TRY(put_line(w, "v", mesh->positions + 3 * i, mesh->colors != NULL ? mesh->colors + 4 * i : NULL));
    }
    for (size_t i = 0; i < mesh->vertex_count && mesh->normals != NULL; ++i) {
        SVO_I_TRY(put_line(w, "vn", mesh->normals + 3 * i, NULL));
    }
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        uint32_t c[3];
        corners_of(mesh, i, c);
        const uint64_t a = UINT64_C(1) + c[0];
        const uint64_t b = UINT64_C(1) + c[1];
        const uint64_t d = UINT64_C(1) + c[2];
        SVO_I_TRY(mesh->normals != NULL
                      ? put_text(w, "f %" PRIu64 "//%" PRIu64 " %" PRIu64 "//%" PRIu64 " %" PRIu64 "//%" PRIu64 "\n", a,
                                 a, b, b, d, d)
                      : put_text(w, "f %" PRIu64 " %" PRIu64 " %" PRIu64 "\n", a, b, d));
    }
    return SVO_OK;
}

/*
 * ---- .glb ----
 *
 * One primitive. Colors are linear in glTF: 16 bits a component, which give the bytes of sRGB back.
 */

/* The least and the greatest coordinates, as JSON. */
static void describe_bounds(const svo_mesh *mesh, char text[TEXT_BYTES])
{
    char numbers[6][VOXEL_NUMBER_BYTES];
    for (size_t axis = 0; axis < 3; ++axis) {
        float low = mesh->positions[axis];
        float high = low;
        for (size_t i = 1; i < mesh->vertex_count; ++i) {
            low = fminf(low, mesh->positions[3 * i + axis]);
            high = fmaxf(high, mesh->positions[3 * i + axis]);
        }
        (void)svo_i_voxel_number(numbers[axis], (double)low, POSITION_DIGITS);
        (void)svo_i_voxel_number(numbers[3 + axis], (double)high, POSITION_DIGITS);
    }
    (void)snprintf(text, TEXT_BYTES, "\"min\":[%s,%s,%s],\"max\":[%s,%s,%s]", numbers[0], numbers[1], numbers[2],
                   numbers[3], numbers[4], numbers[5]);
}

static bool is_opaque(const svo_mesh *mesh)
{
    bool opaque = true;
    for (size_t i = 0; i < mesh->vertex_count && mesh->colors != NULL; ++i) {
        opaque = opaque && mesh->colors[4 * i + 3] == 255;
    }
    return opaque;
}

/* The arrays of a file, in their order; bytes of an element, 0: it has none. */
typedef struct glb_array {
    const char *name;
    const char *type; /* of an accessor */
    size_t element_bytes;
    int component;
} glb_array;

#define GLB_ARRAYS 4

static void list_arrays(const svo_mesh *mesh, glb_array arrays[GLB_ARRAYS])
{
    arrays[0] = (glb_array){"POSITION", "\"VEC3\"", 12, GLB_FLOAT};
    arrays[1] = (glb_array){"NORMAL", "\"VEC3\"", mesh->normals != NULL ? 12 : 0, GLB_FLOAT};
    arrays[2] = (glb_array){"COLOR_0", "\"VEC4\",\"normalized\":true", mesh->colors != NULL ? 8 : 0, GLB_SHORT};
    arrays[3] = (glb_array){"", "\"SCALAR\"", 4, GLB_WORD};
}

/* Text that grows to the end of its room. */
typedef struct json_text {
    char text[2 * TEXT_BYTES];
    size_t used;
} json_text;

static void add_json(json_text *json, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void add_json(json_text *json, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    json->used += (size_t)vsnprintf(json->text + json->used, sizeof json->text - json->used, format, arguments);
    va_end(arguments);
}

/* Writes the JSON, padded to words, and returns the bytes of the arrays. */
static uint64_t describe(const svo_mesh *mesh, json_text *json)
{
    char bounds[TEXT_BYTES];
    glb_array arrays[GLB_ARRAYS];
    uint64_t begin = 0;
    int number = 0;
    json->used = 0;
    list_arrays(mesh, arrays);
    describe_bounds(mesh, bounds);
    add_json(json,
             "{\"asset\":{\"version\":\"2.0\",\"generator\":\"svocl\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
             "\"nodes\":[{\"mesh\":0}],\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":0}%s}],"
             "\"meshes\":[{\"primitives\":[{\"attributes\":{",
             is_opaque(mesh) ? "" : ",\"alphaMode\":\"BLEND\"");
    for (int i = 0; i + 1 < GLB_ARRAYS; ++i) {
        if (arrays[i].element_bytes > 0) {
            add_json(json, "%s\"%s\":%d", number > 0 ? "," : "", arrays[i].name, number);
            ++number;
        }
    }
    add_json(json, "},\"indices\":%d,\"material\":0}]}],\"accessors\":[", number);
    for (int i = 0, at = 0; i < GLB_ARRAYS; ++i) {
        if (arrays[i].element_bytes > 0) {
            add_json(json, "%s{\"bufferView\":%d,\"componentType\":%d,\"count\":%zu,\"type\":%s%s%s}",
                     at > 0 ? "," : "", at, arrays[i].component,
                     i + 1 < GLB_ARRAYS ? mesh->vertex_count : 3 * mesh->triangle_count, arrays[i].type,
                     i == 0 ? "," : "", i == 0 ? bounds : "");
            ++at;
        }
    }
    add_json(json, "],\"bufferViews\":[");
    for (int i = 0; i < GLB_ARRAYS; ++i) {
        const bool of_vertices = i + 1 < GLB_ARRAYS;
        const uint64_t bytes =
            arrays[i].element_bytes * (uint64_t)(of_vertices ? mesh->vertex_count : 3 * mesh->triangle_count);
        if (bytes > 0) {
            add_json(json, "%s{\"buffer\":0,\"byteOffset\":%" PRIu64 ",\"byteLength\":%" PRIu64 ",\"target\":%d}",
                     begin > 0 ? "," : "", begin, bytes, of_vertices ? GLB_VERTICES : GLB_INDICES);
        }
        begin += bytes;
    }
    add_json(json, "],\"buffers\":[{\"byteLength\":%" PRIu64 "}]}", begin);
    while (json->used % 4 != 0) {
        add_json(json, " ");
    }
    return begin;
}

/* As long as 1; of none 0, 0, 1, for all normals of glTF have that length. */
static svo_status put_unit(mesh_writer *w, const float normal[3])
{
    const double at[3] = {(double)normal[0], (double)normal[1], (double)normal[2]};
    const double length = sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]);
    const bool is_there = length > 0.0 && isfinite(length);
    const float unit[3] = {is_there ? (float)(at[0] / length) : 0.0F, is_there ? (float)(at[1] / length) : 0.0F,
                           is_there ? (float)(at[2] / length) : 1.0F};
    return put_vector(w, unit);
}

static svo_status put_linear(mesh_writer *w, const uint8_t color[4])
{
    const uint32_t words[2] = {w->linear[color[0]] | (uint32_t)w->linear[color[1]] << 16,
                               w->linear[color[2]] | (uint32_t)color[3] * 257u << 16};
    return put_words(w, words, 2);
}

static svo_status put_glb(mesh_writer *w)
{
    const svo_mesh *mesh = w->mesh;
    json_text json;
    const uint64_t bytes = describe(mesh, &json);
    const uint64_t total = GLB_HEAD_BYTES + 2 * GLB_CHUNK_BYTES + json.used + bytes;
    if (total > UINT32_MAX) {
        return svo_i_fail(w->sink.message, SVO_UNSUPPORTED,
                          "%s: a .glb file of %" PRIu64 " bytes is above the format's limit of %u", w->sink.name, total,
                          UINT32_MAX);
    }
    const uint32_t head[3] = {GLB_MAGIC, GLB_VERSION, (uint32_t)total};
    const uint32_t chunks[2][2] = {{(uint32_t)json.used, GLB_JSON}, {(uint32_t)bytes, GLB_BINARY}};
    for (int i = 0; i < 256; ++i) {
        w->linear[i] = (uint16_t)(svo_i_srgb_linear((uint8_t)i) * 65535.0 + 0.5);
    }
    SVO_I_TRY(put_words(w, head, 3));
    SVO_I_TRY(put_words(w, chunks[0], 2));
    SVO_I_TRY(put(w, json.text, json.used));
    SVO_I_TRY(put_words(w, chunks[1], 2));
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        SVO_I_TRY(put_vector(w, mesh->positions + 3 * i));
    }
    for (size_t i = 0; i < mesh->vertex_count && mesh->normals != NULL; ++i) {
        SVO_I_TRY(put_unit(w, mesh->normals + 3 * i));
    }
    for (size_t i = 0; i < mesh->vertex_count && mesh->colors != NULL; ++i) {
        SVO_I_TRY(put_linear(w, mesh->colors + 4 * i));
    }
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        uint32_t corners[3];
        corners_of(mesh, i, corners);
        SVO_I_TRY(put_words(w, corners, 3));
    }
    return SVO_OK;
}

/* ---- saving ---- */

static svo_status check_mesh(const svo_mesh *mesh, svo_message *message)
{
    if (mesh->positions == NULL || mesh->material_count > 0 || mesh->texture_count > 0) {
        return svo_i_fail(message, SVO_UNSUPPORTED, "%s: the mesh %s", function,
                          mesh->positions == NULL ? "has no float positions" : "has materials or textures");
    }
    if (mesh->vertex_count == 0 || mesh->triangle_count == 0 || mesh->vertex_count >= UINT32_MAX ||
        mesh->triangle_count >= UINT32_MAX) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %zu vertices or %zu triangles are not in 1 .. %u",
                          function, mesh->vertex_count, mesh->triangle_count, UINT32_MAX - 1);
    }
    for (size_t i = 0; i < 3 * mesh->vertex_count; ++i) {
        if (!isfinite(mesh->positions[i])) {
            return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: position %g of vertex %zu is not finite", function,
                              (double)mesh->positions[i], i / 3);
        }
    }
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        uint32_t corners[3];
        corners_of(mesh, i, corners);
        for (int k = 0; k < 3; ++k) {
            if (corners[k] >= mesh->vertex_count) {
                return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: vertex %u of triangle %zu is not below %zu",
                                  function, corners[k], i, mesh->vertex_count);
            }
        }
    }
    return SVO_OK;
}

/* Whether a path ends in a suffix of lower-case letters, in any case. */
static bool ends_in(const char *path, const char *suffix)
{
    const size_t length = strlen(path);
    const size_t count = strlen(suffix);
    bool does = length > count;
    for (size_t i = 0; i < count && does; ++i) {
        const char letter = path[length - count + i];
        does = (letter >= 'A' && letter <= 'Z' ? (char)(letter - 'A' + 'a') : letter) == suffix[i];
    }
    return does;
}

svo_mesh_format svo_mesh_format_of_path(const char *path)
{
    static const char *const suffixes[] = {".ply", ".obj", ".glb"};
    for (int i = 0; i < 3 && path != NULL; ++i) {
        if (ends_in(path, suffixes[i])) {
            return (svo_mesh_format)(SVO_MESH_FORMAT_PLY + i);
        }
    }
    return SVO_MESH_FORMAT_AUTO;
}

static svo_status put_file(mesh_writer *w, svo_mesh_format format)
{
    SVO_I_TRY(format == SVO_MESH_FORMAT_PLY ? put_ply(w) : format == SVO_MESH_FORMAT_OBJ ? put_obj(w) : put_glb(w));
    return flush(w);
}

svo_status svo_mesh_save(const svo_mesh *mesh, svo_sink sink, svo_mesh_format format, svo_message *message)
{
    mesh_writer w = {.used = 0};
    svo_mesh given;
    if (mesh == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: mesh is NULL", function);
    }
    SVO_I_TRY(svo_i_struct_read(message, function, "mesh", mesh, &given, SVO_I_STRUCT_SIZES(svo_mesh, texture_count)));
    format = format == SVO_MESH_FORMAT_AUTO ? svo_mesh_format_of_path(sink.path) : format;
    if ((unsigned)format < SVO_MESH_FORMAT_PLY || (unsigned)format > SVO_MESH_FORMAT_GLB) {
        return sink.path != NULL ? svo_i_fail(message, SVO_INVALID_ARGUMENT,
                                              "%s: the suffix of '%s' is not ply, obj or glb, and format is %d",
                                              function, sink.path, (int)format)
                                 : svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: format %d is not in %d .. %d",
                                              function, (int)format, SVO_MESH_FORMAT_PLY, SVO_MESH_FORMAT_GLB);
    }
    SVO_I_TRY(check_mesh(&given, message));
    w.mesh = &given;
    SVO_I_TRY(svo_i_sink_open(function, sink, message, &w.sink));
    return svo_i_sink_close(&w.sink, put_file(&w, format));
}
