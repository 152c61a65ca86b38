/* SPDX-License-Identifier: MIT */
/* What svocl and svocl-lab have in common: both run commands of one table (command_table.h), each its own. */
#ifndef SVOCL_TOOLS_SUPPORT_DISPATCH_H
#define SVOCL_TOOLS_SUPPORT_DISPATCH_H

#include "support/program.h"

typedef struct dispatch_runner {
    const char *name; /* of the command */
    int (*run)(program *state); /* returns the exit code after printing its line */
} dispatch_runner;

typedef struct dispatch_program {
    const char *name;
    const dispatch_runner *runners; /* ends with a NULL name */
    void (*print_help)(const program *state);
    void (*print_command_help)(const command *which);
    /* Runs a command that has no runner here, whose name is in state: all arguments, as main has them. Returns an exit
       code where it cannot. NULL: no other command is known. */
    int (*run_elsewhere)(program *state, char **arguments);
} dispatch_program;

/* The program's main. */
int dispatch_main(const dispatch_program *self, int argument_count, char **arguments);

#endif
