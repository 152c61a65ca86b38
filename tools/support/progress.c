/* SPDX-License-Identifier: MIT */
/* The progress bar: one line, redrawn ten times a second by its own thread. */
#include "support/progress.h"

#include <errno.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#define QUIET_SECONDS      0.5
#define REDRAW_NANOSECONDS 100000000L
#define BAR_CELLS          24U

struct progress {
    const char *title;
    const char *what;
    unsigned step_count;
    unsigned steps_begun;
    const char *stage; /* of the current step; NULL: it has not said */
    double part; /* of the current step that is done, 0 .. 1 */
    double started_s;
    bool shown;
    bool held;
    bool ending;
    bool is_drawn; /* on a terminal, by the thread */
    progress_watch watch; /* NULL functions: nobody */
    pthread_mutex_t lock;
    pthread_cond_t changed;
    pthread_t thread;
};

static double now_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

static void draw(progress *bar)
{
    const double elapsed_s = now_s() - bar->started_s;
    if (!bar->is_drawn || elapsed_s < QUIET_SECONDS || bar->steps_begun == 0) {
        return;
    }
    const double done = (bar->steps_begun - 1 + bar->part) / bar->step_count;
    const unsigned filled = done < 1.0 ? (unsigned)(BAR_CELLS * done) : BAR_CELLS;
    char cells[BAR_CELLS + 1];
    for (unsigned i = 0; i < BAR_CELLS; ++i) {
        cells[i] = i < filled ? '=' : '.';
    }
    cells[BAR_CELLS] = '\0';
    fprintf(stderr, "\r\033[K%s [%s] %u/%u %s", bar->title, cells, bar->steps_begun, bar->step_count, bar->what);
    if (bar->stage != NULL) {
        fprintf(stderr, ": %s, %.0f %%", bar->stage, bar->part * 100.0);
    }
    fprintf(stderr, ", %.1f s", elapsed_s);
    fflush(stderr);
    bar->shown = true;
}

static void erase(progress *bar)
{
    if (bar->shown) {
        fputs("\r\033[K", stderr);
        fflush(stderr);
        bar->shown = false;
    }
}

static void *keep_drawing(void *user)
{
    progress *bar = user;
    pthread_mutex_lock(&bar->lock);
    while (!bar->ending) {
        struct timespec until;
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_nsec += REDRAW_NANOSECONDS;
        if (until.tv_nsec >= 1000000000L) {
            until.tv_nsec -= 1000000000L;
            ++until.tv_sec;
        }
        if (pthread_cond_timedwait(&bar->changed, &bar->lock, &until) == ETIMEDOUT && !bar->ending) {
            draw(bar);
        }
    }
    pthread_mutex_unlock(&bar->lock);
    return NULL;
}

static void tell(const progress *bar)
{
    const progress_view now = {bar->what, bar->stage, bar->steps_begun, bar->step_count, bar->part};
    if (bar->watch.see != NULL) {
        bar->watch.see(bar->watch.user, &now);
    }
}

progress *progress_create(const char *title, unsigned step_count, bool on_terminal, const progress_watch *watch)
{
    const bool is_drawn = on_terminal && isatty(STDERR_FILENO) == 1;
    if ((!is_drawn && watch == NULL) || step_count == 0) {
        return NULL;
    }
    progress *bar = calloc(1, sizeof *bar);
    if (bar == NULL) {
        return NULL;
    }
    bar->title = title;
    bar->what = "";
    bar->step_count = step_count;
    bar->started_s = now_s();
    bar->watch = watch != NULL ? *watch : bar->watch;
    pthread_mutex_init(&bar->lock, NULL);
    pthread_cond_init(&bar->changed, NULL);
    bar->is_drawn = is_drawn && pthread_create(&bar->thread, NULL, keep_drawing, bar) == 0;
    if (!bar->is_drawn && watch == NULL) {
        pthread_cond_destroy(&bar->changed);
        pthread_mutex_destroy(&bar->lock);
        free(bar);
        return NULL;
    }
    return bar;
}

void progress_step(progress *bar, const char *what)
{
    if (bar == NULL) {
        return;
    }
    pthread_mutex_lock(&bar->lock);
    const bool is_seen = !bar->held;
    if (is_seen) {
        bar->what = what;
        bar->stage = NULL;
        bar->part = 0.0;
        ++bar->steps_begun;
        draw(bar);
    }
    pthread_mutex_unlock(&bar->lock);
    if (is_seen) {
        tell(bar);
    }
}

void progress_part(progress *bar, const char *stage, double fraction)
{
    if (bar == NULL) {
        return;
    }
    pthread_mutex_lock(&bar->lock);
    const bool is_seen = !bar->held;
    if (is_seen) { /* the thread draws it */
        bar->stage = stage;
        bar->part = fraction;
    }
    pthread_mutex_unlock(&bar->lock);
    if (is_seen) {
        tell(bar);
    }
}

bool progress_stops(const progress *bar)
{
    return bar != NULL && bar->watch.stops != NULL && bar->watch.stops(bar->watch.user);
}

void progress_hold(progress *bar, bool held)
{
    if (bar == NULL) {
        return;
    }
    pthread_mutex_lock(&bar->lock);
    bar->held = held;
    pthread_mutex_unlock(&bar->lock);
}

void progress_hide(progress *bar)
{
    if (bar == NULL) {
        return;
    }
    pthread_mutex_lock(&bar->lock);
    erase(bar);
    pthread_mutex_unlock(&bar->lock);
}

void progress_destroy(progress **bar)
{
    if (bar == NULL || *bar == NULL) {
        return;
    }
    pthread_mutex_lock(&(*bar)->lock);
    (*bar)->ending = true;
    erase(*bar);
    pthread_cond_signal(&(*bar)->changed);
    pthread_mutex_unlock(&(*bar)->lock);
    if ((*bar)->is_drawn) {
        pthread_join((*bar)->thread, NULL);
    }
    pthread_cond_destroy(&(*bar)->changed);
    pthread_mutex_destroy(&(*bar)->lock);
    free(*bar);
    *bar = NULL;
}
