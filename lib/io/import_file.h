/* SPDX-License-Identifier: MIT */
/* Files of the import child: mapped for reading. */
#ifndef SVO_LIB_IO_IMPORT_FILE_H
#define SVO_LIB_IO_IMPORT_FILE_H

#include <assimp/cfileio.h>
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

/* Tells the parent at the other end of stream that such a file is read. Returns -1 when memory runs out or the parent
   is gone. */
int svo_i_file_tell_beside(int stream, const char *path, const char *name);

/* How assimp opens files, so that the parent is told of each but path, the mesh file. files: filled in, and valid as
   long as path. */
typedef struct scene_files {
    struct aiFileIO io;
    int stream;
    const char *path;
    int result; /* -1: the parent is gone */
    const char *trouble; /* why path itself could not be opened; NULL: it could */
} scene_files;

void svo_i_scene_files(int stream, const char *path, scene_files *files);

#endif
