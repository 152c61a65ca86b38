/* SPDX-License-Identifier: MIT */
/*
 * A tree that is built in parts and stitched is the tree in one piece: the files are equal byte for byte, however it is
 * cut, in whatever order the parts come, with every payload and coverage. Damaged parts are refused by name.
 */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "support/attributed_mesh.h"
#include "support/fixture.h"
#include "support/suite.h"
#include "svocl/io.h"
#include "svocl/parts.h"

#define PATH_BYTES 256
#define PARTS_MAX  4096
#define NEED_ALL   ((uint32_t)SVO_NEED_ALL)

static char directory[] = "/tmp/svocl-parts-XXXXXX";

/* How the grid is cut. */
typedef struct cut {
    uint32_t level; /* of the parts */
    uint64_t mixed; /* not 0: a seed; nodes above level are parts themselves as it decides */
    bool keep_empty; /* parts without triangles have files too */
} cut;

/* A tree that is being built in parts. */
typedef struct job {
    fixture opened;
    const svo_mesh *mesh;
    svo_part_header header;
    svo_builder builder;
    cut how;
    uint64_t state;
    char (*paths)[PATH_BYTES];
    size_t count;
} job;

static void path_of(const char *name, char path[PATH_BYTES])
{
    const int length = snprintf(path, PATH_BYTES, "%s/%s", directory, name);
    assert_true(length > 0 && length < PATH_BYTES);
}

static void check(const job *j, svo_status status, const svo_message *message)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status),
                 message != NULL ? message->text : svo_device_message(j->opened.device));
    }
}

static void save_part(job *j, svo_plan *plan, uint32_t level, uint64_t code)
{
    svo_tree *tree = NULL;
    svo_message message;
    assert_true(j->count < PARTS_MAX);
    char *path = j->paths[j->count++];
    char name[64];
    (void)snprintf(name, sizeof name, "%u-%llx.part", level, (unsigned long long)code);
    path_of(name, path);
    check(j, svo_build(plan, j->opened.frontend, j->opened.queue, &tree, NULL), NULL);
    check(j, svo_tree_download(tree, j->opened.queue), NULL);
    check(j, svo_part_save(tree, path, &message), &message);
    svo_tree_destroy(&tree);
}

static void build_part(job *j, uint32_t level, uint64_t code)
{
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    svo_plan *plan = NULL;
    options.part_header = &j->header;
    options.part_level = level;
    options.part_code = code;
    options.builder = j->builder;
    check(j, svo_plan_create(j->opened.device, j->mesh, j->header.depth, &options, &plan), NULL);
    assert_int_equal(svo_plan_get_info(plan, &info), SVO_OK);
    assert_int_equal(info.depth, j->header.depth - level);
    if (info.expected_fragments > 0.0 || j->how.keep_empty) {
        save_part(j, plan, level, code);
    }
    svo_plan_destroy(&plan);
}

static void cut_node(job *j, uint32_t level, uint64_t code)
{
    if (level == j->how.level || (j->how.mixed != 0 && level > 0 && random_below(&j->state, 3) == 0)) {
        build_part(j, level, code);
        return;
    }
    for (uint64_t octant = 0; octant < 8; ++octant) {
        cut_node(j, level + 1, code << 3 | octant);
    }
}

static char *read_file(const char *path, size_t *bytes)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    *bytes = (size_t)ftell(file);
    rewind(file);
    char *content = malloc(*bytes + 1);
    assert_non_null(content);
    assert_int_equal(fread(content, 1, *bytes, file), *bytes);
    (void)fclose(file);
    return content;
}

static void assert_same_files(const char *a, const char *b)
{
    size_t a_bytes = 0;
    size_t b_bytes = 0;
    char *first = read_file(a, &a_bytes);
    char *second = read_file(b, &b_bytes);
    assert_int_equal(a_bytes, b_bytes);
    for (size_t i = 0; i < a_bytes; ++i) {
        if (first[i] != second[i]) {
            fail_msg("byte %zu of %zu is %d in one piece, %d in parts", i, a_bytes, first[i], second[i]);
        }
    }
    free(first);
    free(second);
}

static void shuffle(job *j, const char **paths)
{
    for (size_t i = 0; i < j->count; ++i) {
        const size_t other = random_below(&j->state, (uint32_t)i + 1);
        paths[i] = paths[other];
        paths[other] = j->paths[i];
    }
}

static svo_status stitch(job *j, const char *out, svo_message *message)
{
    char mesh[PATH_BYTES];
    const char **paths = calloc(j->count + 1, sizeof *paths);
    assert_non_null(paths);
    path_of("mesh", mesh);
    shuffle(j, paths);
    const svo_status status = svo_parts_stitch(&j->header, paths, j->count,
                                               (j->header.need & SVO_NEED_RAYS) != 0 ? mesh : NULL, out, message);
    free(paths);
    return status;
}

/* Builds and saves the tree in one piece, and takes the header from its plan. */
static void build_whole(job *j, unsigned depth, const svo_plan_options *options)
{
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    svo_message message;
    char path[PATH_BYTES];
    path_of("whole.svo", path);
    check(j, svo_plan_create(j->opened.device, j->mesh, depth, options, &plan), NULL);
    j->header = (svo_part_header)SVO_PART_HEADER_INIT;
    check(j, svo_plan_get_part_header(plan, &j->header), NULL);
    check(j, svo_build(plan, j->opened.frontend, j->opened.queue, &tree, NULL), NULL);
    check(j, svo_tree_download(tree, j->opened.queue), NULL);
    check(j, svo_tree_save(tree, svo_to_path(path), NULL, &message), &message);
    svo_tree_destroy(&tree);
    if ((j->header.need & SVO_NEED_RAYS) != 0) {
        path_of("mesh", path);
        check(j, svo_part_save_mesh(plan, path, &message), &message);
    }
    svo_plan_destroy(&plan);
}

static void remove_parts(job *j)
{
    for (size_t i = 0; i < j->count; ++i) {
        assert_int_equal(unlink(j->paths[i]), 0);
    }
    j->count = 0;
}

static job open_job(void **state, const svo_mesh *mesh)
{
    job j = {.opened = fixture_cl_of_group(state), .mesh = mesh, .paths = calloc(PARTS_MAX, PATH_BYTES)};
    assert_non_null(j.paths);
    return j;
}

static void close_job(job *j)
{
    remove_parts(j);
    free(j->paths);
}

static void cut_and_compare(job *j, cut how)
{
    svo_message message;
    char whole[PATH_BYTES];
    char parts[PATH_BYTES];
    path_of("whole.svo", whole);
    path_of("parts.svo", parts);
    j->how = how;
    j->state = how.mixed + 1;
    cut_node(j, 0, 0);
    check(j, stitch(j, parts, &message), &message);
    assert_same_files(whole, parts);
    remove_parts(j);
}

static const cut cuts[] = {{0, 0, true}, {1, 0, false}, {2, 0, true}, {2, 1, false}, {3, 2, false}};

static void compare_cuts(void **state, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                         size_t cut_count)
{
    job j = open_job(state, mesh);
    build_whole(&j, depth, options);
    for (size_t i = 0; i < cut_count; ++i) {
        cut_and_compare(&j, cuts[i]);
    }
    close_job(&j);
}

