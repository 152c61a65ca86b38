/* SPDX-License-Identifier: MIT */
/*
 * The procedural scenes: well-formed meshes of about the requested size, identical bytes with every machine and
 * compiler (pinned hashes), closed where documented. Mesh files contain exactly the mesh.
 */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dirent.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "scenes.h"
#include "support/suite.h"

#define ANY_COUNT 0u

static scene *create(const char *spec)
{
    scene *made = NULL;
    svo_message message = {""};
    if (scene_create(spec, &made, &message) != SVO_OK) {
        fail_msg("%s: %s", spec, message.text);
    }
    return made;
}

static uint64_t mesh_hash(const svo_mesh *mesh)
{
    XXH3_state_t *state = XXH3_createState();
    assert_non_null(state);
    XXH3_64bits_reset(state);
    XXH3_64bits_update(state, mesh->positions, mesh->vertex_count * 12);
    XXH3_64bits_update(state, mesh->normals, mesh->vertex_count * 12);
    XXH3_64bits_update(state, mesh->colors, mesh->vertex_count * 4);
    XXH3_64bits_update(state, mesh->indices, mesh->triangle_count * 12);
    const uint64_t hash = XXH3_64bits_digest(state);
    XXH3_freeState(state);
    return hash;
}

/* Finite positions, unit normals, indices and materials in range. */
static void check_well_formed(const char *spec, const svo_mesh *mesh)
{
    assert_int_equal(mesh->struct_size, sizeof *mesh);
    assert_non_null(mesh->positions);
    assert_non_null(mesh->normals);
    assert_non_null(mesh->colors);
    for (size_t vertex = 0; vertex < mesh->vertex_count; ++vertex) {
        const float *p = mesh->positions + 3 * vertex;
        const float *n = mesh->normals + 3 * vertex;
        const double length = sqrt((double)n[0] * n[0] + (double)n[1] * n[1] + (double)n[2] * n[2]);
        if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]) || !(fabs(length - 1) < 1e-6)) {
            fail_msg("%s: vertex %zu is (%g %g %g), its normal is %.9g long", spec, vertex, (double)p[0], (double)p[1],
                     (double)p[2], length);
        }
    }
    for (size_t corner = 0; corner < 3 * mesh->triangle_count; ++corner) {
        if (mesh->indices[corner] >= mesh->vertex_count) {
            fail_msg("%s: corner %zu has index %u of %zu vertices", spec, corner, mesh->indices[corner],
                     mesh->vertex_count);
        }
    }
    for (size_t triangle = 0; mesh->material_count > 0 && triangle < mesh->triangle_count; ++triangle) {
        assert_true(mesh->triangle_materials[triangle] < mesh->material_count);
    }
}

typedef struct expected_scene {
    const char *spec;
    uint32_t requested; /* ANY_COUNT: not checked */
    double tolerance; /* relative */
    uint64_t hash; /* 0: not pinned */
} expected_scene;

static const expected_scene expected[] = {
    {"atrium", 70000u, 0.01, 0xa0e325e320abbb3fu},
    {"atrium:20000", 20000u, 0.01, 0x59e939053e4e9bd0u},
    {"atrium:500000:4", 500000u, 0.01, 0xdeccdd0efc7896deu},
    {"atrium:1", ANY_COUNT, 0, 0xd2e480dceda61918u},
    {"knot", 40000u, 0.005, 0x90d18e7583bc5953u},
    {"knot:1", ANY_COUNT, 0, 0xc3b1c86d85e7918cu},
    {"knot:12345:2", 12345u, 0.005, 0xbe7183341db700ffu},
    {"knot:3000:3", 3000u, 0.01, 0x72706917bb7a477bu},
    {"terrain", 100000u, 0, 0x0e984a8cff362828u},
    {"terrain:1", 1u, 0, 0x1f70030546e6a3e9u},
    {"terrain:4999:9", 4999u, 0, 0x2768499ac2915538u},
    {"needles", 20000u, 0, 0x5f8d5a52a4bdc3e3u},
    {"needles:1:2", 1u, 0, 0x25ec3e4b571e91fcu},
    {"dust", 200000u, 0, 0x19b7a854f0d28177u},
    {"dust:77:3", 77u, 0, 0x17a7b4c57717e35eu},
    {"cornell", 5000u, 0.03, 0xe9120af52f348c57u},
    {"cornell:40000:6", 40000u, 0.02, 0x2be07810e4fc021du},
    {"cube", 12u, 0, 0xa4c5519ad114506cu},
    {"cube:1:4", ANY_COUNT, 0, 0x6fc022e6c770aebcu},
    {"cube:30000", 30000u, 0.05, 0x6e3930818ec70a9au},
};

