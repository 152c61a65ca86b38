/* SPDX-License-Identifier: MIT */
/* Memory that is accounted for, and calls of malloc that are counted. */
#define _POSIX_C_SOURCE 200809L
#include "memory_ledger.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define ALIGNMENT     16
#define GUARD         0xc5
#define GUARD_BYTES   16
#define FRESH         0xa5
#define RELEASED      0x5a
#define PADDING_BYTES 64
#define SETTLE_MS     10000

/* Stands before a block. */
typedef struct entry {
    void *base;
    size_t bytes;
} entry;

_Static_assert(sizeof(entry) <= ALIGNMENT, "an entry fits before an aligned block");

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static ledger_counts counts;
static uint64_t fails_at = LEDGER_NEVER;
static bool watching;

#ifdef SVOCL_WATCH_MALLOC
/* The linker's names for the real calls and for their wrappers. */
/* NOLINTBEGIN(readability-identifier-naming) */
#define WATCH(type, name, parameters, arguments) \
    type __real_##name parameters;               \
    type __wrap_##name parameters;               \
    type __wrap_##name parameters                \
    {                                            \
        note_other();                            \
        return __real_##name arguments;          \
    }

static void note_other(void)
{
    pthread_mutex_lock(&lock);
    counts.others += watching ? 1 : 0;
    pthread_mutex_unlock(&lock);
}

WATCH(void *, malloc, (size_t bytes), (bytes))
WATCH(void *, calloc, (size_t count, size_t bytes), (count, bytes))
WATCH(void *, realloc, (void *old, size_t bytes), (old, bytes))
WATCH(void *, aligned_alloc, (size_t alignment, size_t bytes), (alignment, bytes))
WATCH(int, posix_memalign, (void **out, size_t alignment, size_t bytes), (out, alignment, bytes))
WATCH(char *, strdup, (const char *text), (text))
WATCH(char *, strndup, (const char *text, size_t bytes), (text, bytes))

void __real_free(void *block);
void __wrap_free(void *block);
void __wrap_free(void *block)
{
    note_other();
    __real_free(block);
}

#define REAL_MALLOC __real_malloc
#define REAL_FREE   __real_free
/* NOLINTEND(readability-identifier-naming) */
#else
#define REAL_MALLOC malloc
#define REAL_FREE   free
#endif

static void find_wrong(bool is_wrong, const char *words)
{
    if (is_wrong && counts.wrong == NULL) {
        counts.wrong = words;
    }
}

static entry *entry_of(void *block)
{
    return (entry *)(void *)((unsigned char *)block - ALIGNMENT);
}

static void *make_block(size_t bytes)
{
    unsigned char *base = REAL_MALLOC(bytes + PADDING_BYTES + GUARD_BYTES);
    if (base == NULL) {
        return NULL;
    }
    /* An odd multiple of the alignment, after the entry. */
    unsigned char *block = base + ALIGNMENT + ALIGNMENT - (uintptr_t)base % ALIGNMENT;
    block += (uintptr_t)block / ALIGNMENT % 2 == 0 ? ALIGNMENT : 0;
    *entry_of(block) = (entry){base, bytes};
    memset(block, FRESH, bytes);
    memset(block + bytes, GUARD, GUARD_BYTES);
    return block;
}

static void *allocate(void *user, size_t bytes, size_t alignment)
{
    pthread_mutex_lock(&lock);
    find_wrong(user != &counts, "allocate: another user");
    find_wrong(bytes == 0, "allocate: no bytes");
    find_wrong(alignment != ALIGNMENT, "allocate: another alignment than documented");
    const bool fails = counts.allocations++ == fails_at;
    counts.failed = counts.failed || fails;
    void *block = fails ? NULL : make_block(bytes);
    if (block != NULL) {
        ++counts.live_blocks;
        counts.live_bytes += bytes;
        counts.largest_bytes = bytes > counts.largest_bytes ? bytes : counts.largest_bytes;
    }
    pthread_mutex_unlock(&lock);
    return block;
}

static bool guard_is_whole(const unsigned char *guard)
{
    for (size_t i = 0; i < GUARD_BYTES; ++i) {
        if (guard[i] != GUARD) {
            return false;
        }
    }
    return true;
}

static void release(void *user, void *block, size_t bytes, size_t alignment)
{
    pthread_mutex_lock(&lock);
    find_wrong(user != &counts, "release: another user");
    find_wrong(alignment != ALIGNMENT, "release: another alignment than at allocation");
    find_wrong(block == NULL, "release: no block");
    if (block != NULL) {
        const entry held = *entry_of(block);
        find_wrong(held.bytes != bytes, "release: another size than at allocation");
        find_wrong(!guard_is_whole((unsigned char *)block + held.bytes), "release: bytes beyond the end were written");
        --counts.live_blocks;
        counts.live_bytes -= held.bytes;
        memset(held.base, RELEASED, held.bytes + PADDING_BYTES + GUARD_BYTES);
        REAL_FREE(held.base);
    }
    pthread_mutex_unlock(&lock);
}

const svo_memory_callbacks ledger_callbacks = {
    .struct_size = sizeof ledger_callbacks, .allocate = allocate, .release = release, .user = &counts};

void ledger_begin(uint64_t fail_at)
{
    pthread_mutex_lock(&lock);
    counts.allocations = 0;
    counts.largest_bytes = 0;
    counts.others = 0;
    counts.failed = false;
    fails_at = fail_at;
    watching = true;
    pthread_mutex_unlock(&lock);
}

ledger_counts ledger_end(void)
{
    pthread_mutex_lock(&lock);
    fails_at = LEDGER_NEVER;
    watching = false;
    const ledger_counts now = counts;
    pthread_mutex_unlock(&lock);
    return now;
}

static uint64_t live_blocks(void)
{
    pthread_mutex_lock(&lock);
    const uint64_t live = counts.live_blocks;
    pthread_mutex_unlock(&lock);
    return live;
}

uint64_t ledger_settle(uint64_t blocks)
{
    const struct timespec millisecond = {.tv_nsec = 1000000};
    uint64_t live = live_blocks();
    for (unsigned i = 0; i < SETTLE_MS && live > blocks; ++i) {
        nanosleep(&millisecond, NULL);
        live = live_blocks();
    }
    return live;
}
