/* SPDX-License-Identifier: MIT */
/* Compares the front ends: triangles to exact fragments by OpenCL alone and by OpenGL's rasterizer. */
#include "bench/voxelize.h"

#include "bench/series.h"

static const char table_id[] = "voxelize";

static const char note[] =
    "Front ends run interleaved. Transfer: the mesh to the device, the list to OpenCL, counts back. First: voxelize in "
    "the warm-up run, with compilation. Ratio: to cl, within each round.";

static int begin(suite *all)
{
    result_table *table = suite_add_table(all, table_id, "Front ends: triangles to exact fragments", note);
    result_add_column(table, "scene", "");
    result_add_column(table, "triangles", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "fragments", "");
    result_add_column(table, "frontend", "");
    result_add_column(table, "share", "");
    result_add_column(table, "clock", "");
    result_add_column(table, "first", "ms");
    spread_add_columns(table, "voxelize", "ms");
    spread_add_columns(table, "transfer", "ms");
    result_add_column(table, "rate", "M/s");
    spread_add_columns(table, "ratio", "");
    return PROGRAM_DONE;
}

static void add_row(result_table *table, const input *source, unsigned depth, const series_method *method,
                    const series_method *first)
{
    const unsigned clock = SERIES_BIT(SVO_STAGE_VOXELIZE);
    const spread ms = series_ms(method, clock);
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, (double)source->mesh->triangle_count);
    result_add_number(table, depth);
    result_add_number(table, (double)method->report.fragments);
    result_add_text(table, "%s", method->report.frontend);
    result_add_text(table, "%s", method->report.share);
    result_add_text(table, "%s", series_clock(method, SVO_STAGE_VOXELIZE));
    result_add_number(table, series_first_ms(method, clock | SERIES_BIT(SVO_STAGE_COMPILE)));
    spread_add(table, ms);
    spread_add(table, series_ms(method, SERIES_BIT(SVO_STAGE_TRANSFER)));
    result_add_number(table, (double)method->report.fragments / ms.median * 1e-3);
    spread_add(table, series_ratio(method, first, clock));
}

static int run(suite *all, const input *source, unsigned depth)
{
    enum { METHODS = 3 };
    const svo_plan_options plan = {.need = SVO_NEED_NONE};
    series_method methods[METHODS] = {
        {.name = "cl", .plan = plan}, {.name = "gl-expand", .plan = plan}, {.name = "gl-hw", .plan = plan}};
    series_use_cl(all, &methods[0]);
    series_use_gl(all, OPTION_FRONTEND_GL_EXPAND, SVO_GL_SHARE_AUTO, &methods[1]);
    series_use_gl(all, OPTION_FRONTEND_GL_HW, SVO_GL_SHARE_AUTO, &methods[2]);
    return series_run(all, table_id, source, depth, methods, METHODS, add_row);
}

const suite_subject bench_voxelize = {
    .words = &subject_table[SUBJECT_VOXELIZE],
    .full = {.scenes = {"atrium", "statue", "knot", "terrain", "needles", "dust"}, .depths = {6, 7, 8, 9, 10}},
    .quick = {.scenes = {"knot:8000", "atrium:17000"}, .depths = {6, 8}},
    .begin = begin,
    .run = run,
};
