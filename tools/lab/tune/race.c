/* SPDX-License-Identifier: MIT */
/* Leaving and judging. Settings of one kind of errors share the same draws, so that they are compared on equal
   points. */
#include "tune/race.h"

#include <math.h>
#include <stdlib.h>

#include "measure/spread.h"

#define JUDGE_DRAWS 400u
#define NEAR        1.05 /* times the best: as good as that */
#define HALF_SLACK  1.15 /* nobody leaves for being so much slower than the best, without an interval */

static const char *const left_names[LEFT_COUNT] = {"",      "no value", "memory",    "error",        "time",  "slower",
                                                   "worse", "halved",   "dominated", "fresh points", "failed"};

const char *race_left_name(race_left left)
{
    return left_names[left];
}

/* ---- one candidate ---- */

static const tune_errors *errors_of(const candidate *one, size_t measure)
{
    return one->errors[quantity_kind(tune_measure_at(measure)->quantity)];
}

interval race_error(const candidate *one, size_t measure)
{
    const tune_errors *errors = errors_of(one, measure);
    return errors != NULL ? interval_of_error(errors, tune_measure_at(measure)) : (interval){NAN, NAN, NAN};
}

static double estimate_error(const candidate *one, size_t measure)
{
    const tune_errors *errors = errors_of(one, measure);
    if (errors == NULL) {
        return NAN;
    }
    const sample_block sum = samples_sum(&errors->of[tune_measure_at(measure)->quantity]);
    return fabs(tune_measure_value(tune_measure_at(measure), errors, &sum));
}

/* Intervals of what decides. */
typedef struct standing {
    interval time, goal; /* goal: of the measure that is to be the least, or the time */
    bool within, beyond; /* all bounds, surely; one of them, surely */
    race_left why; /* which */
} standing;

static standing stand(const candidate *one, const tune_bounds *bounds)
{
    standing out = {.time = interval_of_time(one->rounds, one->round_count), .why = LEFT_NOT};
    const bool has_least = bounds->least < tune_measure_count();
    out.goal = has_least ? race_error(one, bounds->least) : out.time;
    out.within = one->round_count > 0 && out.time.high <= bounds->time_ms && one->bytes <= bounds->bytes;
    out.why = one->bytes > bounds->bytes ? LEFT_MEMORY : out.time.low > bounds->time_ms ? LEFT_TIME : LEFT_NOT;
    for (size_t i = 0; tune_bounds_at(bounds, i) != NULL; ++i) {
        out.why = one->lacks[tune_bounds_at(bounds, i)->quantity] ? LEFT_UNABLE : out.why;
    }
    for (size_t i = 0; i < bounds->count; ++i) {
        const interval error = race_error(one, bounds->list[i].measure);
        out.within = out.within && error.high <= bounds->list[i].most;
        out.why = out.why == LEFT_NOT && error.low > bounds->list[i].most ? LEFT_ERROR : out.why;
    }
    out.beyond = out.why != LEFT_NOT;
    return out;
}

bool race_has_goal(const tune_bounds *bounds)
{
    return bounds->count > 0 || bounds->least < tune_measure_count() || isfinite(bounds->time_ms) ||
           isfinite(bounds->bytes);
}

/* ---- fronts ---- */

/* Whether a is at most as large as b in everything, and smaller in something. surely: by the ends of the times'
   intervals. */
static bool dominates(const candidate *a, const candidate *b, bool surely)
{
    const interval of_a = interval_of_time(a->rounds, a->round_count);
    const interval of_b = interval_of_time(b->rounds, b->round_count);
    bool smaller = surely ? of_a.high < of_b.low : of_a.middle < of_b.middle;
    if (a->round_count == 0 || b->round_count == 0 || a->bytes > b->bytes ||
        (surely ? !smaller : of_a.middle > of_b.middle)) {
        return false;
    }
    smaller = smaller || a->bytes < b->bytes;
    for (size_t i = 0; i < tune_measure_count(); ++i) {
        const double first = estimate_error(a, i);
        const double second = estimate_error(b, i);
        if ((tune_measure_at(i)->statistic != STATISTIC_MOST && first > second) || (isnan(first) && !isnan(second))) {
            return false;
        }
        smaller = smaller || first < second;
    }
    return smaller;
}

bool race_is_on_front(const race *all, size_t index)
{
    bool found = all->list[index].round_count > 0;
    for (size_t i = 0; i < all->count && found; ++i) {
        found = i == index || !dominates(&all->list[i], &all->list[index], false);
    }
    return found;
}

/* ---- leaving ---- */

static void leave(candidate *one, race_left why, unsigned rung)
{
    one->left = why;
    one->left_after = rung;
}

static void leave_dominated(const race *all, unsigned rung)
{
    for (size_t i = 0; i < all->count; ++i) {
        for (size_t k = 0; k < all->count && all->list[i].left == LEFT_NOT; ++k) {
            if (k != i && dominates(&all->list[k], &all->list[i], true)) {
                leave(&all->list[i], LEFT_DOMINATED, rung);
            }
        }
    }
}

/* The slower ones of those that remain, until a half does; not who is close to the best within bounds. */
static void leave_half(const race *all, const standing *standings, double best, unsigned rung)
{
    double *times = calloc(all->count + 1, sizeof *times);
    size_t live = 0;
    for (size_t i = 0; i < all->count && times != NULL; ++i) {
        if (all->list[i].left == LEFT_NOT) {
            times[live++] = standings[i].goal.middle;
        }
    }
    const double half = live > 2 ? spread_of(times, live).median : INFINITY;
    for (size_t i = 0; i < all->count && times != NULL; ++i) {
        const double goal = standings[i].goal.middle;
        if (all->list[i].left == LEFT_NOT && goal > half && goal > HALF_SLACK * best) {
            leave(&all->list[i], LEFT_HALVED, rung);
        }
    }
    free(times);
}

