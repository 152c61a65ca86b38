/* SPDX-License-Identifier: MIT */
/*
 * The inside of meshes: svo_solid_create, and OpenVDB's level set of the same snapped triangles, whose interior it
 * finds by filling from outside. Both are compared with the exact reference.
 */
#include "bench/subjects.h"

#include <math.h>
#include <stdlib.h>

#include "bench/openvdb.h"
#include "measure/solid_check.h"
#include "measure/spread.h"

static const char table_id[] = "solid";

/* Rows of the table end here: the reference is a dense grid. */
#define DEPTH_MAX 9

static const char note[] =
    "Methods run interleaved. Tree: plan and build with leaf lists; fill: svo_solid_create on that tree. OpenVDB: "
    "tools::meshToVolume on all cores, signed distances in a band of three voxels to each side, from the rounded "
    "triangles. Wrong: voxels that no triangle touches and that are not on the side of their center, by the exact "
    "reference. Ratio: svocl's tree and fill to OpenVDB, within each round.";

/* ---- the measurement ---- */

typedef struct solid_bench {
    suite *all;
    const input *source;
    unsigned depth;
    bool with_openvdb;
    double *tree_ms, *fill_ms, *other_ms, *ratio; /* of each round after the warm-up; tree_ms owns them */
    svo_tree *tree; /* of the last round, downloaded */
    svo_compact *solid;
    svo_tree_info tree_info;
    svo_tree_arrays arrays;
    svo_solid_info info;
    float *points; /* snapped vertices in units of voxels from the center of the first one */
    uint64_t *inside; /* OpenVDB's, a bit per voxel */
    uint64_t own_wrong, other_wrong;
} solid_bench;

static int fail_library(const solid_bench *b)
{
    return program_fail_library(b->all->state, svo_device_message(b->all->opened.device));
}

static int fail_memory(const solid_bench *b)
{
    return program_fail(b->all->state, PROGRAM_FAILED, "out of memory for the inside at depth %u", b->depth);
}

/* Builds and fills once. */
static int run_svocl(solid_bench *b, double *tree_ms, double *fill_ms)
{
    const svo_plan_options plan_options = {.struct_size = sizeof plan_options, .need = SVO_NEED_RAYS};
    svo_device *device = b->all->opened.device;
    svo_plan *plan = NULL;
    svo_compact_destroy(&b->solid);
    svo_tree_destroy(&b->tree);
    const double start_ms = input_now_ms();
    svo_status status = svo_plan_create(device, b->source->mesh, b->depth, &plan_options, &plan);
    if (status == SVO_OK) {
        status = svo_build(plan, b->all->opened.cl, b->all->opened.queue, &b->tree, NULL);
    }
    const double built_ms = input_now_ms();
    svo_plan_destroy(&plan);
    if (status == SVO_OK) {
        status = svo_solid_create(b->tree, NULL, b->all->opened.queue, &b->solid, &b->info);
    }
    *tree_ms = built_ms - start_ms;
    *fill_ms = input_now_ms() - built_ms;
    return status == SVO_OK ? PROGRAM_DONE : fail_library(b);
}

/* The results on the host, and the points for OpenVDB. */
static int download(solid_bench *b)
{
    if (svo_tree_download(b->tree, NULL) != SVO_OK || svo_compact_download(b->solid, NULL) != SVO_OK) {
        return fail_library(b);
    }
    (void)svo_tree_get_info(b->tree, &b->tree_info);
    (void)svo_tree_get_arrays(b->tree, &b->arrays);
    if (b->points == NULL) {
        const float voxel = (float)(1u << (b->tree_info.snap_bits - b->depth));
        b->points = malloc((size_t)b->tree_info.vertex_count * 3 * sizeof *b->points + 1);
        for (size_t i = 0; b->points != NULL && i < b->tree_info.vertex_count * 3; ++i) {
            b->points[i] = (float)b->arrays.vertices[i] / voxel - 0.5F;
        }
    }
    return b->points != NULL ? PROGRAM_DONE : fail_memory(b);
}

static int run_openvdb(solid_bench *b, double *ms)
{
    if (!b->with_openvdb) {
        return PROGRAM_DONE;
    }
    *ms = openvdb_fill(b->points, (size_t)b->tree_info.vertex_count, b->arrays.indices,
                       (size_t)b->tree_info.list_triangle_count, b->depth, b->inside);
    return *ms >= 0.0 ? PROGRAM_DONE : program_fail(b->all->state, PROGRAM_FAILED, "OpenVDB cannot take the triangles");
}

static int run_round(solid_bench *b, size_t round)
{
    double tree_ms = 0.0;
    double fill_ms = 0.0;
    double other_ms = 0.0;
    int exit_code = run_svocl(b, &tree_ms, &fill_ms);
    if (exit_code == PROGRAM_DONE) {
        exit_code = download(b);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = run_openvdb(b, &other_ms);
    }
    if (exit_code == PROGRAM_DONE && round > 0) {
        b->tree_ms[round - 1] = tree_ms;
        b->fill_ms[round - 1] = fill_ms;
        b->other_ms[round - 1] = other_ms;
        b->ratio[round - 1] = b->with_openvdb ? (tree_ms + fill_ms) / other_ms : 0.0;
    }
    return exit_code;
}

/* ---- wrong voxels ---- */

