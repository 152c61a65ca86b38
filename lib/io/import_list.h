/* SPDX-License-Identifier: MIT */
/* An array that grows, for the readers of mesh formats in the import child. */
#ifndef SVO_LIB_IO_IMPORT_LIST_H
#define SVO_LIB_IO_IMPORT_LIST_H

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/* Elements of one size, which each call names. All zero: empty. free(items) releases it. */
typedef struct item_list {
    void *items;
    size_t count, capacity;
} item_list;

/* A new last element, not initialized; NULL when memory runs out. */
static inline void *list_add(item_list *list, size_t element_bytes)
{
    if (list->count == list->capacity) {
        const size_t capacity = list->capacity == 0 ? 256 : 2 * list->capacity;
        void *items = capacity <= SIZE_MAX / element_bytes ? realloc(list->items, capacity * element_bytes) : NULL;
        if (items == NULL) {
            return NULL;
        }
        list->items = items;
        list->capacity = capacity;
    }
    return (char *)list->items + list->count++ * element_bytes;
}

#endif
