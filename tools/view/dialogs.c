/* SPDX-License-Identifier: MIT */
/* Questions about files, and the box that opens one: its paths and folders. "~/" is the home folder, as in shells. */
#include "view/dialogs.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "support/file_register.h"
#include "support/table.h"
#include "view/files.h"
#include "view/history.h"
#include "view/ui.h"

#define WIDTH_MAX   460.0F /* of a box */
#define NOTICE_MAX  420.0F
#define NAMES_MAX   4096 /* of a folder */
#define NAMES_SHOWN 9

/* What a document is called, what names of its files end with, and what its box and the box of its name say. */
typedef struct document_words {
    const char *name, *suffix, *has, *heading, *note;
} document_words;

static const document_words words_of[VIEW_DOCUMENTS] = {
    {"scene", "scene.json", "has", "Save the scene as", "svocl view and svocl render show it as INPUT."},
    {"lights", "lights.json", "have", "Save the lights as", "svocl view and svocl render take it by --lights."},
    {"voxels", "edited.svo", "have", "Save the voxels as", "A tree, .svo, with color and material."}};

static char *path_of(view_state *state, view_document document)
{
    return document == VIEW_SCENE    ? state->scene_path
           : document == VIEW_LIGHTS ? state->lights_path
                                     : state->voxels_path;
}

/* Voxels that no file has come first. Then what is shown, unless only the other one has edits. */
static view_document document_to_save(const view_state *state)
{
    const bool is_scene = state->is_scene || state->mover_count > 0 || state->scene_form != NULL;
    const view_document shown = is_scene ? VIEW_SCENE : VIEW_LIGHTS;
    const view_document other = is_scene ? VIEW_LIGHTS : VIEW_SCENE;
    return state->unsaved[VIEW_VOXELS] ? VIEW_VOXELS : !state->unsaved[shown] && state->unsaved[other] ? other : shown;
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
        (void)snprintf(path, sizeof path, "%.*s-%s", (int)length, begin, words_of[document].suffix);
    }
    ask(state, VIEW_ASKS_FOR_NAME, document, path);
}

/* ---- files that are saved ---- */

static bool is_there(const char *path, struct stat *out)
{
    return stat(path, out) == 0;
}

static bool is_same_file(const char *path, const struct stat *target)
{
    struct stat other;
    return path != NULL && is_there(path, &other) && other.st_dev == target->st_dev && other.st_ino == target->st_ino;
}

/* Whether a file is one that this session has read; what it has saved itself, and the scene that is shown, it may
   replace. */
