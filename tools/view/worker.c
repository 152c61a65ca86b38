/* SPDX-License-Identifier: MIT */
/* One lock and one condition for both directions: every change wakes whoever waits. */
#include "view/worker.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <time.h>

struct worker {
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t changed;
    bool ends; /* the thread is to end */
    int (*job)(void *user); /* NULL: none is under way */
    void *job_user;
    int exit_code; /* of the last one */
    void (*call)(void *user); /* NULL: the job asks for none */
    void *call_user;
    bool is_canceled;
    progress_view progress;
};

static void *work(void *user)
{
    worker *self = user;
    pthread_mutex_lock(&self->lock);
    while (!self->ends) {
        if (self->job == NULL) {
            pthread_cond_wait(&self->changed, &self->lock);
            continue;
        }
        pthread_mutex_unlock(&self->lock);
        const int exit_code = self->job(self->job_user);
        pthread_mutex_lock(&self->lock);
        self->exit_code = exit_code;
        self->job = NULL;
        pthread_cond_broadcast(&self->changed);
    }
    pthread_mutex_unlock(&self->lock);
    return NULL;
}

/* Waits take their time from a clock that nobody sets. */
static bool begin_condition(pthread_cond_t *made)
{
    pthread_condattr_t attributes;
    if (pthread_condattr_init(&attributes) != 0) {
        return false;
    }
    const bool works =
        pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC) == 0 && pthread_cond_init(made, &attributes) == 0;
    pthread_condattr_destroy(&attributes);
    return works;
}

worker *worker_create(void)
{
    worker *made = calloc(1, sizeof *made);
    if (made == NULL || !begin_condition(&made->changed)) {
        free(made);
        return NULL;
    }
    pthread_mutex_init(&made->lock, NULL);
    made->progress.what = "";
    if (pthread_create(&made->thread, NULL, work, made) != 0) {
        pthread_cond_destroy(&made->changed);
        pthread_mutex_destroy(&made->lock);
        free(made);
        return NULL;
    }
    return made;
}

void worker_destroy(worker **which)
{
    worker *gone = *which;
    if (gone == NULL) {
        return;
    }
    pthread_mutex_lock(&gone->lock);
    gone->ends = true;
    pthread_cond_broadcast(&gone->changed);
    pthread_mutex_unlock(&gone->lock);
    pthread_join(gone->thread, NULL);
    pthread_cond_destroy(&gone->changed);
    pthread_mutex_destroy(&gone->lock);
    free(gone);
    *which = NULL;
}

/* ---- on the thread that waits ---- */

void worker_begin(worker *which, int (*job)(void *user), void *user)
{
    pthread_mutex_lock(&which->lock);
    which->job = job;
    which->job_user = user;
    which->is_canceled = false;
    which->progress = (progress_view){.what = ""};
    pthread_cond_broadcast(&which->changed);
    pthread_mutex_unlock(&which->lock);
}

static struct timespec time_in(int milliseconds)
{
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_sec += milliseconds / 1000;
    until.tv_nsec += milliseconds % 1000 * 1000000L;
    if (until.tv_nsec >= 1000000000L) {
        until.tv_nsec -= 1000000000L;
        ++until.tv_sec;
    }
    return until;
}

worker_state worker_wait(worker *which, int milliseconds)
{
    const struct timespec until = time_in(milliseconds > 0 ? milliseconds : 0);
    int error = 0;
    pthread_mutex_lock(&which->lock);
    while (which->job != NULL && which->call == NULL && error != ETIMEDOUT) {
        error = milliseconds == WORKER_FOREVER ? pthread_cond_wait(&which->changed, &which->lock)
                                               : pthread_cond_timedwait(&which->changed, &which->lock, &until);
    }
    const worker_state state = which->job == NULL ? WORKER_DONE : which->call != NULL ? WORKER_ASKS : WORKER_BUSY;
    pthread_mutex_unlock(&which->lock);
    return state;
}

/* The job waits meanwhile, so the call may use what is the job's. */
void worker_answer(worker *which)
{
    pthread_mutex_lock(&which->lock);
    void (*const call)(void *user) = which->call;
    void *const user = which->call_user;
    pthread_mutex_unlock(&which->lock);
    if (call != NULL) {
        call(user);
    }
    pthread_mutex_lock(&which->lock);
    which->call = NULL;
    pthread_cond_broadcast(&which->changed);
    pthread_mutex_unlock(&which->lock);
}

int worker_exit_code(const worker *which)
{
    return which->exit_code;
}

void worker_cancel(worker *which)
{
    pthread_mutex_lock(&which->lock);
    which->is_canceled = true;
    pthread_mutex_unlock(&which->lock);
}

progress_view worker_progress(worker *which)
{
    pthread_mutex_lock(&which->lock);
    const progress_view now = which->progress;
    pthread_mutex_unlock(&which->lock);
    return now;
}

/* ---- in the job ---- */

void worker_ask(worker *which, void (*call)(void *user), void *user)
{
    pthread_mutex_lock(&which->lock);
    which->call = call;
    which->call_user = user;
    pthread_cond_broadcast(&which->changed);
    while (which->call != NULL) {
        pthread_cond_wait(&which->changed, &which->lock);
    }
    pthread_mutex_unlock(&which->lock);
}

void worker_see(void *user, const progress_view *now)
{
    worker *self = user;
    pthread_mutex_lock(&self->lock);
    self->progress = *now;
    pthread_mutex_unlock(&self->lock);
}

bool worker_stops(void *user)
{
    worker *self = user;
    pthread_mutex_lock(&self->lock);
    const bool stops = self->is_canceled;
    pthread_mutex_unlock(&self->lock);
    return stops;
}
