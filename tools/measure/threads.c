/* SPDX-License-Identifier: MIT */
/* Portions are handed out by one counter; the calling thread is a member too. */
#include "measure/threads.h"

#include <pthread.h>
#include <stdatomic.h>

typedef struct crew {
    threads_work *work;
    void *user;
    size_t count, portion;
    atomic_size_t next;
} crew;

typedef struct seat {
    crew *all;
    unsigned member;
    pthread_t thread;
} seat;

static void *work_until_done(void *own)
{
    const seat *place = own;
    crew *all = place->all;
    for (;;) {
        const size_t begin = atomic_fetch_add(&all->next, all->portion);
        if (begin >= all->count) {
            return NULL;
        }
        const size_t left = all->count - begin;
        all->work(all->user, place->member, begin, begin + (left < all->portion ? left : all->portion));
    }
}

unsigned threads_run(unsigned thread_count, size_t count, size_t portion, threads_work *work, void *user)
{
    crew all = {.work = work, .user = user, .count = count, .portion = portion > 0 ? portion : 1};
    seat seats[THREADS_MAX];
    unsigned started = 0;
    atomic_init(&all.next, 0);
    thread_count = thread_count < THREADS_MAX ? thread_count : THREADS_MAX;
    while (started + 1 < thread_count) {
        seats[started] = (seat){.all = &all, .member = started + 1};
        if (pthread_create(&seats[started].thread, NULL, work_until_done, &seats[started]) != 0) {
            break;
        }
        ++started;
    }
    seat own = {.all = &all};
    work_until_done(&own);
    for (unsigned i = 0; i < started; ++i) {
        pthread_join(seats[i].thread, NULL);
    }
    return started + 1;
}
