/* SPDX-License-Identifier: MIT */
/* Tables of settings, errors and raw rounds; the answer in words. */
#include "tune/answer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "measure/host.h"
#include "measure/result_json.h"
#include "measure/spread.h"
#include "support/info_of.h"
#include "support/json.h"
#include "support/table.h"
#include "tune/state.h"
#include "tune/text_list.h"

#define ROWS_SHOWN 16u

/* The measures that have a column in the table of settings, where they were measured. */
static const char *const shown[] = {
    "voxel-rms-units", "surface-rms-units", "face-max-units", "area",       "volume",      "color", "delta-e",
    "normal",          "depth-rms-units",   "silhouette",     "triangle",   "t-rms-units", "ao",    "ao-bias",
    "light",           "light-bias",        "direct",         "direct-bias"};
#define SHOWN (sizeof shown / sizeof shown[0])

static double value_of(const candidate *of, size_t measure)
{
    const tune_measure *which = tune_measure_at(measure);
    const tune_errors *errors = of->errors[quantity_kind(which->quantity)];
    if (errors == NULL) {
        return NAN;
    }
    const sample_block sum = samples_sum(&errors->of[which->quantity]);
    return tune_measure_value(which, errors, &sum);
}

static bool is_measured(const sweep *all, size_t measure)
{
    bool found = false;
    for (size_t i = 0; i < all->count && !found; ++i) {
        found = isfinite(value_of(&all->candidates[i], measure));
    }
    return found;
}

static bool varies(const sweep *all, tune_dimension which)
{
    return which == DIMENSION_DEPTH || all->space.counts[which] > 1 ||
           (which == DIMENSION_GATHER && all->space.values[which][0] != 0);
}

void answer_varied(const sweep *all, size_t index, text_list *out)
{
    char value[32];
    text_list_clear(out);
    for (tune_dimension at = DIMENSION_COVERAGE; at < DIMENSION_COUNT; ++at) {
        dimension_value(at, all->settings[index].setting.values[at], value, sizeof value);
        if (varies(all, at)) {
            text_list_add(out, "%s%s", out->used > 0 ? ", " : "", value);
        }
    }
}

/* ---- tables ---- */

static const char *standing_of(const sweep *all, size_t index)
{
    const race of = sweep_race(all);
    const candidate *own = &all->candidates[index];
    if (index == all->verdict.winner || index == all->verdict.second) {
        return index == all->verdict.winner ? "answer" : "second";
    }
    if (own->left != LEFT_NOT) {
        return race_left_name(own->left);
    }
    return race_is_on_front(&of, index) ? "front" : "";
}

/* A number, or why there is none. */
static void add_value(const sweep *all, size_t index, size_t measure, result_table *into)
{
    const char *why = tune_setting_lacks(&all->settings[index].setting, tune_measure_at(measure)->quantity);
    if (why != NULL) {
        result_add_text(into, "%s", why);
    } else {
        result_add_number(into, value_of(&all->candidates[index], measure));
    }
}

static void add_setting(const sweep *all, size_t index, result_table *into)
{
    char value[32];
    text_list text;
    const sweep_setting *own = &all->settings[index];
    const candidate *of = &all->candidates[index];
    double rounds[BOOTSTRAP_ROUNDS_MAX];
    result_add_text(into, "%s", standing_of(all, index));
    for (tune_dimension i = DIMENSION_DEPTH; i < DIMENSION_COUNT; ++i) {
        if (i == DIMENSION_DEPTH) {
            result_add_number(into, own->setting.values[i]);
        } else if (varies(all, i)) {
            dimension_value(i, own->setting.values[i], value, sizeof value);
            result_add_text(into, "%s", value);
        }
    }
    memcpy(rounds, of->rounds, sizeof rounds);
    spread_add(into, of->round_count > 0 ? spread_of(rounds, of->round_count) : spread_none());
    result_add_number(into, own->first_ms > 0 ? own->first_ms : (double)NAN);
    result_add_number(into, of->bytes > 0 ? of->bytes : (double)NAN);
    result_add_number(into, own->result_bytes > 0 ? own->result_bytes : (double)NAN);
    if (all->runs->traces || all->space.values[DIMENSION_GATHER][0] != 0) {
        result_add_number(into, own->query_us);
    }
    for (size_t i = 0; i < SHOWN; ++i) {
        const size_t measure = tune_measure_find(shown[i], strlen(shown[i]));
        if (is_measured(all, measure)) {
            add_value(all, index, measure, into);
        }
    }
    tune_setting_command(all->state, &own->setting, &text);
    result_add_text(into, "%s", text.text);
}

