/* SPDX-License-Identifier: MIT */
/*
 * Measurements of time. A subject of `svocl bench` is a file of its own: it says which scenes it builds at which
 * depths, adds empty tables to a set (result.h), and then rows for one scene at one depth after the other. bench.c
 * opens what they share and goes through them.
 */
#ifndef SVOCL_TOOLS_BENCH_BENCH_H
#define SVOCL_TOOLS_BENCH_BENCH_H

#include "measure/result.h"
#include "support/input.h"
#include "support/session.h"

#define BENCH_LIST_MAX 16
/* In place of a depth: the one that svo_plan_ray_depth finds. */
#define BENCH_DEPTH_FOR_RAYS 255u

typedef struct bench_suite {
    program *state;
    result_set *results; /* the caller's */
    session opened; /* both APIs, where there are both */
    size_t repeats; /* runs after the first */
    bool quick;
    char *scene_text; /* owned: the list of --scenes, cut at its commas */
    const char *scenes[BENCH_LIST_MAX]; /* ends with NULL; empty: each subject's own */
    unsigned depths[BENCH_LIST_MAX]; /* ends with 0 */
} bench_suite;

/* Scenes and depths, each list ending with NULL or 0. */
typedef struct bench_work {
    const char *scenes[BENCH_LIST_MAX]; /* INPUTs, "scene:" left out */
    unsigned depths[BENCH_LIST_MAX];
} bench_work;

typedef struct bench_subject {
    const char *name;
    const char *summary; /* one line, without a full stop */
    bench_work full, quick;
    bool fixed; /* --scenes and --depths do not change them */
    /* Both return the exit code, its line printed. */
    int (*begin)(bench_suite *all); /* adds the tables with their columns */
    int (*run)(bench_suite *all, const input *source, unsigned depth); /* adds rows */
} bench_subject;

/* The subjects in their order; NULL past the last. */
const bench_subject *bench_describe(size_t index);

/*
 * Runs one subject, all of them for "all", or experiments of tools/errors ("errors", "e1" to "e5") into a set, whose
 * machine it fills in, with one progress bar for the whole.
 * The options are those of OPTION_DEVICE and OPTION_MEASURE, and the context. Returns the exit code, its line printed.
 */
int bench_collect(program *state, const char *subject, result_set *results);

/* `svocl bench rays`: one input by the build options, with a JSON document of its own. */
int bench_rays_alone(program *state);

/* The scene's name for tables: the input's without "scene:", or a file's without its folders. */
const char *bench_scene_name(const input *source);

/* A table for repeated runs, without columns: the note begins with how often, "medians and quartiles of 11 runs". */
result_table *bench_add_table(bench_suite *all, const char *id, const char *title, const char *note);

extern const bench_subject bench_voxelize, bench_builders, bench_filter, bench_startup, bench_leaving_out,
    bench_scene_sizes, bench_memory, bench_older_structure, bench_older_memory, bench_peer_embree, bench_peer_openvdb,
    bench_rays;

#endif
