/* SPDX-License-Identifier: MIT */
/* Host threads that share a range of work: for ways that run on the host, beside those of a device. */
#ifndef SVOCL_TOOLS_MEASURE_THREADS_H
#define SVOCL_TOOLS_MEASURE_THREADS_H

#include <stddef.h>

#define THREADS_MAX 64u /* threads */

/* Items begin .. end - 1. member: which of the threads asks, below thread_count. */
typedef void threads_work(void *user, unsigned member, size_t begin, size_t end);

/* Has the work done for items 0 .. count - 1, portion by portion as threads come free, and waits for it. Returns how
   many threads took part: at most thread_count, fewer where threads cannot be had. */
unsigned threads_run(unsigned thread_count, size_t count, size_t portion, threads_work *work, void *user);

#endif
