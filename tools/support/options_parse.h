/* SPDX-License-Identifier: MIT */
/* Parses the command line and prints the help. */
#ifndef SVOCL_TOOLS_SUPPORT_OPTIONS_PARSE_H
#define SVOCL_TOOLS_SUPPORT_OPTIONS_PARSE_H

#include "support/program.h"

/* Parses the arguments after the command's name into state->options; what is not given gets its default. Returns the
   exit code. */
int options_parse(program *state, const command *which, int argument_count, char **arguments);

/* Whether a front end, share path, builder or context on the command line requires OpenGL. */
bool options_ask_for_gl(const options *given);

/* Whether usage shows the argument in brackets; what bench may lack has them in its name already. */
bool options_may_lack_input(const command *which);

/* Prints a command's usage and options to standard output. */
void options_print_help(const command *which);

#endif
