/* SPDX-License-Identifier: MIT */
/* The progress bar: one line, redrawn ten times a second by its own thread. */
#include "support/progress.h"

#include <errno.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#define QUIET_SECONDS      0.5
#define REDRAW_NANOSECONDS 100000000L
#define BAR_CELLS          24U
#define BAR_CELLS_MIN      8U
#define COLUMNS_UNKNOWN    80
#define LINE_BYTES         256

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
    bool forecasts; /* how much time is left */
    double forecast_s, forecast_done; /* when that began, and what was done then */
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

/* Columns that a line may fill: the last one stays free, since terminals go to the next line behind it. Asked anew each
   time, since windows change. */
static size_t columns(void)
{
    struct winsize size;
    const unsigned count =
        ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : COLUMNS_UNKNOWN;
    return count < LINE_BYTES ? count - 1 : LINE_BYTES - 1;
}

/* Puts a text into room columns; one that is longer ends in dots. */
static void put_text(char line[LINE_BYTES], const char *text, size_t room)
{
    const size_t length = strlen(text);
    const size_t dots = length <= room ? 0 : room < 3 ? room : 3;
    (void)snprintf(line + strlen(line), LINE_BYTES - strlen(line), "%.*s%.*s",
                   (int)(length <= room ? length : room - dots), text, (int)dots, "...");
}

/* The bar is as long as there is room, then what runs is shortened; the step and the clock stay. */
static void write_line(const progress *bar, double elapsed_s, char line[LINE_BYTES])
{
    char step[32], what[LINE_BYTES], clock[96];
    const size_t room = columns();
    const double done = (bar->steps_begun - 1 + bar->part) / bar->step_count;
    (void)snprintf(step, sizeof step, "%u/%u ", bar->steps_begun, bar->step_count);
    (void)snprintf(what, sizeof what, "%s%s%s", bar->what, bar->stage != NULL ? ": " : "",
                   bar->stage != NULL ? bar->stage : "");
    if (bar->stage != NULL) {
        (void)snprintf(clock, sizeof clock, ", %.0f %%, %.1f s", bar->part * 100.0, elapsed_s);
    } else {
        (void)snprintf(clock, sizeof clock, ", %.1f s", elapsed_s);
    }
    if (bar->forecasts && done > bar->forecast_done + 0.02 && done < 1.0) {
        const double rate = (elapsed_s - bar->forecast_s) / (done - bar->forecast_done);
        (void)snprintf(clock + strlen(clock), sizeof clock - strlen(clock), ", %.0f s left", rate * (1.0 - done));
    }
    size_t used = strlen(bar->title) + 1 + strlen(step) + strlen(clock);
    const size_t wanted = used + strlen(what) + 3; /* with brackets and a space */
    const size_t cells = wanted + BAR_CELLS_MIN > room ? 0 : wanted + BAR_CELLS > room ? room - wanted : BAR_CELLS;
    const size_t filled = done < 1.0 ? (size_t)((double)cells * done) : cells;
    (void)snprintf(line, LINE_BYTES, "%s ", bar->title);
    if (cells > 0) {
        char text[BAR_CELLS + 1] = "";
        memset(text, '=', filled);
        memset(text + filled, '.', cells - filled);
        (void)snprintf(line + strlen(line), LINE_BYTES - strlen(line), "[%.*s] ", (int)cells, text);
        used += cells + 3;
    }
    put_text(line, step, strlen(step));
    put_text(line, what, used < room ? room - used : 0);
    put_text(line, clock, strlen(clock));
    line[room] = '\0';
}

static void draw(progress *bar)
{
    char line[LINE_BYTES];
    const double elapsed_s = now_s() - bar->started_s;
    if (!bar->is_drawn || elapsed_s < QUIET_SECONDS || bar->steps_begun == 0) {
        return;
    }
    write_line(bar, elapsed_s, line);
    fprintf(stderr, "\r\033[K%s", line);
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

void progress_forecast(progress *bar)
{
    if (bar == NULL) {
        return;
    }
    pthread_mutex_lock(&bar->lock);
    bar->forecasts = true;
    bar->forecast_s = now_s() - bar->started_s;
    bar->forecast_done = (double)bar->steps_begun / bar->step_count;
    pthread_mutex_unlock(&bar->lock);
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
