/* SPDX-License-Identifier: MIT */
/*
 * svocl parts: the steps of building in parts, one a command, for engines that run many. Each may be run again, and
 * twice at once: files appear whole or not at all. Exit code 75 says that another try may succeed.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/json.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/parts_hold.h"
#include "support/parts_job.h"
#include "support/table.h"
#include "svocl/commands.h"

#define SUFFIX ".parts"

/* Refuses what an action does not take. */
static int take_only(program *state, uint64_t groups, const char *const names[])
{
    char where[32];
    (void)snprintf(where, sizeof where, "to parts %s", state->options.subject);
    return options_take_only(state, groups, names, where);
}

/* Parts are planned without a front end. */
static int check_plan(program *state)
{
    static const char *const of_builds[] = {"part", "shares", "sample", NULL};
    static const char where[] = "to parts plan";
    if (options_refuse(state, of_builds, where) != PROGRAM_DONE ||
        options_refuse_groups(state, OPTION_METHODS | OPTION_TREE_FORM, where) != PROGRAM_DONE) {
        return PROGRAM_WRONG_USAGE;
    }
    return parts_check_builder(state);
}

/* A device that fails here may work later, or on another machine that sees the folder. */
static int open_device(program *state, session *opened)
{
    const int exit_code = session_open(state, opened);
    return exit_code == PROGRAM_FAILED ? PROGRAM_TRY_AGAIN : exit_code;
}

static int plan(program *state)
{
    session opened = {0};
    svo_parts *parts = NULL;
    parts_mesh mesh;
    if (state->options.output_path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "parts plan needs -o FILE");
    }
    int exit_code = check_plan(state);
    if (exit_code == PROGRAM_DONE) {
        exit_code = output_check(state, state->options.output_path);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    char *folder = parts_folder_of(state->options.output_path);
    if (folder == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory");
    }
    program_begin_progress(state, 2);
    exit_code = open_device(state, &opened);
    if (exit_code == PROGRAM_DONE) {
        exit_code = parts_plan(state, &opened, folder, &mesh);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = parts_open(state, folder, &parts);
    }
    progress_destroy(&state->progress);
    if (exit_code == PROGRAM_DONE && state->options.json) {
        cJSON *document = json_document();
        json_add_text(document, "folder", folder);
        json_add_count(document, "count", svo_parts_count(parts));
        exit_code = json_print(state, document);
    } else if (exit_code == PROGRAM_DONE && !state->options.quiet) {
        printf("%s: %zu parts\n", folder, svo_parts_count(parts));
    }
    svo_parts_close(&parts);
    session_close(&opened);
    free(folder);
    return exit_code;
}

/* The index of the part that --part names. */
static int find_part(program *state, const svo_parts *parts, size_t *index)
{
    const char *asked = state->options.part;
    char *end = NULL;
    const size_t count = svo_parts_count(parts);
    const unsigned long long number = strtoull(asked, &end, 10);
    if (asked[0] >= '0' && asked[0] <= '9' && *end == '\0' && number < count) {
        *index = (size_t)number;
        return PROGRAM_DONE;
    }
    for (*index = 0; *index < count; ++*index) {
        svo_message message;
        svo_parts_entry entry = SVO_PARTS_ENTRY_INIT;
        char name[48];
        if (svo_parts_get(parts, *index, &entry, &message) != SVO_OK) {
            return program_fail_library(state, message.text);
        }
        (void)snprintf(name, sizeof name, "%" PRIu32 "-%" PRIx64, entry.level, entry.code);
        if (strcmp(name, asked) == 0) {
            return PROGRAM_DONE;
        }
    }
    return program_fail(state, PROGRAM_WRONG_USAGE, "--part '%s' is neither below %zu nor the name of a part", asked,
                        count);
}

static int build_parts_of(program *state, const svo_parts *parts)
{
    session opened = {0};
    size_t first = 0;
    size_t end = svo_parts_count(parts);
    int exit_code = PROGRAM_DONE;
    if (state->options.part != NULL) {
        exit_code = find_part(state, parts, &first);
        end = first + 1;
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = open_device(state, &opened);
    }
    for (size_t i = first; i < end && exit_code == PROGRAM_DONE; ++i) {
        exit_code = parts_build(state, &opened, parts, i);
    }
    session_close(&opened);
    return exit_code;
}

