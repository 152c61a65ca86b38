/* SPDX-License-Identifier: MIT */
/* The whole sweep of `svocl tune`: settings, what was measured of them, and how far it has come. */
#ifndef SVOCL_TOOLS_TUNE_SWEEP_H
#define SVOCL_TOOLS_TUNE_SWEEP_H

#include "tune/race.h"
#include "tune/trial.h"

#define SWEEP_RUNGS 4u

typedef struct sweep_setting {
    tune_setting setting;
    size_t records[KIND_COUNT]; /* indices of errors; record_count: none */
    double first_ms; /* of the first run, kernels compiled, its own queries counted; 0: it has not run */
    double result_bytes, query_us; /* of the last run */
    svo_message reason; /* of LEFT_FAILED */
} sweep_setting;

typedef struct sweep sweep;
struct sweep {
    program *state;
    sampler *made;
    trials *runs;
    tune_bounds bounds;
    tune_space space;
    uint32_t seed;
    uint32_t usual_need; /* svo_need bits of a tree without --need */
    bool exhaustive;
    sweep_setting *settings; /* count */
    candidate *candidates; /* count */
    size_t count;
    tune_errors *records; /* record_count */
    size_t record_count;
    tune_errors *fresh; /* KIND_COUNT: of the answer, on points of another seed */
    bool is_confirmed; /* fresh has them */
    race_verdict verdict;
    int (*save)(const sweep *all); /* keeps the state; returns the exit code */
};

/* Makes candidates and records of the settings. Returns false when memory runs out. */
bool sweep_begin(sweep *all);
void sweep_end(sweep *all);

/* Runs what is not measured yet, and saves the state to --resume as it goes; then confirms the answer on fresh points:
   one that breaks its bounds there leaves, and the next one is asked. Returns the exit code. */
int sweep_run(sweep *all);

/* Of the race. */
race sweep_race(const sweep *all);

#endif