static void test_every_cut(void **state)
{
    attributed_mesh made;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    attributed_mesh_create(7, 60, 0.0, &made);
    options.need = NEED_ALL;
    compare_cuts(state, &made.mesh, 6, &options, sizeof cuts / sizeof cuts[0]);
    attributed_mesh_destroy(&made);
}

/* One part per parent of leaves, and hundreds of parts, alone and mixed with larger ones. */
static void test_deepest_cuts(void **state)
{
    static const struct {
        unsigned depth, triangles;
        cut how;
    } deepest[] = {{4, 12, {3, 0, false}}, {5, 2, {4, 0, false}}, {6, 4, {4, 3, false}}};
    attributed_mesh made;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    options.need = NEED_ALL;
    for (size_t i = 0; i < sizeof deepest / sizeof deepest[0]; ++i) {
        attributed_mesh_create(8, deepest[i].triangles, 0.0, &made);
        job j = open_job(state, &made.mesh);
        build_whole(&j, deepest[i].depth, &options);
        cut_and_compare(&j, deepest[i].how);
        close_job(&j);
        attributed_mesh_destroy(&made);
    }
}

/* Triangles that reach outside a caller's grid, for each coverage and kind of weight. */
static void test_coverages(void **state)
{
    attributed_mesh made;
    attributed_mesh_create(9, 40, 0.7, &made);
    for (unsigned coverage = 0; coverage <= SVO_COVERAGE_THIN; ++coverage) {
        svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
        options.need = coverage == SVO_COVERAGE_THIN ? NEED_ALL & ~(uint32_t)SVO_NEED_FILL : NEED_ALL;
        options.coverage = (svo_coverage)coverage;
        options.weights = coverage == SVO_COVERAGE_THIN ? SVO_WEIGHTS_CENTER : SVO_WEIGHTS_AREA;
        options.edge = 1.0;
        compare_cuts(state, &made.mesh, 5, &options, 4);
    }
    attributed_mesh_destroy(&made);
}

/* Also where the payload has no color, or the color of nothing. */
static void test_dropped_pairs(void **state)
{
    static const uint32_t needs[] = {SVO_NEED_ALL, SVO_NEED_NONE, SVO_NEED_NORMAL};
    attributed_mesh made;
    attributed_mesh_create(19, 60, 0.0, &made);
    for (size_t i = 0; i < sizeof needs / sizeof needs[0]; ++i) {
        svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
        options.need = needs[i];
        options.drop_alpha = 0.3;
        compare_cuts(state, &made.mesh, 5, &options, 4);
    }
    made.mesh.colors = NULL;
    made.mesh.texture_count = made.mesh.material_count = 1;
    made.materials[0].rgba[3] = 60;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    options.need = SVO_NEED_COLOR;
    options.drop_alpha = 0.3;
    compare_cuts(state, &made.mesh, 4, &options, 3);
    attributed_mesh_destroy(&made);
}

static void test_payload_levels(void **state)
{
    attributed_mesh made;
    attributed_mesh_create(10, 40, 0.0, &made);
    for (unsigned level = 1; level <= 5; ++level) {
        svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
        options.need = NEED_ALL;
        options.payload_level = level;
        compare_cuts(state, &made.mesh, 5, &options, 4);
    }
    attributed_mesh_destroy(&made);
}

/* Depths with longer codes, with finer snapping, and the least; with the other builder. */
static void test_depths(void **state)
{
    static const unsigned depths[] = {1, 10, 11, 12, 13, 16};
    const double corner[3] = {0.499, 0.499, 0.499};
    owned_mesh dust;
    random_dust(11, 30, corner, 0.002, &dust);
    for (size_t i = 0; i < sizeof depths / sizeof depths[0]; ++i) {
        svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
        options.need = (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_FILL;
        options.edge = 1.0;
        job j = open_job(state, &dust.mesh);
        build_whole(&j, depths[i], &options);
        j.builder = SVO_BUILDER_SORTED;
        cut_and_compare(&j, (cut){depths[i] > 1 ? 2 : 0, 0, false});
        close_job(&j);
    }
    owned_mesh_free(&dust);
}

/* Two squares of equal area and different material in each part; every node above has a tie. */
static void test_materials_tie(void **state)
{
    static const float positions[] = {0, 0, 0, 8, 0, 0, 0, 8, 0, 8, 8, 0, 0, 0, 8, 8, 0, 8, 0, 8, 8, 8, 8, 8};
    static const uint32_t indices[] = {0, 1, 2, 3, 2, 1, 4, 5, 6, 7, 6, 5};
    static const uint16_t materials[] = {2, 1, 1, 2};
    static const svo_material all[3] = {
        {{255, 0, 0, 255}, SVO_NO_TEXTURE}, {{0, 255, 0, 255}, SVO_NO_TEXTURE}, {{0, 0, 255, 255}, SVO_NO_TEXTURE}};
    svo_mesh mesh = SVO_MESH_INIT;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    mesh.positions = positions;
    mesh.vertex_count = 8;
    mesh.indices = indices;
    mesh.triangle_count = 4;
    mesh.triangle_materials = materials;
    mesh.materials = all;
    mesh.material_count = 3;
    options.need = (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_COLOR;
    compare_cuts(state, &mesh, 4, &options, 4);
}

/* Triangles whose corners and edges lie on the faces, edges and corners of parts. */
static void test_triangles_on_faces(void **state)
{
    uint64_t random = 12;
    enum { TRIANGLES = 80 };
    float positions[TRIANGLES * 9];
    svo_mesh mesh = SVO_MESH_INIT;
    for (size_t i = 0; i < TRIANGLES * 9; ++i) {
        positions[i] = 0.25f * (float)random_below(&random, 5);
    }
    mesh.positions = positions;
    mesh.vertex_count = (size_t)TRIANGLES * 3;
    mesh.triangle_count = TRIANGLES;
    for (unsigned coverage = 0; coverage <= SVO_COVERAGE_CLOSED; ++coverage) {
        svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
        options.need = NEED_ALL;
        options.coverage = (svo_coverage)coverage;
        options.edge = 1.0;
        compare_cuts(state, &mesh, 5, &options, 4);
    }
}

static void test_empty_trees(void **state)
{
    const float far[9] = {5, 5, 5, 6, 5, 5, 5, 6, 5};
    svo_mesh mesh = SVO_MESH_INIT;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    mesh.positions = far;
    mesh.vertex_count = 3;
    mesh.triangle_count = 1;
    options.need = NEED_ALL;
    options.edge = 1.0;
    compare_cuts(state, &mesh, 3, &options, 3);
}

/* A part may be built from the triangles that meet it alone. */
static void test_triangles_of_a_part(void **state)
{
    attributed_mesh made;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_message message;
    char paths[2][PATH_BYTES];
    attributed_mesh_create(13, 60, 0.0, &made);
    options.need = NEED_ALL;
    options.edge = 1.0;
    job j = open_job(state, &made.mesh);
    build_whole(&j, 5, &options);
    build_part(&j, 1, 3);
    assert_int_equal(j.count, 1);
    path_of("other", paths[0]);
    assert_int_equal(rename(j.paths[0], paths[0]), 0);

    uint32_t names[60] = {0};
    uint32_t indices[180];
    size_t count = 0;
    for (uint32_t t = 0; t < 60; ++t) {
        double high[2] = {-1.0, -1.0};
        double low_z = 2.0;
        for (unsigned corner = 0; corner < 3; ++corner) {
            const double *at = made.base.positions + 3 * (size_t)made.mesh.indices[3 * t + corner];
            high[0] = at[0] > high[0] ? at[0] : high[0];
            high[1] = at[1] > high[1] ? at[1] : high[1];
            low_z = at[2] < low_z ? at[2] : low_z;
        }
        /* part 3 has the high x and y and the low z */
        if (high[0] > 0.45 && high[1] > 0.45 && low_z < 0.55) {
            memcpy(indices + 3 * count, made.mesh.indices + 3 * (size_t)t, 3 * sizeof *indices);
            names[count++] = t;
        }
    }
    assert_true(count > 0 && count < 60);
    uint16_t materials[60];
    for (size_t i = 0; i < count; ++i) {
        materials[i] = made.mesh.triangle_materials[names[i]];
    }
    svo_mesh some = made.mesh;
    some.indices = indices;
    some.triangle_count = count;
    some.triangle_materials = materials;
    svo_plan *plan = NULL;
    svo_plan_options part = SVO_PLAN_OPTIONS_INIT;
    part.part_header = &j.header;
    part.part_level = 1;
    part.part_code = 3;
    part.part_triangles = names;
    check(&j, svo_plan_create(j.opened.device, &some, 5, &part, &plan), NULL);
    j.count = 0;
    save_part(&j, plan, 1, 3);
    svo_plan_destroy(&plan);
    assert_same_files(paths[0], j.paths[0]);
    svo_part_info info = SVO_PART_INFO_INIT;
    check(&j, svo_part_check(&j.header, paths[0], &info, &message), &message);
    assert_int_equal(info.level, 1);
    assert_int_equal(info.code, 3);
    assert_true(info.leaf_count > 0 && info.node_count > info.leaf_count && info.fragments >= info.leaf_count);
    assert_int_equal(unlink(paths[0]), 0);
    close_job(&j);
    attributed_mesh_destroy(&made);
}

static void write_file(const char *path, const char *bytes, size_t count)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, count, file), count);
    assert_int_equal(fclose(file), 0);
}

