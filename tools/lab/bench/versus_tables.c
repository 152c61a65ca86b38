/* SPDX-License-Identifier: MIT */
/* The tables that people read: every combination of list, path and builder; the two APIs by payload, depth and scene;
   what of the time is where; which clocks there are; starts. */
#include "bench/versus_tables.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/versus_effects.h"
#include "bench/versus_start.h"

/* What stands in a cell. */
typedef struct words {
    char text[SVO_MESSAGE_BYTES];
} words;

typedef struct number_words {
    char text[32];
} number_words;

/* Three digits. */
static number_words number_text(double number)
{
    number_words made;
    const int decimals = number >= 100 ? 0 : number >= 10 ? 1 : 2;
    snprintf(made.text, sizeof made.text, "%.*f", decimals, number);
    return made;
}

/* "31.2 [30.9, 33.0]", or "31.2 (one)" */
static words interval_text(interval of)
{
    words made;
    if (isfinite(of.low)) {
        snprintf(made.text, sizeof made.text, "%s [%s, %s]", number_text(of.middle).text, number_text(of.low).text,
                 number_text(of.high).text);
    } else {
        snprintf(made.text, sizeof made.text, "%s (one)", number_text(of.middle).text);
    }
    return made;
}

/* The median with its interval, or why there is none. */
static words cell_text(const versus_data *data, size_t cell)
{
    words made = {"not part of the design"};
    if (cell < data->count && data->samples[cell].count > 0) {
        return interval_text(versus_interval(data, cell, VERSUS_WALL));
    }
    if (cell < data->count) {
        const char *reason = versus_text(data, cell, VERSUS_REASON);
        snprintf(made.text, sizeof made.text, "%s", reason[0] != '\0' ? reason : "not measured: the time was over");
    }
    return made;
}

/* ---- cells ---- */

/* The cell of one cell's method and of another's settings; data->count: there is none. */
static size_t find_cell(const versus_data *data, size_t method, size_t setting, unsigned method_factors)
{
    size_t i = 0;
    while (i < data->count &&
           !(versus_same(data, i, method, method_factors) && versus_same(data, i, setting, VERSUS_SETTING))) {
        ++i;
    }
    return i;
}

static bool is_central(const versus_data *data, size_t cell)
{
    return versus_same(data, cell, 0, VERSUS_SETTING);
}

/* ---- every combination ---- */

static const char methods_note[] =
    "Wall time, ms, of every combination of list, share and builder at the central scene, depth and payload: "
    "medians with 95 % intervals by the bootstrap, (one) where there is a single round, or the reason why there is "
    "none. A build "
    "that reports another list "
    "or share than it was asked for is no cell of its own.";

static void add_methods(const versus_data *data, result_set *results)
{
    const versus_level *builders = versus_levels(VERSUS_BUILDER);
    result_table *table = result_add_table(results, "gl-vs-cl-methods", "List, share and builder", methods_note);
    result_add_column(table, "path", "");
    result_add_column(table, "list", "");
    result_add_column(table, "share", "");
    for (size_t i = 0; builders[i].name != NULL; ++i) {
        result_add_column(table, builders[i].name, "");
    }
    const unsigned row_factors = VERSUS_METHOD & ~VERSUS_BIT(VERSUS_BUILDER);
    for (size_t i = 0; i < data->count && is_central(data, i); ++i) {
        size_t first = 0;
        while (first < i && !versus_same(data, first, i, row_factors)) {
            ++first;
        }
        for (versus_column k = VERSUS_PATH; k <= VERSUS_SHARE && first == i; ++k) {
            result_add_text(table, "%s", versus_text(data, i, k));
        }
        for (size_t b = 0; builders[b].name != NULL && first == i; ++b) {
            size_t cell = i;
            while (cell < data->count && !(is_central(data, cell) && versus_same(data, cell, i, row_factors) &&
                                           strcmp(versus_text(data, cell, VERSUS_BUILDER), builders[b].name) == 0)) {
                ++cell;
            }
            result_add_text(table, "%s", cell_text(data, cell).text);
        }
    }
}

/* ---- where the time is ---- */

