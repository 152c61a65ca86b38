/* SPDX-License-Identifier: MIT */
/* One job of the program: its device, input, plan and tree. */
#ifndef SVOCL_TOOLS_SUPPORT_JOB_H
#define SVOCL_TOOLS_SUPPORT_JOB_H

#include <stdbool.h>
#include <stdint.h>

#include "support/cl_calls.h"
#include "support/input.h"
#include "support/json.h"
#include "support/session.h"

typedef struct build_result {
    svo_tree *tree; /* on the device and downloaded */
    svo_plan_info plan;
    svo_tree_info info;
    svo_build_report report; /* stage times are medians of the builds after the first if there were several */
    double first_compile_ms; /* compile time of the first build */
    double wall_ms; /* from the source to the tree, the plan included; a median as stage times are */
    cl_calls calls; /* of the last build, its plan included */
    bool calls_are_counted;
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
 * in place of --need. Begins the progress bar; further_steps: how many steps the caller adds. Returns the exit code; on
 * failure nothing is left to release.
 */
int job_run(program *state, uint32_t need, unsigned further_steps, job *done);
/* The same for an input that is a finished tree (input_is_tree): it is loaded onto the device, not built. */
int job_load(program *state, unsigned further_steps, job *done);
void job_release(job *done);

/* An svo_progress_callback whose user is the program's bar. */
int job_show_progress(void *user, svo_stage stage, double fraction);
/* The options of a plan on the command line, with the svo_need bits of need. */
svo_plan_options job_plan_options(const program *state, uint32_t need);
/* Plans the source by the options, with the svo_need bits of need. Returns the exit code. */
int job_plan(program *state, svo_device *device, const input *source, uint32_t need, svo_plan **out);

/* The first part of job_run: reads the input and opens the session. On failure nothing is left to release. */
int job_open(program *state, uint32_t need, unsigned further_steps, job *done);
/* The building part of job_run, for a source and a session that are already open. On failure both stay open. */
int job_build(program *state, uint32_t need, job *done);

/* Adds what was used: front end and why, share, builder, coverage, context, device, renderer, depth. */
void job_add_what_ran(cJSON *document, const job *done);

#endif
