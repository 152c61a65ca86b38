/* SPDX-License-Identifier: MIT */
/*
 * Files that are written whole or not at all. This is the first room: the library's writers and the program's both use
 * it, so it knows neither messages nor statuses, and it allocates no memory. Functions return 0 or the errno of what
 * failed.
 *
 * A path leads to one of these:
 *
 *   - A file, or nothing yet: the bytes go to a file without a name in the same folder (O_TMPFILE). When it is
 *     complete and flushed it gets its name; an old file of that name is replaced by a rename. File systems without
 *     O_TMPFILE get a temporary name from the start.
 *   - A symbolic link: what it leads to is written, and the link stays.
 *   - A device, a pipe, a terminal: the bytes go straight there.
 *   - An open descriptor of this process, such as /dev/stdout or /dev/fd/3: the bytes go straight to it, from where it
 *     stands. Opening such a path anew would begin at the start of a file that others have written to.
 */
#ifndef SVO_LIB_OUTPUT_OUTPUT_H
#define SVO_LIB_OUTPUT_OUTPUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/*
 * Told about temporary names, so that a program can remove them when a signal ends it. hold is called before a name
 * may appear or vanish, release after it: with the name that is there now, or NULL. A process that is ended between
 * two such pairs leaves exactly the name of the last release behind.
 */
typedef struct svo_i_output_watch {
    void (*hold)(void *user);
    void (*release)(void *user, const char *temporary);
    void *user;
} svo_i_output_watch;

/* At least PATH_MAX, which headers have only where POSIX was asked for before the first of them. */
#define SVO_I_OUTPUT_PATH_BYTES 4096

typedef struct svo_i_output {
    int descriptor; /* where the bytes go; -1: not open */
    /* The file to make or to replace, with links followed; "": the bytes go straight to their place. */
    char target[SVO_I_OUTPUT_PATH_BYTES];
    char temporary[SVO_I_OUTPUT_PATH_BYTES]; /* the name that the bytes have meanwhile; "": none */
    const svo_i_output_watch *watch; /* NULL allowed */
} svo_i_output;

/* Whether an output could be opened at path, as far as can be told without opening it: 0 or an errno. */
int svo_i_output_check(const char *path);

/*
 * Opens an output. Opening a named pipe waits for its reader.
 *
 * watch: NULL allowed; must outlive the output. output: to be committed or abandoned after success.
 */
int svo_i_output_open(const char *path, const svo_i_output_watch *watch, svo_i_output *output);

/* The same straight to an open descriptor, of which a copy is used. EBADF where it cannot be written to. */
int svo_i_output_open_descriptor(int descriptor, svo_i_output *output);

/* Writes all the bytes. A reader that has gone is EPIPE; it raises no SIGPIPE. */
int svo_i_output_write(const svo_i_output *output, const void *bytes, size_t byte_count);

/* Writes all the bytes to a place of a file that is being made (target is not ""). */
int svo_i_output_write_at(const svo_i_output *output, uint64_t offset, const void *bytes, size_t byte_count);

/* Flushes, gives the file its name and closes. On failure nothing is left, and an old file is unchanged. */
int svo_i_output_commit(svo_i_output *output);

/* The same without flushing to a local disk, for files that are made again if need be: after a crash of the machine the
   file may be there with other bytes, so it must have a checksum. */
int svo_i_output_commit_unflushed(svo_i_output *output);

/* Gives a file that is complete and closed the name path, as svo_i_output_commit does. EINVAL where path leads to no
   file, EXDEV where it is on another file system. On failure the file stays where it is. */
int svo_i_output_take(const char *complete, const char *path);

/* Closes and leaves nothing behind, except what has gone straight to its place. Does nothing when not open. */
void svo_i_output_abandon(svo_i_output *output);

/* Whether a file of a folder has such a name as outputs have meanwhile: one that a killed process left behind, or one
   that another process is writing. */
bool svo_i_output_is_temporary(const char *name);

/* The descriptor of this process that a path names, as /dev/stdin names 0; -1: none. */
int svo_i_output_descriptor_of(const char *path);

#endif
