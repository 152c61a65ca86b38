/* SPDX-License-Identifier: MIT */
/* The two tables of what was measured, put together, checked and looked at. */
#include "bench/versus_data.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The columns of rounds before the times. */
enum { ROUND_CELL, ROUND_PROCESS, ROUND_NUMBER, ROUND_TIMES };

static const char cells_note[] =
    "Each row is a way to build a tree. Rows of the same scene, depth, need, weights and coverage have the same hash. "
    "Reason: why there are no rounds; of ways that never work only the central row is listed. Peak: of OpenCL's "
    "buffers. Clocks: of voxelize, tree and transfer in the table of rounds.";
static const char rounds_note[] =
    "Each row is a build; round 0 is the first one of its process, which is a round where it took a second and "
    "compiled nothing. Wall: from svo_plan_create to clFinish, with plan, "
    "svo_plan_create. Voxelize, tree (subdivide, link, pack, filter) and transfer by the clocks of the cell.";
static const char starts_note[] =
    "Each row is a process that builds one tree. Cold: the drivers' caches of kernels and shaders are empty. Wall: of "
    "the build, with compile; process: from its start to its exit; resident: the most host memory that it had.";

void versus_add_tables(result_set *results)
{
    static const struct {
        const char *name, *unit;
    } columns[VERSUS_COLUMNS] = {{"scene", ""},    {"depth", ""},     {"path", ""},      {"list", ""},
                                 {"share", ""},    {"builder", ""},   {"need", ""},      {"weights", ""},
                                 {"coverage", ""}, {"triangles", ""}, {"fragments", ""}, {"nodes", ""},
                                 {"peak", "B"},    {"hash", ""},      {"clocks", ""},    {"reason", ""}},
      times[] = {{"cell", ""},       {"process", ""}, {"round", ""},      {"wall", "ms"},   {"plan", "ms"},
                 {"voxelize", "ms"}, {"tree", "ms"},  {"transfer", "ms"}, {"compile", "ms"}},
      starts[] = {{"path", ""},      {"list", ""},      {"share", ""},     {"builder", ""},
                  {"caches", ""},    {"process", "ms"}, {"compile", "ms"}, {"wall", "ms"},
                  {"resident", "B"}, {"peak", "B"},     {"reason", ""}};
    result_table *table = result_add_table(results, VERSUS_CELLS_ID, "Cells", cells_note);
    for (size_t i = 0; i < VERSUS_COLUMNS; ++i) {
        result_add_column(table, columns[i].name, columns[i].unit);
    }
    table = result_add_table(results, VERSUS_ROUNDS_ID, "Rounds", rounds_note);
    for (size_t i = 0; i < sizeof times / sizeof times[0]; ++i) {
        result_add_column(table, times[i].name, times[i].unit);
    }
    table = result_add_table(results, VERSUS_STARTS_ID, "Processes that build one tree", starts_note);
    for (size_t i = 0; i < sizeof starts / sizeof starts[0]; ++i) {
        result_add_column(table, starts[i].name, starts[i].unit);
    }
}

bool versus_is_round(const double ms[VERSUS_TIMES])
{
    return ms[VERSUS_WALL] >= VERSUS_LONG_MS && ms[VERSUS_COMPILE] < 0.01 * ms[VERSUS_WALL];
}

/* ---- cells ---- */

const char *versus_text(const versus_data *data, size_t cell, versus_column column)
{
    const result_cell *at = result_cell_at(data->cells, cell, column);
    return at != NULL && at->kind == RESULT_TEXT ? at->text : "";
}

double versus_number(const versus_data *data, size_t cell, versus_column column)
{
    const result_cell *at = result_cell_at(data->cells, cell, column);
    return at != NULL && at->kind == RESULT_NUMBER ? at->number : (double)NAN;
}

static bool is_same(const result_cell *a, const result_cell *b)
{
    if (a->kind != b->kind) {
        return false;
    }
    return a->kind == RESULT_TEXT ? strcmp(a->text, b->text) == 0 : a->kind == RESULT_ABSENT || a->number == b->number;
}

