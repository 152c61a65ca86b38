/* SPDX-License-Identifier: MIT */
/* From INPUT to a tree in memory, measured: what build, hash, verify and render share. */
#ifndef SVOCL_TOOLS_SUPPORT_JOB_H
#define SVOCL_TOOLS_SUPPORT_JOB_H

#include "support/input.h"
#include "support/json.h"
#include "support/session.h"

typedef struct build_result {
    svo_tree *tree; /* on the device and downloaded */
    svo_plan_info plan;
    svo_tree_info info;
    svo_build_report report; /* stage times are medians of the builds after the first, if there were several */
    double first_compile_ms; /* compiling in the first build */
    svo_buffer_info *buffers;
    size_t buffer_count;
    uint64_t peak_bytes;
} build_result;

typedef struct job {
    input source;
    session opened;
    build_result result;
} job;

/*
 * Reads the input, opens the session and builds the tree --repeat times by the options, with the svo_need bits of need
 * instead of --need. Begins the progress bar; further_steps: how many the caller adds. Returns the exit code; on
 * failure nothing is left to release.
 */
int job_run(program *state, uint32_t need, unsigned further_steps, job *done);
/* The same for an input that is a finished tree (input_is_tree), on the device then: loaded, not built. */
int job_load(program *state, unsigned further_steps, job *done);
void job_release(job *done);

/* A plan for the mesh by the options, with the svo_need bits of need. Returns the exit code. */
int job_plan(program *state, svo_device *device, const svo_mesh *mesh, uint32_t need, svo_plan **out);

/* The building part of job_run, for a source and a session that are open. Leaves both so on failure. */
int job_build(program *state, uint32_t need, job *done);

/* Adds what ran: frontend and why, share, builder, coverage, context, device, renderer, depth. */
void job_add_what_ran(cJSON *document, const job *done);

#endif
