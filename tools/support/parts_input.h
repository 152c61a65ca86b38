/* SPDX-License-Identifier: MIT */
/* INPUT that is a folder of parts, a tree that nobody stitched; and what failures of parts mean for the exit code. */
#ifndef SVOCL_TOOLS_SUPPORT_PARTS_INPUT_H
#define SVOCL_TOOLS_SUPPORT_PARTS_INPUT_H

#include "support/program.h"
#include "svocl/parts.h"
#include "svocl/parts_tree.h"

/* program_fail with a library message: PROGRAM_TRY_AGAIN after what may pass, such as a failure of the device, of
   memory or of space, or another's lease. */
int parts_fail(program *state, svo_status status, const char *message);
/* Whether a part is missing or damaged, which building it mends. */
bool parts_lack(const svo_parts *parts);

/* Whether a name is that of a folder with a plan of parts, or of the plan in it. */
bool parts_input_is_name(const char *name);
/* Opens the folder. Returns the exit code: PROGRAM_TRY_AGAIN where a part is missing or damaged. */
int parts_input_open(program *state, svo_parts_tree **out);
/* The same exit code for a failure of a call that reads the tree. */
int parts_input_fail(program *state, svo_status status, const svo_message *message);
/* What --region and --levels ask for. Returns the exit code. */
int parts_input_region(program *state, svo_parts_region *region);
/* The length of all parts' files. Returns the exit code. */
int parts_input_measure(program *state, uint64_t *byte_count);
/* Loads it. Returns the exit code. */
int parts_input_load(program *state, svo_tree **out);

#endif