static bool has_same(const result_table *a, size_t in_a, const result_table *b, size_t in_b, unsigned factors)
{
    for (versus_column i = 0; i < VERSUS_FACTORS; ++i) {
        if ((factors & VERSUS_BIT(i)) != 0 && !is_same(result_cell_at(a, in_a, i), result_cell_at(b, in_b, i))) {
            return false;
        }
    }
    return true;
}

bool versus_same(const versus_data *data, size_t a, size_t b, unsigned factors)
{
    return has_same(data->cells, a, data->cells, b, factors);
}

versus_words versus_method_words(const versus_data *data, size_t cell)
{
    versus_words words;
    const bool is_own = versus_same(data, cell, 0, VERSUS_BIT(VERSUS_PATH));
    snprintf(words.text, sizeof words.text, "%.20s, %.20s, %.20s%s%.8s%s", versus_text(data, cell, VERSUS_LIST),
             versus_text(data, cell, VERSUS_SHARE), versus_text(data, cell, VERSUS_BUILDER), is_own ? "" : ", ",
             is_own ? "" : versus_text(data, cell, VERSUS_PATH), is_own ? "" : " path");
    return words;
}

size_t versus_kinds(const versus_data *data, size_t kinds[VERSUS_KINDS_MAX])
{
    const unsigned factors = VERSUS_METHOD & ~VERSUS_BIT(VERSUS_SHARE);
    size_t count = 0;
    for (size_t i = 0; i < data->count && count < VERSUS_KINDS_MAX; ++i) {
        bool is_new = versus_same(data, i, 0, VERSUS_SETTING) && data->samples[i].count > 0;
        for (size_t k = 0; k < count && is_new; ++k) {
            is_new = !versus_same(data, i, kinds[k], factors);
        }
        if (is_new) {
            kinds[count++] = i;
        }
    }
    return count;
}

/* ---- putting together ---- */

/* The row of `into` that a row of another set adds to: that of the same factors and tree. The row count: none. */
static size_t find_row(const result_table *into, const result_table *from, size_t row)
{
    const char *hash = result_cell_at(from, row, VERSUS_HASH)->text;
    size_t found = 0;
    for (; found < result_row_count(into); ++found) {
        const char *other = result_cell_at(into, found, VERSUS_HASH)->text;
        if (has_same(into, found, from, row, VERSUS_BIT(VERSUS_FACTORS) - 1u) &&
            (hash[0] == '\0' || other[0] == '\0' || strcmp(hash, other) == 0)) {
            return found;
        }
    }
    return found;
}

static void swap_row(result_table *into, size_t at, result_table *from, size_t row)
{
    for (size_t i = 0; i < VERSUS_COLUMNS; ++i) {
        const result_cell kept = into->cells[at * VERSUS_COLUMNS + i];
        into->cells[at * VERSUS_COLUMNS + i] = from->cells[row * VERSUS_COLUMNS + i];
        from->cells[row * VERSUS_COLUMNS + i] = kept;
    }
}

/* A cell that one process could not measure has what another measured. Returns the row. */
static size_t merge_cell(result_table *into, result_table *from, size_t row)
{
    const size_t found = find_row(into, from, row);
    const bool is_new = found == result_row_count(into);
    for (size_t i = 0; is_new && i < VERSUS_COLUMNS; ++i) {
        result_add_absent(into);
    }
    if (is_new || (result_cell_at(into, found, VERSUS_HASH)->text[0] == '\0' &&
                   result_cell_at(from, row, VERSUS_HASH)->text[0] != '\0')) {
        swap_row(into, found, from, row);
    }
    return found;
}

static const char *const raw_ids[] = {VERSUS_CELLS_ID, VERSUS_ROUNDS_ID, VERSUS_STARTS_ID};

