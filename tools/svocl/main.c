/* SPDX-License-Identifier: MIT */
/* The svocl program. What checks and measures is another one, svocl-lab, which it becomes for those commands. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "scenes/scenes.h"
#include "support/dispatch.h"
#include "support/options_parse.h"
#include "support/sibling.h"
#include "support/table.h"
#include "svocl/commands.h"
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
    fputs("\nINPUT is a mesh file (OBJ, PLY, STL, OFF, glTF, ...), a voxel file, a .svo or\n"
          ".svc file where no build is needed, - for standard input, or a generated scene,\n"
          "scene:NAME[:triangles[:seed]], with NAME one of\n ",
          stdout);
    for (size_t i = 0; scene_describe(i) != NULL; ++i) {
        printf("%s%s", i == 0 ? " " : ", ", scene_describe(i)->name);
    }
    puts(".\n\nOptions of a command, with their defaults in parentheses: svocl COMMAND --help\n"
         "Exit code: 0 done, 1 failed, 2 wrong usage\n"
         "Exit code of diff: 0 equal, 1 different, 2 failed or wrong usage");
}

static int run_lab(program *state, char **arguments)
{
    sibling_become("svocl-lab", arguments);
    return errno == ENOENT ? program_fail(state, PROGRAM_FAILED, "svocl-lab is not installed (apt install svocl-lab)")
                           : program_fail(state, PROGRAM_FAILED, "svocl-lab: %s", strerror(errno));
}

int main(int argument_count, char **arguments)
{
    static const dispatch_runner runners[] = {
        {"devices", command_devices}, {"scene", command_scene},
        {"build", command_build},     {"parts", command_parts},
        {"info", command_info},       {"hash", command_hash},
        {"diff", command_diff},       {"convert", command_convert},
        {"edit", command_edit},       {"render", command_render},
        {"view", command_view},       {"export-web", command_export_web},
        {"trace", command_trace},     {"gather", command_gather},
        {"sdf", command_sdf},         {"mesh", command_mesh},
        {"kernels", command_kernels}, {"completion", command_completion},
        {"man", command_man},         {NULL, NULL},
    };
    static const dispatch_program self = {.name = "svocl",
                                          .runners = runners,
                                          .print_help = print_help,
                                          .print_command_help = options_print_help,
                                          .run_elsewhere = run_lab};
    return dispatch_main(&self, argument_count, arguments);
}
