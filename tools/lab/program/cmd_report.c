/* SPDX-License-Identifier: MIT */
/* svocl report: all results as one HTML page, and the same values as CSV, JSON and Markdown. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "measure/result_file.h"
#include "measure/result_json.h"
#include "measure/result_text.h"
#include "program/commands.h"
#include "program/subjects.h"
#include "report/docs_tables.h"
#include "report/page.h"
#include "report/summary.h"
#include "report/text.h"
#include "support/json.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/table.h"

#define PATH_BYTES 4096

/* ---- reading or measuring ---- */

static void set_date(result_machine *machine)
{
    const time_t now = time(NULL);
    struct tm broken_down;
    if (gmtime_r(&now, &broken_down) == NULL ||
        strftime(machine->date, sizeof machine->date, "%Y-%m-%d", &broken_down) == 0) {
        machine->date[0] = '\0';
    }
}

/* failed_count: receives how many subjects failed. */
static result_set *measure(program *state, size_t *failed_count)
{
    result_set *results = result_create();
    if (results == NULL) {
        program_fail(state, PROGRAM_FAILED, "out of memory");
    } else if (suite_collect(state, subjects, "errors", results, failed_count) != PROGRAM_DONE ||
               suite_collect(state, subjects, "all", results, failed_count) != PROGRAM_DONE) {
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

/* The results of --from may be those of the same folder, and would be replaced. */
static int check_results(program *state)
{
    char path[PATH_BYTES];
    (void)snprintf(path, sizeof path, "%s/results.json", state->options.output_path);
    return output_check(state, path);
}

/* Writes one file into the folder, completely or not at all, and adds it to files. */
static int write_file(program *state, const page_content *content, const result_table *shown, const char *name,
                      write_part *write, cJSON *files)
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
    const long byte_count = ftell(file.stream);
    exit_code = output_commit(state, &file);
    if (exit_code == PROGRAM_DONE) {
        json_add_file(files, path, byte_count);
    }
    return exit_code;
}

static int write_tables(program *state, const page_content *content, cJSON *files)
{
    for (size_t i = 0; i < content->results->table_count; ++i) {
        char name[128];
        const result_table *shown = content->results->tables[i];
        snprintf(name, sizeof name, "%s.csv", text_make_name(shown->id).text);
        const int exit_code = write_file(state, content, shown, name, write_csv, files);
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
    }
    return PROGRAM_DONE;
}

static int write_all(program *state, const page_content *content, cJSON *files)
{
    static const struct {
        const char *name;
        write_part *write;
    } parts[] = {{"results.json", write_json}, {"summary.md", write_summary}, {"index.html", write_page}};
    int exit_code = write_tables(state, content, files);
    for (size_t i = 0; i < sizeof parts / sizeof parts[0] && exit_code == PROGRAM_DONE; ++i) {
        exit_code = write_file(state, content, NULL, parts[i].name, parts[i].write, files);
    }
    return exit_code;
}

/* ---- the command ---- */

static int make_report(program *state, const result_set *results, cJSON *files)
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
    exit_code = write_all(state, &content, files);
    pictures_free(&drawn);
    if (exit_code == PROGRAM_DONE && !given->json && !given->quiet) {
        progress_hide(state->progress);
        table_line("%s/index.html: %zu tables", given->output_path, results->table_count);
    }
    return exit_code;
}

/* {version, folder, page, source, tables, files[{file, bytes}], documents[{file, bytes}]}; a folder that was not asked
   for is null, and documents are there with --docs. */
static cJSON *describe(const options *given, const result_set *results)
{
    char page[PATH_BYTES];
    cJSON *document = json_document();
    snprintf(page, sizeof page, "%s/index.html", given->output_path != NULL ? given->output_path : "");
    json_add_text(document, "folder", given->output_path);
    json_add_text(document, "page", given->output_path != NULL ? page : NULL);
    json_add_text(document, "source", given->from);
    json_add_count(document, "tables", results->table_count);
    return document;
}

int command_report(program *state)
{
    const options *given = &state->options;
    if (given->output_path == NULL && given->docs == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o DIR is missing");
    }
    static const char *const of_measurements[] = {"scenes", "depths", "repeat", NULL};
    int exit_code = given->from != NULL ? options_refuse(state, of_measurements, "with --from") : PROGRAM_DONE;
    if (exit_code == PROGRAM_DONE && given->output_path != NULL) {
        exit_code = make_folder(state, given->output_path);
    }
    if (exit_code == PROGRAM_DONE && given->output_path != NULL) {
        exit_code = check_results(state);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    size_t failed_count = 0;
    result_set *results = given->from != NULL ? result_file_read(state, given->from) : measure(state, &failed_count);
    if (results == NULL) {
        return PROGRAM_FAILED;
    }
    cJSON *document = describe(given, results);
    cJSON *files = cJSON_AddArrayToObject(document, "files");
    if (given->output_path != NULL) {
        exit_code = make_report(state, results, files);
    }
    if (exit_code == PROGRAM_DONE && given->docs != NULL) {
        exit_code = docs_tables_write(state, results, given->docs, cJSON_AddArrayToObject(document, "documents"));
    }
    result_destroy(&results);
    if (exit_code == PROGRAM_DONE && given->json) {
        exit_code = json_print(state, document);
    } else {
        cJSON_Delete(document);
    }
    return exit_code == PROGRAM_DONE && failed_count > 0
               ? program_fail(state, PROGRAM_FAILED, "%zu subjects failed; their sections have the reasons",
                              failed_count)
               : exit_code;
}
