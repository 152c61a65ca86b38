/* SPDX-License-Identifier: MIT */
/* A caller's source or sink (svocl/files.h) while it is open. Trees, compact trees and voxels are read and written
   through these. */
#ifndef SVO_LIB_IO_FILES_H
#define SVO_LIB_IO_FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/message.h"
#include "output/output.h"
#include "svocl/files.h"

/* ---- reading ---- */

/* Reads bytes from a place on; *got: how many, fewer where the file ends before. Returns 0 or an errno. */
int svo_i_read_at(int file, uint64_t offset, void *out, size_t byte_count, size_t *got);

/* Reads bytes of a file that is made while it is read. */
typedef svo_status (*svo_i_source_reader)(void *of, uint64_t offset, void *out, size_t byte_count);

typedef struct svo_i_source {
    const char *name; /* begins messages */
    svo_message *message;
    const uint8_t *bytes; /* the caller's, of the whole file; NULL: they are read from file */
    int file; /* -1: none */
    uint64_t byte_count; /* of the whole file */
    svo_i_source_reader read; /* in place of both; NULL: none */
    void *of; /* passed to read */
} svo_i_source;

/* Opens a source. function: of the caller, for the message. To be closed after success. */
svo_status svo_i_source_open(const char *function, svo_source given, svo_message *message, svo_i_source *source);
void svo_i_source_close(svo_i_source *source);
/* Reads bytes that the file had when it was opened. */
svo_status svo_i_source_read(const svo_i_source *source, uint64_t offset, void *out, size_t byte_count);

/* ---- writing ---- */

typedef struct svo_i_sink {
    const char *name; /* begins messages: the path, or the caller's function */
    svo_message *message;
    svo_sink given;
    svo_i_output output; /* of a path */
    int error; /* errno of what failed of it */
} svo_i_sink;

/* Opens a sink. function: of the caller, for the message. To be closed after success. */
svo_status svo_i_sink_open(const char *function, svo_sink given, svo_message *message, svo_i_sink *sink);
/* Whether all the bytes were written; after a failure there is nothing to do but to close. */
bool svo_i_sink_write(svo_i_sink *sink, const void *bytes, size_t byte_count);
/* Gives the file its name if status is SVO_OK, else leaves nothing behind. Returns status, or why a path could not be
   written. */
svo_status svo_i_sink_close(svo_i_sink *sink, svo_status status);

#endif