static void every_scene_is_well_formed_and_pinned(void **unused)
{
    (void)unused;
    for (size_t k = 0; k < sizeof expected / sizeof expected[0]; ++k) {
        const expected_scene *row = &expected[k];
        scene *made = create(row->spec);
        const svo_mesh *mesh = scene_mesh(made);
        check_well_formed(row->spec, mesh);
        const double error = fabs((double)mesh->triangle_count - row->requested);
        if (row->requested != ANY_COUNT && error > row->tolerance * row->requested) {
            fail_msg("%s: %zu triangles, requested %u, allowed error %g", row->spec, mesh->triangle_count,
                     row->requested, row->tolerance * row->requested);
        }
        const uint64_t hash = mesh_hash(mesh);
        if (row->hash != 0 && hash != row->hash) {
            fail_msg("%s: hash 0x%016llx, pinned 0x%016llx", row->spec, (unsigned long long)hash,
                     (unsigned long long)row->hash);
        }
        scene_destroy(&made);
        assert_null(made);
    }
}

static void bytes_depend_only_on_request_and_seed(void **unused)
{
    (void)unused;
    const scene_description *description;
    for (size_t k = 0; (description = scene_describe(k)) != NULL; ++k) {
        char spec[64];
        uint64_t hashes[3];
        for (uint32_t run = 0; run < 3; ++run) {
            (void)snprintf(spec, sizeof spec, "%s:3000:%u", description->name, run == 2 ? 8u : 5u);
            scene *made = create(spec);
            hashes[run] = mesh_hash(scene_mesh(made));
            scene_destroy(&made);
        }
        assert_true(hashes[0] == hashes[1]);
        if (hashes[0] == hashes[2]) {
            fail_msg("%s: seeds 5 and 8 give the same mesh", description->name);
        }
    }
}

static void the_default_count_matches_the_description(void **unused)
{
    (void)unused;
    const scene_description *description;
    for (size_t k = 0; (description = scene_describe(k)) != NULL; ++k) {
        scene *made = create(description->name);
        const double requested = description->default_triangles;
        const double count = (double)scene_mesh(made)->triangle_count;
        if (fabs(count - requested) > 0.025 * requested) {
            fail_msg("%s: %g triangles by default, described as %g", description->name, count, requested);
        }
        assert_true(strlen(description->summary) > 10);
        scene_destroy(&made);
    }
}

/* ---- closedness ---- */

static int compare_edges(const void *a, const void *b)
{
    const uint64_t first = *(const uint64_t *)a;
    const uint64_t second = *(const uint64_t *)b;
    return first < second ? -1 : first > second ? 1 : 0;
}

/* Every directed edge occurs once and so does its reverse: closed, edge-manifold and consistently oriented. */
static void check_closed(const char *spec)
{
    scene *made = create(spec);
    const svo_mesh *mesh = scene_mesh(made);
    const size_t edge_count = 3 * mesh->triangle_count;
    uint64_t *edges = malloc(edge_count * sizeof *edges);
    uint64_t *reversed = malloc(edge_count * sizeof *reversed);
    assert_non_null(edges);
    assert_non_null(reversed);
    for (size_t corner = 0; corner < edge_count; ++corner) {
        const uint64_t from = mesh->indices[corner];
        const uint64_t to = mesh->indices[corner % 3 == 2 ? corner - 2 : corner + 1];
        assert_true(from != to);
        edges[corner] = from << 32 | to;
        reversed[corner] = to << 32 | from;
    }
    qsort(edges, edge_count, sizeof *edges, compare_edges);
    qsort(reversed, edge_count, sizeof *reversed, compare_edges);
    for (size_t k = 0; k < edge_count; ++k) {
        if (edges[k] != reversed[k] || (k > 0 && edges[k] == edges[k - 1])) {
            fail_msg("%s: edge %u to %u is open or used twice", spec, (unsigned)(edges[k] >> 32), (unsigned)edges[k]);
        }
    }
    free(edges);
    free(reversed);
    scene_destroy(&made);
}

