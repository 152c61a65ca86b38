/* SPDX-License-Identifier: MIT */
/*
 * Other libraries on the same triangles, where their Debian packages are installed: Embree builds its BVH, OpenVDB a
 * sparse volume of the same resolution. Each runs interleaved with svocl.
 */
#include "bench/subjects.h"

#include <math.h>
#include <stdlib.h>

#include "bench/openvdb.h"
#include "bench/series.h"
#include "measure/embree.h"
#include "measure/quantization.h"
#include "support/info_of.h"

static const char embree_id[] = "peer-embree";
static const char openvdb_id[] = "peer-openvdb";

/* What is compared with Embree: the build and the BVH. */
#define BUILD_FOR_RAYS (SERIES_BUILD | SERIES_BIT(SERIES_RAYS))

/* Embree's builds beside the medium one. */
static const struct {
    const char *column;
    embree_options options;
} embree_builds[] = {{"Embree low", {.quality = EMBREE_LOW}},
                     {"Embree high", {.quality = EMBREE_HIGH}},
                     {"Embree robust", {.robust = true}}};
#define EMBREE_BUILDS (sizeof embree_builds / sizeof embree_builds[0])

/* The runs of a peer, and its results. */
typedef struct peer_runs {
    double *times, *ratios; /* after the warm-up run */
    size_t count;
    double first_ms;
    uint64_t active_voxels, memory_bytes;
    double *build_times[EMBREE_BUILDS]; /* of each of embree_builds */
} peer_runs;

/* The triangles as floats in units of voxels, for both peers. */
typedef struct peer_mesh {
    float *points;
    const svo_mesh *mesh;
    uint32_t *indices;
} peer_mesh;

/* ---- the mesh ---- */

/* In units of voxels from the center of the first one, on the grid that a plan would fit. Meshes with refused triangles
   are not supported. */
static bool make_peer_mesh(const svo_mesh *mesh, unsigned depth, peer_mesh *out)
{
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL};
    double edge = 0.0;
    *out = (peer_mesh){.points = calloc(mesh->vertex_count * 3, sizeof(float)),
                       .mesh = mesh,
                       .indices = calloc(mesh->triangle_count * 3, sizeof(uint32_t))};
    if (out->points == NULL || out->indices == NULL) {
        return false;
    }
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        low[i % 3] = fmin(low[i % 3], quantization_source(mesh, i));
    }
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        edge = fmax(edge, quantization_source(mesh, i) - low[i % 3]);
    }
    const double scale = edge > 0.0 ? (double)(1u << depth) / edge : 1.0;
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        out->points[i] = (float)((quantization_source(mesh, i) - low[i % 3]) * scale - 0.5);
    }
    for (size_t i = 0; i < mesh->triangle_count * 3; ++i) {
        out->indices[i] = mesh->indices != NULL ? mesh->indices[i] : (uint32_t)i;
    }
    return true;
}

/* ---- the runs ---- */

static double run_embree(const suite *all, const peer_mesh *made, embree_options asked)
{
    asked.isa = all->state->options.isa;
    embree *made_bvh =
        embree_create(made->points, made->mesh->vertex_count, made->indices, made->mesh->triangle_count, &asked);
    const double ms = made_bvh != NULL ? embree_build_ms(made_bvh) : -1.0;
    embree_destroy(&made_bvh);
    return ms;
}

static double run_openvdb(const peer_mesh *made, peer_runs *runs)
{
    return openvdb_voxelize(made->points, made->mesh->vertex_count, made->indices, made->mesh->triangle_count,
                            &runs->active_voxels, &runs->memory_bytes);
}

/* The other builds of a round; round: 0 is the warm-up. */
static void run_embree_builds(const suite *all, const peer_mesh *made, peer_runs *runs, size_t round)
{
    for (size_t i = 0; i < EMBREE_BUILDS; ++i) {
        const double ms = run_embree(all, made, embree_builds[i].options);
        if (round > 0) {
            runs->build_times[i][round - 1] = ms;
        }
    }
}

static bool make_times(peer_runs *runs, size_t repeats)
{
    runs->times = calloc(repeats + 1, sizeof *runs->times);
    runs->ratios = calloc(repeats + 1, sizeof *runs->ratios);
    bool made = runs->times != NULL && runs->ratios != NULL;
    for (size_t i = 0; i < EMBREE_BUILDS; ++i) {
        runs->build_times[i] = calloc(repeats + 1, sizeof *runs->build_times[i]);
        made = made && runs->build_times[i] != NULL;
    }
    return made;
}

