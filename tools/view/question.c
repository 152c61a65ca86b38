/* SPDX-License-Identifier: MIT */
/* Questions about files. */
#include "view/question.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "view/history.h"
#include "view/scene_save.h"

#define WIDTH_MAX 460.0F

static const char *const names[VIEW_DOCUMENTS] = {"scene", "lights"};

static char *path_of(view_state *state, view_document document)
{
    return document == VIEW_SCENE ? state->scene_path : state->lights_path;
}

/* What is shown, unless only the other one has edits. */
static view_document document_to_save(const view_state *state)
{
    const bool is_scene = state->is_scene || state->mover_count > 0 || state->scene_form != NULL;
    const view_document shown = is_scene ? VIEW_SCENE : VIEW_LIGHTS;
    const view_document other = is_scene ? VIEW_LIGHTS : VIEW_SCENE;
    return !state->unsaved[shown] && state->unsaved[other] ? other : shown;
}

/* ---- asking ---- */

static void ask(view_state *state, view_asking asking, view_document document, const char *path)
{
    view_question *question = &state->question;
    if (path != question->path) {
        (void)snprintf(question->path, sizeof question->path, "%s", path);
    }
    question->asking = asking;
    question->document = document;
    question->is_new = true;
    question->has_failed = false;
}

/* Asks for another name after the log said why. */
static void ask_again(view_state *state, view_document document, const char *path)
{
    ask(state, VIEW_ASKS_FOR_NAME, document, path);
    state->question.has_failed = true;
}

static void end(view_state *state)
{
    state->question.asking = VIEW_ASKS_NOTHING;
    state->question.wish = NULL;
}

/* Beside INPUT, "model-scene.json"; what has no file is named after the scene it is. */
static void ask_for_name(view_state *state, view_document document)
{
    char path[VIEW_PATH_BYTES] = "";
    const char *input = state->input != NULL && strcmp(state->input, "-") != 0 ? state->input : "view";
    const char *begin = strncmp(input, "scene:", 6) == 0 ? input + 6 : input;
    const char *slash = strrchr(begin, '/');
    const char *dot = strrchr(slash != NULL ? slash : begin, '.');
    const size_t length = begin != input ? strcspn(begin, ":/") : dot != NULL ? (size_t)(dot - begin) : strlen(begin);
    if (length < sizeof path - 16) {
        (void)snprintf(path, sizeof path, "%.*s-%s.json", (int)length, begin, names[document]);
    }
    ask(state, VIEW_ASKS_FOR_NAME, document, path);
}

/* ---- files ---- */

static bool is_there(const char *path, struct stat *out)
{
    return stat(path, out) == 0;
}

/* Whether a file is what trees or this session come from. */
static bool is_read(const view_state *state, const char *path)
{
    struct stat target;
    struct stat read;
    if (!is_there(path, &target)) {
        return false;
    }
    for (size_t i = 0; i < state->tree_count; ++i) {
        if (is_there(state->trees[i].path, &read) && read.st_dev == target.st_dev && read.st_ino == target.st_ino) {
            return true;
        }
    }
    return state->scene_form == NULL && state->input != NULL && is_there(state->input, &read) &&
           read.st_dev == target.st_dev && read.st_ino == target.st_ino;
}

/* Goes on with what waited for the file; another document may have edits too. */
static void go_on(view_state *state)
{
    bool *wish = state->question.wish;
    if (wish != NULL && view_is_unsaved(state)) {
        ask(state, VIEW_ASKS_TO_SAVE, document_to_save(state), "");
        return;
    }
    end(state);
    if (wish != NULL) {
        *wish = true;
    }
}

static void write_file(view_state *state, view_document document, const char *path)
{
    char written[VIEW_PATH_BYTES];
    (void)snprintf(written, sizeof written, "%s", path);
    const int error = document == VIEW_SCENE ? scene_save(state, written) : lights_save(state, written);
    if (error != 0) {
        view_log(state, "%s was not saved: %s", written, strerror(error));
        ask_again(state, document, written);
        return;
    }
    (void)snprintf(path_of(state, document), VIEW_PATH_BYTES, "%s", written);
    (void)snprintf(state->own_paths[document], VIEW_PATH_BYTES, "%s", written);
    history_saved(state, document);
    view_log(state, "saved %zu %s in %s", document == VIEW_SCENE ? state->instance_count : state->source_count,
             document == VIEW_SCENE ? "instances" : "lights", written);
    go_on(state);
}

