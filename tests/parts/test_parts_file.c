/* SPDX-License-Identifier: MIT */
/*
 * Mesh files that are read in blocks: the tree of their parts is that of the imported mesh in one piece, byte for byte.
 * Files that are imported whole are told apart, and files that are short of bytes are refused by name.
 */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/fixture_folder.h"
#include "support/import_check.h"
#include "support/suite.h"
#include "svocl/io.h"
#include "svocl/parts.h"

#define PATH_BYTES 256
#define DEPTH      6
#define LIMIT      600000

/* What lib/parts/blocks.c reads at a time, and a surface of more than two such blocks. */
#define BLOCK 16384
#define SIDE  140

/* ---- files ---- */

typedef struct bytes {
    unsigned char *at;
    size_t count, capacity;
    bool big_endian;
} bytes;

static void put(bytes *out, const void *from, size_t count)
{
    if (out->count + count > out->capacity) {
        out->capacity = 2 * (out->count + count);
        out->at = realloc(out->at, out->capacity);
        assert_non_null(out->at);
    }
    memcpy(out->at + out->count, from, count);
    out->count += count;
}

/* A number of a binary file in its byte order. */
static void put_number(bytes *out, const void *from, size_t count)
{
    unsigned char turned[8];
    for (size_t i = 0; i < count; ++i) {
        turned[i] = ((const unsigned char *)from)[out->big_endian ? count - 1 - i : i];
    }
    put(out, turned, count);
}

static void put_text(bytes *out, const char *text)
{
    put(out, text, strlen(text));
}

static void put_byte(bytes *out, unsigned value)
{
    const unsigned char byte = (unsigned char)value;
    put(out, &byte, 1);
}

static void put_float(bytes *out, float value)
{
    put_number(out, &value, sizeof value);
}

static void put_int(bytes *out, int32_t value)
{
    put_number(out, &value, sizeof value);
}

/* A wavy surface over a grid of side + 1 vertices each way. */
static void find_vertex(unsigned side, unsigned vertex, float position[3])
{
    const unsigned column = vertex % (side + 1);
    const unsigned row = vertex / (side + 1);
    const float x = (float)column / (float)side;
    const float y = (float)row / (float)side;
    position[0] = x;
    position[1] = y;
    position[2] = 0.3f * x * y + 0.1f * (float)(vertex % 7) / 7.0f;
}

/* What a PLY file of the surface has. */
typedef struct ply_form {
    bool big_endian, doubles, normals, colors;
    unsigned corners; /* of a face: 3, 4, or 5 for pentagons with a corner twice */
    bool damaged; /* indices out of range, a vertex that is not finite, faces of two corners */
    const char *before_faces, *face_list; /* more of the header */
} ply_form;

static const char coordinate_names[] = "xyz";

static void put_ply_header(bytes *out, const ply_form *form, unsigned vertices, unsigned faces)
{
    char line[128];
    (void)snprintf(line, sizeof line, "ply\nformat binary_%s_endian 1.0\ncomment a surface\nelement vertex %u\n",
                   form->big_endian ? "big" : "little", vertices);
    put_text(out, line);
    for (unsigned axis = 0; axis < 3; ++axis) {
        (void)snprintf(line, sizeof line, "property %s %c\n", form->doubles ? "double" : "float",
                       coordinate_names[axis]);
        put_text(out, line);
    }
    put_text(out, form->normals ? "property float nx\nproperty float ny\nproperty float nz\n" : "");
    put_text(out, form->colors ? "property uchar red\nproperty uchar green\nproperty uchar blue\n" : "");
    put_text(out, form->before_faces != NULL ? form->before_faces : "");
    (void)snprintf(line, sizeof line, "element face %u\n", faces);
    put_text(out, line);
    put_text(out, form->face_list != NULL ? form->face_list : "property list uchar int vertex_indices\n");
    put_text(out, "end_header\n");
}

