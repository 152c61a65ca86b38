/* SPDX-License-Identifier: MIT */
/* Reading the command line, and the help that describes it. */
#ifndef SVOCL_TOOLS_SUPPORT_OPTIONS_PARSE_H
#define SVOCL_TOOLS_SUPPORT_OPTIONS_PARSE_H

#include "support/program.h"

/* Reads what follows the command's name into state->options, defaults where nothing is given. Returns the exit code. */
int options_parse(program *state, const command *which, int argument_count, char **arguments);

/* Whether OpenGL was asked for: by its front end, a share path or a context. */
bool options_ask_for_gl(const options *given);

/* Prints a command's usage and options to standard output. */
void options_print_help(const command *which);

#endif
