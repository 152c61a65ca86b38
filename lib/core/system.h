/* SPDX-License-Identifier: MIT */
/*
 * What the library asks of the operating system beside OpenCL; system_posix.c or system_windows.c answers. Descriptors
 * are the C library's, which close() closes. Paths are as open() takes them: on Windows, in the process's code page.
 */
#ifndef SVO_LIB_CORE_SYSTEM_H
#define SVO_LIB_CORE_SYSTEM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/visibility.h"

SVO_I_SHARED_BEGIN

/* Wall clock in milliseconds, monotonic. */
double svo_i_now_ms(void);

SVO_I_SHARED_END

/* Waits that long, or a little longer. */
void svo_i_system_sleep_ms(unsigned milliseconds);

/* Processors that are online, at least 1. */
uint32_t svo_i_system_processors(void);

/* The machine's memory; UINT64_MAX where that cannot be known. */
uint64_t svo_i_system_memory_bytes(void);

/* A descriptor that reads a file, without waiting for who writes into a pipe; -1, with errno. */
int svo_i_system_open(const char *path);

/* A descriptor that writes a new file; -1, with errno, which is EEXIST where something has that name. */
int svo_i_system_make(const char *path);

/* All of the bytes; false on an error, with errno, or where the file ends before. */
bool svo_i_system_read(int descriptor, void *bytes, size_t size);
bool svo_i_system_write(int descriptor, const void *bytes, size_t size);

/* Gives a file the name of another, which it replaces at once. False, with errno. */
bool svo_i_system_replace(const char *from, const char *to);

/* Makes a folder, unless it is there. False, with errno. */
bool svo_i_system_make_folder(const char *path);

#endif