static void put_ply_vertices(bytes *out, const ply_form *form, unsigned side)
{
    const unsigned count = (side + 1) * (side + 1);
    for (unsigned v = 0; v < count; ++v) {
        float position[3];
        find_vertex(side, v, position);
        position[2] = form->damaged && v == 5 ? NAN : position[2];
        for (unsigned axis = 0; axis < 3; ++axis) {
            const double wide = (double)position[axis];
            if (form->doubles) {
                put_number(out, &wide, sizeof wide);
            } else {
                put_float(out, position[axis]);
            }
            if (form->normals && axis == 2) {
                put_float(out, position[0] - 0.5f);
                put_float(out, position[1] - 0.5f);
                put_float(out, 1.0f);
            }
        }
        for (unsigned channel = 0; form->colors && channel < 3; ++channel) {
            put_byte(out, v * (channel + 3) % 256);
        }
    }
}

/* Quads, each as one face or two. */
static unsigned faces_of(const ply_form *form, unsigned side)
{
    return side * side * (form->corners == 3 ? 2 : 1);
}

static void put_ply_faces(bytes *out, const ply_form *form, unsigned side)
{
    for (unsigned face = 0; face < faces_of(form, side); ++face) {
        const unsigned quad = form->corners == 3 ? face / 2 : face;
        const unsigned first = quad / side * (side + 1) + quad % side;
        const unsigned ring[5] = {first, first + 1, first + side + 2, first + side + 1, first};
        const bool second = form->corners == 3 && face % 2 == 1;
        const unsigned corners = form->damaged && face % 31 == 0 ? 2 : form->corners;
        put_byte(out, corners);
        for (unsigned i = 0; i < corners; ++i) {
            const unsigned vertex = second && i > 0 ? ring[i + 1] : ring[i];
            put_int(out, form->damaged && face % 97 == 1 && i == 1 ? 1 << 30 : (int32_t)vertex);
        }
    }
}

static bytes make_ply(const ply_form *form, unsigned side)
{
    bytes out = {.big_endian = form->big_endian};
    put_ply_header(&out, form, (side + 1) * (side + 1), faces_of(form, side));
    put_ply_vertices(&out, form, side);
    put_ply_faces(&out, form, side);
    return out;
}

/* attribute: 0 no colors; 1 VisCAM's in every third facet; 2 Magics'. */
static bytes make_stl(unsigned side, unsigned attribute)
{
    bytes out = {.at = NULL};
    char header[80] = "a surface ";
    const uint32_t count = 2 * side * side;
    if (attribute == 2) {
        (void)snprintf(header + 10, sizeof header - 10, "COLOR=\x80\x40\x20\xff");
    }
    put(&out, header, sizeof header);
    put(&out, &count, sizeof count);
    for (uint32_t facet = 0; facet < count; ++facet) {
        const unsigned first = facet / 2 / side * (side + 1) + facet / 2 % side;
        const unsigned corners[3] = {first, facet % 2 == 0 ? first + 1 : first + side + 2,
                                     facet % 2 == 0 ? first + side + 2 : first + side + 1};
        const uint16_t color = (uint16_t)(facet * 37 % 32768 + (facet % 3 == 0 && attribute == 1 ? 32768 : 0));
        const uint16_t word = attribute == 0 ? 7 : color;
        put_float(&out, 0.0f);
        put_float(&out, (float)(facet % 3));
        put_float(&out, 1.0f);
        for (unsigned i = 0; i < 3; ++i) {
            float position[3];
            find_vertex(side, corners[i], position);
            put(&out, position, sizeof position);
        }
        put(&out, &word, sizeof word);
    }
    return out;
}

/* ---- both ways ---- */

static void name_of(const char *name, char path[PATH_BYTES])
{
    (void)snprintf(path, PATH_BYTES, "%s", path_of(name));
}

static void check(svo_status status, const char *text)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), text);
    }
}

/* The tree of the imported mesh in one piece, in whole.svo. */
static void build_whole(const fixture *opened, const char *name, const svo_plan_options *options)
{
    char path[PATH_BYTES];
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    svo_message message;
    svo_import *import = import_named(name);
    work_folder_remember("whole.svo");
    name_of("whole.svo", path);
    check(svo_plan_create(opened->device, svo_import_mesh(import), DEPTH, options, &plan),
          svo_device_message(opened->device));
    check(svo_build(plan, opened->frontend, opened->queue, &tree, NULL), svo_device_message(opened->device));
    check(svo_tree_download(tree, opened->queue), svo_device_message(opened->device));
    check(svo_tree_save(tree, svo_to_path(path), NULL, &message), message.text);
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    svo_import_destroy(&import);
}

