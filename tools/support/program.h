/* SPDX-License-Identifier: MIT */
/*
 * State that every command shares: its options, the progress bar, and the one function that reports a failure.
 *
 * Functions that can fail print their own line through program_fail and return the exit code, 0 for success; callers
 * pass it on.
 */
#ifndef SVOCL_TOOLS_SUPPORT_PROGRAM_H
#define SVOCL_TOOLS_SUPPORT_PROGRAM_H

#include <stdbool.h>

#include "support/file_register.h"
#include "support/options.h"
#include "support/piped.h"
#include "support/progress.h"
#include "svocl/device.h"
#include "svocl/status.h"

enum {
    PROGRAM_DONE = 0,
    PROGRAM_FAILED = 1,
    PROGRAM_WRONG_USAGE = 2,
    PROGRAM_DIFFERENT = 3, /* what a command that compares found: the program's exit code is 1, and 2 for failures */
    PROGRAM_TRY_AGAIN = 75 /* as in sysexits.h */
};

#define PROGRAM_WARNINGS_KEPT 16
#define PROGRAM_FAILURE_BYTES 2048

/* How device handles are made, where not by svo_device_create_default. */
typedef struct program_devices {
    svo_status (*create)(void *user, const svo_device_options *options, svo_device **out, svo_message *message);
    void *user;
} program_devices;

typedef struct program {
    const char *command; /* "build", ...; NULL before it is known */
    const command *commands; /* all of them */
    size_t command_count;
    options options;
    progress *progress; /* NULL: no bar */
    const progress_watch *watch; /* who sees the bars besides a terminal; NULL: nobody */
    svo_message *failure; /* where program_fail puts its line in place of standard error; NULL: nowhere */
    piped_input piped; /* INPUT, where it came through a pipe */
    file_register files; /* what this run reads and writes */
    int file_descriptor; /* what -o - writes to, once output_begin was called for it */
    /* Warnings of the library, printed only after success: a failure is one line. */
    char *warnings[PROGRAM_WARNINGS_KEPT];
    unsigned warning_count; /* all warnings, kept or not */
    program_devices devices; /* create NULL: the default */
    bool compares; /* the command does */
    bool reads_mesh; /* so that JSON has the warnings as well */
    bool wants_normal_maps; /* of mesh files */
    char last_failure[PROGRAM_FAILURE_BYTES]; /* the words of the last program_fail */
} program;

/* Removes the bar, prints "svocl: COMMAND: text" as one line to standard error and returns exit_code. */
int program_fail(program *state, int exit_code, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* A library message without its leading function name: "svo_plan_create: words" -> "words". */
const char *program_words(const char *message);

/* program_fail with a library message, shortened by program_words, that names options where the library names its
   arguments. The second with PROGRAM_FAILED. */
int program_fail_status(program *state, int exit_code, const char *message);
int program_fail_library(program *state, const char *message);
/* The same for scenes, whose names and counts come from the command line: an invalid one is wrong usage. */
int program_fail_scene(program *state, svo_status status, const char *message);

/* Removes the bar and begins a new one (see progress.h). */
void program_begin_progress(program *state, unsigned step_count);
/* The same for work of one step. */
void program_begin_step(program *state, const char *what);

/* Whether who watches wants the work to end. */
bool program_is_canceled(const program *state);

/* An svo_log_callback whose user is the program: keeps warnings; --verbose prints everything at once. */
void program_log(void *user, svo_log_level level, const char *text);

/* Prints and releases the kept warnings; discard: only releases them. */
void program_end_warnings(program *state, int discard);

#endif
