/* SPDX-License-Identifier: MIT */
/* Running an import child: its command line and environment, and the parent's side of its run. */
#ifndef SVO_LIB_IO_IMPORT_H
#define SVO_LIB_IO_IMPORT_H

#include <stdbool.h>

#include "svocl/io.h"

/* The child's arguments: itself, this word, the file, bytes of address space, seconds, whether the seconds and the
   bytes grow with the work that the child announces, and whether it reads normal maps. */
#define IMPORT_CHILD_WORD           "--svocl-import-child"
#define IMPORT_CHILD_ARGUMENT_COUNT 8
#define IMPORT_CHILD_GROWS          "grows"
#define IMPORT_CHILD_FIXED          "fixed"
#define IMPORT_CHILD_NORMAL_MAPS    "normal-maps"
#define IMPORT_CHILD_NO_NORMAL_MAPS "no-normal-maps"
/* Set for the child, so that a program that never calls svo_import_child_main does not start itself recursively. */
#define IMPORT_CHILD_ENVIRONMENT "SVOCL_IMPORT_CHILD"
#define IMPORT_CHILD_STREAM      3 /* the file descriptor of its answer */

/* Which limits grow with the announced work: those that the caller has not set. */
typedef struct import_growth {
    bool time, memory;
} import_growth;

/*
 * Runs the child for one file and collects its answer in import->bytes. options: complete, without zeros. grows: with
 * announced work (STREAM_WORK) there is a second more for each STREAM_BYTES_A_SECOND, and svo_i_stream_memory.
 * Returns SVO_OK when the child ended by itself with an answer; that answer may report a failure.
 */
svo_status svo_i_import_run_child(const char *path, const svo_import_options *options, import_growth grows,
                                  svo_import *import, svo_message *message);

#endif
