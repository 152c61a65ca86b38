/* SPDX-License-Identifier: MIT */
/*
 * Blocks of host memory from malloc or from the caller's functions, and lists of what other rooms keep with a device or
 * a tree.
 */
#include "core/memory.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "core/struct_size.h"

/* ---- blocks ---- */

#define ALIGNMENT 16

/* What stands before a block. */
typedef struct header {
    svo_i_memory memory;
    size_t bytes; /* header and block */
} header;

#define HEADER_BYTES ((sizeof(header) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT)

svo_status svo_i_memory_read(svo_message *message, const char *function, const char *argument,
                             const svo_memory_callbacks *given, svo_i_memory *out)
{
    svo_memory_callbacks read;
    SVO_I_TRY(
        svo_i_struct_read(message, function, argument, given, &read, SVO_I_STRUCT_SIZES(svo_memory_callbacks, user)));
    if (given != NULL && (read.allocate == NULL || read.release == NULL)) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s->%s is NULL", function, argument,
                          read.allocate == NULL ? "allocate" : "release");
    }
    *out = (svo_i_memory){.allocate = read.allocate, .release = read.release, .user = read.user};
    return SVO_OK;
}

static header *header_of(void *block)
{
    return (header *)(void *)((unsigned char *)block - HEADER_BYTES);
}

/* The block after a new header; NULL for none. */
static void *begin(const svo_i_memory *memory, void *whole, size_t bytes)
{
    if (whole == NULL) {
        return NULL;
    }
    header *first = whole;
    *first = (header){.memory = *memory, .bytes = bytes};
    return (unsigned char *)whole + HEADER_BYTES;
}

static const svo_i_memory *chosen(const svo_i_memory *memory)
{
    static const svo_i_memory standard = {NULL, NULL, NULL};
    return memory != NULL ? memory : &standard;
}

void *svo_i_alloc(const svo_i_memory *memory, size_t bytes)
{
    const svo_i_memory *from = chosen(memory);
    size_t all_bytes = 0;
    if (!svo_i_add_size(bytes, HEADER_BYTES, &all_bytes)) {
        return NULL;
    }
    return begin(from, from->allocate != NULL ? from->allocate(from->user, all_bytes, ALIGNMENT) : malloc(all_bytes),
                 all_bytes);
}

void *svo_i_alloc_zeroed(const svo_i_memory *memory, size_t count, size_t element_bytes)
{
    const svo_i_memory *from = chosen(memory);
    size_t bytes = 0;
    size_t all_bytes = 0;
    if (!svo_i_mul_size(count, element_bytes, &bytes) || !svo_i_add_size(bytes, HEADER_BYTES, &all_bytes)) {
        return NULL;
    }
    if (from->allocate == NULL) {
        return begin(from, calloc(1, all_bytes), all_bytes); /* large blocks are zero without being written */
    }
    void *block = svo_i_alloc(from, bytes);
    return block != NULL ? memset(block, 0, bytes) : NULL;
}

void *svo_i_grow(const svo_i_memory *memory, void *block, size_t bytes)
{
    if (block == NULL) {
        return svo_i_alloc(memory, bytes);
    }
    header *old = header_of(block);
    const svo_i_memory from = old->memory;
    size_t all_bytes = 0;
    if (!svo_i_add_size(bytes, HEADER_BYTES, &all_bytes)) {
        return NULL;
    }
    if (from.allocate == NULL) {
        return begin(&from, realloc(old, all_bytes), all_bytes);
    }
    void *grown = svo_i_alloc(&from, bytes);
    if (grown != NULL) {
        const size_t old_bytes = old->bytes - HEADER_BYTES;
        memcpy(grown, block, old_bytes < bytes ? old_bytes : bytes);
        svo_i_free(block);
    }
    return grown;
}

char *svo_i_copy_text(const svo_i_memory *memory, const char *text)
{
    const size_t bytes = strlen(text) + 1;
    char *copy = svo_i_alloc(memory, bytes);
    return copy != NULL ? memcpy(copy, text, bytes) : NULL;
}

void svo_i_free(void *block)
{
    if (block == NULL) {
        return;
    }
    header *whole = header_of(block);
    const header held = *whole;
    if (held.memory.release != NULL) {
        held.memory.release(held.memory.user, whole, held.bytes, ALIGNMENT);
    } else {
        free(whole);
    }
}

/* ---- attachments ---- */

void svo_i_attachment_add(svo_i_attachment **list, svo_i_attachment *attachment)
{
    attachment->next = *list;
    *list = attachment;
}

svo_i_attachment *svo_i_attachment_find(svo_i_attachment *list, svo_i_attachment_destroy destroy)
{
    while (list != NULL && list->destroy != destroy) {
        list = list->next;
    }
    return list;
}

void svo_i_attachments_outdate(svo_i_attachment **list)
{
    while (*list != NULL) {
        svo_i_attachment *attachment = *list;
        if (attachment->outdate != NULL && attachment->outdate(attachment) != 0) {
            list = &attachment->next;
        } else {
            *list = attachment->next;
            attachment->destroy(attachment);
        }
    }
}

void svo_i_attachments_clear(svo_i_attachment **list)
{
    while (*list != NULL) {
        svo_i_attachment *attachment = *list;
        *list = attachment->next;
        attachment->destroy(attachment);
    }
}
