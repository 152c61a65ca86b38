/* SPDX-License-Identifier: MIT */
/* The commands of svocl-lab, one file each. Each returns the exit code; if it is not 0, the command has printed one
   line. */
#ifndef SVOCL_TOOLS_PROGRAM_COMMANDS_H
#define SVOCL_TOOLS_PROGRAM_COMMANDS_H

#include "support/program.h"

int command_verify(program *state);
int command_reference(program *state);
int command_stress(program *state);
int command_bench(program *state);
int command_report(program *state);
void command_bench_print_subjects(void);
int command_tune(program *state);
void command_tune_print_measures(void);

#endif
