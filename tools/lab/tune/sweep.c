/* SPDX-License-Identifier: MIT */
/* Rounds go through all settings that remain, one after the other, so that disturbances of the machine affect all
   alike. */
#include "tune/sweep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/json.h"
#include "tune/light_errors.h"

/* Rounds of each setting up to the end of a rung. */
static const size_t rounds_until[SWEEP_RUNGS] = {2, 4, 7, 11};

/* ---- records ---- */

/* The dimensions that errors of a kind depend on. */
static bool shares_record(tune_kind kind, const tune_setting *a, const tune_setting *b)
{
    bool same = true;
    for (int i = 0; i < DIMENSION_COUNT; ++i) {
        const bool matters = i == DIMENSION_DEPTH || i == DIMENSION_COVERAGE ||
                             (kind == KIND_RAYS && i == DIMENSION_FORM) ||
                             (kind >= KIND_PAYLOAD && i == DIMENSION_WEIGHTS) ||
                             (kind == KIND_LIGHT && (i == DIMENSION_LIGHT_FORM || i == DIMENSION_GATHER));
        same = same && (!matters || a->values[i] == b->values[i]);
    }
    return same;
}

static size_t find_record(sweep *all, size_t index, tune_kind kind)
{
    for (size_t i = 0; i < index; ++i) {
        if (shares_record(kind, &all->settings[i].setting, &all->settings[index].setting)) {
            return all->settings[i].records[kind];
        }
    }
    all->records[all->record_count].kind = kind;
    return all->record_count++;
}

bool sweep_begin(sweep *all)
{
    all->candidates = calloc(all->count + 1, sizeof *all->candidates);
    all->records = calloc(KIND_COUNT * all->count + 1, sizeof *all->records);
    all->fresh = calloc(KIND_COUNT, sizeof *all->fresh);
    all->record_count = 0;
    if (all->candidates == NULL || all->records == NULL || all->fresh == NULL) {
        return false;
    }
    for (size_t i = 0; i < all->count; ++i) {
        const bool gathers = all->settings[i].setting.values[DIMENSION_GATHER] != 0;
        for (tune_quantity k = QUANTITY_VOXEL; k < QUANTITY_COUNT; ++k) {
            all->candidates[i].lacks[k] = tune_setting_lacks(&all->settings[i].setting, k) != NULL;
        }
        for (tune_kind kind = KIND_SHAPE; kind < KIND_COUNT; ++kind) {
            if (kind != KIND_LIGHT || gathers) {
                all->settings[i].records[kind] = find_record(all, i, kind);
                all->candidates[i].errors[kind] = &all->records[all->settings[i].records[kind]];
            } else {
                all->settings[i].records[kind] = SIZE_MAX;
            }
        }
    }
    return true;
}

void sweep_end(sweep *all)
{
    free(all->settings);
    free(all->candidates);
    free(all->records);
    free(all->fresh);
    all->settings = NULL;
    all->candidates = NULL;
    all->records = all->fresh = NULL;
}

race sweep_race(const sweep *all)
{
    return (race){.list = all->candidates, .count = all->count, .bounds = &all->bounds};
}

/* ---- a rung ---- */

static void fail_setting(sweep *all, size_t index, const svo_message *reason, unsigned rung)
{
    all->candidates[index].left = LEFT_FAILED;
    all->candidates[index].left_after = rung;
    all->settings[index].reason = *reason;
}

/* One run of a setting: the first one is apart. */
static void run_setting(sweep *all, size_t index, unsigned rung)
{
    sweep_setting *own = &all->settings[index];
    candidate *of = &all->candidates[index];
    trial_times times;
    svo_message reason = {""};
    const bool is_first = !(own->first_ms > 0);
    for (int i = 0; i < 1 + is_first; ++i) {
        if (!trial_run(all->runs, &own->setting, &times, &reason)) {
            fail_setting(all, index, &reason, rung);
            return;
        }
        if (is_first && i == 0) {
            own->first_ms = times.once_ms;
        }
    }
    of->rounds[of->round_count++] = times.total_ms;
    of->bytes = fmax(of->bytes, times.bytes);
    own->result_bytes = times.result_bytes;
    own->query_us = times.query_us;
    tune_errors *light = own->setting.values[DIMENSION_GATHER] != 0 ? &all->records[own->records[KIND_LIGHT]] : NULL;
    if (light != NULL && light->rungs == 0) {
        light_errors_add(all->made, &own->setting, all->runs->gathered, light);
        light->rungs = 1;
    }
}

/* measured: set where something was. */
static int run_rounds(sweep *all, unsigned rung, bool *measured)
{
    int exit_code = PROGRAM_DONE;
    for (size_t round = 0; round < rounds_until[rung] && exit_code == PROGRAM_DONE; ++round) {
        bool ran = false;
        for (size_t i = 0; i < all->count; ++i) {
            progress_part(all->state->progress, "builds",
                          (double)(round * all->count + i) / (double)(rounds_until[rung] * all->count));
            if (all->candidates[i].left == LEFT_NOT && all->candidates[i].round_count == round) {
                run_setting(all, i, rung);
                ran = true;
            }
        }
        *measured = *measured || ran;
        exit_code = ran ? all->save(all) : PROGRAM_DONE;
    }
    return exit_code;
}

