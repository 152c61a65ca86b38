/* SPDX-License-Identifier: MIT */
/*
 * gnuplot reads its script from one temporary file and writes into another, so that neither waits for the other. What
 * comes back is text of its "svg" terminal, line by line.
 */
#include "report/plot.h"

#include <errno.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "report/palette.h"
#include "report/text.h"

#define FAILURE_BYTES 400

extern char **environ;

/* ---- the child ---- */

static int spawn_gnuplot(int script, int picture, int complaints, pid_t *process)
{
    char *const arguments[] = {(char[]){"gnuplot"}, (char[]){"-d"}, (char[]){"-"},
                               NULL}; /* -d: no one's own settings */
    posix_spawn_file_actions_t actions;
    int error = posix_spawn_file_actions_init(&actions);
    if (error != 0) {
        return error;
    }
    error = posix_spawn_file_actions_adddup2(&actions, script, STDIN_FILENO);
    error = error != 0 ? error : posix_spawn_file_actions_adddup2(&actions, picture, STDOUT_FILENO);
    error = error != 0 ? error : posix_spawn_file_actions_adddup2(&actions, complaints, STDERR_FILENO);
    error = error != 0 ? error : posix_spawnp(process, arguments[0], &actions, NULL, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    return error;
}

/* Whether it ended with success. */
static bool wait_for(pid_t process)
{
    int status = 0;
    while (waitpid(process, &status, 0) < 0) {
        if (errno != EINTR) {
            return false;
        }
    }
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

static int fail_by_complaints(program *state, FILE *complaints)
{
    char text[FAILURE_BYTES] = "";
    rewind(complaints);
    const size_t length = fread(text, 1, sizeof text - 1, complaints);
    text[length] = '\0';
    return program_fail(state, PROGRAM_FAILED, "gnuplot failed: %s", text);
}

static int run_gnuplot(program *state, FILE *script, FILE *picture, FILE *complaints)
{
    pid_t process = 0;
    fflush(script);
    rewind(script);
    if (lseek(fileno(script), 0, SEEK_SET) < 0) {
        return program_fail(state, PROGRAM_FAILED, "a temporary file: %s", strerror(errno));
    }
    const int error = spawn_gnuplot(fileno(script), fileno(picture), fileno(complaints), &process);
    if (error == ENOENT) {
        return program_fail(state, PROGRAM_FAILED, "gnuplot draws the charts and is not there: install gnuplot-nox");
    }
    if (error != 0) {
        return program_fail(state, PROGRAM_FAILED, "gnuplot cannot be started: %s", strerror(error));
    }
    return wait_for(process) ? PROGRAM_DONE : fail_by_complaints(state, complaints);
}

/* ---- what it drew ---- */

/* At "rgb(r, g, b)": writes what stands for it, and returns what follows. */
static const char *write_color(const char *text, FILE *page)
{
    unsigned red = 0;
    unsigned green = 0;
    unsigned blue = 0;
    int length = 0;
    if (sscanf(text, "rgb(%u,%u,%u)%n", &red, &green, &blue, &length) != 3 || length == 0) {
        fputc(*text, page);
        return text + 1;
    }
    const uint32_t color = red << 16 | green << 8 | blue;
    for (int i = 0; i < PALETTE_COLOR_COUNT; ++i) {
        if (palette_rgb((palette_color)i) == color) {
            fprintf(page, "var(--method-%d)", i);
            return text + length;
        }
    }
    fputs(color == PLOT_RULE_COLOR ? "var(--rule)" : "currentColor", page);
    return text + length;
}

static bool begins(const char *text, const char *with)
{
    return strncmp(text, with, strlen(with)) == 0;
}

/* One line of the picture with names and colors replaced. */
static void write_line(const char *line, const char *name, FILE *page)
{
    for (const char *text = line; *text != '\0';) {
        if (begins(text, "rgb(")) {
            text = write_color(text, page);
        } else if (begins(text, "xlink:href")) {
            text += strlen("xlink:");
        } else if (begins(text, " color=\"black\"") || begins(text, " color=\"white\"")) {
            text += strlen(" color=\"black\"");
        } else if (begins(text, "fill=\"black\"")) {
            fputs("fill=\"currentColor\"", page);
            text += strlen("fill=\"black\"");
        } else if (begins(text, "gpPt") || begins(text, "gpDot")) {
            fputs(name, page);
            text += strlen("gp");
        } else {
            fputc(*text++, page);
        }
    }
}

/* Everything between the head and the end, without groups that hold nothing and without what no chart here uses. */
static void write_body(FILE *picture, const char *name, FILE *page)
{
    char *line = NULL;
    char *held = NULL; /* an opened group that has nothing in it yet */
    size_t line_bytes = 0;
    bool inside = false;
    bool in_filter = false;
    while (getline(&line, &line_bytes, picture) >= 0) {
        const char *text = line + strspn(line, " \t");
        if (begins(text, "<defs>")) {
            inside = true;
        }
        in_filter = in_filter || begins(text, "<filter");
        if (inside && !in_filter && *text != '\n' && !begins(text, "</svg>")) {
            if (held != NULL && begins(text, "</g>")) {
                free(held);
                held = NULL;
                continue;
            }
            if (held != NULL) {
                write_line(held, name, page);
                free(held);
                held = NULL;
            }
            if (begins(text, "<g fill=\"none\"") && strstr(text, "</g>") == NULL) {
                held = strdup(text);
            } else {
                write_line(text, name, page);
            }
        }
        in_filter = in_filter && !begins(text, "</filter>");
    }
    free(held);
    free(line);
}

/* Three temporary files: script, picture, complaints. */
static bool open_files(FILE *files[3])
{
    bool all = true;
    for (int i = 0; i < 3; ++i) {
        files[i] = tmpfile();
        all = all && files[i] != NULL;
    }
    return all;
}

static void close_files(FILE *files[3])
{
    for (int i = 0; i < 3; ++i) {
        if (files[i] != NULL) {
            fclose(files[i]);
        }
    }
}

int plot_check(program *state)
{
    FILE *files[3];
    const int exit_code = open_files(files)
                              ? run_gnuplot(state, files[0], files[1], files[2])
                              : program_fail(state, PROGRAM_FAILED, "a temporary file: %s", strerror(errno));
    close_files(files);
    return exit_code;
}

int plot_draw(program *state, const char *script, const char *name, const char *label, unsigned width, unsigned height,
              FILE *page)
{
    FILE *files[3];
    int exit_code = PROGRAM_DONE;
    if (!open_files(files)) {
        exit_code = program_fail(state, PROGRAM_FAILED, "a temporary file: %s", strerror(errno));
    } else {
        fprintf(files[0],
                "set terminal svg size %u,%u dynamic noenhanced font 'inherit,12' linewidth 1.2 name '%s'\n%s", width,
                height, name, script);
        exit_code = run_gnuplot(state, files[0], files[1], files[2]);
    }
    if (exit_code == PROGRAM_DONE) {
        rewind(files[1]);
        fprintf(page, "<svg class=\"chart\" id=\"%s\" role=\"img\" viewBox=\"0 0 %u %u\" aria-label=\"", name, width,
                height);
        text_escape(label, page);
        fputs("\">\n<g>\n", page);
        write_body(files[1], name, page);
        fputs("</svg>\n", page);
    }
    close_files(files);
    return exit_code;
}
