/* SPDX-License-Identifier: MIT */
/*
 * Temporary files of this process, which are removed when a signal ends it: SIGHUP, SIGINT, SIGPIPE, SIGQUIT, SIGTERM,
 * SIGXCPU. A signal that was ignored when the program started stays ignored.
 *
 * Files are made and removed by one thread at a time, at first the one that called cleanup_begin. A signal that another
 * thread receives is passed on to it, so it never comes between a file and its entry here.
 */
#ifndef SVOCL_TOOLS_SUPPORT_CLEANUP_H
#define SVOCL_TOOLS_SUPPORT_CLEANUP_H

#include "output/output.h"

/* First in main: installs the handlers. */
void cleanup_begin(void);

/* From now on the calling thread makes and removes files. No other one may be in a function of this header. */
void cleanup_take(void);
/* Ends the process with this exit code, whatever its threads are doing, and removes its files. */
void cleanup_end(int exit_code) __attribute__((noreturn));

/* Removes the name that watch was told of when a signal ends the process. */
typedef struct cleanup_entry {
    svo_i_output_watch watch;
    char *path; /* by malloc; NULL: nothing is there */
    struct cleanup_entry *next;
} cleanup_entry;

/* Begins to watch; the entry stays where it is until cleanup_remove. */
void cleanup_add(cleanup_entry *entry);
void cleanup_remove(cleanup_entry *entry);

/* Between the two, signals wait. They do not nest. */
void cleanup_hold(void);
void cleanup_release(void);

#endif