static const char stages_note[] =
    "The cells above that work. Ratio: to the first row, within rounds; gpu path: to the row of the same builder's "
    "algorithm in OpenCL with the kernels of GPUs, which gl-compute's shaders are. First: the first build of a "
    "process, the slowest of all processes, with what it compiles that no cell before it did. Plan, wall clock; "
    "voxelize, tree and transfer by the clocks named; rest: wall without them. Peak: OpenCL's buffers.";

/* The cell with GPU kernels, builder cl and a list by OpenCL; data->count where the device's own path is that. */
static size_t find_gpu_path(const versus_data *data, size_t setting)
{
    for (size_t i = 0; i < data->count; ++i) {
        if (versus_same(data, i, setting, VERSUS_SETTING) && strcmp(versus_text(data, i, VERSUS_PATH), "gpu") == 0 &&
            strcmp(versus_text(data, i, VERSUS_LIST), "cl") == 0 &&
            strcmp(versus_text(data, i, VERSUS_BUILDER), "cl") == 0) {
            return i;
        }
    }
    return data->count;
}

static interval ratio_to(const versus_data *data, size_t cell, size_t other)
{
    return cell < data->count && other < data->count ? versus_ratio(data, cell, other) : (interval){NAN, NAN, NAN};
}

static void add_stages(const versus_data *data, result_set *results)
{
    static const versus_time shown[] = {VERSUS_PLAN, VERSUS_VOXELIZE, VERSUS_TREE, VERSUS_TRANSFER};
    static const char *const names[] = {"plan", "voxelize", "tree", "transfer", "rest", "first"};
    result_table *table = result_add_table(results, "gl-vs-cl-stages", "Where the time is", stages_note);
    result_add_column(table, "method", "");
    interval_add_columns(table, "wall", "ms");
    interval_add_columns(table, "ratio", "");
    interval_add_columns(table, "to gpu path", "");
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        result_add_column(table, names[i], "ms");
    }
    result_add_column(table, "peak", "B");
    const size_t gpu = find_gpu_path(data, 0);
    for (size_t i = 0; i < data->count && is_central(data, i); ++i) {
        if (data->samples[i].count == 0) {
            continue;
        }
        double rest = versus_interval(data, i, VERSUS_WALL).middle;
        result_add_text(table, "%s", versus_method_words(data, i).text);
        interval_add(table, versus_interval(data, i, VERSUS_WALL));
        interval_add(table, ratio_to(data, i, 0));
        interval_add(table, ratio_to(data, i, gpu));
        for (size_t k = 0; k < sizeof shown / sizeof shown[0]; ++k) {
            const double middle = versus_interval(data, i, shown[k]).middle;
            result_add_number(table, middle);
            rest -= middle;
        }
        result_add_number(table, fmax(rest, 0));
        result_add_number(table, data->samples[i].first_ms);
        result_add_number(table, versus_number(data, i, VERSUS_PEAK));
    }
}

/* ---- clocks ---- */

static const char clocks_note[] =
    "What the library times stages by in the cells above, and whether the sum can be: what a device's timers say of a "
    "build that waits must fit into its wall time. Wall: the library does not trust the timer of that API and device, "
    "or the work is the host's. In timers: voxelize, tree and transfer as a share of the wall time.";

static void add_clocks(const versus_data *data, result_set *results)
{
    result_table *table = result_add_table(results, "gl-vs-cl-clocks", "Clocks", clocks_note);
    result_add_column(table, "method", "");
    result_add_column(table, "clocks", "");
    result_add_column(table, "in timers", "%");
    result_add_column(table, "verdict", "");
    for (size_t i = 0; i < data->count && is_central(data, i); ++i) {
        if (data->samples[i].count == 0) {
            continue;
        }
        const char *clocks = versus_text(data, i, VERSUS_CLOCKS);
        const double share =
            100 *
            (versus_interval(data, i, VERSUS_VOXELIZE).middle + versus_interval(data, i, VERSUS_TREE).middle +
             versus_interval(data, i, VERSUS_TRANSFER).middle) /
            versus_interval(data, i, VERSUS_WALL).middle;
        result_add_text(table, "%s", versus_method_words(data, i).text);
        result_add_text(table, "%s", clocks);
        result_add_number(table, share);
        result_add_text(table, "%s",
                        share > 101                      ? "not to be trusted: more than the wall time"
                        : strstr(clocks, "wall") != NULL ? "partly the wall clock"
                                                         : "timers of the device, within the wall time");
    }
}

