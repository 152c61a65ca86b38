/* SPDX-License-Identifier: MIT */
/* Parts of a folder that are planned, divided into their eight children, built (svo_parts_build), and found again. */
#ifndef SVO_LIB_PARTS_JOB_H
#define SVO_LIB_PARTS_JOB_H

#include "parts/cut.h"

/* Makes the list of the parts of a cut, whose triangles are in the folder. Those that may not fit are planned, and
   divided until they do. */
svo_status svo_i_parts_divide(svo_parts *parts, const svo_i_cut *cut, svo_device *device, svo_message *message);

/* The files that a tree is put together from. */
typedef struct svo_i_part_files {
    char **paths; /* owned, as each of them */
    size_t count, capacity;
    char *mesh; /* owned; NULL: the tree has no rays */
} svo_i_part_files;

/* Finds the files of all parts, whose heads are checked. To be freed also after a failure: SVO_FILE_ERROR, a part is
   missing; SVO_FILE_DAMAGED. */
svo_status svo_i_parts_gather(const svo_parts *parts, svo_i_part_files *files, svo_message *message);
void svo_i_part_files_free(svo_i_part_files *files);

/* A failure of files that came of a new plan says so. */
svo_status svo_i_parts_tell_cause(const svo_parts *parts, svo_status status, svo_message *message);

#endif
