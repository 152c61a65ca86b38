/* SPDX-License-Identifier: MIT */
/* Reads part files. They are not trusted: every byte that is used is covered by a checksum that has been compared. */
#ifndef SVO_LIB_PARTS_PART_READ_H
#define SVO_LIB_PARTS_PART_READ_H

#include <stdbool.h>

#include "parts/format.h"
#include "svocl/parts.h"

typedef struct svo_i_part_reader {
    const char *path;
    svo_message *message;
    int file;
    part_file content; /* head and table */
} svo_i_part_reader;

/* Opens a file of the whole that the header describes. To be closed also after a failure. */
svo_status svo_i_part_open(const svo_part_header *header, const char *path, bool is_mesh, svo_message *message,
                           svo_i_part_reader *reader);
void svo_i_part_close(svo_i_part_reader *reader);

/* The segment of a kind and level; NULL: the file has none. */
const part_segment *svo_i_part_find(const svo_i_part_reader *reader, uint32_t kind, uint32_t level);

/* Called with the bytes of a segment, a piece at a time; pieces but the last are multiples of 65536 bytes. */
typedef svo_status (*svo_i_part_visitor)(void *user, const void *bytes, size_t byte_count);
/* Reads a segment and compares its checksum after the last piece, so what came from it is void after a failure. visit:
   NULL allowed. */
svo_status svo_i_part_stream(const svo_i_part_reader *reader, const part_segment *segment, svo_i_part_visitor visit,
                             void *user);
/* Fails for a file whose contents contradict each other. */
svo_status svo_i_part_damaged(const svo_i_part_reader *reader, const char *why);

/* Checks a part file: its head, and on request every byte. */
svo_status svo_i_part_check(const svo_part_header *header, const char *path, bool reads_all, svo_part_info *info,
                            svo_message *message);

/* Takes a caller's header. */
svo_status svo_i_part_header_read(const char *function, const svo_part_header *given, svo_message *message,
                                  svo_part_header *header);

#endif
