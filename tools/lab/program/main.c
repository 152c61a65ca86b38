/* SPDX-License-Identifier: MIT */
/* svocl-lab: the commands of svocl that check and measure, with what only they need. svocl runs it for them. */
#include <stdio.h>

#include "program/commands.h"
#include "support/dispatch.h"
#include "support/options_parse.h"
#include "support/table.h"
#include "svocl/version.h"

static void print_help(const program *state)
{
    printf("svocl-lab %s: checks and measurements of svocl, which runs it\n\nusage: svocl-lab COMMAND [options]\n\n",
           svo_version_string());
    table *rows = table_create("ll");
    for (size_t i = 0; i < state->command_count; ++i) {
        if (state->commands[i].in_lab) {
            table_cell(rows, "%s", state->commands[i].name);
            table_cell(rows, "%s", state->commands[i].summary);
        }
    }
    table_print_wrapped(rows, TABLE_HELP_WIDTH);
    puts("\nOther commands, and what an INPUT is: svocl --help");
}

static void print_command_help(const command *which)
{
    options_print_help(which);
    if ((which->groups & (unsigned)OPTION_BENCH_COMMAND) != 0) {
        command_bench_print_subjects();
    }
    if ((which->groups & OPTION_TUNE_COMMAND) != 0) {
        command_tune_print_measures();
    }
}

int main(int argument_count, char **arguments)
{
    static const dispatch_runner runners[] = {
        {"verify", command_verify},
        {"reference", command_reference},
        {"stress", command_stress},
        {"bench", command_bench},
        {"report", command_report},
        {"tune", command_tune},
        {NULL, NULL},
    };
    static const dispatch_program self = {
        .name = "svocl-lab", .runners = runners, .print_help = print_help, .print_command_help = print_command_help};
    return dispatch_main(&self, argument_count, arguments);
}
