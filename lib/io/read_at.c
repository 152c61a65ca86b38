/* SPDX-License-Identifier: MIT */
/* The one loop around pread of trees, parts and meshes in blocks, which may be interrupted or give less. */
#define _POSIX_C_SOURCE 200809L
#include "io/read_at.h"

#include <errno.h>
#include <unistd.h>

int svo_i_read_at(int file, uint64_t offset, void *out, size_t byte_count, size_t *got)
{
    char *to = out;
    ssize_t count = 1;
    *got = 0;
    while (*got < byte_count && count != 0) {
        count = pread(file, to + *got, byte_count - *got, (off_t)(offset + *got));
        if (count < 0 && errno != EINTR) {
            return errno;
        }
        *got += count > 0 ? (size_t)count : 0;
    }
    return 0;
}
