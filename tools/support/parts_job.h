/* SPDX-License-Identifier: MIT */
/* Trees in parts: shared by `build --max-memory` and `parts`. */
#ifndef SVOCL_TOOLS_SUPPORT_PARTS_JOB_H
#define SVOCL_TOOLS_SUPPORT_PARTS_JOB_H

#include "support/input.h"
#include "support/session.h"
#include "svocl/parts.h"

/* The folder of the parts of a .svo file; by malloc, NULL when out of memory. */
char *parts_folder_of(const char *path);
bool parts_folder_exists(const char *folder);

/* program_fail with a library message: PROGRAM_TRY_AGAIN after a failure of the device or of memory. */
int parts_fail(program *state, svo_status status, const char *message);

/* Reads the mesh of INPUT and plans its parts in a folder by the options. *mesh_bytes: of the mesh in memory; NULL
   allowed. Returns the exit code. */
int parts_plan(program *state, session *opened, const char *folder, uint64_t *mesh_bytes);
int parts_open(program *state, const char *folder, svo_parts **out);
/* Builds one part; where its file is damaged, says so. */
int parts_build(program *state, session *opened, const svo_parts *parts, size_t index);
int parts_finish(program *state, const svo_parts *parts, const char *path);

#endif
