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

/* Whether an option is on the command line. */
bool options_is_given(const options *given, const char *name);
/* The same of the option at a place of the table: names may stand there twice. */
bool options_is_given_at(const options *given, size_t place);

/* The file that the option at a place of the table reads, where it is on the command line; else NULL. */
const char *options_input_path(const options *given, size_t place);

/* Fails where one of the options is on the command line: "option --NAME does not apply WHERE". names: ends with NULL.
   Returns the exit code. */
int options_refuse(program *state, const char *const names[], const char *where);
/* The same of all options of some groups. */
int options_refuse_groups(program *state, uint64_t groups, const char *where);
/* Fails where another option is on the command line than those of the groups and the names. */
int options_take_only(program *state, uint64_t groups, const char *const names[], const char *where);

/* Prints a command's usage and options to standard output. */
void options_print_help(const command *which);

#endif