static void add_settings(const sweep *all, result_set *tables)
{
    result_table *into = result_add_table(tables, "tune", "Settings",
                                          "Time: plan, build, compact form, light and queries, median and quartiles of "
                                          "the rounds after the first run, which is apart, compiles, and makes the "
                                          "sampled queries alone. Memory: the most on the device at one time. Result: "
                                          "the tree or its compact form, light and probes. Errors: against the mesh as "
                                          "it was given; ao reaches as far as `svocl gather` has it");
    result_add_column(into, "standing", "");
    for (tune_dimension i = DIMENSION_DEPTH; i < DIMENSION_COUNT; ++i) {
        if (varies(all, i)) {
            result_add_column(into, dimension_name(i), "");
        }
    }
    spread_add_columns(into, "time", "ms");
    result_add_column(into, "first", "ms");
    result_add_column(into, "memory", "B");
    result_add_column(into, "result", "B");
    if (all->runs->traces || all->space.values[DIMENSION_GATHER][0] != 0) {
        result_add_column(into, "query", "µs");
    }
    for (size_t i = 0; i < SHOWN; ++i) {
        const size_t measure = tune_measure_find(shown[i], strlen(shown[i]));
        if (is_measured(all, measure)) {
            result_add_column(into, shown[i], tune_measure_at(measure)->unit);
        }
    }
    result_add_column(into, "command", "");
    for (size_t i = 0; i < all->count; ++i) {
        add_setting(all, i, into);
    }
}

static void add_errors(const sweep *all, result_set *tables)
{
    result_table *into = result_add_table(tables, "tune-errors", "All measures",
                                          "Intervals: 95 %, by the bootstrap over sample points. Largest values are "
                                          "those of the points that were sampled");
    const char *const columns[] = {"setting", "measure", "value", "low", "high", "points", "unit"};
    for (size_t i = 0; i < sizeof columns / sizeof columns[0]; ++i) {
        result_add_column(into, columns[i], "");
    }
    for (size_t i = 0; i < all->count; ++i) {
        for (size_t measure = 0; measure < tune_measure_count(); ++measure) {
            const tune_measure *which = tune_measure_at(measure);
            const tune_errors *errors = all->candidates[i].errors[quantity_kind(which->quantity)];
            const double value = value_of(&all->candidates[i], measure);
            if (!isfinite(value)) {
                continue;
            }
            const interval own = race_error(&all->candidates[i], measure);
            result_add_number(into, (double)i);
            result_add_text(into, "%s", which->name);
            result_add_number(into, value);
            result_add_number(into, own.low);
            result_add_number(into, own.high);
            result_add_number(into, samples_sum(&errors->of[which->quantity]).count);
            result_add_text(into, "%s", which->unit);
        }
    }
}

static void add_rounds(const sweep *all, result_set *tables)
{
    text_list text;
    result_table *into = result_add_table(tables, "tune-rounds", "Rounds", "Each round of each setting");
    result_add_column(into, "setting", "");
    result_add_column(into, "round", "");
    result_add_column(into, "time", "ms");
    result_add_column(into, "memory", "B");
    result_add_column(into, "command", "");
    for (size_t i = 0; i < all->count; ++i) {
        tune_setting_command(all->state, &all->settings[i].setting, &text);
        for (size_t round = 0; round < all->candidates[i].round_count; ++round) {
            result_add_number(into, (double)i);
            result_add_number(into, (double)round);
            result_add_number(into, all->candidates[i].rounds[round]);
            result_add_number(into, all->candidates[i].bytes);
            result_add_text(into, "%s", text.text);
        }
    }
}

