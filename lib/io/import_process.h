/* SPDX-License-Identifier: MIT */
/* How an import child is started and recognized, and how its parent waits for it. */
#ifndef SVO_LIB_IO_IMPORT_PROCESS_H
#define SVO_LIB_IO_IMPORT_PROCESS_H

#include "svocl/io.h"

/* The child's arguments: itself, this word, the file, bytes of address space, seconds. */
#define IMPORT_CHILD_WORD           "--svocl-import-child"
#define IMPORT_CHILD_ARGUMENT_COUNT 5
/* Set for the child, so that a program that does not call svo_import_child_main cannot start itself without end. */
#define IMPORT_CHILD_ENVIRONMENT "SVOCL_IMPORT_CHILD"
#define IMPORT_CHILD_STREAM      3 /* the descriptor its answer goes to */

/*
 * Runs the child for one file and collects its answer in import->bytes. options: filled in, no zeros.
 * Returns SVO_OK when the child ended by itself with an answer, which may be that it failed.
 */
svo_status svo_i_import_run_child(const char *path, const svo_import_options *options, svo_import *import,
                                  svo_message *message);

#endif
