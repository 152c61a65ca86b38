/* SPDX-License-Identifier: MIT */
/* Finds the command, reads its options and runs it. */
#include "support/dispatch.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "support/cleanup.h"
#include "support/command_table.h"
#include "support/input.h"
#include "support/options_parse.h"
#include "support/options_rules.h"
#include "support/output.h"
#include "support/suggest.h"
#include "svocl/io.h"
#include "svocl/version.h"

/* NULL: another program runs the command. */
static const dispatch_runner *find_runner(const dispatch_program *self, const command *which)
{
    const dispatch_runner *one = self->runners;
    while (one->name != NULL && strcmp(one->name, which->name) != 0) {
        ++one;
    }
    return one->name != NULL ? one : NULL;
}

static bool is_known(const dispatch_program *self, const command *which)
{
    return self->run_elsewhere != NULL || find_runner(self, which) != NULL;
}

static const command *find_command(const program *state, const dispatch_program *self, const char *name)
{
    for (size_t i = 0; i < state->command_count; ++i) {
        if (strcmp(state->commands[i].name, name) == 0 && is_known(self, &state->commands[i])) {
            return &state->commands[i];
        }
    }
    return NULL;
}

static int fail_unknown(program *state, const dispatch_program *self, const char *name)
{
    if (name[0] == '\0') {
        return program_fail(state, PROGRAM_WRONG_USAGE, "no command given, see %s --help", self->name);
    }
    suggestion near = suggestion_begin(name, strlen(name));
    for (size_t i = 0; i < state->command_count; ++i) {
        if (is_known(self, &state->commands[i])) {
            suggestion_offer(&near, state->commands[i].name);
        }
    }
    return near.best != NULL
               ? program_fail(state, PROGRAM_WRONG_USAGE, "unknown command '%s'%s", name, suggestion_end(&near).text)
               : program_fail(state, PROGRAM_WRONG_USAGE, "unknown command '%s', see %s --help", name, self->name);
}

/* The files that the command line names as inputs. What those refer to is protected when it is read. */
static int protect_inputs(program *state, const command *which)
{
    const options *given = &state->options;
    int exit_code = PROGRAM_DONE;
    if (which->reads_file && given->input != NULL && strncmp(given->input, "scene:", 6) != 0) {
        exit_code = output_protect(state, given->input);
    }
    if (given->second_input != NULL && strncmp(given->second_input, "scene:", 6) != 0 && exit_code == PROGRAM_DONE) {
        exit_code = output_protect(state, given->second_input);
    }
    for (size_t i = 0; options_rule(i) != NULL && exit_code == PROGRAM_DONE; ++i) {
        const char *path = options_input_path(given, i);
        exit_code = path != NULL ? output_protect(state, path) : PROGRAM_DONE;
    }
    return exit_code;
}

static int run_command(program *state, const dispatch_program *self, const command *which, int argument_count,
                       char **arguments)
{
    int exit_code = options_parse(state, which, argument_count, arguments);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (state->options.help) {
        self->print_command_help(which);
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
        exit_code = find_runner(self, which)->run(state);
    }
    piped_free(&state->piped);
    file_register_free(&state->files);
    progress_destroy(&state->progress);
    program_end_warnings(state, exit_code != PROGRAM_DONE || state->options.quiet);
    return exit_code;
}

static int dispatch(program *state, const dispatch_program *self, int argument_count, char **arguments)
{
    const char *name = argument_count > 1 ? arguments[1] : "";
    const bool asks_help = strcmp(name, "help") == 0;
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0 || (asks_help && argument_count == 2)) {
        self->print_help(state);
        return PROGRAM_DONE;
    }
    if (strcmp(name, "--version") == 0) {
        printf("%s %s\n", self->name, svo_version_string());
        return PROGRAM_DONE;
    }
    name = asks_help ? arguments[2] : name;
    const command *which = find_command(state, self, name);
    if (which == NULL) {
        return fail_unknown(state, self, name);
    }
    if (find_runner(self, which) == NULL) {
        state->command = which->name;
        return self->run_elsewhere(state, arguments);
    }
    if (asks_help) {
        self->print_command_help(which);
        return PROGRAM_DONE;
    }
    state->command = which->name;
    state->compares = which->compares;
    return run_command(state, self, which, argument_count - 2, arguments + 2);
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

int dispatch_main(const dispatch_program *self, int argument_count, char **arguments)
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
    exit_code = dispatch(&state, self, argument_count, arguments);
    errno = 0;
    if ((fflush(stdout) != 0 || ferror(stdout)) && exit_code == PROGRAM_DONE) {
        exit_code = program_fail(&state, PROGRAM_FAILED, "standard output: %s",
                                 errno != 0 ? strerror(errno) : "a write failed");
    }
    if (state.compares && exit_code != PROGRAM_DONE) {
        exit_code = exit_code == PROGRAM_DIFFERENT ? PROGRAM_FAILED : PROGRAM_WRONG_USAGE;
    }
    return exit_code;
}
