/* SPDX-License-Identifier: MIT */
/*
 * A run of measurements. A subject measures one thing: it adds empty tables to the results (result.h), then rows,
 * either for one scene and depth after the other or all by itself. A suite opens what subjects share and runs those
 * that are asked for. Which subjects there are is the caller's list.
 */
#ifndef SVOCL_TOOLS_MEASURE_SUITE_H
#define SVOCL_TOOLS_MEASURE_SUITE_H

#include "measure/result.h"
#include "support/input.h"
#include "support/session.h"
#include "support/subjects.h"

#define SUITE_LIST_MAX 16
/* In place of a depth: that of svo_plan_info.ray_depth. */
#define SUITE_DEPTH_FOR_RAYS 255u

typedef struct suite {
    program *state;
    result_set *results; /* the caller's */
    session opened; /* both APIs, where there are both */
    size_t repeats; /* runs after the first */
    bool quick;
    char *scene_text; /* owned: the list of --scenes, cut at its commas */
    const char *scenes[SUITE_LIST_MAX]; /* ends with NULL; empty: each subject's own */
    size_t failed_count; /* subjects of a group that failed, each with a reason in the results */
    unsigned depths[SUITE_LIST_MAX]; /* ends with 0 */
} suite;

/* Scenes and depths, each list ending with NULL or 0. */
typedef struct suite_work {
    const char *scenes[SUITE_LIST_MAX]; /* INPUTs; "scene:" may be left out */
    unsigned depths[SUITE_LIST_MAX];
} suite_work;

/* Its functions return the exit code, its line printed. */
typedef struct suite_subject {
    const subject_words *words;
    suite_work full, quick;
    bool fixed; /* --scenes and --depths do not change them */
    bool takes_scenes; /* with run_all: it measures what --scenes says; --depths does not apply */
    bool takes_voxels; /* of an INPUT that is a voxel file, once, at the least depth that holds it */
    int (*begin)(suite *all); /* adds the tables with their columns */
    int (*run)(suite *all, const input *source, unsigned depth); /* adds rows */

    /* In place of begin and run, for a subject that chooses its own scenes. */
    int (*run_all)(suite *all);
    unsigned step_count; /* of the progress bar */
} suite_subject;

/* Whether a name asks for the subject: its own name or its group's. */
bool suite_is_wanted(const suite_subject *subject, const char *wanted);

/*
 * Runs the wanted subjects into a set, whose machine it fills in, with one progress bar for all. The options are those
 * of OPTION_DEVICE and OPTION_MEASURE, and the context. subjects: ends with NULL.
 *
 * Of a group, subjects that fail leave the rows that they have and the reason in the note of a table, and the others go
 * on; failed_count is increased by their number. Returns the exit code, its line printed: not PROGRAM_DONE if a subject
 * that was asked for by its own name failed, or nothing could be measured.
 */
int suite_collect(program *state, const suite_subject *const *subjects, const char *wanted, result_set *results,
                  size_t *failed_count);

/* One mesh of a list of scenes. */
typedef struct suite_input {
    char text[4096]; /* its INPUT */
    input source;
} suite_input;

/* The text of an INPUT in which "scene:" may be left out. Returns the exit code. */
int suite_name(program *state, const char *name, suite_input *out);
/* Opens an INPUT, in which "scene:" may be left out, to be closed by input_close(&out->source). Returns the exit code.
 */
int suite_open(program *state, const char *name, suite_input *out);

/* Reads the value of --depths; the list ends with 0. Returns the exit code. */
int suite_read_depths(program *state, const char *list, unsigned depths[SUITE_LIST_MAX]);

/* The scene's name for tables: the input's without "scene:", or a file's without its folders. */
const char *suite_scene_name(const input *source);

/* A table for repeated runs, without columns: the note begins with how often, "Medians and quartiles of 11 runs". */
result_table *suite_add_table(suite *all, const char *id, const char *title, const char *note);

#endif
