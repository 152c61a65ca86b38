/* SPDX-License-Identifier: MIT */
/*
 * What a build costs, stage by stage. Front ends: triangles to exact fragments by OpenCL alone and by OpenGL's
 * rasterizer. Builders: top-down in OpenCL, bottom-up by sorting in OpenCL, and OpenGL compute shaders; and moving a
 * list from OpenGL to OpenCL by every interop path. Attributes: all weightings, and each attribute by itself. And what
 * a plan saves by omitting unused stages and buffers: one scene with each need, weighting and builder.
 */
#include <string.h>

#include "bench/series.h"
#include "bench/subjects.h"

/* ---- front ends ---- */

static const char voxelize_id[] = "voxelize";

static const char voxelize_note[] =
    "Front ends run interleaved. Transfer: the mesh to the device, the list to OpenCL, counts back. First: voxelize in "
    "the warm-up run, with compilation. Ratio: to cl, within each round.";

static int begin_voxelize(suite *all)
{
    result_table *table = suite_add_table(all, voxelize_id, "Front ends: triangles to exact fragments", voxelize_note);
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

static void add_voxelize(result_table *table, const input *source, unsigned depth, const series_method *method,
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

static int run_voxelize(suite *all, const input *source, unsigned depth)
{
    enum { METHODS = 3 };
    const svo_plan_options plan = {.need = SVO_NEED_NONE};
    series_method methods[METHODS] = {
        {.name = "cl", .plan = plan}, {.name = "gl-expand", .plan = plan}, {.name = "gl-hw", .plan = plan}};
    series_use_cl(all, &methods[0]);
    series_use_gl(all, OPTION_FRONTEND_GL_EXPAND, SVO_GL_SHARE_AUTO, &methods[1]);
    series_use_gl(all, OPTION_FRONTEND_GL_HW, SVO_GL_SHARE_AUTO, &methods[2]);
    return series_run(all, voxelize_id, source, depth, methods, METHODS, add_voxelize);
}

const suite_subject bench_voxelize = {
    .words = &subject_table[SUBJECT_VOXELIZE],
    .full = {.scenes = {"atrium", "statue", "knot", "terrain", "needles", "dust"}, .depths = {6, 7, 8, 9, 10}},
    .quick = {.scenes = {"knot:8000", "atrium:17000"}, .depths = {6, 8}},
    .begin = begin_voxelize,
    .run = run_voxelize,
};

/* ---- builders and interop paths ---- */

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
    "Builders run interleaved. Needs: colors, normals and rays, with uniform weights; table \"filter\" has the "
    "others. "
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

static const char share_note[] = "Interop paths run interleaved; occupancy only. Path \"none\": OpenCL makes "
                                 "the list itself. Ratio: voxelize and "
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

static int begin_builds(suite *all)
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

static int run_builds(suite *all, const input *source, unsigned depth)
{
    const int exit_code = run_builders(all, source, depth);
    return exit_code == PROGRAM_DONE ? run_share(all, source, depth) : exit_code;
}

const suite_subject bench_builders = {
    .words = &subject_table[SUBJECT_BUILD],
    .full = {.scenes = {"statue", "atrium"}, .depths = {6, 7, 8, 9, 10}},
    .quick = {.scenes = {"knot:8000"}, .depths = {6, 7, 8}},
    .begin = begin_builds,
    .run = run_builds,
};

/* ---- attributes ---- */

static const char filter_id[] = "filter";

/* The first is the one that the others are compared with. */
static const struct {
    const char *attributes;
    uint32_t need;
    svo_weights weights;
} filter_forms[] = {
    {"color,normal", SVO_NEED_COLOR | SVO_NEED_NORMAL, SVO_WEIGHTS_AREA},
    {"color,normal", SVO_NEED_COLOR | SVO_NEED_NORMAL, SVO_WEIGHTS_CENTER},
    {"color,normal", SVO_NEED_COLOR | SVO_NEED_NORMAL, SVO_WEIGHTS_UNIFORM},
    {"color", SVO_NEED_COLOR, SVO_WEIGHTS_AREA},
    {"normal", SVO_NEED_NORMAL, SVO_WEIGHTS_AREA},
    {"material", SVO_NEED_MATERIAL, SVO_WEIGHTS_AREA},
    {"fill", SVO_NEED_FILL, SVO_WEIGHTS_AREA},
    {"projected area", SVO_NEED_PROJECTED_AREA, SVO_WEIGHTS_AREA},
    {"color,normal,projected area", SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_PROJECTED_AREA, SVO_WEIGHTS_AREA},
    {"color", SVO_NEED_COLOR, SVO_WEIGHTS_UNIFORM},
    {"normal", SVO_NEED_NORMAL, SVO_WEIGHTS_UNIFORM},
    {"material", SVO_NEED_MATERIAL, SVO_WEIGHTS_UNIFORM},
};
#define FILTER_FORMS (sizeof filter_forms / sizeof filter_forms[0])

static const char filter_note[] =
    "Rows run interleaved, with front end and builder cl. List to tree: subdivide, link, pack and filter. First: the "
    "same in the warm-up run, with compilation. Ratio: of filter, relative to colors and normals weighted by area, "
    "within each round.";

static int begin_filter(suite *all)
{
    result_table *table = suite_add_table(all, filter_id, "Attributes: by weighting, and each by itself", filter_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "nodes", "");
    result_add_column(table, "attributes", "");
    result_add_column(table, "weights", "");
    result_add_column(table, "clock", "");
    spread_add_columns(table, "filter", "ms");
    spread_add_columns(table, "list to tree", "ms");
    result_add_column(table, "first", "ms");
    spread_add_columns(table, "ratio", "");
    return PROGRAM_DONE;
}

static void add_filter(result_table *table, const input *source, unsigned depth, const series_method *method,
                       const series_method *first)
{
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, depth);
    result_add_number(table, (double)method->info.node_count);
    result_add_text(table, "%s", method->name);
    result_add_text(table, "%s", svo_name(SVO_NAME_WEIGHTS, method->plan.weights));
    result_add_text(table, "%s", series_clock(method, SVO_STAGE_FILTER));
    spread_add(table, series_ms(method, SERIES_BIT(SVO_STAGE_FILTER)));
    spread_add(table, series_ms(method, SERIES_TREE));
    result_add_number(table, series_first_ms(method, SERIES_TREE | SERIES_BIT(SVO_STAGE_COMPILE)));
    spread_add(table, series_ratio(method, first, SERIES_BIT(SVO_STAGE_FILTER)));
}

static int run_filter(suite *all, const input *source, unsigned depth)
{
    series_method methods[FILTER_FORMS];
    memset(methods, 0, sizeof methods);
    for (size_t i = 0; i < FILTER_FORMS; ++i) {
        methods[i].name = filter_forms[i].attributes;
        methods[i].plan = (svo_plan_options){.need = filter_forms[i].need, .weights = filter_forms[i].weights};
        series_use_cl(all, &methods[i]);
    }
    return series_run(all, filter_id, source, depth, methods, FILTER_FORMS, add_filter);
}

const suite_subject bench_filter = {
    .words = &subject_table[SUBJECT_FILTER],
    .full = {.scenes = {"atrium", "statue"}, .depths = {7, 8, 9}},
    .quick = {.scenes = {"atrium:17000"}, .depths = {7}},
    .begin = begin_filter,
    .run = run_filter,
};

/* ---- needs ---- */

static const char needs_id[] = "e6-leaving-out";

#define NEED_PAYLOAD (SVO_NEED_ALL & ~SVO_NEED_RAYS)

/* The first is the one that the others are compared with. */
static const struct {
    const char *name;
    const char *left_out;
    svo_plan_options plan;
} needs_forms[] = {
    {"all", "nothing", {.need = SVO_NEED_ALL}},
    {"all but rays", "rays", {.need = NEED_PAYLOAD}},
    {"all but color", "color", {.need = SVO_NEED_ALL & ~SVO_NEED_COLOR}},
    {"all but normal", "normal", {.need = SVO_NEED_ALL & ~SVO_NEED_NORMAL}},
    {"all but material", "material", {.need = SVO_NEED_ALL & ~SVO_NEED_MATERIAL}},
    {"all but fill", "fill", {.need = SVO_NEED_ALL & ~SVO_NEED_FILL}},
    {"all but projected area", "projected area", {.need = SVO_NEED_ALL & ~SVO_NEED_PROJECTED_AREA}},
    {"color", "all but color", {.need = SVO_NEED_COLOR}},
    {"normal", "all but normal", {.need = SVO_NEED_NORMAL}},
    {"rays", "all but rays", {.need = SVO_NEED_RAYS}},
    {"material", "all but material", {.need = SVO_NEED_MATERIAL}},
    {"fill", "all but fill", {.need = SVO_NEED_FILL}},
    {"projected area", "all but projected area", {.need = SVO_NEED_PROJECTED_AREA}},
    {"none", "all but occupancy", {.need = SVO_NEED_NONE}},
    {"color,normal by area", "rays, material, fill, projected area", {.need = SVO_NEED_COLOR | SVO_NEED_NORMAL}},
    {"color,normal by center",
     "rays, material, fill, projected area, areas",
     {.need = SVO_NEED_COLOR | SVO_NEED_NORMAL, .weights = SVO_WEIGHTS_CENTER}},
    {"color,normal uniform",
     "rays, material, fill, projected area, clipping",
     {.need = SVO_NEED_COLOR | SVO_NEED_NORMAL, .weights = SVO_WEIGHTS_UNIFORM}},
    {"none, sorted", "all but occupancy", {.need = SVO_NEED_NONE, .builder = SVO_BUILDER_SORTED}},
    {"rays, sorted", "all but rays", {.need = SVO_NEED_RAYS, .builder = SVO_BUILDER_SORTED}},
};
#define NEED_FORMS (sizeof needs_forms / sizeof needs_forms[0])

static const char needs_note[] =
    "Rows run interleaved, with front end cl. Build: from the mesh on the host to the finished tree, without "
    "compilation. First: the warm-up run, with compilation. Peak: the largest sum of OpenCL buffers at one time. Tree: "
    "the buffers of the finished tree. Ratio: of build, relative to all, within each round.";

static int begin_needs(suite *all)
{
    result_table *table = suite_add_table(all, needs_id, "Time and bytes of each need", needs_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "leaves", "");
    result_add_column(table, "need", "");
    result_add_column(table, "left out", "");
    result_add_column(table, "builder", "");
    spread_add_columns(table, "build", "ms");
    result_add_column(table, "first", "ms");
    result_add_column(table, "peak", "B");
    result_add_column(table, "tree", "B");
    result_add_column(table, "tree per leaf", "B");
    spread_add_columns(table, "ratio", "");
    return PROGRAM_DONE;
}

static void add_needs(result_table *table, const input *source, unsigned depth, const series_method *method,
                      const series_method *first)
{
    const size_t form = (size_t)(method - first);
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, depth);
    result_add_number(table, (double)method->info.leaf_count);
    result_add_text(table, "%s", method->name);
    result_add_text(table, "%s", needs_forms[form].left_out);
    result_add_text(table, "%s", method->report.builder);
    spread_add(table, series_ms(method, SERIES_BUILD));
    result_add_number(table, series_first_ms(method, SERIES_BUILD | SERIES_BIT(SVO_STAGE_COMPILE)));
    result_add_number(table, (double)method->peak_bytes);
    result_add_number(table, (double)method->tree_bytes);
    result_add_number(table, (double)method->tree_bytes / (double)method->info.leaf_count);
    spread_add(table, series_ratio(method, first, SERIES_BUILD));
}

static int run_needs(suite *all, const input *source, unsigned depth)
{
    series_method methods[NEED_FORMS];
    memset(methods, 0, sizeof methods);
    for (size_t i = 0; i < NEED_FORMS; ++i) {
        methods[i].name = needs_forms[i].name;
        methods[i].plan = needs_forms[i].plan;
        series_use_cl(all, &methods[i]);
    }
    return series_run(all, needs_id, source, depth, methods, NEED_FORMS, add_needs);
}

const suite_subject bench_leaving_out = {
    .words = &subject_table[SUBJECT_LEAVING_OUT],
    .full = {.scenes = {"atrium"}, .depths = {9}},
    .quick = {.scenes = {"atrium:17000"}, .depths = {7}},
    .begin = begin_needs,
    .run = run_needs,
};