static void free_times(peer_runs *runs)
{
    free(runs->times);
    free(runs->ratios);
    for (size_t i = 0; i < EMBREE_BUILDS; ++i) {
        free(runs->build_times[i]);
    }
}

/* Interleaves svocl with a peer; one round of svocl is a series of one build. */
static int run_rounds(suite *all, const peer_mesh *made, unsigned depth, series_method *method, peer_runs *runs,
                      bool with_embree)
{
    int exit_code = make_times(runs, all->repeats) && series_begin(all, method, 1)
                        ? PROGRAM_DONE
                        : program_fail(all->state, PROGRAM_FAILED, "out of memory");
    for (size_t round = 0; round <= all->repeats && exit_code == PROGRAM_DONE; ++round) {
        exit_code = series_run_round(all, made->mesh, depth, method, round);
        const double ms =
            with_embree ? run_embree(all, made, (embree_options){.robust = false}) : run_openvdb(made, runs);
        if (ms < 0.0 && exit_code == PROGRAM_DONE) {
            return program_fail(all->state, PROGRAM_FAILED, "%s cannot take the triangles",
                                with_embree ? "Embree" : "OpenVDB");
        }
        if (with_embree) {
            run_embree_builds(all, made, runs, round);
        }
        if (round == 0) {
            runs->first_ms = ms;
        } else if (exit_code == PROGRAM_DONE && method->reason[0] == '\0') {
            runs->ratios[runs->count] =
                series_round_ms(method, round, with_embree ? BUILD_FOR_RAYS : SERIES_BUILD) / ms;
            runs->times[runs->count++] = ms;
        }
    }
    return exit_code;
}

/* ---- tables ---- */

static const char embree_note[] =
    "Methods run interleaved. svocl: grid, voxelize, transfer, subdivide and pack at the ray depth, and the BVH, which "
    "one host thread builds. BVH: that part by itself. Embree: committing geometry and scene on all cores, without "
    "copying the triangles: its medium build, then low, high and robust. Ratio: svocl's time to that of Embree's "
    "medium "
    "build, within each round; above 1 Embree leads.";

static int begin_embree(suite *all)
{
    result_table *table =
        suite_add_table(all, embree_id, "Ray structures: the octree with its BVH, and Embree's BVH", embree_note);
    if (!embree_is_there()) {
        result_extend_note(table, "Empty: %s.", embree_lack());
    }
    result_add_column(table, "scene", "");
    result_add_column(table, "triangles", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "svocl tree", "B");
    result_add_column(table, "BVH", "B");
    spread_add_columns(table, "svocl", "ms");
    spread_add_columns(table, "BVH time", "ms");
    spread_add_columns(table, "Embree", "ms");
    spread_add_columns(table, "ratio", "");
    for (size_t i = 0; i < EMBREE_BUILDS; ++i) {
        spread_add_columns(table, embree_builds[i].column, "ms");
    }
    return PROGRAM_DONE;
}

static const char openvdb_note[] =
    "Methods run interleaved. svocl: from the mesh to the octree, occupancy only, exact. OpenVDB: tools::meshToVolume "
    "on all cores, unsigned distances in a band of one voxel to each side; its active voxels are those near the "
    "surface, whether or not it touches them. Ratio: svocl's time to OpenVDB's, within each round.";

static int begin_openvdb(suite *all)
{
    result_table *table = suite_add_table(
        all, openvdb_id, "Occupancy: the octree and an OpenVDB grid of the same resolution", openvdb_note);
    if (openvdb_is_there()) {
        result_extend_note(table, "OpenVDB %s.", openvdb_version());
    } else {
        result_extend_note(table, "Empty: this program was built without libopenvdb-dev.");
    }
    result_add_column(table, "scene", "");
    result_add_column(table, "triangles", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "svocl leaves", "");
    result_add_column(table, "svocl tree", "B");
    spread_add_columns(table, "svocl", "ms");
    result_add_column(table, "OpenVDB active voxels", "");
    result_add_column(table, "OpenVDB volume", "B");
    spread_add_columns(table, "OpenVDB", "ms");
    spread_add_columns(table, "ratio", "");
    return PROGRAM_DONE;
}