static void statue_and_knot_are_closed_manifolds(void **unused)
{
    (void)unused;
    static const char *const specs[] = {"statue", "statue:1",    "statue:600:3", "statue:20000:9", "statue:400000",
                                        "knot:1", "knot:1001:1", "knot",         "knot:20000:2",   "knot:20000:3"};
    for (size_t k = 0; k < sizeof specs / sizeof specs[0]; ++k) {
        check_closed(specs[k]);
    }
}

/* The signed volume is positive when triangles are counter-clockwise seen from outside. */
static void closed_scenes_face_outwards(void **unused)
{
    (void)unused;
    static const char *const specs[] = {"statue:5000", "knot:5000", "cube:48"};
    for (size_t k = 0; k < sizeof specs / sizeof specs[0]; ++k) {
        scene *made = create(specs[k]);
        const svo_mesh *mesh = scene_mesh(made);
        double volume = 0;
        for (size_t triangle = 0; triangle < mesh->triangle_count; ++triangle) {
            const float *a = mesh->positions + 3 * mesh->indices[3 * triangle];
            const float *b = mesh->positions + 3 * mesh->indices[3 * triangle + 1];
            const float *c = mesh->positions + 3 * mesh->indices[3 * triangle + 2];
            volume += (double)a[0] * ((double)b[1] * c[2] - (double)b[2] * c[1]) +
                      (double)a[1] * ((double)b[2] * c[0] - (double)b[0] * c[2]) +
                      (double)a[2] * ((double)b[0] * c[1] - (double)b[1] * c[0]);
        }
        if (volume <= 0) {
            fail_msg("%s: signed volume %g", specs[k], volume / 6);
        }
        scene_destroy(&made);
    }
}

/* A triangle's front side is the side of its vertex normals; in a coarse mesh, a few triangles may deviate. */
static void normals_are_on_the_outer_side(void **unused)
{
    (void)unused;
    const scene_description *description;
    for (size_t kind = 0; (description = scene_describe(kind)) != NULL; ++kind) {
        scene *made = create(description->name);
        const svo_mesh *mesh = scene_mesh(made);
        size_t turned_away = 0;
        for (size_t triangle = 0; triangle < mesh->triangle_count; ++triangle) {
            double edges[2][3];
            double normal[3];
            const uint32_t *corners = mesh->indices + 3 * triangle;
            for (size_t axis = 0; axis < 3; ++axis) {
                const double first = (double)mesh->positions[3 * corners[0] + axis];
                edges[0][axis] = (double)mesh->positions[3 * corners[1] + axis] - first;
                edges[1][axis] = (double)mesh->positions[3 * corners[2] + axis] - first;
                normal[axis] = (double)mesh->normals[3 * corners[0] + axis] +
                               (double)mesh->normals[3 * corners[1] + axis] +
                               (double)mesh->normals[3 * corners[2] + axis];
            }
            const double side = (edges[0][1] * edges[1][2] - edges[0][2] * edges[1][1]) * normal[0] +
                                (edges[0][2] * edges[1][0] - edges[0][0] * edges[1][2]) * normal[1] +
                                (edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0]) * normal[2];
            turned_away += side < 0;
        }
        if (50 * turned_away > mesh->triangle_count) {
            fail_msg("%s: %zu of %zu triangles face away from their normals", description->name, turned_away,
                     mesh->triangle_count);
        }
        scene_destroy(&made);
    }
}

