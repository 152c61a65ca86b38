/* SPDX-License-Identifier: MIT */
/*
 * The library's host memory. Each block begins with a header that holds its size and the functions it came from, so it
 * is released without a handle. Nothing else in the library calls malloc and its relatives; tools/dev check finds it.
 */
#ifndef SVO_LIB_CORE_MEMORY_H
#define SVO_LIB_CORE_MEMORY_H

#include <stddef.h>

#include "core/message.h"
#include "svocl/memory.h"

/* Where memory comes from. All NULL: malloc and free. */
typedef struct svo_i_memory {
    svo_allocate_callback allocate;
    svo_release_callback release;
    void *user;
} svo_i_memory;

SVO_I_SHARED_BEGIN

/*
 * Takes a caller's functions. function, argument: names for the message. given: NULL means malloc and free. message:
 * NULL allowed.
 * Returns SVO_INVALID_ARGUMENT when one of the functions is missing or struct_size is wrong.
 */
svo_status svo_i_memory_read(svo_message *message, const char *function, const char *argument,
                             const svo_memory_callbacks *given, svo_i_memory *out);

/* A block, aligned for every type; NULL when out of memory. memory: NULL means malloc and free. */
void *svo_i_alloc(const svo_i_memory *memory, size_t bytes);
/* The same for count elements, all zero; NULL also when their size overflows. */
void *svo_i_alloc_zeroed(const svo_i_memory *memory, size_t count, size_t element_bytes);
/* The block with another size; its contents are kept as far as they fit. It stays with the functions that it came from;
   memory is for a block of NULL, which is a new one. Returns NULL, with the block unchanged, when out of memory. */
void *svo_i_grow(const svo_i_memory *memory, void *block, size_t bytes);
/* A copy of a text; NULL when out of memory. */
char *svo_i_copy_text(const svo_i_memory *memory, const char *text);
/* Releases a block; NULL allowed. */
void svo_i_free(void *block);

SVO_I_SHARED_END

#endif
