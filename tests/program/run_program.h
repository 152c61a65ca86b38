/* SPDX-License-Identifier: MIT */
/*
 * Shared by tests of the whole program. Every test runs the built program through the shell in a new folder of its own;
 * $SVOCL is its path, and $SHIM that of signal_shim.c. Tests that need a device or a GL context probe for it with
 * `svocl devices` and skip visibly if the machine has none. A check that fails ends the test.
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

/* Runs a shell line and stores its outcome in last. */
void run(const char *line);
/* The same; the exit code must be 0. */
void run_well(const char *line);
/* The line must fail with the exit code and print exactly one line on standard error, which contains words. */
void run_badly(const char *line, int exit_code, const char *words);
/* The line must succeed with JSON on standard output, which is returned and released by the caller. */
cJSON *run_json(const char *line);

/* Only the program writes into the folder: any other file was left behind. */
void expect_files(const char *const names[], size_t count);

/* Members that the document must have; the test fails without them. */
double number_of(const cJSON *document, const char *name);
const char *text_of(const cJSON *document, const char *name);
const cJSON *array_of(const cJSON *document, const char *name);

/* Whether a method (a front end or a share path) works on the first pair that uses the context; NULL: on any. */
bool method_works(const char *context, const char *kind, const char *name);
/* Whether a device can build trees with OpenCL alone; whether a context for gl-expand exists. */
bool cl_works(void);
bool gl_works(void);
/* Skips the test where no tree can be built. */
void need_builds(void);

/* Each test gets an empty folder and must leave it empty. */
int enter_folder(void **state);
int leave_folder(void **state);
#define IN_FOLDER(test) cmocka_unit_test_setup_teardown(test, enter_folder, leave_folder)

/* The same, and PoCL compiles without its optimizer: for tests that check what the program does on the host, where
   compiling takes longer than running. */
int enter_folder_unoptimized(void **state);
int leave_folder_unoptimized(void **state);
#define IN_FOLDER_ANY_KERNELS(test) \
    cmocka_unit_test_setup_teardown(test, enter_folder_unoptimized, leave_folder_unoptimized)

/* A table of results by its id, and the index of its column of that name; the test fails without them. */
const cJSON *table_of(const cJSON *document, const char *id);
int column_of(const cJSON *table, const char *name);

#endif
