/* SPDX-License-Identifier: MIT */
/* Runs the built program through the shell in a folder of its own, and checks the outcome. */
#include "run_program.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#ifndef SVOCL_PROGRAM
#error "SVOCL_PROGRAM must be the path of the program"
#endif

outcome last;

void read_text(const char *path, char *text, size_t text_bytes)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t length = fread(text, 1, text_bytes - 1, file);
    text[length] = '\0';
    fclose(file);
}

void write_text(const char *path, const char *text)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    assert_int_equal(fclose(file), 0);
}

void run(const char *line)
{
    char all[2048];
    snprintf(all, sizeof all, "( %s ) >.output 2>.errors", line);
    const int status = system(all);
    last.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    read_text(".output", last.output, sizeof last.output);
    read_text(".errors", last.errors, sizeof last.errors);
}

void run_well(const char *line)
{
    run(line);
    if (last.exit_code != 0) {
        fail_msg("%s: exit code %d: %s", line, last.exit_code, last.errors);
    }
}

void run_badly(const char *line, int exit_code, const char *words)
{
    run(line);
    if (last.exit_code != exit_code) {
        fail_msg("%s: exit code %d instead of %d: %s", line, last.exit_code, exit_code, last.errors);
    }
    const char *newline = strchr(last.errors, '\n');
    if (strncmp(last.errors, "svocl: ", 7) != 0 || newline == NULL || newline[1] != '\0') {
        fail_msg("%s: not one line of the program: '%s'", line, last.errors);
    }
    if (strstr(last.errors, words) == NULL) {
        fail_msg("%s: '%s' is not in '%s'", line, words, last.errors);
    }
    assert_string_equal(last.output, "");
}

cJSON *run_json(const char *line)
{
    run_well(line);
    cJSON *document = cJSON_Parse(last.output);
    if (document == NULL) {
        fail_msg("%s: not JSON: %s", line, last.output);
    }
    return document;
}

void expect_files(const char *const names[], size_t count)
{
    DIR *folder = opendir(".");
    assert_non_null(folder);
    for (const struct dirent *entry = readdir(folder); entry != NULL; entry = readdir(folder)) {
        bool known = entry->d_name[0] == '.';
        for (size_t i = 0; i < count; ++i) {
            known = known || strcmp(entry->d_name, names[i]) == 0;
        }
        if (!known) {
            fail_msg("%s was left behind", entry->d_name);
        }
    }
    closedir(folder);
}

double number_of(const cJSON *document, const char *name)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(document, name);
    if (!cJSON_IsNumber(item)) {
        fail_msg("%s is not a number", name);
    }
    return item->valuedouble;
}

const char *text_of(const cJSON *document, const char *name)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(document, name));
    if (text == NULL) {
        fail_msg("%s is not a text", name);
    }
    return text;
}

const cJSON *array_of(const cJSON *document, const char *name)
{
    const cJSON *array = cJSON_GetObjectItemCaseSensitive(document, name);
    if (!cJSON_IsArray(array)) {
        fail_msg("%s is not an array", name);
    }
    return array;
}

bool method_works(const char *context, const char *kind, const char *name)
{
    run("$SVOCL devices --json");
    cJSON *document = cJSON_Parse(last.output);
    const cJSON *pair = NULL;
    bool found = false;
    cJSON_ArrayForEach(pair, cJSON_GetObjectItem(document, "pairs"))
    {
        const cJSON *method = NULL;
        cJSON_ArrayForEach(method, array_of(pair, kind))
        {
            found = found ||
                    ((context == NULL || strcmp(text_of(pair, "context"), context) == 0) &&
                     strcmp(text_of(method, "name"), name) == 0 && cJSON_IsTrue(cJSON_GetObjectItem(method, "works")));
        }
    }
    cJSON_Delete(document);
    return found;
}

bool cl_works(void)
{
    run("$SVOCL devices --json");
    cJSON *document = cJSON_Parse(last.output);
    const cJSON *platform = NULL;
    bool found = false;
    cJSON_ArrayForEach(platform, cJSON_GetObjectItem(document, "platforms"))
    {
        const cJSON *device = NULL;
        cJSON_ArrayForEach(device, array_of(platform, "devices"))
        {
            const cJSON *method = cJSON_GetArrayItem(cJSON_GetObjectItem(device, "frontends"), 0);
            found = found ||
                    (cJSON_IsTrue(cJSON_GetObjectItem(method, "works")) && strcmp(text_of(method, "name"), "cl") == 0);
        }
    }
    cJSON_Delete(document);
    return found;
}

void need_builds(void)
{
    if (!cl_works()) {
        print_message("skipped: no OpenCL device that works\n");
        skip();
    }
}

bool gl_works(void)
{
    return method_works(NULL, "frontends", "gl-expand");
}

int enter_folder(void **state)
{
    char *folder = strdup("/tmp/svocl_test_program_XXXXXX");
    *state = folder;
    return setenv("SVOCL", SVOCL_PROGRAM, 1) != 0 || setenv("SHIM", SVOCL_SIGNAL_SHIM, 1) != 0 || folder == NULL ||
           mkdtemp(folder) == NULL || chdir(folder) != 0;
}

int leave_folder(void **state)
{
    char line[128];
    snprintf(line, sizeof line, "rm -r '%s'", (const char *)*state);
    free(*state);
    return chdir("/") != 0 || system(line) != 0;
}

int enter_folder_unoptimized(void **state)
{
    return setenv("POCL_EXTRA_BUILD_FLAGS", "-cl-opt-disable", 1) != 0 || enter_folder(state) != 0;
}

int leave_folder_unoptimized(void **state)
{
    const int failed = leave_folder(state);
    return unsetenv("POCL_EXTRA_BUILD_FLAGS") != 0 || failed != 0;
}

const cJSON *table_of(const cJSON *document, const char *id)
{
    const cJSON *table = NULL;
    cJSON_ArrayForEach(table, array_of(document, "tables"))
    {
        if (strcmp(text_of(table, "id"), id) == 0) {
            return table;
        }
    }
    fail_msg("there is no table %s", id);
    return NULL;
}

int column_of(const cJSON *table, const char *name)
{
    int index = 0;
    const cJSON *column = NULL;
    cJSON_ArrayForEach(column, array_of(table, "columns"))
    {
        if (strcmp(text_of(column, "name"), name) == 0) {
            text_of(column, "unit");
            return index;
        }
        ++index;
    }
    fail_msg("%s has no column %s", text_of(table, "id"), name);
    return -1;
}
