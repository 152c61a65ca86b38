/* SPDX-License-Identifier: MIT */
/* Reads of open files. */
#ifndef SVO_LIB_IO_READ_AT_H
#define SVO_LIB_IO_READ_AT_H

#include <stddef.h>
#include <stdint.h>

/* Reads bytes from a place on; *got: how many, fewer where the file ends before. Returns 0 or an errno. */
int svo_i_read_at(int file, uint64_t offset, void *out, size_t byte_count, size_t *got);

#endif
