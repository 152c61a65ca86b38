/* SPDX-License-Identifier: MIT */
/*
 * Which factor explains how much: an analysis of variance (Fisher, "Statistical Methods for Research Workers", 1925) of
 * the logarithms of times. The methods are no full cross of path, list, share and builder, but each has all needs,
 * weights and coverages, so these are orthogonal to each other and to the methods. A factor of the methods has two
 * shares: of the squares between its values, which another may explain too, and of those that nothing else explains.
 */
#include "bench/versus_effects.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define GROUPS_MAX ((size_t)1 << 20)
#define ROUNDING   1e-9 /* of sums of squares */
#define PAIR_LEAST 1e-3 /* what a pair must explain for a row */

/* The logarithm of a cell's median in one process, with the numbers of its factors' values. */
typedef struct observation {
    double log;
    unsigned value[VERSUS_FACTORS];
} observation;

typedef struct analysis {
    observation *list;
    size_t count;
    unsigned value_count[VERSUS_FACTORS];
    double *sums, *counts; /* of groups */
    double total;
} analysis;

/* What is analyzed together: cells that are like the first one in all but their methods and the factors that vary. */
typedef struct subset {
    const char *name;
    unsigned varying;
    bool is_series; /* values that a method lacks leave; else methods that lack a cell leave */
} subset;

static const char note[] =
    "Analysis of variance of the logarithm of wall times, of each cell's median in each process. Share: of the sum of "
    "squares, between the factor's values. Alone: what path, list, share and builder together explain beyond the other "
    "three of them; less than share where they go together, as a list by OpenGL and its path do. Pairs: what two "
    "explain beyond each, from 0.1 % on; what the method has with a setting contains what its factors have. Largest "
    "ratio: of the geometric means of the slowest and the fastest value.";

/* ---- observations ---- */

/* NAN where the process has no round of the cell. */
static double log_of_process(const versus_sample *sample, unsigned process)
{
    return log(versus_process_median(sample, process));
}

static bool is_complete(const versus_data *data, size_t cell, unsigned processes)
{
    bool complete = processes > 0;
    for (unsigned i = 1; i <= processes; ++i) {
        complete = complete && isfinite(log_of_process(&data->samples[cell], i));
    }
    return complete;
}

/* For each cell of the subset the first cell of the same value of some factors; data->count for other cells. */
static void number(const versus_data *data, const bool *is_in, unsigned factors, size_t *out)
{
    for (size_t i = 0; i < data->count; ++i) {
        out[i] = is_in[i] ? i : data->count;
        for (size_t k = 0; k < i && is_in[i]; ++k) {
            if (is_in[k] && out[k] == k && versus_same(data, i, k, factors)) {
                out[i] = k;
                break;
            }
        }
    }
}

static size_t count_distinct(const size_t *numbers, const bool *is_in, size_t count)
{
    size_t distinct = 0;
    for (size_t i = 0; i < count; ++i) {
        distinct += is_in[i] && numbers[i] == i;
    }
    return distinct;
}

/* How many cells of the subset have the same number. */
static size_t count_same(const size_t *numbers, const bool *is_in, size_t cell, size_t count)
{
    size_t same = 0;
    for (size_t i = 0; i < count; ++i) {
        same += is_in[i] && numbers[i] == numbers[cell];
    }
    return same;
}

/* Leaves a balanced design: values of which all methods have a cell, but for methods with one value; or methods that
   have all cells. */
static bool balance(const versus_data *data, const subset *of, bool *is_in)
{
    size_t *methods = calloc(2 * data->count + 1, sizeof *methods);
    size_t *settings = methods + data->count;
    bool *kept = calloc(data->count + 1, sizeof *kept);
    const bool done = methods != NULL && kept != NULL;
    if (done) {
        number(data, is_in, VERSUS_METHOD, methods);
        for (size_t i = 0; i < data->count && of->is_series; ++i) {
            kept[i] = is_in[i] && count_same(methods, is_in, i, data->count) > 1;
        }
        if (of->is_series) {
            memcpy(is_in, kept, data->count * sizeof *kept);
        }
        number(data, is_in, VERSUS_METHOD, methods);
        number(data, is_in, VERSUS_SETTING, settings);
        const size_t wanted = count_distinct(of->is_series ? methods : settings, is_in, data->count);
        for (size_t i = 0; i < data->count; ++i) {
            kept[i] = is_in[i] && count_same(of->is_series ? settings : methods, is_in, i, data->count) == wanted;
        }
        memcpy(is_in, kept, data->count * sizeof *kept);
    }
    free(kept);
    free(methods);
    return done;
}