/* Writes one byte into a file that is there. */
static void overwrite(const char *path, long at, char byte)
{
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    assert_int_equal(fseek(file, at, SEEK_SET), 0);
    assert_int_equal(fputc((unsigned char)byte, file), (unsigned char)byte);
    assert_int_equal(fclose(file), 0);
}

static void assert_refused(const job *j, const char *path)
{
    svo_message message;
    const svo_status status = svo_part_check(&j->header, path, NULL, &message);
    assert_int_equal(status, SVO_FILE_DAMAGED);
    assert_non_null(strstr(message.text, path));
}

/* Every truncation and every flipped byte of a part. */
static void test_damaged_parts(void **state)
{
    attributed_mesh made;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_message message;
    char out[PATH_BYTES];
    size_t bytes = 0;
    attributed_mesh_create(14, 4, 0.0, &made);
    options.need = NEED_ALL;
    job j = open_job(state, &made.mesh);
    build_whole(&j, 3, &options);
    build_part(&j, 0, 0);
    char *content = read_file(j.paths[0], &bytes);
    for (size_t i = 0; i < bytes; ++i) {
        const char flipped = (char)(content[i] ^ 1 << i % 8);
        overwrite(j.paths[0], (long)i, flipped);
        assert_refused(&j, j.paths[0]);
        overwrite(j.paths[0], (long)i, content[i]);
    }
    check(&j, svo_part_check(&j.header, j.paths[0], NULL, &message), &message);
    for (size_t i = bytes; i-- > 0;) {
        assert_int_equal(truncate(j.paths[0], (off_t)i), 0);
        assert_refused(&j, j.paths[0]);
    }
    /* a file that is damaged where only its segments say so leaves no tree */
    path_of("damaged.svo", out);
    content[bytes - 1] = (char)(content[bytes - 1] ^ 1);
    write_file(j.paths[0], content, bytes);
    assert_int_equal(stitch(&j, out, &message), SVO_FILE_DAMAGED);
    assert_int_equal(access(out, F_OK), -1);
    /* that of another tree */
    content[bytes - 1] = (char)(content[bytes - 1] ^ 1);
    write_file(j.paths[0], content, bytes);
    j.header.weight_log2 += 1;
    assert_refused(&j, j.paths[0]);
    free(content);
    close_job(&j);
    attributed_mesh_destroy(&made);
}

/* Parts that overlap are refused, and both are named or one of them. */
static void test_overlap(void **state)
{
    attributed_mesh made;
    svo_message message;
    char out[PATH_BYTES];
    attributed_mesh_create(15, 30, 0.0, &made);
    job j = open_job(state, &made.mesh);
    build_whole(&j, 4, NULL);
    build_part(&j, 1, 2);
    for (uint64_t octant = 0; octant < 8; ++octant) {
        build_part(&j, 2, 2 << 3 | octant);
    }
    assert_true(j.count > 1);
    path_of("overlap.svo", out);
    assert_int_equal(stitch(&j, out, &message), SVO_FILE_DAMAGED);
    assert_non_null(strstr(message.text, "overlaps"));
    assert_int_equal(access(out, F_OK), -1);
    close_job(&j);
    attributed_mesh_destroy(&made);
}

/* Bytes of a part file's head, as parts.h documents them. */
enum { HEAD_SEGMENTS = 12, HEAD_HASH = 24, HEAD_HASHED = 32, HEAD_LEVELS = 136, HEAD_BYTES = 208, SEGMENT_BYTES = 32 };

/* Rewrites the head of a part of 12 levels: full levels down to the tenth, 3 * 10^9 nodes below, a right checksum.
   Returns how many nodes that are. */
static uint64_t promise_nodes(const char *path)
{
    size_t bytes = 0;
    char *content = read_file(path, &bytes);
    uint32_t segments = 0;
    uint32_t begin = 0;
    memcpy(&segments, content + HEAD_SEGMENTS, sizeof segments);
    for (uint32_t level = 0; level <= 12; ++level) {
        begin += level <= 10 ? 1u << (3 * level) : 1500000000u;
        memcpy(content + HEAD_LEVELS + sizeof begin * (level + 1), &begin, sizeof begin);
    }
    const uint64_t hash =
        XXH3_64bits(content + HEAD_HASHED, HEAD_BYTES - HEAD_HASHED + (size_t)segments * SEGMENT_BYTES);
    memcpy(content + HEAD_HASH, &hash, sizeof hash);
    write_file(path, content, bytes);
    free(content);
    return begin;
}

