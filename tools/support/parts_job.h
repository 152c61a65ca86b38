/* SPDX-License-Identifier: MIT */
/* Trees in parts: shared by `build --max-memory` and `parts`. */
#ifndef SVOCL_TOOLS_SUPPORT_PARTS_JOB_H
#define SVOCL_TOOLS_SUPPORT_PARTS_JOB_H

#include "support/input.h"
#include "support/parts_input.h"
#include "support/session.h"
#include "svocl/parts.h"

/* The folder of the parts of a .svo file; by malloc, NULL when out of memory. */
char *parts_folder_of(const char *path);
bool parts_folder_exists(const char *folder);
/* Runs that ended before they had planned leave a folder without a plan. */
bool parts_folder_has_plan(const char *folder);

/* Refuses --builder where it is not the one that makes parts. Returns the exit code. */
int parts_check_builder(program *state);

/* How a mesh came into a folder of parts. */
typedef struct parts_mesh {
    bool in_blocks; /* it was never in memory as a whole */
    svo_message why_whole; /* why not, of a mesh file; "": of no file, or not asked for */
    uint64_t bytes; /* of the mesh in memory */
} parts_mesh;

/* Plans the parts of INPUT in a folder by the options: a mesh file in blocks where that works and --max-memory is
   given, else from memory. Returns the exit code. */
int parts_plan(program *state, session *opened, const char *folder, parts_mesh *mesh);
int parts_open(program *state, const char *folder, svo_parts **out);
/* Builds one part; where its file is damaged, says so. */
int parts_build(program *state, session *opened, const svo_parts *parts, size_t index);
/* Stitches the parts; PROGRAM_TRY_AGAIN where one is missing or damaged, since it can be built. By --tree-form it makes
   a compact tree of them, for which the tree must fit on the device and in memory, and its .svo file in a temporary
   folder. */
int parts_finish(program *state, const session *opened, const svo_parts *parts, const char *path);
/* Begins shares of the file, writes one of them, or gives the file its name when all are written. */
int parts_begin_shares(program *state, const svo_parts *parts, unsigned count);
int parts_write_share(program *state, const svo_parts *parts, unsigned index, unsigned count);
int parts_finish_shares(program *state, const svo_parts *parts, unsigned count, const char *path);

#endif
