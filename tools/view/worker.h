/* SPDX-License-Identifier: MIT */
/*
 * A thread that works while the window answers: one job at a time, always on the same thread, since contexts of OpenGL
 * that a job makes stay with it. What a job uses is the job's until it has ended; what both sides look at meanwhile is
 * here, behind a lock.
 */
#ifndef SVOCL_TOOLS_VIEW_WORKER_H
#define SVOCL_TOOLS_VIEW_WORKER_H

#include <stdbool.h>

#include "support/progress.h"

typedef struct worker worker;

typedef enum worker_state {
    WORKER_BUSY = 0,
    WORKER_ASKS, /* worker_answer is due */
    WORKER_DONE /* or it never began */
} worker_state;

#define WORKER_FOREVER (-1)

/* NULL without memory or threads. */
worker *worker_create(void);
/* Waits for its job. */
void worker_destroy(worker **which);

/* ---- on the thread that waits ---- */

/* Begins a job, which returns an exit code. No other one may be under way. */
void worker_begin(worker *which, int (*job)(void *user), void *user);
/* Waits until the job has ended or asks, so many milliseconds at most. */
worker_state worker_wait(worker *which, int milliseconds);
/* Makes the call that the job waits for. */
void worker_answer(worker *which);
/* Of the job that has ended. */
int worker_exit_code(const worker *which);
/* Tells the job to end. */
void worker_cancel(worker *which);
/* What the job said last. */
progress_view worker_progress(worker *which);

/* ---- in the job ---- */

/* Has a function called on the thread that waits, and waits for its end. */
void worker_ask(worker *which, void (*call)(void *user), void *user);
/* Functions of a progress_watch; user is the worker. */
void worker_see(void *user, const progress_view *now);
bool worker_stops(void *user);

#endif
