/* SPDX-License-Identifier: MIT */
/*
 * Tables of two older systems, measured again: a master's thesis on an octree-building library for the GPU (2020) and
 * one on voxel cone tracing (2016). Their scenes and hardware are not available, so the scenes here have the same
 * number of triangles or the same kind of content. The published values give the scale and name their hardware.
 */
#include "bench/subjects.h"

#include <math.h>
#include <string.h>

#include "bench/series.h"
#include "bench/sizes.h"

/* ---- thesis-2020: structures at small depths ---- */

/* Of ours: the thesis counts the root as depth 1, so that its depth h is a grid of 2^(h - 1) voxels per axis, our depth
   h - 1. */
#define PUBLISHED_LEAST_DEPTH 2
#define PUBLISHED_DEPTHS      4

static const char structure_id[] = "thesis-2020";

static const char structure_note[] =
    "svocl: terrains with the same numbers of triangles, front end and builder cl, colors and normals. Structure: "
    "subdivide, link, pack and filter. Transfer: the mesh to the device, counts back. Total: with grid and voxelize. "
    "Published: a scene with that number of triangles on a GTX 960. The thesis lists structure, voxelization and "
    "transfer at its depths 3 to 6, which are grids of 4 to 32 voxels per axis; here are its totals, and the structure "
    "at its last depth.";

/* Published, in milliseconds. */
static const struct {
    const char *scene; /* ours, with as many triangles */
    double total_ms[PUBLISHED_DEPTHS]; /* from PUBLISHED_LEAST_DEPTH on */
    double structure_ms; /* of these, at the last depth */
} structures[] = {{"terrain:3538", {592, 2921, 30266, 255455}, 255150},
                  {"terrain:2243", {512, 1909, 15811, 163345}, 162059},
                  {"terrain:26220", {1481, 9372, 88597, 1182155}, 1181685}};

static int begin_structure(suite *all)
{
    result_table *table =
        suite_add_table(all, structure_id, "Octree-building thesis (2020): scenes of 3,538, 2,243 and 26,220 triangles",
                        structure_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "triangles", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "published depth", "");
    result_add_column(table, "leaves", "");
    spread_add_columns(table, "voxelize", "ms");
    spread_add_columns(table, "structure", "ms");
    spread_add_columns(table, "transfer", "ms");
    spread_add_columns(table, "total", "ms");
    result_add_column(table, "published structure", "ms");
    result_add_column(table, "published total", "ms");
    result_add_column(table, "published on", "");
    return PROGRAM_DONE;
}

/* What was published for our scene at a depth; on other scenes nothing. */
static void add_published_structure(result_table *table, const char *name, unsigned depth)
{
    const unsigned index = depth - PUBLISHED_LEAST_DEPTH;
    double structure_ms = (double)NAN;
    double total_ms = (double)NAN;
    for (size_t i = 0; i < sizeof structures / sizeof structures[0]; ++i) {
        if (strcmp(structures[i].scene, name) == 0 && index < PUBLISHED_DEPTHS) {
            structure_ms = index == PUBLISHED_DEPTHS - 1 ? structures[i].structure_ms : (double)NAN;
            total_ms = structures[i].total_ms[index];
        }
    }
    result_add_number(table, structure_ms);
    result_add_number(table, total_ms);
    result_add_text(table, "%s", isnan(total_ms) ? "" : "GTX 960");
}

static void add_structure(result_table *table, const input *source, unsigned depth, const series_method *method,
                          const series_method *first)
{
    (void)first;
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, (double)source->mesh->triangle_count);
    result_add_number(table, depth);
    result_add_number(table, depth + 1);
    result_add_number(table, (double)method->info.leaf_count);
    spread_add(table, series_ms(method, SERIES_BIT(SVO_STAGE_VOXELIZE)));
    spread_add(table, series_ms(method, SERIES_TREE));
    spread_add(table, series_ms(method, SERIES_BIT(SVO_STAGE_TRANSFER)));
    spread_add(table, series_ms(method, SERIES_BUILD));
    add_published_structure(table, suite_scene_name(source), depth);
}

