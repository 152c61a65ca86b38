/* SPDX-License-Identifier: MIT */
/* The library's host memory, and what handles own in it. */
#ifndef SVO_LIB_CORE_MEMORY_H
#define SVO_LIB_CORE_MEMORY_H

#include <stddef.h>

#include "core/limits.h"
#include "core/message.h"
#include "svocl/memory.h"

/*
 * The library's host memory. Each block begins with a header that holds its size and the functions it came from, so it
 * is released without a handle. Nothing else in the library calls malloc and its relatives; tools/dev check finds it.
 */

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

/*
 * What other rooms keep with a handle of the core: compiled programs with a device, a BVH with a tree. The handle owns
 * these attachments and destroys them without knowing what they are, so that the core includes no other room.
 */

typedef struct svo_i_attachment svo_i_attachment;

/* Releases what is attached, and the attachment itself. */
typedef void (*svo_i_attachment_destroy)(svo_i_attachment *attachment);

/* Tells what is attached that the handle's content changes. Returns 0 if it is of no use then. */
typedef int (*svo_i_attachment_outdate)(svo_i_attachment *attachment);

/* The first member of every struct that is attached. */
struct svo_i_attachment {
    svo_i_attachment *next; /* of the same handle */
    svo_i_attachment_destroy destroy; /* not NULL; also says what is attached, see svo_i_attachment_find */
    svo_i_attachment_outdate outdate; /* NULL: it is of no use when the content changes */
};

/* Adds an attachment to the list, which owns it from now on. */
void svo_i_attachment_add(svo_i_attachment **list, svo_i_attachment *attachment);

/* The newest attachment that destroy would release, or NULL. */
svo_i_attachment *svo_i_attachment_find(svo_i_attachment *list, svo_i_attachment_destroy destroy);

/* Destroys the attachments that are of no use when the handle's content changes. */
void svo_i_attachments_outdate(svo_i_attachment **list);

/* Destroys all attachments, the newest first, and sets *list to NULL. */
void svo_i_attachments_clear(svo_i_attachment **list);

#endif