void question_save_as(view_state *state, view_document document, const char *path)
{
    struct stat unused;
    if (path[0] == '\0') {
        ask_for_name(state, document);
    } else if (is_read(state, path)) {
        view_log(state, "%s is what is shown: the %s needs a file of its own", path, names[document]);
        ask_again(state, document, path);
    } else if (is_there(path, &unused) && strcmp(path, state->own_paths[document]) != 0) {
        ask(state, VIEW_ASKS_TO_REPLACE, document, path);
    } else {
        write_file(state, document, path);
    }
}

void question_save(view_state *state)
{
    const view_document document = document_to_save(state);
    question_save_as(state, document, path_of(state, document));
}

/* ---- answers ---- */

bool question_take(view_state *state, const view_event *event)
{
    if (state->question.asking == VIEW_ASKS_NOTHING || event->kind != VIEW_EVENT_KEY || !event->is_down) {
        return false;
    }
    if (event->key == VIEW_KEY_ESCAPE) {
        end(state);
        return true;
    }
    if (event->key == VIEW_KEY_ENTER && state->question.asking == VIEW_ASKS_TO_SAVE) {
        question_save(state);
        return true;
    }
    return false;
}

void question_answer(view_state *state, int button)
{
    const view_question question = state->question;
    const view_asking asking = question.asking;
    const bool is_last = button == (asking == VIEW_ASKS_FOR_NAME ? 1 : 2);
    if (asking == VIEW_ASKS_NOTHING || button < 0) {
        return;
    }
    if (is_last) {
        end(state);
    } else if (asking == VIEW_ASKS_TO_SAVE && button == 0) {
        question_save(state);
    } else if (asking == VIEW_ASKS_TO_SAVE) {
        end(state);
        *question.wish = true;
    } else if (asking == VIEW_ASKS_FOR_NAME) {
        question_save_as(state, question.document, question.path);
    } else if (button == 0) {
        write_file(state, question.document, question.path);
    } else {
        ask(state, VIEW_ASKS_FOR_NAME, question.document, question.path);
    }
}

/* ---- drawing ---- */

static void describe_leaving(ui *toolkit, view_state *state)
{
    static const char *const buttons[] = {"Save", "Discard", "Cancel"};
    const view_document document = document_to_save(state);
    ui_heading(toolkit, "Unsaved edits");
    ui_text(toolkit, "The %s of %s %s edits that no file has.", names[document],
            state->input != NULL ? state->input : "the window", document == VIEW_SCENE ? "has" : "have");
    question_answer(state, ui_buttons(toolkit, buttons, 3));
}

static void describe_name(ui *toolkit, view_state *state)
{
    static const char *const buttons[] = {"Save", "Cancel"};
    view_question *question = &state->question;
    ui_heading(toolkit, question->document == VIEW_SCENE ? "Save the scene as" : "Save the lights as");
    if (question->is_new) {
        ui_focus(toolkit);
    }
    const bool entered = ui_field(toolkit, "File", question->path, sizeof question->path);
    ui_note(toolkit, "%s",
            question->document == VIEW_SCENE ? "svocl view and svocl render show it as INPUT."
                                             : "svocl view and svocl render take it by --lights.");
    if (question->has_failed) {
        ui_text(toolkit, "%s", state->log[(state->log_count - 1) % VIEW_LOG_LINES]);
    }
    const int pressed = ui_buttons(toolkit, buttons, 2);
    question_answer(state, entered ? 0 : pressed);
}

static void describe_replacing(ui *toolkit, view_state *state)
{
    static const char *const buttons[] = {"Replace", "Other name", "Cancel"};
    ui_heading(toolkit, "The file exists");
    ui_text(toolkit, "%s is there already. Replace it?", state->question.path);
    question_answer(state, ui_buttons(toolkit, buttons, 3));
}

void question_describe(ui *toolkit, view_state *state)
{
    const view_asking asking = state->question.asking;
    if (asking == VIEW_ASKS_NOTHING) {
        return;
    }
    const float width = fminf(WIDTH_MAX, (float)state->width);
    const float height = 8 * ui_row_height(toolkit);
    const ui_place place = {floorf(((float)state->width - width) / 2), floorf((float)state->height * 0.3F), width,
                            fminf(height, (float)state->height * 0.7F)};
    const bool was_new = state->question.is_new;
    ui_panel_begin(toolkit, "#question", place);
    if (asking == VIEW_ASKS_TO_SAVE) {
        describe_leaving(toolkit, state);
    } else if (asking == VIEW_ASKS_FOR_NAME) {
        describe_name(toolkit, state);
    } else {
        describe_replacing(toolkit, state);
    }
    (void)ui_panel_end(toolkit);
    state->question.is_new = state->question.is_new && (!was_new || state->question.asking != asking);
}