result_set *answer_tables(const sweep *all)
{
    result_set *tables = result_create();
    if (tables != NULL) {
        host_describe(&all->state->options, &tables->machine);
        result_set_fact(tables, &tables->machine.device, info_of_device(all->made->opened->device).name);
        add_settings(all, tables);
        add_errors(all, tables);
        add_rounds(all, tables);
    }
    return tables;
}

/* ---- words ---- */

/* What trees hold that nobody named: by bounds, and by what is gathered. */
static void add_needs(const sweep *all, text_list *out)
{
    text_list names;
    const uint32_t named = all->state->options.need;
    uint32_t asked = 0;
    uint32_t gathered = 0;
    for (size_t i = 0; tune_bounds_at(&all->bounds, i) != NULL; ++i) {
        asked |= quantity_need(tune_bounds_at(&all->bounds, i)->quantity) & ~all->usual_need;
    }
    for (size_t i = 0; i < all->count && named != (uint32_t)SVO_NEED_DEFAULT; ++i) {
        gathered |= all->settings[i].setting.need & ~named;
    }
    if (named == (uint32_t)SVO_NEED_DEFAULT && asked != 0) {
        tune_need_names(asked, &names);
        text_list_add(out, "; trees hold %s, too, which --error asks for", names.text);
    }
    if (gathered != 0) {
        tune_need_names(gathered, &names);
        text_list_add(out, "; trees hold %s, too, by which light is gathered", names.text);
    }
}

void answer_words(const sweep *all, text_list *out)
{
    const tune_bounds *bounds = &all->bounds;
    text_list_clear(out);
    if (!race_has_goal(bounds)) {
        text_list_add(out, "no bound is given: settings marked front are those that none beats in everything");
        add_needs(all, out);
        return;
    }
    text_list_add(out, "least %s",
                  bounds->least < tune_measure_count() ? tune_measure_at(bounds->least)->name : "time");
    for (size_t i = 0; i < bounds->count; ++i) {
        text_list_add(out, ", %s at most %g", tune_measure_at(bounds->list[i].measure)->name, bounds->list[i].most);
    }
    if (isfinite(bounds->time_ms)) {
        text_list_add(out, ", time at most %s", figure_ms(bounds->time_ms).text);
    }
    if (isfinite(bounds->bytes)) {
        text_list_add(out, ", memory at most %s", figure_bytes((uint64_t)bounds->bytes).text);
    }
    if (all->verdict.winner == all->count) {
        text_list_add(out, ": no setting keeps these bounds");
    }
    add_needs(all, out);
}

static void print_setting(const sweep *all, const char *what, size_t index)
{
    text_list text;
    const candidate *own = &all->candidates[index];
    tune_setting_command(all->state, &all->settings[index].setting, &text);
    table_line("%s: %s", what, text.text);
    answer_varied(all, index, &text);
    table_line("  %s%s%s, memory %s", text.text, text.used > 0 ? ": " : "",
               figure_ms(bootstrap_median(own->rounds, own->round_count)).text,
               figure_bytes((uint64_t)own->bytes).text);
}

static void print_fresh(const sweep *all)
{
    for (size_t i = 0; i < all->bounds.count; ++i) {
        const tune_measure *which = tune_measure_at(all->bounds.list[i].measure);
        const tune_errors *errors = &all->fresh[quantity_kind(which->quantity)];
        const sample_block sum = samples_sum(&errors->of[which->quantity]);
        const interval own = race_error(&all->candidates[all->verdict.winner], all->bounds.list[i].measure);
        table_line("  %s %.4g (%.4g to %.4g), at most %g; on fresh points %.4g", which->name, own.middle, own.low,
                   own.high, all->bounds.list[i].most, fabs(tune_measure_value(which, errors, &sum)));
    }
}

