/* SPDX-License-Identifier: MIT */
/* Time and bytes of scenes from no triangle to a million; bytes per leaf compared with methods that store all nodes. */
#include "bench/sizes.h"

#include "bench/series.h"

/* ---- scene-sizes ---- */

static const char sizes_id[] = "scene-sizes";

static const svo_mesh no_triangles = {.struct_size = sizeof(svo_mesh)};
#define SIZES_DEPTH 8

static void add_size(result_table *table, const input *source, unsigned depth, const series_method *method,
                     const series_method *first)
{
    (void)first;
    result_add_number(table, (double)source->mesh->triangle_count);
    result_add_number(table, depth);
    result_add_text(table, "%s", method->name);
    result_add_number(table, (double)method->report.fragments);
    result_add_number(table, (double)method->info.leaf_count);
    result_add_number(table, (double)method->peak_bytes);
    result_add_number(table, (double)method->tree_bytes);
    spread_add(table, series_ms(method, SERIES_BIT(SERIES_WALL)));
    result_add_number(table, series_first_ms(method, SERIES_BIT(SERIES_WALL)));
}

static int run_sizes(suite *all, const input *source, unsigned depth)
{
    enum { METHODS = 2 };
    series_method methods[METHODS] = {{.name = "default"}, {.name = "none", .plan = {.need = SVO_NEED_NONE}}};
    series_use_cl(all, &methods[0]);
    series_use_cl(all, &methods[1]);
    return series_run(all, sizes_id, source, depth, methods, METHODS, add_size);
}

static const char sizes_note[] =
    "Needs run interleaved, with front end cl. The scene is a terrain with exactly this number of triangles, and the "
    "grid is fitted to it. Default: the colors and normals of the mesh. Peak: the largest sum of OpenCL buffers at one "
    "time. Tree: the buffers of the finished tree. Build: wall clock from planning to the finished tree. First: the "
    "warm-up run, with compilation.";

static int begin_sizes(suite *all)
{
    result_table *table =
        suite_add_table(all, sizes_id, "From an empty mesh to a million triangles: bytes and time", sizes_note);
    result_add_column(table, "triangles", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "need", "");
    result_add_column(table, "fragments", "");
    result_add_column(table, "leaves", "");
    result_add_column(table, "peak", "B");
    result_add_column(table, "tree", "B");
    spread_add_columns(table, "build", "ms");
    result_add_column(table, "first", "ms");
    const input nothing = {.name = "no triangles", .mesh = &no_triangles};
    return run_sizes(all, &nothing, SIZES_DEPTH);
}

const suite_subject bench_scene_sizes = {
    .words = &subject_table[SUBJECT_SIZES],
    .full = {.scenes = {"terrain:1", "terrain:10", "terrain:1000", "terrain:100000", "terrain:1000000"},
             .depths = {SIZES_DEPTH}},
    .quick = {.scenes = {"terrain:1", "terrain:10", "terrain:1000", "terrain:100000"}, .depths = {SIZES_DEPTH}},
    .begin = begin_sizes,
    .run = run_sizes,
};

/* ---- memory ---- */

static const char memory_id[] = "memory";

static const char memory_note[] =
    "OpenCL buffers after a build with --need none. Full octree: 4 bytes for each node of a complete octree, computed. "
    "List of 36 bytes: the fragment list of the voxel cone tracing thesis (2016), computed from the number of "
    "fragments.";

static int begin_memory(suite *all)
{
    result_table *table = result_add_table(all->results, memory_id, "Bytes of an occupancy-only octree", memory_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "fragments", "");
    result_add_column(table, "nodes", "");
    result_add_column(table, "leaves", "");
    result_add_column(table, "tree", "B");
    result_add_column(table, "tree per leaf", "B");
    result_add_column(table, "fragment list", "B");
    result_add_column(table, "peak", "B");
    result_add_column(table, "full octree", "B");
    result_add_column(table, "list of 36 bytes", "B");
    return PROGRAM_DONE;
}

double bench_full_octree_bytes(unsigned depth)
{
    double nodes = 0.0;
    double level = 1.0;
    for (unsigned i = 0; i <= depth; ++i, level *= 8.0) {
        nodes += level;
    }
    return nodes * 4.0;
}

static void add_memory(result_table *table, const input *source, unsigned depth, const series_method *method,
                       const series_method *first)
{
    (void)first;
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, depth);
    result_add_number(table, (double)method->report.fragments);
    result_add_number(table, (double)method->info.node_count);
    result_add_number(table, (double)method->info.leaf_count);
    result_add_number(table, (double)method->tree_bytes);
    result_add_number(table, (double)method->tree_bytes / (double)method->info.leaf_count);
    result_add_number(table, (double)method->list_bytes);
    result_add_number(table, (double)method->peak_bytes);
    result_add_number(table, bench_full_octree_bytes(depth));
    result_add_number(table, (double)method->report.fragments * 36.0);
}

static int run_memory(suite *all, const input *source, unsigned depth)
{
    series_method method = {.name = "cl", .plan = {.need = SVO_NEED_NONE}};
    const size_t repeats = all->repeats;
    series_use_cl(all, &method);
    all->repeats = 0; /* bytes are the same every time */
    const int exit_code = series_run(all, memory_id, source, depth, &method, 1, add_memory);
    all->repeats = repeats;
    return exit_code;
}

const suite_subject bench_memory = {
    .words = &subject_table[SUBJECT_MEMORY],
    .full = {.scenes = {"statue", "atrium"}, .depths = {7, 8, 9, 10}},
    .quick = {.scenes = {"statue"}, .depths = {7, 9}},
    .begin = begin_memory,
    .run = run_memory,
};
