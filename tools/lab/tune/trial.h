/* SPDX-License-Identifier: MIT */
/* One run of a setting, with the clock: plan and build, the compact form, the light, and queries. */
#ifndef SVOCL_TOOLS_TUNE_TRIAL_H
#define SVOCL_TOOLS_TUNE_TRIAL_H

#include "tune/sampler.h"

#define TRIAL_SESSIONS_MAX 48u

/* What settings with the same path, front end, share path and builder's API build with. */
typedef struct trial_session {
    int values[4];
    session opened;
    bool works;
    svo_message reason; /* why not */
} trial_session;

typedef struct trials {
    program *state;
    sampler *made;
    trial_session list[TRIAL_SESSIONS_MAX];
    size_t count;
    uint64_t queries; /* that count in the time of a setting */
    bool traces; /* queries are rays through voxels where nothing is gathered */
    svo_gather_result *gathered; /* GATHER_POINTS: of the last run that gathered */
} trials;

typedef struct trial_times {
    double build_ms, form_ms, light_ms; /* light_ms: also of probes */
    double query_us; /* of one */
    double once_ms; /* with those that were measured */
    double total_ms; /* with so many queries */
    double bytes; /* the most on the device at one time */
    double result_bytes; /* of what is left: the tree or its compact form, and light */
} trial_times;

bool trials_open(program *state, sampler *made, uint64_t queries, bool traces, trials *out);
void trials_close(trials *all);

/* Returns false with the reason. */
bool trial_run(trials *all, const tune_setting *setting, trial_times *out, svo_message *reason);

#endif