/* Whether a set has the tables of versus_add_tables, with rows that can be read. */
static bool is_versus(const result_set *results)
{
    result_set *own = result_create();
    versus_add_tables(own);
    bool same = own != NULL && result_is_whole(results);
    for (size_t i = 0; i < 3 && same; ++i) {
        const result_table *known = result_find(own, raw_ids[i]);
        const result_table *table = result_find(results, raw_ids[i]);
        same = table != NULL && table->column_count == known->column_count;
        for (size_t k = 0; same && k < known->column_count; ++k) {
            same = strcmp(table->columns[k].name, known->columns[k].name) == 0;
        }
    }
    const result_table *cells = same ? result_find(results, VERSUS_CELLS_ID) : NULL;
    for (size_t row = 0; same && row < result_row_count(cells); ++row) {
        same = result_cell_at(cells, row, VERSUS_HASH)->kind == RESULT_TEXT;
    }
    result_destroy(&own);
    return same;
}

bool versus_merge(result_set *into, result_set *from, unsigned process)
{
    if (!is_versus(into) || !is_versus(from)) {
        return false;
    }
    result_table *cells = result_find(from, VERSUS_CELLS_ID);
    const result_table *rounds = result_find(from, VERSUS_ROUNDS_ID);
    const size_t count = result_row_count(cells);
    size_t *rows = calloc(count + 1, sizeof *rows);
    for (size_t i = 0; i < count && rows != NULL; ++i) {
        rows[i] = merge_cell(result_find(into, VERSUS_CELLS_ID), cells, i);
    }
    for (size_t i = 0; i < result_row_count(rounds) && rows != NULL; ++i) {
        for (size_t k = 0; k < rounds->column_count; ++k) {
            const double number = result_cell_at(rounds, i, k)->number;
            const size_t cell = k == ROUND_CELL && number >= 0 && number < (double)count ? (size_t)number : count;
            result_add_number(result_find(into, VERSUS_ROUNDS_ID), k == ROUND_CELL      ? (double)rows[cell]
                                                                   : k == ROUND_PROCESS ? process
                                                                                        : number);
        }
    }
    const bool done = rows != NULL && result_is_whole(into);
    free(rows);
    return done;
}

/* ---- reading ---- */

static void keep_round(const result_table *rounds, size_t row, versus_sample *sample)
{
    const size_t at = sample->count;
    const bool is_first = result_cell_at(rounds, row, ROUND_NUMBER)->number < 1;
    double ms[VERSUS_TIMES];
    for (size_t i = 0; i < VERSUS_TIMES; ++i) {
        ms[i] = result_cell_at(rounds, row, ROUND_TIMES + i)->number;
    }
    if (is_first) {
        sample->first_ms = isfinite(sample->first_ms) ? fmax(sample->first_ms, ms[VERSUS_WALL]) : ms[VERSUS_WALL];
    }
    if (at < BOOTSTRAP_ROUNDS_MAX && (!is_first || versus_is_round(ms))) {
        for (size_t i = 0; i < VERSUS_TIMES; ++i) {
            sample->ms[i][at] = ms[i];
        }
        sample->process[at] = (unsigned)result_cell_at(rounds, row, ROUND_PROCESS)->number;
        sample->round[at] = (unsigned)result_cell_at(rounds, row, ROUND_NUMBER)->number;
        ++sample->count;
    }
}

static int check_hashes(program *state, const versus_data *data)
{
    for (size_t i = 0; i < data->count; ++i) {
        const char *hash = versus_text(data, i, VERSUS_HASH);
        for (size_t k = 0; k < i && hash[0] != '\0'; ++k) {
            const char *other = versus_text(data, k, VERSUS_HASH);
            if (other[0] != '\0' && strcmp(hash, other) != 0 && versus_same(data, i, k, VERSUS_SETTING)) {
                return program_fail(state, PROGRAM_FAILED,
                                    "%s at depth %.0f, %s, %s, %s, %s: the tree's hash is %s, and %s has %s",
                                    versus_text(data, i, VERSUS_SCENE), versus_number(data, i, VERSUS_DEPTH),
                                    versus_method_words(data, i).text, versus_text(data, i, VERSUS_NEED),
                                    versus_text(data, i, VERSUS_WEIGHTS), versus_text(data, i, VERSUS_COVERAGE), hash,
                                    versus_method_words(data, k).text, other);
            }
        }
    }
    return PROGRAM_DONE;
}

