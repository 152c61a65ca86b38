/* SPDX-License-Identifier: MIT */
/* Paths and folders. "~/" is the home folder, as in shells. */
#include "view/open_dialog.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "view/panels_figures.h"
#include "view/ui.h"

#define NAMES_MAX   4096 /* of a folder */
#define NAMES_SHOWN 9
#define BOX_WIDTH   460.0F

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

/* ---- names ---- */

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

void open_dialog_list(view_state *state)
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

/* ---- the box ---- */

void open_dialog_show(view_state *state)
{
    view_open *open = &state->open;
    const char *input = state->input != NULL && strncmp(state->input, "scene:", 6) != 0 ? state->input : "";
    const size_t length = last_part(input);
    forget_names(open);
    open->is_shown = open->takes_focus = true;
    (void)snprintf(open->path, sizeof open->path, "%.*s", length < sizeof open->path ? (int)length : 0, input);
    open_dialog_list(state);
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
    open_dialog_list(state);
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
    open_dialog_list(state);
}

void open_dialog_choose(view_state *state, int step)
{
    view_open *open = &state->open;
    open_dialog_list(state);
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

void panels_open(ui *toolkit, view_state *state, float width, float height)
{
    static const char *const buttons[] = {"Open", "Cancel"};
    view_open *open = &state->open;
    if (!open->is_shown) {
        return;
    }
    const ui_path_keys keys = {edit_path, state};
    open_dialog_list(state);
    panels_begin_box(toolkit, "#open", BOX_WIDTH, width, height);
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
