/* SPDX-License-Identifier: MIT */
/* The svocl program: finds the command and runs it. */
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "scenes/scenes.h"
#include "support/input.h"
#include "support/options_parse.h"
#include "support/options_rules.h"
#include "support/output.h"
#include "support/suggest.h"
#include "support/table.h"
#include "svocl/command_table.h"
#include "svocl/commands.h"
#include "svocl/io.h"
#include "svocl/version.h"

static void print_help(const program *state)
{
    printf("svocl %s: exact sparse voxel octrees of triangle meshes\n\nusage: svocl COMMAND [options]\n\n",
           svo_version_string());
    table *rows = table_create("ll");
    for (size_t i = 0; i < state->command_count; ++i) {
        table_cell(rows, "%s", state->commands[i].name);
        table_cell(rows, "%s", state->commands[i].summary);
    }
    table_print_wrapped(rows, TABLE_HELP_WIDTH);
    fputs("\nINPUT is a mesh file (OBJ, PLY, STL, OFF, glTF, ...), a .svo file where no build\n"
          "is needed, - for standard input, or a generated scene,\n"
          "scene:NAME[:triangles[:seed]], with NAME one of\n ",
          stdout);
    for (size_t i = 0; scene_describe(i) != NULL; ++i) {
        printf("%s%s", i == 0 ? " " : ", ", scene_describe(i)->name);
    }
    puts(".\n\nOptions of a command, with their defaults in parentheses: svocl COMMAND --help\n"
         "Exit code: 0 done, 1 failed, 2 wrong usage");
}

static const command *find_command(const program *state, const char *name)
{
    for (size_t i = 0; i < state->command_count; ++i) {
        if (strcmp(state->commands[i].name, name) == 0) {
            return &state->commands[i];
        }
    }
    return NULL;
}

static int fail_unknown(program *state, const char *name)
{
    suggestion near = suggestion_begin(name, strlen(name));
    for (size_t i = 0; i < state->command_count; ++i) {
        suggestion_offer(&near, state->commands[i].name);
    }
    return program_fail(state, PROGRAM_WRONG_USAGE, "unknown command '%s'%s", name,
                        near.best != NULL ? suggestion_end(&near).text : ", see svocl --help");
}

static void print_command_help(const command *which)
{
    options_print_help(which);
    if (which->run == command_bench) {
        command_bench_print_subjects();
    }
}

/* The files that the command line names as inputs. What those refer to is protected when it is read. */
static int protect_inputs(program *state, const command *which)
{
    const options *given = &state->options;
    int exit_code = PROGRAM_DONE;
    if (which->reads_file && given->input != NULL && strncmp(given->input, "scene:", 6) != 0) {
        exit_code = output_protect(state, given->input);
    }
    for (size_t i = 0; options_rule(i) != NULL && exit_code == PROGRAM_DONE; ++i) {
        const char *path = options_input_path(given, i);
        exit_code = path != NULL ? output_protect(state, path) : PROGRAM_DONE;
    }
    return exit_code;
}

static int run_command(program *state, const command *which, int argument_count, char **arguments)
{
    state->command = which->name;
    int exit_code = options_parse(state, which, argument_count, arguments);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (state->options.help) {
        print_command_help(which);
        return PROGRAM_DONE;
    }
    exit_code = protect_inputs(state, which);
    if (exit_code == PROGRAM_DONE) {
        exit_code = output_begin(state, which);
    }
    if (exit_code == PROGRAM_DONE && which->reads_file) {
        exit_code = input_begin(state);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = which->run(state);
    }
    piped_free(&state->piped);
    file_register_free(&state->files);
    progress_destroy(&state->progress);
    program_end_warnings(state, exit_code != PROGRAM_DONE || state->options.quiet);
    return exit_code;
}

static int dispatch(program *state, int argument_count, char **arguments)
{
    const char *name = argument_count > 1 ? arguments[1] : "";
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0 || (strcmp(name, "help") == 0 && argument_count == 2)) {
        print_help(state);
        return PROGRAM_DONE;
    }
    if (strcmp(name, "--version") == 0) {
        printf("svocl %s\n", svo_version_string());
        return PROGRAM_DONE;
    }
    if (strcmp(name, "help") == 0) {
        const command *which = find_command(state, arguments[2]);
        if (which != NULL) {
            print_command_help(which);
            return PROGRAM_DONE;
        }
        name = arguments[2];
    }
    const command *which = find_command(state, name);
    if (which == NULL) {
        return name[0] == '\0' ? program_fail(state, PROGRAM_WRONG_USAGE, "no command given, see svocl --help")
                               : fail_unknown(state, name);
    }
    return run_command(state, which, argument_count - 2, arguments + 2);
}

/* A file must not get the number of a standard stream that is closed: what is printed would go into it. Reading from
   the stand-in works, and writing to it fails as it should. */
static void fill_standard_streams(void)
{
    int descriptor = 0;
    while (descriptor >= 0 && descriptor <= STDERR_FILENO) {
        descriptor = open("/dev/null", O_RDONLY);
    }
    if (descriptor >= 0) {
        (void)close(descriptor);
    }
}

int main(int argument_count, char **arguments)
{
    int exit_code = PROGRAM_DONE;
    if (svo_import_child_main(argument_count, arguments, &exit_code)) {
        return exit_code;
    }
#ifdef SIGXFSZ
    signal(SIGXFSZ, SIG_IGN); /* beyond a file size limit, write() then fails with a message instead of a signal */
#endif
    fill_standard_streams();
    cleanup_begin();
    program state = {0};
    state.commands = command_table(&state.command_count);
    exit_code = dispatch(&state, argument_count, arguments);
    errno = 0;
    if ((fflush(stdout) != 0 || ferror(stdout)) && exit_code == PROGRAM_DONE) {
        exit_code = program_fail(&state, PROGRAM_FAILED, "standard output: %s",
                                 errno != 0 ? strerror(errno) : "a write failed");
    }
    return exit_code;
}