/* ---- methods beside each other ---- */

/* A table with a row for each setting that differs from the central one in some factors alone, and a column for each
   kind of method. */
typedef struct beside {
    const char *id, *title, *note;
    unsigned varying;
    versus_column shown[3];
    size_t shown_count;
} beside;

static void add_ratios(const versus_data *data, result_table *table, const size_t *kinds, size_t kind_count,
                       size_t setting)
{
    size_t compute = 0;
    while (compute < kind_count && strcmp(versus_text(data, kinds[compute], VERSUS_BUILDER), "gl-compute") != 0) {
        ++compute;
    }
    const size_t cell = compute < kind_count ? find_cell(data, kinds[compute], setting, VERSUS_METHOD) : data->count;
    const size_t others[2] = {find_cell(data, 0, setting, VERSUS_METHOD), find_gpu_path(data, setting)};
    for (size_t i = 0; i < 2; ++i) {
        const interval ratio = ratio_to(data, cell, others[i]);
        result_add_text(table, "%s", isfinite(ratio.middle) ? interval_text(ratio).text : "no rounds in common");
    }
}

static bool is_row(const versus_data *data, const beside *of, size_t cell)
{
    bool row = versus_same(data, cell, 0, VERSUS_SETTING & ~of->varying);
    for (size_t i = 0; i < cell && row; ++i) {
        row = !versus_same(data, i, cell, VERSUS_SETTING);
    }
    return row;
}

static double order_of(const versus_data *data, size_t cell)
{
    return versus_number(data, cell, VERSUS_DEPTH) * 1e12 + versus_number(data, cell, VERSUS_TRIANGLES);
}

/* Adds a row by growing depth, then by triangles, behind those that are alike. */
static void insert_row(const versus_data *data, size_t cell, size_t *rows, size_t *count)
{
    size_t at = (*count)++;
    for (; at > 0 && order_of(data, rows[at - 1]) > order_of(data, cell); --at) {
        rows[at] = rows[at - 1];
    }
    rows[at] = cell;
}

static size_t list_rows(const versus_data *data, const beside *of, size_t *rows)
{
    size_t count = 0;
    for (size_t i = 0; i < data->count; ++i) {
        if (is_row(data, of, i)) {
            insert_row(data, i, rows, &count);
        }
    }
    return count;
}

/* What a row is of; fragments of any cell that has them. */
static void add_shown(const versus_data *data, result_table *table, size_t row, versus_column column)
{
    size_t cell = row;
    while (column == VERSUS_FRAGMENTS && cell < data->count &&
           !(versus_same(data, cell, row, VERSUS_SETTING) && isfinite(versus_number(data, cell, column)))) {
        ++cell;
    }
    if (cell < data->count) {
        result_add_cell(table, result_cell_at(data->cells, cell, column));
    } else {
        result_add_text(table, "not counted");
    }
}

static void add_beside(const versus_data *data, const beside *of, result_set *results)
{
    static const char *const names[VERSUS_COLUMNS] = {
        [VERSUS_SCENE] = "scene",        [VERSUS_DEPTH] = "depth",       [VERSUS_NEED] = "need",
        [VERSUS_WEIGHTS] = "weights",    [VERSUS_COVERAGE] = "coverage", [VERSUS_TRIANGLES] = "triangles",
        [VERSUS_FRAGMENTS] = "fragments"};
    size_t kinds[VERSUS_KINDS_MAX];
    size_t *rows = calloc(data->count + 1, sizeof *rows);
    const size_t kind_count = versus_kinds(data, kinds);
    const size_t row_count = rows != NULL ? list_rows(data, of, rows) : 0;
    result_table *table = result_add_table(results, of->id, of->title, of->note);
    for (size_t i = 0; i < of->shown_count; ++i) {
        result_add_column(table, names[of->shown[i]], "");
    }
    for (size_t i = 0; i < kind_count; ++i) {
        result_add_column(table, versus_method_words(data, kinds[i]).text, "");
    }
    result_add_column(table, "gl-compute over cl", "");
    result_add_column(table, "over gpu path", "");
    for (size_t i = 0; i < row_count; ++i) {
        for (size_t k = 0; k < of->shown_count; ++k) {
            add_shown(data, table, rows[i], of->shown[k]);
        }
        for (size_t k = 0; k < kind_count; ++k) {
            result_add_text(table, "%s", cell_text(data, find_cell(data, kinds[k], rows[i], VERSUS_METHOD)).text);
        }
        add_ratios(data, table, kinds, kind_count, rows[i]);
    }
    free(rows);
}