/* One part of the array `parts`. */
static void add_entry(cJSON *array, size_t index, const svo_parts_entry *entry, int is_built)
{
    cJSON *object = cJSON_CreateObject();
    char name[48];
    (void)snprintf(name, sizeof name, "%" PRIu32 "-%" PRIx64, entry->level, entry->code);
    json_add_count(object, "index", index);
    json_add_text(object, "part", name);
    json_add_count(object, "triangles", entry->triangles);
    json_add_count(object, "expected_bytes", entry->expected_bytes);
    cJSON_AddBoolToObject(object, "built", is_built);
    cJSON_AddItemToArray(array, object);
}

static int status(program *state, const svo_parts *parts)
{
    cJSON *document = state->options.json ? json_document() : NULL;
    cJSON *array = document != NULL ? cJSON_AddArrayToObject(document, "parts") : NULL;
    size_t built = 0;
    for (size_t i = 0; i < svo_parts_count(parts); ++i) {
        svo_message message;
        svo_parts_entry entry = SVO_PARTS_ENTRY_INIT;
        int is_built = 0;
        if (svo_parts_get(parts, i, &entry, &message) != SVO_OK ||
            svo_parts_is_built(parts, i, &is_built, &message) != SVO_OK) {
            cJSON_Delete(document);
            return program_fail_library(state, message.text);
        }
        built += is_built != 0 ? 1u : 0u;
        if (array != NULL) {
            add_entry(array, i, &entry, is_built);
        } else if (message.text[0] != '\0' && is_built == 0) {
            printf("%s\n", message.text);
        }
    }
    if (document != NULL) {
        json_add_count(document, "built", built);
        return json_print(state, document);
    }
    printf("%zu of %zu parts are built\n", built, svo_parts_count(parts));
    return PROGRAM_DONE;
}

/* The folder's name without its suffix; by malloc. NULL: it has another, or there is no memory. */
static char *path_of_folder(const char *folder)
{
    const size_t length = strlen(folder);
    char *path = output_has_suffix(folder, SUFFIX) ? calloc(length + 1, 1) : NULL;
    if (path != NULL) {
        memcpy(path, folder, length - (sizeof SUFFIX - 1));
    }
    return path;
}

static int stitch_to(program *state, const svo_parts *parts, const char *path)
{
    session opened = {0};
    if (state->options.shares > 0) {
        return parts_finish_shares(state, parts, (unsigned)state->options.shares, path);
    }
    int exit_code = state->options.tree_form != 0 ? open_device(state, &opened) : PROGRAM_DONE;
    if (exit_code == PROGRAM_DONE) {
        exit_code = parts_finish(state, &opened, parts, path);
    }
    session_close(&opened);
    return exit_code;
}

/* Begins shares, or writes the one that --part names. */
static int share(program *state, const svo_parts *parts)
{
    const char *asked = state->options.part;
    const unsigned count = (unsigned)state->options.shares;
    char *end = NULL;
    if (count == 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "parts share needs --shares N");
    }
    if (asked == NULL) {
        return parts_begin_shares(state, parts, count);
    }
    const unsigned long long index = strtoull(asked, &end, 10);
    return asked[0] >= '0' && asked[0] <= '9' && *end == '\0' && index < count
               ? parts_write_share(state, parts, (unsigned)index, count)
               : program_fail(state, PROGRAM_WRONG_USAGE, "--part '%s' is not a number below %u", asked, count);
}

