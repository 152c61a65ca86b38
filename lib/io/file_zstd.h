/* SPDX-License-Identifier: MIT */
/* zstd's contexts in the memory of a tree. */
#ifndef SVO_LIB_IO_FILE_ZSTD_H
#define SVO_LIB_IO_FILE_ZSTD_H

#include <stddef.h>
#include <stdint.h>

#define ZSTD_STATIC_LINKING_ONLY /* ZSTD_customMem */
#include <zstd.h>

#include "core/memory.h"

static inline void *file_zstd_allocate(void *memory, size_t bytes)
{
    return svo_i_alloc(memory, bytes);
}

static inline void file_zstd_release(void *memory, void *block)
{
    (void)memory;
    svo_i_free(block);
}

/* For ZSTD_createCCtx_advanced and ZSTD_createDCtx_advanced. memory: to outlive the context. */
static inline ZSTD_customMem file_zstd_memory(const svo_i_memory *memory)
{
    return (ZSTD_customMem){file_zstd_allocate, file_zstd_release, (void *)(uintptr_t)memory};
}

#endif