static const char beside_note[] =
    "Wall time, ms, as above. Columns are list, share and builder, with the first share that works. Ratios: of "
    "gl-compute to builder cl with the kernels of this device, and with those of GPUs, within rounds.";

static const beside tables[] = {
    {"gl-vs-cl-payload",
     "Needs, weights and coverage",
     beside_note,
     VERSUS_BIT(VERSUS_NEED) | VERSUS_BIT(VERSUS_WEIGHTS) | VERSUS_BIT(VERSUS_COVERAGE),
     {VERSUS_NEED, VERSUS_WEIGHTS, VERSUS_COVERAGE},
     3},
    {"gl-vs-cl-depth", "Depth", beside_note, VERSUS_BIT(VERSUS_DEPTH), {VERSUS_DEPTH, VERSUS_FRAGMENTS}, 2},
    {"gl-vs-cl-scene", "Scenes", beside_note, VERSUS_BIT(VERSUS_SCENE), {VERSUS_SCENE, VERSUS_TRIANGLES}, 2},
};

/* ---- for charts ---- */

static const char series_note[] = "The same numbers, a row for each time: all cells of the central payload.";

/* Measured cells of the central payload. */
static size_t list_series(const versus_data *data, size_t *rows)
{
    const unsigned payload = VERSUS_SETTING & ~VERSUS_BIT(VERSUS_DEPTH) & ~VERSUS_BIT(VERSUS_SCENE);
    size_t count = 0;
    for (size_t i = 0; i < data->count; ++i) {
        if (data->samples[i].count > 0 && versus_same(data, i, 0, payload)) {
            insert_row(data, i, rows, &count);
        }
    }
    return count;
}

static void add_series(const versus_data *data, result_set *results)
{
    size_t *rows = calloc(data->count + 1, sizeof *rows);
    const size_t row_count = rows != NULL ? list_series(data, rows) : 0;
    result_table *table = result_add_table(results, VERSUS_SERIES_ID, "Times by depth and scene", series_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "triangles", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "central scene", "");
    result_add_column(table, "central depth", "");
    result_add_column(table, "method", "");
    interval_add_columns(table, "wall", "ms");
    for (size_t i = 0; i < row_count; ++i) {
        const size_t cell = rows[i];
        result_add_text(table, "%s", versus_text(data, cell, VERSUS_SCENE));
        result_add_number(table, versus_number(data, cell, VERSUS_TRIANGLES));
        result_add_number(table, versus_number(data, cell, VERSUS_DEPTH));
        result_add_text(table, "%s", versus_same(data, cell, 0, VERSUS_BIT(VERSUS_SCENE)) ? "yes" : "no");
        result_add_text(table, "%s", versus_same(data, cell, 0, VERSUS_BIT(VERSUS_DEPTH)) ? "yes" : "no");
        result_add_text(table, "%s", versus_method_words(data, cell).text);
        interval_add(table, versus_interval(data, cell, VERSUS_WALL));
    }
    free(rows);
}

void versus_tabulate(const versus_data *data, const result_set *measured, result_set *into)
{
    add_methods(data, into);
    add_stages(data, into);
    for (size_t i = 0; i < sizeof tables / sizeof tables[0]; ++i) {
        add_beside(data, &tables[i], into);
    }
    versus_add_effects(data, into);
    add_clocks(data, into);
    versus_add_starts(measured, into);
    add_series(data, into);
}
