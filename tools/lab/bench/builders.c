/* SPDX-License-Identifier: MIT */
/*
 * Compares the builders stage by stage: top-down in OpenCL, bottom-up by sorting in OpenCL, and OpenGL compute shaders.
 * Also the cost of moving a list from OpenGL to OpenCL by every interop path.
 */
#include "bench/builders.h"

#include "bench/series.h"

static const char builders_id[] = "builders";
static const char share_id[] = "share";

/* The columns of both tables: stages in the order of the pipeline. */
static const struct {
    const char *name;
    unsigned clocks;
} builder_stages[] = {{"voxelize", SERIES_BIT(SVO_STAGE_VOXELIZE)},
                      {"subdivide", SERIES_BIT(SVO_STAGE_SUBDIVIDE)},
                      {"link", SERIES_BIT(SVO_STAGE_LINK)},
                      {"pack", SERIES_BIT(SVO_STAGE_PACK)},
                      {"filter", SERIES_BIT(SVO_STAGE_FILTER)},
                      {"transfer", SERIES_BIT(SVO_STAGE_TRANSFER)},
                      {"list to tree", SERIES_TREE},
                      {"total", SERIES_BUILD}},
  share_stages[] = {{"voxelize", SERIES_BIT(SVO_STAGE_VOXELIZE)},
                    {"transfer", SERIES_BIT(SVO_STAGE_TRANSFER)},
                    {"both", SERIES_BIT(SVO_STAGE_VOXELIZE) | SERIES_BIT(SVO_STAGE_TRANSFER)}};
#define BUILDER_STAGES (sizeof builder_stages / sizeof builder_stages[0])
#define SHARE_STAGES   (sizeof share_stages / sizeof share_stages[0])

static const char builders_note[] =
    "Builders run interleaved. Needs: colors, normals and rays, with uniform weights; table \"filter\" has the others. "
    "Transfer: the mesh to the device, the list or the finished arrays from OpenGL to OpenCL, counts back. List to "
    "tree: subdivide, link, pack and filter. Total: with grid, voxelize and transfer, without compilation. First: "
    "total of the warm-up run, with compilation. Ratio: list to tree, relative to cl, within each round.";

static void begin_builders(suite *all)
{
    result_table *table = suite_add_table(all, builders_id, "Builders: time per stage", builders_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "triangles", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "fragments", "");
    result_add_column(table, "nodes", "");
    result_add_column(table, "builder", "");
    result_add_column(table, "frontend", "");
    result_add_column(table, "clock", "");
    for (size_t i = 0; i < BUILDER_STAGES; ++i) {
        spread_add_columns(table, builder_stages[i].name, "ms");
    }
    result_add_column(table, "first", "ms");
    spread_add_columns(table, "ratio", "");
}

static const char share_note[] =
    "Interop paths run interleaved; occupancy only. Path \"none\": OpenCL makes the list itself. Ratio: voxelize and "
    "transfer, relative to \"none\", within each round.";

static void begin_share(suite *all)
{
    result_table *table =
        suite_add_table(all, share_id, "Interop: moving the fragment list from OpenGL to OpenCL", share_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "list", "B");
    result_add_column(table, "frontend", "");
    result_add_column(table, "share", "");
    for (size_t i = 0; i < SHARE_STAGES; ++i) {
        spread_add_columns(table, share_stages[i].name, "ms");
    }
    spread_add_columns(table, "ratio", "");
}

static int begin(suite *all)
{
    begin_builders(all);
    begin_share(all);
    return PROGRAM_DONE;
}

static void add_builder(result_table *table, const input *source, unsigned depth, const series_method *method,
                        const series_method *first)
{
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, (double)source->mesh->triangle_count);
    result_add_number(table, depth);
    result_add_number(table, (double)method->report.fragments);
    result_add_number(table, (double)method->info.node_count);
    result_add_text(table, "%s", method->report.builder);
    result_add_text(table, "%s", method->report.frontend);
    result_add_text(table, "%s", series_clock(method, SVO_STAGE_SUBDIVIDE));
    for (size_t i = 0; i < BUILDER_STAGES; ++i) {
        spread_add(table, series_ms(method, builder_stages[i].clocks));
    }
    result_add_number(table, series_first_ms(method, SERIES_BUILD | SERIES_BIT(SVO_STAGE_COMPILE)));
    spread_add(table, series_ratio(method, first, SERIES_TREE));
}

static int run_builders(suite *all, const input *source, unsigned depth)
{
    enum { METHODS = 3 };
    const svo_plan_options plan = {.need = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS,
                                   .weights = SVO_WEIGHTS_UNIFORM};
    series_method methods[METHODS] = {
        {.name = "cl", .plan = plan}, {.name = "sorted", .plan = plan}, {.name = "gl-compute", .plan = plan}};
    methods[1].plan.builder = SVO_BUILDER_SORTED;
    series_use_cl(all, &methods[0]);
    series_use_cl(all, &methods[1]);
    series_use_gl_compute(all, &methods[2]);
    return series_run(all, builders_id, source, depth, methods, METHODS, add_builder);
}

static void add_share(result_table *table, const input *source, unsigned depth, const series_method *method,
                      const series_method *first)
{
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, depth);
    result_add_number(table, (double)method->list_bytes);
    result_add_text(table, "%s", method->report.frontend);
    result_add_text(table, "%s", method->report.share);
    for (size_t i = 0; i < SHARE_STAGES; ++i) {
        spread_add(table, series_ms(method, share_stages[i].clocks));
    }
    spread_add(table, series_ratio(method, first, share_stages[SHARE_STAGES - 1].clocks));
}

static int run_share(suite *all, const input *source, unsigned depth)
{
    enum { METHODS = 4 };
    const svo_plan_options plan = {.need = SVO_NEED_NONE};
    series_method methods[METHODS] = {{.name = "none", .plan = plan},
                                      {.name = "interop", .plan = plan},
                                      {.name = "host", .plan = plan},
                                      {.name = "copy", .plan = plan}};
    const int shares[METHODS] = {SVO_GL_SHARE_AUTO, SVO_GL_SHARE_INTEROP, SVO_GL_SHARE_HOST, SVO_GL_SHARE_COPY};
    series_use_cl(all, &methods[0]);
    for (size_t i = 1; i < METHODS; ++i) {
        series_use_gl(all, OPTION_FRONTEND_AUTO, shares[i], &methods[i]);
    }
    return series_run(all, share_id, source, depth, methods, METHODS, add_share);
}

static int run(suite *all, const input *source, unsigned depth)
{
    const int exit_code = run_builders(all, source, depth);
    return exit_code == PROGRAM_DONE ? run_share(all, source, depth) : exit_code;
}

const suite_subject bench_builders = {
    .words = &subject_table[SUBJECT_BUILD],
    .full = {.scenes = {"statue", "atrium"}, .depths = {6, 7, 8, 9, 10}},
    .quick = {.scenes = {"knot:8000"}, .depths = {6, 7, 8}},
    .begin = begin,
    .run = run,
};
