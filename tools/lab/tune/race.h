/* SPDX-License-Identifier: MIT */
/*
 * Which settings can still win, and which one does: successive halving (Jamieson and Talwalkar, "Non-stochastic Best
 * Arm Identification and Hyperparameter Optimization", AISTATS 2016) by the intervals of resample.h. Each rung adds
 * rounds and sample points; then those leave that cannot win, and the slowest of the rest down to a half.
 */
#ifndef SVOCL_TOOLS_TUNE_RACE_H
#define SVOCL_TOOLS_TUNE_RACE_H

#include "tune/resample.h"

typedef enum race_left {
    LEFT_NOT = 0, /* still there */
    LEFT_UNABLE, /* it has no value of what is bounded, or to be the least */
    LEFT_MEMORY, /* above --memory */
    LEFT_ERROR, /* above a bound of --error */
    LEFT_TIME, /* above --time */
    LEFT_SLOWER, /* another one within all bounds is faster */
    LEFT_WORSE, /* another one within --time errs less */
    LEFT_HALVED, /* the slower half of those that remained */
    LEFT_DOMINATED, /* without bounds: another one is better in time, memory and every error */
    LEFT_FRESH, /* beyond a bound on fresh points */
    LEFT_FAILED, /* it cannot be built here */
    LEFT_COUNT
} race_left;
const char *race_left_name(race_left left); /* in files and tables */

typedef struct candidate {
    double rounds[BOOTSTRAP_ROUNDS_MAX]; /* ms */
    size_t round_count;
    double bytes;
    const tune_errors *errors[KIND_COUNT]; /* borrowed; NULL: not measured */
    bool lacks[QUANTITY_COUNT]; /* it can have no value */
    race_left left;
    unsigned left_after; /* rungs */
} candidate;

typedef struct race {
    candidate *list;
    size_t count;
    const tune_bounds *bounds;
} race;

/* The interval of a measure of a candidate; NAN where it has none. */
interval race_error(const candidate *one, size_t measure);

/* After a rung: marks those that leave. halves: also the slowest of those that remain. */
void race_leave(const race *all, unsigned rung, bool halves);

typedef struct race_verdict {
    size_t winner, second; /* indices; count: none */
    double sure; /* the share of draws in which the winner wins */
    double near; /* the share in which it is within 5 % of who wins, in what is to be the least */
} race_verdict;

/* Of those that have not left for a bound; within bounds is who is so with both ends of the interval. Without bounds
   there is no winner. */
race_verdict race_judge(const race *all);

/* Whether something says what wins. */
bool race_has_goal(const tune_bounds *bounds);
/* Without bounds: whether no other one is at most as large in time, memory and all errors, and smaller in one. */
bool race_is_on_front(const race *all, size_t index);

#endif
