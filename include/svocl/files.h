/* SPDX-License-Identifier: MIT */
/** \file
 * Where files are read from and written to: a path, or the caller's memory or function. io.h and voxel_files.h
 * (svocl::io) take them.
 *
 *     svo_tree_load(svo_from_path("model.svo"), NULL, &tree, &message);
 *     svo_tree_load(svo_from_memory(bytes, byte_count, "model"), NULL, &tree, &message);
 *     svo_tree_save(tree, svo_to_path("model.svo"), NULL, &message);
 *     svo_tree_save(tree, svo_to_callback(append, &list), NULL, &message);
 *
 * A file at a path is written whole or not at all: on failure nothing is left behind and an existing file stays as it
 * was. The bytes go to a file without a name in the folder of path (O_TMPFILE), which is flushed and then takes the
 * place of path. A process that ends meanwhile leaves nothing. On file systems without such files the bytes have a
 * temporary name, .svocl-PID-N.tmp, which a process that is killed leaves behind; write through a function to handle
 * that yourself. A symbolic link stays, and what it leads to is written. Bytes for a device, a pipe or an open
 * descriptor (/dev/stdout) go straight there; a pipe that nobody reads is an error and no SIGPIPE, and opening a named
 * pipe waits for its reader.
 */
#ifndef SVOCL_FILES_H
#define SVOCL_FILES_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A file to read: a regular file, or its contents in memory. What it points to lives until the call returns. This
 *  struct does not grow. */
typedef struct svo_source {
    const char *path; /**< of the file; NULL: its contents are bytes */
    const void *bytes; /**< not NULL, even where byte_count is 0. Unused with path, as what follows */
    size_t byte_count; /**< number of bytes */
    const char *name; /**< stands for the path in messages; not NULL */
} svo_source;

/** A file to read.
 *
 * \param path of the file
 * \returns the source. */
static inline svo_source svo_from_path(const char *path)
{
    const svo_source source = {path, NULL, 0, NULL};
    return source;
}

/** The contents of a file in memory.
 *
 * \param bytes not NULL, even where byte_count is 0
 * \param byte_count their number
 * \param name stands for the path in messages
 * \returns the source. */
static inline svo_source svo_from_memory(const void *bytes, size_t byte_count, const char *name)
{
    const svo_source source = {NULL, bytes, byte_count, name};
    return source;
}

/** Receives the bytes of a file in their order.
 *
 * \param user as given
 * \param bytes valid during the call
 * \param byte_count above 0
 * \returns 0 when all of them were written; anything else ends the writing. */
typedef int (*svo_write_callback)(void *user, const void *bytes, size_t byte_count);

/** Where the bytes of a file go: to a path, whole or not at all (see the head of this file), or through a function,
 *  into memory, an archive, a connection. They are the same. This struct does not grow. */
typedef struct svo_sink {
    const char *path; /**< of the file; NULL: write receives the bytes */
    svo_write_callback write; /**< receives them piece by piece. Unused with path, as user */
    void *user; /**< passed to write */
} svo_sink;

/** A file to write.
 *
 * \param path of the file
 * \returns the sink. */
static inline svo_sink svo_to_path(const char *path)
{
    const svo_sink sink = {path, NULL, NULL};
    return sink;
}

/** A function that receives the bytes of a file.
 *
 * \param write not NULL; when it does not return 0, the writing ends with SVO_FILE_ERROR
 * \param user passed to write
 * \returns the sink. */
static inline svo_sink svo_to_callback(svo_write_callback write, void *user)
{
    const svo_sink sink = {NULL, write, user};
    return sink;
}

#ifdef __cplusplus
}
#endif

#endif