static void number_values(const versus_data *data, const bool *is_in, size_t *firsts, analysis *all)
{
    const unsigned processes = versus_process_count(data);
    for (versus_column i = 0; i < VERSUS_FACTORS; ++i) {
        size_t at = 0;
        number(data, is_in, VERSUS_BIT(i), firsts);
        for (size_t cell = 0; cell < data->count; ++cell) {
            unsigned value = 0;
            for (size_t k = 0; k < firsts[cell] && is_in[cell]; ++k) {
                value += is_in[k] && firsts[k] == k;
            }
            for (unsigned k = 1; k <= processes && is_in[cell]; ++k) {
                all->list[at].value[i] = value;
                all->list[at++].log = log_of_process(&data->samples[cell], k);
            }
            all->value_count[i] = value + 1 > all->value_count[i] ? value + 1 : all->value_count[i];
        }
        all->count = at;
    }
}

/* ---- sums of squares ---- */

static size_t group_of(const analysis *all, const observation *one, unsigned factors)
{
    size_t group = 0;
    for (versus_column i = 0; i < VERSUS_FACTORS; ++i) {
        group = (factors & VERSUS_BIT(i)) != 0 ? group * all->value_count[i] + one->value[i] : group;
    }
    return group;
}

static size_t count_groups(const analysis *all, unsigned factors)
{
    size_t count = 1;
    for (versus_column i = 0; i < VERSUS_FACTORS; ++i) {
        count *= (factors & VERSUS_BIT(i)) != 0 ? all->value_count[i] : 1;
    }
    return count;
}

static void sum_groups(const analysis *all, unsigned factors)
{
    const size_t groups = count_groups(all, factors);
    memset(all->sums, 0, groups * sizeof *all->sums);
    memset(all->counts, 0, groups * sizeof *all->counts);
    for (size_t i = 0; i < all->count; ++i) {
        const size_t group = group_of(all, &all->list[i], factors);
        all->sums[group] += all->list[i].log;
        all->counts[group] += 1;
    }
}

/* The sum of squares between the groups of factors. */
static double between(const analysis *all, unsigned factors)
{
    double sum = 0;
    double squares = 0;
    sum_groups(all, factors);
    for (size_t i = 0; i < count_groups(all, factors); ++i) {
        sum += all->sums[i];
        squares += all->counts[i] > 0 ? all->sums[i] * all->sums[i] / all->counts[i] : 0;
    }
    return squares - sum * sum / (double)all->count;
}

static double largest_ratio(const analysis *all, unsigned factors)
{
    double least = INFINITY;
    double most = -INFINITY;
    sum_groups(all, factors);
    for (size_t i = 0; i < count_groups(all, factors); ++i) {
        if (all->counts[i] > 0) {
            least = fmin(least, all->sums[i] / all->counts[i]);
            most = fmax(most, all->sums[i] / all->counts[i]);
        }
    }
    return exp(most - least);
}

static double total(const analysis *all)
{
    double sum = 0;
    double squares = 0;
    for (size_t i = 0; i < all->count; ++i) {
        sum += all->list[i].log;
        squares += all->list[i].log * all->list[i].log;
    }
    return squares - sum * sum / (double)all->count;
}

/* ---- the table ---- */

typedef struct factor {
    const char *name;
    unsigned bits;
} factor;

static const factor factors[] = {
    {"method", VERSUS_METHOD},
    {"path", VERSUS_BIT(VERSUS_PATH)},
    {"list", VERSUS_BIT(VERSUS_LIST)},
    {"share", VERSUS_BIT(VERSUS_SHARE)},
    {"builder", VERSUS_BIT(VERSUS_BUILDER)},
    {"need", VERSUS_BIT(VERSUS_NEED)},
    {"weights", VERSUS_BIT(VERSUS_WEIGHTS)},
    {"coverage", VERSUS_BIT(VERSUS_COVERAGE)},
    {"depth", VERSUS_BIT(VERSUS_DEPTH)},
    {"scene", VERSUS_BIT(VERSUS_SCENE)},
};
#define FACTOR_COUNT  (sizeof factors / sizeof factors[0])
#define FIRST_SETTING 5u
#define EVERY         (VERSUS_BIT(VERSUS_FACTORS) - 1u)

static size_t count_values(const analysis *all, unsigned bits)
{
    size_t values = 0;
    sum_groups(all, bits);
    for (size_t i = 0; i < count_groups(all, bits); ++i) {
        values += all->counts[i] > 0;
    }
    return values;
}

static void add_share(result_table *table, double share)
{
    result_add_number(table, share > ROUNDING ? 100 * share : 0);
}

static void add_row(result_table *table, const subset *of, const char *name, double share)
{
    result_add_text(table, "%s", of->name);
    result_add_text(table, "%s", name);
    add_share(table, share);
}

