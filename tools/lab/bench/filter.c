/* SPDX-License-Identifier: MIT */
/* The cost of attributes: all weightings, and each attribute by itself. */
#include "bench/filter.h"

#include <string.h>

#include "bench/series.h"

static const char table_id[] = "filter";

/* The first is the one that the others are compared with. */
static const struct {
    const char *attributes;
    uint32_t need;
    svo_weights weights;
} forms[] = {
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
#define FORM_COUNT (sizeof forms / sizeof forms[0])

static const char note[] =
    "Rows run interleaved, with front end and builder cl. List to tree: subdivide, link, pack and filter. First: the "
    "same in the warm-up run, with compilation. Ratio: of filter, relative to colors and normals weighted by area, "
    "within each round.";

static int begin(suite *all)
{
    result_table *table = suite_add_table(all, table_id, "Attributes: by weighting, and each by itself", note);
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

static void add_row(result_table *table, const input *source, unsigned depth, const series_method *method,
                    const series_method *first)
{
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, depth);
    result_add_number(table, (double)method->info.node_count);
    result_add_text(table, "%s", method->name);
    result_add_text(table, "%s", svo_weights_name(method->plan.weights));
    result_add_text(table, "%s", series_clock(method, SVO_STAGE_FILTER));
    spread_add(table, series_ms(method, SERIES_BIT(SVO_STAGE_FILTER)));
    spread_add(table, series_ms(method, SERIES_TREE));
    result_add_number(table, series_first_ms(method, SERIES_TREE | SERIES_BIT(SVO_STAGE_COMPILE)));
    spread_add(table, series_ratio(method, first, SERIES_BIT(SVO_STAGE_FILTER)));
}

static int run(suite *all, const input *source, unsigned depth)
{
    series_method methods[FORM_COUNT];
    memset(methods, 0, sizeof methods);
    for (size_t i = 0; i < FORM_COUNT; ++i) {
        methods[i].name = forms[i].attributes;
        methods[i].plan = (svo_plan_options){.need = forms[i].need, .weights = forms[i].weights};
        series_use_cl(all, &methods[i]);
    }
    return series_run(all, table_id, source, depth, methods, FORM_COUNT, add_row);
}

const suite_subject bench_filter = {
    .words = &subject_table[SUBJECT_FILTER],
    .full = {.scenes = {"atrium", "statue"}, .depths = {7, 8, 9}},
    .quick = {.scenes = {"atrium:17000"}, .depths = {7}},
    .begin = begin,
    .run = run,
};
