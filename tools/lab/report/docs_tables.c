/* SPDX-License-Identifier: MIT */
/* Every document is rewritten in memory first; files change only when all of them could be. */
#include "report/docs_tables.h"

#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "measure/result_file.h"
#include "report/summary.h"
#include "support/output.h"

#define PATH_BYTES    4096
#define ID_BYTES      64
#define DOCUMENTS_MAX 64

static const char marker_begin[] = "<!-- svocl:";
static const char marker_table[] = "<!-- svocl:table ";
static const char marker_results[] = "<!-- svocl:results ";
static const char marker_end[] = "<!-- svocl:end -->\n";

typedef struct document {
    char path[PATH_BYTES];
    char *text; /* by malloc; NULL: stays as it is */
    size_t text_bytes;
} document;

/* Where in a document the rewriting is. */
typedef struct cursor {
    program *state;
    const result_set *results;
    result_set *own; /* of svocl:results; NULL before it */
    const char *path;
    size_t line, table_line; /* from 1; table_line is 0 outside tables */
    size_t table_count;
} cursor;

static int fail_at(const cursor *at, size_t line, const char *problem, const char *what)
{
    return program_fail(at->state, PROGRAM_FAILED, "%s:%zu: %s%s", at->path, line, problem, what);
}

/* ---- markers ---- */

/* The word of a line between the marker and its end; false where there is none. */
static bool read_word(const char *line, const char *marker, char word[ID_BYTES])
{
    const size_t prefix = strlen(marker);
    if (strncmp(line, marker, prefix) != 0) {
        return false;
    }
    const size_t length = strcspn(line + prefix, " \n");
    if (length == 0 || length >= ID_BYTES || strcmp(line + prefix + length, " -->\n") != 0) {
        return false;
    }
    memcpy(word, line + prefix, length);
    word[length] = '\0';
    return true;
}

/* Reads the results of the tables below. name: of a file beside the document. */
static int read_results(cursor *at, const char *name)
{
    char path[PATH_BYTES + ID_BYTES];
    const char *slash = strrchr(at->path, '/');
    const int folder_length = slash != NULL ? (int)(slash + 1 - at->path) : 0;
    (void)snprintf(path, sizeof path, "%.*s%s", folder_length, at->path, name);
    result_destroy(&at->own);
    at->own = result_file_read(at->state, path);
    return at->own != NULL ? PROGRAM_DONE : PROGRAM_FAILED;
}

static int write_table(const cursor *at, const char *id, FILE *text)
{
    const result_set *results = at->own != NULL ? at->own : at->results;
    const result_table *whole = at->own != NULL ? result_find(at->own, id) : NULL;
    fputs("\n", text);
    if (strcmp(id, "machine") == 0) {
        summary_write_machine(&results->machine, text);
    } else if (whole != NULL) {
        summary_write_table(whole, text);
    } else {
        const summary_extract *wanted = summary_find(id);
        if (wanted == NULL) {
            return fail_at(at, at->line, "there is no table of the ID ", id);
        }
        if (!summary_write_extract(wanted, results, text)) {
            return fail_at(at, at->line, "the results lack what is needed for the table ", id);
        }
    }
    fputs("\n", text);
    return PROGRAM_DONE;
}

static int rewrite_marker(cursor *at, const char *line, FILE *text)
{
    char id[ID_BYTES];
    if (strcmp(line, marker_end) == 0) {
        if (at->table_line == 0) {
            return fail_at(at, at->line, "svocl:end without a svocl:table before it", "");
        }
        at->table_line = 0;
        fputs(line, text);
        return PROGRAM_DONE;
    }
    if (at->table_line != 0) {
        return fail_at(at, at->table_line, "this table has no svocl:end", "");
    }
    if (read_word(line, marker_results, id)) {
        fputs(line, text);
        return read_results(at, id);
    }
    if (!read_word(line, marker_table, id)) {
        return fail_at(at, at->line, "neither <!-- svocl:table ID --> nor <!-- svocl:end -->", "");
    }
    at->table_line = at->line;
    ++at->table_count;
    fputs(line, text);
    return write_table(at, id, text);
}

static int rewrite_line(cursor *at, const char *line, FILE *text)
{
    ++at->line;
    if (strncmp(line, marker_begin, sizeof marker_begin - 1) == 0) {
        return rewrite_marker(at, line, text);
    }
    if (at->table_line == 0) {
        fputs(line, text);
    }
    return PROGRAM_DONE;
}

