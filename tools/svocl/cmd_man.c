/* SPDX-License-Identifier: MIT */
/* svocl man: manual pages from the tables of commands and options, in the macros of man(7). */
#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "scenes/scenes.h"
#include "support/options_parse.h"
#include "support/options_rules.h"
#include "support/output.h"
#include "support/subjects.h"
#include "svocl/commands.h"
#include "svocl/version.h"

#define PATH_BYTES 4096

/* ---- roff ---- */

/* Text of a line. Hyphens are minus signs, so that options can be copied; a control character at the beginning of a
   line is kept from being one. */
static void put_text(FILE *page, const char *text)
{
    if (text[0] == '.' || text[0] == '\'') {
        fputs("\\&", page);
    }
    for (const char *c = text; *c != '\0'; ++c) {
        if (*c == '\\') {
            fputs("\\e", page);
        } else if (*c == '-') {
            fputs("\\-", page);
        } else {
            fputc(*c, page);
        }
    }
}

static void put_upper(FILE *page, const char *text)
{
    for (const char *c = text; *c != '\0'; ++c) {
        const char upper[2] = {(char)toupper((unsigned char)*c), '\0'};
        put_text(page, upper);
    }
}

static void put_section(FILE *page, const char *title)
{
    fprintf(page, ".SH %s\n", title);
}

static void put_paragraph(FILE *page, const char *text)
{
    put_text(page, text);
    fputc('\n', page);
}

/* name: of a command, "lab", or "" for the whole program. */
static void put_head(FILE *page, const char *name, const char *summary)
{
    fputs(".TH SVOCL", page);
    fputs(name[0] != '\0' ? "\\-" : "", page);
    put_upper(page, name);
    fprintf(page, " 1 \"\" \"svocl %s\" \"User Commands\"\n.SH NAME\nsvocl%s", svo_version_string(),
            name[0] != '\0' ? "\\-" : "");
    put_text(page, name);
    fputs(" \\- ", page);
    put_paragraph(page, summary);
}

/* ---- parts of a page ---- */

static void put_option(FILE *page, const rule *option)
{
    fputs(".TP\n", page);
    if (option->letter != '\0') {
        fprintf(page, "\\fB\\-%c\\fR, ", option->letter);
    }
    fputs("\\fB\\-\\-", page);
    put_text(page, option->name);
    fputs("\\fR", page);
    if (option->value_name != NULL) {
        fputs(" \\fI", page);
        put_text(page, option->value_name);
        fputs("\\fR", page);
    }
    fputc('\n', page);
    put_paragraph(page, option->help);
}

static void put_options(FILE *page, const command *which)
{
    put_section(page, "OPTIONS");
    for (size_t i = 0; options_rule(i) != NULL; ++i) {
        if (options_apply(options_rule(i), which)) {
            put_option(page, options_rule(i));
        }
    }
}

static void put_examples(FILE *page, const command *which)
{
    for (size_t i = 0; which->examples[i] != NULL; ++i) {
        fputs(i > 0 ? ".br\n.B svocl " : ".B svocl ", page);
        put_paragraph(page, which->examples[i]);
    }
}

static void put_input(FILE *page)
{
    put_paragraph(
        page, "INPUT is a mesh file (OBJ, PLY, STL, OFF, glTF and others that assimp reads), a voxel file (.vox, .svx, "
              ".binvox, .nvdb, .vdb), a .svo or .svc file where no build is needed, or a scene made on the fly, "
              "scene:NAME[:triangles[:seed]].");
    fputs(".PP\nWith \\fB\\-\\fR, or the path of a pipe, INPUT is read from there. Its first bytes tell the format. "
          "Meshes of several files cannot come through a pipe: glTF with files beside it, and OBJ with materials.\n"
          ".PP\nScenes:",
          page);
    for (size_t i = 0; scene_describe(i) != NULL; ++i) {
        fprintf(page, "%s%s", i == 0 ? " " : ", ", scene_describe(i)->name);
    }
    fputs(".\n", page);
}

static void put_output(FILE *page)
{
    put_paragraph(page,
                  "A file is written whole or not at all: after a failure or a signal nothing is left behind and an "
                  "old file is unchanged. What a symbolic link leads to is written, and the link stays. With - and "
                  "with the path of a device or a pipe the bytes go straight there. What is printed besides then "
                  "goes to standard error.");
}

static void put_subjects(FILE *page)
{
    put_section(page, "SUBJECTS");
    for (size_t i = 0; i < SUBJECT_COUNT; ++i) {
        fputs(".TP\n.B ", page);
        put_paragraph(page, subject_table[i].name);
        put_paragraph(page, subject_table[i].summary);
    }
    fputs(".TP\n.B " BENCH_GPU_NAME "\n" BENCH_GPU_SUMMARY "\n.TP\n.B " BENCH_VERSUS_NAME "\n" BENCH_VERSUS_SUMMARY
          "\n",
          page);
    fputs(".TP\n.BR all \", \" errors\nAll of a group: the measurements of times and bytes; e1 to e5, e7 and e8.\n",
          page);
}

/* compares: of a command that does. */
static void put_exit_status(FILE *page, bool compares)
{
    put_section(page, "EXIT STATUS");
    fputs(compares
              ? ".TP\n.B 0\nEqual.\n.TP\n.B 1\nDifferent.\n.TP\n.B 2\nFailed, or wrong usage; one line on "
                "standard error says why.\n"
              : ".TP\n.B 0\nDone.\n.TP\n.B 1\nFailed; one line on standard error says why.\n.TP\n.B 2\nWrong usage.\n",
          page);
}