/* Builds the parts of a folder; the file is parts.svo. Returns how many there are. */
static size_t build_parts(const fixture *opened, const char *folder)
{
    char path[PATH_BYTES];
    svo_parts *parts = NULL;
    svo_message message;
    work_folder_remember("parts.svo");
    name_of("parts.svo", path);
    check(svo_parts_open(folder, &parts, &message), message.text);
    const size_t count = svo_parts_count(parts);
    for (size_t i = 0; i < count; ++i) {
        check(svo_parts_build(parts, i, opened->device, opened->frontend, opened->queue, &message), message.text);
    }
    check(svo_parts_finish(parts, path, &message), message.text);
    svo_parts_close(&parts);
    check(svo_parts_remove(folder, &message), message.text);
    return count;
}

static bytes read_file(const char *name)
{
    bytes out = {.at = NULL};
    char block[4096];
    FILE *file = fopen(path_of(name), "rb");
    assert_non_null(file);
    for (size_t got = fread(block, 1, sizeof block, file); got > 0; got = fread(block, 1, sizeof block, file)) {
        put(&out, block, got);
    }
    (void)fclose(file);
    return out;
}

static void assert_same_files(const char *name)
{
    bytes whole = read_file("whole.svo");
    bytes parts = read_file("parts.svo");
    if (whole.count != parts.count || memcmp(whole.at, parts.at, whole.count) != 0) {
        fail_msg("%s: %zu bytes in one piece and %zu in blocks differ", name, whole.count, parts.count);
    }
    free(whole.at);
    free(parts.at);
}

static svo_status create(const fixture *opened, const char *name, const svo_plan_options *options, svo_message *message)
{
    char path[PATH_BYTES];
    char folder[PATH_BYTES];
    name_of(name, path);
    name_of("folder", folder);
    return svo_parts_create_from_file(opened->device, path, DEPTH, options, LIMIT, folder, message);
}

static void compare(const fixture *opened, const char *name, bytes file, const svo_plan_options *options)
{
    char folder[PATH_BYTES];
    svo_message message;
    write_bytes(name, file.at, file.count);
    free(file.at);
    name_of("folder", folder);
    check(create(opened, name, options, &message), message.text);
    assert_true(build_parts(opened, folder) > 1);
    build_whole(opened, name, options);
    assert_same_files(name);
}

/* ---- tests ---- */

#define NEED_PAYLOAD \
    ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_FILL)

static void test_stl(void **state)
{
    fixture opened = fixture_cl_of_group(state);
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    for (unsigned attribute = 0; attribute < 3; ++attribute) {
        options.need = SVO_NEED_DEFAULT;
        compare(&opened, "surface.stl", make_stl(SIDE, attribute), &options);
        options.need = NEED_PAYLOAD;
        compare(&opened, "surface.stl", make_stl(20, attribute), &options);
    }
}

static void test_ply(void **state)
{
    static const ply_form forms[] = {{.corners = 3},
                                     {.corners = 3, .normals = true, .colors = true},
                                     {.corners = 3, .big_endian = true, .doubles = true, .colors = true},
                                     {.corners = 4, .normals = true},
                                     {.corners = 5, .big_endian = true, .colors = true},
                                     {.corners = 3, .damaged = true, .normals = true, .colors = true},
                                     {.corners = 5, .damaged = true}};
    fixture opened = fixture_cl_of_group(state);
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; ++i) {
        options.need = SVO_NEED_DEFAULT;
        compare(&opened, "surface.ply", make_ply(&forms[i], SIDE), &options);
        options.need = NEED_PAYLOAD;
        compare(&opened, "surface.ply", make_ply(&forms[i], 20), &options);
    }
}

/* A caller's grid that cuts the mesh, every coverage and every kind of weight. */
static void test_options(void **state)
{
    static const ply_form form = {.corners = 3, .normals = true, .colors = true};
    fixture opened = fixture_cl_of_group(state);
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    options.edge = 0.7;
    options.origin[0] = 0.1;
    for (unsigned i = 0; i < 3; ++i) {
        options.coverage = (svo_coverage)i;
        options.weights = (svo_weights)i;
        compare(&opened, "surface.ply", make_ply(&form, 40), &options);
    }
}

