/* SPDX-License-Identifier: MIT */
/* The lease of a run on its folder of parts, renewed by a thread, since a part may take longer than a lease lasts. */
#define _POSIX_C_SOURCE 200809L
#include "support/parts_hold.h"

#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <time.h>

#include "support/parts_job.h"

#define RENEWALS 4 /* in the time after which a lease is stale */

struct parts_holder {
    svo_parts_lease *lease;
    pthread_t thread;
    pthread_mutex_t mutex;
    pthread_cond_t wake;
    bool is_done, has_thread;
};

/* A renewal that fails is not told: whatever it led to is, by its name, where files are of another plan. */
static void *renew(void *user)
{
    parts_holder *holder = user;
    (void)pthread_mutex_lock(&holder->mutex);
    while (!holder->is_done) {
        struct timespec until;
        (void)clock_gettime(CLOCK_REALTIME, &until);
        until.tv_sec += SVO_PARTS_LEASE_SECONDS / RENEWALS;
        (void)pthread_cond_timedwait(&holder->wake, &holder->mutex, &until);
        if (!holder->is_done) {
            (void)svo_parts_lease_renew(holder->lease, NULL);
        }
    }
    (void)pthread_mutex_unlock(&holder->mutex);
    return NULL;
}

/* Signals stay with the thread that handles them. */
static bool start(parts_holder *holder)
{
    sigset_t all;
    sigset_t before;
    (void)sigfillset(&all);
    (void)pthread_sigmask(SIG_SETMASK, &all, &before);
    holder->has_thread = pthread_create(&holder->thread, NULL, renew, holder) == 0;
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
    return holder->has_thread;
}

int parts_hold(program *state, const char *folder, parts_holder **out)
{
    svo_message message;
    parts_holder *holder = calloc(1, sizeof *holder);
    if (holder == NULL) {
        return program_fail(state, PROGRAM_TRY_AGAIN, "out of memory");
    }
    (void)pthread_mutex_init(&holder->mutex, NULL);
    (void)pthread_cond_init(&holder->wake, NULL);
    const svo_status status = svo_parts_lease_take(folder, &holder->lease, &message);
    int exit_code = status == SVO_OK ? PROGRAM_DONE : parts_fail(state, status, message.text);
    if (exit_code == PROGRAM_DONE && !start(holder)) {
        exit_code = program_fail(state, PROGRAM_TRY_AGAIN,
                                 "no thread can be started: out of memory, or too many threads (ulimit -v, ulimit -u)");
    }
    if (exit_code != PROGRAM_DONE) {
        parts_release(&holder);
    }
    *out = holder;
    return exit_code;
}

void parts_release(parts_holder **holder)
{
    parts_holder *held = *holder;
    if (held == NULL) {
        return;
    }
    (void)pthread_mutex_lock(&held->mutex);
    held->is_done = true;
    (void)pthread_cond_signal(&held->wake);
    (void)pthread_mutex_unlock(&held->mutex);
    if (held->has_thread) {
        (void)pthread_join(held->thread, NULL);
    }
    svo_parts_lease_release(&held->lease);
    (void)pthread_cond_destroy(&held->wake);
    (void)pthread_mutex_destroy(&held->mutex);
    free(held);
    *holder = NULL;
}