static void add_single(result_table *table, const subset *of, const analysis *all, const factor *one)
{
    const bool is_method = (one->bits & VERSUS_METHOD) != 0;
    const double alone =
        is_method ? between(all, VERSUS_METHOD) - between(all, VERSUS_METHOD & ~one->bits) : between(all, one->bits);
    add_row(table, of, one->name, between(all, one->bits) / all->total);
    add_share(table, alone / all->total);
    result_add_number(table, (double)count_values(all, one->bits));
    result_add_number(table, largest_ratio(all, one->bits));
}

/* Returns what the pair explains. */
static double add_pair(result_table *table, const subset *of, const analysis *all, const factor *a, const factor *b)
{
    char name[64];
    const unsigned both = a->bits | b->bits;
    const double share = (between(all, both) - between(all, a->bits) - between(all, b->bits)) / all->total;
    if (share < PAIR_LEAST) {
        return share;
    }
    snprintf(name, sizeof name, "%s × %s", a->name, b->name);
    add_row(table, of, name, share);
    result_add_text(table, "%s", "");
    result_add_number(table, (double)count_values(all, both));
    result_add_number(table, largest_ratio(all, both));
    return share;
}

static void add_last(result_table *table, const subset *of, const char *name, double share)
{
    add_row(table, of, name, share);
    for (size_t i = 0; i < 3; ++i) {
        result_add_text(table, "%s", "");
    }
}

/* Factors by themselves, pairs with a setting, and the rest. The method contains its factors, and so do its pairs. */
static void add_rows(result_table *table, const subset *of, const analysis *all)
{
    double left = between(all, EVERY) / all->total;
    for (size_t i = 0; i < FACTOR_COUNT; ++i) {
        if (count_values(all, factors[i].bits) > 1) {
            add_single(table, of, all, &factors[i]);
            left -= i == 0 || i >= FIRST_SETTING ? between(all, factors[i].bits) / all->total : 0;
        }
    }
    for (size_t i = 0; i < FACTOR_COUNT; ++i) {
        for (size_t k = i < FIRST_SETTING ? FIRST_SETTING : i + 1; k < FACTOR_COUNT; ++k) {
            if (count_values(all, factors[i].bits) > 1 && count_values(all, factors[k].bits) > 1) {
                const double share = add_pair(table, of, all, &factors[i], &factors[k]);
                left -= i == 0 || i >= FIRST_SETTING ? share : 0;
            }
        }
    }
    add_last(table, of, "three and more", left);
    add_last(table, of, "between processes", 1 - between(all, EVERY) / all->total);
}

static void analyze(const versus_data *data, const subset *of, result_table *table)
{
    const unsigned processes = versus_process_count(data);
    analysis all = {.count = 0};
    bool *is_in = calloc(data->count + 1, sizeof *is_in);
    size_t *firsts = calloc(data->count + 1, sizeof *firsts);
    all.list = calloc(data->count * processes + 1, sizeof *all.list);
    for (size_t i = 0; i < data->count && is_in != NULL; ++i) {
        is_in[i] = versus_same(data, i, 0, VERSUS_SETTING & ~of->varying) && is_complete(data, i, processes);
    }
    if (is_in != NULL && firsts != NULL && all.list != NULL && balance(data, of, is_in)) {
        number_values(data, is_in, firsts, &all);
    }
    const size_t groups = all.count > 0 ? count_groups(&all, EVERY) : 0;
    all.sums = groups > 0 && groups < GROUPS_MAX ? calloc(2 * groups, sizeof *all.sums) : NULL;
    if (all.sums != NULL) {
        all.counts = all.sums + groups;
        all.total = fmax(total(&all), 1e-300);
        if (count_values(&all, of->varying) > 1) {
            add_rows(table, of, &all);
        }
    }
    free(all.sums);
    free(all.list);
    free(firsts);
    free(is_in);
}

void versus_add_effects(const versus_data *data, result_set *results)
{
    static const unsigned payload = VERSUS_BIT(VERSUS_NEED) | VERSUS_BIT(VERSUS_WEIGHTS) | VERSUS_BIT(VERSUS_COVERAGE);
    static const subset subsets[] = {{"methods and payload", payload, false},
                                     {"methods and depth", VERSUS_BIT(VERSUS_DEPTH), true},
                                     {"methods and scene", VERSUS_BIT(VERSUS_SCENE), true}};
    result_table *table = result_add_table(results, "gl-vs-cl-effects", "Effects", note);
    result_add_column(table, "design", "");
    result_add_column(table, "factor", "");
    result_add_column(table, "share", "%");
    result_add_column(table, "alone", "%");
    result_add_column(table, "values", "");
    result_add_column(table, "largest ratio", "");
    for (size_t i = 0; i < sizeof subsets / sizeof subsets[0]; ++i) {
        analyze(data, &subsets[i], table);
    }
}