/* Voxels without a leaf of the tree that OpenVDB has on the other side than the reference. codes: of the leaves. */
static uint64_t count_other_wrong(const solid_bench *b, const oracle_solid *reference, const uint64_t *codes)
{
    uint64_t wrong = 0;
    uint64_t leaf = 0;
    for (uint64_t code = 0; code < UINT64_C(1) << 3 * b->depth; ++code) {
        uint32_t cell[3];
        if (leaf < b->tree_info.leaf_count && codes[leaf] == code) {
            ++leaf;
            continue;
        }
        svo_code_to_cell(code, cell);
        const uint64_t index = cell[0] + ((cell[1] + ((uint64_t)cell[2] << b->depth)) << b->depth);
        const bool inside = oracle_solid_votes(reference, cell[0], cell[1], cell[2]) >= 2;
        wrong += (b->inside[index / 64] >> index % 64 & 1) != (inside ? 1 : 0) ? 1 : 0;
    }
    return wrong;
}

static int judge_openvdb(solid_bench *b)
{
    const oracle_mesh mesh = {b->arrays.vertices, b->arrays.indices, NULL, (size_t)b->tree_info.list_triangle_count};
    const oracle_request request = {.depth = b->depth, .snap_bits = b->tree_info.snap_bits};
    uint64_t *codes = malloc((size_t)b->tree_info.leaf_count * sizeof *codes + 1);
    oracle_solid reference = {.depth = 0};
    const bool good =
        codes != NULL &&
        oracle_leaf_codes(b->arrays.child_mask, b->tree_info.inner_count, b->depth, b->tree_info.leaf_count, codes) &&
        oracle_solid_make(&mesh, &request, ORACLE_WINDING, &reference);
    if (good) {
        b->other_wrong = count_other_wrong(b, &reference, codes);
    }
    oracle_solid_free(&reference);
    free(codes);
    return good ? PROGRAM_DONE : fail_memory(b);
}

static int judge(solid_bench *b)
{
    solid_differences found;
    if (!solid_check(&b->tree_info, &b->arrays, b->solid, &b->info, SVO_SOLID_WINDING, &found)) {
        return fail_memory(b);
    }
    b->own_wrong = found.voxels.wrong_voxels + found.voxels.split_voxels;
    return b->with_openvdb ? judge_openvdb(b) : PROGRAM_DONE;
}

/* ---- the table ---- */

static int begin(suite *all)
{
    result_table *table = suite_add_table(all, table_id, "Solids: the inside of closed meshes", note);
    if (openvdb_is_there()) {
        result_extend_note(table, "OpenVDB %s.", openvdb_version());
    } else {
        result_extend_note(table, "Without OpenVDB: this program was built without libopenvdb-dev.");
    }
    result_add_column(table, "scene", "");
    result_add_column(table, "triangles", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "surface voxels", "");
    result_add_column(table, "inside voxels", "");
    result_add_column(table, "inside leaves", "");
    result_add_column(table, "tests", "");
    spread_add_columns(table, "tree", "ms");
    spread_add_columns(table, "fill", "ms");
    result_add_column(table, "wrong", "");
    spread_add_columns(table, "OpenVDB", "ms");
    result_add_column(table, "OpenVDB wrong", "");
    spread_add_columns(table, "ratio", "");
    return PROGRAM_DONE;
}

static void add_row(const solid_bench *b)
{
    result_table *table = result_find(b->all->results, table_id);
    const size_t count = b->all->repeats;
    result_add_text(table, "%s", suite_scene_name(b->source));
    result_add_number(table, (double)b->source->mesh->triangle_count);
    result_add_number(table, b->depth);
    result_add_number(table, (double)b->info.surface_voxels);
    result_add_number(table, (double)b->info.inside_voxels);
    result_add_number(table, (double)b->info.inside_leaves);
    result_add_number(table, (double)b->info.tests);
    spread_add(table, spread_of(b->tree_ms, count));
    spread_add(table, spread_of(b->fill_ms, count));
    result_add_number(table, (double)b->own_wrong);
    spread_add(table, b->with_openvdb ? spread_of(b->other_ms, count) : spread_none());
    result_add_number(table, b->with_openvdb ? (double)b->other_wrong : NAN);
    spread_add(table, b->with_openvdb ? spread_of(b->ratio, count) : spread_none());
}

static int allocate(solid_bench *b)
{
    const size_t count = b->all->repeats + 1;
    b->tree_ms = calloc(4 * count, sizeof *b->tree_ms);
    b->inside = calloc((((size_t)1 << 3 * b->depth) + 63) / 64, sizeof *b->inside);
    if (b->tree_ms == NULL || b->inside == NULL) {
        return fail_memory(b);
    }
    b->fill_ms = b->tree_ms + count;
    b->other_ms = b->fill_ms + count;
    b->ratio = b->other_ms + count;
    return PROGRAM_DONE;
}

static int run(suite *all, const input *source, unsigned depth)
{
    solid_bench b = {.all = all,
                     .source = source,
                     .depth = depth,
                     .with_openvdb = openvdb_is_there(),
                     .tree_info = SVO_TREE_INFO_INIT,
                     .arrays = SVO_TREE_ARRAYS_INIT,
                     .info = SVO_SOLID_INFO_INIT};
    if (depth > DEPTH_MAX) {
        return program_fail(all->state, PROGRAM_WRONG_USAGE, "bench solid takes depths up to %d, not %u", DEPTH_MAX,
                            depth);
    }
    int exit_code = allocate(&b);
    for (size_t round = 0; round <= all->repeats && exit_code == PROGRAM_DONE; ++round) {
        exit_code = run_round(&b, round);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = judge(&b);
    }
    if (exit_code == PROGRAM_DONE) {
        add_row(&b);
    }
    svo_compact_destroy(&b.solid);
    svo_tree_destroy(&b.tree);
    free(b.tree_ms);
    free(b.points);
    free(b.inside);
    return exit_code;
}

const suite_subject bench_solid = {
    .words = &subject_table[SUBJECT_SOLID],
    .full = {.scenes = {"statue", "knot"}, .depths = {7, 8, 9}},
    .quick = {.scenes = {"knot:8000"}, .depths = {6}},
    .begin = begin,
    .run = run,
};