/* What is the same in every block but differs between blocks is not constant. */
static void test_blocks_that_differ(void **state)
{
    fixture opened = fixture_cl_of_group(state);
    bytes file = make_stl(SIDE, 1);
    for (size_t facet = 0; facet < (size_t)2 * SIDE * SIDE; ++facet) {
        const bool later = facet >= BLOCK;
        unsigned char *at = file.at + 84 + 50 * facet;
        const float normal[3] = {0.0f, later ? 1.0f : 0.0f, later ? 0.0f : 1.0f};
        memcpy(at, normal, sizeof normal);
        at[48] = later ? 31 : 0;
        at[49] = 0x80;
    }
    compare(&opened, "surface.stl", file, NULL);
}

/* The first triangle is far larger than all others. The unit of weights follows from the largest area of a triangle in
   a voxel: of a mesh of few voxels, where the whole area is no tighter bound. */
static void test_one_large_triangle(void **state)
{
    static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0.4F};
    const svo_plan_options options = {.struct_size = sizeof options, .origin = {-4, -4, -4}, .edge = 16};
    fixture opened = fixture_cl_of_group(state);
    char path[PATH_BYTES];
    char folder[PATH_BYTES];
    svo_message message;
    bytes file = make_stl(SIDE, 1);
    memcpy(file.at + 84 + 12, corners, sizeof corners);
    write_bytes("large.stl", file.at, file.count);
    free(file.at);
    name_of("large.stl", path);
    name_of("folder", folder);
    check(svo_parts_create_from_file(opened.device, path, DEPTH, &options, (size_t)20 * LIMIT, folder, &message),
          message.text);
    (void)build_parts(&opened, folder);
    build_whole(&opened, "large.stl", &options);
    assert_same_files("large.stl");
}

static void expect(const fixture *opened, const char *name, svo_status expected, const char *words)
{
    svo_message message = {""};
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    const svo_status status = create(opened, name, &options, &message);
    if (status != expected || strstr(message.text, words) == NULL) {
        fail_msg("%s: %s, \"%s\"; expected %s with \"%s\"", name, svo_name(SVO_NAME_STATUS, status), message.text,
                 svo_name(SVO_NAME_STATUS, expected), words);
    }
}

/* A grid beside the mesh: each block has nothing to keep, and the tree is empty. */
static void test_grid_elsewhere(void **state)
{
    fixture opened = fixture_cl_of_group(state);
    svo_message message;
    char folder[PATH_BYTES];
    const svo_plan_options options = {.struct_size = sizeof options, .origin = {5, 5, 5}, .edge = 2};
    bytes file = make_stl(SIDE, 0);
    write_bytes("elsewhere.stl", file.at, file.count);
    free(file.at);
    name_of("folder", folder);
    check(create(&opened, "elsewhere.stl", &options, &message), message.text);
    (void)build_parts(&opened, folder);
    build_whole(&opened, "elsewhere.stl", &options);
    assert_same_files("elsewhere.stl");
}