/* Parts that each fit 32 bits and do not together: refused by the exact number before anything is written. */
static void test_too_many_nodes(void **state)
{
    const double corner[3] = {0.499, 0.499, 0.499};
    owned_mesh dust;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_message message;
    char out[PATH_BYTES];
    char number[32];
    random_dust(22, 8, corner, 0.002, &dust);
    options.edge = 1.0;
    job j = open_job(state, &dust.mesh);
    build_whole(&j, 13, &options);
    build_part(&j, 1, 0);
    build_part(&j, 1, 7);
    assert_int_equal(j.count, 2);
    uint64_t nodes = 1;
    for (size_t i = 0; i < j.count; ++i) {
        nodes += promise_nodes(j.paths[i]);
    }
    path_of("many.svo", out);
    assert_int_equal(stitch(&j, out, &message), SVO_CAPACITY_EXCEEDED);
    (void)snprintf(number, sizeof number, " %llu nodes", (unsigned long long)nodes);
    assert_non_null(strstr(message.text, number));
    assert_int_equal(access(out, F_OK), -1);
    close_job(&j);
    owned_mesh_free(&dust);
}

static void test_bad_requests(void **state)
{
    attributed_mesh made;
    attributed_mesh_create(16, 10, 0.0, &made);
    job j = open_job(state, &made.mesh);
    build_whole(&j, 4, NULL);
    const struct {
        unsigned depth;
        uint32_t level;
        uint64_t code;
        svo_place place;
        svo_status status;
        const char *names;
    } requests[] = {{5, 1, 0, SVO_PLACE_DEFAULT, SVO_INVALID_ARGUMENT, "another depth"},
                    {4, 4, 0, SVO_PLACE_DEFAULT, SVO_INVALID_ARGUMENT, "part_level 4"},
                    {4, 2, 64, SVO_PLACE_DEFAULT, SVO_INVALID_ARGUMENT, "part_code 64"},
                    {4, 1, 0, SVO_PLACE_DEVICE, SVO_UNSUPPORTED, "place"}};
    for (size_t i = 0; i < sizeof requests / sizeof requests[0]; ++i) {
        svo_plan *plan = NULL;
        svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
        options.part_header = &j.header;
        options.part_level = requests[i].level;
        options.part_code = requests[i].code;
        options.place = requests[i].place;
        assert_int_equal(svo_plan_create(j.opened.device, &made.mesh, requests[i].depth, &options, &plan),
                         requests[i].status);
        assert_non_null(strstr(svo_device_message(j.opened.device), requests[i].names));
    }
    close_job(&j);
    attributed_mesh_destroy(&made);
}