/* ---- errors ---- */

static void bad_requests_are_one_line_errors(void **unused)
{
    (void)unused;
    static const char *const rows[][2] = {
        {"teapot", "atrium, statue, knot, terrain, needles, dust, cornell, cube"},
        {"", "there are atrium"},
        {"cube:", "from 1 to 50000000"},
        {"cube:0", "from 1 to 50000000"},
        {"cube:-3", "from 1 to 50000000"},
        {"cube:12x", "from 1 to 50000000"},
        {"cube:50000001", "from 1 to 50000000"},
        {"cube:99999999999999999999", "from 1 to 50000000"},
        {"cube:12:", "from 0 to 4294967295"},
        {"cube:12:4294967296", "from 0 to 4294967295"},
        {"cube:12:1:1", "NAME[:triangles[:seed]]"},
    };
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; ++k) {
        scene *made = NULL;
        svo_message message = {""};
        assert_int_equal(scene_create(rows[k][0], &made, &message), SVO_INVALID_ARGUMENT);
        assert_null(made);
        if (strstr(message.text, rows[k][1]) == NULL || strchr(message.text, '\n') != NULL) {
            fail_msg("'%s': message '%s' lacks '%s'", rows[k][0], message.text, rows[k][1]);
        }
        assert_int_equal(scene_create(rows[k][0], &made, NULL), SVO_INVALID_ARGUMENT);
    }
}

/* ---- files ---- */

static char folder[] = "/tmp/svocl_scenes_XXXXXX";

static int make_folder(void **unused)
{
    (void)unused;
    return mkdtemp(folder) == NULL ? -1 : 0;
}

/* Removes every file in the folder and returns how many there were. */
static int empty_folder(void)
{
    int count = 0;
    DIR *directory = opendir(folder);
    const struct dirent *entry;
    while (directory != NULL && (entry = readdir(directory)) != NULL) {
        char path[512];
        (void)snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        count += unlink(path) == 0;
    }
    if (directory != NULL) {
        closedir(directory);
    }
    return count;
}

static int remove_folder(void **unused)
{
    (void)unused;
    (void)empty_folder();
    return rmdir(folder);
}

static void path_in_folder(char path[512], const char *name)
{
    (void)snprintf(path, 512, "%s/%s", folder, name);
}

static FILE *create_file(const char *name)
{
    char path[512];
    path_in_folder(path, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    return file;
}

static void write_obj(const svo_mesh *mesh, const char *name, const char *library_name)
{
    FILE *file = create_file(name);
    assert_int_equal(scene_write_obj(mesh, library_name, file, NULL), SVO_OK);
    assert_int_equal(fclose(file), 0);
}

static void write_ply(const svo_mesh *mesh, const char *name)
{
    FILE *file = create_file(name);
    assert_int_equal(scene_write_ply(mesh, file, NULL), SVO_OK);
    assert_int_equal(fclose(file), 0);
}

/* The whole file, terminated; released by the caller. */
static char *read_file(const char *name)
{
    char path[512];
    path_in_folder(path, name);
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        fail_msg("cannot open %s", path);
    }
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    const size_t bytes = (size_t)ftell(file);
    rewind(file);
    char *text = malloc(bytes + 1);
    assert_non_null(text);
    assert_int_equal(fread(text, 1, bytes, file), bytes);
    text[bytes] = '\0';
    (void)fclose(file);
    return text;
}

/* The bytes of a color in 0 .. 1, rounded like an importer does. */
static int byte_of(double component)
{
    return (int)floor(component * 255 + 0.5);
}

