/* SPDX-License-Identifier: MIT */
/* Host threads that share a range of items. */
#ifndef SVOCL_TOOLS_PATH_THREADS_H
#define SVOCL_TOOLS_PATH_THREADS_H

#include <stddef.h>

#define THREADS_MAX 256u

/* Processes items begin .. end - 1. thread_index: of the calling thread, below thread_count. */
typedef void threads_work(void *user, unsigned thread_index, size_t begin, size_t end);

/* Processes items 0 .. count - 1 in chunks of chunk_size and waits for the end; an idle thread takes the next chunk.
   Returns how many threads took part: at most thread_count, fewer where threads cannot be created. */
unsigned threads_run(unsigned thread_count, size_t count, size_t chunk_size, threads_work *work, void *user);

#endif