static int run_structure(suite *all, const input *source, unsigned depth)
{
    series_method method = {.name = "cl", .plan = {.need = SVO_NEED_COLOR | SVO_NEED_NORMAL}};
    series_use_cl(all, &method);
    return series_run(all, structure_id, source, depth, &method, 1, add_structure);
}

const suite_subject bench_thesis_2020 = {
    .words = &subject_table[SUBJECT_THESIS_2020],
    .full = {.scenes = {"terrain:3538", "terrain:2243", "terrain:26220"}, .depths = {2, 3, 4, 5}},
    .quick = {.scenes = {"terrain:3538", "terrain:2243", "terrain:26220"}, .depths = {2, 3, 4, 5}},
    .begin = begin_structure,
    .run = run_structure,
};

/* ---- thesis-2016: memory at three resolutions ---- */

static const char memory_id[] = "thesis-2016";

/* At 512³, on a Radeon HD 5850. */
static const struct {
    double voxelize_ms, first_build_ms, second_build_ms, list_kib, full_kib, sparse_kib;
} published = {110, 1944, 111, 51035, 599186, 4576};

static const char memory_note[] =
    "svocl: another atrium, front end and builder cl, occupancy only. Build: subdivide, link, pack and filter. First "
    "build: the warm-up run, with compilation. Second build: the runs after it. Sparse octree: OpenCL buffers. Full "
    "octree: 4 bytes for each node of a complete octree, computed. Published: an atrium at 512³ on a Radeon HD 5850, "
    "with 36 bytes per fragment; the names of the two builds are the thesis's.";

static int begin_memory(suite *all)
{
    result_table *table = suite_add_table(
        all, memory_id, "Voxel cone tracing thesis (2016): memory and build times at 128³, 256³ and 512³", memory_note);
    result_add_column(table, "system", "");
    result_add_column(table, "hardware", "");
    result_add_column(table, "voxels per axis", "");
    result_add_column(table, "fragments", "");
    result_add_column(table, "fragment list", "KiB");
    result_add_column(table, "full octree", "KiB");
    result_add_column(table, "sparse octree", "KiB");
    result_add_column(table, "voxelize", "ms");
    result_add_column(table, "first build", "ms");
    result_add_column(table, "second build", "ms");
    return PROGRAM_DONE;
}

static void add_published(result_table *table)
{
    result_add_text(table, "published");
    result_add_text(table, "Radeon HD 5850");
    result_add_number(table, 512);
    result_add_absent(table);
    result_add_number(table, published.list_kib);
    result_add_number(table, published.full_kib);
    result_add_number(table, published.sparse_kib);
    result_add_number(table, published.voxelize_ms);
    result_add_number(table, published.first_build_ms);
    result_add_number(table, published.second_build_ms);
}

static void add_memory(result_table *table, const input *source, unsigned depth, const series_method *method,
                       const series_method *first)
{
    const unsigned compile = SERIES_BIT(SVO_STAGE_COMPILE);
    (void)source;
    (void)first;
    result_add_text(table, "svocl");
    result_add_text(table, "%s", table->owner->machine.device);
    result_add_number(table, (double)(1u << depth));
    result_add_number(table, (double)method->report.fragments);
    result_add_number(table, (double)method->list_bytes / 1024.0);
    result_add_number(table, bench_full_octree_bytes(depth) / 1024.0);
    result_add_number(table, (double)method->tree_bytes / 1024.0);
    result_add_number(table, series_ms(method, SERIES_BIT(SVO_STAGE_VOXELIZE)).median);
    result_add_number(table, series_first_ms(method, SERIES_TREE | compile));
    result_add_number(table, series_ms(method, SERIES_TREE).median);
    if (depth == 9) {
        add_published(table);
    }
}

static int run_memory(suite *all, const input *source, unsigned depth)
{
    series_method method = {.name = "cl", .plan = {.need = SVO_NEED_NONE}};
    series_use_cl(all, &method);
    return series_run(all, memory_id, source, depth, &method, 1, add_memory);
}

const suite_subject bench_thesis_2016 = {
    .words = &subject_table[SUBJECT_THESIS_2016],
    .full = {.scenes = {"atrium"}, .depths = {7, 8, 9}},
    .quick = {.scenes = {"atrium"}, .depths = {7, 8, 9}},
    .begin = begin_memory,
    .run = run_memory,
};