static void add_runs(result_table *table, peer_runs *runs)
{
    spread_add(table, spread_of(runs->times, runs->count));
    spread_add(table, spread_of(runs->ratios, runs->count));
}

/* The depth that svo_plan_info.ray_depth recommends. */
static int find_ray_depth(suite *all, const svo_mesh *mesh, unsigned *depth)
{
    svo_plan *plan = NULL;
    if (svo_plan_create(all->opened.device, mesh, OPTION_DEFAULT_DEPTH, NULL, &plan) != SVO_OK) {
        return program_fail_library(all->state, svo_device_message(all->opened.device));
    }
    *depth = info_of_plan(plan).ray_depth;
    svo_plan_destroy(&plan);
    return PROGRAM_DONE;
}

static void add_embree(suite *all, const input *source, unsigned depth, const series_method *method, peer_runs *runs)
{
    result_table *table = result_find(all->results, embree_id);
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, (double)source->mesh->triangle_count);
    result_add_number(table, depth);
    result_add_number(table, (double)method->tree_bytes);
    result_add_number(table, (double)method->ray_bytes);
    spread_add(table, series_ms(method, BUILD_FOR_RAYS));
    spread_add(table, series_ms(method, SERIES_BIT(SERIES_RAYS)));
    add_runs(table, runs);
    for (size_t i = 0; i < EMBREE_BUILDS; ++i) {
        spread_add(table, spread_of(runs->build_times[i], runs->count));
    }
}

static void add_openvdb(suite *all, const input *source, unsigned depth, const series_method *method, peer_runs *runs)
{
    result_table *table = result_find(all->results, openvdb_id);
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, (double)source->mesh->triangle_count);
    result_add_number(table, depth);
    result_add_number(table, (double)method->info.leaf_count);
    result_add_number(table, (double)method->tree_bytes);
    spread_add(table, series_ms(method, SERIES_BUILD));
    result_add_number(table, (double)runs->active_voxels);
    result_add_number(table, (double)runs->memory_bytes);
    add_runs(table, runs);
}

static int compare(suite *all, const input *source, unsigned depth, bool with_embree)
{
    series_method method = {
        .name = "svocl", .plan = {.need = with_embree ? SVO_NEED_RAYS : SVO_NEED_NONE}, .for_rays = with_embree};
    peer_runs runs = {0};
    peer_mesh made;
    series_use_cl(all, &method);
    int exit_code = PROGRAM_DONE;
    if (!make_peer_mesh(source->mesh, depth, &made)) {
        exit_code = program_fail(all->state, PROGRAM_FAILED, "out of memory for the mesh of a peer");
        goto cleanup;
    }
    exit_code = run_rounds(all, &made, depth, &method, &runs, with_embree);
    if (exit_code == PROGRAM_DONE && method.reason[0] == '\0') {
        (with_embree ? add_embree : add_openvdb)(all, source, depth, &method, &runs);
    }
cleanup:
    free_times(&runs);
    series_release(&method, 1);
    free(made.points);
    free(made.indices);
    return exit_code;
}

static int run_with_embree(suite *all, const input *source, unsigned depth)
{
    if (!embree_is_there()) {
        return PROGRAM_DONE;
    }
    const int exit_code = depth == SUITE_DEPTH_FOR_RAYS ? find_ray_depth(all, source->mesh, &depth) : PROGRAM_DONE;
    return exit_code == PROGRAM_DONE ? compare(all, source, depth, true) : exit_code;
}

static int run_with_openvdb(suite *all, const input *source, unsigned depth)
{
    return openvdb_is_there() ? compare(all, source, depth, false) : PROGRAM_DONE;
}

const suite_subject bench_peer_embree = {
    .words = &subject_table[SUBJECT_PEER_EMBREE],
    .full = {.scenes = {"atrium", "statue", "terrain"}, .depths = {SUITE_DEPTH_FOR_RAYS}},
    .quick = {.scenes = {"knot:8000"}, .depths = {SUITE_DEPTH_FOR_RAYS}},
    .begin = begin_embree,
    .run = run_with_embree,
};

const suite_subject bench_peer_openvdb = {
    .words = &subject_table[SUBJECT_PEER_OPENVDB],
    .full = {.scenes = {"atrium", "statue", "terrain"}, .depths = {7, 8, 9}},
    .quick = {.scenes = {"knot:8000"}, .depths = {7}},
    .begin = begin_openvdb,
    .run = run_with_openvdb,
};
