/* SPDX-License-Identifier: MIT */
/*
 * Public structs that may grow. Each begins with "size_t struct_size", which the caller sets to the size that its
 * headers declare. New fields go to the end, never into padding, and zero is their default; so callers that were
 * compiled against older headers keep working.
 */
#ifndef SVO_LIB_CORE_STRUCT_SIZE_H
#define SVO_LIB_CORE_STRUCT_SIZE_H

#include <stddef.h>

#include "core/message.h"

/* The sizes in bytes that a struct may have. */
typedef struct svo_i_struct_sizes {
    size_t current; /* what this version of the library knows */
    size_t first; /* of the first release: nothing smaller was ever valid */
} svo_i_struct_sizes;

/* The sizes of a struct whose first release ends with the field last_field. */
#define SVO_I_STRUCT_SIZES(type, last_field)                                                                       \
    ((svo_i_struct_sizes){sizeof(type),                                                                            \
                          (offsetof(type, last_field) + sizeof(size_t) - 1 + sizeof(((type *)NULL)->last_field)) / \
                              sizeof(size_t) * sizeof(size_t)})

SVO_I_SHARED_BEGIN

/*
 * Copies a caller's input struct to one of the current size; fields that the caller does not have become zero.
 *
 * function, argument: names for the message. from: NULL means all zero. to: sizes.current bytes. message: NULL
 * allowed.
 * Returns SVO_INVALID_ARGUMENT when struct_size is not in first .. current.
 */
svo_status svo_i_struct_read(svo_message *message, const char *function, const char *argument, const void *from,
                             void *to, svo_i_struct_sizes sizes);

/*
 * Copies an output struct of the current size to the caller's, as far as that reaches; what the caller has beyond it
 * becomes zero. struct_size stays as the caller set it.
 *
 * Returns SVO_INVALID_ARGUMENT when the caller's struct_size is below first, and writes nothing then.
 */
svo_status svo_i_struct_write(svo_message *message, const char *function, const char *argument, const void *from,
                              void *to, svo_i_struct_sizes sizes);

/* Whether svo_i_struct_write would accept the struct; for functions that check before they begin. */
svo_status svo_i_struct_check(svo_message *message, const char *function, const char *argument, const void *to,
                              svo_i_struct_sizes sizes);

SVO_I_SHARED_END

#endif