static bool is_read(const view_state *state, const char *path)
{
    struct stat target;
    if (!is_there(path, &target) || (state->scene_form != NULL && is_same_file(state->input, &target))) {
        return false;
    }
    for (size_t i = 0; i < state->tree_count; ++i) {
        if (is_same_file(state->trees[i].path, &target)) {
            return true;
        }
    }
    return is_same_file(state->input, &target) ||
           (state->files != NULL && file_register_input_at(state->files, path) != NULL);
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

void question_wrote_voxels(view_state *state, const char *failure)
{
    char written[VIEW_PATH_BYTES];
    (void)snprintf(written, sizeof written, "%s", state->question.path);
    state->wants_voxels = false;
    if (failure != NULL) {
        view_log(state, "%s", failure);
        ask_again(state, VIEW_VOXELS, written);
        return;
    }
    (void)snprintf(state->voxels_path, sizeof state->voxels_path, "%s", written);
    (void)snprintf(state->own_paths[VIEW_VOXELS], sizeof state->own_paths[0], "%s", written);
    history_saved(state, VIEW_VOXELS);
    view_log(state, "saved %s voxels in %s", figure_count(state->brush.voxel_count).text, written);
    go_on(state);
}

/* The next frame writes them: that takes a device, and time. */
static void want_voxels(view_state *state, const char *path)
{
    const char *dot = strrchr(path, '.');
    if (dot == NULL || strcmp(dot, ".svo") != 0) {
        view_log(state, "%s: the name of a tree ends with .svo", path);
        ask_again(state, VIEW_VOXELS, path);
        return;
    }
    ask(state, VIEW_ASKS_NOTHING, VIEW_VOXELS, path);
    state->wants_voxels = true;
}

static void write_file(view_state *state, view_document document, const char *path)
{
    char written[VIEW_PATH_BYTES];
    if (document == VIEW_VOXELS) {
        want_voxels(state, path);
        return;
    }
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
    if (document == VIEW_SCENE && state->unsaved[VIEW_VOXELS]) {
        document = VIEW_VOXELS;
        path = state->voxels_path;
    }
    if (path[0] == '\0') {
        ask_for_name(state, document);
    } else if (is_read(state, path) && strcmp(path, state->own_paths[document]) != 0) {
        view_log(state, "%s is what is shown: the %s need%s a file of %s own", path, words_of[document].name,
                 document == VIEW_SCENE ? "s" : "", document == VIEW_SCENE ? "its" : "their");
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
    if (state->question.asking != VIEW_ASKS_TO_SAVE) {
        return false; /* a field has the other keys */
    }
    question_answer(state, event->key == VIEW_KEY_ENTER || event->key == 's' ? 0 : event->key == 'd' ? 1 : -1);
    return true;
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

/* ---- the box of a question ---- */

static void describe_leaving(ui *toolkit, view_state *state)
{
    static const char *const buttons[] = {"Save", "Discard", "Cancel"};
    const view_document document = document_to_save(state);
    ui_heading(toolkit, "Unsaved edits");
    ui_text(toolkit, "The %s of %s %s edits that no file has.", words_of[document].name,
            state->input != NULL ? state->input : "the window", words_of[document].has);
    question_answer(state, ui_buttons(toolkit, buttons, 3));
}

static void describe_name(ui *toolkit, view_state *state)
{
    static const char *const buttons[] = {"Save", "Cancel"};
    view_question *question = &state->question;
    ui_heading(toolkit, words_of[question->document].heading);
    if (question->is_new) {
        ui_focus(toolkit);
    }
    const bool entered = ui_field(toolkit, "File", question->path, sizeof question->path);
    ui_note(toolkit, "%s", words_of[question->document].note);
    if (question->has_failed) {
        ui_text(toolkit, "%s", view_log_line(state, 0));
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

static void describe_question(ui *toolkit, view_state *state)
{
    const view_asking asking = state->question.asking;
    if (asking == VIEW_ASKS_NOTHING) {
        return;
    }
    const float columns = (float)state->width / state->scale;
    const float rows = (float)state->height / state->scale;
    const float width = fminf(WIDTH_MAX, columns);
    const float height = 8 * ui_row_height(toolkit);
    const ui_place place = {floorf((columns - width) / 2), floorf(rows * 0.3F), width, fminf(height, rows * 0.7F)};
    const bool was_new = state->question.is_new;
    ui_raise(toolkit);
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

/* ---- paths ---- */

/* The path for the system. False where it is too long. */
static bool expand(const char *path, char out[VIEW_PATH_BYTES])
{
    const char *home = getenv("HOME");
    const bool is_home = path[0] == '~' && path[1] == '/' && home != NULL;
    const int length = snprintf(out, VIEW_PATH_BYTES, "%s%s", is_home ? home : "", is_home ? path + 1 : path);
    return length >= 0 && length < VIEW_PATH_BYTES;
}

/* Where the last part of a path begins. */
static size_t last_part(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash != NULL ? (size_t)(slash - path) + 1 : 0;
}

static bool is_folder(const char *path)
{
    struct stat entry;
    char expanded[VIEW_PATH_BYTES];
    return expand(path, expanded) && stat(expanded, &entry) == 0 && S_ISDIR(entry.st_mode);
}

/* ---- names in a folder ---- */

static void forget_names(view_open *open)
{
    for (size_t i = 0; i < open->name_count; ++i) {
        free(open->names[i]);
    }
    free(open->names);
    open->names = NULL;
    open->name_count = open->chosen = 0;
}

/* Folders first, then by the alphabet. */
static int compare_names(const void *a, const void *b)
{
    const char *left = *(char *const *)a;
    const char *right = *(char *const *)b;
    const bool left_is_folder = left[strlen(left) - 1] == '/';
    const bool right_is_folder = right[strlen(right) - 1] == '/';
    const int by_case = strcasecmp(left, right);
    return left_is_folder != right_is_folder ? (left_is_folder ? -1 : 1) : by_case != 0 ? by_case : strcmp(left, right);
}

/* Adds a name of a folder, with a slash where it is one itself. False without memory. */
static bool add_name(view_open *open, const char *folder, const char *name)
{
    char path[2 * VIEW_PATH_BYTES];
    struct stat entry;
    const int length = snprintf(path, sizeof path, "%s/%s", folder, name);
    const bool is_sub = length > 0 && (size_t)length < sizeof path && stat(path, &entry) == 0 && S_ISDIR(entry.st_mode);
    const size_t bytes = strlen(name) + 2;
    char *copy = malloc(bytes);
    if (copy == NULL) {
        return false;
    }
    (void)snprintf(copy, bytes, "%s%s", name, is_sub ? "/" : "");
    open->names[open->name_count++] = copy;
    return true;
}

/* Hidden names are for those who type their dot. */
static bool fits(const char *name, const char *begin)
{
    return strncasecmp(name, begin, strlen(begin)) == 0 && (name[0] != '.' || begin[0] == '.') &&
           strcmp(name, ".") != 0 && strcmp(name, "..") != 0;
}

static void read_folder(view_open *open, const char *folder, const char *begin)
{
    DIR *stream = opendir(folder);
    if (stream == NULL) {
        return;
    }
    open->names = malloc(NAMES_MAX * sizeof *open->names);
    bool has_memory = open->names != NULL;
    for (const struct dirent *entry = readdir(stream); entry != NULL && has_memory && open->name_count < NAMES_MAX;
         entry = readdir(stream)) {
        has_memory = !fits(entry->d_name, begin) || add_name(open, folder, entry->d_name);
    }
    (void)closedir(stream);
    if (open->name_count > 0) {
        qsort(open->names, open->name_count, sizeof *open->names, compare_names);
    }
}

/* Lists the names again where the path has changed. */
static void list_folder(view_state *state)
{
    view_open *open = &state->open;
    char folder[VIEW_PATH_BYTES];
    if (open->names != NULL && strcmp(open->listed, open->path) == 0) {
        return;
    }
    forget_names(open);
    memcpy(open->listed, open->path, sizeof open->listed);
    if (expand(open->path, folder)) {
        const char *begin = open->path + last_part(open->path);
        folder[last_part(folder)] = '\0';
        read_folder(open, folder[0] != '\0' ? folder : ".", begin);
    }
    open->chosen = open->name_count;
}

/* ---- a file to open ---- */

void open_dialog_show(view_state *state)
{
    view_open *open = &state->open;
    const char *input = state->input != NULL && strncmp(state->input, "scene:", 6) != 0 ? state->input : "";
    const size_t length = last_part(input);
    forget_names(open);
    open->is_shown = open->takes_focus = true;
    (void)snprintf(open->path, sizeof open->path, "%.*s", length < sizeof open->path ? (int)length : 0, input);
    list_folder(state);
}

void open_dialog_hide(view_state *state)
{
    state->open.is_shown = false;
}

/* Puts a name in place of the path's last part. */
static void take_name(view_open *open, const char *name, size_t length)
{
    const size_t begin = last_part(open->path);
    if (begin + length < sizeof open->path) {
        memcpy(open->path + begin, name, length);
        open->path[begin + length] = '\0';
    }
}

void open_dialog_complete(view_state *state)
{
    view_open *open = &state->open;
    list_folder(state);
    if (open->name_count == 0) {
        return;
    }
    size_t common = strlen(open->names[0]);
    for (size_t i = 1; i < open->name_count; ++i) {
        size_t same = 0;
        while (same < common && open->names[i][same] == open->names[0][same]) {
            ++same;
        }
        common = same;
    }
    if (common >= strlen(open->path + last_part(open->path))) {
        take_name(open, open->names[0], common);
    }
    list_folder(state);
}

void open_dialog_choose(view_state *state, int step)
{
    view_open *open = &state->open;
    list_folder(state);
    const size_t places = open->name_count + 1; /* one of them for none */
    open->chosen = (open->chosen + places + (size_t)(step > 0 ? 1 : places - 1)) % places;
}

void open_dialog_accept(view_state *state)
{
    view_open *open = &state->open;
    char path[VIEW_PATH_BYTES];
    if (open->chosen < open->name_count) {
        take_name(open, open->names[open->chosen], strlen(open->names[open->chosen]));
    }
    const size_t length = strlen(open->path);
    if (length == 0 || is_folder(open->path)) {
        if (length > 0 && length + 1 < sizeof open->path && open->path[length - 1] != '/') {
            memcpy(open->path + length, "/", 2);
        }
        open->takes_focus = true;
    } else if (expand(open->path, path)) {
        view_open_file(state, path);
        open->is_shown = false;
    }
}

/* What a key does in the field. */
static void edit_path(void *user, ui_path_edit kind)
{
    view_state *state = user;
    if (kind == UI_PATH_COMPLETE) {
        open_dialog_complete(state);
    } else {
        open_dialog_choose(state, kind == UI_PATH_NEXT ? 1 : -1);
    }
}

/* The names around the chosen one. */
static void list_names(ui *toolkit, view_state *state)
{
    view_open *open = &state->open;
    const size_t count = open->name_count;
    const size_t middle = open->chosen < count ? open->chosen : 0;
    const size_t last = count > NAMES_SHOWN ? count - NAMES_SHOWN : 0;
    size_t begin = middle > NAMES_SHOWN / 2 ? middle - NAMES_SHOWN / 2 : 0;
    begin = begin < last ? begin : last;
    for (size_t i = begin; i < count && i < begin + NAMES_SHOWN; ++i) {
        ui_push(toolkit, (int)i);
        if (ui_item(toolkit, open->names[i], i == open->chosen)) {
            open->chosen = i;
            open_dialog_accept(state);
            ui_pop(toolkit);
            return;
        }
        ui_pop(toolkit);
    }
    if (count > NAMES_SHOWN) {
        ui_note(toolkit, "%zu of %zu: type more, or use Up and Down", (size_t)NAMES_SHOWN, count);
    } else if (count == 0) {
        ui_note(toolkit, "Nothing here begins so.");
    }
}

static void list_recent(ui *toolkit, view_state *state)
{
    char(*recent)[VIEW_PATH_BYTES] = state->settings.recent;
    ui_heading(toolkit, "Opened before");
    for (int i = 0; i < VIEW_RECENT_MAX && recent[i][0] != '\0'; ++i) {
        ui_push(toolkit, NAMES_MAX + i);
        if (ui_item(toolkit, recent[i], false)) {
            view_open_file(state, recent[i]);
            open_dialog_hide(state);
        }
        ui_tooltip(toolkit, recent[i]);
        ui_pop(toolkit);
    }
}

/* Begins a panel above the others, at most so wide, in a window of this size. */
static void begin_box(ui *toolkit, const char *name, float box_width, float width, float height)
{
    const float room = width - 2 * UI_PADDING;
    const float columns = floorf(box_width < room ? box_width : room);
    const float top = floorf(height * 0.12F);
    ui_raise(toolkit);
    ui_panel_begin(toolkit, name, (ui_place){floorf((width - columns) / 2), top, columns, height - 2 * top});
}

static void describe_open(ui *toolkit, view_state *state, float width, float height)
{
    static const char *const buttons[] = {"Open", "Cancel"};
    view_open *open = &state->open;
    if (!open->is_shown) {
        return;
    }
    const ui_path_keys keys = {edit_path, state};
    list_folder(state);
    begin_box(toolkit, "#open", WIDTH_MAX, width, height);
    ui_heading(toolkit, "Open a mesh, a voxel file, a tree or a scene");
    const bool takes_focus = open->takes_focus;
    open->takes_focus = false;
    const bool entered = ui_path(toolkit, open->path, sizeof open->path, takes_focus, &keys);
    list_names(toolkit, state);
    if (state->settings.recent[0][0] != '\0') {
        list_recent(toolkit, state);
    }
    ui_note(toolkit, "Tab completes, Up and Down choose, Enter opens, Esc closes. A file can also be dropped on the "
                     "window.");
    const int pressed = ui_buttons(toolkit, buttons, 2);
    if (entered || pressed == 0) {
        open_dialog_accept(state);
    } else if (pressed == 1) {
        open_dialog_hide(state);
    }
    (void)ui_panel_end(toolkit);
}

/* ---- all of them ---- */

static void describe_notice(ui *toolkit, view_state *state, float width, float height)
{
    static const char *const buttons[] = {"Close"};
    if (state->notice[0] == '\0') {
        return;
    }
    begin_box(toolkit, "#notice", NOTICE_MAX, width, height);
    ui_text(toolkit, "%s", state->notice);
    if (ui_buttons(toolkit, buttons, 1) == 0) {
        state->notice[0] = '\0';
    }
    (void)ui_panel_end(toolkit);
}

void dialogs_describe(ui *toolkit, view_state *state)
{
    const float width = (float)state->width / state->scale;
    const float height = (float)state->height / state->scale;
    describe_question(toolkit, state);
    describe_open(toolkit, state, width, height);
    describe_notice(toolkit, state, width, height);
}
