/* SPDX-License-Identifier: MIT */
/* Pictures of the window as PNG files. */
#define _POSIX_C_SOURCE 200809L
#include "view/shots.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support/picture.h"

/* Pictures that are saved have numbers up to this. */
#define SHOTS_MAX 9999u

int shots_take(viewer *which, const char *path, unsigned width, unsigned height)
{
    uint8_t *rgba = malloc((size_t)width * height * 4);
    if (rgba == NULL) {
        return program_fail(which->running, PROGRAM_FAILED, "out of memory for %ux%u pixels", width, height);
    }
    const int exit_code = canvas_read(which->canvas, width, height, rgba, &which->why)
                              ? picture_write_as(which->running, path, width, height, rgba)
                              : viewer_fail(which);
    free(rgba);
    return exit_code;
}

/* What pictures of INPUT are called: "a/statue.svo" gives "statue", "scene:knot:2000" gives "knot". */
static void name_shots(const char *path, char name[VIEW_NAME_BYTES])
{
    const char *slash = strrchr(path, '/');
    const char *begin = strncmp(path, "scene:", 6) == 0 ? path + 6 : slash != NULL ? slash + 1 : path;
    (void)snprintf(name, VIEW_NAME_BYTES, "%.*s", (int)strcspn(begin, ".:"), begin);
    if (name[0] == '\0' || name[0] == '-') {
        (void)snprintf(name, VIEW_NAME_BYTES, "svocl");
    }
}

/* Takes a name that no file has, in a folder, by making the file. False with errno where none can be made. */
static bool take_fresh_name(const char *folder, const char *name, char path[VIEW_PATH_BYTES])
{
    for (unsigned i = 1; i <= SHOTS_MAX; ++i) {
        const int length = snprintf(path, VIEW_PATH_BYTES, "%s/%s-%03u.png", folder, name, i);
        if (length < 0 || length >= VIEW_PATH_BYTES) {
            errno = ENAMETOOLONG;
            return false;
        }
        const int file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (file >= 0) {
            (void)close(file);
            return true;
        }
        if (errno != EEXIST) {
            return false;
        }
    }
    return false;
}

/* Saves the frame as it is, in the folder where the program runs, or at home where that cannot be written. */
static void save(viewer *which)
{
    view_state *state = &which->state;
    const char *home = getenv("HOME");
    char folder[VIEW_PATH_BYTES];
    char path[VIEW_PATH_BYTES];
    char name[VIEW_NAME_BYTES];
    svo_message reason = {""};
    name_shots(state->input, name);
    const bool is_here = getcwd(folder, sizeof folder) != NULL && take_fresh_name(folder, name, path);
    if (!is_here && (home == NULL || !take_fresh_name(home, name, path))) {
        view_log(state, "no picture was saved: %s", strerror(errno));
        return;
    }
    which->running->failure = &reason;
    const int exit_code = shots_take(which, path, state->width, state->height);
    which->running->failure = NULL;
    if (exit_code == PROGRAM_DONE) {
        view_log(state, "saved %s", path);
    } else {
        (void)unlink(path);
        view_notice(state, reason.text);
    }
}

void shots_save(viewer *which, view_shot shot)
{
    view_state *state = &which->state;
    if (state->wants_shot == shot && shot != VIEW_SHOT_NONE && state->is_refined) {
        state->wants_shot = VIEW_SHOT_NONE;
        save(which);
    }
}