/* of_lab: only those that svocl-lab runs. */
static void put_commands(FILE *page, const program *state, bool of_lab)
{
    put_section(page, "COMMANDS");
    for (size_t i = 0; i < state->command_count; ++i) {
        if (!of_lab || state->commands[i].in_lab) {
            fputs(".TP\n", page);
            fputs("\\fBsvocl\\-", page);
            put_text(page, state->commands[i].name);
            fputs("\\fR(1)\n", page);
            put_paragraph(page, state->commands[i].summary);
        }
    }
}

static void put_lab(FILE *page, const program *state)
{
    put_head(page, "lab", "checks and measurements of svocl");
    put_section(page, "SYNOPSIS");
    fputs("\\fBsvocl\\-lab\\fR \\fICOMMAND\\fR [\\fIoptions\\fR]\n", page);
    put_section(page, "DESCRIPTION");
    put_paragraph(page,
                  "What svocl runs for the commands that check and measure, with the same arguments. It looks for "
                  "svocl-lab in its own folder, then along PATH.");
    put_commands(page, state, true);
    put_exit_status(page, false);
    put_section(page, "SEE ALSO");
    fputs(".BR svocl (1)\n", page);
}

static void put_program(FILE *page, const program *state)
{
    put_head(page, "", "exact sparse voxel octrees of triangle meshes");
    put_section(page, "SYNOPSIS");
    fputs("\\fBsvocl\\fR \\fICOMMAND\\fR [\\fIoptions\\fR]\n", page);
    put_section(page, "DESCRIPTION");
    put_paragraph(page,
                  "Builds sparse voxel octrees of triangle meshes with OpenCL, checks, renders and measures them.");
    put_commands(page, state, false);
    put_section(page, "INPUT");
    put_input(page);
    put_section(page, "OUTPUT");
    put_output(page);
    fputs(".PP\n", page);
    put_paragraph(page,
                  "--json prints JSON on standard output; its member version is the version of svocl. A byte of a "
                  "name that is not UTF-8 is shown as \\xNN.");
    put_exit_status(page, false);
    put_section(page, "ENVIRONMENT");
    fputs(".TP\n.B TMPDIR\n", page);
    put_paragraph(page, "The folder for a mesh that comes through a pipe, /tmp by default.");
    fputs(".TP\n.B NO_COLOR\n", page);
    put_paragraph(page, "Headings on a terminal are not bold.");
}

static void put_command(FILE *page, const command *which)
{
    put_head(page, which->name, which->summary);
    put_section(page, "SYNOPSIS");
    fputs("\\fBsvocl ", page);
    put_text(page, which->name);
    fputs("\\fR", page);
    if (which->input_name != NULL) {
        fprintf(page, options_may_lack_input(which) ? " [\\fI%s\\fR]" : " \\fI%s\\fR", which->input_name);
    }
    fputs(" [\\fIoptions\\fR]\n", page);
    put_section(page, "DESCRIPTION");
    put_paragraph(page, which->summary);
    if (which->reads_file) {
        fputs(".PP\n", page);
        put_input(page);
    }
    if ((which->groups & (unsigned)OPTION_OUTPUT) != 0 && which->output != OPTION_OUTPUT_FOLDER) {
        fputs(".PP\n", page);
        put_output(page);
    }
    if ((which->groups & (unsigned)OPTION_BENCH_COMMAND) != 0) {
        put_subjects(page);
    }
    put_options(page, which);
    put_exit_status(page, which->compares);
    put_section(page, "EXAMPLES");
    put_examples(page, which);
    put_section(page, "SEE ALSO");
    fputs(".BR svocl (1)\n", page);
}

/* ---- the command ---- */

/* name: of a command, "lab", or NULL for the whole program. False: no command has it. */
static bool put_page(FILE *page, const program *state, const char *name)
{
    if (name == NULL) {
        put_program(page, state);
        return true;
    }
    if (strcmp(name, "lab") == 0) {
        put_lab(page, state);
        return true;
    }
    for (size_t i = 0; i < state->command_count; ++i) {
        if (strcmp(state->commands[i].name, name) == 0) {
            put_command(page, &state->commands[i]);
            return true;
        }
    }
    return false;
}

static int write_page(program *state, const char *folder, const char *name)
{
    char path[PATH_BYTES];
    output_file file;
    const int length =
        snprintf(path, sizeof path, "%s/svocl%s%s.1", folder, name != NULL ? "-" : "", name != NULL ? name : "");
    if (length < 0 || (size_t)length >= sizeof path) {
        return program_fail(state, PROGRAM_FAILED, "%s: the path is too long", folder);
    }
    const int exit_code = output_open(state, path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    (void)put_page(file.stream, state, name);
    return output_commit(state, &file);
}

static int write_all(program *state, const char *folder)
{
    if (mkdir(folder, 0777) != 0 && errno != EEXIST) {
        return program_fail(state, PROGRAM_FAILED, "%s: %s", folder, strerror(errno));
    }
    int exit_code = write_page(state, folder, NULL);
    if (exit_code == PROGRAM_DONE) {
        exit_code = write_page(state, folder, "lab");
    }
    for (size_t i = 0; i < state->command_count && exit_code == PROGRAM_DONE; ++i) {
        exit_code = write_page(state, folder, state->commands[i].name);
    }
    return exit_code;
}

int command_man(program *state)
{
    const options *given = &state->options;
    if (given->output_path != NULL) {
        return given->input == NULL
                   ? write_all(state, given->output_path)
                   : program_fail(state, PROGRAM_WRONG_USAGE, "-o DIR gets all pages, without COMMAND");
    }
    return put_page(stdout, state, given->input)
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "unknown command '%s', see svocl --help", given->input);
}