static void print_answer(const sweep *all)
{
    text_list text;
    answer_words(all, &text);
    table_line("%s", text.text);
    if (all->verdict.winner < all->count) {
        print_setting(all, "answer", all->verdict.winner);
        print_fresh(all);
        tune_setting_code(&all->settings[all->verdict.winner].setting, &text);
        table_line("  C: %s", text.text);
        if (tune_setting_rest(&all->settings[all->verdict.winner].setting)[0] != '\0') {
            table_line("  %s", tune_setting_rest(&all->settings[all->verdict.winner].setting));
        }
        table_line("  wins in %.0f %% of resampled sweeps, within 5 %% of the winner in %.0f %%",
                   100 * all->verdict.sure, 100 * all->verdict.near);
    }
    if (all->verdict.second < all->count) {
        print_setting(all, "second", all->verdict.second);
    }
}

/* Rows by time, those that are in the race first. */
typedef struct row_order {
    size_t index;
    double time;
    bool left;
} row_order;

static int compare_rows(const void *a, const void *b)
{
    const row_order *first = a;
    const row_order *second = b;
    if (first->left != second->left) {
        return first->left - second->left;
    }
    return first->time == second->time ? (first->index > second->index) - (first->index < second->index)
                                       : (first->time > second->time) - (first->time < second->time);
}

#define COLUMNS_SHOWN 4u

/* The measures of the bounds, then usual ones, as far as they were measured. Returns how many. */
static size_t choose_columns(const sweep *all, size_t columns[COLUMNS_SHOWN])
{
    static const char *const usual[] = {"light", "ao", "voxel-rms-units", "normal", "delta-e"};
    size_t count = 0;
    for (size_t i = 0; i < TUNE_BOUNDS_MAX + 1 + sizeof usual / sizeof usual[0] && count < COLUMNS_SHOWN; ++i) {
        const tune_measure *asked = tune_bounds_at(&all->bounds, i);
        const size_t place = i - TUNE_BOUNDS_MAX - 1;
        if (asked == NULL && i < TUNE_BOUNDS_MAX + 1) {
            continue;
        }
        const char *name = i < TUNE_BOUNDS_MAX + 1 ? asked->name : usual[place];
        const size_t measure = tune_measure_find(name, strlen(name));
        bool is_new = is_measured(all, measure);
        for (size_t k = 0; k < count; ++k) {
            is_new = is_new && columns[k] != measure;
        }
        columns[count] = measure;
        count += is_new;
    }
    return count;
}

static void print_value(const sweep *all, size_t index, size_t measure, table *rows)
{
    const char *why = tune_setting_lacks(&all->settings[index].setting, tune_measure_at(measure)->quantity);
    const double value = value_of(&all->candidates[index], measure);
    if (isfinite(value)) {
        table_cell(rows, "%.4g", value);
    } else {
        table_cell(rows, "%s", why != NULL ? why : "-");
    }
}

static void print_row(const sweep *all, const row_order *row, table *rows)
{
    text_list list;
    const candidate *own = &all->candidates[row->index];
    answer_varied(all, row->index, &list);
    table_cell(rows, "%s", standing_of(all, row->index));
    table_cell(rows, "%d", all->settings[row->index].setting.values[DIMENSION_DEPTH]);
    table_cell(rows, "%s", list.text);
    table_cell(rows, "%s", isfinite(row->time) ? figure_ms(row->time).text : "-");
    table_cell(rows, "%s", own->bytes > 0 ? figure_bytes((uint64_t)own->bytes).text : "-");
}

