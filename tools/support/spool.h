/* SPDX-License-Identifier: MIT */
/* Bytes in a temporary file with a name of a given suffix, for readers that need both. A signal that ends the program
   removes it. */
#ifndef SVOCL_TOOLS_SUPPORT_SPOOL_H
#define SVOCL_TOOLS_SUPPORT_SPOOL_H

#include "support/cleanup.h"
#include "support/program.h"

/* Stays where it is while it exists. */
typedef struct spool_file {
    char path[4096];
    svo_i_output target;
    cleanup_entry entry;
} spool_file;

/* Makes an empty file in $TMPDIR, or in /tmp. Returns the exit code; after a failure there is nothing to remove. */
int spool_open(program *state, const char *suffix, spool_file *spool);
int spool_write(program *state, spool_file *spool, const void *bytes, size_t byte_count);
void spool_remove(spool_file *spool);

#endif
