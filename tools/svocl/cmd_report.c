/* SPDX-License-Identifier: MIT */
/* svocl report: all results as one HTML page, and the same values as CSV, JSON and Markdown. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "measure/result_json.h"
#include "measure/result_text.h"
#include "report/docs_tables.h"
#include "report/page.h"
#include "report/summary.h"
#include "report/text.h"
#include "support/json.h"
#include "support/output.h"
#include "support/table.h"
#include "svocl/commands.h"
#include "svocl/subjects.h"

#define PATH_BYTES     4096
#define FILE_BYTES_MAX ((size_t)64 << 20)

/* ---- reading or measuring ---- */

/* The text of a file, allocated by malloc; NULL after a failure, which is printed. */
static char *read_text(program *state, const char *path)
{
    FILE *file = fopen(path, "rb");
    char *text = NULL;
    size_t used = 0;
    if (file == NULL) {
        program_fail(state, PROGRAM_FAILED, "%s: %s", path, strerror(errno));
        return NULL;
    }
    for (size_t capacity = 1 << 16; capacity <= FILE_BYTES_MAX; capacity *= 2) {
        char *grown = realloc(text, capacity + 1);
        if (grown == NULL) {
            break;
        }
        text = grown;
        used += fread(text + used, 1, capacity - used, file);
        if (used < capacity) {
            text[used] = '\0';
            const bool good = ferror(file) == 0;
            fclose(file);
            if (!good) {
                program_fail(state, PROGRAM_FAILED, "%s: %s", path, strerror(errno));
                free(text);
                return NULL;
            }
            return text;
        }
    }
    fclose(file);
    free(text);
    program_fail(state, PROGRAM_FAILED, "%s: longer than %zu bytes", path, FILE_BYTES_MAX);
    return NULL;
}

static result_set *read_results(program *state, const char *path)
{
    svo_message message = {""};
    char *text = read_text(state, path);
    if (text == NULL) {
        return NULL;
    }
    result_set *results = result_parse(text, &message);
    free(text);
    if (results == NULL) {
        program_fail(state, PROGRAM_FAILED, "%s: %s", path, message.text);
    }
    return results;
}

static void set_date(result_machine *machine)
{
    const time_t now = time(NULL);
    struct tm broken_down;
    if (gmtime_r(&now, &broken_down) == NULL ||
        strftime(machine->date, sizeof machine->date, "%Y-%m-%d", &broken_down) == 0) {
        machine->date[0] = '\0';
    }
}

static result_set *measure(program *state)
{
    result_set *results = result_create();
    if (results == NULL) {
        program_fail(state, PROGRAM_FAILED, "out of memory");
    } else if (suite_collect(state, subjects, "errors", results) != PROGRAM_DONE ||
               suite_collect(state, subjects, "all", results) != PROGRAM_DONE) {
        result_destroy(&results);
    } else {
        set_date(&results->machine);
    }
    return results;
}

/* ---- writing ---- */

static int make_folder(program *state, const char *folder)
{
    struct stat status;
    if (mkdir(folder, 0777) != 0 && errno != EEXIST) {
        return program_fail(state, PROGRAM_FAILED, "%s: %s", folder, strerror(errno));
    }
    if (stat(folder, &status) != 0 || !S_ISDIR(status.st_mode)) {
        return program_fail(state, PROGRAM_FAILED, "%s: not a folder", folder);
    }
    return PROGRAM_DONE;
}

/* Writes one file of the report. */
typedef int write_part(program *state, const page_content *content, const result_table *shown, FILE *stream);

static int write_csv(program *state, const page_content *content, const result_table *shown, FILE *stream)
{
    (void)state;
    (void)content;
    result_write_csv(shown, stream);
    return PROGRAM_DONE;
}

static int write_page(program *state, const page_content *content, const result_table *shown, FILE *stream)
{
    (void)shown;
    return page_write(state, content, stream);
}

static int write_summary(program *state, const page_content *content, const result_table *shown, FILE *stream)
{
    (void)state;
    (void)shown;
    summary_write(content->results, stream);
    return PROGRAM_DONE;
}

static int write_json(program *state, const page_content *content, const result_table *shown, FILE *stream)
{
    (void)shown;
    cJSON *document = result_to_json(content->results);
    char *text = document != NULL ? cJSON_Print(document) : NULL;
    cJSON_Delete(document);
    if (text == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for the JSON text");
    }
    fputs(text, stream);
    fputc('\n', stream);
    cJSON_free(text);
    return PROGRAM_DONE;
}

/* Writes one file into the folder, completely or not at all. */
static int write_file(program *state, const page_content *content, const result_table *shown, const char *name,
                      write_part *write)
{
    char path[PATH_BYTES];
    output_file file;
    if (snprintf(path, sizeof path, "%s/%s", state->options.output_path, name) >= (int)sizeof path) {
        return program_fail(state, PROGRAM_FAILED, "%s: the path is too long", state->options.output_path);
    }
    int exit_code = output_open(state, path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = write(state, content, shown, file.stream);
    if (exit_code != PROGRAM_DONE) {
        output_abandon(&file);
        return exit_code;
    }
    file.error = ferror(file.stream) != 0 ? EIO : 0;
    return output_commit(state, &file);
}

static int write_tables(program *state, const page_content *content)
{
    for (size_t i = 0; i < content->results->table_count; ++i) {
        char name[128];
        const result_table *shown = content->results->tables[i];
        snprintf(name, sizeof name, "%s.csv", text_make_name(shown->id).text);
        const int exit_code = write_file(state, content, shown, name, write_csv);
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
    }
    return PROGRAM_DONE;
}

static int write_all(program *state, const page_content *content)
{
    static const struct {
        const char *name;
        write_part *write;
    } files[] = {{"results.json", write_json}, {"summary.md", write_summary}, {"index.html", write_page}};
    int exit_code = write_tables(state, content);
    for (size_t i = 0; i < sizeof files / sizeof files[0] && exit_code == PROGRAM_DONE; ++i) {
        exit_code = write_file(state, content, NULL, files[i].name, files[i].write);
    }
    return exit_code;
}

/* ---- the command ---- */

static int make_report(program *state, const result_set *results)
{
    const options *given = &state->options;
    pictures drawn;
    const page_content content = {.results = results,
                                  .drawn = &drawn,
                                  .origin = given->from != NULL ? "file"
                                            : given->quick != 0 ? "quick"
                                                                : "full"};
    program_begin_progress(state, PICTURES_MAX);
    int exit_code = pictures_make(state, given->quick != 0, &drawn);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = write_all(state, &content);
    pictures_free(&drawn);
    if (exit_code == PROGRAM_DONE) {
        progress_hide(state->progress);
        table_line("%s/index.html: %zu tables", given->output_path, results->table_count);
    }
    return exit_code;
}

int command_report(program *state)
{
    const options *given = &state->options;
    if (given->output_path == NULL && given->docs == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o DIR is missing");
    }
    int exit_code = PROGRAM_DONE;
    if (given->output_path != NULL) {
        exit_code = make_folder(state, given->output_path);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    result_set *results = given->from != NULL ? read_results(state, given->from) : measure(state);
    if (results == NULL) {
        return PROGRAM_FAILED;
    }
    if (given->output_path != NULL) {
        exit_code = make_report(state, results);
    }
    if (exit_code == PROGRAM_DONE && given->docs != NULL) {
        exit_code = docs_tables_write(state, results, given->docs);
    }
    result_destroy(&results);
    return exit_code;
}
