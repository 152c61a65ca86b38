/* SPDX-License-Identifier: MIT */
/* Failures, warnings and the progress bar of the running command. */
#include "support/program.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/text.h"

/* A message stays on one line and is UTF-8, whatever file names or drivers put into it. */
static void print_line(const program *state, const char *kind, const char *text)
{
    fprintf(stderr, "svocl: %s%s%s", state->command != NULL ? state->command : "", state->command != NULL ? ": " : "",
            kind);
    while (*text != '\0') {
        const size_t length = utf8_length(text);
        if (length == 0) {
            fprintf(stderr, "\\x%02x", (unsigned)(unsigned char)*text);
        } else if (length == 1 && iscntrl((unsigned char)*text)) {
            fputc(' ', stderr);
        } else {
            fwrite(text, 1, length, stderr);
        }
        text += length > 0 ? length : 1;
    }
    fputc('\n', stderr);
}

int program_fail(program *state, int exit_code, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(state->last_failure, sizeof state->last_failure, format, arguments);
    va_end(arguments);
    progress_destroy(&state->progress);
    if (state->failure != NULL) {
        snprintf(state->failure->text, sizeof state->failure->text, "%.*s", (int)sizeof state->failure->text - 1,
                 state->last_failure);
    } else {
        print_line(state, "", state->last_failure);
    }
    return exit_code;
}

const char *program_words(const char *message)
{
    const size_t name_length = strspn(message, "abcdefghijklmnopqrstuvwxyz0123456789_");
    const bool is_function = strncmp(message, "svo_", 4) == 0 || strncmp(message, "scene_", 6) == 0;
    return is_function && strncmp(message + name_length, ": ", 2) == 0 ? message + name_length + 2 : message;
}

int program_fail_scene(program *state, svo_status status, const char *message)
{
    const int exit_code = status == SVO_INVALID_ARGUMENT ? PROGRAM_WRONG_USAGE : PROGRAM_FAILED;
    return program_fail(state, exit_code, "%s", program_words(message));
}

/* What the library calls an argument, and what the command line does. */
static const char *const arguments[][2] = {{"options.payload_level", "--payload-level"},
                                           {"max_device_bytes", "--max-memory"},
                                           {"max_bytes", "--max-memory"},
                                           {"svo_parts_create", "svocl build --max-memory"},
                                           {"memory_limit_bytes", "--import-memory"},
                                           {"options.memory_bytes", "--max-memory"},
                                           {"memory_bytes", "--max-memory"},
                                           {"voxels_max", "--max-voxels"},
                                           {"voxel_edge", "--voxel-size"}};

/* The words with options in place of arguments. */
static svo_message with_options(const char *words)
{
    svo_message named = {""};
    size_t used = 0;
    while (*words != '\0' && used + 1 < sizeof named.text) {
        size_t i = 0;
        const size_t count = sizeof arguments / sizeof arguments[0];
        while (i < count && strncmp(words, arguments[i][0], strlen(arguments[i][0])) != 0) {
            ++i;
        }
        const char *from = i < count ? arguments[i][1] : words;
        const size_t length = i < count ? strlen(from) : 1;
        const size_t left = sizeof named.text - 1 - used;
        memcpy(named.text + used, from, length < left ? length : left);
        used += length < left ? length : left;
        words += i < count ? strlen(arguments[i][0]) : 1;
    }
    return named;
}

int program_fail_status(program *state, int exit_code, const char *message)
{
    return program_fail(state, exit_code, "%s", with_options(program_words(message)).text);
}

int program_fail_library(program *state, const char *message)
{
    return program_fail_status(state, PROGRAM_FAILED, message);
}

void program_begin_progress(program *state, unsigned step_count)
{
    progress_destroy(&state->progress);
    state->progress = progress_create(state->command, step_count, !state->options.quiet, state->watch);
}

void program_begin_step(program *state, const char *what)
{
    program_begin_progress(state, 1);
    progress_step(state->progress, what);
}

bool program_is_canceled(const program *state)
{
    return state->watch != NULL && state->watch->stops(state->watch->user);
}

void program_log(void *user, svo_log_level level, const char *text)
{
    program *state = user;
    if (state->options.verbose) {
        progress_hide(state->progress);
        fprintf(stderr, "%s\n", text);
    }
    if (level == SVO_LOG_WARNING) {
        if (state->warning_count < PROGRAM_WARNINGS_KEPT) {
            state->warnings[state->warning_count] = strdup(program_words(text));
        }
        ++state->warning_count;
    }
}

void program_end_warnings(program *state, int discard)
{
    unsigned i = 0;
    for (; i < state->warning_count && i < PROGRAM_WARNINGS_KEPT; ++i) {
        if (!discard && !state->options.verbose && state->warnings[i] != NULL) {
            print_line(state, "warning: ", state->warnings[i]);
        }
        free(state->warnings[i]);
        state->warnings[i] = NULL;
    }
    if (!discard && !state->options.verbose && state->warning_count > i) {
        char text[64];
        snprintf(text, sizeof text, "%u more", state->warning_count - i);
        print_line(state, "warning: ", text);
    }
    state->warning_count = 0;
}