static void print_rows(const sweep *all, const row_order *order)
{
    static const char *const heads[] = {"", "depth", "setting", "time", "memory"};
    size_t columns[COLUMNS_SHOWN];
    const size_t column_count = choose_columns(all, columns);
    char alignment[] = "lrlrrrrrr";
    alignment[sizeof heads / sizeof heads[0] + column_count] = '\0';
    table *rows = table_create(alignment);
    for (size_t i = 0; i < sizeof heads / sizeof heads[0]; ++i) {
        table_cell(rows, "%s", heads[i]);
    }
    for (size_t k = 0; k < column_count; ++k) {
        table_cell(rows, "%s", tune_measure_at(columns[k])->name);
    }
    for (size_t i = 0; i < all->count && i < ROWS_SHOWN; ++i) {
        print_row(all, &order[i], rows);
        for (size_t k = 0; k < column_count; ++k) {
            print_value(all, order[i].index, columns[k], rows);
        }
    }
    table_print(rows);
    if (all->count > ROWS_SHOWN) {
        table_line("and %zu more settings: --json, --csv and --page have all", all->count - ROWS_SHOWN);
    }
}

void answer_print(const sweep *all)
{
    row_order *order = calloc(all->count + 1, sizeof *order);
    for (size_t i = 0; i < all->count && order != NULL; ++i) {
        const candidate *own = &all->candidates[i];
        order[i] =
            (row_order){.index = i,
                        .time = own->round_count > 0 ? bootstrap_median(own->rounds, own->round_count) : HUGE_VAL,
                        .left = own->left != LEFT_NOT && i != all->verdict.winner && i != all->verdict.second};
    }
    if (order != NULL) {
        qsort(order, all->count, sizeof *order, compare_rows);
        print_rows(all, order);
    }
    free(order);
    print_answer(all);
}

/* ---- JSON ---- */

static cJSON *verdict_to_json(const sweep *all, size_t index)
{
    text_list text;
    const candidate *own = &all->candidates[index];
    cJSON *object = cJSON_CreateObject();
    json_add_count(object, "setting", index);
    tune_setting_command(all->state, &all->settings[index].setting, &text);
    json_add_text(object, "command", text.text);
    tune_setting_code(&all->settings[index].setting, &text);
    json_add_text(object, "c", text.text);
    json_add_text(object, "note", tune_setting_rest(&all->settings[index].setting));
    const interval time = interval_of_time(own->rounds, own->round_count);
    cJSON_AddNumberToObject(object, "time_ms", time.middle);
    cJSON_AddNumberToObject(object, "time_low_ms", time.low);
    cJSON_AddNumberToObject(object, "time_high_ms", time.high);
    cJSON_AddNumberToObject(object, "memory_bytes", own->bytes);
    return object;
}

cJSON *answer_to_json(const sweep *all, const result_set *tables)
{
    text_list text;
    cJSON *document = state_to_json(all);
    cJSON *of_tables = result_to_json(tables);
    if (document == NULL || of_tables == NULL) {
        cJSON_Delete(document);
        cJSON_Delete(of_tables);
        return NULL;
    }
    answer_words(all, &text);
    json_add_text(document, "asked", text.text);
    cJSON_AddItemToObject(document, "answer",
                          all->verdict.winner < all->count ? verdict_to_json(all, all->verdict.winner)
                                                           : cJSON_CreateNull());
    cJSON_AddItemToObject(document, "second",
                          all->verdict.second < all->count ? verdict_to_json(all, all->verdict.second)
                                                           : cJSON_CreateNull());
    cJSON_AddNumberToObject(document, "sure", all->verdict.sure);
    cJSON_AddNumberToObject(document, "within_5_percent", all->verdict.near);
    cJSON *fresh = cJSON_AddObjectToObject(document, "fresh");
    for (size_t i = 0; i < tune_measure_count() && all->is_confirmed; ++i) {
        const tune_measure *which = tune_measure_at(i);
        const tune_errors *errors = &all->fresh[quantity_kind(which->quantity)];
        const sample_block sum = samples_sum(&errors->of[which->quantity]);
        if (sum.count > 0) {
            cJSON_AddNumberToObject(fresh, which->name, tune_measure_value(which, errors, &sum));
        }
    }
    cJSON_AddItemToObject(document, "machine", cJSON_DetachItemFromObject(of_tables, "machine"));
    cJSON_AddItemToObject(document, "tables", cJSON_DetachItemFromObject(of_tables, "tables"));
    cJSON_Delete(of_tables);
    return document;
}