int versus_open(program *state, const result_set *results, const char *name, versus_data *out)
{
    if (!is_versus(results)) {
        return program_fail(state, PROGRAM_FAILED, "%s: no results of bench gl-vs-cl", name);
    }
    const result_table *rounds = result_find(results, VERSUS_ROUNDS_ID);
    *out = (versus_data){.cells = result_find(results, VERSUS_CELLS_ID)};
    out->count = result_row_count(out->cells);
    out->samples = calloc(out->count + 1, sizeof *out->samples);
    if (out->samples == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory");
    }
    for (size_t i = 0; i < out->count; ++i) {
        out->samples[i].first_ms = (double)NAN;
    }
    for (size_t row = 0; row < result_row_count(rounds); ++row) {
        const double cell = result_cell_at(rounds, row, ROUND_CELL)->number;
        if (cell >= 0 && cell < (double)out->count) {
            keep_round(rounds, row, &out->samples[(size_t)cell]);
        }
    }
    const int exit_code = check_hashes(state, out);
    if (exit_code != PROGRAM_DONE) {
        versus_close(out);
    }
    return exit_code;
}

void versus_close(versus_data *data)
{
    free(data->samples);
    *data = (versus_data){.cells = NULL};
}

/* ---- times ---- */

interval versus_interval_of(const double *values, size_t count)
{
    const interval of = interval_of_time(values, count);
    return count > 1 ? of : (interval){NAN, of.middle, NAN};
}

interval versus_interval(const versus_data *data, size_t cell, versus_time time)
{
    return versus_interval_of(data->samples[cell].ms[time], data->samples[cell].count);
}

double versus_process_median(const versus_sample *sample, unsigned process)
{
    double own[BOOTSTRAP_ROUNDS_MAX];
    size_t count = 0;
    for (size_t i = 0; i < sample->count; ++i) {
        if (sample->process[i] == process) {
            own[count++] = sample->ms[VERSUS_WALL][i];
        }
    }
    return bootstrap_median(own, count);
}

static size_t list_ratios(const versus_sample *a, const versus_sample *b, double ratios[BOOTSTRAP_ROUNDS_MAX])
{
    size_t count = 0;
    for (size_t i = 0; i < a->count; ++i) {
        for (size_t k = 0; k < b->count; ++k) {
            if (a->process[i] == b->process[k] && a->round[i] == b->round[k] && count < BOOTSTRAP_ROUNDS_MAX) {
                ratios[count++] = a->ms[VERSUS_WALL][i] / b->ms[VERSUS_WALL][k];
            }
        }
    }
    return count;
}

unsigned versus_process_count(const versus_data *data)
{
    unsigned most = 0;
    for (size_t i = 0; i < data->count; ++i) {
        for (size_t k = 0; k < data->samples[i].count; ++k) {
            most = data->samples[i].process[k] > most ? data->samples[i].process[k] : most;
        }
    }
    return most;
}

interval versus_ratio(const versus_data *data, size_t cell, size_t other)
{
    double ratios[BOOTSTRAP_ROUNDS_MAX];
    const versus_sample *a = &data->samples[cell];
    const versus_sample *b = &data->samples[other];
    size_t count = list_ratios(a, b, ratios);
    const unsigned processes = count == 0 ? versus_process_count(data) : 0;
    for (unsigned i = 1; i <= processes && count < BOOTSTRAP_ROUNDS_MAX; ++i) {
        ratios[count] = versus_process_median(a, i) / versus_process_median(b, i);
        count += isfinite(ratios[count]) ? 1 : 0;
    }
    return versus_interval_of(ratios, count);
}
