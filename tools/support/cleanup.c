/* SPDX-License-Identifier: MIT */
/* The list of temporary files and the handlers of signals that end the process. */
#include "support/cleanup.h"

#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const int ending_signals[] = {SIGHUP, SIGINT, SIGPIPE, SIGQUIT, SIGTERM, SIGXCPU};

#define SIGNAL_COUNT (sizeof ending_signals / sizeof ending_signals[0])

/* A handler has no argument for state of its own. */
static _Atomic(pthread_t) writer;
static volatile sig_atomic_t is_ended_by_hand;
static volatile sig_atomic_t code_by_hand;
static cleanup_entry *first;
static sigset_t before_hold;

/* Calls only what may be called in a handler. The list does not change meanwhile: its thread is here, and holds signals
   back where it changes the list. */
static void end(int number)
{
    if (pthread_equal(pthread_self(), writer) == 0) {
        (void)pthread_kill(writer, number);
        return;
    }
    for (const cleanup_entry *entry = first; entry != NULL; entry = entry->next) {
        if (entry->path != NULL) {
            (void)unlink(entry->path);
        }
    }
    if (is_ended_by_hand != 0) {
        _exit(code_by_hand);
    }
    /* Ends the process as the signal would have done, for a caller that asks how it ended. */
    (void)signal(number, SIG_DFL);
    (void)raise(number);
}

void cleanup_begin(void)
{
    writer = pthread_self();
    for (size_t i = 0; i < SIGNAL_COUNT; ++i) {
        struct sigaction old;
        struct sigaction wanted = {.sa_handler = end, .sa_flags = SA_RESTART};
        sigfillset(&wanted.sa_mask);
        if (sigaction(ending_signals[i], NULL, &old) == 0 && old.sa_handler != SIG_IGN) {
            (void)sigaction(ending_signals[i], &wanted, NULL);
        }
    }
}

void cleanup_take(void)
{
    writer = pthread_self();
}

/* The thread of the files may be in the middle of its list: the handler runs there, where it holds no signal back. */
void cleanup_end(int exit_code)
{
    const int number = ending_signals[0];
    struct sigaction wanted = {.sa_handler = end};
    sigfillset(&wanted.sa_mask);
    code_by_hand = exit_code;
    is_ended_by_hand = 1;
    (void)sigaction(number, &wanted, NULL);
    (void)pthread_kill(writer, number);
    for (;;) {
        (void)pause();
    }
}

void cleanup_hold(void)
{
    sigset_t held;
    sigemptyset(&held);
    for (size_t i = 0; i < SIGNAL_COUNT; ++i) {
        sigaddset(&held, ending_signals[i]);
    }
    (void)pthread_sigmask(SIG_BLOCK, &held, &before_hold);
}

void cleanup_release(void)
{
    (void)pthread_sigmask(SIG_SETMASK, &before_hold, NULL);
}

static void watch_hold(void *user)
{
    (void)user;
    cleanup_hold();
}

static void watch_release(void *user, const char *temporary)
{
    cleanup_entry *entry = user;
    free(entry->path);
    entry->path = temporary != NULL ? strdup(temporary) : NULL;
    cleanup_release();
}

void cleanup_add(cleanup_entry *entry)
{
    *entry = (cleanup_entry){.watch = {.hold = watch_hold, .release = watch_release, .user = entry}};
    cleanup_hold();
    entry->next = first;
    first = entry;
    cleanup_release();
}

void cleanup_remove(cleanup_entry *entry)
{
    cleanup_hold();
    for (cleanup_entry **at = &first; *at != NULL; at = &(*at)->next) {
        if (*at == entry) {
            *at = entry->next;
            break;
        }
    }
    free(entry->path);
    entry->path = NULL;
    cleanup_release();
}
