/* SPDX-License-Identifier: MIT */
/* An atomic counter hands out the chunks; the calling thread works too. */
#include "path/threads.h"

#include <pthread.h>
#include <stdatomic.h>

typedef struct job_queue {
    threads_work *work;
    void *user;
    size_t count, chunk_size;
    atomic_size_t next;
} job_queue;

typedef struct worker {
    job_queue *queue;
    unsigned thread_index;
    pthread_t thread;
} worker;

static void *work_until_done(void *own)
{
    const worker *self = own;
    job_queue *queue = self->queue;
    for (;;) {
        const size_t begin = atomic_fetch_add(&queue->next, queue->chunk_size);
        if (begin >= queue->count) {
            return NULL;
        }
        const size_t left = queue->count - begin;
        queue->work(queue->user, self->thread_index, begin,
                    begin + (left < queue->chunk_size ? left : queue->chunk_size));
    }
}

unsigned threads_run(unsigned thread_count, size_t count, size_t chunk_size, threads_work *work, void *user)
{
    job_queue queue = {.work = work, .user = user, .count = count, .chunk_size = chunk_size > 0 ? chunk_size : 1};
    worker workers[THREADS_MAX];
    unsigned started = 0;
    atomic_init(&queue.next, 0);
    thread_count = thread_count < THREADS_MAX ? thread_count : THREADS_MAX;
    while (started + 1 < thread_count) {
        workers[started] = (worker){.queue = &queue, .thread_index = started + 1};
        if (pthread_create(&workers[started].thread, NULL, work_until_done, &workers[started]) != 0) {
            break;
        }
        ++started;
    }
    worker own = {.queue = &queue};
    work_until_done(&own);
    for (unsigned i = 0; i < started; ++i) {
        pthread_join(workers[i].thread, NULL);
    }
    return started + 1;
}