/* Files that are imported whole, each with its reason. */
static void test_files_that_are_imported(void **state)
{
    static const ply_form strips = {.corners = 3, .before_faces = "element tristrips 1\nproperty list int int i\n"};
    static const ply_form no_list = {.corners = 3, .face_list = "property int vertex_index\n"};
    fixture opened = fixture_cl_of_group(state);
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_message message;
    write_text("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    expect(&opened, "a.obj", SVO_UNSUPPORTED, "neither binary PLY nor binary STL");
    write_text("a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
                        "endfacet\nendsolid a\n");
    expect(&opened, "a.stl", SVO_UNSUPPORTED, "text");
    write_text("a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                        "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0\n1 0\n0 1\n3 0 1 2\n");
    expect(&opened, "a.ply", SVO_UNSUPPORTED, "text");
    bytes file = make_ply(&strips, 2);
    write_bytes("b.ply", file.at, file.count);
    expect(&opened, "b.ply", SVO_UNSUPPORTED, "more than vertices and faces");
    free(file.at);
    file = make_ply(&no_list, 2);
    write_bytes("c.ply", file.at, file.count);
    expect(&opened, "c.ply", SVO_UNSUPPORTED, "no list of vertices");
    free(file.at);
    file = make_stl(2, 0);
    write_bytes("b.stl", file.at, file.count);
    free(file.at);
    options.need = SVO_NEED_RAYS;
    assert_int_equal(create(&opened, "b.stl", &options, &message), SVO_UNSUPPORTED);
    options.need = SVO_NEED_PROJECTED_AREA;
    assert_int_equal(create(&opened, "b.stl", &options, &message), SVO_UNSUPPORTED);
    expect(&opened, "absent.stl", SVO_FILE_ERROR, "absent.stl");
    expect(&opened, ".", SVO_FILE_ERROR, "not a regular file");
}

/* Every length that is short of bytes is refused, with the file's name and nothing written. */
static void test_truncated_files(void **state)
{
    static const ply_form form = {.corners = 4, .normals = true, .colors = true};
    fixture opened = fixture_cl_of_group(state);
    bytes files[2] = {make_ply(&form, 4), make_stl(4, 1)};
    const char *const names[2] = {"short.ply", "short.stl"};
    for (unsigned i = 0; i < 2; ++i) {
        for (size_t count = 0; count < files[i].count; count += 1 + count / 64) {
            svo_message message = {""};
            write_bytes(names[i], files[i].at, count);
            const svo_status status = create(&opened, names[i], NULL, &message);
            if ((status != SVO_IMPORT_FAILED && status != SVO_UNSUPPORTED) || strstr(message.text, names[i]) == NULL) {
                fail_msg("%s of %zu bytes: %s, \"%s\"", names[i], count, svo_name(SVO_NAME_STATUS, status),
                         message.text);
            }
        }
        free(files[i].at);
    }
}

/* Counts that the file is too short for, up to the largest. */
static void test_counts_above_the_file(void **state)
{
    static const char *const counts[] = {"1000", "4294967295", "1000000000000000000"};
    fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < 3; ++i) {
        for (unsigned of_faces = 0; of_faces < 2; ++of_faces) {
            char text[512];
            (void)snprintf(text, sizeof text,
                           "ply\nformat binary_little_endian 1.0\nelement vertex %s\nproperty float x\n"
                           "property double y\nelement face %s\nproperty list uchar int vertex_indices\nend_header\n"
                           "0123456789ab",
                           of_faces != 0 ? "1" : counts[i], of_faces != 0 ? counts[i] : "1");
            write_text("many.ply", text);
            expect(&opened, "many.ply", SVO_IMPORT_FAILED, counts[i]);
        }
    }
    char facets[100] = {0};
    memset(facets + 80, 0xff, 4);
    write_bytes("many.stl", facets, sizeof facets);
    expect(&opened, "many.stl", SVO_IMPORT_FAILED, "4294967295 facets");
    memset(facets + 80, 0, 4);
    write_bytes("many.stl", facets, 84);
    expect(&opened, "many.stl", SVO_IMPORT_FAILED, "no triangles");
}

/* ---- ranges ---- */

/* Does a task, and takes its result; twice: a worker that was given up may go on. */
static void plan_range(const fixture *opened, svo_parts_planning *planning, size_t index)
{
    const void *task = NULL;
    void *results[2] = {NULL};
    size_t task_bytes = 0;
    size_t result_bytes = 0;
    svo_message message;
    check(svo_parts_planning_task(planning, index, &task, &task_bytes, &message), message.text);
    for (unsigned turn = 0; turn < 2; ++turn) {
        check(svo_parts_planning_work(opened->device, task, task_bytes, &results[turn], &result_bytes, &message),
              message.text);
    }
    assert_int_equal(svo_parts_planning_take(planning, index, results[0], result_bytes - 1, &message),
                     SVO_INVALID_ARGUMENT);
    check(svo_parts_planning_take(planning, index, results[1], result_bytes, &message), message.text);
    svo_parts_planning_free(results[0]);
    svo_parts_planning_free(results[1]);
}

/* Plans a file in ranges, the last first. Returns how many ranges the last step had. */
static size_t plan_ranges(const fixture *opened, const char *name, const svo_plan_options *options, unsigned ranges)
{
    char path[PATH_BYTES];
    char folder[PATH_BYTES];
    svo_parts_planning *planning = NULL;
    svo_message message;
    size_t count = 0;
    size_t last_count = 0;
    name_of(name, path);
    name_of("folder", folder);
    check(svo_parts_planning_begin(opened->device, path, DEPTH, options, LIMIT, folder, ranges, &planning, &message),
          message.text);
    assert_int_equal(svo_parts_planning_finish(planning, &message), SVO_INVALID_ARGUMENT);
    for (;;) {
        check(svo_parts_planning_tasks(planning, &count, &message), message.text);
        if (count == 0) {
            break;
        }
        last_count = count;
        for (size_t i = count; i-- > 0;) {
            plan_range(opened, planning, i);
        }
    }
    check(svo_parts_planning_finish(planning, &message), message.text);
    svo_parts_planning_end(&planning);
    return last_count;
}

/* The files of a folder's plan, one after the other. */
static bytes read_plan(uint64_t *triangles)
{
    char folder[PATH_BYTES];
    char name[PATH_BYTES + 64];
    char identity[SVO_PARTS_IDENTITY_BYTES];
    svo_parts *parts = NULL;
    svo_message message;
    name_of("folder", folder);
    check(svo_parts_open(folder, &parts, &message), message.text);
    check(svo_parts_get_identity(parts, identity, &message), message.text);
    bytes all = read_file("folder/plan");
    *triangles = 0;
    for (size_t i = 0; i < svo_parts_count(parts); ++i) {
        svo_parts_entry entry = SVO_PARTS_ENTRY_INIT;
        check(svo_parts_get(parts, i, &entry, &message), message.text);
        (void)snprintf(name, sizeof name, "folder/%s/%u-%llx.tri", identity, entry.level,
                       (unsigned long long)entry.code);
        bytes file = read_file(name);
        put(&all, file.at, file.count);
        free(file.at);
        *triangles += entry.triangles;
    }
    svo_parts_close(&parts);
    return all;
}

/* Any number of ranges gives the same plan, byte for byte, and the tree of the mesh in one piece. */
static void compare_ranges(const fixture *opened, const char *name, bytes file, bool is_even)
{
    char folder[PATH_BYTES];
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_message message;
    uint64_t triangles = 0;
    options.need = NEED_PAYLOAD;
    write_bytes(name, file.at, file.count);
    free(file.at);
    name_of("folder", folder);
    check(create(opened, name, &options, &message), message.text);
    const bytes one = read_plan(&triangles);
    check(svo_parts_remove(folder, &message), message.text);
    for (unsigned ranges = 1; ranges <= 7; ranges += 3) {
        assert_int_equal(plan_ranges(opened, name, &options, ranges), is_even ? ranges : 1);
        bytes many = read_plan(&triangles);
        if (many.count != one.count || memcmp(many.at, one.at, one.count) != 0) {
            fail_msg("%s: the plans of 1 and %u ranges differ", name, ranges);
        }
        free(many.at);
        if (ranges < 7) {
            check(svo_parts_remove(folder, &message), message.text);
        }
    }
    assert_true(build_parts(opened, folder) > 1);
    build_whole(opened, name, &options);
    assert_same_files(name);
    free(one.at);
}

static void test_ranges(void **state)
{
    fixture opened = fixture_cl_of_group(state);
    const ply_form triangles = {.corners = 3, .colors = true, .normals = true};
    const ply_form quads = {.corners = 4, .big_endian = true, .colors = true};
    const ply_form mixed = {.corners = 4, .damaged = true};
    compare_ranges(&opened, "surface.ply", make_ply(&triangles, SIDE), true);
    compare_ranges(&opened, "surface.ply", make_ply(&quads, 40), true);
    compare_ranges(&opened, "surface.ply", make_ply(&mixed, 40), false);
    compare_ranges(&opened, "surface.stl", make_stl(40, 1), true);
}

/* Faces of five corners and of three that fill the file as so many of four would: it looks even, and is not. */
static void test_ranges_of_uneven_faces(void **state)
{
    fixture opened = fixture_cl_of_group(state);
    const ply_form form = {.corners = 4};
    bytes file = {.at = NULL};
    const unsigned side = 40;
    put_ply_header(&file, &form, (side + 1) * (side + 1), 2 * (side - 1) * side);
    put_ply_vertices(&file, &form, side);
    for (unsigned face = 0; face < 2 * (side - 1) * side; ++face) {
        const int first = (int)(face / 2 / (side - 1) * (side + 1) + face / 2 % (side - 1));
        const int edge = (int)side + 1;
        const int rings[3][5] = {{first, first + 1, first + edge + 1, first + edge},
                                 {first, first + 1, first + 2, first + edge + 1, first + edge},
                                 {first + 2, first + edge + 2, first + edge + 1}};
        const unsigned kind = face < 2 * side ? 0 : 1 + face % 2;
        const unsigned corners = kind == 0 ? 4 : kind == 1 ? 5 : 3;
        put_byte(&file, corners);
        for (unsigned i = 0; i < corners; ++i) {
            put_int(&file, rings[kind][i]);
        }
    }
    compare_ranges(&opened, "surface.ply", file, false);
}

/* Vertices that no triangle uses do not widen the grid, however far they are. */
static void test_unused_vertices(void **state)
{
    fixture opened = fixture_cl_of_group(state);
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    const ply_form form = {.corners = 3};
    for (unsigned way = 0; way < 2; ++way) {
        bytes file = {.at = NULL};
        put_ply_header(&file, &form, 41 * 41 + 1, faces_of(&form, 40));
        put_ply_vertices(&file, &form, 40);
        put_float(&file, 0.0f);
        put_float(&file, way == 0 ? -3.0f : 3e38f);
        put_float(&file, way == 0 ? 0.0f : -3e38f);
        put_ply_faces(&file, &form, 40);
        compare(&opened, "surface.ply", file, &options);
    }
}

/* Each triangle is written once to the parts that it may meet: not much more often than there are triangles. */
static void test_triangles_are_written_once(void **state)
{
    fixture opened = fixture_cl_of_group(state);
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_message message;
    char path[PATH_BYTES];
    char folder[PATH_BYTES];
    uint64_t triangles = 0;
    bytes file = make_stl(SIDE, 0);
    write_bytes("surface.stl", file.at, file.count);
    free(file.at);
    name_of("folder", folder);
    name_of("surface.stl", path);
    check(svo_parts_create_from_file(opened.device, path, DEPTH, &options, 8 * LIMIT, folder, &message), message.text);
    bytes all = read_plan(&triangles);
    free(all.at);
    assert_true(triangles > 2 * SIDE * SIDE); /* there are parts */
    assert_in_range(triangles, 2 * SIDE * SIDE, 2 * SIDE * SIDE * 5 / 4);
    check(svo_parts_remove(folder, &message), message.text);
}

static void test_bad_requests(void **state)
{
    fixture opened = fixture_cl_of_group(state);
    svo_message message;
    assert_int_equal(svo_parts_create_from_file(NULL, "a", 4, NULL, 1, "b", &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_parts_create_from_file(opened.device, NULL, 4, NULL, 1, "b", &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_parts_create_from_file(opened.device, "a", 4, NULL, 1, NULL, &message), SVO_INVALID_ARGUMENT);
    svo_parts_planning *planning = NULL;
    for (unsigned ranges = 0; ranges <= 65537; ranges += 65537) {
        assert_int_equal(svo_parts_planning_begin(opened.device, "a", 4, NULL, 1, "b", ranges, &planning, &message),
                         SVO_INVALID_ARGUMENT);
        assert_non_null(strstr(message.text, "is not in 1 .. 65536"));
    }
    bytes file = make_stl(2, 0);
    write_bytes("b.stl", file.at, file.count);
    free(file.at);
    char path[PATH_BYTES];
    name_of("b.stl", path);
    assert_int_equal(svo_parts_create_from_file(opened.device, path, 21, NULL, LIMIT, "b", &message),
                     SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "depth 21"));
}

TEST_GROUP(parts_file)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_stl),
        cmocka_unit_test(test_ply),
        cmocka_unit_test(test_options),
        cmocka_unit_test(test_blocks_that_differ),
        cmocka_unit_test(test_one_large_triangle),
        cmocka_unit_test(test_grid_elsewhere),
        cmocka_unit_test(test_files_that_are_imported),
        cmocka_unit_test(test_truncated_files),
        cmocka_unit_test(test_counts_above_the_file),
        cmocka_unit_test(test_ranges),
        cmocka_unit_test(test_ranges_of_uneven_faces),
        cmocka_unit_test(test_unused_vertices),
        cmocka_unit_test(test_triangles_are_written_once),
        cmocka_unit_test(test_bad_requests),
    };
    return cmocka_run_group_tests_name("parts_file", tests, fixture_folder_setup, fixture_folder_teardown);
}