/* Compares the OBJ text with the mesh, line by line. */
static void check_obj(const char *text, const svo_mesh *mesh)
{
    size_t vertices = 0;
    size_t normals = 0;
    size_t triangles = 0;
    unsigned material = 0;
    for (const char *line = text; line != NULL && *line != '\0'; line = strchr(line, '\n'), line += line != NULL) {
        float v[3];
        double c[3];
        unsigned i[6];
        if (sscanf(line, "v %f %f %f %lf %lf %lf", &v[0], &v[1], &v[2], &c[0], &c[1], &c[2]) == 6) {
            assert_memory_equal(v, mesh->positions + 3 * vertices, sizeof v);
            for (size_t k = 0; k < 3; ++k) {
                assert_int_equal(byte_of(c[k]), mesh->colors[4 * vertices + k]);
            }
            ++vertices;
        } else if (sscanf(line, "vn %f %f %f", &v[0], &v[1], &v[2]) == 3) {
            assert_memory_equal(v, mesh->normals + 3 * normals, sizeof v);
            ++normals;
        } else if (sscanf(line, "usemtl material_%u", &material) == 1) {
            assert_true(material < mesh->material_count);
        } else if (sscanf(line, "f %u//%u %u//%u %u//%u", &i[0], &i[1], &i[2], &i[3], &i[4], &i[5]) == 6) {
            for (size_t k = 0; k < 6; ++k) {
                assert_int_equal(i[k], mesh->indices[3 * triangles + k / 2] + 1);
            }
            assert_int_equal(material, mesh->material_count == 0 ? 0 : mesh->triangle_materials[triangles]);
            ++triangles;
        }
    }
    assert_int_equal(vertices, mesh->vertex_count);
    assert_int_equal(normals, mesh->vertex_count);
    assert_int_equal(triangles, mesh->triangle_count);
}

static void obj_files_hold_the_mesh(void **unused)
{
    (void)unused;
    static const char *const specs[] = {"cornell:500", "knot:1000", "needles:200", "dust:300"};
    for (size_t k = 0; k < sizeof specs / sizeof specs[0]; ++k) {
        scene *made = create(specs[k]);
        write_obj(scene_mesh(made), "mesh.obj", "mesh.mtl");
        char *text = read_file("mesh.obj");
        check_obj(text, scene_mesh(made));
        const bool has_materials = scene_mesh(made)->material_count > 0;
        assert_true((strstr(text, "mtllib mesh.mtl\n") != NULL) == has_materials);
        free(text);
        assert_int_equal(empty_folder(), 1);
        scene_destroy(&made);
    }
}

static void material_libraries_hold_the_base_colors(void **unused)
{
    (void)unused;
    scene *made = create("cornell:500");
    const svo_mesh *mesh = scene_mesh(made);
    FILE *file = create_file("box.mtl");
    scene_write_mtl(mesh, file);
    assert_int_equal(fclose(file), 0);
    char *text = read_file("box.mtl");
    const char *at = text;
    for (size_t k = 0; k < mesh->material_count; ++k) {
        unsigned number = 0;
        double c[3];
        at = strstr(at, "newmtl");
        assert_non_null(at);
        assert_int_equal(sscanf(at, "newmtl material_%u Kd %lf %lf %lf", &number, &c[0], &c[1], &c[2]), 4);
        assert_int_equal(number, k);
        for (size_t channel = 0; channel < 3; ++channel) {
            assert_int_equal(byte_of(c[channel]), mesh->materials[k].rgba[channel]);
        }
        at += 6;
    }
    free(text);
    (void)empty_folder();
    scene_destroy(&made);
}