static int add_errors(sweep *all, unsigned rung, bool *measured)
{
    int exit_code = PROGRAM_DONE;
    for (size_t i = 0; i < all->count && exit_code == PROGRAM_DONE; ++i) {
        sampler_targets targets = {{NULL}};
        bool wanted = false;
        for (tune_kind kind = KIND_SHAPE; kind <= KIND_PAYLOAD; ++kind) {
            tune_errors *record = &all->records[all->settings[i].records[kind]];
            if (all->candidates[i].left == LEFT_NOT && record->rungs == rung) {
                targets.of[kind] = record;
                wanted = true;
            }
        }
        progress_part(all->state->progress, "errors", (double)i / (double)all->count);
        if (wanted) {
            *measured = true;
            exit_code = sampler_add(all->made, &all->settings[i].setting, rung, all->seed, &targets);
        }
        for (tune_kind kind = KIND_SHAPE; kind <= KIND_PAYLOAD && wanted && exit_code == PROGRAM_DONE; ++kind) {
            if (targets.of[kind] != NULL) {
                ++targets.of[kind]->rungs;
            }
        }
    }
    return exit_code;
}

/* ---- the answer ---- */

/* Whether the answer keeps its bounds on fresh points. */
static bool keeps_bounds(const sweep *all)
{
    bool keeps = true;
    for (size_t i = 0; i < all->bounds.count; ++i) {
        const tune_measure *measure = tune_measure_at(all->bounds.list[i].measure);
        const tune_errors *errors = &all->fresh[quantity_kind(measure->quantity)];
        const sample_block sum = samples_sum(&errors->of[measure->quantity]);
        keeps = keeps && fabs(tune_measure_value(measure, errors, &sum)) <= all->bounds.list[i].most;
    }
    return keeps;
}

static int measure_fresh(sweep *all, size_t index)
{
    const tune_setting *setting = &all->settings[index].setting;
    sampler_targets targets = {{&all->fresh[KIND_SHAPE], &all->fresh[KIND_RAYS], &all->fresh[KIND_PAYLOAD]}};
    memset(all->fresh, 0, KIND_COUNT * sizeof *all->fresh);
    int exit_code = sampler_add(all->made, setting, SWEEP_RUNGS - 1, all->seed + 1, &targets);
    if (exit_code == PROGRAM_DONE && setting->values[DIMENSION_GATHER] != 0) {
        trial_times times;
        svo_message reason = {""};
        exit_code = sampler_light_truth(all->made, all->seed + 1);
        if (exit_code == PROGRAM_DONE && trial_run(all->runs, setting, &times, &reason)) {
            light_errors_add(all->made, setting, all->runs->gathered, &all->fresh[KIND_LIGHT]);
        }
    }
    return exit_code;
}

static int answer(sweep *all)
{
    const race of = sweep_race(all);
    int exit_code = PROGRAM_DONE;
    progress_step(all->state->progress, "fresh points");
    do {
        all->verdict = race_judge(&of);
        all->is_confirmed = false;
        if (all->verdict.winner == all->count) {
            return PROGRAM_DONE;
        }
        exit_code = measure_fresh(all, all->verdict.winner);
        all->is_confirmed = exit_code == PROGRAM_DONE && keeps_bounds(all);
        if (exit_code == PROGRAM_DONE && !all->is_confirmed) {
            all->candidates[all->verdict.winner].left = LEFT_FRESH;
        }
    } while (exit_code == PROGRAM_DONE && !all->is_confirmed);
    return exit_code;
}

/* Fails where a bound is of light and there is none. */
static int check_light(const sweep *all)
{
    const char *path = all->state->options.lights_path;
    for (size_t i = 0; tune_bounds_at(&all->bounds, i) != NULL; ++i) {
        const tune_measure *measure = tune_bounds_at(&all->bounds, i);
        if ((measure->quantity == QUANTITY_LIGHT || measure->quantity == QUANTITY_DIRECT) &&
            !sampler_is_lit(all->made, measure->quantity)) {
            return program_fail(all->state, PROGRAM_FAILED, "--error %s: no light reaches %s from %s", measure->name,
                                all->made->source->name, path != NULL ? path : "the sun and the sky");
        }
    }
    return PROGRAM_DONE;
}

int sweep_run(sweep *all)
{
    static const char *const steps[SWEEP_RUNGS] = {"rung 1 of 4", "rung 2 of 4", "rung 3 of 4", "rung 4 of 4"};
    int exit_code = PROGRAM_DONE;
    if (all->space.values[DIMENSION_GATHER][0] != 0) {
        exit_code = sampler_light_truth(all->made, all->seed);
        exit_code = exit_code == PROGRAM_DONE ? check_light(all) : exit_code;
    }
    progress_forecast(all->state->progress);
    for (unsigned rung = 0; rung < SWEEP_RUNGS && exit_code == PROGRAM_DONE; ++rung) {
        const race of = sweep_race(all);
        bool measured = false; /* not where an earlier run has finished the rung: who left then has left */
        progress_step(all->state->progress, steps[rung]);
        exit_code = run_rounds(all, rung, &measured);
        if (exit_code == PROGRAM_DONE) {
            exit_code = add_errors(all, rung, &measured);
        }
        if (exit_code == PROGRAM_DONE && measured && !all->exhaustive) {
            race_leave(&of, rung + 1, true);
        }
        if (exit_code == PROGRAM_DONE && measured) {
            exit_code = all->save(all);
        }
    }
    return exit_code == PROGRAM_DONE ? answer(all) : exit_code;
}
