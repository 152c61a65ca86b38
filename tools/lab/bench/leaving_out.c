/* SPDX-License-Identifier: MIT */
/* What a plan saves by omitting unused stages and buffers: one scene with each need, weighting and builder. */
#include "bench/leaving_out.h"

#include <string.h>

#include "bench/series.h"

static const char table_id[] = "e6-leaving-out";

#define NEED_PAYLOAD (SVO_NEED_ALL & ~SVO_NEED_RAYS)

/* The first is the one that the others are compared with. */
static const struct {
    const char *name;
    const char *left_out;
    svo_plan_options plan;
} forms[] = {
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
#define FORM_COUNT (sizeof forms / sizeof forms[0])

static const char note[] =
    "Rows run interleaved, with front end cl. Build: from the mesh on the host to the finished tree, without "
    "compilation. First: the warm-up run, with compilation. Peak: the largest sum of OpenCL buffers at one time. Tree: "
    "the buffers of the finished tree. Ratio: of build, relative to all, within each round.";

static int begin(suite *all)
{
    result_table *table = suite_add_table(all, table_id, "Time and bytes of each need", note);
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

static void add_row(result_table *table, const input *source, unsigned depth, const series_method *method,
                    const series_method *first)
{
    const size_t form = (size_t)(method - first);
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, depth);
    result_add_number(table, (double)method->info.leaf_count);
    result_add_text(table, "%s", method->name);
    result_add_text(table, "%s", forms[form].left_out);
    result_add_text(table, "%s", method->report.builder);
    spread_add(table, series_ms(method, SERIES_BUILD));
    result_add_number(table, series_first_ms(method, SERIES_BUILD | SERIES_BIT(SVO_STAGE_COMPILE)));
    result_add_number(table, (double)method->peak_bytes);
    result_add_number(table, (double)method->tree_bytes);
    result_add_number(table, (double)method->tree_bytes / (double)method->info.leaf_count);
    spread_add(table, series_ratio(method, first, SERIES_BUILD));
}

static int run(suite *all, const input *source, unsigned depth)
{
    series_method methods[FORM_COUNT];
    memset(methods, 0, sizeof methods);
    for (size_t i = 0; i < FORM_COUNT; ++i) {
        methods[i].name = forms[i].name;
        methods[i].plan = forms[i].plan;
        series_use_cl(all, &methods[i]);
    }
    return series_run(all, table_id, source, depth, methods, FORM_COUNT, add_row);
}

const suite_subject bench_leaving_out = {
    .words = &subject_table[SUBJECT_LEAVING_OUT],
    .full = {.scenes = {"atrium"}, .depths = {9}},
    .quick = {.scenes = {"atrium:17000"}, .depths = {7}},
    .begin = begin,
    .run = run,
};
