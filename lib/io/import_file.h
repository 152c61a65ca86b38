/* SPDX-License-Identifier: MIT */
/* Files of the import child: mapped for reading. */
#ifndef SVO_LIB_IO_IMPORT_FILE_H
#define SVO_LIB_IO_IMPORT_FILE_H

#include <stddef.h>

typedef struct file_bytes {
    const char *bytes; /* not NULL */
    size_t byte_count;
} file_bytes;

/* Returns NULL, or why the file cannot be read: a static string. */
const char *svo_i_file_open(const char *path, file_bytes *file);
/* A file whose name is relative to the folder of another one, with either system's separators. */
const char *svo_i_file_open_beside(const char *path, const char *name, file_bytes *file);
void svo_i_file_close(file_bytes *file);

/* That name as a path, released by free; NULL: no memory. */
char *svo_i_file_beside(const char *path, const char *name);

#endif