/* A part's tree is for svo_part_save alone, and a whole tree is no part. */
static void test_trees_of_parts(void **state)
{
    attributed_mesh made;
    svo_message message;
    char path[PATH_BYTES];
    attributed_mesh_create(17, 10, 0.0, &made);
    job j = open_job(state, &made.mesh);
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    options.need = NEED_ALL;
    build_whole(&j, 4, &options);
    options.part_header = &j.header;
    options.part_level = 1;
    check(&j, svo_plan_create(j.opened.device, &made.mesh, 4, &options, &plan), NULL);
    check(&j, svo_build(plan, NULL, NULL, &tree, NULL), NULL);
    check(&j, svo_tree_download(tree, NULL), NULL);
    path_of("part.svo", path);
    assert_int_equal(svo_tree_save(tree, svo_to_path(path), NULL, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_make_bvh(tree, SVO_BVH_BEST, NULL), SVO_INVALID_ARGUMENT);
    svo_part_header header = SVO_PART_HEADER_INIT;
    assert_int_equal(svo_plan_get_part_header(plan, &header), SVO_INVALID_ARGUMENT);
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    path_of("whole.svo", path);
    assert_int_equal(svo_tree_load(svo_from_path(path), NULL, &tree, &message), SVO_OK);
    assert_int_equal(svo_part_save(tree, path, &message), SVO_INVALID_ARGUMENT);
    svo_tree_destroy(&tree);
    close_job(&j);
    attributed_mesh_destroy(&made);
}

/* ---- folders ---- */

static void build_folder(const job *j, svo_device *device, const char *folder)
{
    svo_parts *parts = NULL;
    svo_message message;
    check(j, svo_parts_open(folder, &parts, &message), &message);
    for (size_t i = svo_parts_count(parts); i-- > 0;) {
        check(j, svo_parts_build(parts, i, device, NULL, NULL, &message), &message);
    }
    svo_parts_close(&parts);
}

static void finish_folder(const job *j, const char *folder, const char *path)
{
    svo_parts *parts = NULL;
    svo_message message;
    check(j, svo_parts_open(folder, &parts, &message), &message);
    check(j, svo_parts_finish(parts, path, &message), &message);
    svo_parts_close(&parts);
}

static size_t count_parts(const job *j, const char *folder)
{
    svo_parts *parts = NULL;
    svo_message message;
    check(j, svo_parts_open(folder, &parts, &message), &message);
    const size_t count = svo_parts_count(parts);
    svo_parts_close(&parts);
    return count;
}

static bool is_built(const job *j, const char *folder, size_t index)
{
    svo_parts *parts = NULL;
    svo_message message;
    int answer = 0;
    check(j, svo_parts_open(folder, &parts, &message), &message);
    check(j, svo_parts_is_built(parts, index, &answer, &message), &message);
    svo_parts_close(&parts);
    return answer != 0;
}

/* The place of a folder's files that are not parts. The folder has one plan. */
static void place_of(const char *folder, char place[PATH_BYTES + 48])
{
    svo_parts *parts = NULL;
    svo_message message;
    char identity[SVO_PARTS_IDENTITY_BYTES];
    assert_int_equal(svo_parts_open(folder, &parts, &message), SVO_OK);
    assert_int_equal(svo_parts_get_identity(parts, identity, &message), SVO_OK);
    (void)snprintf(place, PATH_BYTES + 48, "%s/%s", folder, identity);
    svo_parts_close(&parts);
}

/* Any limit gives the same file, in positions of either width. */
static void test_folders(void **state)
{
    attributed_mesh made;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_message message;
    char folder[PATH_BYTES];
    char whole[PATH_BYTES];
    char parts[PATH_BYTES];
    attributed_mesh_create(18, 300, 0.3, &made);
    options.need = NEED_ALL;
    options.edge = 1.0;
    path_of("folder", folder);
    path_of("whole.svo", whole);
    path_of("parts.svo", parts);
    for (unsigned coverage = 0; coverage <= SVO_COVERAGE_CLOSED; ++coverage) {
        options.coverage = (svo_coverage)coverage;
        job j = open_job(state, &made.mesh);
        build_whole(&j, 6, &options);
        size_t most = 0;
        for (uint64_t limit = 0; limit <= (uint64_t)1 << 30; limit = limit * 64 + 400000) {
            check(&j, svo_parts_create(j.opened.device, &made.mesh, 6, &options, limit, folder, &message), &message);
            most = count_parts(&j, folder) > most ? count_parts(&j, folder) : most;
            build_folder(&j, j.opened.device, folder);
            finish_folder(&j, folder, parts);
            assert_same_files(whole, parts);
            check(&j, svo_parts_remove(folder, &message), &message);
            assert_int_equal(access(folder, F_OK), -1);
        }
        assert_true(most > 8);
        close_job(&j);
    }
    attributed_mesh_destroy(&made);
}

/* Flips a bit of a file's byte: the last one, or the one in its middle. */
static void damage(const char *path, bool in_middle)
{
    size_t bytes = 0;
    char *content = read_file(path, &bytes);
    const size_t at = in_middle ? bytes / 2 : bytes - 1;
    content[at] = (char)(content[at] ^ 1);
    write_file(path, content, bytes);
    free(content);
}

static void damage_end(const char *path)
{
    damage(path, false);
}

/* Parts that change after they were built are found while they are put together, the file stays as it was, and the next
   build replaces them. */
static void test_parts_that_change(void **state)
{
    attributed_mesh made;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_message message;
    svo_parts *parts = NULL;
    char folder[PATH_BYTES];
    char whole[PATH_BYTES];
    char out[PATH_BYTES];
    char path[PATH_BYTES + 48];
    attributed_mesh_create(21, 100, 0.0, &made);
    path_of("folder", folder);
    path_of("whole.svo", whole);
    path_of("parts.svo", out);
    job j = open_job(state, &made.mesh);
    build_whole(&j, 5, &options);
    check(&j, svo_parts_create(j.opened.device, &made.mesh, 5, &options, 400000, folder, &message), &message);
    build_folder(&j, j.opened.device, folder);
    check(&j, svo_parts_open(folder, &parts, &message), &message);
    assert_true(svo_parts_count(parts) > 1);
    for (size_t i = 0; i < svo_parts_count(parts); ++i) {
        svo_parts_entry entry = SVO_PARTS_ENTRY_INIT;
        check(&j, svo_parts_get(parts, i, &entry, &message), &message);
        (void)snprintf(path, sizeof path, "%s/%u-%llx.part", folder, entry.level, (unsigned long long)entry.code);
        damage_end(path);
        write_file(out, "before", 6);
        assert_int_equal(svo_parts_finish(parts, out, &message), SVO_FILE_DAMAGED);
        assert_non_null(strstr(message.text, path));
        size_t bytes = 0;
        char *content = read_file(out, &bytes);
        assert_int_equal(bytes, 6);
        assert_memory_equal(content, "before", 6);
        free(content);
        check(&j, svo_parts_build(parts, i, j.opened.device, NULL, NULL, &message), &message);
    }
    svo_parts_close(&parts);
    finish_folder(&j, folder, out);
    assert_same_files(whole, out);
    check(&j, svo_parts_remove(folder, &message), &message);
    close_job(&j);
    attributed_mesh_destroy(&made);
}

/* A part that a device has too little memory for is split while it is built. A damaged note of that counts as none. */
static void test_small_devices(void **state)
{
    attributed_mesh made;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_device_options limited = SVO_DEVICE_OPTIONS_INIT;
    svo_device *device = NULL;
    svo_message message;
    char folder[PATH_BYTES];
    char whole[PATH_BYTES];
    char place[PATH_BYTES + 48];
    char split[PATH_BYTES + 96];
    char parts[PATH_BYTES];
    attributed_mesh_create(19, 200, 0.0, &made);
    options.need = NEED_ALL;
    path_of("folder", folder);
    path_of("whole.svo", whole);
    path_of("parts.svo", parts);
    job j = open_job(state, &made.mesh);
    build_whole(&j, 6, &options);
    check(&j, svo_parts_create(j.opened.device, &made.mesh, 6, &options, (uint64_t)1 << 40, folder, &message),
          &message);
    assert_int_equal(count_parts(&j, folder), 1);
    limited.max_device_bytes = 3000000;
    check(&j, svo_device_create_default(&limited, &device, &message), &message);
    build_folder(&j, device, folder);
    place_of(folder, place);
    (void)snprintf(split, sizeof split, "%s/0-0.split", place);
    assert_int_equal(access(split, F_OK), 0);
    finish_folder(&j, folder, parts);
    assert_same_files(whole, parts);
    damage_end(split);
    assert_false(is_built(&j, folder, 0));
    build_folder(&j, device, folder);
    assert_true(is_built(&j, folder, 0));
    svo_device_destroy(&device);
    finish_folder(&j, folder, parts);
    assert_same_files(whole, parts);
    check(&j, svo_parts_remove(folder, &message), &message);
    close_job(&j);
    attributed_mesh_destroy(&made);
}

/* ---- triangles of parts that were split ---- */

/* A folder of one part that a small device has split, and split again. */
typedef struct divided_folder {
    attributed_mesh made;
    job opened;
    svo_device *device;
    svo_parts *parts;
    char folder[PATH_BYTES], whole[PATH_BYTES], out[PATH_BYTES];
} divided_folder;

static void open_divided(void **state, divided_folder *d)
{
    svo_device_options limited = SVO_DEVICE_OPTIONS_INIT;
    svo_message message;
    attributed_mesh_create(23, 200, 0.0, &d->made);
    path_of("folder", d->folder);
    path_of("whole.svo", d->whole);
    path_of("parts.svo", d->out);
    d->opened = open_job(state, &d->made.mesh);
    build_whole(&d->opened, 6, NULL);
    check(&d->opened,
          svo_parts_create(d->opened.opened.device, &d->made.mesh, 6, NULL, (uint64_t)1 << 40, d->folder, &message),
          &message);
    limited.max_device_bytes = 450000;
    check(&d->opened, svo_device_create_default(&limited, &d->device, &message), &message);
    build_folder(&d->opened, d->device, d->folder);
    check(&d->opened, svo_parts_open(d->folder, &d->parts, &message), &message);
}

static void close_divided(divided_folder *d)
{
    svo_message message;
    svo_parts_close(&d->parts);
    check(&d->opened, svo_parts_remove(d->folder, &message), &message);
    svo_device_destroy(&d->device);
    close_job(&d->opened);
    attributed_mesh_destroy(&d->made);
}

/* Finds a part of the deepest level. */
static void find_deep_part(const divided_folder *d, uint32_t *level, unsigned long long *code)
{
    DIR *opened = opendir(d->folder);
    assert_non_null(opened);
    *level = 0;
    for (const struct dirent *entry = readdir(opened); entry != NULL; entry = readdir(opened)) {
        unsigned found_level = 0;
        unsigned long long found_code = 0;
        char end = '\0';
        if (sscanf(entry->d_name, "%u-%llx.par%c", &found_level, &found_code, &end) == 3 && found_level > *level) {
            *level = found_level;
            *code = found_code;
        }
    }
    (void)closedir(opened);
}

/* A worker without the folder sends parts, but no triangles of those that it split. They come from the part's own, also
   where they are damaged. Without those, the words say what to do. */
static void test_triangles_that_are_missing(void **state)
{
    divided_folder d;
    svo_message message;
    uint32_t level = 0;
    unsigned long long code = 0;
    char place[PATH_BYTES + 48];
    char part[PATH_BYTES + 48];
    char above[PATH_BYTES + 96];
    char listed[PATH_BYTES + 96];
    open_divided(state, &d);
    find_deep_part(&d, &level, &code);
    assert_true(level >= 2);
    (void)snprintf(part, sizeof part, "%s/%u-%llx.part", d.folder, level, code);
    place_of(d.folder, place);
    (void)snprintf(above, sizeof above, "%s/%u-%llx.tri", place, level - 1, code >> 3);
    (void)snprintf(listed, sizeof listed, "%s/0-0.tri", place);
    char triangles[PATH_BYTES + 96];
    (void)snprintf(triangles, sizeof triangles, "%s/%u-%llx.tri", place, level, code);
    for (unsigned way = 0; way < 2; ++way) {
        damage_end(part);
        if (way == 0) {
            assert_int_equal(unlink(triangles), 0);
            assert_int_equal(unlink(above), 0);
        } else {
            damage_end(triangles);
        }
        check(&d.opened, svo_parts_build(d.parts, 0, d.device, NULL, NULL, &message), &message);
        check(&d.opened, svo_parts_finish(d.parts, d.out, &message), &message);
        assert_same_files(d.whole, d.out);
    }
    damage_end(part);
    assert_int_equal(unlink(triangles), 0);
    assert_int_equal(unlink(listed), 0);
    assert_int_equal(svo_parts_build(d.parts, 0, d.device, NULL, NULL, &message), SVO_FILE_ERROR);
    assert_non_null(strstr(message.text, "0-0.tri: cannot be opened"));
    assert_non_null(strstr(message.text, "planning the parts again"));
    close_divided(&d);
}

/* A changed byte in the plan or in triangles is found before anything is built from it. */
static void test_damaged_folders(void **state)
{
    attributed_mesh made;
    svo_message message;
    char folder[PATH_BYTES];
    char place[PATH_BYTES + 48];
    char path[PATH_BYTES + 96];
    attributed_mesh_create(20, 5, 0.0, &made);
    path_of("folder", folder);
    job j = open_job(state, &made.mesh);
    for (size_t i = 0; i < 2; ++i) {
        check(&j, svo_parts_create(j.opened.device, &made.mesh, 3, NULL, (uint64_t)1 << 40, folder, &message),
              &message);
        place_of(folder, place);
        (void)snprintf(path, sizeof path, i == 0 ? "%s/plan" : "%s/0-0.tri", i == 0 ? folder : place);
        size_t bytes = 0;
        char *content = read_file(path, &bytes);
        for (size_t at = 0; at < bytes; at += 3) {
            svo_parts *parts = NULL;
            content[at] = (char)(content[at] ^ 16);
            write_file(path, content, at % 2 == 0 ? bytes : at);
            svo_status status = svo_parts_open(folder, &parts, &message);
            if (status == SVO_OK) {
                status = svo_parts_build(parts, 0, j.opened.device, NULL, NULL, &message);
            }
            assert_int_equal(status, SVO_FILE_DAMAGED);
            assert_non_null(strstr(message.text, path));
            svo_parts_close(&parts);
            content[at] = (char)(content[at] ^ 16);
        }
        free(content);
        check(&j, svo_parts_remove(folder, &message), &message);
    }
    close_job(&j);
    attributed_mesh_destroy(&made);
}

/* Gives a folder's plan and its first part the version before, which only the plan's checksum covers. */
static void make_older(const char *folder, const char *part)
{
    char plan[PATH_BYTES + 16];
    size_t bytes = 0;
    (void)snprintf(plan, sizeof plan, "%s/plan", folder);
    char *content = read_file(plan, &bytes);
    content[16] = 1;
    const uint64_t sum = XXH3_64bits(content + 16, bytes - 16);
    memcpy(content + 8, &sum, sizeof sum);
    write_file(plan, content, bytes);
    free(content);
    overwrite(part, 8, 1);
}

/* Parts of version 1 are of the rounded mesh: they do not become parts of a tree of the mesh as it was given. */
static void test_older_folders(void **state)
{
    attributed_mesh made;
    svo_message message;
    svo_parts *parts = NULL;
    char folder[PATH_BYTES];
    char part[PATH_BYTES + 16];
    attributed_mesh_create(33, 20, 0.0, &made);
    path_of("folder", folder);
    (void)snprintf(part, sizeof part, "%s/0-0.part", folder);
    job j = open_job(state, &made.mesh);
    for (int turn = 0; turn < 2; ++turn) {
        check(&j, svo_parts_create(j.opened.device, &made.mesh, 3, NULL, (uint64_t)1 << 40, folder, &message),
              &message);
        assert_false(is_built(&j, folder, 0));
        build_folder(&j, j.opened.device, folder);
        assert_true(is_built(&j, folder, 0));
        make_older(folder, part);
        assert_int_equal(svo_parts_open(folder, &parts, &message), SVO_FILE_DAMAGED);
        assert_non_null(strstr(message.text, "plan: version 1 is not known, only 4; planning the parts again"));
    }
    const svo_part_header header = {.struct_size = sizeof header, .depth = 3};
    assert_int_equal(svo_part_check(&header, part, NULL, &message), SVO_FILE_DAMAGED);
    assert_non_null(strstr(message.text, "0-0.part: version 1 is not known, only 4"));
    check(&j, svo_parts_remove(folder, &message), &message);
    close_job(&j);
    attributed_mesh_destroy(&made);
}

/* A file of triangles of each of the first two parts of a folder, in memory. The caller frees them. */
typedef struct triangle_files {
    char paths[2][PATH_BYTES + 96];
    char *contents[2];
    size_t bytes[2];
} triangle_files;

static triangle_files make_triangle_files(const job *j, const svo_mesh *mesh, const char *folder)
{
    triangle_files files;
    svo_parts *parts = NULL;
    svo_message message;
    char place[PATH_BYTES + 48];
    check(j, svo_parts_create(j->opened.device, mesh, 5, NULL, 400000, folder, &message), &message);
    place_of(folder, place);
    check(j, svo_parts_open(folder, &parts, &message), &message);
    assert_true(svo_parts_count(parts) >= 2);
    for (size_t i = 0; i < 2; ++i) {
        svo_parts_entry entry = SVO_PARTS_ENTRY_INIT;
        check(j, svo_parts_get(parts, i, &entry, &message), &message);
        (void)snprintf(files.paths[i], sizeof files.paths[i], "%s/%u-%llx.tri", place, entry.level,
                       (unsigned long long)entry.code);
        files.contents[i] = read_file(files.paths[i], &files.bytes[i]);
    }
    svo_parts_close(&parts);
    return files;
}

static void free_triangle_files(triangle_files *files)
{
    free(files->contents[0]);
    free(files->contents[1]);
}

/* The first part does not build from these bytes, and the message has the text. */
static void expect_refused(const job *j, const triangle_files *own, const char *folder, const char *bytes,
                           size_t byte_count, const char *text)
{
    svo_parts *parts = NULL;
    svo_message message;
    write_file(own->paths[0], bytes, byte_count);
    check(j, svo_parts_open(folder, &parts, &message), &message);
    assert_int_equal(svo_parts_build(parts, 0, j->opened.device, NULL, NULL, &message), SVO_FILE_DAMAGED);
    if (strstr(message.text, own->paths[0]) == NULL || strstr(message.text, text) == NULL) {
        fail_msg("\"%s\", expected \"%s\"", message.text, text);
    }
    svo_parts_close(&parts);
}

/* Triangles of another mesh, of another part and of the first version, which knew neither, are not built from. */
static void test_triangles_of_another_plan(void **state)
{
    attributed_mesh made;
    attributed_mesh other;
    svo_message message;
    char folder[PATH_BYTES];
    attributed_mesh_create(31, 200, 0.0, &made);
    attributed_mesh_create(32, 200, 0.0, &other);
    path_of("folder", folder);
    job j = open_job(state, &made.mesh);
    triangle_files foreign = make_triangle_files(&j, &other.mesh, folder);
    check(&j, svo_parts_remove(folder, &message), &message);
    triangle_files own = make_triangle_files(&j, &made.mesh, folder);
    expect_refused(&j, &own, folder, foreign.contents[0], foreign.bytes[0], " belongs to plan ");
    expect_refused(&j, &own, folder, own.contents[1], own.bytes[1], "triangles of the part ");
    const size_t records = own.bytes[0] - 56;
    const uint64_t sum = XXH3_64bits(own.contents[0], records);
    char *older = malloc(own.bytes[0]);
    assert_non_null(older);
    memcpy(older, own.contents[0], own.bytes[0]);
    memcpy(older + records, &sum, sizeof sum);
    expect_refused(&j, &own, folder, older, records + sizeof sum, "no file of triangles of version 4");
    free(older);
    write_file(own.paths[0], own.contents[0], own.bytes[0]);
    build_folder(&j, j.opened.device, folder);
    check(&j, svo_parts_remove(folder, &message), &message);
    free_triangle_files(&foreign);
    free_triangle_files(&own);
    close_job(&j);
    attributed_mesh_destroy(&made);
    attributed_mesh_destroy(&other);
}

/* A folder that is planned anew: who opened it before builds and stitches nothing more, and says why. Parts of the plan
   before are of no use to the new one, nor is the place of its triangles, which is gone. */
static void test_planned_anew(void **state)
{
    attributed_mesh made;
    attributed_mesh other;
    svo_message message;
    svo_parts *before = NULL;
    svo_parts_lease *lease = NULL;
    char folder[PATH_BYTES];
    char place[PATH_BYTES + 48];
    char out[PATH_BYTES];
    attributed_mesh_create(31, 200, 0.0, &made);
    attributed_mesh_create(32, 200, 0.0, &other);
    path_of("folder", folder);
    path_of("parts.svo", out);
    job j = open_job(state, &made.mesh);
    check(&j, svo_parts_lease_take(folder, &lease, &message), &message);
    check(&j, svo_parts_create(j.opened.device, &other.mesh, 5, NULL, 400000, folder, &message), &message);
    check(&j, svo_parts_open(folder, &before, &message), &message);
    place_of(folder, place);
    check(&j, svo_parts_build(before, 0, j.opened.device, NULL, NULL, &message), &message);
    check(&j, svo_parts_create(j.opened.device, &made.mesh, 5, NULL, 400000, folder, &message), &message);
    assert_int_equal(access(place, F_OK), -1);
    assert_int_equal(svo_parts_build(before, 1, j.opened.device, NULL, NULL, &message), SVO_UNAVAILABLE);
    assert_non_null(strstr(message.text, strrchr(place, '/') + 1));
    assert_int_equal(svo_parts_finish(before, out, &message), SVO_UNAVAILABLE);
    assert_non_null(strstr(message.text, "planned anew meanwhile: this run belongs to plan "));
    svo_parts_close(&before);
    build_folder(&j, j.opened.device, folder);
    finish_folder(&j, folder, out);
    build_whole(&j, 5, NULL);
    path_of("whole.svo", folder);
    assert_same_files(folder, out);
    path_of("folder", folder);
    place_of(folder, place);
    check(&j, svo_parts_create(j.opened.device, &made.mesh, 5, NULL, 300000, folder, &message), &message);
    assert_int_equal(access(place, F_OK), 0);
    check(&j, svo_parts_lease_renew(lease, &message), &message);
    check(&j, svo_parts_remove(folder, &message), &message);
    assert_int_equal(svo_parts_lease_renew(lease, &message), SVO_UNAVAILABLE);
    svo_parts_lease_release(&lease);
    assert_null(lease);
    svo_parts_lease_release(&lease);
    assert_int_equal(svo_parts_lease_take(NULL, &lease, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_parts_lease_renew(NULL, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_parts_get_identity(NULL, place, &message), SVO_INVALID_ARGUMENT);
    close_job(&j);
    attributed_mesh_destroy(&made);
    attributed_mesh_destroy(&other);
}

static int setup(void **state)
{
    return mkdtemp(directory) != NULL ? fixture_group_setup(state) : -1;
}

static int teardown(void **state)
{
    static const char *const names[] = {"whole.svo", "parts.svo", "mesh"};
    char path[PATH_BYTES];
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        path_of(names[i], path);
        (void)unlink(path);
    }
    (void)rmdir(directory);
    return fixture_group_teardown(state);
}

/* ---- shares ---- */

/* A folder whose parts are built, and the tree in one piece. */
typedef struct shared_folder {
    job j;
    svo_parts *parts;
    char folder[PATH_BYTES], whole[PATH_BYTES], out[PATH_BYTES];
} shared_folder;

static void open_shared(void **state, const svo_mesh *mesh, unsigned depth, uint32_t need, shared_folder *f)
{
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_message message;
    options.need = need;
    options.edge = 1.0;
    f->j = open_job(state, mesh);
    path_of("folder", f->folder);
    path_of("whole.svo", f->whole);
    path_of("shares.svo", f->out);
    build_whole(&f->j, depth, &options);
    check(&f->j, svo_parts_create(f->j.opened.device, mesh, depth, &options, 400000, f->folder, &message), &message);
    build_folder(&f->j, f->j.opened.device, f->folder);
    check(&f->j, svo_parts_open(f->folder, &f->parts, &message), &message);
}

static void close_shared(shared_folder *f)
{
    svo_message message;
    svo_parts_close(&f->parts);
    check(&f->j, svo_parts_remove(f->folder, &message), &message);
    (void)unlink(f->out);
    close_job(&f->j);
}

/* Writes all shares, the last first. */
static void write_shares(const shared_folder *f, unsigned count)
{
    svo_message message;
    check(&f->j, svo_parts_shares_begin(f->parts, count, &message), &message);
    for (unsigned i = count; i-- > 0;) {
        check(&f->j, svo_parts_shares_write(f->parts, i, count, &message), &message);
    }
}

/* Any number of shares is the file of the tree in one piece, and leaves nothing behind. */
static void test_shares(void **state)
{
    static const unsigned counts[] = {1, 3, 64};
    attributed_mesh made;
    shared_folder f;
    svo_message message;
    attributed_mesh_create(18, 300, 0.3, &made);
    static const uint32_t needs[] = {NEED_ALL, SVO_NEED_DEFAULT};
    for (unsigned n = 0; n < 2; ++n) {
        open_shared(state, &made.mesh, 6, needs[n], &f);
        assert_true(svo_parts_count(f.parts) > 8);
        for (unsigned i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
            char command[4 * PATH_BYTES];
            write_shares(&f, counts[i]);
            assert_int_equal(svo_parts_shares_finish(f.parts, counts[i], f.out, &message), SVO_OK);
            assert_same_files(f.whole, f.out);
            (void)snprintf(command, sizeof command, "! ls %s/*/stitch-* %s/*/*.stitch %s/*/*.share 2>/dev/null",
                           f.folder, f.folder, f.folder);
            assert_int_equal(system(command), 0);
        }
        close_shared(&f);
    }
    attributed_mesh_destroy(&made);
}

/* A tree without a node but its root has no parts with nodes. */
static void test_shares_of_nothing(void **state)
{
    const float far[9] = {5, 5, 5, 6, 5, 5, 5, 6, 5};
    shared_folder f;
    svo_message message;
    svo_mesh mesh = SVO_MESH_INIT;
    mesh.positions = far;
    mesh.vertex_count = 3;
    mesh.triangle_count = 1;
    open_shared(state, &mesh, 4, NEED_ALL, &f);
    write_shares(&f, 3);
    check(&f.j, svo_parts_shares_finish(f.parts, 3, f.out, &message), &message);
    assert_same_files(f.whole, f.out);
    close_shared(&f);
}

static void expect_no_share(svo_status status, svo_status expected, const svo_message *message, const char *words)
{
    assert_int_equal(status, expected);
    if (strstr(message->text, words) == NULL) {
        fail_msg("'%s' has no '%s'", message->text, words);
    }
}

/* What is not written, or was written to a file that has its name, does not count. */
static void test_shares_that_are_missing(void **state)
{
    attributed_mesh made;
    shared_folder f;
    svo_message message;
    char command[4 * PATH_BYTES];
    attributed_mesh_create(18, 300, 0.3, &made);
    open_shared(state, &made.mesh, 6, NEED_ALL, &f);
    expect_no_share(svo_parts_shares_write(f.parts, 0, 3, &message), SVO_UNAVAILABLE, &message, "has not been begun");
    check(&f.j, svo_parts_shares_begin(f.parts, 3, &message), &message);
    check(&f.j, svo_parts_shares_write(f.parts, 0, 3, &message), &message);
    check(&f.j, svo_parts_shares_write(f.parts, 2, 3, &message), &message);
    expect_no_share(svo_parts_shares_finish(f.parts, 3, f.out, &message), SVO_UNAVAILABLE, &message,
                    "share 1 of 3 is not written");
    write_shares(&f, 3);
    (void)snprintf(command, sizeof command,
                   "cd %s/*/ && mkdir ../../kept && cp *.share ../../kept/ && truncate -s -1 *-1.share", f.folder);
    assert_int_equal(system(command), 0);
    expect_no_share(svo_parts_shares_finish(f.parts, 3, f.out, &message), SVO_UNAVAILABLE, &message, "share 1 of 3");
    assert_int_equal(access(f.out, F_OK), -1);
    write_shares(&f, 3);
    check(&f.j, svo_parts_shares_finish(f.parts, 3, f.out, &message), &message);
    check(&f.j, svo_parts_shares_begin(f.parts, 3, &message), &message);
    (void)snprintf(command, sizeof command, "mv %s/../kept/* %s/*/ && rmdir %s/../kept", f.folder, f.folder, f.folder);
    assert_int_equal(system(command), 0);
    expect_no_share(svo_parts_shares_finish(f.parts, 3, f.out, &message), SVO_UNAVAILABLE, &message, "share 0 of 3");
    assert_same_files(f.whole, f.out);
    close_shared(&f);
    attributed_mesh_destroy(&made);
}

/* A damaged part is named, and no file comes of it, until it is built again. */
static void test_shares_of_damaged_parts(void **state)
{
    attributed_mesh made;
    shared_folder f;
    svo_message message;
    char path[PATH_BYTES + 48];
    svo_parts_entry entry = SVO_PARTS_ENTRY_INIT;
    attributed_mesh_create(18, 300, 0.3, &made);
    open_shared(state, &made.mesh, 6, NEED_ALL, &f);
    check(&f.j, svo_parts_get(f.parts, 1, &entry, &message), &message);
    (void)snprintf(path, sizeof path, "%s/%u-%llx.part", f.folder, entry.level, (unsigned long long)entry.code);
    check(&f.j, svo_parts_shares_begin(f.parts, 1, &message), &message);
    damage(path, true);
    expect_no_share(svo_parts_shares_write(f.parts, 0, 1, &message), SVO_FILE_DAMAGED, &message, path);
    expect_no_share(svo_parts_shares_finish(f.parts, 1, f.out, &message), SVO_UNAVAILABLE, &message, "share 0 of 1");
    build_folder(&f.j, f.j.opened.device, f.folder);
    check(&f.j, svo_parts_shares_write(f.parts, 0, 1, &message), &message);
    check(&f.j, svo_parts_shares_finish(f.parts, 1, f.out, &message), &message);
    assert_same_files(f.whole, f.out);
    assert_int_equal(unlink(path), 0);
    expect_no_share(svo_parts_shares_begin(f.parts, 1, &message), SVO_FILE_ERROR, &message, "is missing");
    expect_no_share(svo_parts_shares_begin(f.parts, 0, &message), SVO_INVALID_ARGUMENT, &message, "count 0");
    expect_no_share(svo_parts_shares_begin(f.parts, 65537, &message), SVO_INVALID_ARGUMENT, &message, "count 65537");
    expect_no_share(svo_parts_shares_begin(NULL, 1, &message), SVO_INVALID_ARGUMENT, &message, "parts is NULL");
    expect_no_share(svo_parts_shares_write(f.parts, 1, 1, &message), SVO_INVALID_ARGUMENT, &message, "index 1");
    expect_no_share(svo_parts_shares_finish(f.parts, 1, NULL, &message), SVO_INVALID_ARGUMENT, &message, "path");
    close_shared(&f);
    attributed_mesh_destroy(&made);
}

TEST_GROUP(parts)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_cut),
        cmocka_unit_test(test_deepest_cuts),
        cmocka_unit_test(test_coverages),
        cmocka_unit_test(test_dropped_pairs),
        cmocka_unit_test(test_payload_levels),
        cmocka_unit_test(test_depths),
        cmocka_unit_test(test_materials_tie),
        cmocka_unit_test(test_triangles_on_faces),
        cmocka_unit_test(test_empty_trees),
        cmocka_unit_test(test_triangles_of_a_part),
        cmocka_unit_test(test_damaged_parts),
        cmocka_unit_test(test_overlap),
        cmocka_unit_test(test_too_many_nodes),
        cmocka_unit_test(test_bad_requests),
        cmocka_unit_test(test_trees_of_parts),
        cmocka_unit_test(test_folders),
        cmocka_unit_test(test_parts_that_change),
        cmocka_unit_test(test_small_devices),
        cmocka_unit_test(test_triangles_that_are_missing),
        cmocka_unit_test(test_damaged_folders),
        cmocka_unit_test(test_older_folders),
        cmocka_unit_test(test_triangles_of_another_plan),
        cmocka_unit_test(test_planned_anew),
        cmocka_unit_test(test_shares),
        cmocka_unit_test(test_shares_of_nothing),
        cmocka_unit_test(test_shares_that_are_missing),
        cmocka_unit_test(test_shares_of_damaged_parts),
    };
    return cmocka_run_group_tests_name("parts", tests, setup, teardown);
}