/* -o, or the folder's name without its suffix. */
static int stitch(program *state, const svo_parts *parts)
{
    const options *given = &state->options;
    if (given->tree_form != 0 && given->shares > 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--shares does not apply with --tree-form");
    }
    if (given->tree_form == 0 &&
        options_refuse_groups(state, OPTION_DEVICE, "to parts stitch without --tree-form") != PROGRAM_DONE) {
        return PROGRAM_WRONG_USAGE;
    }
    if (given->output_path != NULL) {
        const int exit_code = output_check(state, given->output_path);
        return exit_code == PROGRAM_DONE ? stitch_to(state, parts, given->output_path) : exit_code;
    }
    if (!output_has_suffix(given->input, SUFFIX)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s does not end in " SUFFIX ": parts stitch needs -o FILE",
                            given->input);
    }
    char *path = path_of_folder(given->input);
    if (path == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory");
    }
    int exit_code = output_check_tree(state, path, "--tree-form");
    if (exit_code == PROGRAM_DONE) {
        exit_code = stitch_to(state, parts, path);
    }
    free(path);
    return exit_code;
}

/* Some of the parts, or all: every byte, and whether masks and levels agree. */
static int check(program *state, const svo_parts *parts)
{
    svo_parts_tree *tree = NULL;
    svo_message message = {""};
    uint64_t checked = 0;
    (void)parts;
    const int exit_code = parts_input_open(state, &tree);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const svo_status status = svo_parts_tree_check(tree, state->options.sample, 0, &checked, &message);
    svo_parts_tree_close(&tree);
    if (status != SVO_OK) {
        return parts_input_fail(state, status, &message);
    }
    printf("%" PRIu64 " parts are whole\n", checked);
    return PROGRAM_DONE;
}

static int remove_folder(program *state)
{
    static const char *const none[] = {NULL};
    svo_message message;
    if (take_only(state, 0, none) != PROGRAM_DONE) {
        return PROGRAM_WRONG_USAGE;
    }
    const svo_status status = svo_parts_remove(state->options.input, &message);
    return status == SVO_OK ? PROGRAM_DONE : parts_fail(state, status, message.text);
}

/* The actions on a folder that is open, and the options that they take. */
static const struct {
    const char *name;
    int (*run)(program *state, const svo_parts *parts);
    uint64_t groups;
    const char *names[3];
    bool holds; /* a lease of the folder, so that nobody plans meanwhile */
} actions[] = {{"build", build_parts_of, OPTION_DEVICE | OPTION_METHODS, {"part", "max-memory", NULL}, true},
               {"status", status, OPTION_JSON, {NULL}, false},
               {"check", check, 0, {"sample", NULL}, false},
               {"share", share, 0, {"shares", "part", NULL}, true},
               {"stitch", stitch, OPTION_OUTPUT | OPTION_TREE_FORM | OPTION_DEVICE, {"shares", NULL}, true}};

/* Opens the folder for an action, and runs it. A folder that is not there is not made. */
static int run_action(program *state, int (*run)(program *state, const svo_parts *parts), bool holds)
{
    svo_parts *parts = NULL;
    parts_holder *holder = NULL;
    const char *folder = state->options.input;
    int exit_code = holds && parts_folder_exists(folder) ? parts_hold(state, folder, &holder) : PROGRAM_DONE;
    if (exit_code == PROGRAM_DONE) {
        exit_code = parts_open(state, folder, &parts);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = run(state, parts);
    }
    svo_parts_close(&parts);
    parts_release(&holder);
    return exit_code;
}

int command_parts(program *state)
{
    const char *action = state->options.subject != NULL ? state->options.subject : "";
    if (state->options.input == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "parts needs an ACTION and an INPUT, see svocl parts --help");
    }
    if (strcmp(action, "plan") == 0) {
        return plan(state);
    }
    if (strcmp(action, "remove") == 0) {
        return remove_folder(state);
    }
    for (size_t i = 0; i < sizeof actions / sizeof actions[0]; ++i) {
        if (strcmp(action, actions[i].name) == 0) {
            const int exit_code = take_only(state, actions[i].groups, actions[i].names);
            return exit_code == PROGRAM_DONE ? run_action(state, actions[i].run, actions[i].holds) : exit_code;
        }
    }
    return program_fail(state, PROGRAM_WRONG_USAGE,
                        "ACTION '%s' is none of plan, build, status, check, share, stitch, remove", action);
}