/* Whether another one that is as good in what is to be the least is surely faster. */
static bool has_faster_twin(const race *all, const standing *standings, size_t index)
{
    bool found = false;
    for (size_t i = 0; i < all->count && !found; ++i) {
        found = i != index && standings[i].within && standings[i].goal.middle <= standings[index].goal.middle &&
                standings[i].time.high < standings[index].time.low;
    }
    return found;
}

static void leave_by_goal(const race *all, const standing *standings, bool halves, unsigned rung)
{
    const bool has_least = all->bounds->least < tune_measure_count();
    double sure = INFINITY;
    double best = INFINITY;
    for (size_t i = 0; i < all->count; ++i) {
        sure = standings[i].within ? fmin(sure, standings[i].goal.high) : sure;
        best = standings[i].within ? fmin(best, standings[i].goal.middle) : best;
    }
    for (size_t i = 0; i < all->count; ++i) {
        candidate *one = &all->list[i];
        if (one->left != LEFT_NOT) {
            continue;
        }
        if (standings[i].beyond) {
            leave(one, standings[i].why, rung);
        } else if (standings[i].goal.low > sure) {
            leave(one, has_least ? LEFT_WORSE : LEFT_SLOWER, rung);
        } else if (has_least && has_faster_twin(all, standings, i)) {
            leave(one, LEFT_SLOWER, rung);
        }
    }
    if (halves) {
        leave_half(all, standings, best, rung);
    }
}

void race_leave(const race *all, unsigned rung, bool halves)
{
    standing *standings = calloc(all->count + 1, sizeof *standings);
    if (standings == NULL) {
        return; /* all stay, which takes longer and changes no answer */
    }
    for (size_t i = 0; i < all->count; ++i) {
        standings[i] = stand(&all->list[i], all->bounds);
        standings[i].within = standings[i].within && all->list[i].left == LEFT_NOT;
    }
    if (race_has_goal(all->bounds)) {
        leave_by_goal(all, standings, halves, rung);
    } else if (halves) {
        leave_dominated(all, rung);
    }
    free(standings);
}

/* ---- judging ---- */

static bool may_win(const candidate *one)
{
    return one->round_count > 0 &&
           (one->left == LEFT_NOT || one->left == LEFT_SLOWER || one->left == LEFT_WORSE || one->left == LEFT_HALVED);
}

/* What decides, smaller is better: the goal, then the time. */
typedef struct score {
    bool within;
    double goal, time;
} score;

static bool is_better(score a, score b)
{
    return a.within && (!b.within || a.goal < b.goal || (a.goal == b.goal && a.time < b.time));
}

/* In one draw. */
static score draw_score(const candidate *one, size_t index, const tune_bounds *bounds, uint64_t number)
{
    const double time = bootstrap_time(one->rounds, one->round_count, (draw){number, 16 + index});
    score out = {.within = one->bytes <= bounds->bytes && time <= bounds->time_ms, .goal = time, .time = time};
    for (size_t i = 0; i < bounds->count; ++i) {
        const tune_errors *errors = errors_of(one, bounds->list[i].measure);
        const double error = errors != NULL ? resample_error(errors, tune_measure_at(bounds->list[i].measure),
                                                             (draw){number, (uint64_t)errors->kind})
                                            : (double)NAN;
        out.within = out.within && error <= bounds->list[i].most;
    }
    if (bounds->least < tune_measure_count()) {
        const tune_errors *errors = errors_of(one, bounds->least);
        out.goal = errors != NULL
                       ? resample_error(errors, tune_measure_at(bounds->least), (draw){number, (uint64_t)errors->kind})
                       : (double)NAN;
        out.within = out.within && isfinite(out.goal);
    }
    return out;
}

static void judge_draws(const race *all, race_verdict *verdict)
{
    for (uint64_t number = 0; number < JUDGE_DRAWS; ++number) {
        score best = {.within = false};
        score own = {.within = false};
        bool is_own = false;
        for (size_t i = 0; i < all->count; ++i) {
            if (!may_win(&all->list[i])) {
                continue;
            }
            const score one = draw_score(&all->list[i], i, all->bounds, number);
            if (is_better(one, best)) {
                best = one;
                is_own = i == verdict->winner;
            }
            own = i == verdict->winner ? one : own;
        }
        verdict->sure += is_own ? 1.0 / JUDGE_DRAWS : 0;
        verdict->near += own.within && own.goal <= NEAR * best.goal ? 1.0 / JUDGE_DRAWS : 0;
    }
}

race_verdict race_judge(const race *all)
{
    race_verdict verdict = {.winner = all->count, .second = all->count};
    score best = {.within = false};
    score next = {.within = false};
    for (size_t i = 0; i < all->count && race_has_goal(all->bounds); ++i) {
        const standing at = stand(&all->list[i], all->bounds);
        const score one = {at.within && may_win(&all->list[i]) && isfinite(at.goal.middle), at.goal.middle,
                           at.time.middle};
        if (is_better(one, best)) {
            next = best;
            verdict.second = verdict.winner;
            best = one;
            verdict.winner = i;
        } else if (is_better(one, next)) {
            next = one;
            verdict.second = i;
        }
    }
    if (verdict.winner < all->count) {
        judge_draws(all, &verdict);
    }
    return verdict;
}
