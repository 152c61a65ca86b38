/* SPDX-License-Identifier: MIT */
/* Copies between the structs of callers and those of this version of the library. */
#include "core/struct_size.h"

#include <string.h>

/* struct_size is the first member of every struct. */
static size_t size_of(const void *any_struct)
{
    size_t bytes = 0;
    memcpy(&bytes, any_struct, sizeof bytes);
    return bytes;
}

svo_status svo_i_struct_read(svo_message *message, const char *function, const char *argument, const void *from,
                             void *to, svo_i_struct_sizes sizes)
{
    const size_t given = from != NULL ? size_of(from) : 0;
    if (from != NULL && (given < sizes.first || given > sizes.current)) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s.struct_size is %zu, not in %zu .. %zu", function,
                          argument, given, sizes.first, sizes.current);
    }
    memset(to, 0, sizes.current);
    if (from != NULL) {
        memcpy(to, from, given);
    }
    memcpy(to, &sizes.current, sizeof sizes.current);
    return SVO_OK;
}

svo_status svo_i_struct_check(svo_message *message, const char *function, const char *argument, const void *to,
                              svo_i_struct_sizes sizes)
{
    if (to == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function, argument);
    }
    if (size_of(to) < sizes.first) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s.struct_size is %zu, below %zu", function, argument,
                          size_of(to), sizes.first);
    }
    return SVO_OK;
}

svo_status svo_i_struct_write(svo_message *message, const char *function, const char *argument, const void *from,
                              void *to, svo_i_struct_sizes sizes)
{
    SVO_I_TRY(svo_i_struct_check(message, function, argument, to, sizes));
    const size_t given = size_of(to);
    const size_t copied = given < sizes.current ? given : sizes.current;
    unsigned char *bytes = to;
    memcpy(bytes, from, copied);
    memset(bytes + copied, 0, given - copied);
    memcpy(bytes, &given, sizeof given);
    return SVO_OK;
}
