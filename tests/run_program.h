/* SPDX-License-Identifier: MIT */
/*
 * What tests of the whole program share: every test runs the built program through the shell in a fresh folder of its
 * own; $SVOCL is its path. What needs a device or a GL context is probed with `svocl devices` and skipped, visibly,
 * where the machine has none. A check that fails ends the test.
 */
#ifndef SVOCL_TESTS_RUN_PROGRAM_H
#define SVOCL_TESTS_RUN_PROGRAM_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <cjson/cJSON.h>
#include <stdbool.h>

#define TEXT_BYTES 262144

typedef struct outcome {
    int exit_code; /* -1: ended by a signal */
    char output[TEXT_BYTES];
    char errors[4096];
} outcome;

extern outcome last; /* of the last run */

void read_text(const char *path, char *text, size_t text_bytes);
void write_text(const char *path, const char *text);

/* Runs a shell line and keeps what it did in last. */
void run(const char *line);
/* The same of a line that must end with exit code 0. */
void run_well(const char *line);
/* The line must fail with the exit code, nothing but one line on standard error, and words in that line. */
void run_badly(const char *line, int exit_code, const char *words);
/* A line that must end well with JSON on standard output, which the caller releases. */
cJSON *run_json(const char *line);

/* The program is the only one that writes here: every other file is one that was left behind. */
void expect_files(const char *const names[], size_t count);

/* What the document must have by that name. */
double number_of(const cJSON *document, const char *name);
const char *text_of(const cJSON *document, const char *name);
const cJSON *array_of(const cJSON *document, const char *name);

/* Whether a way (a front end or a share path) works on the first pair that uses the context; NULL: on any pair. */
bool method_works(const char *context, const char *kind, const char *name);
/* Whether there is a device on which OpenCL alone makes trees; whether there is a context for gl-expand. */
bool cl_works(void);
bool gl_works(void);
/* Skips the test where no tree can be made. */
void need_builds(void);

/* Each test gets an empty folder and leaves it behind empty. */
int enter_folder(void **state);
int leave_folder(void **state);
#define IN_FOLDER(test) cmocka_unit_test_setup_teardown(test, enter_folder, leave_folder)

/* A table of measurements by its id, and the index of its column of that name; the test fails without them. */
const cJSON *table_of(const cJSON *document, const char *id);
int column_of(const cJSON *table, const char *name);

#endif