static int rewrite_lines(cursor *at, FILE *file, FILE *text)
{
    char *line = NULL;
    size_t line_bytes = 0;
    int exit_code = PROGRAM_DONE;
    while (exit_code == PROGRAM_DONE && getline(&line, &line_bytes, file) >= 0) {
        exit_code = rewrite_line(at, line, text);
    }
    free(line);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (ferror(file) != 0) {
        return program_fail(at->state, PROGRAM_FAILED, "%s: %s", at->path, strerror(errno));
    }
    return at->table_line != 0 ? fail_at(at, at->table_line, "this table has no svocl:end", "") : PROGRAM_DONE;
}

/* ---- documents ---- */

static int rewrite(program *state, const result_set *results, document *one)
{
    cursor at = {.state = state, .results = results, .path = one->path};
    FILE *file = fopen(one->path, "rb");
    if (file == NULL) {
        return program_fail(state, PROGRAM_FAILED, "%s: %s", one->path, strerror(errno));
    }
    FILE *text = open_memstream(&one->text, &one->text_bytes);
    int exit_code =
        text != NULL ? rewrite_lines(&at, file, text) : program_fail(state, PROGRAM_FAILED, "out of memory");
    fclose(file);
    result_destroy(&at.own);
    if (text != NULL && fclose(text) != 0 && exit_code == PROGRAM_DONE) {
        exit_code = program_fail(state, PROGRAM_FAILED, "out of memory");
    }
    if (at.table_count == 0) {
        free(one->text);
        one->text = NULL;
    }
    return exit_code;
}

static int save(program *state, const document *one, cJSON *written)
{
    output_file file;
    if (one->text == NULL) {
        return PROGRAM_DONE;
    }
    const int exit_code = output_open(state, one->path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    output_write(&file, one->text, one->text_bytes);
    const int result = output_commit(state, &file);
    if (result == PROGRAM_DONE) {
        json_add_file(written, one->path, (long)one->text_bytes);
    }
    return result;
}

static int is_markdown(const struct dirent *entry)
{
    const size_t length = strlen(entry->d_name);
    return entry->d_name[0] != '.' && length > 3 && strcmp(entry->d_name + length - 3, ".md") == 0;
}

static int name_document(program *state, document *one, const char *folder, const char *between, const char *name)
{
    if (snprintf(one->path, sizeof one->path, "%s/%s%s", folder, between, name) >= (int)sizeof one->path) {
        return program_fail(state, PROGRAM_FAILED, "%s: the path is too long", folder);
    }
    return PROGRAM_DONE;
}

/* README.md and the chapters in alphabetical order. */
static int list_documents(program *state, const char *folder, document *all, size_t *count)
{
    document chapters = {.path = ""};
    struct dirent **entries = NULL;
    int exit_code = name_document(state, &all[0], folder, "", "README.md");
    if (exit_code == PROGRAM_DONE) {
        exit_code = name_document(state, &chapters, folder, "docs", "");
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const int entry_count = scandir(chapters.path, &entries, is_markdown, alphasort);
    if (entry_count < 0) {
        return program_fail(state, PROGRAM_FAILED, "%s: %s", chapters.path, strerror(errno));
    }
    *count = 1;
    for (int i = 0; i < entry_count; ++i) {
        if (exit_code == PROGRAM_DONE && *count < DOCUMENTS_MAX) {
            exit_code = name_document(state, &all[(*count)++], folder, "docs/", entries[i]->d_name);
        } else if (exit_code == PROGRAM_DONE) {
            exit_code = program_fail(state, PROGRAM_FAILED, "%s: above %d documents", chapters.path, DOCUMENTS_MAX);
        }
        free(entries[i]);
    }
    free(entries);
    return exit_code;
}

int docs_tables_write(program *state, const result_set *results, const char *folder, cJSON *written)
{
    size_t count = 0;
    document *all = calloc(DOCUMENTS_MAX, sizeof *all);
    if (all == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory");
    }
    int exit_code = list_documents(state, folder, all, &count);
    for (size_t i = 0; i < count && exit_code == PROGRAM_DONE; ++i) {
        exit_code = rewrite(state, results, &all[i]);
    }
    for (size_t i = 0; i < count && exit_code == PROGRAM_DONE; ++i) {
        exit_code = save(state, &all[i], written);
    }
    for (size_t i = 0; i < count; ++i) {
        free(all[i].text);
    }
    free(all);
    return exit_code;
}