static uint32_t word_at(const char *bytes)
{
    const uint8_t *b = (const uint8_t *)bytes;
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/* Compares the binary part of a PLY file with the mesh. */
static void check_ply(const char *bytes, const svo_mesh *mesh)
{
    size_t vertices = 0;
    size_t triangles = 0;
    const char *counts = strstr(bytes, "element vertex");
    assert_non_null(counts);
    assert_int_equal(sscanf(counts, "element vertex %zu", &vertices), 1);
    counts = strstr(bytes, "element face");
    assert_non_null(counts);
    assert_int_equal(sscanf(counts, "element face %zu", &triangles), 1);
    assert_int_equal(vertices, mesh->vertex_count);
    assert_int_equal(triangles, mesh->triangle_count);
    const char *record = strstr(bytes, "end_header\n") + strlen("end_header\n");
    for (size_t vertex = 0; vertex < vertices; ++vertex, record += 28) {
        assert_memory_equal(record, mesh->positions + 3 * vertex, 12);
        assert_memory_equal(record + 12, mesh->normals + 3 * vertex, 12);
        if (mesh->material_count == 0) {
            assert_memory_equal(record + 24, mesh->colors + 4 * vertex, 4);
        }
    }
    for (size_t triangle = 0; triangle < triangles; ++triangle, record += 13) {
        assert_int_equal(record[0], 3);
        for (size_t k = 0; k < 3; ++k) {
            assert_int_equal(word_at(record + 1 + 4 * k), mesh->indices[3 * triangle + k]);
        }
    }
}

static void ply_files_hold_the_mesh(void **unused)
{
    (void)unused;
    static const char *const specs[] = {"terrain:777", "statue:2000", "cornell:500"};
    for (size_t k = 0; k < sizeof specs / sizeof specs[0]; ++k) {
        scene *made = create(specs[k]);
        write_ply(scene_mesh(made), "mesh.ply");
        char *bytes = read_file("mesh.ply");
        check_ply(bytes, scene_mesh(made));
        free(bytes);
        assert_int_equal(empty_folder(), 1);
        scene_destroy(&made);
    }
}

static void ply_bakes_in_base_colors_or_reports_why_not(void **unused)
{
    (void)unused;
    const float positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    const float normals[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    uint8_t colors[16];
    memset(colors, 100, sizeof colors);
    const uint32_t indices[6] = {0, 1, 2, 2, 1, 3};
    const uint16_t same[2] = {1, 1};
    const uint16_t different[2] = {0, 1};
    const svo_material materials[2] = {{{255, 0, 0, 255}, SVO_NO_TEXTURE}, {{128, 255, 51, 255}, SVO_NO_TEXTURE}};
    svo_mesh mesh = {.struct_size = sizeof mesh,
                     .positions = positions,
                     .vertex_count = 4,
                     .indices = indices,
                     .triangle_count = 2,
                     .normals = normals,
                     .colors = colors,
                     .triangle_materials = same,
                     .materials = materials,
                     .material_count = 2};
    write_ply(&mesh, "quad.ply");
    char *bytes = read_file("quad.ply");
    const uint8_t baked[4] = {50, 100, 20, 100}; /* 100 * 128 / 255 = 50.2 */
    assert_memory_equal(strstr(bytes, "end_header\n") + strlen("end_header\n") + 24, baked, 4);
    free(bytes);
    mesh.triangle_materials = different;
    svo_message message = {""};
    FILE *file = create_file("quad.ply");
    assert_int_equal(scene_write_ply(&mesh, file, &message), SVO_UNSUPPORTED);
    assert_int_equal(ftell(file), 0);
    assert_int_equal(fclose(file), 0);
    assert_non_null(strstr(message.text, ".obj"));
    mesh.normals = NULL;
    assert_int_equal(scene_write_obj(&mesh, "", stdout, &message), SVO_UNSUPPORTED);
    assert_non_null(strstr(message.text, "normals"));
    assert_int_equal(empty_folder(), 1);
}

TEST_GROUP(scenes)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_scene_is_well_formed_and_pinned),
        cmocka_unit_test(bytes_depend_only_on_request_and_seed),
        cmocka_unit_test(the_default_count_matches_the_description),
        cmocka_unit_test(statue_and_knot_are_closed_manifolds),
        cmocka_unit_test(closed_scenes_face_outwards),
        cmocka_unit_test(normals_are_on_the_outer_side),
        cmocka_unit_test(bad_requests_are_one_line_errors),
        cmocka_unit_test(obj_files_hold_the_mesh),
        cmocka_unit_test(material_libraries_hold_the_base_colors),
        cmocka_unit_test(ply_files_hold_the_mesh),
        cmocka_unit_test(ply_bakes_in_base_colors_or_reports_why_not),
    };
    return cmocka_run_group_tests_name("scenes", tests, make_folder, remove_folder);
}
